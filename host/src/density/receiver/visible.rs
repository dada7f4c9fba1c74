//! Visible part of a disc: a polygon around the point from which rays along the disc's plane are blocked.
//!
//! ```text
//!        .--*--.            rays along the plane, a little above it, each up to the radius
//!      *'   |   '*
//!     |   \ | /   \         *  a corner of the polygon: the end of a ray
//!   ##*-----x------*
//!   ##|   / | \   /         #  a wall: rays end at it
//!      *.   |   .*
//!        '--*--'
//! ```
//! Photons count only inside the polygon, and its area takes the place of the disc's. So walls neither darken a point
//! at their foot nor let light from behind them through. The polygon is exact for straight walls that no two
//! neighbouring rays straddle. A point exactly in the plane of a wall sees nothing, because its side of the wall is not
//! known.
//!
//! # Source
//! The idea that the kernel's domain is what the point sees: *Photon mapping with visible kernel domains*, The Visual
//! Computer 2018. The polygon is ours.

use std::f64::consts::TAU;

use arboleda::{Ray, RayIndex};

use super::Receiver;
use super::kernel::Kernel;
use crate::photon::surface::hemisphere::tangents;
use crate::scene::vector::Vector64;

/// Rays of a polygon. In the open, 32 corners cover 0.9936 of the disc.
pub const RAYS: usize = 32;
/// Rays of a quarter.
const QUARTER: usize = RAYS / 4;

/// Directions of the rays in the plane. The first one is repeated at the end.
#[derive(Clone, Debug)]
pub struct Fan {
    directions: [(f64, f64); RAYS + 1],
    half_sector_cosine: f64,
}

impl Default for Fan {
    fn default() -> Self {
        // Quarters of one another, so that the rays along the axes are exactly along them.
        let at = |ray: usize| {
            let angle = TAU * (ray % QUARTER) as f64 / RAYS as f64;
            let (x, y) = (libm::cos(angle), libm::sin(angle));
            [(x, y), (-y, x), (-x, -y), (y, -x)][ray / QUARTER % 4]
        };
        Self {
            directions: std::array::from_fn(at),
            half_sector_cosine: libm::cos(0.5 * TAU / RAYS as f64),
        }
    }
}

/// Visible polygon of a receiver.
#[derive(Clone, Debug)]
pub struct VisiblePolygon<'f> {
    fan: &'f Fan,
    /// Radius of the disc.
    radius: f64,
    tangent: Vector64,
    bitangent: Vector64,
    /// Distance of each corner from the centre.
    reach: [f32; RAYS],
    /// Squared radius of a circle inside the polygon.
    inner_squared: f64,
}

impl Fan {
    /// Computes the polygon of a receiver. The rays run `lift` above its plane, and at least so far above it that
    /// rounding cannot put them behind it.
    pub fn polygon(
        &self,
        receiver: &Receiver,
        radius: f64,
        lift: f64,
        index: &(dyn RayIndex + Sync),
    ) -> VisiblePolygon<'_> {
        let slack = receiver.slack(radius);
        let (tangent, bitangent) = tangents(receiver.normal());
        let origin = (receiver.point() + receiver.normal() * lift.max(slack)).rounded();
        let mut reach = [radius as f32; RAYS];
        for (reach, &(x, y)) in reach.iter_mut().zip(&self.directions) {
            let direction = (tangent * x + bitangent * y).rounded();
            let ray = Ray::with_interval(origin, direction, 0.0, radius as f32);
            if let Some(hit) = ray.ok().and_then(|ray| index.closest_hit(&ray)) {
                // Photons on the wall's far side are as near as rounding allows, so the corner stays before the wall.
                *reach = (f64::from(hit.t) - 2.0 * slack).max(0.0) as f32;
            }
        }
        // The distance of an edge from the centre is at least that of its nearer corner times the cosine of half a
        // sector, unless the angle at that corner is obtuse; then the corner is the nearest point.
        let nearest = f64::from(reach.iter().copied().fold(f32::INFINITY, f32::min));
        let inner = nearest * self.half_sector_cosine;
        VisiblePolygon {
            fan: self,
            radius,
            tangent,
            bitangent,
            reach,
            inner_squared: inner * inner,
        }
    }
}

