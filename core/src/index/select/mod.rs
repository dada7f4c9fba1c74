//! Selection of an index for a scene: candidates are built, tried on rays, and weighed.
//!
//! ```text
//! candidate -> build in the arena -> too large, or too much work: left out
//!                                -> rays, counted -> ray + nodes * node + tests * test -> the least wins
//! ```
//! The candidates find level and resolution themselves, unless the options give them. Counters are the same on every
//! machine, and so is the choice.

mod budget;

use core::fmt;

use arrayvec::ArrayVec;

use super::IndexKind;
use crate::error::BuildError;
use crate::geometry::{Aabb, Ray, RaySpan};
use crate::indices::cost::for_each_ray;
use crate::input::{Options, Scene, Sequential};
use crate::query::Counters;
use budget::{Budget, BuildCost};

/// Number of kinds to choose from.
const KINDS: usize = IndexKind::ALL.len();

/// Candidates worth building.
///
/// # Measured
/// - On every built-in scene, one of these was the fastest of all kinds, and no other kind was within a factor of 1.5
///   of it.
/// - The octree hierarchy is here for its size.
/// - The compact BVH, which is smaller still, is not here: it is a sixth slower than the wide BVH, which is less than
///   weights tell apart on some scenes.
pub const USUAL: &[IndexKind] = &[
    IndexKind::Linear,
    #[cfg(feature = "octree")]
    IndexKind::OctreeHierarchy,
    #[cfg(feature = "uniform-grid")]
    IndexKind::GridHierarchy,
    #[cfg(feature = "kd-tree")]
    IndexKind::KdTree,
    #[cfg(feature = "bvh")]
    IndexKind::Bvh,
    #[cfg(feature = "bvh")]
    IndexKind::BvhHierarchy,
    #[cfg(feature = "wide-bvh")]
    IndexKind::WideBvh,
    #[cfg(feature = "wide-bvh")]
    IndexKind::WideBvhHierarchy,
];

/// Tolerance of the choice: candidates within 3% of the cheapest tie, because the weights are no more accurate than
/// that.
const AS_GOOD: f64 = 1.03;

/// Number of rays of a sample. They take a few milliseconds, little beside the builds.
const RAYS: u32 = 1024;

/// Expectation of a candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expectation {
    /// The candidate fits into the arena, at this cost.
    Fits(Cost),
    /// The candidate was left out, for this reason: it cannot be built in the memory given or at all, or trying it
    /// would have taken more than it may save.
    LeftOut(BuildError),
}

/// Cost of an index: averages over the rays, the build, and the bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cost {
    /// Nanoseconds of a ray, as [`Weights`](crate::custom::Weights) estimate them from its counters.
    pub nanoseconds: f64,
    /// Nanoseconds of building the index once, estimated from its steps.
    pub build_nanoseconds: f64,
    /// Nodes visited by a ray.
    pub nodes: f64,
    /// Triangles tested by a ray.
    pub tests: f64,
    /// Bytes of the index.
    pub bytes: usize,
}

/// Candidate: a kind, and its expectation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The kind of index.
    pub kind: IndexKind,
    /// Its cost, or the reason why it was left out.
    pub expectation: Expectation,
}

/// Result of [`select`]: the chosen kind and all candidates. Printed, it is a sentence with the reasons.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    chosen: IndexKind,
    cost: Cost,
    candidates: ArrayVec<Candidate, KINDS>,
}

impl Selection {
    /// The chosen kind: the cheapest that fits. Of those within 3% of the cheapest it is the smallest, then the first.
    pub fn kind(&self) -> IndexKind {
        self.chosen
    }

    /// The cost of the chosen kind.
    pub fn cost(&self) -> Cost {
        self.cost
    }

    /// All candidates, in the order in which they were given.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }
}

