//! Rules by which a segment of a photon's path counts for a disc.

use arboleda::Vec3;

use crate::density::receiver::{Receiver, distance_squared};
use crate::photon::Segment;
use crate::vector::Vector64;

/// Segment in `f64`.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    origin: Vector64,
    direction: Vector64,
    /// Hit point at the end; `None` if the photon leaves the scene.
    end: Option<Vector64>,
}

impl Flight {
    /// Creates the flight of a segment that ends at `end`, the hit point in `f32`.
    pub fn new(segment: &Segment, end: Option<Vec3>) -> Self {
        Self {
            origin: segment.ray.origin().into(),
            direction: segment.ray.direction().into(),
            end: end.map(Vector64::from),
        }
    }
}

/// Size of a disc, and how far before it a segment may end.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Squared radius.
    pub radius_squared: f64,
    /// Largest height above the plane of the end of a segment that counts as one that reaches the plane.
    pub beyond: f64,
    /// Largest distance from the plane of a point that lies in the plane up to rounding.
    pub slack: f64,
}

/// Point at which a segment crosses a disc.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// Offset from the centre.
    pub offset: Vector64,
    /// Squared distance from the centre.
    pub distance_squared: f64,
}

/// Decides whether a segment crosses a disc from the front.
///
/// 1. It comes from the front: its direction leads against the normal.
/// 2. It begins in front of the plane.
/// 3. It reaches the plane: it ends on the plane or behind it or at most `beyond` before it, or it leaves the scene.
/// 4. The crossing is at most the radius away from the centre. If the end lies in the plane up to rounding, the end is
///    the crossing, as for a photon map; else it is the point where the line meets the plane.
#[inline]
pub fn crossing(receiver: &Receiver, flight: &Flight, reach: &Reach) -> Option<Crossing> {
    let (centre, normal) = (receiver.point(), receiver.normal());
    let along = flight.direction.dot(normal);
    let height = (flight.origin - centre).dot(normal);
    // Both comparisons are false for NaN, which does not occur.
    if !(along < 0.0 && height > 0.0) {
        return None;
    }
    let end = flight.end.map(|end| (end, (end - centre).dot(normal)));
    let point = match end {
        Some((_, above)) if above > reach.beyond + reach.slack => return None,
        Some((end, above)) if above.abs() <= reach.slack => end,
        _ => flight.origin + flight.direction * (height / -along),
    };
    let squared = distance_squared(point, centre);
    let inside = squared <= reach.radius_squared;
    inside.then(|| Crossing { offset: point - centre, distance_squared: squared })
}
