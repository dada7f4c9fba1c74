//! Rules by which a segment of a photon's path counts for a disc.

use arboleda::Vec3;

use crate::density::receiver::{Receiver, distance_squared};
use crate::photon::Segment;
use crate::scene::vector::Vector64;

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

#[cfg(test)]
mod tests {
    use super::*;

    /// Crosses the disc of radius 1 around the origin that faces up.
    fn crossed(origin: Vec3, direction: Vec3, end: Option<Vec3>, beyond: f64) -> Option<Crossing> {
        let receiver = Receiver::new(Vec3::ZERO, Vec3::Z).unwrap();
        let flight =
            Flight { origin: origin.into(), direction: direction.into(), end: end.map(Vec3::into) };
        crossing(&receiver, &flight, &Reach { radius_squared: 1.0, beyond, slack: 1e-6 })
    }

    #[test]
    fn a_segment_counts_by_the_four_rules() {
        let (up, down) = (Vec3::Z, Vec3::NEG_Z);
        let at = |x: f32, z: f32| Vec3::new(x, 0.0, z);
        for (origin, direction, end, beyond, distance, rule) in [
            (at(0.5, 2.0), down, Some(at(0.5, 0.0)), 0.0, Some(0.5), "ends in the disc"),
            (at(0.5, 2.0), down, Some(at(0.5, -3.0)), 0.0, Some(0.5), "ends behind the disc"),
            (at(0.5, 2.0), down, None, 0.0, Some(0.5), "leaves the scene"),
            (at(-1.5, 2.0), at(1.0, -1.0), None, 0.0, Some(0.5), "slanting"),
            // 1. From the front.
            (at(0.5, -2.0), up, Some(at(0.5, 0.0)), 0.0, None, "from behind"),
            (at(0.5, -2.0), up, None, 0.0, None, "from behind, through the disc"),
            (at(0.5, 2.0), up, None, 0.0, None, "away from the disc"),
            (at(0.5, 2.0), Vec3::X, None, 0.0, None, "along the plane"),
            (at(0.5, 0.0), Vec3::X, Some(at(0.7, 0.0)), 0.0, None, "in the plane"),
            // 2. Begins in front.
            (at(0.5, -1.0), down, None, 0.0, None, "begins behind"),
            (at(0.5, 0.0), down, None, 0.0, None, "begins in the plane"),
            // 3. Reaches the plane.
            (at(0.5, 2.0), down, Some(at(0.5, 0.3)), 0.0, None, "ends before the plane"),
            (at(0.5, 2.0), down, Some(at(0.5, 0.3)), 0.2, None, "ends before the slack"),
            (at(0.5, 2.0), down, Some(at(0.5, 0.3)), 0.4, Some(0.5), "ends within the slack"),
            // 4. Inside, the border included; an end that is in the plane up to rounding is the crossing.
            (at(1.0, 2.0), down, None, 0.0, Some(1.0), "the border"),
            (at(1.1, 2.0), down, None, 0.0, None, "outside"),
            (at(0.5, 2.0), down, Some(at(0.25, 5e-7)), 0.0, Some(0.25), "an end above by rounding"),
            (
                at(0.5, 2.0),
                down,
                Some(at(0.25, -5e-7)),
                0.0,
                Some(0.25),
                "an end below by rounding",
            ),
        ] {
            let crossing = crossed(origin, direction, end, beyond);
            let found = crossing.map(|crossing| crossing.distance_squared.sqrt() as f32);
            assert_eq!(found, distance, "{rule}");
            if let Some(crossing) = crossing {
                assert_eq!(crossing.offset.dot(crossing.offset), crossing.distance_squared);
            }
        }
    }
}