/// Chooses an index for a scene: builds candidates in the arena, answers the [scene's rays](Scene::rays) with each, and
/// weighs the work of that.
///
/// - Without rays, a sample is taken: 1,024 rays, two thirds of them lines through the scene's box, the rest light that
///   reaches triangles.
/// - [`IndexKind::Linear`] is not queried, since its work is known.
/// - A candidate named twice counts once.
/// - The contents of the arena are undefined afterwards. Build the chosen kind in it with the same options.
///
/// If the scene says [how many rays](Scene::expecting) are to come, the build counts too: for a single ray in a large
/// scene the linear scan wins, because no tree has to be built.
///
/// Cost: trying takes at most the largest of three times the build of the chosen candidate, half the time of its rays,
/// and 4 ms; plus a few thousand queries.
/// - Without [`Scene::expecting`], 16 rays a triangle are assumed.
/// - Candidates that are likely to be best are tried first.
/// - A candidate that would take more is left out as [`BuildError::TooMuchWork`]; with more rays expected, it is tried.
/// - Work is counted, not timed, so that the choice is the same on every machine.
///
/// # Errors
/// - If no candidate can be built, the error of the first; if that is [`BuildError::ArenaFull`], the one that needs the
///   fewest bytes.
/// - [`BuildError::InvalidOption`] without candidates.
///
/// # Examples
/// ```
/// use arboleda::select::{USUAL, select};
/// use arboleda::{Block, Options, Scene, Triangle, Vec3};
///
/// let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)];
/// let (scene, options) = (Scene::new(&triangles), Options::default());
/// let (mut arena, mut scratch) = ([Block::ZERO; 64], [Block::ZERO; 64]);
/// let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
/// let selection = select(&scene, &options, USUAL, arena, scratch)?;
/// assert_eq!(selection.candidates().len(), USUAL.len());
/// let index = selection.kind().build(&scene, &options, arena, scratch)?;
/// # Ok::<(), arboleda::BuildError>(())
/// ```
pub fn select(
    scene: &Scene<'_>,
    options: &Options,
    candidates: &[IndexKind],
    arena: &mut [u8],
    scratch: &mut [u8],
) -> Result<Selection, BuildError> {
    // 1. List each kind once, in the caller's order.
    let mut estimates = ArrayVec::<Candidate, KINDS>::new();
    for &kind in candidates {
        if estimates.iter().all(|known| known.kind != kind) {
            let untried = Expectation::LeftOut(BuildError::TooMuchWork { limit: 0 });
            let pushed = estimates.try_push(Candidate { kind, expectation: untried }).is_ok();
            debug_assert!(pushed, "each kind comes once");
        }
    }

    // 2. Try the kinds, in the order of their turns.
    let mut trials =
        Trials { scene, options, budget: Budget::new(scene, options.float64), best: None };
    for turn in 0..BuildCost::TURNS {
        for candidate in &mut estimates {
            if BuildCost::turn(candidate.kind) == turn {
                candidate.expectation = match trials.expect(candidate.kind, arena, scratch) {
                    Ok(cost) => Expectation::Fits(cost),
                    Err(error) => Expectation::LeftOut(error),
                };
            }
        }
    }

    // 3. Choose the smallest of those whose cost ties with the least.
    let Some(least) = trials.best.map(|best| best.whole) else {
        return Err(least_missing(&estimates));
    };
    let mut best: Option<(IndexKind, Cost)> = None;
    for Candidate { kind, expectation } in &estimates {
        if let Expectation::Fits(cost) = *expectation
            && trials.budget.whole(cost.build_nanoseconds, cost.nanoseconds) <= least * AS_GOOD
            && best.is_none_or(|(_, smallest)| cost.bytes < smallest.bytes)
        {
            best = Some((*kind, cost));
        }
    }
    match best {
        Some((chosen, cost)) => Ok(Selection { chosen, cost, candidates: estimates }),
        None => Err(least_missing(&estimates)),
    }
}

/// Best candidate so far.
#[derive(Clone, Copy)]
struct Best {
    /// Nanoseconds to build it.
    build: f64,
    /// Nanoseconds a ray.
    ray: f64,
    /// The whole cost; see [`Budget::whole`].
    whole: f64,
}

/// Trials of the candidates, with their common budget.
struct Trials<'t, 'a> {
    scene: &'t Scene<'a>,
    options: &'t Options,
    budget: Budget,
    best: Option<Best>,
}

impl Trials<'_, '_> {
    /// Tries a candidate, if there is enough memory for it and enough of the budget left.
    fn expect(
        &mut self,
        kind: IndexKind,
        arena: &mut [u8],
        scratch: &mut [u8],
    ) -> Result<Cost, BuildError> {
        let count = self.scene.triangles().len();
        let costs = BuildCost::of(kind, self.options.float64);
        let least = costs.least_nanoseconds(count);
        let given = self.options.work_limit.unwrap_or(u64::MAX);
        let limit = match self.best {
            None => given,
            Some(best) => {
                let left = self.budget.left(best.build, best.ray);
                let limit = costs.steps_within(count, left).min(given);
                if least > left || !self.budget.may_win(least, best.whole) {
                    return Err(BuildError::TooMuchWork { limit });
                }
                limit
            }
        };
        let options = Options { work_limit: Some(limit), ..*self.options };
        let mut steps = 0;
        let tried = try_candidate(kind, self.scene, &options, arena, scratch, &mut steps);
        let build = costs.nanoseconds(count, steps as f64);
        // The linear scan's build is a copy of the ids; spending it could keep the first tree from being tried.
        if kind != IndexKind::Linear {
            self.budget.spend(build);
        }
        let cost = Cost { build_nanoseconds: build, ..tried? };
        let whole = self.budget.whole(build, cost.nanoseconds);
        if self.best.is_none_or(|best| whole < best.whole) {
            self.best = Some(Best { build, ray: cost.nanoseconds, whole });
        }
        Ok(cost)
    }
}

