//! The triangles of a scene, where the caller keeps them.

use core::fmt;

use crate::Vec3;
use crate::geometry::Triangle;

/// 2^30: twice as many cluster-tree nodes still have ids below the ones used as marks.
pub(crate) const MOST_TRIANGLES: usize = 1 << 30;

/// Triangles that an index is built from, and that one built [beside](crate::Scene::beside) them reads
/// whenever it answers.
///
/// A triangle's id is its place.
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
    /// One after the other.
    Triangles(&'a [Triangle]),
    /// By corners that they share.
    Indexed {
        /// The corners. An array of `[f32; 3]` is one of these too: `bytemuck::cast_slice`.
        vertices: &'a [Vec3],
        /// For each triangle the places of its corners `a`, `b` and `c` among the vertices.
        corners: &'a [[u32; 3]],
    },
}

impl<'a> Mesh<'a> {
    /// A mesh without triangles.
    pub const EMPTY: Self = Self::Triangles(&[]);

    /// How many triangles there are.
    #[inline]
    pub const fn len(&self) -> usize {
        match self {
            Self::Triangles(triangles) => triangles.len(),
            Self::Indexed { corners, .. } => corners.len(),
        }
    }

    /// Tells whether there are none.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A triangle; `None` if there is none, or if a corner of it is none of the vertices.
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

    /// All triangles, by id.
    pub fn iter(self) -> impl Iterator<Item = Triangle> + Clone + use<'a> {
        (0..self.len() as u32).filter_map(move |id| self.get(id))
    }

    /// Refuses what no index can hold.
    ///
    /// # Errors
    /// Any of [`MeshError`]: the first of the triangles that is wrong.
    pub fn check(&self) -> Result<(), MeshError> {
        let given = self.len();
        if given > MOST_TRIANGLES {
            return Err(MeshError::TooManyTriangles { given, most: MOST_TRIANGLES });
        }
        for triangle in 0..given as u32 {
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

    /// What tells meshes apart: FNV-1a in 64 bits over the coordinates, 32 bits at a time instead of 8. Nine
    /// multiplications a triangle. However a mesh is kept, only its triangles count, bit for bit.
    pub(crate) fn fingerprint(&self) -> u64 {
        let numbers = self.iter().flat_map(|Triangle { a, b, c }| {
            [a, b, c].into_iter().flat_map(|corner| corner.to_array())
        });
        numbers.fold(0xcbf2_9ce4_8422_2325, |hash, number| {
            (hash ^ u64::from(number.to_bits())).wrapping_mul(0x0100_0000_01b3)
        })
    }
}

/// Why triangles cannot be indexed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshError {
    /// A triangle has an infinite or NaN coordinate.
    NonFiniteVertex {
        /// The place of the triangle in the scene.
        triangle: u32,
    },
    /// A corner of a triangle is none of the vertices.
    CornerOutOfRange {
        /// The place of the triangle in the scene.
        triangle: u32,
        /// What it has for the place of a vertex.
        corner: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// More triangles than ids; `most` can be indexed.
    TooManyTriangles {
        /// Triangles in the scene.
        given: usize,
        /// The limit.
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
