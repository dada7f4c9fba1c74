//! Scenes of about a given number of triangles: a city, and one closed mesh.
//!
//! Indices that are equally fast on ten thousand triangles may differ on ten million, where they no longer fit a cache.

use arboleda::{Aabb, Triangle, Vec3};

use super::city::{CityOptions, procedural_city};
use super::shapes;
use crate::scene::model::DEFAULT_FLUX;
use crate::scene::vector::Vector64;
use crate::scene::{AreaLight, Model};

/// Most triangles of a scene: 3.6 GB.
pub const MOST_TRIANGLES: u32 = 100_000_000;

/// Makes a city of about `triangle_count` triangles, at least one block.
///
/// The city grows by blocks of the same kind. Below `SMALL_CITY` triangles, walls have fewer quads, so that the city
/// still has several buildings.
pub fn city_of(triangle_count: u32) -> Model {
    let mut options = CityOptions::default();
    if triangle_count < SMALL_CITY {
        options.window_columns = 1;
    }
    // Averages of 36 blocks. The number of a city depends on its buildings, and so on the seed.
    let block = if triangle_count < SMALL_CITY { SMALL_BLOCK } else { BLOCK };
    let blocks = (triangle_count / block).max(1);
    let columns = blocks.isqrt();
    options.blocks = [columns, (blocks + columns / 2) / columns];
    procedural_city(options)
}

/// Number of triangles below which walls are one quad wide.
const SMALL_CITY: u32 = 20_000;
/// Average number of triangles of a block.
const BLOCK: u32 = 1_950;
/// Average number of triangles of a block whose walls are one quad wide.
const SMALL_BLOCK: u32 = 460;

/// Makes one closed mesh of about `triangle_count` triangles: a ball around the origin with waves of two lengths. Every
/// ray from the origin meets the mesh once.
pub fn mesh_of(triangle_count: u32) -> Model {
    // Each face of a cube has `divisions^2` quads.
    let divisions = (triangle_count / 12).isqrt().max(1);
    let cube = Aabb::new(Vec3::NEG_ONE, Vec3::ONE);
    let surface = shapes::cuboid(cube, divisions);
    let mut model = Model::named("mesh");
    // A moved corner is a function of the corner alone, so shared corners stay equal and the mesh stays closed.
    let moved = surface.iter().map(|t| Triangle::new(wavy(t.a), wavy(t.b), wavy(t.c)));
    model.add_object("mesh", moved, 0.5);
    model.lights.push(AreaLight::facing_down(Vec3::Z * 2.0, 1.0, 1.0, DEFAULT_FLUX));
    model
}

/// Moves a point from the surface of the cube to the ball, then along its direction by the waves.
fn wavy(point: Vec3) -> Vec3 {
    // Equal steps of the angle. With equal steps of the coordinate, triangles near the cube's corners would be a fifth
    // as large as those in the middle of its faces.
    let warped =
        point.to_array().map(|x| libm::tan(f64::from(x + 0.0) * std::f64::consts::FRAC_PI_4));
    let warped = Vector64::from(warped);
    let direction = warped / warped.length();
    let Vector64 { x, y, z } = direction;
    let long = libm::sin(5.0 * x + 1.0) * libm::sin(4.0 * y) * libm::sin(6.0 * z + 2.0);
    let short = libm::sin(31.0 * x) * libm::sin(37.0 * y + 1.0) * libm::sin(29.0 * z);
    let radius = 1.0 + 0.2 * long + 0.03 * short;
    (direction * radius).rounded()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::closed::is_closed;

    #[test]
    fn sizes_are_about_what_was_asked_for() {
        for asked in [1_000, 5_000, 19_999, 20_000, 300_000] {
            for model in [city_of(asked), mesh_of(asked)] {
                let share = model.triangles.len() as f64 / f64::from(asked);
                assert!((0.75..1.25).contains(&share), "{} of {asked}: {share}", model.name);
            }
        }
        assert!(!city_of(0).triangles.is_empty());
        assert_eq!(mesh_of(0).triangles.len(), 12);
    }

    #[test]
    fn the_mesh_is_closed_around_the_origin() {
        let mesh = mesh_of(12_000);
        assert!(is_closed(&mesh.triangles));
        for triangle in &mesh.triangles {
            assert!(triangle.normal().dot(triangle.a) > 0.0);
            assert!((0.7..1.3).contains(&triangle.a.length()));
        }
    }
}
