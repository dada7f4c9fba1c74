//! Loss of precision when a file's coordinates are rounded to `f32`.
//!
//! An `f32` has 24 bits: near 4,649,776.1 neighbours are half a unit apart, and a wall of 10 cm is either
//! gone or five times as thick. The loss is compared with the edges, so a model in millimetres and one in
//! light years are judged alike.

use super::Surface;
use super::origin::{Origin, Written};

/// Losses up to this share of the median edge pass without a word: far below what the eye sees and what
/// surveys measure, and far above what decimals lose in files of usual extent (a part in ten million).
const TOLERATED_SHARE: f64 = 1e-4;

/// Distances by which rounding moves the vertices that faces use.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Loss {
    /// Vertices of which a coordinate moves farther than is tolerated.
    moved: usize,
    vertices: usize,
    farthest: f64,
}

/// Describes the loss by rounding, and the cure; `None` if the loss is tolerated.
pub(super) fn warning(surface: &Surface, origin: [f64; 3]) -> Option<String> {
    // 1. Most files lose next to nothing, and need no median.
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
    // 2. The loss that would be left with the automatic origin.
    let better = Origin::Automatic.point(of(surface, &used));
    let cured = loss(surface, &used, better, tolerated);
    let cure = if cured.moved == 0 {
        format!("`--origin auto`, or `--origin {}`, keeps them apart", Written(better))
    } else if cured.farthest < 0.5 * now.farthest {
        format!(
            "`--origin auto` or `--origin {}` leaves {} vertices moved by up to {:.2e}",
            Written(better),
            cured.moved,
            cured.farthest
        )
    } else {
        "no `--origin` helps: the scene is too large for its edges".into()
    };
    Some(format!(
        "rounded to 32 bits, {} of {} vertices move by up to {:.2e}, {:.2}% of the median edge \
         ({median:.3e}); {cure}",
        now.moved,
        now.vertices,
        now.farthest,
        now.farthest / median * 100.0,
    ))
}

fn used_vertices(surface: &Surface) -> Vec<bool> {
    let mut used = vec![false; surface.positions.len()];
    for &corner in &surface.corners {
        used[corner as usize] = true;
    }
    used
}

fn of<'s>(surface: &'s Surface, used: &'s [bool]) -> impl Iterator<Item = &'s [f64; 3]> {
    surface.positions.iter().zip(used).filter(|(_, used)| **used).map(|(position, _)| position)
}

fn loss(surface: &Surface, used: &[bool], origin: [f64; 3], tolerated: f64) -> Loss {
    let mut loss = Loss { moved: 0, vertices: 0, farthest: 0.0 };
    for position in of(surface, used) {
        let mut farthest = 0.0_f64;
        for axis in 0..3 {
            let exact = position[axis] - origin[axis];
            farthest = farthest.max((exact - f64::from(exact as f32)).abs());
        }
        // `Surface::place` warns of vertices that are not finite.
        if farthest.is_finite() {
            loss.vertices += 1;
            loss.moved += usize::from(farthest > tolerated);
            loss.farthest = loss.farthest.max(farthest);
        }
    }
    loss
}

/// The median length of the edges that have one.
fn median_edge(surface: &Surface) -> Option<f64> {
    // As f32: the length needs no more digits, and there are millions.
    let mut lengths: Vec<f32> = Vec::with_capacity(surface.corners.len());
    for face in surface.faces() {
        let mut before = surface.positions[face[face.len() - 1] as usize];
        for &corner in face {
            let here = surface.positions[corner as usize];
            let squares = [0, 1, 2].map(|axis| (here[axis] - before[axis]).powi(2));
            let length = (squares[0] + squares[1] + squares[2]).sqrt() as f32;
            if length > 0.0 && length.is_finite() {
                lengths.push(length);
            }
            before = here;
        }
    }
    let middle = lengths.len() / 2;
    if lengths.is_empty() {
        return None;
    }
    let (_, median, _) = lengths.select_nth_unstable_by(middle, f32::total_cmp);
    Some(f64::from(*median))
}
