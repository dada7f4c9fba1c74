//! Carriers: triangles that contain discs, for the index that finds the discs which a segment may cross.
//!
//! ```text
//!            /\
//!           /  \          one carrier for discs that lie in one plane, next to each other
//!          / .. \
//!         / (oo) \        its inscribed circle contains them all, with a margin
//!        /  '..'  \
//!       /__________\
//! ```
//! A carrier costs a hit of the index, a disc a few multiplications. Discs of neighbouring pixels overlap almost
//! entirely, so a carrier of 16 discs is hit little more often than each of them.
//!
//! # Source
//! R. García, C. Ureña, J. Revelles, M. Lastra, R. Montes, *Density estimation optimizations for global illumination*,
//! for indexing the discs instead of the rays; carriers that several discs share are ours.

use std::ops::Range;

use arboleda::Triangle;

use crate::density::receiver::Receiver;
use crate::photon::surface::hemisphere::tangents;
use crate::scene::vector::Vector64;

/// Most discs of a carrier.
const MOST_DISCS: usize = 64;
/// Largest half side of the box around the centres of a carrier's discs, in radii.
const SPREAD: f64 = 0.5;
/// Factor by which a carrier's inscribed circle is larger than its discs need. Rounding to `f32` moves the carrier off
/// the plane by at most 2^-22 of its distance from the origin, the offset. A ray that crosses a disc can miss the
/// carrier only if its slope to the plane is below that offset over the margin, a sixteenth of the radius.
const MARGIN: f64 = 1.0625;

/// Carrier of consecutive discs.
#[derive(Clone, Debug)]
pub struct Carrier {
    /// Equilateral triangle.
    pub triangle: Triangle,
    /// Receivers of the discs.
    pub discs: Range<u32>,
}

/// Makes the carriers of the discs of a radius around receivers. Consecutive receivers share a carrier if they have the
/// same normal and plane, and are near each other. `None` if a corner is beyond the range of `f32`.
pub fn carriers(receivers: &[Receiver], radius: f64) -> Option<Vec<Carrier>> {
    let mut carriers = Vec::new();
    let mut first = 0;
    while let Some(receiver) = receivers.get(first) {
        let frame = ReceiverPlane::new(receiver, receiver.slack(radius));
        // The box around the centres, in the frame of the first.
        let (mut lo, mut hi) = ((0.0_f64, 0.0_f64), (0.0_f64, 0.0_f64));
        let mut end = first + 1;
        for next in receivers.iter().skip(end).take(MOST_DISCS - 1) {
            let Some((x, y)) = frame.place(next) else { break };
            let wider = ((lo.0.min(x), lo.1.min(y)), (hi.0.max(x), hi.1.max(y)));
            let side = (wider.1.0 - wider.0.0).max(wider.1.1 - wider.0.1);
            if side > 2.0 * SPREAD * radius {
                break;
            }
            (lo, hi) = wider;
            end += 1;
        }
        let (width, height) = (0.5 * (hi.0 - lo.0), 0.5 * (hi.1 - lo.1));
        let inscribed = MARGIN * (radius + (width * width + height * height).sqrt());
        let triangle = frame.equilateral((lo.0 + width, lo.1 + height), inscribed);
        if !triangle.is_finite() {
            return None;
        }
        carriers.push(Carrier { triangle, discs: first as u32..end as u32 });
        first = end;
    }
    Some(carriers)
}

/// Plane of a receiver, with two axes.
struct ReceiverPlane {
    centre: Vector64,
    normal: Vector64,
    tangent: Vector64,
    bitangent: Vector64,
    slack: f64,
}

impl ReceiverPlane {
    fn new(receiver: &Receiver, slack: f64) -> Self {
        let normal = receiver.normal();
        let (tangent, bitangent) = tangents(normal);
        Self { centre: receiver.point(), normal, tangent, bitangent, slack }
    }

    /// Returns the coordinates of a receiver along the two axes; `None` if it lies in another plane.
    fn place(&self, receiver: &Receiver) -> Option<(f64, f64)> {
        let offset = receiver.point() - self.centre;
        let same = receiver.normal() == self.normal && offset.dot(self.normal).abs() <= self.slack;
        same.then(|| (offset.dot(self.tangent), offset.dot(self.bitangent)))
    }

    /// Makes the triangle around a circle.
    fn equilateral(&self, (x, y): (f64, f64), inscribed: f64) -> Triangle {
        let corner = |across: f64, along: f64| {
            let point = self.centre
                + self.tangent * (x + across * inscribed)
                + self.bitangent * (y + along * inscribed);
            point.rounded()
        };
        let root = 3.0_f64.sqrt();
        Triangle::new(corner(0.0, 2.0), corner(-root, -1.0), corner(root, -1.0))
    }
}
