//! Scenes that need no file, by name.

use arboleda::Vec3;

use super::generated::city::{CityOptions, procedural_city};
use super::generated::mixed::{MixedOptions, mixed_sizes};
use super::generated::{paper, shapes, sized};
use super::model::DEFAULT_FLUX;
use super::{AreaLight, Model, SceneError};

/// Scene that needs no file.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// Name on command lines.
    pub name: &'static str,
    /// Description in one line.
    pub description: &'static str,
    build: fn() -> Model,
}

impl Builtin {
    /// Makes the scene. The bits are the same each time.
    pub fn build(&self) -> Model {
        (self.build)()
    }
}

/// All built-in scenes of a fixed size.
pub const ALL: &[Builtin] = &[
    entry("fig2", "six groups of a few objects, six clusters (paper, figure 2)", paper::fig2),
    entry("fig3", "two distant clusters of 512 cubes each (figure 3)", paper::fig3),
    entry("fig4a", "a floor and a pile of five teapots, 2 clusters (figure 4a)", paper::fig4a),
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

/// Name of a scene of any size, and the function that makes it with about the given number of triangles.
type SizedScene = (&'static str, fn(u32) -> Model);

/// Scenes of any size: `mesh-1000000` names a mesh of about a million triangles. They are not in [`ALL`], whose scenes
/// run by default, because they may be large.
pub(crate) const SIZED: [SizedScene; 2] = [("mesh", sized::mesh_of), ("city", sized::city_of)];

/// Triangles of the scene `mesh` without a size.
const MESH_TRIANGLES: u32 = 125_000;

/// Lists the names of all built-in scenes of a fixed size.
pub fn names() -> impl Iterator<Item = &'static str> {
    ALL.iter().map(|scene| scene.name)
}

/// Makes the built-in scene of this name, if there is one: a scene of [`ALL`], `mesh`, or `mesh-N` or `city-N` with
/// about N triangles.
pub fn by_name(name: &str) -> Option<Model> {
    if let Some(scene) = ALL.iter().find(|scene| scene.name == name) {
        return Some(scene.build());
    }
    let mut model = if name == "mesh" { sized::mesh_of(MESH_TRIANGLES) } else { of_size(name)? };
    name.clone_into(&mut model.name);
    Some(model)
}

/// Makes a scene whose name ends in its number of triangles.
fn of_size(name: &str) -> Option<Model> {
    let (family, size) = name.rsplit_once('-')?;
    let (_, build) = SIZED.iter().find(|(name, _)| *name == family)?;
    let size = size.parse().ok().filter(|&size| size <= sized::MOST_TRIANGLES)?;
    Some(build(size))
}

/// Makes the built-in scene of this name.
///
/// # Errors
/// [`SceneError::UnknownScene`], which lists the known names.
pub fn require(name: &str) -> Result<Model, SceneError> {
    by_name(name).ok_or_else(|| SceneError::UnknownScene { name: name.into() })
}

/// Lists the names for messages.
pub(super) fn list() -> String {
    let names = names().collect::<Vec<_>>().join(", ");
    format!(
        "{names}, mesh; mesh-N and city-N have about N triangles, at most {}",
        sized::MOST_TRIANGLES
    )
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
             fig4e, city, mixed, sphere, mesh; mesh-N and city-N have about N triangles, at most \
             100000000"
        );
    }

    #[test]
    fn scenes_of_a_size_are_named_with_it() {
        let [mesh, city] = ["mesh-1200", "city-3000"].map(|name| require(name).unwrap());
        assert_eq!((mesh.name.as_str(), mesh.triangles.len()), ("mesh-1200", 1_200));
        assert_eq!((city.name.as_str(), city.lights.len()), ("city-3000", 1));
        assert_eq!(require("mesh").unwrap().triangles.len(), 124_848);
        for wrong in ["mesh-", "mesh-1e6", "mesh--1", "mesh-100000001", "sphere-100", "-5"] {
            assert!(by_name(wrong).is_none(), "{wrong}");
        }
    }
}
