//! Numbers in few characters, for axes, tables and pictures.

/// Writes a number in few characters: 12k, 0.5, 3M; from 10^13 with an exponent.
pub fn number(value: f64) -> String {
    let size = value.abs();
    if size >= 1e13 {
        return format!("{value:.2e}");
    }
    let (value, unit) = match size {
        1e9.. => (value / 1e9, "G"),
        1e6.. => (value / 1e6, "M"),
        1e4.. => (value / 1e3, "k"),
        _ => (value, ""),
    };
    let places = match value.abs() {
        0.0 | 100.0.. => 0,
        10.0.. => 1,
        1.0.. => 2,
        _ => 3,
    };
    let text = format!("{value:.places$}");
    let text =
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    format!("{text}{unit}")
}

/// Writes a number as [`number`] does, but numbers below 0.01 with an exponent.
pub fn short_number(value: f64) -> String {
    if value != 0.0 && value.abs() < 0.01 { format!("{value:.1e}") } else { number(value) }
}

/// Writes a number with four decimals, or with an exponent where those would show nothing or digits that are none.
pub fn four_decimals(value: f64) -> String {
    let is_plain = value == 0.0 || (1e-3..1e9).contains(&value.abs());
    if is_plain { format!("{value:.4}") } else { format!("{value:.4e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases =
            [(0.0, "0"), (0.125, "0.125"), (12.0, "12"), (1_500.0, "1500"), (70_888.0, "70.9k")];
        for (value, text) in cases.into_iter().chain([(2.5e6, "2.5M"), (-40.0, "-40")]) {
            assert_eq!(number(value), text);
        }
        assert_eq!((number(1e12), number(3e38)), ("1000G".into(), "3.00e38".into()));
        let decimals = [0.0, 0.5, 2e-31, 1e30].map(four_decimals);
        assert_eq!(decimals, ["0.0000", "0.5000", "2.0000e-31", "1.0000e30"]);
    }
}
