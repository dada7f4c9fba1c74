//! Parsers of option values: whole numbers, numbers and file names.
//!
//! A value out of range is refused while the command line is parsed, before a scene is loaded. The message names the
//! range.

use std::fmt::Display;
use std::ops::{Range, RangeInclusive};
use std::path::PathBuf;

use clap::builder::{PathBufValueParser, TypedValueParser};

/// Most photons of a shot: 10^15, weeks of work for the largest machines.
pub const MOST_PHOTONS: u64 = 1_000_000_000_000_000;
/// Most photons whose rays are kept for replaying, at about 150 bytes a photon.
pub const MOST_REPLAYED_PHOTONS: u64 = 10_000_000;
/// Most repetitions of a measurement.
pub const MOST_REPETITIONS: u64 = 10_000;
/// Most threads on a machine with fewer processors. More threads than processors only wait for each other.
///
/// # Measured
/// - 5,000 threads on two processors did not end in ten minutes.
const THREADS: usize = 256;
/// Range of a picture's width and height. A picture of the largest size takes 2 GiB while it is painted.
pub const PIXELS: RangeInclusive<u64> = 64..=8192;

/// Parses a whole number in a range: `1000000`, `1_000_000`, `1e6` or `1M`.
pub fn whole<T>(range: RangeInclusive<u64>) -> impl TypedValueParser<Value = T>
where
    T: TryFrom<u64> + Clone + Send + Sync + 'static,
{
    move |text: &str| {
        let number = parse_whole(text)?;
        let outside = || out_of_range(range.start(), range.end());
        if !range.contains(&number) {
            return Err(outside());
        }
        T::try_from(number).map_err(|_| outside())
    }
}

/// Parses a range that is not empty: `A..B`, two whole numbers, of which the second is not in the range.
pub fn range(text: &str) -> Result<Range<u64>, String> {
    let (start, end) = text.split_once("..").ok_or("not a range; write it as 0..1000 or 1M..2M")?;
    let range = parse_whole(start)?..parse_whole(end)?;
    if range.is_empty() { Err("the range is empty".to_owned()) } else { Ok(range) }
}

/// Parses a number in a range; refuses NaN and infinities.
pub fn number(range: RangeInclusive<f32>) -> impl TypedValueParser<Value = f32> {
    move |text: &str| {
        let number: f32 = text.parse().map_err(|_| "not a number".to_owned())?;
        if range.contains(&number) {
            Ok(number)
        } else {
            Err(out_of_range(range.start(), range.end()))
        }
    }
}

/// Parses a number of threads, from 1 to 256 or to the number of processors, whichever is larger.
pub fn threads() -> impl TypedValueParser<Value = usize> {
    let processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    whole(1..=processors.max(THREADS) as u64)
}

/// Parses a file name that must have one of the given endings.
pub fn file_ending_in(endings: &'static [&'static str]) -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(move |path| {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("");
        if endings.iter().any(|known| known.eq_ignore_ascii_case(ending)) {
            return Ok(path);
        }
        let known = endings.iter().map(|known| format!(".{known}")).collect::<Vec<_>>();
        Err(format!("the name must end in {}", known.join(" or ")))
    })
}

/// Parses the name of a file of one format: with that ending, or without any, such as `/dev/stdout`.
pub fn file_ending_in_or_bare(format: &'static str) -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(move |path| match path.extension() {
        Some(ending) if !ending.eq_ignore_ascii_case(format) => {
            Err(format!("the name must end in .{format}"))
        }
        _ => Ok(path),
    })
}

fn out_of_range(least: impl Display, most: impl Display) -> String {
    format!("must be {least} to {most}")
}

/// Parses a whole number, optionally with `_`, an exponent, or k, M, G. A number beyond `u64` becomes `u64::MAX`.
fn parse_whole(text: &str) -> Result<u64, String> {
    let refused = || "not a whole number; write it as 1000000, 1_000_000, 1e6 or 1M".to_owned();
    let plain = text.replace('_', "");
    let (number, power) = match plain.as_bytes() {
        [.., b'k' | b'K'] => (&plain[..plain.len() - 1], 3),
        [.., b'M'] => (&plain[..plain.len() - 1], 6),
        [.., b'G'] => (&plain[..plain.len() - 1], 9),
        _ => match plain.split_once(['e', 'E']) {
            Some((number, power)) => (number, power.parse::<usize>().map_err(|_| refused())?),
            None => (plain.as_str(), 0),
        },
    };
    let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
    let fraction = fraction.trim_end_matches('0');
    let are_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if number.is_empty() || !are_digits(whole) || !are_digits(fraction) || fraction.len() > power {
        return Err(refused());
    }
    let digits = format!("{whole}{fraction}");
    let digits = digits.trim_start_matches('0');
    if digits.is_empty() {
        return Ok(0);
    }
    let zeros = u32::try_from(power - fraction.len()).unwrap_or(u32::MAX);
    let factor = 10_u64.checked_pow(zeros);
    let product = digits.parse().ok().zip(factor).and_then(|(a, b): (u64, u64)| a.checked_mul(b));
    Ok(product.unwrap_or(u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_are_read_as_people_write_them() {
        for (text, number) in [
            ("0", 0),
            ("1000000", 1_000_000),
            ("1_000_000", 1_000_000),
            ("1e6", 1_000_000),
            ("1E+6", 1_000_000),
            ("2.5e6", 2_500_000),
            ("1.0", 1),
            ("1M", 1_000_000),
            ("0.5k", 500),
            ("20k", 20_000),
            ("3G", 3_000_000_000),
            ("18446744073709551615", u64::MAX),
            ("18446744073709551616", u64::MAX),
            ("1e99999999999999", u64::MAX),
            ("0e99999999999999", 0),
        ] {
            assert_eq!(parse_whole(text), Ok(number), "{text}");
        }
        for text in [
            "", "-1", "+1", "1.5", "1e", "e6", "1e-3", "1,000", "1 000", "M", "1MM", "inf", "nan",
            "0x10", "1e1e1",
        ] {
            assert!(parse_whole(text).is_err(), "{text}");
        }
    }

    #[test]
    fn ranges_have_an_end_beyond_their_start() {
        assert_eq!(range("0..10"), Ok(0..10));
        assert_eq!(range("1M..2.5M"), Ok(1_000_000..2_500_000));
        for text in ["", "5", "..", "1..", "..5", "5..5", "6..5", "1..2..3", "1..=2", "-1..2"] {
            assert!(range(text).is_err(), "{text}");
        }
    }
}
