//! Balls, boxes and teapots of widely different sizes, strewn in space.
//!
//! The hard case for size classes, grids and octrees: sizes are uniform on a logarithmic scale, without gaps. Each
//! object lies inside one cell of a cubic lattice, so no two overlap.

use arboleda::{Aabb, Triangle, Vec3};

use super::hash::Draws;
use super::shapes;
use super::teapot::{Placement, placed, teapot};
use crate::scene::model::DEFAULT_FLUX;
use crate::scene::{AreaLight, Model};

/// Options of the scene. The defaults give about 150,000 triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixedOptions {
    /// Number of objects.
    pub object_count: u32,
    /// Ratio of the largest to the smallest size, 1 or more.
    pub size_ratio: f32,
    /// Subdivision, 0 to 6; each step makes four times as many triangles.
    pub detail: u32,
    /// Seed of the random sizes and positions.
    pub seed: u64,
}

impl Default for MixedOptions {
    fn default() -> Self {
        Self { object_count: 300, size_ratio: 1000.0, detail: 2, seed: 1 }
    }
}

/// Side of the largest lattice; its cube is larger than every `u32`.
const MOST_SIDE: u32 = 1_626;

/// Largest value of `detail`.
const MOST_DETAIL: u32 = 6;

/// Strews objects, a third of each kind, with sizes uniform on a logarithmic scale.
///
/// At detail `d` a ball has `20 * 4^d` triangles, a box `12 * 4^d`, a teapot `64 * 4^d - 8 * 2^d`.
pub fn mixed_sizes(options: MixedOptions) -> Model {
    let mut model = Model::named("mixed");
    let detail = options.detail.min(MOST_DETAIL);
    let (ball, pot) = (shapes::closed_sphere(detail), teapot(1 << detail));
    let cube = shapes::cuboid(Aabb::new(Vec3::NEG_ONE, Vec3::ONE), 1 << detail);
    let steps =
        libm::log2f(if options.size_ratio >= 1.0 { options.size_ratio.min(1e9) } else { 1.0 });
    // The smallest cubic lattice with a cell for each object.
    let room = |side: &u32| u64::from(*side).pow(3) >= u64::from(options.object_count);
    let side = (1..=MOST_SIDE).find(room).unwrap_or(MOST_SIDE);
    for number in 0..options.object_count {
        let draws = Draws::new(options.seed, u64::from(number));
        // Cells have side 1. The largest objects, of radius 0.45, fill their cell; small ones lie anywhere in it.
        let radius = 0.45 * libm::exp2f(-steps * draws.unit(0));
        let free = 0.49 - radius;
        let within = |nth| draws.between(nth, -free, free);
        let cell = Vec3::new(
            (number % side) as f32,
            (number / side % side) as f32,
            (number / (side * side)) as f32,
        );
        let centre = cell + Vec3::new(within(1), within(2), within(3));
        let (name, shape, scale, lift) = match draws.below(4, 3) {
            0 => ("ball", &ball, 1.0, 0.0),
            // Scales to radius 1: a cube's corners are sqrt(3) from its centre; a teapot's handle and spout 3.5, and
            // its half height is 1.6.
            1 => ("box", &cube, 0.57, 0.0),
            _ => ("teapot", &pot, 0.28, 0.4),
        };
        let base = centre - Vec3::Z * (radius * lift);
        let placement = Placement { base, scale: radius * scale, quarter_turns: draws.below(5, 4) };
        let triangles: Vec<Triangle> = placed(shape, placement);
        model.add_object(format!("{name} {number}"), triangles, draws.between(6, 0.2, 0.8));
    }
    let bounds = model.bounds();
    if !bounds.is_empty() {
        let [width, depth, height] = bounds.extent();
        let above = bounds.hi.z + height as f32 * 0.1;
        model.lights.push(AreaLight::facing_down(
            bounds.centre().with_z(above),
            width as f32,
            depth as f32,
            DEFAULT_FLUX,
        ));
    }
    model
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxes(model: &Model) -> Vec<Aabb> {
        let mut boxes = vec![Aabb::EMPTY; model.object_names.len()];
        for (triangle, &object) in model.triangles.iter().zip(&model.objects) {
            let bounds = &mut boxes[object as usize];
            *bounds = bounds.union(triangle.bounds());
        }
        boxes
    }

    #[test]
    fn objects_do_not_overlap_and_sizes_are_mixed() {
        let boxes = boxes(&mixed_sizes(MixedOptions::default()));
        for (at, a) in boxes.iter().enumerate() {
            assert!(boxes[..at].iter().all(|b| a.gap_squared(b) > 0.0));
        }
        let sizes = || boxes.iter().map(|b| b.diagonal_squared().sqrt());
        let (least, most) = (sizes().fold(9.0, f64::min), sizes().fold(0.0, f64::max));
        assert!(most / least > 300.0, "{least} to {most}");
    }

    #[test]
    fn scenes_scale_from_hundreds_to_millions() {
        let size = |object_count, detail| {
            mixed_sizes(MixedOptions { object_count, detail, ..MixedOptions::default() })
                .triangles
                .len()
        };
        assert_eq!(size(0, 2), 0);
        assert!((100..1_000).contains(&size(10, 0)));
        assert!(size(500, 4) > 2_000_000);
        let usual = mixed_sizes(MixedOptions::default()).triangles.len();
        assert!((50_000..200_000).contains(&usual), "{usual}");
    }

    #[test]
    fn scenes_are_functions_of_their_options() {
        let options = MixedOptions::default();
        assert_eq!(mixed_sizes(options), mixed_sizes(options));
        assert_ne!(mixed_sizes(options), mixed_sizes(MixedOptions { seed: 2, ..options }));
    }
}
