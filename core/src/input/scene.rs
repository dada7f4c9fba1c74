//! What an index is built from: triangles, and the options.

use super::Mesh;
use crate::error::BuildError;
use crate::geometry::{Ray, Triangle};

/// The triangles of a scene, which whole objects they belong to and which rays it will be asked about where that
/// is known, and whether an index of them has a copy.
///
/// # Examples
/// An index beside a mesh that is kept anyway reads the triangles where they lie, and is read back beside them.
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
    /// Whether an index has no copy of the triangles.
    pub(crate) beside: bool,
    pub(crate) rays: &'a [Ray],
    /// The number of rays to come, if that is known.
    pub(crate) expected_rays: Option<u64>,
}

impl<'a> Scene<'a> {
    /// A scene whose primitives, for finding clusters, are its triangles.
    pub const fn new(triangles: &'a [Triangle]) -> Self {
        Self::of(Mesh::Triangles(triangles))
    }

    /// As [`Scene::new`], of a mesh.
    pub const fn of(mesh: Mesh<'a>) -> Self {
        Self { triangles: mesh, objects: None, beside: false, rays: &[], expected_rays: None }
    }

    /// A scene whose primitives are whole objects; see [`Scene::objects`].
    pub const fn with_objects(triangles: &'a [Triangle], objects: &'a [u32]) -> Self {
        Self::new(triangles).objects(objects)
    }

    /// The same triangles, with whole objects for primitives: triangle `i` belongs to object `objects[i]`, a
    /// number below the number of triangles. An object is never divided between clusters.
    #[must_use]
    pub const fn objects(self, objects: &'a [u32]) -> Self {
        Self { objects: Some(objects), ..self }
    }

    /// The same scene, of whose triangles an index has no copy: it lies beside them, and reads them where the
    /// caller keeps them. Its answers are the same.
    #[must_use]
    pub const fn beside(self) -> Self {
        Self { beside: true, ..self }
    }

    /// The same scene, and rays such as it will be asked about: some hundred are enough. The automatic resolution
    /// of grids and [`select`](crate::select::select) try their choices on them; without any, on a sample of the
    /// scene's own. No answer depends on them. As the triangles, they live as long as the index that a build returns.
    #[must_use]
    pub const fn rays(self, rays: &'a [Ray]) -> Self {
        Self { rays, ..self }
    }

    /// Tells the approximate number of rays to come. [`select`](crate::select::select) weighs the cost of a build
    /// against the cost of these rays, and tries more candidates the more rays there are; with `u64::MAX`, all
    /// candidates. No answer depends on the number.
    #[must_use]
    pub const fn expecting(self, rays: u64) -> Self {
        Self { expected_rays: Some(rays), ..self }
    }

    /// The triangles, by id.
    pub const fn triangles(&self) -> Mesh<'a> {
        self.triangles
    }

    /// The mesh that an index of the scene lies beside, if it does.
    pub(crate) fn kept(&self) -> Option<Mesh<'a>> {
        self.beside.then_some(self.triangles)
    }

    /// Refuses what no index can hold.
    pub(crate) fn check(&self) -> Result<(), BuildError> {
        self.triangles.check()?;
        let given = self.triangles.len();
        let Some(objects) = self.objects else {
            return Ok(());
        };
        if objects.len() != given {
            return Err(BuildError::ObjectsMismatch { triangles: given, objects: objects.len() });
        }
        match objects.iter().position(|&object| object as usize >= given) {
            Some(triangle) => Err(BuildError::ObjectOutOfRange { triangle: triangle as u32 }),
            None => Ok(()),
        }
    }
}
