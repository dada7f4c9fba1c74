//! Oracle of polygons with whole coordinates: tells whether they are simple, by comparing all sides, and computes
//! areas.

/// Corner of a polygon.
pub type Point = [i64; 2];

/// Computes twice the signed area of a triangle, positive for counter-clockwise.
fn turn([ax, ay]: Point, [bx, by]: Point, [cx, cy]: Point) -> i64 {
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

/// Computes twice the signed area of a polygon, positive for counter-clockwise.
pub fn doubled_area(corners: &[Point]) -> i64 {
    (2..corners.len()).map(|at| turn(corners[0], corners[at - 1], corners[at])).sum()
}

/// Tells whether a polygon is simple: whether sides meet only in the corners that neighbours share.
pub fn is_simple(corners: &[Point]) -> bool {
    let count = corners.len();
    let side = |at: usize| [corners[at % count], corners[(at + 1) % count]];
    (0..count).all(|first| {
        let [p, q] = side(first);
        let [_, after] = side(first + 1);
        let turns_back = turn(p, q, after) == 0 && !is_between(p, q, after);
        let meets_none = (first + 2..count)
            .filter(|second| (second + 1) % count != first)
            .all(|second| !meet([p, q], side(second)));
        p != q && !turns_back && meets_none
    })
}

/// Makes most polygons simple: reverses the part of the polygon between two sides that meet, until no sides meet or
/// `most` parts were reversed. Each reversal shortens the polygon.
pub fn untangle(corners: &mut [Point], most: usize) {
    for _ in 0..most {
        let count = corners.len();
        let side = |at: usize| [corners[at], corners[(at + 1) % count]];
        let mut pairs = (0..count).flat_map(|p| (p + 2..count).map(move |q| (p, q)));
        let neighbours = |p: usize, q: usize| (q + 1) % count == p;
        let found = pairs.find(|&(p, q)| !neighbours(p, q) && meet(side(p), side(q)));
        let Some((first, second)) = found else { return };
        corners[first + 1..=second].reverse();
    }
}

/// Tells whether the middle one of three collinear points lies strictly between the others.
fn is_between(p: Point, middle: Point, q: Point) -> bool {
    (0..2).map(|axis| (middle[axis] - p[axis]) * (q[axis] - middle[axis])).sum::<i64>() > 0
}

/// Tells whether two sides have a point in common.
fn meet([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let overlap = (0..2).all(|axis| {
        let span = |p: Point, q: Point| (p[axis].min(q[axis]), p[axis].max(q[axis]));
        let ((from, to), (begin, end)) = (span(a, b), span(c, d));
        from <= end && begin <= to
    });
    let part = |p: Point, q: Point, r: Point, s: Point| {
        turn(p, q, r).signum() * turn(p, q, s).signum() <= 0
    };
    overlap && part(a, b, c, d) && part(c, d, a, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn untangles_a_crossing() {
        let mut corners = [[0, 0], [2, 2], [2, 0], [0, 2]];
        untangle(&mut corners, 9);
        assert!(is_simple(&corners), "{corners:?}");
    }

    #[test]
    fn tells_simple_polygons_from_others() {
        let comb = [[0, 0], [4, 0], [4, 4], [3, 4], [3, 1], [1, 1], [1, 4], [0, 4]];
        assert!(is_simple(&comb));
        assert_eq!(doubled_area(&comb), 20);
        for other in [
            &[[0, 0], [2, 2], [2, 0], [0, 2]][..],     // crosses itself
            &[[0, 0], [4, 0], [4, 4], [2, 0]],         // touches a side with a corner
            &[[0, 0], [4, 0], [2, 0], [2, 4]],         // turns back
            &[[0, 0], [4, 0], [4, 0], [2, 4]],         // has a side without length
            &[[0, 0], [1, 1], [2, 0], [1, 1], [1, 5]], // passes a corner twice
        ] {
            assert!(!is_simple(other), "{other:?}");
        }
    }
}
