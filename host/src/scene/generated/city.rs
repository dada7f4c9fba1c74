//! City on a grid: blocks of buildings with streets between them.
//!
//! ```text
//! +--+--+   +--+--+     a block: buildings_per_side^2 plots, one building in each
//! |# |# |   |# |# |     # a building: walls divided by storeys and window columns, a roof
//! +--+--+   +--+--+
//!    street
//! ```
//! The unit is a metre; z is up. Each building has a flat roof with a box on it, or a pointed roof.

use arboleda::{Aabb, Triangle, Vec3};

use super::hash::Draws;
use super::shapes;
use crate::scene::model::DEFAULT_FLUX;
use crate::scene::{AreaLight, Model};

/// Options of a city. The defaults give about 70,000 triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CityOptions {
    /// Blocks along x and along y.
    pub blocks: [u32; 2],
    /// Buildings along each side of a block.
    pub buildings_per_side: u32,
    /// Most storeys of a building; the fewest are 2.
    pub most_storeys: u32,
    /// Quads along each storey of a wall. More quads give more triangles on the same surface.
    pub window_columns: u32,
    /// Variation of footprints and heights, from 0 for buildings of one size to 1 for the largest variation.
    pub size_spread: f32,
    /// Ground: a square of two triangles under each block and its street, 2 m below the streets.
    pub ground: bool,
    /// Seed of the random sizes and roofs.
    pub seed: u64,
}

impl Default for CityOptions {
    fn default() -> Self {
        Self {
            blocks: [6, 6],
            buildings_per_side: 3,
            most_storeys: 12,
            window_columns: 5,
            size_spread: 0.7,
            ground: true,
            seed: 1,
        }
    }
}

/// Side of a plot in metres.
const PLOT: f32 = 24.0;
/// Distance of neighbouring blocks in metres.
const STREET: f32 = 18.0;
/// Height of a storey in metres.
const STOREY: f32 = 3.0;
/// Gap between the ground and the buildings in metres. Buildings do not touch the ground, as in surveyed city models.
const GROUND_BELOW: f32 = 2.0;

/// Builds a city; each building is an object.
///
/// A building of `s` storeys and `c` window columns has `8 s c + 2 + 12` triangles with a flat roof and `8 s c + 2 + 4`
/// with a pointed roof. The 2 are its bottom.
pub fn procedural_city(options: CityOptions) -> Model {
    let mut model = Model::named("city");
    let per_side = options.buildings_per_side;
    let pitch = PLOT * per_side as f32 + STREET;
    let [columns, rows] = options.blocks;
    for block in 0..u64::from(columns) * u64::from(rows) {
        let (column, row) = (block % u64::from(columns), block / u64::from(columns));
        let corner = Vec3::new(column as f32 * pitch, row as f32 * pitch, 0.0);
        for plot in 0..u64::from(per_side) * u64::from(per_side) {
            let number = block * u64::from(per_side) * u64::from(per_side) + plot;
            let (x, y) = (plot % u64::from(per_side), plot / u64::from(per_side));
            let centre = Vec3::new((x as f32 + 0.5) * PLOT, (y as f32 + 0.5) * PLOT, 0.0);
            let building = building(corner + centre, &options, Draws::new(options.seed, number));
            model.add_object(format!("building {number}"), building, 0.5);
        }
        if options.ground {
            let half = pitch * 0.5;
            let centre =
                corner + Vec3::new(half - STREET * 0.5, half - STREET * 0.5, -GROUND_BELOW);
            model.add_object(format!("ground {block}"), shapes::floor(centre, pitch, 1), 0.3);
        }
    }
    let bounds = model.bounds();
    if !bounds.is_empty() {
        let [width, depth, _] = bounds.extent();
        let centre = bounds.centre().with_z(bounds.hi.z + 30.0);
        model.lights.push(AreaLight::facing_down(centre, width as f32, depth as f32, DEFAULT_FLUX));
    }
    model
}

