//! Emission in lanes.
//!
//! ```text
//! block 0: light, u, v, x1     block 1: y1, x2, y2, next draw
//! ```

use arboleda::{Ray, SimdLevel, Work};

use super::{DiscPoint, LANE_ATTEMPTS, LANES, LaneRays, Words, part, put, words_of};
use crate::photon::emission::{Emitter, Parallelogram};
use crate::photon::random::{PhotonRandom, Place, halves, philox_lanes};

/// Most lights of one group whose photons are computed in lanes. Each light computes all lanes.
const MOST_LIGHTS: usize = 3;

/// Photons of a group at their emission.
pub(in crate::photon) struct EmissionLanes {
    level: SimdLevel,
    seed: u64,
    first: u64,
    /// The first and the second block of random numbers. Later the second is the one that contains the next draw.
    block0: [Words; 4],
    block1: [Words; 4],
    /// Light of each lane; `MOST_LIGHTS` if the lane is not computed.
    light_of: [u8; LANES],
    lights: [LaneLight; MOST_LIGHTS],
}

/// Photons of one light.
struct LaneLight {
    weight: [f32; 3],
    rays: LaneRays,
}

impl EmissionLanes {
    /// Makes lanes without photons.
    pub fn new(level: SimdLevel, seed: u64) -> Box<Self> {
        let light = || LaneLight { weight: [0.0; 3], rays: LaneRays::ZERO };
        Box::new(Self {
            level,
            seed,
            first: 0,
            block0: [[0; LANES]; 4],
            block1: [[0; LANES]; 4],
            light_of: [0; LANES],
            lights: [light(), light(), light()],
        })
    }

    /// Computes [`LANES`] photons from number `first` on.
    pub fn compute(&mut self, emitter: &Emitter, first: u64) {
        // 1. The random numbers.
        self.first = first;
        let (block0, block1) = (&mut self.block0, &mut self.block1);
        self.level.run(FirstDraws { key: halves(self.seed), first, block0, block1 });

        // 2. The lights. Where there are few, neighbours often have the same.
        let mut sources = [usize::MAX; MOST_LIGHTS];
        let (mut count, mut last) = (0, (usize::MAX, MOST_LIGHTS));
        for lane in 0..LANES {
            let source = emitter.choose(self.block0[0][lane] as u32);
            if source != last.0 {
                let known = sources[..count].iter().position(|&known| known == source);
                let is_usual = count < MOST_LIGHTS && emitter.parallelogram(source).is_some();
                let light = known.unwrap_or(if is_usual { count } else { MOST_LIGHTS });
                if known.is_none() && is_usual {
                    sources[count] = source;
                    count += 1;
                }
                last = (source, light);
            }
            self.light_of[lane] = last.1 as u8;
        }

        // 3. The photons of each light.
        for (light, &source) in sources[..count].iter().enumerate() {
            if let Some(shape) = emitter.parallelogram(source) {
                let LaneLight { weight, rays } = &mut self.lights[light];
                *weight = emitter.weight(source);
                self.level.run(Rays {
                    shape,
                    block0: &self.block0,
                    block1: &self.block1,
                    result: rays,
                });
                self.try_later_points(shape, light);
            }
        }
    }

    /// Draws further points for the photons whose first points lie outside the disc.
    fn try_later_points(&mut self, shape: &Parallelogram, light: usize) {
        let rays = &mut self.lights[light].rays;
        for lane in 0..LANES {
            if rays.attempts[lane] > LANE_ATTEMPTS && usize::from(self.light_of[lane]) == light {
                let photon = self.first.wrapping_add(lane as u64);
                let block = words_of(&self.block1, lane);
                let place = Place { photon, draw_count: 3 + 2 * LANE_ATTEMPTS, block };
                let mut random = PhotonRandom::at(self.seed, place);
                let direction = shape.direction(&mut random, LANE_ATTEMPTS as u32);
                put(&mut rays.directions, lane, direction);
                let Place { draw_count, block, .. } = *random.place();
                rays.attempts[lane] = (draw_count - 3) / 2;
                for (words, word) in self.block1.iter_mut().zip(block) {
                    words[lane] = word.into();
                }
            }
        }
    }

    /// Returns the ray of a lane, its weight and its place in the random numbers, as
    /// [`Tracer::emit`](crate::photon::Tracer::emit) does; `None` if its light is not a usual one, or the ray not
    /// valid.
    #[inline(always)]
    pub fn photon(&self, lane: usize) -> Option<(Ray, [f32; 3], Place)> {
        let light = self.lights.get(usize::from(self.light_of[lane]))?;
        let ray = light.rays.ray(lane).ok()?;
        let place = Place {
            photon: self.first.wrapping_add(lane as u64),
            draw_count: 3 + 2 * light.rays.attempts[lane],
            block: words_of(&self.block1, lane),
        };
        Some((ray, light.weight, place))
    }
}

/// Computation of the first two blocks of random numbers.
struct FirstDraws<'l> {
    key: [u32; 2],
    first: u64,
    block0: &'l mut [Words; 4],
    block1: &'l mut [Words; 4],
}

impl Work for FirstDraws<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (number, block) in [(0, self.block0), (1, self.block1)] {
            let [c0, c1, c2, c3] = block;
            for lane in 0..LANES {
                let photon = self.first.wrapping_add(lane as u64);
                (c0[lane], c1[lane], c2[lane], c3[lane]) = (number, 0, photon, photon >> 32);
            }
            philox_lanes(block, self.key);
        }
    }
}

/// Computation of the rays of one light.
struct Rays<'l> {
    shape: &'l Parallelogram,
    block0: &'l [Words; 4],
    block1: &'l [Words; 4],
    result: &'l mut LaneRays,
}

impl Work for Rays<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        emit(self.shape, self.block0, self.block1, self.result);
    }
}

// A function with references, which the compiler knows to be apart from each other.
#[inline(always)]
fn emit(
    shape: &Parallelogram,
    [_, u, v, x1]: &[Words; 4],
    [y1, x2, y2, _]: &[Words; 4],
    rays: &mut LaneRays,
) {
    for lane in 0..LANES {
        let point = DiscPoint::choose(x1[lane], y1[lane], x2[lane], y2[lane]);
        put(&mut rays.origins, lane, shape.origin(part(u[lane]), part(v[lane])));
        put(&mut rays.directions, lane, shape.frame().lifted(point.x, point.y).rounded());
        rays.attempts[lane] = point.attempts;
    }
}
