//! Which format a file has.

use std::path::Path;

use crate::scene::SceneError;

/// A format that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Obj,
}

/// First bytes of files that are not read: what they are, and what to do.
const FOREIGN: [(&[u8], &str, &str); 6] = [
    (b"\x1f\x8b", "it is compressed by gzip", "unpack it first, with `gunzip`"),
    (b"PK\x03\x04", "it is a ZIP archive", "unpack it first, with `unzip`"),
    (b"\xff\xfe", UTF_16, UTF_8),
    (b"\xfe\xff", UTF_16, UTF_8),
    (b"\x93NUMPY", "it is a NumPy array", "rays are given by `cast --rays`"),
    (b"Kaydara FBX", "it is an FBX file", "export it as OBJ, PLY, STL or glTF"),
];
const UTF_16: &str = "it is text in UTF-16";
const UTF_8: &str = "save it as UTF-8, as by `iconv -f UTF-16 -t UTF-8`";

/// Recognises a format: by first bytes that only one has, else by the ending.
pub(super) fn format(bytes: &[u8], name: &Path) -> Result<Format, SceneError> {
    if let Some(&(_, kind, cure)) = FOREIGN.iter().find(|(first, ..)| bytes.starts_with(first)) {
        return Err(SceneError::Foreign { file: name.into(), kind, cure });
    }
    Ok(Format::Obj)
}
