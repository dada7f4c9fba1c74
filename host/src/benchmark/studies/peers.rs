//! One scene, all contenders: build, check, then time.

use std::cell::LazyCell;
use std::ops::Deref;
use std::panic::{AssertUnwindSafe, catch_unwind};

use arboleda::{AnyIndex, BuildError, IndexKind, Options, Scene};

use crate::TimedIndex;
use crate::benchmark::contenders::agreement::Disagreements;
use crate::benchmark::contenders::best_setting::best_setting;
use crate::benchmark::contenders::contender::{Answers, Contender, Mode};
use crate::benchmark::contenders::mesh::WeldedMesh;
use crate::benchmark::contenders::{PEERS, Peer, PeerError, Setting, ours};
use crate::benchmark::harness::progress::Tick;
use crate::benchmark::harness::summary::Spread;
use crate::benchmark::harness::timing::{Build, Turn, time, time_builds};
use crate::benchmark::harness::workload::Workload;
use crate::scene::{Model, closed};

/// Contenders, and how much they are compared.
#[derive(Clone, Copy, Debug)]
pub struct PeerOptions<'o> {
    /// Rays in each mode.
    pub ray_count: usize,
    /// Times around.
    pub rounds: usize,
    /// Rays of the leak test, for a scene that is one closed mesh around its middle; others have none.
    pub leak_ray_count: usize,
    /// Seed of the photons.
    pub seed: u64,
    /// Libraries that take part.
    pub peers: &'o [Peer],
    /// Indices of ours that take part.
    pub kinds: &'o [IndexKind],
}

impl Default for PeerOptions<'_> {
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

/// Indices of ours made for speed, a binary hierarchy as the others have, and the paper's.
pub const USUAL_KINDS: &[IndexKind] =
    &[IndexKind::WideBvh, IndexKind::WideBvhHierarchy, IndexKind::Bvh, IndexKind::OctreeHierarchy];

/// Figures of one contender in one mode.
#[derive(Clone, Debug, PartialEq)]
pub struct PeerRow {
    /// The scene's name.
    pub scene: String,
    /// The library's or our index's name.
    pub contender: &'static str,
    /// The setting that was the fastest; "default" for ours.
    pub setting: &'static str,
    /// True for an index of `arboleda`.
    pub is_ours: bool,
    /// The question.
    pub mode: Mode,
    /// Triangles of the scene.
    pub triangle_count: usize,
    /// The build, on one thread.
    pub build_seconds: f64,
    /// Bytes that it holds, where that is known.
    pub bytes: Option<usize>,
    /// Million rays a second.
    pub speed: Spread,
    /// Answers that are not `arboleda`'s.
    pub disagreements: Disagreements,
    /// Leak-test rays that hit nothing, if there was such a test.
    pub leaks: Option<usize>,
}

/// Figures of all contenders on one scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PeerComparison {
    /// The scene's name.
    pub scene: String,
    /// Triangles of the scene.
    pub triangle_count: usize,
    /// Contender by contender, in the order in which they were built.
    pub rows: Vec<PeerRow>,
    /// Contenders that could not take part, and why.
    pub absent: Vec<(&'static str, PeerError)>,
}

/// Whose answers are the right ones, where it takes part: the plainest, without vector instructions.
/// Otherwise the first of ours that does.
const JUDGE: IndexKind = IndexKind::Bvh;

/// Rays by which the best setting is chosen.
const SAMPLE: usize = 100_000;

/// Contender, and what was found out before the timing.
struct Entrant<'a> {
    name: &'static str,
    /// Ours have none.
    setting: Option<&'static Setting>,
    contender: Box<dyn Contender + 'a>,
    build: Build<'a>,
    disagreements: [Disagreements; 3],
    leaks: [Option<usize>; 3],
}

impl<'a> Entrant<'a> {
    /// Takes a built contender, whose answers are still to be compared.
    fn new(
        name: &'static str,
        setting: Option<&'static Setting>,
        contender: Box<dyn Contender + 'a>,
        build: Build<'a>,
    ) -> Self {
        let (disagreements, leaks) = Default::default();
        Self { name, setting, contender, build, disagreements, leaks }
    }

    /// Compares the answers of every mode with the exact ones, and counts leaks if there are rays for that.
    fn check(&mut self, workload: &Workload, leaving: &Workload, answers: &mut Answers) {
        for (at, mode) in Mode::ALL.into_iter().enumerate() {
            if !self.contender.answer(mode, workload.rays(mode), answers) {
                continue;
            }
            self.disagreements[at] = Disagreements::of(workload, mode, answers);
            let rays = leaving.rays(mode);
            if rays.is_empty() {
                continue;
            }
            self.contender.answer(mode, rays, answers);
            self.leaks[at] = Some(match mode {
                Mode::Occluded => {
                    answers.occluded[..rays.len()].iter().filter(|hit| !**hit).count()
                }
                _ => answers.hits[..rays.len()].iter().filter(|hit| hit.is_none()).count(),
            });
        }
    }
}

/// Counts the steps of `progress`: for each contender two, and one for each round.
pub fn steps(options: &PeerOptions<'_>) -> u64 {
    (2 * (options.peers.len() + options.kinds.len()) + options.rounds) as u64
}

