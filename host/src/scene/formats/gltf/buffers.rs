//! Buffers of a document: in the file, in a `data:` address, or in files beside it.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use base64::{Engine, alphabet};
use gltf::Document;
use gltf::buffer::{Buffer, Source};
use percent_encoding::percent_decode_str;

use crate::scene::formats::Companions;

/// Decoder of base64 with or without padding. Some writers omit the padding.
const BASE_64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Bytes of a document's buffers, each at least as long as the document says.
pub(super) struct Buffers<'b>(Vec<Cow<'b, [u8]>>);

/// Part of the document, and its problem.
type BadPart = (String, String);

impl<'b> Buffers<'b> {
    /// Loads all buffers. `blob` is the binary part of a `.glb`.
    pub fn load(
        document: &Document,
        blob: &'b mut Option<Vec<u8>>,
        file: &Path,
        companions: &Companions,
    ) -> Result<Self, BadPart> {
        let blob = blob.as_deref();
        let load = |buffer: Buffer<'_>| {
            let bytes = match buffer.source() {
                Source::Bin => blob.map(Cow::Borrowed).ok_or("there is no binary part".into()),
                Source::Uri(uri) => resolve(uri, file, companions).map(Cow::Owned),
            };
            bytes
                .and_then(|bytes| {
                    if bytes.len() >= buffer.length() {
                        return Ok(bytes);
                    }
                    let (needed, found) = (buffer.length(), bytes.len());
                    Err(format!("it is cut off: it needs {needed} bytes, but has {found}"))
                })
                .map_err(|problem| (format!("buffer {}", buffer.index()), problem))
        };
        document.buffers().map(load).collect::<Result<_, _>>().map(Self)
    }

    /// Returns the bytes of a buffer.
    pub fn get(&self, buffer: &Buffer<'_>) -> Option<&[u8]> {
        self.0.get(buffer.index()).map(AsRef::as_ref)
    }
}

fn resolve(uri: &str, file: &Path, companions: &Companions) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, text) = data.split_once(',').ok_or("its `data:` address has no comma")?;
        if !kind.ends_with(";base64") {
            return Ok(percent_decode_str(text).collect());
        }
        return BASE_64
            .decode(text.trim())
            .map_err(|error| format!("its base64 is wrong: {error}"));
    }
    if uri.contains("://") {
        return Err(format!("{uri} is not on this machine; save it beside the file"));
    }
    let path = path_of(uri, file);
    companions(&path).map_err(|error| format!("cannot read {}: {error}", path.display()))
}

/// The path of a file beside a document.
fn path_of(uri: &str, file: &Path) -> PathBuf {
    let relative = percent_decode_str(uri).decode_utf8_lossy();
    file.parent().unwrap_or(Path::new("")).join(&*relative)
}

/// The bytes of the files beside a document that its buffers are in; 0 for those that cannot be found.
pub(super) fn bytes_beside(document: &Document, file: &Path) -> u64 {
    let paths = document.buffers().filter_map(|buffer| match buffer.source() {
        Source::Uri(uri) if !uri.starts_with("data:") => Some(path_of(uri, file)),
        Source::Uri(_) | Source::Bin => None,
    });
    paths
        .filter_map(|path| path.metadata().ok())
        .fold(0, |sum, found| found.len().saturating_add(sum))
}
