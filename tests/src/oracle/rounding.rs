//! Conversion of floats to integers times a power of two, and of exact quotients to the nearest float.
//!
//! Every finite `f32` is `mantissa * 2^exponent`. [`aligned`] gives several floats one exponent, so sums and products
//! are those of integers. [`nearest_f32`] is the only function that rounds, once.

use num_bigint::{BigInt, BigUint, Sign};

use crate::random::power_of_two;

/// Smallest exponent of a bit of an `f32`.
const LOWEST: i64 = -149;
/// Number of bits of an `f32`'s mantissa.
const PRECISION: i64 = 24;

/// Decodes a finite float to `(mantissa, exponent)`, the mantissa odd or 0.
fn decoded(value: f32) -> (i64, i64) {
    let bits = value.to_bits();
    let (biased, fraction) = (i64::from(bits >> 23 & 0xff), i64::from(bits & 0x7f_ffff));
    assert!(biased < 255, "{value} is not finite");
    let magnitude = if biased == 0 { fraction } else { fraction | 1 << 23 };
    if magnitude == 0 {
        return (0, 0);
    }
    let exponent = LOWEST + if biased == 0 { 0 } else { biased - 1 };
    let zeros = magnitude.trailing_zeros();
    let sign = if value < 0.0 { -1 } else { 1 };
    (sign * (magnitude >> zeros), exponent + i64::from(zeros))
}

/// Converts floats to integers with a common exponent `e`: each float is its integer times `2^e`.
///
/// # Panics
/// If a float is not finite.
pub fn aligned<const N: usize>(values: [f32; N]) -> ([BigInt; N], i64) {
    let decoded = values.map(decoded);
    let nonzero = decoded.iter().filter(|(mantissa, _)| *mantissa != 0);
    let lowest = nonzero.map(|(_, exponent)| *exponent).min().unwrap_or(0);
    let integer = |(mantissa, exponent): (i64, i64)| {
        let shift = if mantissa == 0 { 0 } else { exponent - lowest };
        BigInt::from(mantissa) << shift as usize
    };
    (decoded.map(integer), lowest)
}

/// Computes the `f32` nearest to `numerator / denominator * 2^exponent`, ties to even. It is infinite from half-way
/// between the largest `f32` and 2^128. Zero is +0.0.
///
/// # Panics
/// If the denominator is 0.
pub fn nearest_f32(numerator: &BigInt, denominator: &BigInt, exponent: i64) -> f32 {
    let negative = (numerator.sign() == Sign::Minus) != (denominator.sign() == Sign::Minus);
    let (n, d) = (numerator.magnitude(), denominator.magnitude());
    if n.bits() == 0 {
        return 0.0;
    }
    // The quotient lies between 2^(top - 1) and 2^(top + 1). Its last bit in an f32 is one of two.
    let top = n.bits() as i64 - d.bits() as i64 + exponent;
    let mut last = (top - PRECISION).max(LOWEST);
    let mut parts = divided(n, d, exponent - last);
    if parts.0 >> PRECISION != 0 {
        last += 1;
        parts = divided(n, d, exponent - last);
    }
    let (quotient, half) = parts;
    let up = half == Half::Above || (half == Half::Exactly && quotient & 1 == 1);
    let magnitude = (quotient + u64::from(up)) as f64; // at most 2^24: exact
    // Every value beyond 2^128 is infinite; the limit of 200 keeps the scale a finite `f64`.
    let rounded = (magnitude * power_of_two(last.min(200) as i32)) as f32;
    if negative { 0.0 - rounded } else { rounded }
}

/// Comparison of a division's remainder with one half of the divisor.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Half {
    Below,
    Exactly,
    Above,
}

/// Computes `n / d * 2^shift` rounded down, and compares the remainder with one half.
fn divided(n: &BigUint, d: &BigUint, shift: i64) -> (u64, Half) {
    let (n, d) = if shift >= 0 {
        (n << shift as usize, d.clone())
    } else {
        (n.clone(), d << (-shift) as usize)
    };
    let quotient = &n / &d;
    let twice = (n - &quotient * &d) << 1_usize;
    let half = match twice.cmp(&d) {
        std::cmp::Ordering::Less => Half::Below,
        std::cmp::Ordering::Equal => Half::Exactly,
        std::cmp::Ordering::Greater => Half::Above,
    };
    (u64::try_from(quotient).expect("the shift leaves at most 26 bits"), half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// A product of a 48-bit mantissa and a power of two is exact in `f64`, so the conversion to `f32` is the only
    /// rounding.
    #[test]
    fn agrees_with_the_processor_where_that_is_exact() {
        let mut random = Random::new(1);
        for _ in 0..100_000 {
            let value = f64::from_bits(random.bits());
            let exponent = random.whole(-170, 130);
            let mantissa = (random.bits() >> 16) as i64;
            let scaled = mantissa as f64 * power_of_two(exponent - 48);
            let ours =
                nearest_f32(&BigInt::from(mantissa), &BigInt::from(1), i64::from(exponent - 48));
            assert_eq!(
                ours.to_bits(),
                (scaled as f32).to_bits(),
                "{mantissa} * 2^{exponent}, {value}"
            );
        }
    }

    #[test]
    fn divides_as_the_processor_does() {
        let mut random = Random::new(2);
        for _ in 0..100_000 {
            let (p, q) = (random.magnitude(-149, 126), random.magnitude(-149, 126));
            let (integers, _) = aligned([p, q]);
            let expected = p / q + 0.0; // one correctly rounded operation
            assert_eq!(nearest_f32(&integers[0], &integers[1], 0).to_bits(), expected.to_bits());
        }
    }
}
