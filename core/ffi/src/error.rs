//! Statuses, their texts, and the struct that says more.

use core::ffi::{CStr, c_char};
use core::fmt::{self, Write};

use arboleda::{BuildError, MeshError, OpenError, RayError};

use crate::memory::{Caller, Output};

/// Result of a function. The numbers are stable: none is ever used again for another reason. A later library of the
/// same major version may return numbers that this header does not name.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum arb_status {
    /// The function did what it says. The only status that is not an error.
    ARB_OK = 0,

    /// A pointer is NULL that must not be.
    ARB_NULL_POINTER = 1,
    /// A pointer is not aligned for its type; or memory of an index, or scratch of a build, does not start at a multiple
    /// of ARB_ALIGNMENT bytes.
    ARB_MISALIGNED_POINTER = 2,
    /// A length is larger than any memory.
    ARB_LENGTH_OVERFLOW = 3,
    /// Memory that is written overlaps memory of another argument, of the index, or of the mesh beside it.
    ARB_OVERLAP = 4,
    /// The library does not have all of the header's interface: it has another major version, or a lower minor one.
    ARB_OTHER_ABI = 5,
    /// The arb_index was not filled by arb_build or arb_open, or was closed.
    ARB_NOT_OPEN = 6,
    /// No kind of index has this number.
    ARB_UNKNOWN_KIND = 7,
    /// The library was built without this kind of index.
    ARB_KIND_LEFT_OUT = 8,
    /// An option is out of range; the message names it.
    ARB_INVALID_OPTION = 9,
    /// The arb_mesh has both forms of triangles.
    ARB_TWO_MESHES = 10,
    /// There is no such build: it was not begun, it is over, or its memory was moved; or another call comes first.
    ARB_NOT_BEGUN = 11,

    /// The memory for the index is too small; arb_error.needed_bytes are enough.
    ARB_INDEX_MEMORY_TOO_SMALL = 20,
    /// The scratch is too small; arb_error.needed_bytes are enough.
    ARB_SCRATCH_TOO_SMALL = 21,
    /// A coordinate of a triangle is infinite or NaN; arb_error.element is the triangle.
    ARB_NON_FINITE_VERTEX = 22,
    /// A triangle names a vertex that does not exist; arb_error.element is the triangle.
    ARB_CORNER_OUT_OF_RANGE = 23,
    /// There are more than 2^30 triangles.
    ARB_TOO_MANY_TRIANGLES = 24,
    /// An index of this kind holds the triangles in a form of its own, and is not built beside a mesh.
    ARB_HOLDS_TRIANGLES = 25,
    /// The index outgrows its 32-bit links: lower the level.
    ARB_INDEX_TOO_LARGE = 26,
    /// The build takes more steps than arb_options.work_limit.
    ARB_TOO_MUCH_WORK = 27,
    /// An object number is not below the number of triangles; arb_error.element is the triangle.
    ARB_OBJECT_OUT_OF_RANGE = 28,
    /// An index of this kind cannot be built in pieces: only a hierarchy that has one index for each cluster can.
    ARB_NOT_IN_PIECES = 29,

    /// The bytes of the index are cut short.
    ARB_TRUNCATED = 40,
    /// The bytes are not an index.
    ARB_NOT_AN_INDEX = 41,
    /// The index was written on a machine of the other byte order.
    ARB_OTHER_BYTE_ORDER = 42,
    /// The index has a version of the format that the library does not read; arb_error.element is that version.
    ARB_OTHER_FORMAT = 43,
    /// A part of the index contradicts another; arb_error.element is the place in that part.
    ARB_MALFORMED = 44,
    /// The index was built beside a mesh, and none was given.
    ARB_MESH_MISSING = 45,
    /// The index has its own triangles, and a mesh was given.
    ARB_MESH_NOT_WANTED = 46,
    /// The index was built beside another mesh.
    ARB_OTHER_MESH = 47,

    /// A coordinate of a ray's origin is infinite or NaN. Of these five, arb_error.element is the ray's number.
    ARB_RAY_ORIGIN_NOT_FINITE = 60,
    /// A coordinate of a ray's direction is infinite or NaN.
    ARB_RAY_DIRECTION_NOT_FINITE = 61,
    /// A ray's direction is zero.
    ARB_RAY_DIRECTION_ZERO = 62,
    /// A ray's t_min or t_max is NaN.
    ARB_RAY_INTERVAL_NAN = 63,
    /// A ray's t_min is greater than its t_max.
    ARB_RAY_INTERVAL_EMPTY = 64,

    /// A reason that this version of the interface has no number for; the message says what.
    ARB_OTHER_REASON = 99,
}

