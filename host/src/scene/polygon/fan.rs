//! A test whether the fan from the first corner covers a polygon.

use super::{Point, turn};

/// Tells whether every point of a counterclockwise polygon lies in exactly one triangle of the fan from
/// its first corner, edges aside.
///
/// True if the other corners go round the first corner in one direction and less than once: every triangle of
/// the fan turns left or has no area, and none reaches the direction in which the first triangle began.
pub(super) fn covers(points: &[Point]) -> bool {
    let apex = points[0];
    // The direction in which the fan begins.
    let Some(&first) = points.iter().find(|&&point| point != apex) else { return true };
    let mut past_half = false;
    for pair in points[1..].windows(2) {
        let area = turn(apex, pair[0], pair[1]);
        if area < 0.0 || (area == 0.0 && are_opposite(apex, pair[0], pair[1])) {
            return false;
        }
        if pair[1] == apex {
            continue;
        }
        let side = turn(apex, first, pair[1]);
        if past_half && side >= 0.0 {
            return false;
        }
        past_half |= side < 0.0;
    }
    true
}

/// Tells whether the apex lies between two points on a line through it. Both products are zero or
/// negative then, so rounding cannot change the sign of their sum.
fn are_opposite(apex: Point, a: Point, b: Point) -> bool {
    (a.x - apex.x) * (b.x - apex.x) + (a.y - apex.y) * (b.y - apex.y) < 0.0
}
