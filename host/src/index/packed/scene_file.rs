//! File of a scene beside its index: what photons need of a scene that an index does not have.
//!
//! ```text
//! "ARBSCENE"                8 bytes
//! byte order, version       u32 each, in the byte order of the machine that wrote them, as all numbers but the head's
//! bytes of the head         u64
//! BLAKE3                    32 bytes: of the bytes of the head, as above, and of what follows
//! zero                      8 bytes
//! head: digest of the index, name, origin, lights    in the format of postcard
//! columns: triangles, reflectances, colours, objects    by triangle; each begins at a multiple of 64 bytes
//! names of the objects      in the format of postcard
//! ```
//! Triangles are left out if the index has a section of them, and colours of a grey scene.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use arboleda::{AnyIndex, Mesh, Triangle, Vec3};
use bytemuck::{Pod, Zeroable};
use serde::Deserialize;

use super::error::PackedProblem;
use crate::files::MappedFile;
use crate::files::output::write_file;
use crate::scene::{AreaLight, Column, FaceLight, LitSides, Model};

const MAGIC: [u8; 8] = *b"ARBSCENE";
const BYTE_ORDER: u32 = 0x0102_0304;
const VERSION: u32 = 1;
/// Multiple of bytes at which the head and the columns begin.
const ALIGNMENT: usize = 64;
/// Bytes that the system is asked to write at once. While it writes, it touches pages of mapped columns, and nobody can
/// give them back.
const WRITTEN_AT_ONCE: usize = 1 << 20;

/// First 64 bytes.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Front {
    magic: [u8; 8],
    byte_order: u32,
    version: u32,
    head_bytes: u64,
    digest: [u8; 32],
    zero: [u8; 8],
}

/// An area light: corner, both edges, flux.
type LightWords = ([f32; 3], [f32; 3], [f32; 3], f32);
/// A triangle that emits: its id, its radiance, whether both sides emit.
type FaceWords = (u32, [f32; 3], bool);

/// What is not a column, as it is read. [`SceneParts`] writes it.
#[derive(Deserialize)]
pub struct Head {
    /// BLAKE3 of the bytes of the index, and their number.
    pub index: ([u8; 32], u64),
    triangle_count: u64,
    has_triangles: bool,
    has_colours: bool,
    name: String,
    origin: [f64; 3],
    lights: Vec<LightWords>,
    emitters: Vec<FaceWords>,
}

/// Values in the format of postcard, one after another, without their number. So they can be appended to those of
/// other files.
#[derive(Clone, Copy, Default)]
pub(crate) struct Sequence<'b> {
    /// Number of values.
    pub count: usize,
    /// The values.
    pub bytes: &'b [u8],
}

/// Scene as its file has it: each column and sequence is a slice, wherever it lies.
pub(crate) struct SceneParts<'b> {
    /// Name of the scene.
    pub name: &'b str,
    /// Point that was subtracted from all coordinates.
    pub origin: [f64; 3],
    /// Lights that are not triangles.
    pub lights: &'b [AreaLight],
    /// Triangles that emit, as [`emitter_bytes`] makes them.
    pub emitters: Sequence<'b>,
    /// The triangles. They are left out if the index has them.
    pub triangles: &'b [Triangle],
    /// Reflectance of each triangle, `f32`.
    pub reflectance: &'b [u8],
    /// Colour of each triangle, three `f32`; empty if all are grey.
    pub colours: &'b [u8],
    /// Object of each triangle, `u32`.
    pub objects: &'b [u8],
    /// Names of the objects, as [`name_bytes`] makes them.
    pub object_names: Sequence<'b>,
}

/// Scene in a file that is mapped.
pub struct SceneFile {
    pub file: Arc<MappedFile>,
    pub head: Head,
    digest: [u8; 32],
    /// First byte of the columns.
    columns: usize,
}

/// Begins the digest of a file.
fn hasher(head_bytes: u64) -> blake3::Hasher {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&head_bytes.to_ne_bytes());
    hasher
}

/// Tells whether a byte order is that of the other machines.
fn is_other_order(order: u32) -> bool {
    order == BYTE_ORDER.swap_bytes()
}

/// Appends the bytes of triangles that emit to others; ids begin at `first`.
///
/// # Errors
/// Never: memory takes any bytes.
pub(crate) fn emitter_bytes(emitters: &[FaceLight], first: u32) -> postcard::Result<Vec<u8>> {
    emitters.iter().try_fold(Vec::new(), |bytes, light| {
        let light = FaceLight { triangle: first + light.triangle, ..*light };
        postcard::to_extend(&words_of_face(&light), bytes)
    })
}

