//! Memory that reading a scene file takes, which has to fit: a file is read as a whole.

use std::path::{Path, PathBuf};

use crate::scene::SceneError;
use crate::scene::formats::gltf;

/// Bytes of memory for each byte of a file, by its ending: an estimate from above.
///
/// # Measured
/// - Peak of the memory while files of the shortest lines and numbers were read, by their length: OBJ 16 (6.5 for a mesh
///   whose vertices are used twice), PLY as text 5 and as bytes 9, STL as text 1.4 and as bytes 2.9.
const FACTORS: [(&str, u64); 5] = [("obj", 20), ("stl", 5), ("ply", 16), ("gltf", 24), ("glb", 24)];
/// Bytes up to which a document is read to find the files beside it. A larger one has its buffers in itself.
const MOST_OF_DOCUMENT: u64 = 1 << 26;
/// Factor of files without such an ending.
const LARGEST: u64 = 24;

/// File of a scene that takes the most memory to read.
pub struct LargestFile {
    /// The file.
    pub path: PathBuf,
    /// Bytes of memory, estimated.
    pub bytes: u64,
}

/// Finds the file that takes most memory to read.
///
/// # Errors
/// If there is no such file.
pub fn largest(paths: &[PathBuf]) -> Result<LargestFile, SceneError> {
    let mut largest = LargestFile { path: PathBuf::new(), bytes: 0 };
    for path in paths {
        let found = std::fs::metadata(path);
        let own =
            found.map_err(|source| SceneError::Unreadable { file: path.clone(), source })?.len();
        let ending = path.extension().unwrap_or_default();
        let beside = if ending.eq_ignore_ascii_case("gltf") && own <= MOST_OF_DOCUMENT {
            gltf::bytes_beside(path)
        } else {
            0
        };
        let bytes = own.saturating_add(beside).saturating_mul(factor(path));
        if bytes >= largest.bytes {
            largest = LargestFile { path: path.clone(), bytes };
        }
    }
    Ok(largest)
}

fn factor(path: &Path) -> u64 {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    FACTORS.iter().find(|(known, _)| ending == *known).map_or(LARGEST, |&(_, factor)| factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_beside_a_document_count() {
        let folder = tempfile::tempdir().unwrap();
        let [document, buffer, mesh] =
            ["a.gltf", "a b.bin", "c.stl"].map(|name| folder.path().join(name));
        let text = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"a%20b.bin","byteLength":9}]}"#;
        std::fs::write(&document, text).unwrap();
        std::fs::write(&buffer, [0; 5000]).unwrap();
        std::fs::write(&mesh, [0; 10_000]).unwrap();
        let found = largest(&[mesh, document.clone()]).unwrap();
        assert_eq!((found.path, found.bytes), (document, (text.len() as u64 + 5000) * 24));
    }
}