/// Compares everything on one scene.
///
/// # Errors
/// The errors of [`TimedIndex::build`]. A library that fails is only absent.
pub fn run(
    model: &Model,
    options: &PeerOptions<'_>,
    progress: Tick<'_>,
) -> Result<PeerComparison, BuildError> {
    let leaving = leak_workload(model, options);

    // 1. Build ours and, each by its best setting, the others.
    let scene = model.scene();
    let triangle_count = model.triangles.len();
    // Only where it is asked for.
    let mesh = LazyCell::new(|| WeldedMesh::of(&model.triangles));
    let build = |kind: IndexKind| {
        let beside = ours::is_beside(kind);
        let scene = if beside { Scene::of(mesh.kept()).beside() } else { scene };
        TimedIndex::build(kind, &scene, &Options::default())
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
        apart = TimedIndex::build(JUDGE, &scene, &Options::default())?;
        &apart
    };
    let judge = read(judge, &mesh);
    let workload = Workload::of_rays(model, judge.as_ray_index(), options.ray_count, options.seed)
        .with_shadow_rays(judge.as_ray_index());
    let rays = workload.rays(Mode::Single);
    let sample = &rays[..rays.len().min(SAMPLE)];
    let mut entrants = Vec::new();
    let mut absent = Vec::new();
    for peer in options.peers {
        match guarded(peer.name, || best_setting(peer, &model.triangles, sample)) {
            Ok((setting, built)) => {
                let again = || {
                    let built = guarded(peer.name, || setting.build(&model.triangles));
                    built.map_or(f64::INFINITY, |built| built.build_seconds)
                };
                let build = Build { seconds: built.build_seconds, again: Box::new(again) };
                entrants.push(Entrant::new(peer.name, Some(setting), built.contender, build));
            }
            Err(error) => absent.push((peer.name, error)),
        }
        progress();
    }
    for index in &owned {
        let again = || build(index.kind()).map_or(f64::INFINITY, |index| index.build_seconds());
        let build = Build { seconds: index.build_seconds(), again: Box::new(again) };
        let contender = ours::direct(read(index, &mesh));
        entrants.push(Entrant::new(ours::name(index.kind()), None, contender, build));
    }

    // 2. Check the answers, and look for leaks.
    let mut answers = Answers::room(rays.len().max(leaving.rays(Mode::Single).len()));
    entrants.retain_mut(|entrant| {
        let name = entrant.name;
        let checked = guarded(name, || {
            entrant.check(&workload, &leaving, &mut answers);
            Ok(())
        });
        progress();
        let takes_part = checked.is_ok();
        absent.extend(checked.err().map(|error| (name, error)));
        takes_part
    });

    // 3. Time.
    let mut builds: Vec<_> = entrants.iter_mut().map(|entrant| &mut entrant.build).collect();
    time_builds(&mut builds, triangle_count);
    let turns: Vec<Turn<'_>> = entrants
        .iter()
        .flat_map(|entrant| {
            let contender = entrant.contender.as_ref();
            Mode::ALL.map(|mode| Turn { contender, mode, rays: workload.rays(mode) })
        })
        .collect();
    let times = time(&turns, options.rounds, progress);
    let million_rays = rays.len() as f64 / 1e6;
    let mut rows = Vec::new();
    for (entrant, times) in entrants.iter().zip(times.chunks(Mode::ALL.len())) {
        for (at, (mode, times)) in Mode::ALL.into_iter().zip(times).enumerate() {
            // A mode that the contender does not have.
            if times.is_empty() {
                continue;
            }
            let speeds: Vec<f64> = times.iter().map(|seconds| million_rays / seconds).collect();
            rows.push(PeerRow {
                scene: model.name.clone(),
                contender: entrant.name,
                setting: entrant.setting.map_or("default", |setting| setting.name),
                is_ours: entrant.setting.is_none(),
                mode,
                triangle_count,
                build_seconds: entrant.build.seconds,
                bytes: entrant.contender.bytes(),
                speed: Spread::of(&speeds),
                disagreements: entrant.disagreements[at],
                leaks: entrant.leaks[at],
            });
        }
    }
    Ok(PeerComparison { scene: model.name.clone(), triangle_count, rows, absent })
}

/// Compares the first of ours with Embree's default: for scenes by size. All of ours grow in
/// [`growth::run`](super::growth::run).
///
/// # Errors
/// The errors of [`run`].
pub fn run_briefly(model: &Model, options: &PeerOptions<'_>) -> Result<PeerComparison, BuildError> {
    let options = PeerOptions {
        peers: &PEERS[..PEERS.len().min(1)],
        kinds: &options.kinds[..options.kinds.len().min(1)],
        leak_ray_count: 0,
        ..*options
    };
    run(model, &options, &|| {})
}

/// Opens an index of ours, beside the mesh if it was built so.
fn read<'a>(index: &'a TimedIndex, mesh: &'a impl Deref<Target = WeldedMesh>) -> AnyIndex<'a> {
    if ours::is_beside(index.kind()) { index.index_beside(mesh.kept()) } else { index.index() }
}

/// Does some work of a library; if it panics, that is an error.
fn guarded<T>(
    library: &'static str,
    work: impl FnOnce() -> Result<T, PeerError>,
) -> Result<T, PeerError> {
    // What a panic leaves half done is the library's index, which is dropped, and answers, which are
    // overwritten.
    catch_unwind(AssertUnwindSafe(work)).unwrap_or(Err(PeerError::Panicked { library }))
}

/// Makes rays that must all hit; none if the scene is not closed.
fn leak_workload(model: &Model, options: &PeerOptions<'_>) -> Workload {
    let inside = if options.leak_ray_count == 0 { None } else { closed::inside(&model.triangles) };
    inside.map_or_else(Workload::default, |inside| {
        Workload::of_leaks(&model.triangles, inside, options.leak_ray_count, options.seed)
    })
}
