//! Cost of rays in each index on a processor, with their counters. The weights of the core's `select` are fitted to
//! these rows.

use core::fmt::{self, Write};

use arboleda::{AnyIndex, Block, Counters, IndexKind, Options, Ray, Scene, Vec3};

use crate::{Memory, Numbers, TRIANGLES, write_scene};

/// Numbers of triangles of the indexed scenes, each a prefix of the scene's triangles.
const COUNTS: [usize; 5] = [24, 72, 120, 200, TRIANGLES];
const RAYS: usize = 64;

/// Writes a line for each index and number of triangles: name, triangles, rays, nodes, tests, time, hits. The time is
/// that of `clock` for the same rays without counting.
///
/// # Errors
/// If the output or a build fails.
pub fn run(out: &mut dyn Write, clock: impl Fn() -> u64) -> fmt::Result {
    let memory = crate::memory().ok_or(fmt::Error)?;
    if write_scene(&mut memory.triangles) != TRIANGLES {
        return Err(fmt::Error);
    }
    let Memory { triangles, arena, scratch } = memory;
    let rays = rays();
    for count in COUNTS {
        let scene = Scene::new(triangles.get(..count).ok_or(fmt::Error)?);
        for &kind in IndexKind::ALL {
            let (arena, scratch) = (Block::bytes(&mut arena[..]), Block::bytes(&mut scratch[..]));
            let index = kind.build(&scene, &Options::DEFAULT, arena, scratch);
            let index = index.map_err(|_| fmt::Error)?;
            line(kind, count, &index, &rays, &clock, out)?;
        }
    }
    Ok(())
}

fn line(
    kind: IndexKind,
    triangles: usize,
    index: &AnyIndex<'_>,
    rays: &[Option<Ray>],
    clock: impl Fn() -> u64,
    out: &mut dyn Write,
) -> fmt::Result {
    let mut counters = Counters::default();
    let index = index.as_ray_index();
    for ray in rays.iter().flatten() {
        index.closest_hit_counted(ray, &mut counters);
    }
    let begun = clock();
    let hits = rays.iter().flatten().filter(|ray| index.closest_hit(ray).is_some()).count();
    let time = clock() - begun;
    let Counters { nodes_visited, triangle_tests } = counters;
    let (name, rays) = (kind.family(), rays.iter().flatten().count());
    writeln!(out, "{name} {triangles} {rays} {nodes_visited} {triangle_tests} {time} {hits}")
}

/// Makes random rays. Few of them hit a corner or an edge, where the slow exact kernel would decide.
fn rays() -> [Option<Ray>; RAYS] {
    let mut numbers = Numbers(7);
    [(); RAYS].map(|()| {
        let origin = numbers.point() * 24.0 + Vec3::new(0.01, 0.02, 0.03);
        Ray::new(origin, numbers.point() * 16.0 - origin).ok()
    })
}
