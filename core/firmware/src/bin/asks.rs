//! Smallest program that asks an index: it opens the one in flash, and asks for the closest hit of one ray.
#![no_std]
#![no_main]

use core::fmt;
use core::hint::black_box;

use arboleda::{Index, Ray, Vec3};
use arboleda_firmware::kind::Kind;
use arboleda_firmware::{IN_FLASH, program};

program!(main);

fn main() -> fmt::Result {
    let [x, y, z] = black_box([1.0, 2.0, 3.0]);
    let ray = Ray::new(Vec3::ZERO, Vec3::new(x, y, z)).map_err(|_| fmt::Error)?;
    let index = Index::<Kind>::from_bytes(IN_FLASH).map_err(|_| fmt::Error)?;
    black_box(index.closest_hit(&ray));
    Ok(())
}
