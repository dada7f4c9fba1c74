//! Scene of several files, as if they stood one after another: their triangles, objects and names follow each other.
//!
//! ```text
//! a.obj tiles/ -> a.obj, tiles/1.stl, tiles/2.stl -> (origin of all) -> a Model for each -> one Model, or a stream
//! ```
//! - A folder stands for the scene files in it and in its folders, sorted by path; what begins with a dot, and folders that
//!   are links, are left out.
//! - Files are read one after another, and converted with one origin. To find it, `auto` reads them all before.
//! - Objects of one name in two files are two objects.
//! - A file without faces is left out with a warning, unless all are.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::formats;
use super::surface::{Extent, RoundingLoss};
use super::{Model, Origin, SceneError};

/// Endings of the files that a folder stands for.
const ENDINGS: [&str; 5] = ["obj", "ply", "stl", "gltf", "glb"];

/// Files of a scene, in order.
#[derive(Clone, Debug)]
pub struct SceneFiles {
    /// At least one.
    paths: Vec<PathBuf>,
    title: String,
}

impl SceneFiles {
    /// Lists the files that are named, one by one or by their folder.
    ///
    /// # Errors
    /// [`SceneError::Unreadable`] for a folder that cannot be read, [`SceneError::NoSceneFiles`] for one without scene
    /// files.
    pub fn list(named: &[PathBuf]) -> Result<Self, SceneError> {
        let paths = Self::paths_of(named)?;
        warn_of_twins(&paths);
        let Some(first) = named.first() else {
            return Err(SceneError::NoSceneFiles { folder: PathBuf::new() });
        };
        let name = if first.is_dir() { first.file_name() } else { first.file_stem() };
        let name = name.unwrap_or(first.as_os_str()).to_string_lossy();
        let title = match named.len() - 1 {
            0 => name.into_owned(),
            more => format!("{name} and {more} more"),
        };
        Ok(Self { paths, title })
    }

    /// Lists the paths of files that are named, as [`list`](Self::list) does, without a warning.
    ///
    /// # Errors
    /// The errors of [`list`](Self::list).
    pub fn paths_of(named: &[PathBuf]) -> Result<Vec<PathBuf>, SceneError> {
        let mut paths = Vec::new();
        for path in named {
            if path.is_dir() {
                let before = paths.len();
                list_folder(path, &mut paths)?;
                if paths.len() == before {
                    return Err(SceneError::NoSceneFiles { folder: path.clone() });
                }
                paths[before..].sort();
            } else {
                paths.push(path.clone());
            }
        }
        Ok(paths)
    }

    /// The paths of the files.
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }

    /// Name of the scene for headings: that of the file or folder.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Loads all files as one model. Logs the warnings.
    ///
    /// # Errors
    /// The errors of [`formats::load`]; each names its file.
    pub fn load(&self, origin: Origin) -> Result<Model, SceneError> {
        if let [path] = self.paths.as_slice() {
            let model = formats::load(path, origin)?;
            return Ok(Model { name: self.title.clone(), ..model });
        }
        let mut whole = Model::named(self.title.clone());
        whole.origin = self.each(origin, |_, part| {
            whole.append(part);
            Ok::<(), SceneError>(())
        })?;
        Ok(whole)
    }

    /// Reads one file after the other, and passes its model to `take`. Returns the origin that was subtracted from all.
    /// Logs the warnings.
    ///
    /// # Errors
    /// The errors of [`formats::load`] and of `take`.
    pub fn each<E: From<SceneError>>(
        &self,
        origin: Origin,
        mut take: impl FnMut(&Path, Model) -> Result<(), E>,
    ) -> Result<[f64; 3], E> {
        // 1. The origin of all files.
        let mut extent = Extent::default();
        if origin == Origin::Automatic {
            for path in &self.paths {
                match formats::read_file(path) {
                    Ok(surface) => extent.join(&surface.extent()),
                    Err(error) => self.tolerate(error)?,
                }
            }
        }
        let point = origin.point(|| extent);
        // 2. The files.
        let mut loss = RoundingLoss::default();
        let (mut is_empty, mut first_empty) = (true, None);
        for path in &self.paths {
            let part =
                formats::read_file(path).and_then(|surface| surface.place_part(point, &mut loss));
            match part {
                Ok(import) => {
                    import.warnings.iter().for_each(|warning| log::warn!("{warning}"));
                    is_empty = false;
                    take(path, import.model)?;
                }
                Err(error) => {
                    let text = error.to_string();
                    self.tolerate(error)?;
                    log::warn!("{text}; the file is left out");
                    first_empty.get_or_insert_with(|| path.clone());
                }
            }
        }
        if let (true, Some(path)) = (is_empty, first_empty) {
            // The error of the first, read again, stands for all.
            formats::read_file(&path).and_then(|surface| surface.place_part(point, &mut loss))?;
        }
        // 3. What the whole scene loses.
        if let Some(warning) = loss.warning() {
            log::warn!("{}: {warning}", self.title);
        }
        origin.log(&self.title, point, "the files'");
        Ok(point)
    }

    /// Passes an error on, unless it says that one of several files has no faces.
    fn tolerate(&self, error: SceneError) -> Result<(), SceneError> {
        let is_empty =
            matches!(error, SceneError::NoFaces { .. } | SceneError::NoFiniteFaces { .. });
        if is_empty && self.paths.len() > 1 { Ok(()) } else { Err(error) }
    }
}

