//! Triangles of the C caller.

use arboleda::{Mesh, Scene, Triangle, Vec3};

use crate::error::Failure;
use crate::memory::{Caller, Input, Region};

/// Triangles, in one of two forms. The id of a triangle is its number in this order, from 0. Set the struct to zeros
/// first, then what you use; with neither form, and a triangle_count of 0, it is a mesh without triangles.
///
/// Coordinates are finite. Both sides of a triangle are hit; one without area is never hit.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct arb_mesh {
    /// Form 1: triangle_count times 9 floats, x y z of the corners a, b and c. NULL for form 2.
    pub triangles: *const f32,
    /// Form 2: vertex_count times 3 floats, x y z of a vertex. NULL for form 1.
    pub vertices: *const f32,
    /// Form 2: triangle_count times 3 numbers of vertices, from 0, of the corners a, b and c. NULL for form 1.
    pub corners: *const u32,
    /// The object of each triangle, triangle_count numbers below triangle_count; or NULL. A hierarchy never divides an
    /// object between clusters. Read by arb_measure and arb_build only.
    pub objects: *const u32,
    /// The number of triangles: at most 2^30.
    pub triangle_count: usize,
    /// The number of vertices of form 2; 0 for form 1.
    pub vertex_count: usize,
}

/// Checked arrays of a mesh.
pub struct Arrays {
    triangles: Input<Triangle>,
    vertices: Input<Vec3>,
    corners: Input<[u32; 3]>,
    objects: Input<u32>,
    is_indexed: bool,
}

impl Arrays {
    /// Reads the struct, and checks its pointers.
    pub fn check(caller: Caller, mesh: *const arb_mesh) -> Result<Self, Failure> {
        let mesh = caller.read(mesh, "mesh")?;
        let is_indexed = !mesh.vertices.is_null() || !mesh.corners.is_null();
        if is_indexed && !mesh.triangles.is_null() {
            return Err(Failure::TwoMeshes);
        }
        let listed = if is_indexed { 0 } else { mesh.triangle_count };
        let (indexed, vertices) =
            if is_indexed { (mesh.triangle_count, mesh.vertex_count) } else { (0, 0) };
        let objects = if mesh.objects.is_null() { 0 } else { mesh.triangle_count };
        Ok(Self {
            triangles: Input::check(mesh.triangles.cast(), listed, "mesh.triangles")?,
            vertices: Input::check(mesh.vertices.cast(), vertices, "mesh.vertices")?,
            corners: Input::check(mesh.corners.cast(), indexed, "mesh.corners")?,
            objects: Input::check(mesh.objects, objects, "mesh.objects")?,
            is_indexed,
        })
    }

    /// The addresses of the arrays.
    pub fn regions(&self) -> [Region; 4] {
        let Self { triangles, vertices, corners, objects, .. } = self;
        [triangles.region(), vertices.region(), corners.region(), objects.region()]
    }

    /// The triangles.
    pub fn mesh<'a>(&self, caller: Caller) -> Mesh<'a> {
        if self.is_indexed {
            Mesh::Indexed {
                vertices: caller.borrow(self.vertices),
                corners: caller.borrow(self.corners),
            }
        } else {
            Mesh::Triangles(caller.borrow(self.triangles))
        }
    }

    /// The scene: the triangles, their objects if there are any, and whether an index lies beside them.
    pub fn scene<'a>(&self, caller: Caller, beside: bool) -> Scene<'a> {
        let scene = Scene::of(self.mesh(caller));
        let objects = caller.borrow(self.objects);
        let scene = if objects.is_empty() { scene } else { scene.objects(objects) };
        if beside { scene.beside() } else { scene }
    }
}
