//! Samples of a picture: primary rays, and the receivers of light that they hit.
//!
//! A pixel has `s * s` rays, each through the middle of a cell of its own: a stratified pattern without random numbers.
//!
//! Rays of a pixel that hit the same triangle close to each other share one receiver at their mean, because their
//! estimates would be made of the same photons. Receivers come tile by tile. In a tile they are sorted by normal, so
//! that neighbours in a plane follow each other.

use std::collections::HashMap;
use std::f64::consts::PI;

use arboleda::{Hit, Ray, RayIndex, Vec3};
use rayon::prelude::*;

use super::batch;
use super::film::Film;
use crate::density::{Estimate, Receiver};
use crate::report::Camera;
use crate::scene::vector::Vector64;
use crate::scene::{FaceLight, LitSides, Model};

/// Side of a tile in pixels.
pub(super) const TILE: u32 = 16;

/// Pattern of a picture's primary rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Rays of a pixel along each side.
    pub side: u32,
    /// Largest distance of hits that share a receiver.
    pub merged_within: f32,
}

impl Sampling {
    /// Returns the pattern for estimates in discs of a radius. Hits within a quarter of it share a receiver, because
    /// their estimates would be made of nearly the same photons.
    pub fn of_radius(side: u32, radius: f32) -> Self {
        Self { side, merged_within: 0.25 * radius }
    }
}

/// Share of a pixel that one receiver stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelShare {
    /// Number of the pixel, row by row.
    pub pixel: u32,
    /// Triangle that was hit.
    pub triangle: u32,
    /// True if the ray came from the side from which the corners are seen counter-clockwise.
    pub front: bool,
    /// Number of the pixel's rays.
    pub rays: u32,
    /// Mean distance along the line of sight.
    pub depth: f32,
}

/// Receivers of some tiles, and the shares of pixels that they stand for.
#[derive(Clone, Debug, Default)]
pub struct TileSamples {
    /// Points and normals.
    pub receivers: Vec<Receiver>,
    /// For each receiver, its share of a pixel.
    pub shares: Vec<PixelShare>,
    /// Primary rays cast.
    pub rays: u64,
}

/// Hits of a pixel that share a receiver, while they are collected.
struct Merged {
    triangle: u32,
    first: Receiver,
    direction: Vec3,
    sum: Vector64,
    depth: f32,
    rays: u32,
}

impl TileSamples {
    /// Samples the rows of tiles `first..end`, in the caller's pool.
    pub fn of_rows(
        camera: &Camera,
        sampling: Sampling,
        model: &Model,
        index: &(dyn RayIndex + Sync),
        rows: std::ops::Range<u32>,
    ) -> Self {
        let (width, _) = camera.size();
        let columns = width.div_ceil(TILE);
        let tiles: Vec<(u32, u32)> =
            rows.flat_map(|row| (0..columns).map(move |column| (column, row))).collect();
        let sampled: Vec<Self> = tiles
            .into_par_iter()
            .map_init(batch::scratch, |scratch, tile| {
                Self::of_tile(camera, sampling, model, index, tile, scratch)
            })
            .collect();
        let mut all = Self::default();
        for tile in sampled {
            all.receivers.extend(tile.receivers);
            all.shares.extend(tile.shares);
            all.rays += tile.rays;
        }
        all
    }

    fn of_tile(
        camera: &Camera,
        sampling: Sampling,
        model: &Model,
        index: &(dyn RayIndex + Sync),
        (column, row): (u32, u32),
        scratch: &mut [u8],
    ) -> Self {
        // 1. The rays of the tile, answered together. A ray beyond the range of f32 sees nothing.
        let (width, height) = camera.size();
        let side = sampling.side;
        let mut rays: Vec<(u32, Ray)> = Vec::new();
        for (x, y) in (0..TILE * TILE).map(morton) {
            let (x, y) = (column * TILE + x, row * TILE + y);
            if x >= width || y >= height {
                continue;
            }
            for sample in 0..side * side {
                let within = |at: u32| (at as f32 + 0.5) / side as f32;
                let (dx, dy) = (within(sample % side), within(sample / side));
                let ray = camera.ray(x as f32 + dx, y as f32 + dy);
                rays.extend(ray.map(|ray| (y * width + x, ray)));
            }
        }
        let hits = batch::closest_hits(index, &rays, scratch);

        // 2. Hits of a pixel on the same triangle are merged.
        let mut found: Vec<(Receiver, PixelShare)> = Vec::new();
        let mut merged: Vec<Merged> = Vec::new();
        let mut hits = rays.iter().zip(&hits).peekable();
        while let Some(((pixel, ray), hit)) = hits.next() {
            if !hit.is_none() {
                merge(&mut merged, sampling, model, ray, hit);
            }
            if hits.peek().is_none_or(|((next, _), _)| next != pixel) {
                found.extend(merged.drain(..).filter_map(|merged| merged.finish(*pixel, model)));
            }
        }

        // 3. Receivers that face the same way follow each other.
        found.sort_by_key(|(receiver, _)| receiver.normal_bits());
        let (receivers, shares) = found.into_iter().unzip();
        Self { receivers, shares, rays: rays.len() as u64 }
    }

