//! Kernels: weights of photons by their distance from the point of an estimate.

/// Weight of a photon in an estimate, by its distance. The mean weight over the disc is 1.
///
/// With `n` photons expected, the relative standard deviation is `sqrt(c / n)`; a smooth field is blurred by
/// `b r^2` times its Laplacian.
///
/// | kernel | weight at `s = distance / radius` | c | b |
/// |---|---|---|---|
/// | constant | 1 | 1 | 1/8 |
/// | Epanechnikov | `2 (1 - s^2)` | 4/3 | 1/12 |
///
/// # Source
/// B. W. Silverman, *Density Estimation for Statistics and Data Analysis*, 1986, section 4.2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kernel {
    /// Every photon in the disc counts the same.
    #[default]
    Constant,
    /// Photons count less towards the border, so an estimate changes smoothly from point to point.
    Epanechnikov,
}

impl Kernel {
    /// Returns the weight at the square of `distance / radius`, 0 to 1.
    #[inline]
    pub fn weight(self, share_squared: f64) -> f64 {
        match self {
            Self::Constant => 1.0,
            Self::Epanechnikov => 2.0 * (1.0 - share_squared),
        }
    }

    /// Returns the factor of the variance, `c` in the table: the mean of the squared weight over the disc.
    pub fn variance_factor(self) -> f64 {
        match self {
            Self::Constant => 1.0,
            Self::Epanechnikov => 4.0 / 3.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_have_mean_one_and_the_stated_variance() {
        // s^2 is uniform over the disc.
        let steps = 100_000;
        for kernel in [Kernel::Constant, Kernel::Epanechnikov] {
            let weights =
                (0..steps).map(|step| kernel.weight((f64::from(step) + 0.5) / f64::from(steps)));
            let (sum, squares) =
                weights.fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
            assert!((sum / f64::from(steps) - 1.0).abs() < 1e-9);
            assert!((squares / f64::from(steps) - kernel.variance_factor()).abs() < 1e-9);
        }
    }
}
