//! Triangles in the caller's memory.

use core::ops::Range;

use crate::Vec3;
use crate::error::MeshError;
use crate::geometry::Triangle;

/// Largest number of triangles: 2^30. A cluster tree has up to twice as many nodes, and all of their ids stay below
/// the ids that are used as marks.
pub(crate) const MOST_TRIANGLES: usize = 1 << 30;

/// Borrowed triangles, as a list or as an indexed mesh.
///
/// An index is built from a mesh. An index built [beside](crate::Scene::beside) the mesh also reads it in every query.
///
/// The id of a triangle is its index in the mesh.
///
/// # Examples
/// ```
/// use arboleda::{Mesh, Triangle, Vec3};
///
/// let square = Mesh::Indexed {
///     vertices: &[Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y],
///     corners: &[[0, 1, 2], [0, 2, 3]],
/// };
/// assert_eq!(square.get(1), Some(Triangle::new(Vec3::ZERO, Vec3::X + Vec3::Y, Vec3::Y)));
/// assert_eq!(square.check(), Ok(()));
/// ```
#[derive(Clone, Copy, Debug)]
pub enum Mesh<'a> {
    /// A list of triangles.
    Triangles(&'a [Triangle]),
    /// An indexed mesh, whose triangles share vertices.
    Indexed {
        /// The positions of the vertices. An array of `[f32; 3]` can be cast to this type with `bytemuck::cast_slice`.
        vertices: &'a [Vec3],
        /// For each triangle, the indices of its corners `a`, `b` and `c` in `vertices`.
        corners: &'a [[u32; 3]],
    },
}

impl<'a> Mesh<'a> {
    /// A mesh without triangles.
    pub const EMPTY: Self = Self::Triangles(&[]);

    /// The number of triangles.
    #[inline]
    pub const fn len(&self) -> usize {
        match self {
            Self::Triangles(triangles) => triangles.len(),
            Self::Indexed { corners, .. } => corners.len(),
        }
    }

    /// Tells whether the mesh has no triangles.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The triangle `id`. `None` if there is no such triangle, or if one of its corners is not in `vertices`.
    #[inline]
    pub fn get(&self, id: u32) -> Option<Triangle> {
        match self {
            Self::Triangles(triangles) => triangles.get(id as usize).copied(),
            Self::Indexed { vertices, corners } => {
                let [a, b, c] = *corners.get(id as usize)?;
                let vertex = |index: u32| vertices.get(index as usize).copied();
                Some(Triangle::new(vertex(a)?, vertex(b)?, vertex(c)?))
            }
        }
    }

    /// All triangles, in the order of their ids.
    pub fn iter(self) -> impl Iterator<Item = Triangle> + Clone + use<'a> {
        (0..self.len() as u32).filter_map(move |id| self.get(id))
    }

    /// Checks that an index can be built from the mesh: the number of triangles, every vertex index, and that all
    /// coordinates are finite. Cost: linear.
    ///
    /// # Errors
    /// [`MeshError::TooManyTriangles`], else the error of the first wrong triangle.
    pub fn check(&self) -> Result<(), MeshError> {
        self.check_count()?;
        self.check_some(0..self.len())
    }

    /// Checks the number of triangles.
    pub(crate) fn check_count(&self) -> Result<(), MeshError> {
        let given = self.len();
        if given > MOST_TRIANGLES {
            return Err(MeshError::TooManyTriangles { given, most: MOST_TRIANGLES });
        }
        Ok(())
    }

    /// Checks some triangles, of a number that is allowed.
    pub(crate) fn check_some(&self, triangles: Range<usize>) -> Result<(), MeshError> {
        for triangle in triangles.start as u32..triangles.end as u32 {
            match self.get(triangle) {
                Some(corners) if corners.is_finite() => {}
                Some(_) => return Err(MeshError::NonFiniteVertex { triangle }),
                None => return Err(self.corner_out_of_range(triangle)),
            }
        }
        Ok(())
    }

    #[cold]
    fn corner_out_of_range(&self, triangle: u32) -> MeshError {
        let (vertices, corners) = match self {
            Self::Triangles(_) => (0, [0; 3]),
            Self::Indexed { vertices, corners } => {
                (vertices.len(), corners.get(triangle as usize).copied().unwrap_or_default())
            }
        };
        let corner = corners.into_iter().find(|&corner| corner as usize >= vertices);
        MeshError::CornerOutOfRange { triangle, corner: corner.unwrap_or(0), vertices }
    }

    /// Fingerprint that tells meshes apart: 64-bit FNV-1a over the coordinates, fed 32 bits at a time instead of 8.
    ///
    /// Equal triangles, bit for bit, give equal fingerprints, whether as a list or as an indexed mesh. Cost: nine
    /// multiplications a triangle.
    pub(crate) fn fingerprint(&self) -> u64 {
        let numbers = self.iter().flat_map(|Triangle { a, b, c }| {
            [a, b, c].into_iter().flat_map(|corner| corner.to_array())
        });
        numbers.fold(0xcbf2_9ce4_8422_2325, |hash, number| {
            (hash ^ u64::from(number.to_bits())).wrapping_mul(0x0100_0000_01b3)
        })
    }
}