use arb_status::{
    ARB_CORNER_OUT_OF_RANGE, ARB_HOLDS_TRIANGLES, ARB_INDEX_MEMORY_TOO_SMALL, ARB_INDEX_TOO_LARGE,
    ARB_INVALID_OPTION, ARB_KIND_LEFT_OUT, ARB_LENGTH_OVERFLOW, ARB_MALFORMED, ARB_MESH_MISSING,
    ARB_MESH_NOT_WANTED, ARB_MISALIGNED_POINTER, ARB_NON_FINITE_VERTEX, ARB_NOT_AN_INDEX,
    ARB_NOT_BEGUN, ARB_NOT_IN_PIECES, ARB_NOT_OPEN, ARB_NULL_POINTER, ARB_OBJECT_OUT_OF_RANGE,
    ARB_OK, ARB_OTHER_ABI, ARB_OTHER_BYTE_ORDER, ARB_OTHER_FORMAT, ARB_OTHER_MESH,
    ARB_OTHER_REASON, ARB_OVERLAP, ARB_RAY_DIRECTION_NOT_FINITE, ARB_RAY_DIRECTION_ZERO,
    ARB_RAY_INTERVAL_EMPTY, ARB_RAY_INTERVAL_NAN, ARB_RAY_ORIGIN_NOT_FINITE, ARB_SCRATCH_TOO_SMALL,
    ARB_TOO_MANY_TRIANGLES, ARB_TOO_MUCH_WORK, ARB_TRUNCATED, ARB_TWO_MESHES, ARB_UNKNOWN_KIND,
};

