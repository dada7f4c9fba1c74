//! Test of the fan from a polygon's first corner.

use super::{Point, turn};

/// Tells whether every point of a counter-clockwise polygon, except on edges, lies in exactly one triangle of the fan
/// from the first corner.
///
/// True if the directions from the first corner to the others turn left only, and by less than a full turn: every
/// triangle of the fan is counter-clockwise or without area, and none reaches the direction of the first edge again.
pub(super) fn covers(points: &[Point]) -> bool {
    let apex = points[0];
    // The fan begins in the direction from `apex` to `first`.
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

/// Tells whether the apex lies between two points that are collinear with it. Both products are then zero or negative,
/// so rounding cannot change the sign of their sum.
fn are_opposite(apex: Point, a: Point, b: Point) -> bool {
    (a.x - apex.x) * (b.x - apex.x) + (a.y - apex.y) * (b.y - apex.y) < 0.0
}
