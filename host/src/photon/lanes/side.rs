//! Sides of triangles in lanes.

use arboleda::{Hit, Ray, SimdLevel, Triangle, Work};

use super::{LANES, Vectors, put, wide};
use crate::photon::surface::side::Side;

/// Sides on which rays hit triangles.
pub(in crate::photon) struct SideLanes {
    level: SimdLevel,
    corners: [Vectors; 3],
    directions: Vectors,
    verdicts: [u64; LANES],
}

impl SideLanes {
    /// Makes lanes without hits.
    pub fn new(level: SimdLevel) -> Box<Self> {
        let (corners, directions) = ([[[0.0; LANES]; 3]; 3], [[0.0; LANES]; 3]);
        Box::new(Self { level, corners, directions, verdicts: [0; LANES] })
    }

    /// Puts a hit into a lane.
    #[inline(always)]
    pub fn put(&mut self, lane: usize, triangle: &Triangle, ray: &Ray) {
        let [a, b, c] = &mut self.corners;
        put(a, lane, triangle.a);
        put(b, lane, triangle.b);
        put(c, lane, triangle.c);
        put(&mut self.directions, lane, ray.direction());
    }

    /// Computes the sides of all lanes.
    pub fn compute(&mut self) {
        self.level.run(Sides(self));
    }

    /// Returns the side of a lane, as [`Side::met`] does for a ray that hits the triangle.
    #[inline(always)]
    pub fn side(&self, lane: usize, triangle: &Triangle, ray: &Ray, hit: &Hit) -> Side {
        Side::judged(self.verdicts[lane], triangle, ray, hit)
    }
}

/// Computation of the sides of all lanes.
struct Sides<'l>(&'l mut SideLanes);

impl Work for Sides<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let SideLanes { corners: [a, b, c], directions, verdicts, .. } = self.0;
        for lane in 0..LANES {
            let corners = [wide(a, lane), wide(b, lane), wide(c, lane)];
            verdicts[lane] = Side::judge(corners, wide(directions, lane));
        }
    }
}
