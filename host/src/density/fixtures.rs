//! Fixtures of this folder's tests: scenes whose irradiance has a closed form.

use arboleda::{IndexKind, Options, OwnedIndex, Vec3};

use super::{PhotonMap, PhotonSource, Receiver};
use crate::photon::fixtures::{closed_box, quad};
use crate::scene::{AreaLight, Model};

/// Model with an index over it.
pub struct Lit {
    pub model: Model,
    pub index: OwnedIndex,
}

impl Lit {
    pub fn new(model: Model) -> Self {
        Self::with(model, IndexKind::WideBvh)
    }

    pub fn with(model: Model, kind: IndexKind) -> Self {
        let index = OwnedIndex::build(kind, &model.scene(), &Options::DEFAULT).unwrap();
        Self { model, index }
    }

    /// Runs `work` with the first photons of the model.
    pub fn shoot<T>(&self, photons: u64, work: impl FnOnce(&PhotonSource<'_>) -> T) -> T {
        let index = self.index.index();
        work(&PhotonSource::new(&self.model, index.as_ray_index(), photons, 1))
    }

    pub fn map(&self, photons: u64) -> PhotonMap {
        self.shoot(photons, |source| PhotonMap::shoot(source, &|_| {}).unwrap())
    }
}

fn square(half: f32, z: f32) -> [arboleda::Triangle; 2] {
    let corner = Vec3::new(-half, -half, z);
    quad(corner, Vec3::X * (2.0 * half), Vec3::Y * (2.0 * half))
}

/// A lamp of 1 x 1 m and 100 W at a height of 1 m over a black floor of 16 x 16 m.
pub fn lamp_over_floor() -> Lit {
    let mut model = Model::named("lamp over floor");
    model.add_object("floor", square(8.0, 0.0), 0.0);
    model.lights.push(AreaLight::facing_down(Vec3::Z, 1.0, 1.0, 100.0));
    Lit::new(model)
}

/// A lamp of 2 x 2 m and 400 W at a height of 2 m over a black plate of 2 x 2 m in the air.
pub fn lamp_over_plate() -> Lit {
    let mut model = Model::named("lamp over plate");
    model.add_object("plate", square(1.0, 0.0), 0.0);
    model.lights.push(AreaLight::facing_down(Vec3::Z * 2.0, 2.0, 2.0, 400.0));
    Lit::new(model)
}

/// Lights on all faces of a box, facing inwards, of 1 W/m2.
fn faces_of(lo: Vec3, hi: Vec3) -> Vec<AreaLight> {
    let size = hi - lo;
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * size);
    let face = |axis: usize, upper: bool| {
        let (across, u, v) = (axes[axis], axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
        // u x v points along the axis, which is inwards on the lower face.
        let (corner, edge_u, edge_v) = if upper { (lo + across, v, u) } else { (lo, u, v) };
        AreaLight { corner, edge_u, edge_v, flux: u.length() * v.length() }
    };
    (0..3).flat_map(|axis| [face(axis, false), face(axis, true)]).collect()
}

/// A closed box of 2 m, of which every face emits 1 W/m2: the irradiance is `1 / (1 - reflectance)` everywhere.
pub fn uniform_furnace(reflectance: f32) -> Lit {
    let mut model = Model::named("uniform furnace");
    let (lo, hi) = (Vec3::ZERO, Vec3::splat(2.0));
    model.add_object("box", closed_box(lo, hi), reflectance);
    model.lights = faces_of(lo, hi);
    Lit::new(model)
}

/// A box of 4 x 2 x 2 m with a thin wall at x = 2, the left half of which is a black furnace of 1 W/m2.
pub fn furnace_behind_a_wall() -> Lit {
    let mut model = Model::named("thin wall");
    let hi = Vec3::new(4.0, 2.0, 2.0);
    model.add_object("box", closed_box(Vec3::ZERO, hi), 0.0);
    model.add_object("wall", quad(Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::Z * 2.0), 0.0);
    model.lights = faces_of(Vec3::ZERO, Vec3::splat(2.0));
    Lit::new(model)
}

/// Turns a vector by a rotation that leaves no axis where it was.
pub fn turned(v: Vec3) -> Vec3 {
    Vec3::new(
        0.6 * v.x - 0.64 * v.y + 0.48 * v.z,
        0.8 * v.x + 0.48 * v.y - 0.36 * v.z,
        0.6 * v.y + 0.8 * v.z,
    )
}

/// Receiver on a floor that faces up.
pub fn on_floor(x: f32, y: f32) -> Receiver {
    Receiver::new(Vec3::new(x, y, 0.0), Vec3::Z).unwrap()
}

/// Asserts that a value is within a relative tolerance.
pub fn assert_near(value: f64, expected: f64, tolerance: f64, what: &str) {
    let error = value / expected - 1.0;
    assert!(error.abs() <= tolerance, "{what}: {value}, expected {expected}, off by {error:.5}");
}
