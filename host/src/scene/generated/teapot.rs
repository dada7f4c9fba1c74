//! Teapot: 32 bicubic patches, divided into triangles.
//!
//! The control points are decimal fractions and the parameters are `i / n`, so each corner is a rational number. It is
//! computed in whole numbers and rounded once. Two consequences:
//!
//! - Neighbouring patches share their corners bit for bit, whichever way each patch runs.
//! - Triangles at the poles of lid and bottom have exactly no area.
//!
//! # Source
//! M. Newell, *The Utilization of Procedure Models in Digital Image Synthesis*, 1975, for the control points in
//! `teapot_patches.txt`. Proportions are the usual squat ones. z is up; the bottom is at z = 0.

use arboleda::{Triangle, Vec3};

/// Control points and patches.
const PATCHES: &str = include_str!("teapot_patches.txt");

/// Divisions of a patch that give the paper's teapot of about 5,000 triangles: 5,112.
pub const PAPER_DIVISIONS: u32 = 9;

/// Most divisions: 4 million triangles. The whole numbers stay far below the limits of `i128`.
const MOST_DIVISIONS: u32 = 256;

/// Parts of a unit: control points are multiples of a millionth.
const UNIT: f64 = 1e6;

type WholePoint = [i128; 3];

/// Position, scale and rotation of a teapot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Centre of the bottom.
    pub base: Vec3,
    /// Scale. At 1 a teapot is 3.15 high, 4 wide, and 6.43 long from handle to spout; it lies along x, the spout at
    /// larger x.
    pub scale: f32,
    /// Quarter turns counter-clockwise, seen from above. They are exact; other angles would not be.
    pub quarter_turns: u32,
}

/// Makes a teapot at the origin, each patch in `divisions x divisions` quads (1 to 256).
///
/// Triangles are in the order of the patches; those without area are left out. The bits are the same on every target.
pub fn teapot(divisions: u32) -> Vec<Triangle> {
    let n = i128::from(divisions.clamp(1, MOST_DIVISIONS));
    let mut triangles = Vec::new();
    for patch in patches() {
        let at = |i: i128, j: i128| {
            let curve = [0, 1, 2, 3]
                .map(|row| bezier([0, 1, 2, 3].map(|column| patch[row * 4 + column]), i, n));
            bezier(curve, j, n)
        };
        for i in 0..n {
            for j in 0..n {
                let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                for [a, b, c] in [[0, 1, 2], [0, 2, 3]].map(|corners| corners.map(|at| quad[at])) {
                    if a != b && b != c && c != a {
                        let [a, b, c] = [a, b, c].map(|point| rounded(point, n));
                        triangles.push(Triangle::new(a, b, c));
                    }
                }
            }
        }
    }
    triangles
}

/// Makes a teapot, then turns, scales and moves it.
pub fn teapot_at(divisions: u32, placement: Placement) -> Vec<Triangle> {
    placed(&teapot(divisions), placement)
}

/// Turns, scales and moves triangles.
pub(super) fn placed(triangles: &[Triangle], placement: Placement) -> Vec<Triangle> {
    let at = |point: Vec3| {
        let turned = match placement.quarter_turns % 4 {
            0 => point,
            1 => Vec3::new(-point.y, point.x, point.z),
            2 => Vec3::new(-point.x, -point.y, point.z),
            _ => Vec3::new(point.y, -point.x, point.z),
        };
        placement.base + turned * placement.scale
    };
    triangles.iter().map(|t| Triangle::new(at(t.a), at(t.b), at(t.c))).collect()
}

/// Computes the point of a cubic curve at `i / n`, times `n^3`.
fn bezier(control: [WholePoint; 4], i: i128, n: i128) -> WholePoint {
    let k = n - i;
    let weights = [k * k * k, 3 * k * k * i, 3 * k * i * i, i * i * i];
    [0, 1, 2].map(|axis| (0..4).map(|at| weights[at] * control[at][axis]).sum())
}

/// Rounds a point of a patch, which is still multiplied by `n^3 * n^3 * UNIT`.
fn rounded(point: WholePoint, n: i128) -> Vec3 {
    let scale = n.pow(6) as f64 * UNIT;
    Vec3::from_array(point.map(|coordinate| (coordinate as f64 / scale) as f32))
}

/// Reads the 16 control points of each patch, in millionths.
fn patches() -> Vec<[WholePoint; 16]> {
    let mut points = Vec::new();
    let mut patches = Vec::new();
    for line in PATCHES.lines() {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let mut coordinates =
                    words.map(|word| (word.parse::<f64>().unwrap_or(0.0) * UNIT).round() as i128);
                points.push([0; 3].map(|_| coordinates.next().unwrap_or(0)));
            }
            Some("p") => {
                let mut corners = words.map(|word| word.parse::<usize>().unwrap_or(0));
                patches.push([0; 16].map(|_| points[corners.next().unwrap_or(0)]));
            }
            _ => {}
        }
    }
    patches
}

