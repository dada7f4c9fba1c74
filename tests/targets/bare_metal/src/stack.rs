//! Stack of builds and queries on a Cortex-M. Memory below the stack pointer is filled with a pattern; words that have
//! changed after the call were used.
//!
//! - The frames of a query depend only on the functions that it enters. The rays here enter all of them: rays decided
//!   in SIMD lanes, rays decided in `f64`, and rays that reach each stage of the exact kernel.
//! - The frames of a build depend on the scene too, by the depth of the tree.

use core::arch::asm;
use core::fmt::{self, Write};

use arboleda::{AnyIndex, Block, Hit, IndexKind, Options, Ray, RayError, Scene, Vec3};

use crate::{GROUPS, IN_A_BATCH, MOST_HITS, Numbers, TRIANGLES, memory, ray, write_scene};

/// Words filled below the stack pointer, far more than any call uses.
const PAINTED_WORDS: usize = 1 << 15;
/// Number of special rays: 8 sorts on 7 grid lines with 3 intervals.
const RAYS: u32 = 168;
/// Pattern of unused words.
const COLOUR: u32 = 0xa5c3_5a3c;

/// Writes one line for each index. Succeeds only once.
///
/// # Errors
/// If the output or a build fails.
pub fn run(out: &mut dyn Write) -> fmt::Result {
    let memory = memory().ok_or(fmt::Error)?;
    if write_scene(&mut memory.triangles) != TRIANGLES {
        return Err(fmt::Error);
    }
    let scene = Scene::new(&memory.triangles);
    let options = Options::default();
    let (arena, scratch) = (Block::bytes(&mut memory.arena), Block::bytes(&mut memory.scratch));
    for &kind in IndexKind::ALL {
        let mut built = false;
        let build = used_by(&mut || {
            built = kind.build(&scene, &options, arena, scratch).is_ok();
        });
        let mut opened = None;
        let open = used_by(&mut || {
            opened = if built { kind.from_bytes(arena).ok() } else { None };
        });
        let Some(index) = opened else {
            writeln!(out, "{}: not built", kind.name())?;
            return Err(fmt::Error);
        };
        let ordinary = used_by(&mut || ask_ordinary(&index));
        let any = ordinary.max(used_by(&mut || ask_special(&index)));
        let batch = used_by(&mut || ask_batches(&index));
        let name = kind.name();
        writeln!(
            out,
            "{name} ordinary={ordinary} any={any} batch={batch} build={build} open={open}"
        )?;
    }
    Ok(())
}

/// Measures the bytes of stack that `work` uses.
#[inline(never)]
fn used_by(work: &mut dyn FnMut()) -> usize {
    let top: usize;
    // SAFETY: reads a register.
    unsafe { asm!("mov {}, sp", out(reg) top, options(nomem, nostack, preserves_flags)) };
    let words = top as *mut u32;
    // SAFETY: the stack has 3 MiB left, nothing below its pointer is in use, and there are no interrupts.
    (1..=PAINTED_WORDS).for_each(|down| unsafe { words.wrapping_sub(down).write_volatile(COLOUR) });
    work();
    // SAFETY: as above.
    let is_used = |down: &usize| unsafe { words.wrapping_sub(*down).read_volatile() != COLOUR };
    (1..=PAINTED_WORDS).rev().find(is_used).unwrap_or(0) * size_of::<u32>()
}

/// Queries ordinary rays, from a random point above to a random point.
fn ask_ordinary(index: &AnyIndex<'_>) {
    let mut numbers = Numbers(1);
    for _ in 0..RAYS / 8 {
        let origin = numbers.point() * 24.0 + Vec3::Y * 30.0;
        if let Ok(ray) = Ray::new(origin, numbers.point() * 16.0 - origin) {
            ask(index, &ray);
        }
    }
}

fn ask_special(index: &AnyIndex<'_>) {
    let mut numbers = Numbers(1);
    for number in 0..RAYS {
        for ray in [ray(number, &mut numbers), special(number)].into_iter().flatten() {
            ask(index, &ray);
        }
    }
}

fn ask_batches(index: &AnyIndex<'_>) {
    let mut numbers = Numbers(1);
    let mut hits = [Hit::NONE; IN_A_BATCH];
    for number in 0..RAYS {
        for ray in [ray(number, &mut numbers), special(number)].into_iter().flatten() {
            index.closest_hits(&[ray; IN_A_BATCH], &mut hits);
        }
    }
}

fn ask(index: &AnyIndex<'_>, ray: &Ray) {
    let mut buffer = [Hit::NONE; MOST_HITS];
    let _ = (index.closest_hit(ray), index.occluded(ray), index.all_hits(ray, &mut buffer));
}

/// Makes special ray `number`: through edges and corners, as a half-line or as a line. SIMD lanes do not take lines.
///
/// Some rays begin a hair above the floor. Exponents are then too far apart for whole numbers, so long sums decide
/// signs and round quotients.
fn special(number: u32) -> Result<Ray, RayError> {
    const HAIRS: [f32; 3] = [0.0, 1.0e-30, 1.0e-38];
    let hair = HAIRS[number as usize / 2 % HAIRS.len()];
    let (group, side) = GROUPS[number as usize / 8 % GROUPS.len()];
    let corner = if number % 4 < 2 { group } else { group + Vec3::splat(side) };
    let lines = (number % 7) as f32 * 6.0 - 18.0;
    let (origin, direction) = match number % 8 {
        0 => (Vec3::new(lines, hair, lines), Vec3::NEG_Y),
        1 => (Vec3::new(lines, hair, lines + 2.5), Vec3::Y),
        2 => (Vec3::new(hair, 9.0, hair), Vec3::NEG_Y),
        3 => (corner - Vec3::splat(8.0), Vec3::ONE),
        4 => (corner + Vec3::new(4.0, -4.0, 4.0), Vec3::new(-1.0, 1.0, -1.0)),
        5 => (corner + Vec3::new(hair, 7.0, 0.0), Vec3::NEG_Y),
        6 => (Vec3::new(-30.0, hair, lines), Vec3::new(1.0, 0.0, 0.25)),
        _ => (corner + Vec3::new(0.0, 5.0, hair), Vec3::new(0.0, -1.0, hair)),
    };
    let first = if number % 3 == 0 { f32::NEG_INFINITY } else { 0.0 };
    Ray::with_interval(origin, direction, first, f32::INFINITY)
}
