//! Default light of models without lights, and the axis that points up.
//!
//! ```text
//!      ===========     as large as the footprint, facing down
//!        5% of the diagonal
//!      +---------+
//!      |  model  |
//! ```

use std::fmt;
use std::str::FromStr;

use arboleda::{Aabb, Vec3};

use super::{AreaLight, Model};
use crate::scene::SceneError;

/// Axis that points up in a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// Guess by the shape of the model. `Z` if the z extent is less than half the x extent and less than half the y
    /// extent, as in a city; else `Y`, the convention of most OBJ files.
    #[default]
    Auto,
    /// y points up.
    Y,
    /// z points up.
    Z,
}

impl UpAxis {
    /// Replaces `Auto` by `Y` or `Z`, for a model with these bounds.
    #[must_use]
    pub fn resolved(self, bounds: &Aabb) -> Self {
        let [x, y, z] = bounds.extent();
        match self {
            Self::Auto if 2.0 * z < x && 2.0 * z < y => Self::Z,
            Self::Auto => Self::Y,
            given => given,
        }
    }

    /// Returns the direction that points up in a model.
    #[must_use]
    pub fn vector(self, model: &Model) -> Vec3 {
        if self.resolved(&model.bounds()) == Self::Z { Vec3::Z } else { Vec3::Y }
    }
}

impl FromStr for UpAxis {
    type Err = SceneError;

    fn from_str(text: &str) -> Result<Self, SceneError> {
        match text {
            "auto" => Ok(Self::Auto),
            "y" | "Y" => Ok(Self::Y),
            "z" | "Z" => Ok(Self::Z),
            _ => Err(SceneError::UnknownAxis { given: text.into() }),
        }
    }
}

impl fmt::Display for UpAxis {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Auto => "auto",
            Self::Y => "y",
            Self::Z => "z",
        })
    }
}

/// Power of the default light in watts: that of an old light bulb.
pub(in crate::scene) const DEFAULT_FLUX: f32 = 100.0;

impl AreaLight {
    /// Creates a rectangular light in the plane `z = centre.z` that faces down, towards smaller z.
    pub fn facing_down(centre: Vec3, width: f32, depth: f32, flux: f32) -> Self {
        Self {
            corner: centre - Vec3::new(width * 0.5, depth * 0.5, 0.0),
            // Y cross X = -Z.
            edge_u: Vec3::Y * depth,
            edge_v: Vec3::X * width,
            flux,
        }
    }
}

impl Model {
    /// Adds a light of 100 W to a model without lights. The light is a rectangle over the model's footprint, a
    /// twentieth of the diagonal above its top, facing down. A model with lights or without triangles stays as it is.
    #[must_use]
    pub fn with_default_light(mut self, up: UpAxis) -> Self {
        let bounds = self.bounds();
        if !self.lights.is_empty() || !self.emitters.is_empty() || bounds.is_empty() {
            return self;
        }
        let extent = bounds.extent();
        let diagonal = bounds.diagonal_squared().sqrt();
        // A vertical wall has a footprint without area, and a single point has no extent; the light needs an area.
        let least = if diagonal > 0.0 { diagonal * 0.05 } else { 1.0 };
        let side = |axis: usize| extent[axis].max(least);
        let (height, across) = match up.resolved(&bounds) {
            UpAxis::Z => (2, [1, 0]), // Y cross X = -Z
            _ => (1, [0, 2]),         // X cross Z = -Y
        };
        let centre = bounds.centre().to_array();
        let mut corner = centre.map(f64::from);
        corner[height] = f64::from(bounds.hi.to_array()[height]) + least;
        let edges = across.map(|axis| {
            corner[axis] -= side(axis) * 0.5;
            let mut edge = [0.0; 3];
            edge[axis] = side(axis);
            finite(edge)
        });
        self.lights.push(AreaLight {
            corner: finite(corner),
            edge_u: edges[0],
            edge_v: edges[1],
            flux: DEFAULT_FLUX,
        });
        self
    }
}

/// Clamps a vector to finite `f32` values. A model may reach the limits of `f32`, and its light would lie beyond.
fn finite(vector: [f64; 3]) -> Vec3 {
    let limit = f64::from(f32::MAX);
    Vec3::from_array(vector.map(|coordinate| coordinate.clamp(-limit, limit) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes;

    fn boxed(size: Vec3) -> Model {
        let mut model = Model::default();
        model.add_object("box", shapes::cuboid(Aabb::new(Vec3::ZERO, size), 1), 0.5);
        model
    }

    #[test]
    fn lights_face_down_from_above() {
        for (size, up, down) in [
            (Vec3::new(10.0, 8.0, 2.0), UpAxis::Auto, Vec3::NEG_Z),
            (Vec3::new(10.0, 2.0, 8.0), UpAxis::Auto, Vec3::NEG_Y),
            (Vec3::new(10.0, 8.0, 2.0), UpAxis::Y, Vec3::NEG_Y),
            (Vec3::new(1.0, 1.0, 1.0), UpAxis::Auto, Vec3::NEG_Y),
            (Vec3::new(1.0, 1.0, 9.0), UpAxis::Z, Vec3::NEG_Z),
        ] {
            let model = boxed(size).with_default_light(up);
            let [light] = model.lights[..] else { panic!("one light") };
            assert_eq!(light.edge_u.cross(light.edge_v).normalize(), down, "{size} {up}");
            assert!((light.corner - size).dot(-down) > 0.0, "above the top");
            let covered = Aabb::EMPTY
                .with_point(light.corner)
                .with_point(light.corner + light.edge_u + light.edge_v);
            for axis in (0..3).filter(|&axis| down[axis] == 0.0) {
                assert_eq!((covered.lo[axis], covered.hi[axis]), (0.0, size[axis]));
            }
            assert_eq!(light.flux, 100.0);
        }
    }

    #[test]
    fn a_model_with_a_light_or_without_triangles_is_left_alone() {
        assert_eq!(Model::default().with_default_light(UpAxis::Y), Model::default());
        let lit = boxed(Vec3::ONE).with_default_light(UpAxis::Y);
        assert_eq!(lit.clone().with_default_light(UpAxis::Z), lit);
    }

    #[test]
    fn extreme_models_get_finite_lights() {
        let lo = Vec3::splat(f32::MIN);
        for hi in [Vec3::splat(f32::MAX), lo, lo.with_x(0.0)] {
            let mut model = Model::default();
            model.add_object("extreme", [arboleda::Triangle::new(lo, hi, lo)], 0.5);
            let model = model.with_default_light(UpAxis::Auto);
            let light = model.lights[0];
            assert!(
                light.corner.is_finite() && light.edge_u.is_finite() && light.edge_v.is_finite()
            );
        }
    }

    #[test]
    fn axes_are_read_and_refused() {
        for axis in [UpAxis::Auto, UpAxis::Y, UpAxis::Z] {
            assert_eq!(axis.to_string().parse::<UpAxis>().unwrap(), axis);
        }
        let error = "x".parse::<UpAxis>().unwrap_err().to_string();
        assert_eq!(error, "`x` is not an axis that points up; use y, z or auto");
    }
}
