//! Irradiance of whole triangles, on each side: the photons that fell on it, over its area.

use super::estimate::{Estimate, Sums};
use super::receiver::hit_point;
use super::source::PhotonSource;
use crate::photon::{Balance, Segment, Side, Visitor};
use crate::scene::Model;
use crate::scene::vector::area_of;

use arboleda::Vec3;

/// Photons that fell on each side of each triangle.
#[derive(Clone, Debug)]
pub struct TriangleLight {
    sums: Vec<[Sums; 2]>,
    balance: Balance,
}

/// Irradiance of a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TriangleIrradiance {
    /// Area of the triangle.
    pub area: f64,
    /// Estimate on the front: the side from which the corners are seen counter-clockwise.
    pub front: Estimate,
    /// Estimate on the back.
    pub back: Estimate,
}

impl TriangleLight {
    /// Shoots the photons of a source, in the caller's pool. `progress` is called from any thread.
    pub fn shoot(source: &PhotonSource<'_>, progress: &(impl Fn(u64) + Sync)) -> Self {
        let mut sums = vec![[Sums::default(); 2]; source.model.triangles.len()];
        let balance = source.stream(progress, &Hits { source }, |hits| {
            for (id, side, weight) in hits {
                if let Some(sides) = sums.get_mut(id as usize) {
                    sides[side as usize].add(weight, 1.0);
                }
            }
        });
        Self { sums, balance }
    }

    /// Returns the ends of the photons, and their flux.
    pub fn balance(&self) -> &Balance {
        &self.balance
    }

    /// Lists the irradiance of each triangle, by id. A triangle without area has none, and counts of 0 photons.
    pub fn irradiance<'l>(
        &'l self,
        model: &'l Model,
    ) -> impl Iterator<Item = TriangleIrradiance> + 'l {
        let flux = self.balance.photon_flux();
        model.triangles.iter().zip(&self.sums).map(move |(triangle, [front, back])| {
            let area = area_of(triangle);
            let [front, back] = [front, back].map(|sums| sums.estimate(flux, area, 0.0));
            TriangleIrradiance { area, front, back }
        })
    }
}

struct Hits<'m> {
    source: &'m PhotonSource<'m>,
}

impl Visitor for Hits<'_> {
    type State = Vec<(u32, Side, [f32; 3])>;

    fn chunks_at_once(&self) -> u64 {
        1 << 9
    }

    fn begin(&self) -> Self::State {
        Vec::new()
    }

    fn visit(&self, hits: &mut Self::State, segment: &Segment) {
        if let Some((triangle, hit)) = self.source.counted_hit(segment) {
            let side = Side::hit(triangle, &segment.ray, &hit);
            hits.push((hit.triangle.0, side, segment.weight));
        }
    }
}

/// Hit of a photon, for people to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotonHit {
    /// The photon's number.
    pub photon: u64,
    /// Bounces before the hit.
    pub bounce: u32,
    /// Triangle that was hit.
    pub triangle: u32,
    /// Hit point.
    pub position: Vec3,
    /// Direction of flight.
    pub direction: Vec3,
    /// Factors of red, green and blue.
    pub weight: [f32; 3],
}

/// Lists the first `limit` hits of a source, by photon and bounce.
pub fn first_hits(source: &PhotonSource<'_>, limit: usize) -> Vec<PhotonHit> {
    /// Photons that are shot at once, until there are enough hits.
    const SOME: u64 = 1 << 16;
    let mut all: Vec<PhotonHit> = Vec::new();
    let mut first = source.photons.start;
    while all.len() < limit && first < source.photons.end {
        let end = source.photons.end.min(first.saturating_add(SOME));
        let some = PhotonSource { photons: first..end, ..source.clone() };
        let balance = some.stream(&|_| {}, &Listed { source: &some }, |hits| all.extend(hits));
        if balance.emitted == 0 {
            break;
        }
        first = end;
    }
    all.truncate(limit);
    all
}

struct Listed<'m> {
    source: &'m PhotonSource<'m>,
}