/// Makes the bytes of names.
///
/// # Errors
/// Never: memory takes any bytes.
pub(crate) fn name_bytes(names: &[String]) -> postcard::Result<Vec<u8>> {
    names.iter().try_fold(Vec::new(), |bytes, name| postcard::to_extend(name, bytes))
}

/// Computes the digest of the bytes of an index, on all threads of the caller's pool.
pub(crate) fn digest_of(index: &AnyIndex<'_>) -> blake3::Hash {
    blake3::Hasher::new().update_rayon(index.as_bytes()).finalize()
}

impl SceneParts<'_> {
    /// Writes the scene of an index, whose digest is [`digest_of`] it. Works on all threads of the caller's pool.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(
        &self,
        path: &Path,
        index: &AnyIndex<'_>,
        index_digest: &blake3::Hash,
    ) -> anyhow::Result<()> {
        // 1. The head: the fields of `Head`, in their order. A sequence is its number and its values.
        let triangles: &[Triangle] = if has_section(index) { &[] } else { self.triangles };
        let head = (
            (index_digest.as_bytes(), index.as_bytes().len() as u64),
            self.triangles.len() as u64,
            !has_section(index),
            !self.colours.is_empty(),
            self.name,
            self.origin,
            self.lights.iter().map(words_of_light).collect::<Vec<LightWords>>(),
            self.emitters.count,
        );
        let head = postcard::to_stdvec(&head)?;
        let head_bytes = head.len() + self.emitters.bytes.len();

        // 2. All that follows the front.
        let name_count = postcard::to_stdvec(&self.object_names.count)?;
        let columns =
            [bytemuck::cast_slice(triangles), self.reflectance, self.colours, self.objects];
        let zeros = [0; ALIGNMENT];
        let padding = |length: usize| &zeros[..length.next_multiple_of(ALIGNMENT) - length];
        let padded = columns.into_iter().flat_map(|column| [column, padding(column.len())]);
        let body: Vec<&[u8]> = [&head[..], self.emitters.bytes, padding(head_bytes)]
            .into_iter()
            .chain(padded)
            .chain([&name_count[..], self.object_names.bytes])
            .collect();

        // 3. The file.
        let mut hasher = hasher(head_bytes as u64);
        for part in &body {
            hasher.update_rayon(part);
        }
        let front = Front {
            magic: MAGIC,
            byte_order: BYTE_ORDER,
            version: VERSION,
            head_bytes: head_bytes as u64,
            digest: *hasher.finalize().as_bytes(),
            zero: [0; 8],
        };
        write_file(path, |file| {
            file.write_all(bytemuck::bytes_of(&front))?;
            let mut some = body.iter().flat_map(|part| part.chunks(WRITTEN_AT_ONCE));
            some.try_for_each(|some| file.write_all(some))
        })
    }
}

impl SceneFile {
    /// Reads the head of a file. Its digest is not checked.
    pub fn of(file: MappedFile) -> Result<Self, PackedProblem> {
        let bytes = file.bytes();
        let (front, body) =
            bytes.split_at_checked(size_of::<Front>()).ok_or(PackedProblem::NotAScene)?;
        let front: Front = bytemuck::pod_read_unaligned(front);
        if front.magic != MAGIC {
            return Err(PackedProblem::NotAScene);
        }
        if front.byte_order != BYTE_ORDER {
            let other = is_other_order(front.byte_order);
            return Err(if other { PackedProblem::OtherByteOrder } else { PackedProblem::Torn });
        }
        if front.version != VERSION {
            return Err(PackedProblem::Version { found: front.version, read: VERSION });
        }
        if front.zero != [0; 8] {
            return Err(PackedProblem::Torn);
        }
        let head_bytes = usize::try_from(front.head_bytes).map_err(|_| PackedProblem::Torn)?;
        let head = body.get(..head_bytes).ok_or(PackedProblem::Torn)?;
        let head: Head = postcard::from_bytes(head).map_err(|_| PackedProblem::Torn)?;
        let columns = (size_of::<Front>() + head_bytes).checked_next_multiple_of(ALIGNMENT);
        let columns = columns.ok_or(PackedProblem::Torn)?;
        Ok(Self { file: Arc::new(file), head, digest: front.digest, columns })
    }