/// Texts of the statuses.
const TEXTS: [(arb_status, &CStr); 36] = [
    (ARB_OK, c"success"),
    (ARB_NULL_POINTER, c"a pointer is NULL"),
    (ARB_MISALIGNED_POINTER, c"a pointer is not aligned"),
    (ARB_LENGTH_OVERFLOW, c"a length is larger than any memory"),
    (ARB_OVERLAP, c"memory that is written overlaps that of another argument"),
    (ARB_OTHER_ABI, c"the library does not have all of the header's interface"),
    (ARB_NOT_OPEN, c"the arb_index is not open"),
    (ARB_UNKNOWN_KIND, c"no kind of index has this number"),
    (ARB_KIND_LEFT_OUT, c"the library was built without this kind of index"),
    (ARB_INVALID_OPTION, c"an option is out of range"),
    (ARB_TWO_MESHES, c"the mesh has both forms of triangles"),
    (ARB_NOT_BEGUN, c"there is no such build, or another call comes first"),
    (ARB_INDEX_MEMORY_TOO_SMALL, c"the memory for the index is too small"),
    (ARB_SCRATCH_TOO_SMALL, c"the scratch is too small"),
    (ARB_NON_FINITE_VERTEX, c"a coordinate of a triangle is infinite or NaN"),
    (ARB_CORNER_OUT_OF_RANGE, c"a triangle names a vertex that does not exist"),
    (ARB_TOO_MANY_TRIANGLES, c"there are more than 2^30 triangles"),
    (ARB_HOLDS_TRIANGLES, c"this kind of index is not built beside a mesh"),
    (ARB_INDEX_TOO_LARGE, c"the index outgrows its 32-bit links: lower the level"),
    (ARB_TOO_MUCH_WORK, c"the build takes more steps than allowed"),
    (ARB_OBJECT_OUT_OF_RANGE, c"an object number is not below the number of triangles"),
    (ARB_NOT_IN_PIECES, c"this kind of index is not built in pieces"),
    (ARB_TRUNCATED, c"the bytes of the index are cut short"),
    (ARB_NOT_AN_INDEX, c"the bytes are not an index"),
    (ARB_OTHER_BYTE_ORDER, c"the index has the other byte order"),
    (ARB_OTHER_FORMAT, c"the index has another version of the format"),
    (ARB_MALFORMED, c"the index is malformed"),
    (ARB_MESH_MISSING, c"the index was built beside a mesh, and none was given"),
    (ARB_MESH_NOT_WANTED, c"the index has its own triangles, and a mesh was given"),
    (ARB_OTHER_MESH, c"the index was built beside another mesh"),
    (ARB_RAY_ORIGIN_NOT_FINITE, c"a ray's origin is infinite or NaN"),
    (ARB_RAY_DIRECTION_NOT_FINITE, c"a ray's direction is infinite or NaN"),
    (ARB_RAY_DIRECTION_ZERO, c"a ray's direction is zero"),
    (ARB_RAY_INTERVAL_NAN, c"a ray's t_min or t_max is NaN"),
    (ARB_RAY_INTERVAL_EMPTY, c"a ray's t_min is greater than its t_max"),
    (ARB_OTHER_REASON, c"another reason"),
];

/// The text of a status, in English without a final stop; "unknown status" for a number that no status has. A static
/// string, never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn arb_status_text(status: i32) -> *const c_char {
    let text = TEXTS.iter().find(|(found, _)| *found as i32 == status);
    text.map_or(c"unknown status", |(_, text)| *text).as_ptr()
}

/// Room for a message in arb_error, its final zero included.
pub const ARB_MESSAGE_BYTES: usize = 160;

/// More about an error. A function that takes one accepts NULL too. It fills the struct also where it succeeds, with
/// ARB_OK, zeros and an empty message.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct arb_error {
    /// The status that the function returned.
    pub status: arb_status,
    /// The number of the triangle, ray or part that is wrong, counted from 0, where the status says so; else 0.
    pub element: usize,
    /// Bytes that would be enough, of ARB_INDEX_MEMORY_TOO_SMALL and ARB_SCRATCH_TOO_SMALL; else 0.
    pub needed_bytes: usize,
    /// Bytes that were given, of the same two; else 0.
    pub given_bytes: usize,
    /// Description of the error, with names and numbers: English, in ASCII, ended by a zero.
    pub message: [c_char; ARB_MESSAGE_BYTES],
}

