//! Origin: the point of a file that becomes (0, 0, 0).

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

/// Point that is subtracted from all coordinates, in `f64`, before they are rounded to `f32`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Origin {
    /// The file's own origin: nothing is subtracted.
    #[default]
    Unchanged,
    /// The given point.
    At([f64; 3]),
    /// The centre of the scene's bounding box, rounded to few digits.
    Automatic,
}

/// Error of a text that is not an origin.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("`{0}` is not an origin; give three finite numbers, as in 500000,4649776,0, or auto")]
pub struct NotAnOrigin(String);

impl FromStr for Origin {
    type Err = NotAnOrigin;

    fn from_str(text: &str) -> Result<Self, NotAnOrigin> {
        if text == "auto" {
            return Ok(Self::Automatic);
        }
        let numbers: Result<Vec<f64>, _> =
            text.split(',').map(|part| part.trim().parse::<f64>()).collect();
        match numbers.as_deref() {
            Ok(&[x, y, z]) if [x, y, z].iter().all(|number| number.is_finite()) => {
                Ok(Self::At([x, y, z]))
            }
            _ => Err(NotAnOrigin(text.into())),
        }
    }
}

impl Origin {
    /// Computes the point for vertices, whose extent is asked for only if it matters.
    pub(in crate::scene) fn point(self, extent: impl FnOnce() -> Extent) -> [f64; 3] {
        match self {
            Self::Unchanged => [0.0; 3],
            Self::At(point) => point,
            Self::Automatic => extent().middle(),
        }
    }

    /// Logs the point that was subtracted from the coordinates of a scene; `owner` is whose they are. Nothing is said if
    /// none was asked for.
    pub(in crate::scene) fn log(self, scene: impl fmt::Display, [x, y, z]: [f64; 3], owner: &str) {
        if self != Self::Unchanged {
            log::info!(
                "{scene}: origin {x},{y},{z} subtracted; add it to printed positions to get {owner} coordinates"
            );
        }
    }
}

/// Bounding box of points within the range of `f32`; others are ignored.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Extent {
    lo: [f64; 3],
    hi: [f64; 3],
}

impl Default for Extent {
    fn default() -> Self {
        Self { lo: [f64::INFINITY; 3], hi: [f64::NEG_INFINITY; 3] }
    }
}

impl Extent {
    /// The box of some points.
    pub fn of<'p>(positions: impl Iterator<Item = &'p [f64; 3]>) -> Self {
        let mut extent = Self::default();
        positions.for_each(|position| extent.add(position));
        extent
    }

    /// Adds a point.
    pub fn add(&mut self, position: &[f64; 3]) {
        let most = f64::from(f32::MAX);
        if position.iter().all(|x| x.abs() <= most) {
            let sides = self.lo.iter_mut().zip(&mut self.hi);
            for ((lo, hi), &x) in sides.zip(position) {
                *lo = lo.min(x);
                *hi = hi.max(x);
            }
        }
    }

    /// Adds all points of another extent.
    pub fn join(&mut self, other: &Self) {
        self.add(&other.lo);
        self.add(&other.hi);
    }

    /// Computes the centre, rounded to a power of ten of at most a tenth of the longest side, so that it is short to
    /// write.
    pub fn middle(&self) -> [f64; 3] {
        let Self { lo, hi } = *self;
        if lo[0] > hi[0] {
            return [0.0; 3];
        }
        let longest = (0..3).map(|axis| hi[axis] - lo[axis]).fold(0.0, f64::max);
        // Powers of ten up to 10^22 are exact, so the quotient is the f64 nearest to a short decimal. The logarithm is that
        // of `libm`, the same on every machine.
        let digits = if longest > 0.0 {
            (1.0 - libm::log10(longest).floor()).clamp(-22.0, 22.0)
        } else {
            3.0
        };
        let power = (0..digits.abs() as u32).fold(1.0, |power, _| power * 10.0);
        [0, 1, 2].map(|axis| {
            let centre = lo[axis] / 2.0 + hi[axis] / 2.0;
            let rounded = if digits >= 0.0 {
                (centre * power).round() / power
            } else {
                (centre / power).round() * power
            };
            if rounded.is_finite() { rounded } else { centre }
        })
    }

    /// Computes the largest distance of a coordinate from those of a point.
    pub fn farthest_from(&self, point: [f64; 3]) -> f64 {
        let of_axis = |axis: usize| {
            (self.lo[axis] - point[axis]).abs().max((self.hi[axis] - point[axis]).abs())
        };
        (0..3).map(of_axis).fold(0.0, f64::max)
    }
}

/// Point in the notation of the command line.
pub(super) struct Written(pub [f64; 3]);

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "{x},{y},{z}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_read() {
        assert_eq!("auto".parse(), Ok(Origin::Automatic));
        assert_eq!("-1, 2.5,3e6".parse(), Ok(Origin::At([-1.0, 2.5, 3e6])));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,nan", "1,2,1e999", "automatic"] {
            let error = wrong.parse::<Origin>().unwrap_err().to_string();
            assert!(error.starts_with(&format!("`{wrong}` is not an origin")), "{error}");
        }
    }

    #[test]
    fn the_automatic_origin_is_short_and_central() {
        let points =
            [[500_000.13, 4_649_776.22, -3.0], [500_010.33, 4_649_780.0, 1.0], [f64::NAN; 3]];
        let origin = Origin::Automatic.point(|| Extent::of(points.iter()));
        assert_eq!(origin, [500_005.0, 4_649_778.0, -1.0]);
        assert_eq!(Written(origin).to_string(), "500005,4649778,-1");
        assert_eq!(Origin::Automatic.point(|| Extent::of([].iter())), [0.0; 3]);
        // A single point, then a tiny scene far from the origin.
        assert_eq!(
            Origin::Automatic.point(|| Extent::of([[7.25, 0.0, 1e9]].iter())),
            [7.25, 0.0, 1e9]
        );
        let tiny = [[1.0, 0.0, 0.0], [1.000_001, 0.0, 0.0]];
        assert!(
            (Origin::Automatic.point(|| Extent::of(tiny.iter()))[0] - 1.000_000_5).abs() < 2e-7
        );
    }
}