fn building(centre: Vec3, options: &CityOptions, draws: Draws) -> Vec<Triangle> {
    let spread = if options.size_spread >= 0.0 { options.size_spread.min(1.0) } else { 0.0 };
    // At full spread, footprints have sides of 6 to 20 m, so neighbours are at least 4 m apart. Low heights are more
    // frequent.
    let side = |nth| PLOT * (0.75 + spread * draws.between(nth, -0.5, 0.083));
    let (width, depth) = (side(0), side(1));
    let low = 1.0 - spread * (1.0 - draws.unit(2) * draws.unit(3));
    let storeys = ((options.most_storeys as f32 * low) as u32).max(2);
    let columns = options.window_columns.max(1);
    let half = Vec3::new(width * 0.5, depth * 0.5, 0.0);
    let height = storeys as f32 * STOREY;
    let (lo, hi) = (centre - half, centre + half + Vec3::Z * height);

    // 1. Four walls, and the bottom.
    let mut triangles = Vec::new();
    let mut emit = |triangle| triangles.push(triangle);
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let ring = [(lo.x, lo.y), (hi.x, lo.y), (hi.x, hi.y), (lo.x, hi.y)];
    for side in 0..4 {
        let ((x0, y0), (x1, y1)) = (ring[side], ring[(side + 1) % 4]);
        let wall = [at(x0, y0, lo.z), at(x1, y1, lo.z), at(x1, y1, hi.z), at(x0, y0, hi.z)];
        shapes::patch(wall, columns, storeys, &mut emit);
    }
    let floor = [0, 3, 2, 1].map(|corner: usize| at(ring[corner].0, ring[corner].1, lo.z));
    shapes::patch(floor, 1, 1, &mut emit);

    // 2. The roof. Its edges lie on those of the walls but are not divided by the walls' corners.
    let eaves = ring.map(|(x, y)| at(x, y, hi.z));
    if draws.unit(4) < 0.5 {
        let top = at(centre.x, centre.y, hi.z + width.min(depth) * 0.4);
        for side in 0..4 {
            emit(Triangle::new(eaves[side], eaves[(side + 1) % 4], top));
        }
    } else {
        shapes::patch(eaves, 1, 1, &mut emit);
        // A box for stairs or lifts, without its bottom, which lies on the roof.
        let size = draws.between(5, 0.15, 0.3);
        let cabin = half * size + Vec3::Z * STOREY;
        let foot = at(centre.x, centre.y, hi.z);
        let cabin = Aabb::new(foot - cabin.with_z(0.0), foot + cabin);
        triangles.extend(shapes::cuboid(cabin, 1).into_iter().skip(2));
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cities_scale_from_hundreds_to_millions() {
        let size = |blocks, buildings_per_side, window_columns| {
            let options = CityOptions {
                blocks,
                buildings_per_side,
                window_columns,
                ..CityOptions::default()
            };
            procedural_city(options).triangles.len()
        };
        assert!((100..1_000).contains(&size([2, 1], 2, 1)));
        let usual = procedural_city(CityOptions::default()).triangles.len();
        assert!((50_000..150_000).contains(&usual), "{usual}");
        let large = size([12, 12], 4, 8);
        assert!(large > 500_000, "{large}");
    }

    #[test]
    fn cities_are_functions_of_their_options() {
        let options = CityOptions::default();
        let city = procedural_city(options);
        assert_eq!(city, procedural_city(options));
        assert_ne!(city, procedural_city(CityOptions { seed: 2, ..options }));
        assert!(city.triangles.iter().all(|t| t.is_finite() && t.normal() != Vec3::ZERO));
        assert_eq!(city.object_names.len(), 36 * 9 + 36);
    }

    #[test]
    fn buildings_keep_their_distance_and_face_outwards() {
        let options = CityOptions { ground: false, size_spread: 1.0, ..CityOptions::default() };
        let city = procedural_city(options);
        let mut boxes = vec![Aabb::EMPTY; city.object_names.len()];
        for (triangle, &object) in city.triangles.iter().zip(&city.objects) {
            let bounds = &mut boxes[object as usize];
            *bounds = bounds.union(triangle.bounds());
        }
        for (at, a) in boxes.iter().enumerate() {
            assert!(boxes[..at].iter().all(|b| a.gap_squared(b) >= 3.9 * 3.9));
        }
        for (triangle, &object) in city.triangles.iter().zip(&city.objects) {
            let centre = boxes[object as usize].centre();
            let out = triangle.normal().dot(triangle.at(0.3, 0.3) - centre.with_z(triangle.a.z));
            assert!(out > 0.0 || triangle.normal().z != 0.0);
        }
    }

    #[test]
    fn no_blocks_and_no_spread_are_fine() {
        let none = CityOptions { blocks: [0, 3], ..CityOptions::default() };
        assert!(procedural_city(none).triangles.is_empty());
        let alike = CityOptions { size_spread: 0.0, ground: false, ..CityOptions::default() };
        assert_eq!(procedural_city(alike).bounds().lo.z, 0.0);
        let least = CityOptions { most_storeys: 0, window_columns: 0, ..CityOptions::default() };
        assert!(!procedural_city(least).triangles.is_empty());
    }
}
