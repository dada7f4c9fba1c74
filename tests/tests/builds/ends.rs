//! Tests that builds end: work and memory are at most a multiple of n log n, wherever the triangles lie.
//!
//! Work is counted in steps, each a visit of a triangle, so no test depends on time.

use arboleda::{
    Block, BuildError, Capacity, IndexKind, Level, Options, Resolution, Scene, Triangle,
};
use arboleda_tests::build::Built;
use arboleda_tests::checks::{self, work};
use arboleda_tests::rays;
use arboleda_tests::scenes::{self, crowds};

fn capacity(
    kind: IndexKind,
    triangles: &[Triangle],
    options: &Options,
) -> Result<Capacity, BuildError> {
    let bytes = kind.scratch_capacity(triangles.len(), options);
    let mut scratch = vec![Block::ZERO; Block::count(bytes)];
    kind.capacity(&Scene::new(triangles), options, Block::bytes(&mut scratch))
}

/// Counts the steps of a build with automatic level and resolution.
fn steps(kind: IndexKind, triangles: &[Triangle]) -> u64 {
    capacity(kind, triangles, &Options::default()).unwrap().steps
}

/// A crowd takes at most three times the work of as many triangles strewn over a cube.
#[test]
fn crowds_cost_no_more_than_three_times_a_benign_scene() {
    const COUNT: usize = 4_000;
    let benign = scenes::soup(COUNT, 3);
    for &kind in IndexKind::ALL {
        let most = 3 * steps(kind, &benign);
        for (name, crowd) in crowds::ALL {
            let steps = steps(kind, &crowd(COUNT));
            assert!(steps <= most, "{}, {name}: {steps} of {most}", kind.name());
        }
    }
}

/// Work is at most a multiple of `n log2 n`, for 500 and for 8,000 triangles.
#[test]
fn work_grows_no_faster_than_n_log_n() {
    for &kind in IndexKind::ALL {
        for (name, crowd) in crowds::ALL {
            for count in [500, 8_000] {
                let (steps, most) = (steps(kind, &crowd(count)), work::most_steps(count));
                assert!(steps <= most, "{}, {name}, {count}: {steps} of {most}", kind.name());
            }
        }
    }
}

/// With automatic level and resolution, trees have at most 16 references a triangle, grids at most 70.
#[test]
fn references_are_bounded() {
    for &kind in IndexKind::ALL {
        for (name, crowd) in crowds::ALL {
            let triangles = crowd(1_000);
            let built = Built::new(kind, &Scene::new(&triangles), &Options::default()).unwrap();
            let references = built.index().check().unwrap().references;
            assert!(references <= 70 * 1_000, "{}, {name}: {references}", kind.name());
            if !kind.name().contains("grid") {
                assert!(references <= 16 * 1_000, "{}, {name}: {references}", kind.name());
            }
        }
    }
}

/// A given deep level is reached only as far as divisions separate triangles.
#[test]
fn given_levels_and_resolutions_end() {
    let deepest = Options { level: Level::AtMost(20), leaf_capacity: 1, ..Options::default() };
    let finest = Options { resolution: Resolution::Cells([200; 3]), ..Options::default() };
    for (name, crowd) in crowds::ALL {
        let triangles = crowd(30);
        for kind in [IndexKind::Octree, IndexKind::OctreeR, IndexKind::BspTree, IndexKind::KdTree] {
            let steps = capacity(kind, &triangles, &deepest).unwrap().steps;
            // 4,096 references a triangle, each visited up to 16 times at each of up to 60 divisions.
            assert!(steps < 30 * 4096 * 16 * 60, "{}, {name}: {steps}", kind.name());
        }
        let grid = capacity(IndexKind::UniformGrid, &triangles, &finest).unwrap().steps;
        assert!(grid <= 2 * (30 * 4096 + 8 * 200 * 200 * 200), "{name}: {grid}");
    }
}

/// A build with a limit of work returns an index or an error, and the limit is exact.
#[test]
fn the_work_limit_is_kept() {
    let triangles = crowds::planes_through_a_point(300);
    for &kind in IndexKind::ALL {
        let needed = steps(kind, &triangles);
        let limited = |limit| Options { work_limit: Some(limit), ..Options::default() };
        assert_eq!(capacity(kind, &triangles, &limited(needed)).unwrap().steps, needed);
        let refused = capacity(kind, &triangles, &limited(needed - 1)).unwrap_err();
        assert_eq!(refused, BuildError::TooMuchWork { limit: needed - 1 }, "{}", kind.name());
    }
}

/// Every index answers on crowds as the linear scan does.
#[test]
fn crowds_are_answered_exactly() {
    for (_, crowd) in crowds::ALL {
        let triangles = crowd(100);
        let asked = rays::around(&triangles, 20, 11);
        checks::every_index_equals_linear(&triangles, &asked, &Options::default());
    }
}