impl VisiblePolygon<'_> {
    /// Returns the corner of a ray, or of ray 0 for [`RAYS`], in the frame of the plane.
    fn corner(&self, ray: usize) -> (f64, f64) {
        let (x, y) = self.fan.directions[ray];
        let reach = f64::from(self.reach[ray % RAYS]);
        (x * reach, y * reach)
    }

    /// Tells whether a point lies in the polygon, once it is projected along the normal. `offset` leads from the centre
    /// to the point.
    pub(in crate::density) fn contains(&self, offset: Vector64) -> bool {
        let (x, y) = (offset.dot(self.tangent), offset.dot(self.bitangent));
        if x * x + y * y < self.inner_squared {
            return true;
        }
        let turn = libm::atan2(y, x) / TAU * RAYS as f64;
        let sector = (if turn < 0.0 { turn + RAYS as f64 } else { turn }) as usize % RAYS;
        let (from, to) = (self.corner(sector), self.corner(sector + 1));
        (to.0 - from.0) * (y - from.1) - (to.1 - from.1) * (x - from.0) >= 0.0
    }

    /// Computes the integral of the kernel over the polygon: its area, for the constant kernel.
    pub fn area(&self, kernel: Kernel) -> f64 {
        let radius_squared = self.radius * self.radius;
        let part = |sector: usize| {
            let (a, b) = (self.corner(sector), self.corner(sector + 1));
            let area = 0.5 * (a.0 * b.1 - a.1 * b.0);
            match kernel {
                Kernel::Constant => area,
                // The mean of the squared distance over a triangle with a corner at the centre.
                Kernel::Epanechnikov => {
                    let squared =
                        a.0 * a.0 + a.1 * a.1 + b.0 * b.0 + b.1 * b.1 + a.0 * b.0 + a.1 * b.1;
                    area * 2.0 * (1.0 - squared / 6.0 / radius_squared)
                }
            }
        };
        (0..RAYS).map(part).fold(0.0, |sum, part| sum + part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::density::fixtures::{Lit, assert_near, turned};
    use crate::photon::fixtures::quad;
    use crate::scene::Model;
    use arboleda::Vec3;

    #[test]
    fn a_wall_cuts_the_polygon_before_it_also_off_the_axes() {
        let radius = 0.2;
        for (place, plane) in [
            ((|point| point) as fn(Vec3) -> Vec3, "along the axes"),
            (|point| turned(point) + Vec3::new(103.7, -41.3, 17.9), "turned"),
        ] {
            // A wall stands on the plane z = 0 along the y axis.
            let [corner, along, up] =
                [Vec3::new(0.0, -9.0, 0.0), Vec3::Y * 9.0, Vec3::Z * 3.0].map(place);
            let origin = place(Vec3::ZERO);
            let wall = quad(corner, (along - origin) * 2.0, up - origin);
            let mut model = Model::named("wall");
            model.add_object("wall", wall, 0.5);
            let lit = Lit::new(model);
            let (index, fan) = (lit.index.index(), Fan::default());
            for step in 1..=40 {
                let (away, y) = (0.0073 * step as f32, 0.1 * step as f32 - 2.0);
                let position = place(Vec3::new(away, y, 0.0));
                let receiver = Receiver::new(position, place(Vec3::Z) - origin).unwrap();
                let polygon = fan.polygon(&receiver, radius, 0.0, index.as_ray_index());
                // Not the foot of the wall, nor what is behind it.
                for (x, across) in
                    [(0.0, 0.0), (0.0, 0.05), (0.0, -0.11), (-1e-4, 0.02), (-0.1, 0.0)]
                {
                    let point = place(Vec3::new(x, y + across, 0.0));
                    let offset = Vector64::from(point) - receiver.point();
                    assert!(!polygon.contains(offset), "{plane}: {away} {x} {across}");
                }
                let near = place(Vec3::new(away * 0.9, y, 0.0));
                assert!(
                    polygon.contains(Vector64::from(near) - receiver.point()),
                    "{plane}: {away}"
                );
                // The 32-gon without the part behind the wall. Two rays straddle each end of the cut.
                let share = (f64::from(away) / radius).min(1.0);
                let cut = (libm::acos(share) - share * (1.0 - share * share).sqrt()) / (TAU / 2.0);
                let area = TAU / 2.0 * radius * radius * (0.993_587 - cut);
                assert_near(polygon.area(Kernel::Constant), area, 0.05, plane);
            }
        }
    }
}
