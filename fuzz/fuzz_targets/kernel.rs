//! Comparison of the exact kernel with exact integers.
//!
//! Workload: one ray and one triangle. Each coordinate is a raw float, or a small whole number times a power of two, so
//! that exact zeros and extreme magnitudes occur in one pair.
//!
//! Constraints: finite corners and a valid ray; every bit of `t`, `u`, `v` must agree.
#![no_main]

use arbitrary::Arbitrary;
use arboleda::{Ray, Triangle, Vec3, intersect};
use arboleda_tests::oracle;
use arboleda_tests::random::power_of_two;
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug, Clone, Copy)]
enum Number {
    Whole(i8),
    Scaled(i8, i8),
    Raw(f32),
}

impl Number {
    fn value(self) -> f32 {
        match self {
            Self::Whole(whole) => f32::from(whole),
            Self::Scaled(whole, exponent) => {
                (f64::from(whole) * power_of_two(i32::from(exponent))) as f32
            }
            Self::Raw(value) => value,
        }
    }
}

#[derive(Arbitrary, Debug)]
struct Pair {
    corners: [[Number; 3]; 3],
    origin: [Number; 3],
    direction: [Number; 3],
    interval: Option<[Number; 2]>,
}

fuzz_target!(|pair: Pair| {
    let point = |numbers: [Number; 3]| Vec3::from_array(numbers.map(Number::value));
    let [a, b, c] = pair.corners.map(point);
    let triangle = Triangle::new(a, b, c);
    let [t_min, t_max] = pair.interval.map_or([0.0, f32::INFINITY], |ends| ends.map(Number::value));
    let ray = Ray::with_interval(point(pair.origin), point(pair.direction), t_min, t_max);
    let (Ok(ray), true) = (ray, triangle.is_finite()) else {
        return;
    };
    let bits = |hit: arboleda::Intersection| [hit.t, hit.u, hit.v].map(f32::to_bits);
    let (found, exact) = (intersect(&ray, &triangle), oracle::hit::intersect(&ray, &triangle));
    assert_eq!(found.map(bits), exact.map(bits), "found {found:?}, exact {exact:?}");
});
