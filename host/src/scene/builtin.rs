//! The scenes that need no file, by name.

use arboleda::Vec3;

use super::city::{CityOptions, procedural_city};
use super::light::DEFAULT_FLUX;
use super::mixed::{MixedOptions, mixed_sizes};
use super::{AreaLight, Model, SceneError, paper, shapes};

/// A scene that needs no file.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// What to call it on command lines.
    pub name: &'static str,
    /// What it is, in one line.
    pub description: &'static str,
    build: fn() -> Model,
}

impl Builtin {
    /// Makes the scene; the same bits each time.
    pub fn build(&self) -> Model {
        (self.build)()
    }
}

/// All of them.
pub const ALL: &[Builtin] = &[
    entry("fig2", "six groups of a few objects, six clusters (paper, figure 2)", paper::fig2),
    entry("fig3", "two distant clusters of 512 cubes each (figure 3)", paper::fig3),
    entry("fig4a", "a floor and five teapots, 2 clusters (figure 4a)", paper::fig4a),
    entry("fig4b", "a floor and five teapots, 3 clusters (figure 4b)", paper::fig4b),
    entry("fig4c", "a floor and five teapots, 4 clusters (figure 4c)", paper::fig4c),
    entry("fig4d", "as fig4c and a very large teapot (figure 4d)", paper::fig4d),
    entry("fig4e", "as fig4c and a very small teapot (figure 4e)", paper::fig4e),
    entry("city", "324 buildings in 36 blocks, with streets and ground", || {
        procedural_city(CityOptions::default())
    }),
    entry("mixed", "300 balls, boxes and teapots, sizes 1 to 1000", || {
        mixed_sizes(MixedOptions::default())
    }),
    entry("sphere", "a closed sphere of 20,480 triangles, lit from above", sphere),
];

const fn entry(name: &'static str, description: &'static str, build: fn() -> Model) -> Builtin {
    Builtin { name, description, build }
}

/// The names of all built-in scenes.
pub fn names() -> impl Iterator<Item = &'static str> {
    ALL.iter().map(|scene| scene.name)
}

/// A built-in scene, if there is one of this name.
pub fn by_name(name: &str) -> Option<Model> {
    ALL.iter().find(|scene| scene.name == name).map(Builtin::build)
}

/// A built-in scene.
///
/// # Errors
/// [`SceneError::UnknownScene`], which lists the names there are.
pub fn require(name: &str) -> Result<Model, SceneError> {
    by_name(name).ok_or_else(|| SceneError::UnknownScene { name: name.into() })
}

/// The names, for messages.
pub(super) fn list() -> String {
    names().collect::<Vec<_>>().join(", ")
}

fn sphere() -> Model {
    let mut model = Model::named("sphere");
    model.add_object("sphere", shapes::closed_sphere(5), 0.5);
    model.lights.push(AreaLight::facing_down(Vec3::Z * 2.0, 1.0, 1.0, DEFAULT_FLUX));
    model
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_complete() {
        for entry in ALL {
            let model = entry.build();
            assert_eq!(model.name, entry.name);
            assert!(!entry.description.contains('\n'));
            let count = model.triangles.len();
            assert!(count > 0);
            assert_eq!((model.objects.len(), model.reflectance.len()), (count, count));
            assert!(model.triangles.iter().all(arboleda::Triangle::is_finite));
            assert!(
                model.objects.iter().all(|&object| (object as usize) < model.object_names.len())
            );
            assert!(model.reflectance.iter().all(|share| (0.0..=1.0).contains(share)));
            let flux: f32 = model.lights.iter().map(|light| light.flux).sum();
            assert_eq!(flux, 100.0);
            let top = model.bounds().hi.z;
            for light in &model.lights {
                assert!(light.corner.z > top, "{}", entry.name);
                assert!(light.edge_u.cross(light.edge_v).z < 0.0);
            }
        }
    }

    #[test]
    fn an_unknown_name_is_answered_with_the_names() {
        assert!(by_name("fig5").is_none());
        let message = require("fig5").unwrap_err().to_string();
        assert_eq!(
            message,
            "there is no built-in scene `fig5`; there are: fig2, fig3, fig4a, fig4b, fig4c, fig4d, \
             fig4e, city, mixed, sphere"
        );
    }
}
