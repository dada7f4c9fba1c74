//! One scene, all contenders: build, check, then time.

use arboleda::{BuildError, IndexKind, Options};

use super::agreement::Disagreements;
use super::contender::{Contender, Peer};
use super::ours::Ours;
use super::ring::{Answers, Mode, Speed, answer, time};
use super::workload::{Workload, leak_rays};
use super::{PEERS, PeerError, tune};
use crate::OwnedIndex;
use crate::scene::Model;

/// How much is compared.
#[derive(Clone, Copy, Debug)]
pub struct ComparisonOptions<'o> {
    /// Rays in each mode.
    pub ray_count: usize,
    /// Times around.
    pub rounds: usize,
    /// Rays of the leak test; 0 for scenes that are not closed.
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
        // The linear scan comes first and would take hours.
        let kinds = IndexKind::ALL.get(1..).unwrap_or_default();
        Self { ray_count: 500_000, rounds: 5, leak_ray_count: 0, seed: 1, peers: PEERS, kinds }
    }
}

/// One contender in one mode.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The scene's name.
    pub scene: String,
    /// The library's or our index's name.
    pub contender: &'static str,
    /// The setting that was the fastest; "default" for ours.
    pub setting: &'static str,
    /// What was asked.
    pub mode: Mode,
    /// Triangles of the scene.
    pub triangle_count: usize,
    /// The build, on one thread.
    pub build_seconds: f64,
    /// What it holds, where that is known.
    pub bytes: Option<usize>,
    /// Million rays a second.
    pub speed: Speed,
    /// Answers that are not `arboleda`'s.
    pub disagreements: Disagreements,
    /// Leak-test rays that hit nothing, if there was such a test.
    pub leaks: Option<usize>,
}

/// What came of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Contender by contender, in the order in which they were built.
    pub rows: Vec<Row>,
    /// Those that could not take part, and why.
    pub absent: Vec<(&'static str, PeerError)>,
}

/// Rays by which the best setting is chosen.
const SAMPLE: usize = 100_000;

/// A contender and what was found out before the timing.
struct Entrant<'a> {
    name: &'static str,
    setting: &'static str,
    contender: Box<dyn Contender + 'a>,
    build_seconds: f64,
    disagreements: [Disagreements; 3],
    leaks: [Option<usize>; 3],
}

/// Compares everything on one scene.
///
/// # Errors
/// As [`OwnedIndex::build`]: the scene cannot be indexed. A library that fails is only absent.
pub fn compare(model: &Model, options: &ComparisonOptions<'_>) -> Result<Comparison, BuildError> {
    let workload = Workload::new(model, options.ray_count, options.seed)?;
    let leaving = leak_workload(model, options);

    // 1. Build ours and, each by its best setting, the others.
    let scene = model.scene();
    let build = |&kind: &IndexKind| {
        let build = || OwnedIndex::build(kind, &scene, &Options::default());
        tune::fastest_build(build, OwnedIndex::build_seconds)
    };
    let owned = options.kinds.iter().map(build).collect::<Result<Vec<_>, _>>()?;
    let mut entrants = Vec::new();
    let mut absent = Vec::new();
    let entrant = |name, setting, contender, build_seconds| Entrant {
        name,
        setting,
        contender,
        build_seconds,
        disagreements: Default::default(),
        leaks: [None; 3],
    };
    let sample = &workload.rays[..workload.rays.len().min(SAMPLE)];
    for peer in options.peers {
        match tune::best(peer, &model.triangles, sample) {
            Ok((setting, built)) => {
                entrants.push(entrant(peer.name, setting, built.contender, built.build_seconds));
            }
            Err(error) => absent.push((peer.name, error)),
        }
    }
    for index in &owned {
        let ours = Box::new(Ours::new(index.index()));
        entrants.push(entrant(index.kind().name(), "default", ours, index.build_seconds()));
    }

    // 2. Check the answers, and look for leaks.
    let mut answers = Answers::room(workload.rays.len().max(leaving.rays.len()));
    for entrant in &mut entrants {
        for (at, mode) in Mode::ALL.into_iter().enumerate() {
            (entrant.disagreements[at], entrant.leaks[at]) =
                check(entrant.contender.as_ref(), mode, &workload, &leaving, &mut answers);
        }
    }

    // 3. Time.
    let contenders: Vec<&dyn Contender> =
        entrants.iter().map(|entrant| entrant.contender.as_ref()).collect();
    let speeds = time(&contenders, &workload, options.rounds);
    let mut rows = Vec::new();
    for (entrant, speeds) in entrants.iter().zip(speeds) {
        for (at, (mode, speed)) in Mode::ALL.into_iter().zip(speeds).enumerate() {
            rows.extend(speed.map(|speed| Row {
                scene: model.name.clone(),
                contender: entrant.name,
                setting: entrant.setting,
                mode,
                triangle_count: model.triangles.len(),
                build_seconds: entrant.build_seconds,
                bytes: entrant.contender.bytes(),
                speed,
                disagreements: entrant.disagreements[at],
                leaks: entrant.leaks[at],
            }));
        }
    }
    Ok(Comparison { rows, absent })
}

/// Rays that must all hit; empty if that is not asked for. The answers are not looked at.
fn leak_workload(model: &Model, options: &ComparisonOptions<'_>) -> Workload {
    let rays = leak_rays(&model.triangles, options.leak_ray_count, options.seed);
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
            answers.hits[..count].iter().filter(|hit| hit.is_miss()).count()
        }
    };
    (disagreements, Some(leaks))
}
