//! One scene, all contenders: build, check, then time.

use std::cell::LazyCell;
use std::ops::Deref;
use std::panic::{AssertUnwindSafe, catch_unwind};

use arboleda::{AnyIndex, BuildError, IndexKind, Options, Scene};

use crate::OwnedIndex;
use crate::bench::ring::{Answers, Build, Mode, answer, time, time_builds};
use crate::bench::spread::Spread;
use crate::bench::workload::{Workload, leak_rays};
use crate::contenders::agreement::Disagreements;
use crate::contenders::contender::{Built, Contender, Peer, Setting};
use crate::contenders::libraries::mesh::Mesh;
use crate::contenders::ours;
use crate::contenders::{PEERS, PeerError, best_setting};
use crate::scene::{Model, closed};

/// How much is compared.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonOptions<'o> {
    /// Rays in each mode.
    pub ray_count: usize,
    /// Times around.
    pub rounds: usize,
    /// Rays of the leak test, for a scene that is one closed mesh around its middle; others have none.
    pub leak_ray_count: usize,
    /// Of the photons.
    pub seed: u64,
    /// Which libraries take part.
    pub peers: &'o [Peer],
    /// Which of our indices take part.
    pub kinds: &'o [IndexKind],
}

impl Default for ComparisonOptions<'_> {
    fn default() -> Self {
        Self {
            ray_count: 500_000,
            rounds: 5,
            leak_ray_count: 1_000_000,
            seed: 1,
            peers: PEERS,
            kinds: USUAL_KINDS,
        }
    }
}

/// Those of ours made for speed, a binary hierarchy as the others have, and the paper's.
pub const USUAL_KINDS: &[IndexKind] =
    &[IndexKind::WideBvh, IndexKind::WideBvhHierarchy, IndexKind::Bvh, IndexKind::OctreeHierarchy];

/// One contender in one mode.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The scene's name.
    pub scene: String,
    /// The library's or our index's name.
    pub contender: &'static str,
    /// The setting that was the fastest; "default" for ours.
    pub setting: &'static str,
    /// Whether it is an index of `arboleda`.
    pub is_ours: bool,
    /// What was asked.
    pub mode: Mode,
    /// Triangles of the scene.
    pub triangle_count: usize,
    /// The build, on one thread.
    pub build_seconds: f64,
    /// What it holds, where that is known.
    pub bytes: Option<usize>,
    /// Million rays a second.
    pub speed: Spread,
    /// Answers that are not `arboleda`'s.
    pub disagreements: Disagreements,
    /// Leak-test rays that hit nothing, if there was such a test.
    pub leaks: Option<usize>,
}

/// What came of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// The scene's name.
    pub scene: String,
    /// How many it has.
    pub triangle_count: usize,
    /// Contender by contender, in the order in which they were built.
    pub rows: Vec<Row>,
    /// Those that could not take part, and why.
    pub absent: Vec<(&'static str, PeerError)>,
}

/// Whose answers are the right ones, where it takes part: the plainest, without vector instructions.
/// Otherwise the first of ours that does.
const JUDGE: IndexKind = IndexKind::Bvh;

/// Rays by which the best setting is chosen.
const SAMPLE: usize = 100_000;

/// A contender and what was found out before the timing.
struct Entrant<'a> {
    name: &'static str,
    is_ours: bool,
    setting: &'static str,
    contender: Box<dyn Contender + 'a>,
    build: Build<'a>,
    disagreements: [Disagreements; 3],
    leaks: [Option<usize>; 3],
}

impl<'a> Entrant<'a> {
    /// Ours have no settings.
    fn new(
        name: &'static str,
        setting: Option<&'static Setting>,
        contender: Box<dyn Contender + 'a>,
        build: Build<'a>,
    ) -> Self {
        Self {
            name,
            is_ours: setting.is_none(),
            setting: setting.map_or("default", |setting| setting.name),
            contender,
            build,
            disagreements: Default::default(),
            leaks: [None; 3],
        }
    }
}

/// How often `progress` is called: for each contender twice, and for each round.
pub fn steps(options: &ComparisonOptions<'_>) -> u64 {
    (2 * (options.peers.len() + options.kinds.len()) + options.rounds) as u64
}