/// Chooses the error to return if no candidate can be built.
fn least_missing(estimates: &[Candidate]) -> BuildError {
    let mut errors = estimates.iter().filter_map(|estimate| match estimate.expectation {
        Expectation::LeftOut(error) => Some(error),
        Expectation::Fits(_) => None,
    });
    let none = BuildError::InvalidOption { option: "candidates", allowed: "at least one" };
    let Some(first) = errors.next() else {
        return none;
    };
    errors.fold(first, |least, error| match (least, error) {
        (BuildError::ArenaFull { needed, .. }, BuildError::ArenaFull { needed: other, .. })
            if other < needed =>
        {
            error
        }
        _ => least,
    })
}

/// Builds a candidate, writes the number of steps to `steps`, and answers the rays with the index.
fn try_candidate(
    kind: IndexKind,
    scene: &Scene<'_>,
    options: &Options,
    arena: &mut [u8],
    scratch: &mut [u8],
    steps: &mut u64,
) -> Result<Cost, BuildError> {
    let index = kind.build_counted(scene, options, arena, scratch, &Sequential, steps)?;
    let mut counters = Counters::default();
    let mut count = 0_u64;
    // The work of the linear scan is known: a node if the ray meets the scene's box, and then all triangles.
    let scan = (kind == IndexKind::Linear).then(|| index.sections().nodes().last());
    let mut ask = |ray: &Ray| {
        count += 1;
        let Some(root) = scan else {
            index.closest_hit_counted(ray, &mut counters);
            return;
        };
        let meets = |bounds: &Aabb| {
            let ray = RaySpan::new(ray, bounds);
            !ray.clip(bounds, ray.whole()).is_empty()
        };
        if root.is_some_and(|root| meets(&root.bounds)) {
            counters.nodes_visited += 1;
            counters.triangle_tests += scene.triangles().len() as u64;
        }
    };
    if scene.rays.is_empty() {
        for_each_ray(scene.triangles().iter(), RAYS, &mut ask);
    } else {
        scene.rays.iter().for_each(&mut ask);
    }
    // The sample of an empty scene has no rays.
    let per_ray = 1.0 / if count > 0 { count as f64 } else { 1.0 };
    Ok(Cost {
        build_nanoseconds: 0.0,
        nanoseconds: kind.weights(options.float64).nanoseconds(count, &counters) * per_ray,
        nodes: counters.nodes_visited as f64 * per_ray,
        tests: counters.triangle_tests as f64 * per_ray,
        bytes: index.as_bytes().len(),
    })
}

/// Number, at least 0, printed with `PLACES` decimals. As far as the compiler can tell, the standard library's
/// formatting of `f64` can panic.
struct Decimal<const PLACES: u32>(f64);

impl<const PLACES: u32> fmt::Display for Decimal<PLACES> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = const { 10_u64.pow(PLACES) };
        let rounded = (self.0 * unit as f64 + 0.5) as u64;
        write!(f, "{}.{:0width$}", rounded / unit, rounded % unit, width = PLACES as usize)
    }
}

impl fmt::Display for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Cost { nanoseconds, nodes, tests, .. } = self.cost;
        write!(
            f,
            "{}: {} us a ray estimated ({} nodes, {} tests)",
            self.chosen.name(),
            Decimal::<2>(nanoseconds / 1e3),
            Decimal::<1>(nodes),
            Decimal::<1>(tests)
        )?;
        let mut next: Option<(IndexKind, f64)> = None;
        for candidate in &self.candidates {
            match candidate.expectation {
                Expectation::Fits(cost)
                    if candidate.kind != self.chosen
                        && next.is_none_or(|(_, least)| cost.nanoseconds < least) =>
                {
                    next = Some((candidate.kind, cost.nanoseconds));
                }
                _ => {}
            }
        }
        if let Some((kind, other)) = next {
            write!(f, "; next: {}, ", kind.name())?;
            if nanoseconds > 0.0 {
                write!(f, "{} times as much", Decimal::<2>(other / nanoseconds))?;
            } else {
                f.write_str("as much")?;
            }
        }
        // First the candidates that were not worth their build, in one list; then the others, each with a reason.
        let mut separator = "; not worth building: ";
        for candidate in &self.candidates {
            if let Expectation::LeftOut(BuildError::TooMuchWork { .. }) = candidate.expectation {
                write!(f, "{separator}{}", candidate.kind.name())?;
                separator = ", ";
            }
        }
        for candidate in &self.candidates {
            match candidate.expectation {
                Expectation::Fits(_) | Expectation::LeftOut(BuildError::TooMuchWork { .. }) => {}
                Expectation::LeftOut(error) => {
                    write!(f, "; {} left out: {error}", candidate.kind.name())?;
                }
            }
        }
        Ok(())
    }
}