#[cfg(test)]
mod tests {
    use super::*;
    use arboleda::Aabb;

    #[test]
    fn the_data_are_complete() {
        for line in PATCHES.lines() {
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let (count, numbers) = match words[0] {
                "v" => (3, words[1..].iter().all(|word| word.parse::<f64>().is_ok())),
                "p" => (16, words[1..].iter().all(|word| word.parse::<usize>().is_ok())),
                _ => (words.len() - 1, line.starts_with('#')),
            };
            assert!(numbers && words.len() == count + 1, "{line}");
        }
        assert_eq!(patches().len(), 32);
    }

    #[test]
    fn the_papers_teapot() {
        let triangles = teapot(PAPER_DIVISIONS);
        assert_eq!(triangles.len(), 5_112);
        assert!(triangles.iter().all(|t| t.is_finite() && t.normal() != Vec3::ZERO));
        let bounds = triangles.iter().fold(Aabb::EMPTY, |all, t| all.union(t.bounds()));
        assert_eq!((bounds.lo.z, bounds.hi.z), (0.0, 3.15));
        assert_eq!((bounds.lo.y, bounds.hi.y), (-2.0, 2.0));
        assert!(bounds.extent()[0] > 6.4 && bounds.extent()[0] < 6.44);
    }

    #[test]
    fn the_teapot_is_symmetric_but_for_handle_and_spout() {
        use std::collections::HashSet;
        let n = 3;
        let bits = |point: Vec3| point.to_array().map(|x| (x + 0.0).to_bits());
        let corners = |triangles: &[Triangle], mirror: Vec3| -> HashSet<[u32; 3]> {
            triangles.iter().flat_map(|t| [t.a, t.b, t.c]).map(|p| bits(p * mirror)).collect()
        };
        let (across, along) = (Vec3::new(1.0, -1.0, 1.0), Vec3::new(-1.0, 1.0, 1.0));
        let all = teapot(n);
        assert_eq!(corners(&all, Vec3::ONE), corners(&all, across));
        // Patches 12 to 19 are the handle and the spout.
        let quads = (n * n * 2) as usize;
        let round = [&all[..12 * quads], &all[20 * quads..]].concat();
        assert_eq!(corners(&round, Vec3::ONE), corners(&round, along));
        assert!(all[12 * quads..16 * quads].iter().all(|t| t.a.x < -1.4));
        assert!(all[16 * quads..20 * quads].iter().all(|t| t.a.x > 1.6));
    }

    #[test]
    fn counts_follow_the_divisions() {
        // Eight patches have a pole, at which each of n quads has one triangle without area.
        for n in [1, 2, 5, 20] {
            assert_eq!(teapot(n).len() as u32, 64 * n * n - 8 * n);
        }
        assert_eq!(teapot(0).len(), teapot(1).len());
    }

    #[test]
    fn neighbouring_patches_share_corners() {
        // The body is a closed ring: only its upper and lower edges belong to one triangle. Edges are compared by bits.
        let body: Vec<Triangle> = teapot(4).into_iter().skip(4 * 32).take(8 * 32).collect();
        let mut ends = std::collections::HashMap::new();
        let bits = |point: Vec3| point.to_array().map(|x| (x + 0.0).to_bits());
        for t in &body {
            let [a, b, c] = [t.a, t.b, t.c].map(bits);
            for (p, q) in [(a, b), (b, c), (c, a)] {
                *ends.entry((p.min(q), p.max(q))).or_insert(0) += 1;
            }
        }
        // 4 patches of 4 quads at the upper end and as many at the lower end.
        assert_eq!(ends.values().filter(|&&times| times == 1).count(), 32);
    }

    #[test]
    fn placing_turns_scales_and_moves() {
        let base = Vec3::new(10.0, 20.0, 30.0);
        let turned = |quarter_turns| {
            teapot_at(3, Placement { base, scale: 2.0, quarter_turns })
                .iter()
                .fold(Aabb::EMPTY, |all, t| all.union(t.bounds()))
        };
        assert_eq!(turned(0).lo.z, 30.0);
        assert!(turned(0).hi.x > 16.0 && turned(1).hi.y > 26.0);
        assert!(turned(2).lo.x < 4.0 && turned(3).lo.y < 14.0);
        assert_eq!(turned(4), turned(0));
    }
}