/// Compares everything on one scene.
///
/// # Errors
/// As [`OwnedIndex::build`]: the scene cannot be indexed. A library that fails is only absent.
pub fn compare(
    model: &Model,
    options: &ComparisonOptions<'_>,
    progress: &mut dyn FnMut(),
) -> Result<Comparison, BuildError> {
    let leaving = leak_workload(model, options);

    // 1. Build ours and, each by its best setting, the others.
    let scene = model.scene();
    let triangle_count = model.triangles.len();
    // Only where it is asked for.
    let mesh = LazyCell::new(|| Mesh::welded(&model.triangles));
    let build = |kind: IndexKind| {
        let beside = ours::is_beside(kind);
        let scene = if beside { Scene::of(mesh.kept()).beside() } else { scene };
        OwnedIndex::build(kind, &scene, &Options::default())
    };
    let mut owned = Vec::new();
    for &kind in options.kinds {
        owned.push(build(kind)?);
        progress();
    }
    let takes_part = owned.iter().find(|index| index.kind() == JUDGE).or(owned.first());
    let apart;
    let judge = if let Some(judge) = takes_part {
        judge
    } else {
        apart = OwnedIndex::build(JUDGE, &scene, &Options::default())?;
        &apart
    };
    let judge = read(judge, &mesh);
    let workload = Workload::new(model, judge.as_ray_index(), options.ray_count, options.seed);
    let mut entrants = Vec::new();
    let mut absent = Vec::new();
    let sample = &workload.rays[..workload.rays.len().min(SAMPLE)];
    for peer in options.peers {
        match guarded(peer.name, || best_setting::best(peer, &model.triangles, sample)) {
            Ok((setting, built)) => {
                let Built { contender, build_seconds: seconds } = built;
                let again = || {
                    let built = guarded(peer.name, || setting.build(&model.triangles));
                    built.map_or(f64::INFINITY, |built| built.build_seconds)
                };
                let build = Build { seconds, again: Box::new(again) };
                entrants.push(Entrant::new(peer.name, Some(setting), contender, build));
            }
            Err(error) => absent.push((peer.name, error)),
        }
        progress();
    }
    for index in &owned {
        let again = || build(index.kind()).map_or(f64::INFINITY, |index| index.build_seconds());
        let build = Build { seconds: index.build_seconds(), again: Box::new(again) };
        let contender = ours::contender(read(index, &mesh));
        entrants.push(Entrant::new(ours::name(index.kind()), None, contender, build));
    }

    // 2. Check the answers, and look for leaks.
    let mut answers = Answers::room(workload.rays.len().max(leaving.rays.len()));
    entrants.retain_mut(|entrant| {
        let Entrant { contender, disagreements, leaks, .. } = entrant;
        let checked = guarded(entrant.name, || {
            for (at, mode) in Mode::ALL.into_iter().enumerate() {
                (disagreements[at], leaks[at]) =
                    check(contender.as_ref(), mode, &workload, &leaving, &mut answers);
            }
            Ok(())
        });
        progress();
        absent.extend(checked.err().map(|error| (entrant.name, error)));
        absent.last().is_none_or(|(name, _)| *name != entrant.name)
    });

    // 3. Time.
    let mut builds: Vec<_> = entrants.iter_mut().map(|entrant| &mut entrant.build).collect();
    time_builds(&mut builds, triangle_count);
    let contenders: Vec<&dyn Contender> =
        entrants.iter().map(|entrant| entrant.contender.as_ref()).collect();
    let speeds = time(&contenders, &workload, options.rounds, progress);
    let mut rows = Vec::new();
    for (entrant, speeds) in entrants.iter().zip(speeds) {
        for (at, (mode, speed)) in Mode::ALL.into_iter().zip(speeds).enumerate() {
            rows.extend(speed.map(|speed| Row {
                scene: model.name.clone(),
                contender: entrant.name,
                setting: entrant.setting,
                is_ours: entrant.is_ours,
                mode,
                triangle_count,
                build_seconds: entrant.build.seconds,
                bytes: entrant.contender.bytes(),
                speed,
                disagreements: entrant.disagreements[at],
                leaks: entrant.leaks[at],
            }));
        }
    }
    Ok(Comparison { scene: model.name.clone(), triangle_count, rows, absent })
}

/// An index of ours, beside the mesh if it was built so.
fn read<'a>(index: &'a OwnedIndex, mesh: &'a impl Deref<Target = Mesh>) -> AnyIndex<'a> {
    if ours::is_beside(index.kind()) { index.index_beside(mesh.kept()) } else { index.index() }
}

/// A library that panics is absent.
fn guarded<T>(
    library: &'static str,
    work: impl FnOnce() -> Result<T, PeerError>,
) -> Result<T, PeerError> {
    // What a panic leaves half done is the library's index, which is dropped, and answers, which are
    // overwritten.
    catch_unwind(AssertUnwindSafe(work)).unwrap_or(Err(PeerError::Panicked { library }))
}

/// Rays that must all hit; none if the scene is not closed. The answers are not looked at.
fn leak_workload(model: &Model, options: &ComparisonOptions<'_>) -> Workload {
    let inside = if options.leak_ray_count == 0 { None } else { closed::inside(&model.triangles) };
    let rays = inside.map_or_else(Vec::new, |inside| {
        leak_rays(&model.triangles, inside, options.leak_ray_count, options.seed)
    });
    Workload { shadow_rays: rays.clone(), rays, hits: Vec::new(), occluded: Vec::new() }
}

fn check(
    contender: &dyn Contender,
    mode: Mode,
    workload: &Workload,
    leaving: &Workload,
    answers: &mut Answers,
) -> (Disagreements, Option<usize>) {
    if !answer(contender, mode, workload, answers) {
        return (Disagreements::default(), None);
    }
    let disagreements = match mode {
        Mode::Occluded => Disagreements::of_occlusion(&workload.occluded, &answers.occluded),
        Mode::Single | Mode::Batch => Disagreements::of_hits(&workload.hits, &answers.hits),
    };
    if leaving.rays.is_empty() {
        return (disagreements, None);
    }
    answer(contender, mode, leaving, answers);
    let count = leaving.rays.len();
    let leaks = match mode {
        Mode::Occluded => answers.occluded[..count].iter().filter(|blocked| !**blocked).count(),
        Mode::Single | Mode::Batch => {
            answers.hits[..count].iter().filter(|hit| hit.is_none()).count()
        }
    };
    (disagreements, Some(leaks))
}
