//! Errors of a mesh, of a build, and of opening the bytes of an index.

use core::fmt;

/// Reason why no index can be built from a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshError {
    /// A triangle has an infinite or NaN coordinate.
    NonFiniteVertex {
        /// The index of the triangle.
        triangle: u32,
    },
    /// A triangle names a vertex that does not exist.
    CornerOutOfRange {
        /// The index of the triangle.
        triangle: u32,
        /// The vertex index that is out of range.
        corner: u32,
        /// The number of vertices.
        vertices: usize,
    },
    /// The mesh has more triangles than there are ids.
    TooManyTriangles {
        /// The number of triangles.
        given: usize,
        /// The largest number of triangles that can be indexed.
        most: usize,
    },
}

impl fmt::Display for MeshError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NonFiniteVertex { triangle } => {
                write!(f, "triangle {triangle} has an infinite or NaN coordinate")
            }
            Self::CornerOutOfRange { triangle, corner, vertices } => {
                write!(f, "triangle {triangle} has vertex {corner} for a corner, of {vertices}")
            }
            Self::TooManyTriangles { given, most } => {
                write!(f, "{given} triangles are more than the {most} that ids can name")
            }
        }
    }
}

impl core::error::Error for MeshError {}

/// Reason why an index was not built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BuildError {
    /// The arena is too small. Exactly `needed` bytes are enough.
    ArenaFull {
        /// Bytes that the index needs.
        needed: usize,
        /// Bytes of the arena.
        given: usize,
    },
    /// The scratch is too small. `needed` bytes are enough.
    ScratchFull {
        /// Bytes that the build needs.
        needed: usize,
        /// Bytes of the scratch.
        given: usize,
    },
    /// The arena or the scratch does not start at a multiple of [`ALIGNMENT`](crate::custom::ALIGNMENT) bytes.
    Misaligned,
    /// The scene's triangles cannot be indexed.
    Mesh(MeshError),
    /// An index of this kind stores the triangles in a form of its own, so it cannot be built beside a mesh.
    HoldsTriangles {
        /// The kind's name.
        kind: &'static str,
    },
    /// An index beside a mesh borrows the mesh, so it cannot be [stored](crate::Stored) alone.
    CannotBeStored,
    /// An index of this kind is one tree over all triangles, so it cannot be built [in
    /// pieces](crate::PiecewiseBuild).
    NotInPieces {
        /// The kind's name.
        kind: &'static str,
    },
    /// The clusters are of another number of triangles than the scene, so they are those of another scene.
    OtherClusters {
        /// Triangles in the scene.
        triangles: usize,
        /// Triangles in the clusters.
        clustered: usize,
    },
    /// A build in pieces was finished before all pieces were built.
    PiecesLeft {
        /// Clusters whose words are not built.
        left: usize,
    },
    /// The index needs more words than `u32` links can reach: lower the level.
    TooLarge,
    /// The build takes more steps than [`crate::Options::work_limit`] allows.
    TooMuchWork {
        /// Steps that were allowed.
        limit: u64,
    },
    /// The list of objects does not have one entry per triangle.
    ObjectsMismatch {
        /// Triangles in the scene.
        triangles: usize,
        /// Entries in the list of objects.
        objects: usize,
    },
    /// An object number is not below the number of triangles.
    ObjectOutOfRange {
        /// The index of the triangle in the scene.
        triangle: u32,
    },
    /// An option is outside its range.
    InvalidOption {
        /// The option's name.
        option: &'static str,
        /// The allowed values.
        allowed: &'static str,
    },
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::ArenaFull { needed, given } => {
                write!(f, "the index needs {needed} bytes, the arena has {given}")
            }
            Self::ScratchFull { needed, given } => {
                write!(f, "the build needs {needed} bytes of scratch, {given} were given")
            }
            Self::Misaligned => write!(
                f,
                "the arena and the scratch must start at a multiple of {} bytes",
                crate::memory::ALIGNMENT
            ),
            Self::Mesh(error) => error.fmt(f),
            Self::HoldsTriangles { kind } => {
                write!(f, "{kind} holds the triangles itself, and is not built beside a mesh")
            }
            Self::CannotBeStored => {
                f.write_str("an index beside a mesh borrows the mesh, and cannot be stored alone")
            }
            Self::NotInPieces { kind } => {
                write!(f, "{kind} is one tree over all triangles, and is not built in pieces")
            }
            Self::OtherClusters { triangles, clustered } => write!(
                f,
                "the clusters are of {clustered} triangles, and the scene has {triangles}"
            ),
            Self::PiecesLeft { left } => {
                write!(f, "the words of {left} clusters are not built")
            }
            Self::TooLarge => f.write_str("the index outgrows its 32-bit links: lower the level"),
            Self::TooMuchWork { limit } => {
                write!(f, "the build takes more than the {limit} steps allowed")
            }
            Self::ObjectsMismatch { triangles, objects } => {
                write!(f, "{objects} object numbers were given for {triangles} triangles")
            }
            Self::ObjectOutOfRange { triangle } => write!(
                f,
                "the object number of triangle {triangle} is not below the number of triangles"
            ),
            Self::InvalidOption { option, allowed } => write!(f, "{option} must be {allowed}"),
        }
    }
}

