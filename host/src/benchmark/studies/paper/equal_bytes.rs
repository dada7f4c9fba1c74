//! The grid of the same size: the paper compares octrees and grids that take the same memory.

use anyhow::Context;
use arboleda::{Block, IndexKind};

use crate::benchmark::harness::plan::Case;
use crate::scene::Model;

/// Relative difference within which two sizes count as equal.
pub const TOLERANCE: f64 = 0.02;
/// Densities that the core accepts.
const DENSITIES: (f64, f64) = (1e-4, 1024.0);
/// The most dry runs.
const STEPS: usize = 20;

/// Finds a case of `kind` with the density at which the index, without its triangles, is nearest in bytes to
/// `wanted`; and how many bytes that takes.
///
/// More cells take more bytes, but in steps, because cells on an axis are whole: the search narrows the
/// range by size, keeps the nearest of all it meets, and stops at a
/// tenth of [`TOLERANCE`], in bytes or in the range. It takes logarithms of
/// densities and of bytes to be in line between the ends of the range, and stays off the ends by a tenth. Where planes
/// fall together with the faces of many boxes, as on figure 3's cubes, size jumps both ways with density
/// and the nearest met may be several percent off; callers report how far.
/// Cost: up to 20 dry runs, usually 5 to 8.
///
/// # Errors
/// If the model cannot be indexed.
pub fn grid_of_bytes(
    kind: IndexKind,
    model: &Model,
    wanted: usize,
) -> anyhow::Result<(Case, usize)> {
    let triangle_bytes = size_of_val(model.triangles.as_slice());
    let size = |density: f64| -> anyhow::Result<usize> {
        let options = Case::at_density(kind, density as f32).options;
        let needed = kind.scratch_capacity(model.triangles.len(), &options);
        let mut scratch = vec![Block::ZERO; Block::count(needed)];
        let capacity = kind.capacity(&model.scene(), &options, Block::bytes(&mut scratch));
        let capacity = capacity.with_context(|| format!("cannot measure {}", kind.name()))?;
        Ok(capacity.index - triangle_bytes)
    };
    // The ends of the range, as logarithms: density, and bytes once they are known.
    let (mut low, mut high) = ((libm::log(DENSITIES.0), None), (libm::log(DENSITIES.1), None));
    let target = libm::log(wanted.max(1) as f64);
    // Begin near where surfaces usually land, not in the middle of a range a million wide: the dry run of
    // the middle is cheap, that of 1024 cells a triangle is not.
    let mut middle = libm::log((wanted as f64 / triangle_bytes.max(1) as f64).max(0.02));
    let mut best: Option<(f64, usize)> = None;
    for _ in 0..STEPS {
        let bytes = size(libm::exp(middle))?;
        let off = |bytes: usize| bytes.abs_diff(wanted);
        if best.is_none_or(|(_, known)| off(bytes) < off(known)) {
            best = Some((middle, bytes));
        }
        let is_narrow = high.0 - low.0 < TOLERANCE * 0.1;
        if is_narrow || off(bytes) as f64 <= wanted as f64 * TOLERANCE * 0.1 {
            break;
        }
        let known = Some(libm::log(bytes.max(1) as f64));
        if bytes < wanted {
            low = (middle, known);
        } else {
            high = (middle, known);
        }
        middle = match (low, high) {
            ((from, Some(few)), (to, Some(many))) if few < many => {
                let share = ((target - few) / (many - few)).clamp(0.1, 0.9);
                from + (to - from) * share
            }
            ((from, Some(_)), (to, Some(_))) => f64::midpoint(from, to),
            // Three times as many cells at most, until the range is closed from both sides.
            ((from, Some(_)), (to, None)) => f64::midpoint(from, to).min(from + 1.0),
            ((from, None), (to, _)) => f64::midpoint(from, to).max(to - 1.0),
        };
    }
    let (density, bytes) = best.context("no density was tried")?;
    Ok((Case::at_density(kind, libm::exp(density) as f32), bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmark::harness::measurement::build;
    use crate::scene::paper::fig2;

    #[test]
    fn a_grid_can_have_the_size_of_another() {
        let model = fig2();
        let kind = IndexKind::GridHierarchy;
        for density in [0.5, 1.0, 3.0] {
            let other = build(&model, &Case::at_density(kind, density), &[]).unwrap().bytes();
            let triangle_bytes = size_of_val(model.triangles.as_slice());
            let (case, bytes) = grid_of_bytes(kind, &model, other - triangle_bytes).unwrap();
            assert_eq!(bytes + triangle_bytes, build(&model, &case, &[]).unwrap().bytes());
            // The search ends within a tenth of the tolerance, not at the very density.
            let wanted = (other - triangle_bytes) as f64;
            let off = (bytes as f64 - wanted).abs() / wanted;
            assert!(off <= TOLERANCE, "at {density}: {} is {off} off", case.setting);
        }
    }
}
