//! Tests of divisions: areas, coverage, work.

use super::*;

type Outline = Vec<[i32; 2]>;

/// Letter of area 10; the fan from its first corner has 19.
const LETTER_U: [[i32; 2]; 8] = [[0, 0], [4, 0], [4, 4], [3, 4], [3, 1], [1, 1], [1, 4], [0, 4]];
/// Dart of area 6; the fan from two of its corners has 10.
const DART: [[i32; 2]; 4] = [[0, 0], [4, 2], [0, 4], [1, 2]];

/// Lists maps to six planes: across each axis, in both orientations. Each map keeps areas.
fn lifts() -> [fn([i32; 2]) -> Vec3; 6] {
    [
        |[x, y]| Vec3::new(x as f32, y as f32, 1.0),
        |[x, y]| Vec3::new(-1.0, x as f32, y as f32),
        |[x, y]| Vec3::new(y as f32, 2.0, x as f32),
        |[x, y]| Vec3::new(y as f32, x as f32, 1.0),
        |[x, y]| Vec3::new(-1.0, y as f32, x as f32),
        |[x, y]| Vec3::new(x as f32, 2.0, y as f32),
    ]
}

fn twice_area([a, b, c]: [[i32; 2]; 3]) -> i64 {
    let [ax, ay, bx, by, cx, cy] = [a[0], a[1], b[0], b[1], c[0], c[1]].map(i64::from);
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

/// Divides an outline and checks that its triangles have its orientation and, together, its area.
fn divide(outline: &[[i32; 2]], lift: fn([i32; 2]) -> Vec3) -> Vec<[usize; 3]> {
    let corners: Vec<Vec3> = outline.iter().map(|&corner| lift(corner)).collect();
    let mut divider = Divider::default();
    let (triangles, division) = divider.divide(&corners);
    assert_eq!(division, PolygonDivision::Covering, "{outline:?}");
    assert_eq!(triangles.len(), outline.len() - 2);
    let all: i64 =
        (2..outline.len()).map(|at| twice_area([outline[0], outline[at - 1], outline[at]])).sum();
    let parts = triangles.iter().map(|ids| twice_area(ids.map(|id| outline[id])));
    let mut sum = 0;
    for part in parts {
        assert!(part * all.signum() >= 0, "{outline:?} {triangles:?}");
        sum += part;
    }
    assert_eq!(sum, all);
    triangles.to_vec()
}

fn is_crossing(outline: &[[i32; 2]]) -> bool {
    let corners: Vec<Vec3> = outline.iter().map(|&corner| lifts()[0](corner)).collect();
    let mut divider = Divider::default();
    let (triangles, division) = divider.divide(&corners);
    let fan: Vec<_> = (2..outline.len()).map(|at| [0, at - 1, at]).collect();
    assert!(division == PolygonDivision::Covering || triangles == fan);
    division == PolygonDivision::Crossing
}

/// Calls `check` with the outline begun at every corner, in every plane, and reversed.
fn in_all_ways(outline: &[[i32; 2]], check: impl Fn(&[[i32; 2]], fn([i32; 2]) -> Vec3)) {
    for start in 0..outline.len() {
        let mut turned = outline.to_vec();
        turned.rotate_left(start);
        for lift in lifts() {
            check(&turned, lift);
        }
        turned.reverse();
        check(&turned, lifts()[0]);
    }
}

#[test]
fn concave_polygons_have_their_area_from_every_corner() {
    for (outline, twice) in [(&LETTER_U[..], 20), (&DART[..], 12)] {
        in_all_ways(outline, |outline, lift| {
            let triangles = divide(outline, lift);
            let parts: i64 =
                triangles.iter().map(|ids| twice_area(ids.map(|id| outline[id])).abs()).sum();
            assert_eq!(parts, twice);
        });
    }
}

#[test]
fn convex_polygons_keep_their_fan() {
    // The second polygon has corners on its sides; the third has corners twice.
    let outlines: [&[[i32; 2]]; 4] = [
        &[[0, 0], [2, 0], [2, 2], [0, 2]],
        &[[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]],
        &[[0, 0], [2, 0], [2, 0], [2, 2], [2, 2], [0, 2], [0, 0]],
        &[[1, 0], [5, 0], [7, 2], [7, 6], [4, 9], [1, 9], [0, 4]],
    ];
    for outline in outlines {
        in_all_ways(outline, |outline, lift| {
            let fan: Vec<_> = (2..outline.len()).map(|at| [0, at - 1, at]).collect();
            assert_eq!(divide(outline, lift), fan, "{outline:?}");
        });
    }
}

#[test]
fn outlines_that_touch_themselves() {
    let outlines: [&[[i32; 2]]; 6] = [
        // A square with a square hole, joined by an edge there and back.
        &[[0, 0], [6, 0], [6, 6], [0, 6], [0, 0], [2, 2], [2, 4], [4, 4], [4, 2], [2, 2]],
        // Two holes joined to one corner.
        &[
            [0, 0],
            [9, 0],
            [9, 9],
            [0, 9],
            [0, 0],
            [1, 2],
            [1, 3],
            [2, 3],
            [1, 2],
            [0, 0],
            [3, 1],
            [3, 2],
            [4, 2],
            [3, 1],
        ],
        // Spikes outwards and inwards, then corners three times, then corners on a line.
        &[[0, 0], [8, 0], [8, 4], [12, 4], [8, 4], [8, 8], [0, 8], [0, 4], [4, 4], [0, 4]],
        &[[0, 0], [4, 0], [4, 0], [4, 0], [4, 4], [2, 4], [2, 1], [2, 4], [0, 4], [0, 2]],
        &[[0, 0], [2, 0], [4, 0], [4, 4], [3, 4], [3, 2], [2, 2], [1, 2], [1, 4], [0, 4]],
        // Two squares that meet at a corner.
        &[[0, 0], [2, 0], [2, 2], [4, 2], [4, 4], [2, 4], [2, 2], [0, 2]],
    ];
    for outline in outlines {
        in_all_ways(outline, |outline, lift| drop(divide(outline, lift)));
    }
}

#[test]
fn outlines_that_cross_themselves_are_fanned() {
    let star = [0, 2, 4, 1, 3].map(|at| [[0, 9], [-9, 2], [-6, -8], [6, -8], [9, 2]][at]);
    let bow_tie = [[0, 0], [2, 2], [2, 0], [0, 2]];
    let uneven = [[0, 0], [4, 4], [4, 0], [0, 2]];
    // The coil winds twice around its middle and has ears, so only the turning number shows that it crosses itself.
    let coil = [[0, 0], [6, 0], [6, 6], [0, 6], [0, 1], [5, 1], [5, 5], [1, 5]];
    for outline in [&star[..], &bow_tie, &uneven, &coil] {
        in_all_ways(outline, |outline, _| assert!(is_crossing(outline), "{outline:?}"));
    }
    // Outlines without area are covered by triangles without area.
    assert!(!is_crossing(&[[0, 0], [3, 3], [1, 1], [2, 2]]));
    assert!(!is_crossing(&[[1, 1]; 5]));
}

#[test]
fn triangles_cover_each_point_once() {
    // Star-shaped polygons: corners in order of their angle, at random distances from the centre.
    for seed in 0..200_u64 {
        let mut state = seed;
        let mut draw = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        let count = 5 + (seed % 30) as usize;
        let outline: Outline = (0..count)
            .map(|at| {
                let (angle, radius) =
                    (at as f64 * std::f64::consts::TAU / count as f64, 5.0 + 95.0 * draw());
                [(angle.cos() * radius) as i32, (angle.sin() * radius) as i32]
            })
            .collect();
        in_all_ways(&outline, |outline, lift| drop(divide(outline, lift)));
    }
}

/// Makes a comb with upright teeth.
fn comb(teeth: i32) -> Outline {
    let mut outline = vec![[0, -1]];
    for tooth in 0..teeth {
        let x = tooth * 2;
        outline.extend([[x, 0], [x, 5_000], [x + 1, 5_000], [x + 1, 0]]);
    }
    outline.push([teeth * 2 - 1, -1]);
    outline
}

/// Makes a band rolled up around a point.
fn spiral(corners: i32) -> Outline {
    let at = |turn: f64, radius: f64| {
        let angle = turn * std::f64::consts::TAU;
        [(angle.cos() * radius) as i32, (angle.sin() * radius) as i32]
    };
    let side = |width: f64| {
        (0..corners / 2).map(move |step| {
            let turn = f64::from(step) / 200.0;
            at(turn, 20_000.0 + turn * 30_000.0 + width)
        })
    };
    let mut outline: Outline = side(15_000.0).collect();
    let mut inner: Outline = side(0.0).collect();
    inner.reverse();
    outline.extend(inner);
    outline
}

#[test]
fn many_corners_take_little_work() {
    for (outline, most_steps) in [(comb(15_000), 128), (spiral(60_000), 128)] {
        assert!(outline.len() >= 60_000);
        for start in [0, 1, 2, outline.len() / 2] {
            let mut outline = outline.clone();
            outline.rotate_left(start);
            let corners: Vec<Vec3> = outline.iter().map(|&corner| lifts()[1](corner)).collect();
            divide(&outline, lifts()[1]);
            let mut divider = Divider::default();
            divider.divide(&corners);
            let steps = divider.ears.work / outline.len() as u64;
            assert!(steps < most_steps, "{steps} steps a corner");
        }
    }
}

#[test]
fn knots_end() {
    // Each side crosses nearly all others.
    let knot: Outline =
        (0..20_001).map(|at| [(at * 7_919) % 20_011, (at * at % 20_011 * 13) % 20_011]).collect();
    let corners: Vec<Vec3> = knot.iter().map(|&corner| lifts()[0](corner)).collect();
    let mut divider = Divider::default();
    assert_eq!(divider.divide(&corners).1, PolygonDivision::Crossing);
    let work = divider.ears.work;
    // The limit is checked after a round over all corners, which may exceed it.
    assert!(work < 2 * ears::WORK * 20_001, "{work}");
}
