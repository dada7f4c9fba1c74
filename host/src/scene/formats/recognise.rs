//! Recognition of scene files' formats.

use std::path::Path;

use super::stl;
use crate::files::signature::Signature;
use crate::scene::SceneError;

/// Format of scene files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Gltf,
    Obj,
    Ply,
    Stl,
}

/// Recognises the format of a file:
///
/// - PLY and glTF by the first bytes or the ending of the name;
/// - STL by the ending, or by the contents if the ending is not `.obj`;
/// - OBJ for all other files.
///
/// # Errors
/// [`SceneError::Foreign`] for a file recognised as another kind.
pub(super) fn format(bytes: &[u8], name: &Path) -> Result<Format, SceneError> {
    if let Some(signature) = Signature::of(bytes) {
        let cure = match signature {
            Signature::Gzip => "unpack it first, with `gunzip`",
            Signature::Zip => "unpack it first, with `unzip`",
            Signature::Utf16 => "save it as UTF-8, as by `iconv -f UTF-16 -t UTF-8`",
            Signature::Npy => "rays are given to `cast` by `--rays`",
            Signature::Fbx => "export it as OBJ, PLY, STL or glTF",
            Signature::Index => {
                "`cast` and `inspect` read indices X.arb; --index-file takes X.arb with its scene X.arb.scene"
            }
        };
        return Err(SceneError::Foreign { file: name.into(), kind: signature.kind(), cure });
    }
    let ending = name.extension().unwrap_or_default().to_ascii_lowercase();
    let ending = ending.to_str().unwrap_or_default();
    Ok(if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") || ending == "ply" {
        Format::Ply
    } else if bytes.starts_with(b"glTF")
        || bytes.trim_ascii_start().starts_with(b"{")
        || matches!(ending, "glb" | "gltf")
    {
        Format::Gltf
    } else if ending == "stl" || (ending != "obj" && (stl::is_binary(bytes) || stl::is_text(bytes)))
    {
        Format::Stl
    } else {
        Format::Obj
    })
}
