//! Input of the functions that are linked: what callers of any kind could pass.

use core::slice;

use arboleda::{
    AnyIndex, IndexKind, Mesh, OpenError, Options, Ray, RayError, Scene, Triangle, Vec3,
};

/// Slice of the caller.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Slice<T> {
    first: *mut T,
    count: usize,
}

impl<T> Slice<T> {
    /// # Safety
    /// `count` values must lie at `first`, and no other code may use them during `'a`.
    pub unsafe fn get<'a>(self) -> &'a mut [T] {
        // SAFETY: the caller fulfils the conditions of `Slice::get`.
        unsafe { slice::from_raw_parts_mut(self.first, self.count) }
    }
}

/// Numbers of a ray, which may be invalid.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct RayNumbers {
    origin: Vec3,
    direction: Vec3,
    t_min: f32,
    t_max: f32,
}

impl RayNumbers {
    pub fn ray(self) -> Result<Ray, RayError> {
        Ray::with_interval(self.origin, self.direction, self.t_min, self.t_max)
    }
}

/// Mesh in either form, or none.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct MeshParts {
    /// Form of the mesh: 0 for none, 1 for triangles, else vertices and corners.
    form: u32,
    triangles: Slice<Triangle>,
    vertices: Slice<Vec3>,
    corners: Slice<[u32; 3]>,
}

impl MeshParts {
    /// # Safety
    /// Each slice must fulfil the conditions of [`Slice::get`].
    pub unsafe fn get<'a>(self) -> Option<Mesh<'a>> {
        // SAFETY: the caller fulfils the conditions of `Slice::get`.
        let (triangles, vertices, corners) =
            unsafe { (self.triangles.get(), self.vertices.get(), self.corners.get()) };
        match self.form {
            0 => None,
            1 => Some(Mesh::Triangles(triangles)),
            _ => Some(Mesh::Indexed { vertices, corners }),
        }
    }
}

/// Input of a build.
#[repr(C)]
pub struct Build {
    pub kind: usize,
    pub mesh: MeshParts,
    pub is_beside: u32,
    pub objects: Slice<u32>,
    pub has_objects: u32,
    pub rays: Slice<Ray>,
    pub options: Options,
    pub arena: Slice<u8>,
    pub scratch: Slice<u8>,
}

pub fn kind(number: usize) -> Option<IndexKind> {
    IndexKind::ALL.get(number).copied()
}

/// Opens index bytes as a kind of index, beside a mesh if there is one.
pub fn read<'a>(
    number: usize,
    bytes: &'a [u8],
    mesh: Option<Mesh<'a>>,
) -> Option<Result<AnyIndex<'a>, OpenError>> {
    let kind = kind(number)?;
    Some(match mesh {
        Some(mesh) => kind.from_bytes_beside(bytes, mesh),
        None => kind.from_bytes(bytes),
    })
}

/// Makes the scene of a build.
///
/// # Safety
/// Each slice must fulfil the conditions of [`Slice::get`].
pub unsafe fn scene<'a>(input: &Build) -> Scene<'a> {
    // SAFETY: the caller fulfils the conditions of `Slice::get`.
    let (mesh, objects, rays) =
        unsafe { (input.mesh.get(), input.objects.get(), input.rays.get()) };
    let scene = Scene::of(mesh.unwrap_or(Mesh::EMPTY)).rays(rays);
    let scene = if input.has_objects == 0 { scene } else { scene.objects(objects) };
    if input.is_beside == 0 { scene } else { scene.beside() }
}
