//! Turning number: how often the direction of an outline goes round.
//!
//! It is 1 for every polygon that does not cross itself (Hopf's Umlaufsatz). A polygon that winds twice around
//! a part of the plane may well have ears, but their triangles would overlap.

use super::{Point, turn};

/// Counts the turns of a counterclockwise outline. Returns `None` if the outline turns back upon itself
/// somewhere, which is half a turn to either side.
pub(super) fn number(points: &[Point]) -> Option<i64> {
    // 1. Corners without a neighbour beside them, round to the first two again.
    let mut corners: Vec<Point> = points.to_vec();
    corners.dedup();
    while corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    let count = corners.len();
    let corner = |at: usize| corners[at % count];
    // 2. Each passage of the direction over that of the x axis, counterclockwise or back.
    let mut turns = 0;
    for at in 0..count {
        let [a, b, c] = [corner(at), corner(at + 1), corner(at + 2)];
        let side = turn(a, b, c);
        match (is_upper(a, b), is_upper(b, c)) {
            (false, true) if side > 0.0 => turns += 1,
            (true, false) if side < 0.0 => turns -= 1,
            (true, false) | (false, true) if side == 0.0 => return None,
            _ => {}
        }
    }
    Some(turns)
}

/// Tells whether a direction is that of the x axis, or less than half a turn past it.
fn is_upper(from: Point, to: Point) -> bool {
    to.y > from.y || (to.y == from.y && to.x > from.x)
}