impl core::error::Error for BuildError {}

impl From<MeshError> for BuildError {
    fn from(error: MeshError) -> Self {
        Self::Mesh(error)
    }
}

/// Reason why bytes are not an index that can be queried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum OpenError {
    /// The bytes do not start at a multiple of [`ALIGNMENT`](crate::custom::ALIGNMENT).
    Misaligned,
    /// The bytes are fewer than a header has, or fewer than the header announces.
    Truncated,
    /// The bytes do not begin as an index of this library does.
    NotAnIndex,
    /// The bytes were written on a machine of the other byte order.
    OtherByteOrder,
    /// The bytes were written by another version of the format.
    OtherVersion {
        /// The version found.
        found: u32,
    },
    /// The bytes hold an index of another kind.
    OtherKind {
        /// The kind expected; see [`crate::kinds::Representation::FORMAT`].
        expected: u32,
        /// The kind found.
        found: u32,
    },
    /// The bytes hold an index of a kind that was left out of this build.
    KindLeftOut {
        /// The feature of this crate that compiles it in.
        feature: &'static str,
    },
    /// The bytes hold an index of a kind that this version does not know.
    UnknownKind {
        /// The kind found.
        found: u32,
    },
    /// The index was built beside a mesh, and has no triangles without that mesh. Open it with
    /// [`crate::Index::from_bytes_beside`].
    MeshMissing,
    /// The index holds its triangles, and takes no mesh. Open it with [`crate::Index::from_bytes`].
    HasTriangles,
    /// The mesh cannot be indexed.
    Mesh(MeshError),
    /// The number of triangles in the mesh differs from that of the mesh which the index was built beside.
    OtherMeshLength {
        /// Triangles of the mesh that the index was built beside.
        expected: u32,
        /// Triangles of the mesh given.
        found: usize,
    },
    /// The coordinates of the mesh differ from those of the mesh which the index was built beside.
    OtherMesh,
    /// A part of the bytes contradicts another.
    Malformed {
        /// The name of the part.
        part: &'static str,
        /// The index of the wrong element in that part.
        at: u32,
    },
}

impl fmt::Display for OpenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Misaligned => write!(
                f,
                "the bytes of an index must start at a multiple of {} bytes",
                crate::memory::ALIGNMENT
            ),
            Self::Truncated => f.write_str("the bytes of the index are cut short"),
            Self::NotAnIndex => f.write_str("these bytes are not an index"),
            Self::OtherByteOrder => f.write_str("the index has the other byte order"),
            Self::OtherVersion { found } => write!(f, "the index has format version {found}"),
            Self::OtherKind { expected, found } => {
                write!(f, "the bytes hold an index of kind {found:#x}, not {expected:#x}")
            }
            Self::KindLeftOut { feature } => write!(
                f,
                "the bytes hold an index of the family {feature}, which this program was built without: \
                 turn on the feature {feature} of arboleda"
            ),
            Self::UnknownKind { found } => {
                write!(f, "the bytes hold an index of the unknown kind {found:#x}")
            }
            Self::MeshMissing => {
                f.write_str("the index was built beside a mesh, and has to be read beside it")
            }
            Self::HasTriangles => f.write_str("the index holds its triangles, and takes no mesh"),
            Self::Mesh(error) => error.fmt(f),
            Self::OtherMeshLength { expected, found } => write!(
                f,
                "the index was built beside a mesh of {expected} triangles, this one has {found}"
            ),
            Self::OtherMesh => {
                f.write_str("the index was built beside a mesh of other coordinates")
            }
            Self::Malformed { part, at } => write!(f, "the index is malformed: {part} {at}"),
        }
    }
}

impl core::error::Error for OpenError {}
