//! Numbers that sum up others: the middle and the ends of repetitions, and what one saves over another.

/// Middle and ends of several repetitions: times, or speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// The one in the middle.
    pub median: f64,
    /// The least.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// Sums up some numbers; NaN if there are none.
    pub fn of(numbers: &[f64]) -> Self {
        let mut sorted = numbers.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |place: usize| sorted.get(place).copied().unwrap_or(f64::NAN);
        let last = sorted.len().saturating_sub(1);
        Self {
            median: f64::midpoint(at(last / 2), at(last.div_ceil(2))),
            min: at(0),
            max: at(last),
        }
    }
}

/// Returns the time saved over the slower, in percent: above 0 where `ours` is faster, below where `theirs` is.
///
/// # Source
/// Aguilera et al., tables 1 to 3.
pub fn gain_percent(ours: f64, theirs: f64) -> f64 {
    let slower = ours.max(theirs);
    if slower > 0.0 { (theirs - ours) / slower * 100.0 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spread_has_its_middle() {
        assert_eq!(Spread::of(&[3.0, 1.0, 2.0]), Spread { median: 2.0, min: 1.0, max: 3.0 });
        assert_eq!(Spread::of(&[4.0, 1.0]).median, 2.5);
    }

    #[test]
    fn gains_are_the_papers() {
        assert!((gain_percent(51.55, 70.25) - 26.6).abs() < 0.05);
        assert!((gain_percent(97.05, 95.92) - -1.2).abs() < 0.05);
        assert_eq!(gain_percent(0.0, 0.0), 0.0);
    }
}
