//! Columns of a scene beside its triangles, and all else that its file has, streamed to temporary files.
//!
//! ```text
//! Model, Model, .. --append--> Columns<Appended> (files that grow) --view--> Columns<View> --> the scene's file
//! ```
//! The models follow each other as in [`Model::append`]: numbers of objects and ids of triangles are those of the whole
//! scene. Nothing of a model stays in memory but lights that are not triangles, which scene files do not have.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::ensure;
use arboleda::Triangle;

use super::{Pager, View};
use crate::index::packed::{SceneParts, Sequence, emitter_bytes, name_bytes};
use crate::scene::{AreaLight, Model};

/// Emitters or names that are converted at once.
const SOME: usize = 1 << 12;

/// Columns that are streamed beside the triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Nothing.
    Triangles,
    /// The object of each triangle.
    Objects,
    /// All that the scene's file has.
    Scene,
}

/// Bytes that are appended to a temporary file, which has no name.
pub struct Appended {
    writer: BufWriter<File>,
    length: usize,
}

impl Appended {
    fn new(folder: &Path) -> io::Result<Self> {
        let file = tempfile::tempfile_in(folder)?;
        Ok(Self { writer: BufWriter::with_capacity(1 << 20, file), length: 0 })
    }

    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.length += bytes.len();
        self.writer.write_all(bytes)
    }

    /// Maps what was appended so far.
    fn view(&mut self, pager: &Pager) -> io::Result<View> {
        self.writer.flush()?;
        View::new(self.writer.get_ref(), 0, self.length, pager)
    }
}

/// Columns by triangle, while they grow or when they are viewed.
pub struct Columns<B> {
    /// Object of each triangle, `u32`.
    objects: Option<B>,
    object_count: usize,
    triangle_count: usize,
    rest: Option<Rest<B>>,
}

/// Columns and lists that only the scene's file has.
struct Rest<B> {
    /// Reflectance of each triangle, `f32`.
    reflectance: B,
    /// Colour of each triangle, three `f32`, from the first file on that is not grey.
    colours: Option<B>,
    emitters: B,
    emitter_count: usize,
    names: B,
    lights: Vec<AreaLight>,
}

impl Columns<Appended> {
    /// Makes empty files in a folder.
    ///
    /// # Errors
    /// If the folder cannot be written to.
    pub fn new(wanted: Wanted, folder: &Path) -> io::Result<Self> {
        let new = || Appended::new(folder);
        let objects = if wanted == Wanted::Triangles { None } else { Some(new()?) };
        let rest = if wanted == Wanted::Scene {
            let (reflectance, emitters, names) = (new()?, new()?, new()?);
            let lights = Vec::new();
            Some(Rest { reflectance, colours: None, emitters, emitter_count: 0, names, lights })
        } else {
            None
        };
        Ok(Self { objects, object_count: 0, triangle_count: 0, rest })
    }

    /// Appends those of a file's model.
    ///
    /// # Errors
    /// If the disk is full, or numbers of 32 bits cannot name all objects.
    pub fn append(&mut self, model: &Model, folder: &Path, pager: &Pager) -> anyhow::Result<()> {
        if let Some(objects) = &mut self.objects {
            let count = self.object_count + model.object_names.len();
            let most = u32::MAX as usize;
            ensure!(count <= most, "{count} objects are more than numbers of 32 bits can name");
            let first = self.object_count as u32;
            model
                .objects
                .iter()
                .try_for_each(|object| objects.append(&(first + object).to_ne_bytes()))?;
        }
        if let Some(rest) = &mut self.rest {
            rest.append(model, self.triangle_count as u32, folder, pager)?;
        }
        self.object_count += model.object_names.len();
        self.triangle_count += model.triangles.len();
        Ok(())
    }

    /// Maps all files.
    ///
    /// # Errors
    /// If the disk is full.
    pub fn view(self, pager: &Pager) -> io::Result<Columns<View>> {
        let Self { objects, object_count, triangle_count, rest } = self;
        let view = |mut appended: Appended| appended.view(pager);
        let objects = objects.map(view).transpose()?;
        let rest = match rest {
            Some(rest) => Some(Rest {
                reflectance: view(rest.reflectance)?,
                colours: rest.colours.map(view).transpose()?,
                emitters: view(rest.emitters)?,
                emitter_count: rest.emitter_count,
                names: view(rest.names)?,
                lights: rest.lights,
            }),
            None => None,
        };
        Ok(Columns { objects, object_count, triangle_count, rest })
    }
}

impl Rest<Appended> {
    /// Appends those of a file's model, whose first triangle has the id `first` in the whole scene.
    fn append(
        &mut self,
        model: &Model,
        first: u32,
        folder: &Path,
        pager: &Pager,
    ) -> anyhow::Result<()> {
        // 1. Colours, from the first file on that has some. Those of the files before are grey.
        if self.colours.is_none() && !model.colours.is_empty() {
            let before = self.reflectance.view(pager)?;
            let mut colours = Appended::new(folder)?;
            append_grey(&mut colours, super::cast(&before)?)?;
            self.colours = Some(colours);
        }
        if let Some(colours) = &mut self.colours {
            if model.colours.is_empty() {
                append_grey(colours, &model.reflectance)?;
            } else {
                colours.append(bytemuck::cast_slice(&model.colours))?;
            }
        }

        // 2. What each file has.
        self.reflectance.append(bytemuck::cast_slice(&model.reflectance))?;
        for some in model.emitters.chunks(SOME) {
            self.emitters.append(&emitter_bytes(some, first)?)?;
        }
        self.emitter_count += model.emitters.len();
        for some in model.object_names.chunks(SOME) {
            self.names.append(&name_bytes(some)?)?;
        }
        self.lights.extend(&model.lights);
        Ok(())
    }
}