impl Visitor for Listed<'_> {
    type State = Vec<PhotonHit>;

    fn begin(&self) -> Self::State {
        Vec::new()
    }

    fn visit(&self, hits: &mut Self::State, segment: &Segment) {
        if let Some((triangle, hit)) = self.source.counted_hit(segment) {
            hits.push(PhotonHit {
                photon: segment.photon,
                bounce: segment.bounce,
                triangle: hit.triangle.0,
                position: hit_point(triangle, &hit),
                direction: segment.ray.direction(),
                weight: segment.weight,
            });
        }
    }

    fn finish(&self, hits: &mut Self::State) {
        // Waves come in the order of bounces, so a stable sort by photon gives (photon, bounce).
        hits.sort_by_key(|hit| hit.photon);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::density::Bounces;
    use crate::density::fixtures::{Lit, lamp_over_floor, uniform_furnace};
    use crate::scene::{FaceLight, LitSides};

    #[test]
    fn the_flux_of_all_triangles_is_that_of_all_hits() {
        let lit = uniform_furnace(0.5);
        let (light, hits) = lit.shoot(50_000, |source| {
            (TriangleLight::shoot(source, &|_| {}), first_hits(source, 1_000))
        });
        let balance = light.balance();
        assert_eq!((balance.emitted, balance.ended(), balance.escaped), (50_000, 50_000, 0));
        let all: Vec<_> = light.irradiance(&lit.model).collect();
        let count: u64 =
            all.iter().map(|light| u64::from(light.front.count + light.back.count)).sum();
        assert_eq!(count, balance.hits);
        let flux: f64 = all
            .iter()
            .map(|light| f64::from(light.front.mean() + light.back.mean()) * light.area)
            .sum();
        let expected = balance.photon_flux() * balance.hits as f64;
        assert!((flux / expected - 1.0).abs() < 1e-6, "{flux} {expected}");
        // The mean over a closed room is flux / (area (1 - reflectance)).
        let mean = flux / all.iter().map(|light| light.area).sum::<f64>();
        assert!((mean - 2.0).abs() < 0.02, "{mean}");

        assert_eq!(hits.len(), 1_000);
        assert!(hits.is_sorted_by_key(|hit| (hit.photon, hit.bounce)));
        assert!(hits.iter().all(|hit| hit.weight == [1.0; 3]));
    }

    #[test]
    fn walls_that_emit_and_reflect_are_a_furnace() {
        // Each side of each wall emits the exitance 1, so a radiance of 1 / pi. The outer side's photons escape.
        let mut lit = uniform_furnace(0.5);
        lit.model.lights.clear();
        let radiance = [(1.0 / std::f64::consts::PI) as f32; 3];
        let walls = 0..lit.model.triangles.len() as u32;
        lit.model.emitters =
            walls.map(|triangle| FaceLight { triangle, radiance, sides: LitSides::Both }).collect();
        let light = lit.shoot(200_000, |source| TriangleLight::shoot(source, &|_| {}));
        let balance = light.balance();
        assert!((balance.total_flux - 48.0).abs() < 1e-5, "24 m2 on both sides");
        let escaped = balance.escaped as f64 / balance.emitted as f64;
        assert!((escaped - 0.5).abs() < 0.005 && balance.refused == 0, "{escaped}");
        for light in light.irradiance(&lit.model) {
            // 1 / (1 - 0.5) on the inside; 16,700 photons a triangle.
            let inside = light.front.mean() + light.back.mean();
            assert!((inside - 2.0).abs() < 0.08, "{inside}");
            assert!(light.front.count == 0 || light.back.count == 0);
        }
    }

    #[test]
    fn light_is_that_of_a_side_and_of_the_bounces_that_count() {
        // Photons from above fall on the front of a floor that faces up, and on the back of one that faces down.
        let mut lit = lamp_over_floor();
        lit.model.reflectance.fill(0.5);
        let up = lit.shoot(2_000, |source| TriangleLight::shoot(source, &|_| {}));
        for triangle in &mut lit.model.triangles {
            std::mem::swap(&mut triangle.b, &mut triangle.c);
        }
        let down = Lit::new(lit.model.clone())
            .shoot(2_000, |source| TriangleLight::shoot(source, &|_| {}));
        for (up, down) in up.irradiance(&lit.model).zip(down.irradiance(&lit.model)) {
            assert!(up.front.count > 900 && up.back.count == 0);
            assert_eq!((down.front.count, down.back), (0, up.front));
        }
        let lit = uniform_furnace(0.5);
        let [all, direct, indirect] =
            [Bounces::All, Bounces::Direct, Bounces::Indirect].map(|bounces| {
                lit.shoot(2_000, |source| {
                    let source = PhotonSource { bounces, ..source.clone() };
                    let light = TriangleLight::shoot(&source, &|_| {});
                    let hits = first_hits(&source, usize::MAX).len() as u32;
                    let counts =
                        light.irradiance(&lit.model).map(|one| one.front.count + one.back.count);
                    assert_eq!(counts.sum::<u32>(), hits);
                    hits
                })
            });
        assert_eq!((direct, all), (2_000, direct + indirect));
    }
}
