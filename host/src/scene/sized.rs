//! Scenes of about as many triangles as are asked for: a city, and one closed mesh.
//!
//! Indices that are alike at ten thousand triangles need not be at ten million: what no longer fits a
//! cache shows there.

use arboleda::{Aabb, Triangle, Vec3};

use super::city::{CityOptions, procedural_city};
use super::light::DEFAULT_FLUX;
use super::{AreaLight, Model, shapes};

/// The most triangles that may be asked for: 3.6 GB of them.
pub const MOST_TRIANGLES: u32 = 100_000_000;

/// A city of about `triangle_count` triangles, at least one block.
///
/// It grows by blocks, all alike in kind; below `SMALL_CITY` triangles the walls are coarser, so that
/// there still are several buildings.
pub fn city_of(triangle_count: u32) -> Model {
    let mut options = CityOptions::default();
    if triangle_count < SMALL_CITY {
        options.window_columns = 1;
    }
    // Measured on 36 blocks; which buildings there are, and so the number, depends on the seed.
    let block = if triangle_count < SMALL_CITY { SMALL_BLOCK } else { BLOCK };
    let blocks = (triangle_count / block).max(1);
    let columns = blocks.isqrt();
    options.blocks = [columns, (blocks + columns / 2) / columns];
    procedural_city(options)
}

/// Below it, walls are one quad wide.
const SMALL_CITY: u32 = 20_000;
/// Triangles of a block, on average.
const BLOCK: u32 = 1_950;
/// The same with walls one quad wide.
const SMALL_BLOCK: u32 = 460;

/// One closed mesh of about `triangle_count` triangles around the origin: a ball with waves of two
/// lengths, every direction from the middle meets it once.
pub fn mesh_of(triangle_count: u32) -> Model {
    // Each face of a cube has `divisions^2` quads.
    let divisions = (triangle_count / 12).isqrt().max(1);
    let cube = Aabb::new(Vec3::NEG_ONE, Vec3::ONE);
    let surface = shapes::cuboid(cube, divisions);
    let mut model = Model::named("mesh");
    // Corners with the same bits stay together: the place depends on nothing else.
    let moved = surface.iter().map(|t| Triangle::new(wavy(t.a), wavy(t.b), wavy(t.c)));
    model.add_object("mesh", moved, 0.5);
    model.lights.push(AreaLight::facing_down(Vec3::Z * 2.0, 1.0, 1.0, DEFAULT_FLUX));
    model
}

/// Moves a point of the cube's surface to the ball, and along its direction by the waves.
fn wavy(point: Vec3) -> Vec3 {
    // Equal steps of the angle rather than of the coordinate: triangles near a cube's corners would be
    // a fifth as large as in the middle of its faces.
    let warped =
        point.to_array().map(|x| libm::tan(f64::from(x + 0.0) * std::f64::consts::FRAC_PI_4));
    let [x, y, z] = warped;
    let length = (x * x + y * y + z * z).sqrt();
    let [x, y, z] = warped.map(|coordinate| coordinate / length);
    let long = libm::sin(5.0 * x + 1.0) * libm::sin(4.0 * y) * libm::sin(6.0 * z + 2.0);
    let short = libm::sin(31.0 * x) * libm::sin(37.0 * y + 1.0) * libm::sin(29.0 * z);
    let radius = 1.0 + 0.2 * long + 0.03 * short;
    Vec3::from_array([x, y, z].map(|coordinate| (coordinate * radius) as f32))
}

#[cfg(test)]
mod tests {
    use super::super::closed::is_closed;
    use super::*;

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