impl Columns<View> {
    /// The object of each triangle, if it was streamed.
    pub fn objects(&self) -> Option<&View> {
        self.objects.as_ref()
    }

    /// Number of bytes that are to be copied to the scene's file.
    pub fn bytes(&self) -> usize {
        let parts = self.rest.iter().flat_map(|rest| {
            let Rest { reflectance, colours, emitters, names, .. } = rest;
            [Some(reflectance), colours.as_ref(), self.objects(), Some(emitters), Some(names)]
        });
        parts.flatten().map(|view| view.bytes().len()).sum()
    }

    /// The parts of the scene's file; `None` unless all were streamed.
    pub fn scene<'v>(
        &'v self,
        name: &'v str,
        origin: [f64; 3],
        triangles: &'v [Triangle],
    ) -> Option<SceneParts<'v>> {
        let rest = self.rest.as_ref()?;
        Some(SceneParts {
            name,
            origin,
            lights: &rest.lights,
            emitters: Sequence { count: rest.emitter_count, bytes: rest.emitters.bytes() },
            triangles,
            reflectance: rest.reflectance.bytes(),
            colours: rest.colours.as_ref().map_or(&[], View::bytes),
            objects: self.objects.as_ref()?.bytes(),
            object_names: Sequence { count: self.object_count, bytes: rest.names.bytes() },
        })
    }
}

/// Appends grey colours, of which each share is the reflectance.
fn append_grey(colours: &mut Appended, reflectance: &[f32]) -> io::Result<()> {
    reflectance.iter().try_for_each(|&share| colours.append(bytemuck::bytes_of(&[share; 3])))
}

#[cfg(test)]
mod tests {
    use super::super::cast;
    use super::super::pager::tests::alone;
    use super::*;
    use crate::PackedScene;
    use crate::index::packed::digest_of;
    use crate::scene::builtin::require;
    use crate::scene::{FaceLight, LitSides};
    use arboleda::{IndexKind, Options, OwnedIndex};

    /// Three parts, of which those that `coloured` names have colours, and emit.
    fn parts(coloured: [bool; 3]) -> Vec<Model> {
        let parts = ["fig2", "fig3", "fig2"].into_iter().zip(coloured);
        let of = |(name, is_coloured): (&str, bool)| {
            let mut model = require(name).unwrap();
            let count = model.triangles.len();
            if is_coloured {
                model.colours = (0..count).map(|at| [0.5, 0.25, (at % 7) as f32 / 9.0]).collect();
                let light =
                    |triangle| FaceLight { triangle, radiance: [1.0; 3], sides: LitSides::Both };
                model.emitters = (0..count as u32).map(light).collect();
            }
            model
        };
        parts.map(of).collect()
    }

    #[test]
    fn the_scene_is_that_of_models_in_memory() {
        let _alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let pager = Pager::start(u64::MAX);
        for number in 0..8_u8 {
            let parts = parts([1, 2, 4].map(|bit| number & bit != 0));
            let mut columns = Columns::new(Wanted::Scene, at).unwrap();
            let mut triangles = Appended::new(at).unwrap();
            let mut whole = Model::named("three");
            whole.origin = [1e6, -2.5, 0.0];
            for part in parts {
                triangles.append(bytemuck::cast_slice(&part.triangles)).unwrap();
                columns.append(&part, at, &pager).unwrap();
                whole.append(part);
            }
            let (columns, triangles) =
                (columns.view(&pager).unwrap(), triangles.view(&pager).unwrap());
            let scene = columns.scene("three", whole.origin, cast(&triangles).unwrap()).unwrap();
            for kind in [IndexKind::WideBvh, IndexKind::LeanBvh] {
                let owned = OwnedIndex::build(kind, &whole.scene(), &Options::DEFAULT).unwrap();
                let index = owned.index();
                PackedScene::write(&at.join("a.arb"), &whole, &index).unwrap();
                scene.write(&at.join("b.scene"), &index, &digest_of(&index)).unwrap();
                let bytes = |name: &str| std::fs::read(at.join(name)).unwrap();
                assert!(bytes("a.arb.scene") == bytes("b.scene"), "{number} {}", kind.name());
            }
        }
        assert_eq!(std::fs::read_dir(at).unwrap().count(), 3, "columns have no names");
    }

    #[test]
    fn only_what_is_wanted_is_streamed() {
        let _alone = alone();
        let folder = tempfile::tempdir().unwrap();
        let pager = Pager::start(u64::MAX);
        let model = require("fig2").unwrap();
        for wanted in [Wanted::Triangles, Wanted::Objects] {
            let mut columns = Columns::new(wanted, folder.path()).unwrap();
            columns.append(&model, folder.path(), &pager).unwrap();
            columns.append(&model, folder.path(), &pager).unwrap();
            let columns = columns.view(&pager).unwrap();
            assert!(columns.scene("none", [0.0; 3], &[]).is_none());
            let objects = columns.objects().map(|view| cast::<u32>(view).unwrap());
            assert_eq!(objects.is_some(), wanted == Wanted::Objects);
            if let Some(objects) = objects {
                let (first, second) = objects.split_at(model.objects.len());
                let shift = model.object_names.len() as u32;
                assert_eq!(first, &model.objects[..]);
                assert!(second.iter().zip(first).all(|(&b, &a)| b == a + shift));
            }
        }
    }
}
