//! The scene of the digests, which `tests/scene.mjs` makes too: whole numbers decide, so both have the same bits.

use arboleda::{Ray, Triangle, Vec3};

/// Generator of numbers: x -> 1664525 x + 1013904223 modulo 2^32 (Numerical Recipes).
pub struct Numbers(pub u32);

impl Numbers {
    /// A number of 0 to 2^24 - 1.
    pub fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.0 >> 8
    }

    /// A number in -1 to 1, exact in `f32`.
    pub fn signed(&mut self) -> f32 {
        (self.next() as f32 - 8_388_608.0) / 8_388_608.0
    }

    pub fn point(&mut self, scale: f32) -> Vec3 {
        let [x, y, z] = [self.signed(), self.signed(), self.signed()];
        Vec3::new(x, y, z) * scale
    }
}

/// 1,200 triangles in six groups, and two far larger ones.
pub fn triangles() -> Vec<Triangle> {
    let mut numbers = Numbers(1);
    let mut triangles = Vec::new();
    for _ in 0..6 {
        let group = numbers.point(64.0);
        for _ in 0..200 {
            let a = group + numbers.point(4.0);
            triangles.push(Triangle::new(a, a + numbers.point(1.0), a + numbers.point(1.0)));
        }
    }
    let at = |x, z| Vec3::new(x, -70.0, z);
    triangles.push(Triangle::new(at(-80.0, -80.0), at(80.0, -80.0), at(80.0, 80.0)));
    triangles.push(Triangle::new(at(-80.0, -80.0), at(80.0, 80.0), at(-80.0, 80.0)));
    triangles
}

/// Rays from a shell around the scene to its middle, and from the middles of triangles.
pub fn rays(count: usize) -> Vec<Ray> {
    let mut numbers = Numbers(7);
    let mut rays = Vec::new();
    while rays.len() < count {
        let (from, to) = (numbers.point(128.0), numbers.point(64.0));
        rays.extend(Ray::new(from, to - from));
    }
    rays
}