/// Reason why a function failed.
#[allow(missing_docs)] // of the fields, which the variants explain
#[derive(Clone, Copy, Debug)]
pub enum Failure {
    /// A pointer or a length.
    Argument { status: arb_status, name: &'static str },
    /// Two arguments overlap.
    Overlap { output: &'static str, other: &'static str },
    /// A handle that is not open.
    NotOpen,
    /// Memory in which no build lies.
    NotBegun,
    /// A build at which another function is to be called.
    OutOfOrder { why: &'static str },
    /// A number that no kind has.
    UnknownKind { number: u32 },
    /// A kind that the library was built without.
    KindLeftOut { number: u32 },
    /// A mesh with both forms of triangles.
    TwoMeshes,
    /// The core's reason not to build.
    Build(BuildError),
    /// The core's reason not to open.
    Open(OpenError),
    /// The core's reason to refuse a ray.
    Ray { error: RayError, at: usize },
}

impl From<BuildError> for Failure {
    fn from(error: BuildError) -> Self {
        Self::Build(error)
    }
}

impl From<OpenError> for Failure {
    fn from(error: OpenError) -> Self {
        Self::Open(error)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Argument { status, name } => {
                let what = match status {
                    ARB_NULL_POINTER => "is NULL",
                    ARB_MISALIGNED_POINTER => "is not aligned for its type",
                    _ => "is longer than any memory",
                };
                write!(f, "{name} {what}")
            }
            Self::Overlap { output, other } => write!(f, "{output} overlaps {other}"),
            Self::NotOpen => f.write_str("the arb_index is not open"),
            Self::NotBegun => f.write_str("the build was not begun, is over, or was moved"),
            Self::OutOfOrder { why } => f.write_str(why),
            Self::UnknownKind { number } => write!(f, "no kind of index has the number {number}"),
            Self::KindLeftOut { number } => {
                write!(f, "the library was built without the kind of index number {number}")
            }
            Self::TwoMeshes => f.write_str("the mesh has triangles, and vertices or corners"),
            Self::Build(error) => error.fmt(f),
            Self::Open(error) => error.fmt(f),
            Self::Ray { error, at } => write!(f, "ray {at}: {error}"),
        }
    }
}

/// Numbers of an [`arb_error`]: element, needed bytes, given bytes.
type Numbers = (usize, usize, usize);

impl Failure {
    /// The status that a function returns for this reason.
    pub fn status(&self) -> arb_status {
        self.parts().0
    }