    /// Checks that the file is as it was written. Cost: linear.
    pub fn check(&self) -> Result<(), PackedProblem> {
        let (front, body) = self.file.bytes().split_at(size_of::<Front>());
        let front: Front = bytemuck::pod_read_unaligned(front);
        let digest = hasher(front.head_bytes).update_rayon(body).finalize();
        if *digest.as_bytes() == self.digest { Ok(()) } else { Err(PackedProblem::Torn) }
    }

    /// Makes the model, whose columns lie in the file, or in that of the index. Object names are left out.
    pub fn model(&self, index_file: &Arc<MappedFile>, index: &AnyIndex<'_>) -> Option<Model> {
        let Head { triangle_count, has_triangles, has_colours, ref name, origin, .. } = self.head;
        let count = usize::try_from(triangle_count).ok()?;
        if index.sections().triangle_count() as usize != count
            || has_triangles == has_section(index)
        {
            return None;
        }
        let mut places = self.places()?;
        let mut next = || places.next().flatten();
        let own = next()?;
        let triangles = if has_triangles {
            Column::mapped(&self.file, own)
        } else {
            Column::mapped(index_file, section_of(index_file, index)?)
        };
        let reflectance = Column::mapped(&self.file, next()?);
        let colours = Column::mapped(&self.file, next()?)?;
        let model = Model {
            name: name.clone(),
            triangles: triangles?,
            reflectance: reflectance?,
            objects: Column::mapped(&self.file, next()?)?,
            colours: if has_colours { colours } else { Column::default() },
            object_names: Vec::new(),
            lights: self.head.lights.iter().map(light_of_words).collect(),
            emitters: self.head.emitters.iter().map(face_of_words).collect(),
            origin,
        };
        Some(model)
    }

    /// Reads the names of the objects.
    pub fn object_names(&self) -> Option<Vec<String>> {
        let names = self.places()?.last()??;
        postcard::from_bytes(self.file.bytes().get(names.start..)?).ok()
    }

    /// Lists where the columns lie, and last where the names begin.
    fn places(&self) -> Option<impl Iterator<Item = Option<Range<usize>>> + use<>> {
        let Head { triangle_count, has_triangles, has_colours, .. } = self.head;
        let count = usize::try_from(triangle_count).ok()?;
        let if_there = |there: bool, bytes: usize| if there { bytes } else { 0 };
        let widths = [if_there(has_triangles, 36), 4, if_there(has_colours, 12), 4, 0];
        let mut start = Some(self.columns);
        Some(widths.into_iter().map(move |width: usize| {
            let first = start?;
            let end = first.checked_add(count.checked_mul(width)?)?;
            start = end.checked_next_multiple_of(ALIGNMENT);
            Some(first..end)
        }))
    }
}

/// Tells whether an index has a section of triangles, by id.
fn has_section(index: &AnyIndex<'_>) -> bool {
    let sections = index.sections();
    sections.triangles().len() == sections.triangle_count() as usize
}

/// Finds the bytes of the section of triangles in the file of an index.
fn section_of(file: &MappedFile, index: &AnyIndex<'_>) -> Option<Range<usize>> {
    let Mesh::Triangles(triangles) = index.sections().triangles() else { return None };
    if triangles.is_empty() {
        return Some(0..0);
    }
    let start = triangles.as_ptr().addr().checked_sub(file.bytes().as_ptr().addr())?;
    Some(start..start.checked_add(size_of_val(triangles))?)
}

fn words_of_light(light: &AreaLight) -> LightWords {
    let AreaLight { corner, edge_u, edge_v, flux } = *light;
    (corner.to_array(), edge_u.to_array(), edge_v.to_array(), flux)
}

fn light_of_words(&(corner, edge_u, edge_v, flux): &LightWords) -> AreaLight {
    let [corner, edge_u, edge_v] = [corner, edge_u, edge_v].map(Vec3::from_array);
    AreaLight { corner, edge_u, edge_v, flux }
}

fn words_of_face(light: &FaceLight) -> FaceWords {
    (light.triangle, light.radiance, light.sides == LitSides::Both)
}

fn face_of_words(&(triangle, radiance, both): &FaceWords) -> FaceLight {
    let sides = if both { LitSides::Both } else { LitSides::Front };
    FaceLight { triangle, radiance, sides }
}