/// Warns of files that are in the scene twice, or perhaps: by one path, or by one name with two endings.
fn warn_of_twins(paths: &[PathBuf]) {
    let mut seen = HashMap::new();
    for path in paths {
        if let Some(other) = seen.insert(path.with_extension(""), path) {
            log::warn!("{} and {} are both in the scene", other.display(), path.display());
        }
    }
}

/// Lists the scene files in a folder and below it, in any order.
fn list_folder(folder: &Path, paths: &mut Vec<PathBuf>) -> Result<(), SceneError> {
    let unreadable = |source| SceneError::Unreadable { file: folder.into(), source };
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let path = entry.path();
        if entry.file_name().as_encoded_bytes().starts_with(b".") {
            continue;
        }
        // A link to a folder is not followed, because it may lead back.
        if entry.file_type().map_err(unreadable)?.is_dir() {
            list_folder(&path, paths)?;
        } else if path.is_file() {
            let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
            if ENDINGS.iter().any(|known| ending == *known) {
                paths.push(path);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    fn write(folder: &Path, name: &str, text: &str) {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    #[test]
    fn a_folder_stands_for_its_scene_files_sorted() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        for name in ["b.obj", "a/2.PLY", "a/1.stl", "a.mtl", ".hidden.obj", "c.png", "a.glb"] {
            write(at, name, "");
        }
        let list = |named: &[PathBuf]| {
            let files = SceneFiles::list(named)?;
            let names = files.paths().iter().map(|path| path.strip_prefix(at).unwrap().to_owned());
            Ok::<_, SceneError>(names.map(|name| name.display().to_string()).collect::<Vec<_>>())
        };
        assert_eq!(list(&[at.into()]).unwrap(), ["a/1.stl", "a/2.PLY", "a.glb", "b.obj"]);
        let named = [at.join("b.obj"), at.join("a"), at.join("b.obj")];
        assert_eq!(list(&named).unwrap(), ["b.obj", "a/1.stl", "a/2.PLY", "b.obj"]);
        fs::create_dir(at.join("none")).unwrap();
        let error = list(&[at.join("none")]).unwrap_err().to_string();
        assert!(error.contains("none: no scene files"), "{error}");
        assert_eq!(SceneFiles::list(&[at.join("b.obj")]).unwrap().title(), "b");
        assert_eq!(SceneFiles::list(&named).unwrap().title(), "b and 2 more");
    }

    #[test]
    fn files_are_read_as_if_they_stood_one_after_another() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        write(at, "m.mtl", "newmtl red\nKd 0.9 0 0\nnewmtl lamp\nKe 5 5 5\n");
        let first = format!("{TRIANGLE}o one\nf 1 2 3\no two\nf 3 2 1\n");
        let second =
            format!("mtllib m.mtl\n{TRIANGLE}o two\nusemtl red\nf 1 2 3\nusemtl lamp\nf 1 3 2\n");
        write(at, "1.obj", &first);
        write(at, "2.obj", &second);
        write(at, "3.obj", "v 0 0 0\n");
        let model = SceneFiles::list(&[at.into()]).unwrap().load(Origin::Unchanged).unwrap();
        assert_eq!(model.triangles.len(), 4);
        assert_eq!(model.object_names, ["one", "two", "two"]);
        assert_eq!(model.objects, [0, 1, 2, 2]);
        assert_eq!(model.reflectance.len(), 4);
        assert_eq!(model.colours[0], [model.reflectance[0]; 3]);
        assert_eq!(model.colours[2], [0.9, 0.0, 0.0]);
        assert_eq!(model.emitters.iter().map(|light| light.triangle).collect::<Vec<_>>(), [3]);

        // The same with the coloured file first.
        let turned = [at.join("2.obj"), at.join("1.obj")];
        let model = SceneFiles::list(&turned).unwrap().load(Origin::Unchanged).unwrap();
        assert_eq!(model.objects, [0, 0, 1, 2]);
        assert_eq!(model.colours[0], [0.9, 0.0, 0.0]);
        assert_eq!(model.colours[3], [model.reflectance[3]; 3]);
    }

    #[test]
    fn the_origin_is_that_of_all_files() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        write(at, "1.obj", "v 1000 0 0\nv 1001 0 0\nv 1000 1 0\nf 1 2 3\n");
        write(at, "2.obj", "v 2000 0 0\nv 2001 0 0\nv 2000 1 0\nf 1 2 3\n");
        let files = SceneFiles::list(&[at.into()]).unwrap();
        let model = files.load(Origin::Automatic).unwrap();
        assert_eq!(model.origin[0], 1500.0);
        assert_eq!((model.triangles[0].a.x, model.triangles[1].a.x), (-500.0, 500.0));
        let model = files.load(Origin::At([1.0, 0.0, 0.0])).unwrap();
        assert_eq!((model.origin[0], model.triangles[1].a.x), (1.0, 1999.0));
    }

    #[test]
    fn errors_name_the_file_and_the_line() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        write(at, "1.obj", &format!("{TRIANGLE}f 1 2 3\n"));
        write(at, "2.obj", &format!("{TRIANGLE}f 1 2 9\n"));
        let load = || SceneFiles::list(&[at.into()]).unwrap().load(Origin::Automatic);
        let error = load().unwrap_err().to_string();
        assert!(error.contains("2.obj, line 4: a face names vertex 9"), "{error}");
        write(at, "1.obj", "v 0 0 0\n");
        write(at, "2.obj", "v 0 0 0\n");
        let error = load().unwrap_err().to_string();
        assert!(error.contains("1.obj: no faces"), "{error}");
    }
}