    fn parts(&self) -> (arb_status, Numbers) {
        let none = (0, 0, 0);
        match *self {
            Self::Argument { status, .. } => (status, none),
            Self::Overlap { .. } => (ARB_OVERLAP, none),
            Self::NotOpen => (ARB_NOT_OPEN, none),
            Self::NotBegun | Self::OutOfOrder { .. } => (ARB_NOT_BEGUN, none),
            Self::UnknownKind { .. } => (ARB_UNKNOWN_KIND, none),
            Self::KindLeftOut { .. } => (ARB_KIND_LEFT_OUT, none),
            Self::TwoMeshes => (ARB_TWO_MESHES, none),
            Self::Build(error) => of_build(error),
            Self::Open(error) => of_open(error),
            Self::Ray { error, at } => (of_ray(error), (at, 0, 0)),
        }
    }
}

fn of_build(error: BuildError) -> (arb_status, Numbers) {
    let none = (0, 0, 0);
    match error {
        BuildError::ArenaFull { needed, given } => (ARB_INDEX_MEMORY_TOO_SMALL, (0, needed, given)),
        BuildError::ScratchFull { needed, given } => (ARB_SCRATCH_TOO_SMALL, (0, needed, given)),
        BuildError::Misaligned => (ARB_MISALIGNED_POINTER, none),
        BuildError::Mesh(error) => of_mesh(error),
        BuildError::HoldsTriangles { .. } => (ARB_HOLDS_TRIANGLES, none),
        BuildError::TooLarge => (ARB_INDEX_TOO_LARGE, none),
        BuildError::TooMuchWork { .. } => (ARB_TOO_MUCH_WORK, none),
        BuildError::ObjectOutOfRange { triangle } => {
            (ARB_OBJECT_OUT_OF_RANGE, (triangle as usize, 0, 0))
        }
        BuildError::NotInPieces { .. } => (ARB_NOT_IN_PIECES, none),
        BuildError::InvalidOption { .. } => (ARB_INVALID_OPTION, none),
        _ => (ARB_OTHER_REASON, none),
    }
}

fn of_open(error: OpenError) -> (arb_status, Numbers) {
    let none = (0, 0, 0);
    match error {
        OpenError::Misaligned => (ARB_MISALIGNED_POINTER, none),
        OpenError::Truncated => (ARB_TRUNCATED, none),
        OpenError::NotAnIndex => (ARB_NOT_AN_INDEX, none),
        OpenError::OtherByteOrder => (ARB_OTHER_BYTE_ORDER, none),
        OpenError::OtherVersion { found } => (ARB_OTHER_FORMAT, (found as usize, 0, 0)),
        OpenError::KindLeftOut { .. } => (ARB_KIND_LEFT_OUT, none),
        OpenError::UnknownKind { .. } => (ARB_UNKNOWN_KIND, none),
        OpenError::MeshMissing => (ARB_MESH_MISSING, none),
        OpenError::HasTriangles => (ARB_MESH_NOT_WANTED, none),
        OpenError::Mesh(error) => of_mesh(error),
        OpenError::OtherMeshLength { .. } | OpenError::OtherMesh => (ARB_OTHER_MESH, none),
        OpenError::Malformed { at, .. } => (ARB_MALFORMED, (at as usize, 0, 0)),
        _ => (ARB_OTHER_REASON, none),
    }
}

fn of_mesh(error: MeshError) -> (arb_status, Numbers) {
    match error {
        MeshError::NonFiniteVertex { triangle } => {
            (ARB_NON_FINITE_VERTEX, (triangle as usize, 0, 0))
        }
        MeshError::CornerOutOfRange { triangle, .. } => {
            (ARB_CORNER_OUT_OF_RANGE, (triangle as usize, 0, 0))
        }
        MeshError::TooManyTriangles { .. } => (ARB_TOO_MANY_TRIANGLES, (0, 0, 0)),
        _ => (ARB_OTHER_REASON, (0, 0, 0)),
    }
}

fn of_ray(error: RayError) -> arb_status {
    match error {
        RayError::NonFiniteOrigin => ARB_RAY_ORIGIN_NOT_FINITE,
        RayError::NonFiniteDirection => ARB_RAY_DIRECTION_NOT_FINITE,
        RayError::ZeroDirection => ARB_RAY_DIRECTION_ZERO,
        RayError::NanInterval => ARB_RAY_INTERVAL_NAN,
        RayError::EmptyInterval => ARB_RAY_INTERVAL_EMPTY,
        _ => ARB_OTHER_REASON,
    }
}

/// Text of at most a message's length, that ends with a zero.
struct Message {
    bytes: [c_char; ARB_MESSAGE_BYTES],
    length: usize,
}

impl Write for Message {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let room = self.bytes.iter_mut().take(ARB_MESSAGE_BYTES - 1).skip(self.length);
        for (slot, byte) in room.zip(text.bytes()) {
            *slot = byte as c_char;
            self.length += 1;
        }
        Ok(())
    }
}

impl arb_error {
    fn new(result: &Result<(), Failure>) -> Self {
        let mut message = Message { bytes: [0; ARB_MESSAGE_BYTES], length: 0 };
        let mut parts = (ARB_OK, (0, 0, 0));
        if let Err(failure) = result {
            parts = failure.parts();
            // Writing to a `Message` does not fail.
            let _ = write!(message, "{failure}");
        }
        let (status, (element, needed_bytes, given_bytes)) = parts;
        Self { status, element, needed_bytes, given_bytes, message: message.bytes }
    }
}

/// Runs the body of an exported function, and returns its status.
pub fn status_of(body: impl FnOnce() -> Result<(), Failure>) -> arb_status {
    body().map_or_else(|failure| failure.status(), |()| ARB_OK)
}

/// Runs the body of an exported function, fills `error` unless it is null, and returns the status. If `error` is
/// misaligned, nothing is run.
pub fn reported(
    caller: Caller,
    error: *mut arb_error,
    body: impl FnOnce() -> Result<(), Failure>,
) -> arb_status {
    let error = match Output::check(error, usize::from(!error.is_null()), "error") {
        Ok(error) => error,
        Err(failure) => return failure.status(),
    };
    let result = body();
    if !error.is_empty() {
        caller.write(error, arb_error::new(&result));
    }
    result.map_or_else(|failure| failure.status(), |()| ARB_OK)
}
