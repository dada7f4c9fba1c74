//! Signatures: the first bytes by which kinds of files are recognised.

/// Kind of file that people often pass by mistake, or a `.npy` file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Signature {
    Gzip,
    Zip,
    Utf16,
    Npy,
    Fbx,
    Index,
}

const FIRST_BYTES: [(&[u8], Signature); 7] = [
    (b"\x1f\x8b", Signature::Gzip),
    (b"PK\x03\x04", Signature::Zip),
    (b"\xff\xfe", Signature::Utf16),
    (b"\xfe\xff", Signature::Utf16),
    (b"\x93NUMPY", Signature::Npy),
    (b"Kaydara FBX", Signature::Fbx),
    (b"ARBL", Signature::Index),
];

impl Signature {
    /// Recognises the kind of a file.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        FIRST_BYTES.iter().find(|(first, _)| bytes.starts_with(first)).map(|&(_, kind)| kind)
    }

    /// Describes the kind in a clause for messages.
    pub fn kind(self) -> &'static str {
        match self {
            Self::Gzip => "it is compressed by gzip",
            Self::Zip => "it is a ZIP archive",
            Self::Utf16 => "it is text in UTF-16",
            Self::Npy => "it is a NumPy array",
            Self::Fbx => "it is an FBX file",
            Self::Index => "it is an index",
        }
    }
}
