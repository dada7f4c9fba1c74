//! Viewpoint: a camera that shows what photons light, for pictures without a given eye.
//!
//! Nine cameras are tried: from above a corner, level from each of four sides, and from inside near each of four sides.
//! A few photons are shot. A camera's score is the number of their hits that it sees, from the side on which the photon
//! fell. The camera above a closed room scores 0, because the ceiling hides all hits.

use arboleda::{Aabb, Ray, RayIndex, Vec3};

use crate::density::{PhotonSource, Receiver};
use crate::photon::{Segment, Side, Visitor};
use crate::report::Camera;
use crate::scene::Model;

/// Photons whose hits are counted.
const PHOTONS: u64 = 1024;
/// Factor by which a camera's score must exceed that of the best camera before it in the list.
const BETTER: f64 = 1.3;
/// Field of view of a camera outside and inside, in degrees.
const OUTSIDE: f32 = 40.0;
const INSIDE: f32 = 75.0;

/// Chooses a camera of a model.
pub fn viewpoint(source: &PhotonSource<'_>, up: Vec3, size: (u32, u32)) -> Camera {
    let model = source.model;
    let bounds = model.bounds();
    let first = source.photons.start;
    let few = PhotonSource { photons: first..first.saturating_add(PHOTONS), ..source.clone() };
    let mut lit = Vec::new();
    few.stream(&|_| {}, &LitPoints { model }, |points| lit.extend(points));

    let from_above = Camera::looking_at(&bounds, up, size.0, size.1);
    let mut best = (score(&from_above, source.index, &lit), from_above);
    for camera in level_cameras(&bounds, up, size) {
        let score = score(&camera, source.index, &lit);
        if score as f64 > best.0 as f64 * BETTER {
            best = (score, camera);
        }
    }
    best.1
}

/// Lists cameras that look level at the middle of a box: from outside, then from inside.
fn level_cameras(bounds: &Aabb, up: Vec3, size: (u32, u32)) -> Vec<Camera> {
    let (side, depth) = if up == Vec3::Y { (Vec3::X, Vec3::NEG_Z) } else { (Vec3::X, Vec3::Y) };
    let (centre, half) = (bounds.centre(), (bounds.hi - bounds.lo) * 0.5);
    let aspect = size.1 as f32 / size.0 as f32;
    let mut cameras = Vec::new();
    for inside in [false, true] {
        for direction in [depth, -depth, side, -side] {
            let deep = half.dot(direction.abs());
            let back = if inside {
                0.96 * deep
            } else {
                // The near side of the box fills the picture but for a margin.
                let across = half.dot(direction.cross(up).abs());
                let tangent = libm::tanf(OUTSIDE.to_radians() * 0.5);
                deep + 1.06 * (across / tangent).max(half.dot(up) / (tangent * aspect))
            };
            let field_of_view = if inside { INSIDE } else { OUTSIDE };
            cameras.extend(Camera::at(centre - direction * back, centre, up, field_of_view, size));
        }
    }
    cameras
}

/// Counts the points that a camera sees on their lit side.
fn score(camera: &Camera, index: &(dyn RayIndex + Sync), lit: &[(Vec3, Vec3)]) -> usize {
    let (width, height) = camera.size();
    let sees = |(point, normal): &&(Vec3, Vec3)| {
        let inside = camera.project(*point).is_some_and(|(x, y, _)| {
            (0.0..width as f32).contains(&x) && (0.0..height as f32).contains(&y)
        });
        let towards = *point - camera.eye();
        inside
            && towards.dot(*normal) < 0.0
            && Ray::with_interval(camera.eye(), towards, 0.0, 0.999)
                .is_ok_and(|ray| !index.occluded(&ray))
    };
    lit.iter().filter(sees).count()
}

/// Collects the points that photons hit, with the normal on the lit side.
struct LitPoints<'m> {
    model: &'m Model,
}

impl Visitor for LitPoints<'_> {
    type State = Vec<(Vec3, Vec3)>;

    fn begin(&self) -> Self::State {
        Vec::new()
    }

    fn visit(&self, points: &mut Self::State, segment: &Segment) {
        let Some(hit) = segment.hit else { return };
        let Some(triangle) = self.model.triangles.get(hit.triangle.0 as usize) else { return };
        let Some(at) = Receiver::at_hit(triangle, &hit, segment.ray.direction()) else { return };
        let normal = triangle.normal();
        let front = Side::hit(triangle, &segment.ray, &hit) == Side::Front;
        points.push((at.position(), if front { normal } else { -normal }));
    }
}
