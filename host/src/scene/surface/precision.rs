//! Loss of precision when a file's coordinates are rounded to `f32`.
//!
//! An `f32` has 24 bits. Near 4,649,776.1, neighbouring values are half a unit apart, so a wall of 10 cm either
//! vanishes or becomes five times as thick. The loss is measured relative to the median edge, so the unit of the file
//! does not matter.

use std::fmt;

use super::origin::Written;
use super::{Extent, Surface};

/// Largest loss without a warning, as a share of the median edge. It is far below what the eye sees and what surveys
/// measure, and far above the loss of decimals in files of usual extent, one part in ten million.
pub(super) const TOLERATED_SHARE: f64 = 1e-4;

/// Displacement of the vertices of faces by rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Loss {
    /// Vertices with a coordinate that moves farther than is tolerated.
    moved: usize,
    /// Finite vertices.
    vertices: usize,
    /// Largest displacement of a coordinate.
    farthest: f64,
}

/// Writes a warning that describes the loss by rounding and the remedy; `None` if the loss is tolerated.
pub(super) fn warning(surface: &Surface, origin: [f64; 3]) -> Option<String> {
    // 1. The loss. Files whose coordinates are exact in f32 return before the median is computed.
    let used = used_vertices(surface);
    if loss(surface, &used, origin, 0.0).farthest == 0.0 {
        return None;
    }
    let median = median_edge(surface)?;
    let tolerated = median * TOLERATED_SHARE;
    let now = loss(surface, &used, origin, tolerated);
    if now.moved == 0 {
        return None;
    }
    // 2. The loss that remains with the automatic origin.
    let better = Extent::of(of(surface, &used)).middle();
    let cured = loss(surface, &used, better, tolerated);
    let cure = if cured.moved == 0 {
        whole_cure(better)
    } else if cured.farthest < 0.5 * now.farthest {
        format!(
            "`--origin auto` or `--origin {}` leaves {} vertices moved by up to {:.2e}",
            Written(better),
            cured.moved,
            cured.farthest
        )
    } else {
        NO_CURE.into()
    };
    let moved = format_args!("{} of {}", now.moved, now.vertices);
    Some(warning_of(moved, now.farthest, median, &cure))
}

/// Remedy that loses nothing: another origin.
pub(super) fn whole_cure(origin: [f64; 3]) -> String {
    format!("`--origin auto`, or `--origin {}`, keeps them apart", Written(origin))
}

/// What is said where there is no remedy.
pub(super) const NO_CURE: &str = "no `--origin` helps: the scene is too large for its edges";

/// Describes a loss: how many vertices move, by how much, and the remedy.
pub(super) fn warning_of(
    moved: fmt::Arguments<'_>,
    farthest: f64,
    median: f64,
    cure: &str,
) -> String {
    let share = farthest / median * 100.0;
    format!(
        "rounded to 32 bits, {moved} vertices move by up to {farthest:.2e}, {share:.2}% of the median edge \
         ({median:.3e}); {cure}"
    )
}

pub(super) fn used_vertices(surface: &Surface) -> Vec<bool> {
    let mut used = vec![false; surface.positions.len()];
    for &corner in &surface.corners {
        used[corner as usize] = true;
    }
    used
}

pub(super) fn of<'s>(surface: &'s Surface, used: &'s [bool]) -> impl Iterator<Item = &'s [f64; 3]> {
    surface.positions.iter().zip(used).filter(|(_, used)| **used).map(|(position, _)| position)
}

fn loss(surface: &Surface, used: &[bool], origin: [f64; 3], tolerated: f64) -> Loss {
    let mut loss = Loss { moved: 0, vertices: 0, farthest: 0.0 };
    for position in of(surface, used) {
        let farthest = displacement(position, origin);
        // Vertices that are not finite are left to `Surface::place`, which warns of them.
        if farthest.is_finite() {
            loss.vertices += 1;
            loss.moved += usize::from(farthest > tolerated);
            loss.farthest = loss.farthest.max(farthest);
        }
    }
    loss
}

/// Computes the largest displacement of a vertex along an axis by rounding.
pub(super) fn displacement(position: &[f64; 3], origin: [f64; 3]) -> f64 {
    let of_axis = |axis: usize| {
        let exact = position[axis] - origin[axis];
        (exact - f64::from(exact as f32)).abs()
    };
    (0..3).map(of_axis).fold(0.0, f64::max)
}

/// Computes the median length of the edges of positive, finite length.
fn median_edge(surface: &Surface) -> Option<f64> {
    // Stored as f32, because there are millions of lengths and the median needs few digits.
    let mut lengths: Vec<f32> = Vec::with_capacity(surface.corners.len());
    for_each_edge(surface, |length| lengths.push(length));
    let middle = lengths.len() / 2;
    if lengths.is_empty() {
        return None;
    }
    let (_, median, _) = lengths.select_nth_unstable_by(middle, f32::total_cmp);
    Some(f64::from(*median))
}

/// Calls `take` with the length of each edge of positive, finite length.
pub(super) fn for_each_edge(surface: &Surface, mut take: impl FnMut(f32)) {
    for face in surface.faces() {
        let mut before = surface.positions[face[face.len() - 1] as usize];
        for &corner in face {
            let here = surface.positions[corner as usize];
            let squares = [0, 1, 2].map(|axis| (here[axis] - before[axis]).powi(2));
            let length = (squares[0] + squares[1] + squares[2]).sqrt() as f32;
            if length > 0.0 && length.is_finite() {
                take(length);
            }
            before = here;
        }
    }
}
