//! Loss of precision in a scene of several files, which are never in memory together.
//!
//! The lengths of edges and the displacements of vertices are counted by their size, in steps of a thousandth. So the
//! median edge, and the number of vertices that move farther than is tolerated, are known to a thousandth. The largest
//! displacement is exact.

use super::origin::Written;
use super::precision::{
    NO_CURE, TOLERATED_SHARE, displacement, for_each_edge, of, used_vertices, warning_of,
    whole_cure,
};
use super::{Extent, Surface};

/// Loss by rounding in the files of a scene.
#[derive(Debug, Default)]
pub(in crate::scene) struct RoundingLoss {
    edges: Histogram,
    displacements: Histogram,
    /// Finite vertices of faces.
    vertices: u64,
    /// Largest displacement of a coordinate.
    farthest: f64,
    extent: Extent,
}

impl RoundingLoss {
    /// Adds a file. The point is subtracted before rounding.
    pub fn add(&mut self, surface: &Surface, origin: [f64; 3]) {
        for_each_edge(surface, |length| self.edges.add(length));
        for position in of(surface, &used_vertices(surface)) {
            self.extent.add(position);
            let farthest = displacement(position, origin);
            if farthest.is_finite() {
                self.vertices += 1;
                self.displacements.add(farthest as f32);
                self.farthest = self.farthest.max(farthest);
            }
        }
    }

    /// Writes a warning that describes the loss and the remedy; `None` if the loss is tolerated.
    pub fn warning(&self) -> Option<String> {
        if self.farthest == 0.0 {
            return None;
        }
        let median = self.edges.median()?;
        let tolerated = median * TOLERATED_SHARE;
        let moved = self.displacements.count_above(tolerated);
        if self.farthest <= tolerated || moved == 0 {
            return None;
        }
        // An f32 differs from the number that it is rounded from by at most one part in 2^24.
        let better = self.extent.middle();
        let most = self.extent.farthest_from(better) / f64::from(1 << 24);
        let cure = if most <= tolerated {
            whole_cure(better)
        } else if most < 0.5 * self.farthest {
            format!(
                "with `--origin auto` or `--origin {}` they move by at most {most:.2e}",
                Written(better)
            )
        } else {
            NO_CURE.into()
        };
        let moved = format_args!("about {moved} of {}", self.vertices);
        Some(warning_of(moved, self.farthest, median, &cure))
    }
}

/// Numbers of values by size: numbers of one bin have the same upper bits.
#[derive(Debug)]
struct Histogram(Vec<u64>);

/// Bits of an `f32` that do not tell bins apart: ten bits of the mantissa do.
const LOWER_BITS: u32 = 13;

impl Default for Histogram {
    fn default() -> Self {
        Self(vec![0; 1 << (u32::BITS - 1 - LOWER_BITS)])
    }
}

impl Histogram {
    /// Adds a value that is not negative.
    fn add(&mut self, value: f32) {
        self.0[(value.abs().to_bits() >> LOWER_BITS) as usize] += 1;
    }

    /// Least value of a bin.
    fn least(bin: usize) -> f64 {
        f64::from(f32::from_bits((bin as u32) << LOWER_BITS))
    }

    /// Computes the median, rounded down to the least value of its bin; `None` without values.
    fn median(&self) -> Option<f64> {
        let count: u64 = self.0.iter().sum();
        let mut above = 0;
        let bin = self.0.iter().position(|&values| {
            above += values;
            above > count / 2
        })?;
        Some(Self::least(bin))
    }

    /// Counts the values in the bins above that of a value, which are larger.
    fn count_above(&self, value: f64) -> u64 {
        let bin = (value as f32).to_bits() >> LOWER_BITS;
        self.0.iter().skip(bin as usize + 1).sum()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::formats::obj;

    fn surface(text: &str) -> Surface {
        let none = |_: &Path| Err(std::io::ErrorKind::NotFound.into());
        obj::read(text.as_bytes(), Path::new("a.obj"), &none).unwrap()
    }

    #[test]
    fn it_sees_all_files_together() {
        let near = surface("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        let far = surface("v 4649776.1 0 0\nv 4649777.1 0 0\nv 4649776.1 1 0\nf 1 2 3\n");
        let mut loss = RoundingLoss::default();
        loss.add(&near, [0.0; 3]);
        assert_eq!(loss.warning(), None, "whole numbers are exact");
        loss.add(&far, [0.0; 3]);
        let warning = loss.warning().unwrap();
        assert!(warning.contains("about 3 of 6 vertices move by up to 1.00e-1"), "{warning}");
        assert!(warning.contains("no `--origin` helps"), "{warning}");

        let mut alone = RoundingLoss::default();
        alone.add(&far, [0.0; 3]);
        let warning = alone.warning().unwrap();
        assert!(warning.contains("`--origin auto`, or `--origin 4649776"), "{warning}");
        assert!(warning.contains("(1.000e0)"), "{warning}");
        let mut cured = RoundingLoss::default();
        cured.add(&far, [4_649_776.0, 0.0, 0.0]);
        assert_eq!(cured.warning(), None);
    }
}
