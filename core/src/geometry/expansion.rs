//! Exact sums and products of `f64`, as expansions (Shewchuk 1997).
//!
//! An expansion is a sum of `f64` terms, smallest first, no two of which share a bit; zero terms
//! are dropped, so the empty expansion is 0 and the sign of the sum is the sign of the last term.
//! Most values met in practice need one or two terms, whatever the capacity.
//!
//! # Why nothing over- or underflows
//! Inputs are `f32`, multiples of 2^-149 below 2^128. The kernel forms products of three
//! differences, one of them scaled by an `f64` midpoint of two `f32` values: multiples of
//! 2^(-3 * 149 - 150) = 2^-597 below 2^520. All intermediate terms are such multiples too, far inside
//! the range of `f64`, so every error term of a sum or a product is exact.
//!
//! # Source
//! J. R. Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
//! Predicates*, 1997: TWO-SUM, SPLIT, TWO-PRODUCT, FAST-EXPANSION-SUM and SCALE-EXPANSION, with
//! zero elimination. Fused multiply-add is avoided: it is slow where it is emulated.

use arrayvec::ArrayVec;

/// An exact sum of at most `N` terms.
#[derive(Clone, Debug, Default)]
pub(super) struct Expansion<const N: usize> {
    terms: ArrayVec<f64, N>,
}

impl<const N: usize> Expansion<N> {
    /// The exact value of one number.
    pub fn of(value: f64) -> Self {
        let mut sum = Self::default();
        sum.push(value);
        sum
    }

    /// The exact value of `a - b`, in at most two terms.
    pub fn difference(a: f32, b: f32) -> Self {
        let (high, low) = two_sum(f64::from(a), -f64::from(b));
        let mut sum = Self::default();
        sum.push(low);
        sum.push(high);
        sum
    }

    /// Drops zeros. Capacities are chosen so that no term is ever refused: a result of `scaled` has
    /// at most twice the terms of its input, a result of `plus` as many as both inputs.
    fn push(&mut self, term: f64) {
        if term != 0.0 {
            let refused = self.terms.try_push(term).is_err();
            debug_assert!(!refused, "an expansion's capacity was derived wrongly");
        }
    }

    /// The exact value times `factor` (SCALE-EXPANSION); needs `M >= 2 * N`.
    pub fn scaled<const M: usize>(&self, factor: f64) -> Expansion<M> {
        let mut product = Expansion::default();
        let mut carry = 0.0;
        for (i, &term) in self.terms.iter().enumerate() {
            let (high, low) = two_product(term, factor);
            if i == 0 {
                product.push(low);
                carry = high;
            } else {
                let (sum, error) = two_sum(carry, low);
                product.push(error);
                let (sum, error) = fast_two_sum(high, sum);
                product.push(error);
                carry = sum;
            }
        }
        product.push(carry);
        product
    }

    /// The exact sum (FAST-EXPANSION-SUM); needs `M >= N + K`.
    pub fn plus<const K: usize, const M: usize>(&self, other: &Expansion<K>) -> Expansion<M> {
        let mut sum = Expansion::default();
        let mut left = self.terms.iter().copied().peekable();
        let mut right = other.terms.iter().copied().peekable();
        let mut smaller = || match (left.peek(), right.peek()) {
            (Some(a), Some(b)) if a.abs() <= b.abs() => left.next(),
            (Some(_), None) => left.next(),
            _ => right.next(),
        };
        let Some(mut carry) = smaller() else {
            return sum;
        };
        while let Some(term) = smaller() {
            let (high, low) = two_sum(carry, term);
            sum.push(low);
            carry = high;
        }
        sum.push(carry);
        sum
    }

    /// The exact product; needs `M >= 2 * N * K`.
    pub fn times<const K: usize, const M: usize>(&self, other: &Expansion<K>) -> Expansion<M> {
        let mut product = Expansion::<M>::default();
        for &factor in &other.terms {
            product = product.plus::<M, M>(&self.scaled::<M>(factor));
        }
        product
    }

    /// The exact value with the other sign.
    #[must_use]
    pub fn negated(mut self) -> Self {
        for term in &mut self.terms {
            *term = -*term;
        }
        self
    }

    /// The sign of the exact value: -1, 0 or 1.
    pub fn sign(&self) -> i32 {
        match self.terms.last() {
            Some(&term) if term > 0.0 => 1,
            Some(_) => -1,
            None => 0,
        }
    }

    /// The value rounded: off by at most 2^-51 of it, since the terms do not overlap.
    pub fn estimate(&self) -> f64 {
        self.terms.iter().fold(0.0, |sum, term| sum + term)
    }
}

/// `a + b` as a rounded sum and its exact error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_virtual = sum - a;
    let a_virtual = sum - b_virtual;
    (sum, (a - a_virtual) + (b - b_virtual))
}

/// As `two_sum`, where `|a| >= |b|` or `a` is 0.
fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// `a` as a high half of 26 bits and a low half.
fn split(a: f64) -> (f64, f64) {
    const SPLITTER: f64 = 134_217_729.0; // 2^27 + 1
    let c = SPLITTER * a;
    let high = c - (c - a);
    (high, a - high)
}

/// `a * b` as a rounded product and its exact error.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    let (a_high, a_low) = split(a);
    let (b_high, b_low) = split(b);
    let error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low);
    (product, error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_keeps_what_f64_loses() {
        let exact = Expansion::<2>::difference(1e30, 1e-30);
        assert_eq!(exact.terms.len(), 2);
        let back: Expansion<4> = exact.plus(&Expansion::<2>::difference(0.0, 1e30));
        assert_eq!(back.estimate(), -f64::from(1e-30_f32));
    }

    #[test]
    fn a_product_of_sums_cancels_to_nothing() {
        let x = Expansion::<2>::difference(1e20, 3.0);
        let y = Expansion::<2>::difference(-7e-20, 1e10);
        let xy: Expansion<8> = x.times(&y);
        let yx: Expansion<8> = y.times(&x);
        let zero: Expansion<16> = xy.plus(&yx.negated());
        assert_eq!(zero.sign(), 0);
        assert_eq!(xy.sign(), -1);
    }
}