    /// Adds estimates of the receivers to a film. `rays` is the number of rays of a pixel.
    pub fn add_to(&self, film: &mut Film, model: &Model, estimates: &[Estimate], rays: u32) {
        for (share, estimate) in self.shares.iter().zip(estimates) {
            let part = share.rays as f32 / rays as f32;
            let exitance = estimate.exitance(model.colour(share.triangle));
            let reflected = exitance.map(|exitance| (exitance / PI) as f32);
            film.add(share, part, estimate, reflected);
        }
    }
}

/// Returns the place of a pixel in its tile, in Morton's order, in which pixels that follow each other form squares.
fn morton(number: u32) -> (u32, u32) {
    let even = |bits: u32| (0..4).fold(0, |sum, bit| sum | (bits >> (2 * bit) & 1) << bit);
    (even(number), even(number >> 1))
}

/// Adds a hit to those of its pixel that share a receiver with it, or begins a new receiver.
fn merge(merged: &mut Vec<Merged>, sampling: Sampling, model: &Model, ray: &Ray, hit: &Hit) {
    let Some(triangle) = model.triangles.get(hit.triangle.0 as usize) else { return };
    let Some(receiver) = Receiver::at_hit(triangle, hit, ray.direction()) else { return };
    let near = f64::from(sampling.merged_within) * f64::from(sampling.merged_within);
    let position = Vector64::from(receiver.position());
    let same = merged.iter_mut().find(|other| {
        let offset = position - Vector64::from(other.first.position());
        let together = other.triangle == hit.triangle.0 && offset.dot(offset) <= near;
        together && other.first.faces_as(&receiver)
    });
    match same {
        Some(other) => {
            other.sum = other.sum + position;
            other.depth += hit.t;
            other.rays += 1;
        }
        None => merged.push(Merged {
            triangle: hit.triangle.0,
            first: receiver,
            direction: ray.direction(),
            sum: position,
            depth: hit.t,
            rays: 1,
        }),
    }
}

impl Merged {
    fn finish(self, pixel: u32, model: &Model) -> Option<(Receiver, PixelShare)> {
        let triangle = model.triangles.get(self.triangle as usize)?;
        let normal = triangle.normal();
        let front = Vector64::from(normal).dot(self.direction.into()) <= 0.0;
        let position = (self.sum / f64::from(self.rays)).rounded();
        let share = PixelShare {
            pixel,
            triangle: self.triangle,
            front,
            rays: self.rays,
            // The direction's component along the line of sight is 1, so t is the distance along it.
            depth: self.depth / self.rays as f32,
        };
        Some((self.first.moved_to(position), share))
    }
}

/// Radiance that a model's triangles emit, by triangle. Few triangles do.
#[derive(Clone, Debug, Default)]
pub(super) struct Glow {
    radiance: HashMap<u32, ([f32; 3], LitSides)>,
}

impl Glow {
    pub fn of(model: &Model) -> Self {
        let of_light = |light: &FaceLight| (light.triangle, (light.radiance, light.sides));
        Self { radiance: model.emitters.iter().map(of_light).collect() }
    }

    /// Returns the radiance that a triangle emits towards one side; `None` if it emits none.
    pub fn seen(&self, triangle: u32, front: bool) -> Option<[f32; 3]> {
        let (radiance, sides) = self.radiance.get(&triangle)?;
        let emits = radiance.iter().any(|&part| part > 0.0);
        (emits && (front || *sides == LitSides::Both)).then_some(*radiance)
    }
}
