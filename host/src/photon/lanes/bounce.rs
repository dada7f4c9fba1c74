//! Bounces in lanes.
//!
//! ```text
//! words of the photon's block   - R x y   next block   x y - -     R: draw of the roulette; then two points
//! ```

use arboleda::{Hit, Ray, SimdLevel, Triangle, Vec3, Work};

use super::{DiscPoint, LANE_ATTEMPTS, LANES, LaneRays, Vectors, Words, put, wide, words_of};
use crate::photon::random::{Place, halves, philox_lanes};
use crate::photon::surface::hemisphere::Frame;
use crate::photon::surface::offset::Departure;

/// Photons of a group after a bounce.
pub(in crate::photon) struct BounceLanes {
    level: SimdLevel,
    seed: u64,
    impacts: Impacts,
    /// Numbers of draws before the roulette.
    draw_counts: Words,
    /// Block that contains the draw of the roulette, and the next one.
    block: [Words; 4],
    next_block: [Words; 4],
    rays: LaneRays,
}

/// Hits from which photons depart.
struct Impacts {
    corners: [Vectors; 3],
    incoming: Vectors,
    u: [f32; LANES],
    v: [f32; LANES],
}

impl BounceLanes {
    /// Makes lanes without photons.
    pub fn new(level: SimdLevel, seed: u64) -> Box<Self> {
        let impacts = Impacts {
            corners: [[[0.0; LANES]; 3]; 3],
            incoming: [[0.0; LANES]; 3],
            u: [0.0; LANES],
            v: [0.0; LANES],
        };
        let (block, next_block) = ([[0; LANES]; 4], [[0; LANES]; 4]);
        let draw_counts = [0; LANES];
        Box::new(Self {
            level,
            seed,
            impacts,
            draw_counts,
            block,
            next_block,
            rays: LaneRays::ZERO,
        })
    }

    /// Puts a hit into a lane. `place` is that before the roulette, which the photon survives.
    #[inline(always)]
    pub fn put(
        &mut self,
        lane: usize,
        triangles: &[Triangle],
        ray: &Ray,
        hit: &Hit,
        place: &Place,
    ) {
        let Impacts { corners: [a, b, c], incoming, u, v } = &mut self.impacts;
        // A photon cannot depart from a triangle without area.
        let triangle = triangles.get(hit.triangle.0 as usize);
        let corners =
            triangle.map_or([Vec3::ZERO; 3], |triangle| [triangle.a, triangle.b, triangle.c]);
        put(a, lane, corners[0]);
        put(b, lane, corners[1]);
        put(c, lane, corners[2]);
        put(incoming, lane, ray.direction());
        (u[lane], v[lane]) = (hit.u, hit.v);

        self.draw_counts[lane] = place.draw_count;
        self.next_block[2][lane] = place.photon;
        let [w0, w1, w2, w3] = &mut self.block;
        (w0[lane], w1[lane]) = (place.block[0].into(), place.block[1].into());
        (w2[lane], w3[lane]) = (place.block[2].into(), place.block[3].into());
    }

    /// Computes the bounces of all lanes.
    pub fn compute(&mut self) {
        self.level.run(BounceWork(self));
    }

    /// Returns the ray of a lane, and moves `place` beyond the draws that it took; `None`, with `place` as it was, if
    /// the bounce is not a usual one.
    #[inline(always)]
    pub fn ray(&self, lane: usize, place: &mut Place) -> Option<Ray> {
        let attempts = self.rays.attempts[lane];
        if attempts > LANE_ATTEMPTS {
            return None;
        }
        let ray = self.rays.ray(lane).ok()?;
        let block_before = place.draw_count / 4;
        place.draw_count += 1 + 2 * attempts;
        match place.draw_count / 4 - block_before {
            0 => {}
            1 => place.block = words_of(&self.next_block, lane),
            _ => place.compute_block(halves(self.seed)),
        }
        Some(ray)
    }
}

/// Computation of the bounces of all lanes.
struct BounceWork<'l>(&'l mut BounceLanes);

impl Work for BounceWork<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let BounceLanes { seed, impacts, draw_counts, block, next_block, rays, .. } = self.0;
        let [c0, c1, c2, c3] = &mut *next_block;
        for lane in 0..LANES {
            let number = draw_counts[lane] / 4 + 1;
            (c0[lane], c1[lane], c3[lane]) = (number, number >> 32, c2[lane] >> 32);
        }
        philox_lanes(next_block, halves(*seed));
        let draws = draws_after(draw_counts, block, next_block);
        bounce(impacts, &draws, rays);
    }
}

/// Selects the four draws after that of the roulette.
#[inline(always)]
fn draws_after(
    draw_counts: &Words,
    [_, w1, w2, w3]: &[Words; 4],
    [n0, n1, n2, n3]: &[Words; 4],
) -> [Words; 4] {
    let mut draws = [[0; LANES]; 4];
    let [x1, y1, x2, y2] = &mut draws;
    for lane in 0..LANES {
        let (one, two) = (draw_counts[lane] & 1 != 0, draw_counts[lane] & 2 != 0);
        let select = |two: bool, no: u64, yes: u64| if two { yes } else { no };
        // By the second bit: words 0 to 5 of both blocks, or words 2 to 7. By the first bit: from the second or third.
        let word1 = select(two, w1[lane], w3[lane]);
        let word2 = select(two, w2[lane], n0[lane]);
        let word3 = select(two, w3[lane], n1[lane]);
        let word4 = select(two, n0[lane], n2[lane]);
        let word5 = select(two, n1[lane], n3[lane]);
        x1[lane] = select(one, word1, word2);
        y1[lane] = select(one, word2, word3);
        x2[lane] = select(one, word3, word4);
        y2[lane] = select(one, word4, word5);
    }
    draws
}

/// Computes the rays after a bounce. An origin is NaN if the bounce is not a usual one.
#[inline(always)]
fn bounce(impacts: &Impacts, [x1, y1, x2, y2]: &[Words; 4], rays: &mut LaneRays) {
    let Impacts { corners: [a, b, c], incoming, u, v } = impacts;
    for lane in 0..LANES {
        let corners = [wide(a, lane), wide(b, lane), wide(c, lane)];
        let (u, v) = (f64::from(u[lane]), f64::from(v[lane]));
        let (departure, is_usual) = Departure::usual(corners, u, v, wide(incoming, lane));
        let point = DiscPoint::choose(x1[lane], y1[lane], x2[lane], y2[lane]);
        let frame = Frame::around(departure.unit_normal());
        let direction = frame.lifted(point.x, point.y).rounded();
        let is_sure = is_usual & departure.leads_away(direction);
        let Vec3 { x, y, z } = departure.origin();
        put(&mut rays.origins, lane, Vec3::new(if is_sure { x } else { f32::NAN }, y, z));
        put(&mut rays.directions, lane, direction);
        rays.attempts[lane] = point.attempts;
    }
}
