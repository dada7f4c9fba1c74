//! The scene: triangles, and what is known about them.

use core::ops::Range;

use super::Mesh;
use crate::error::BuildError;
use crate::geometry::{Ray, Triangle};

/// Input of a build: triangles and, optionally, the objects they belong to, rays to be expected, and whether the index
/// borrows the triangles instead of copying them.
///
/// # Examples
/// An index built beside a mesh reads the triangles where they lie, and is reopened beside the same mesh.
/// ```
/// use arboleda::{Block, Index, Mesh, Options, Ray, Scene, Vec3};
/// use arboleda::kinds::LeanBvh;
///
/// let (vertices, corners) = ([Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y], [[0, 1, 2], [0, 2, 3]]);
/// let mesh = Mesh::Indexed { vertices: &vertices, corners: &corners };
/// let scene = Scene::of(mesh).beside();
///
/// let (mut arena, mut scratch) = ([Block::ZERO; 16], [Block::ZERO; 16]);
/// let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
/// let built = Index::<LeanBvh>::build(&scene, &Options::default(), arena, scratch)?;
/// let ray = Ray::new(Vec3::new(0.25, 0.75, -1.0), Vec3::Z)?;
/// assert_eq!(built.closest_hit(&ray).map(|hit| (hit.triangle.0, hit.t)), Some((1, 1.0)));
///
/// let read = Index::<LeanBvh>::from_bytes_beside(built.as_bytes(), mesh)?;
/// assert!(read.occluded(&ray));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    pub(crate) triangles: Mesh<'a>,
    pub(crate) objects: Option<&'a [u32]>,
    /// True if the index borrows the triangles.
    pub(crate) beside: bool,
    pub(crate) rays: &'a [Ray],
    /// The number of rays to expect, if known.
    pub(crate) expected_rays: Option<u64>,
}

impl<'a> Scene<'a> {
    /// Makes a scene of a list of triangles. The primitives that are clustered are its triangles.
    pub const fn new(triangles: &'a [Triangle]) -> Self {
        Self::of(Mesh::Triangles(triangles))
    }

    /// Makes a scene of a mesh. The primitives that are clustered are its triangles.
    pub const fn of(mesh: Mesh<'a>) -> Self {
        Self { triangles: mesh, objects: None, beside: false, rays: &[], expected_rays: None }
    }

    /// Makes a scene of a list of triangles, whose primitives are whole objects; see [`Scene::objects`].
    pub const fn with_objects(triangles: &'a [Triangle], objects: &'a [u32]) -> Self {
        Self::new(triangles).objects(objects)
    }

    /// Makes whole objects the primitives that are clustered: triangle `i` belongs to object `objects[i]`, a number
    /// below the number of triangles. An object is never divided between clusters.
    #[must_use]
    pub const fn objects(self, objects: &'a [u32]) -> Self {
        Self { objects: Some(objects), ..self }
    }

    /// Makes the index borrow the triangles: it lies beside them, and reads them where the caller keeps them. Its
    /// answers are the same.
    ///
    /// The wide and the compact BVH hold triangles in a form of their own, and are not built beside a mesh.
    #[must_use]
    pub const fn beside(self) -> Self {
        Self { beside: true, ..self }
    }

    /// Gives rays like those that the index will be asked about; some hundred are enough.
    ///
    /// The automatic resolution of a uniform grid and [`select`](crate::select::select) choose by the cost of these
    /// rays. Without any, they choose by a sample of rays that they make. Query results never depend on the rays. The
    /// rays are borrowed as long as the triangles.
    #[must_use]
    pub const fn rays(self, rays: &'a [Ray]) -> Self {
        Self { rays, ..self }
    }

    /// Gives the approximate number of rays that the index will be asked about.
    ///
    /// [`select`](crate::select::select) weighs the cost of a build against the cost of this many rays, and tries more
    /// candidates the more rays there are. With `u64::MAX`, it tries all. Query results never depend on the number.
    #[must_use]
    pub const fn expecting(self, rays: u64) -> Self {
        Self { expected_rays: Some(rays), ..self }
    }

    /// The triangles.
    pub const fn triangles(&self) -> Mesh<'a> {
        self.triangles
    }

    /// The mesh that an index of the scene borrows; `None` if the index copies it.
    pub(crate) fn kept(&self) -> Option<Mesh<'a>> {
        self.beside.then_some(self.triangles)
    }

    /// Checks that an index can be built from the scene.
    pub(crate) fn check(&self) -> Result<(), BuildError> {
        self.triangles.check()?;
        self.check_objects(0..self.triangles.len())
    }

    /// Checks how many objects there are, and those of some triangles.
    pub(crate) fn check_objects(&self, triangles: Range<usize>) -> Result<(), BuildError> {
        let given = self.triangles.len();
        let Some(objects) = self.objects else {
            return Ok(());
        };
        if objects.len() != given {
            return Err(BuildError::ObjectsMismatch { triangles: given, objects: objects.len() });
        }
        let first = triangles.start;
        let some = objects.get(triangles).unwrap_or_default();
        match some.iter().position(|&object| object as usize >= given) {
            Some(at) => Err(BuildError::ObjectOutOfRange { triangle: (first + at) as u32 }),
            None => Ok(()),
        }
    }
}
