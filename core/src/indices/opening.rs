//! Opening an image of any kind by its header. Kinds that were left out of the build are refused by name.

use super::{AnyIndex, IndexKind};
use crate::memory::{MESH_BESIDE, image_kind};
use crate::{ImageError, Mesh};

/// The families by the number of their images, whether they are compiled in or not.
const FAMILIES: [(u32, &str); 10] = [
    (1, "linear"),
    (2, "octree"),
    (3, "octree-r"),
    (4, "kd-tree"),
    (5, "bsp-tree"),
    (6, "uniform-grid"),
    (7, "bvh"),
    (9, "wide-bvh"),
    (10, "compact-bvh"),
    (11, "lean-bvh"),
];
/// The bits of an image's kind that are the family.
const FAMILY: u32 = 0xffff;

impl IndexKind {
    /// Reads the kind of an image from its header; the rest of the image is not looked at.
    ///
    /// # Errors
    /// [`ImageError::KindLeftOut`] for a kind that was left out of the build, [`ImageError::UnknownKind`], and the
    /// errors of a header: `Misaligned`, `Truncated`, `NotAnImage`, `OtherByteOrder`, `OtherVersion`.
    pub fn of_image(bytes: &[u8]) -> Result<Self, ImageError> {
        let found = image_kind(bytes)? & !MESH_BESIDE;
        if let Some(&kind) = Self::ALL.iter().find(|kind| kind.image_kind() == found) {
            return Ok(kind);
        }
        match FAMILIES.iter().find(|(family, _)| *family == found & FAMILY) {
            Some((_, feature)) => Err(ImageError::KindLeftOut { feature }),
            None => Err(ImageError::UnknownKind { found }),
        }
    }
}

impl<'a> AnyIndex<'a> {
    /// Takes over bytes that [`RayIndex::as_bytes`](crate::RayIndex::as_bytes) gave, of any kind that is compiled in;
    /// see [`Index::from_bytes`](crate::Index::from_bytes).
    ///
    /// # Errors
    /// Any of [`ImageError`].
    ///
    /// # Examples
    /// ```
    /// use arboleda::{AnyIndex, Block, Index, IndexKind, Linear, Options, RayIndex, Scene, Triangle, Vec3};
    ///
    /// let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)];
    /// let (mut arena, mut scratch) = ([Block::ZERO; 8], [Block::ZERO; 8]);
    /// let built = Index::<Linear>::build(
    ///     &Scene::new(&triangles), &Options::default(), Block::bytes(&mut arena), Block::bytes(&mut scratch))?;
    ///
    /// let read = AnyIndex::from_bytes(built.as_bytes())?;
    /// assert_eq!(read.kind(), IndexKind::Linear);
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, ImageError> {
        IndexKind::of_image(bytes)?.from_bytes(bytes)
    }

    /// Takes over bytes of an index of any kind that lies [beside](crate::Scene::beside) a mesh; see
    /// [`Index::from_bytes_beside`](crate::Index::from_bytes_beside).
    ///
    /// # Errors
    /// Any of [`ImageError`].
    pub fn from_bytes_beside(bytes: &'a [u8], mesh: Mesh<'a>) -> Result<Self, ImageError> {
        IndexKind::of_image(bytes)?.from_bytes_beside(bytes, mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Block, Options, Scene, Triangle, Vec3};

    /// Writes an image of a triangle, with another kind in its header.
    fn image_of_kind(kind: u32) -> [Block; 8] {
        let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)];
        let (scene, options) = (Scene::new(&triangles), Options::DEFAULT);
        let (mut arena, mut scratch) = ([Block::ZERO; 8], [Block::ZERO; 8]);
        let (bytes, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
        assert!(IndexKind::Linear.build(&scene, &options, bytes, scratch).is_ok());
        Block::bytes(&mut arena)[12..16].copy_from_slice(&kind.to_ne_bytes());
        arena
    }

    #[test]
    fn kinds_that_are_not_here_are_refused_by_name() {
        for (number, feature) in FAMILIES {
            for kind in [number, number | 1 << 16] {
                let mut arena = image_of_kind(kind);
                let error = AnyIndex::from_bytes(Block::bytes(&mut arena)).err();
                let is_here = IndexKind::ALL.iter().any(|kind| kind.family() == feature);
                let left_out = Some(ImageError::KindLeftOut { feature });
                assert!(is_here || error == left_out, "{feature}: {error:?}");
            }
        }
        let mut arena = image_of_kind(99);
        let error = AnyIndex::from_bytes(Block::bytes(&mut arena)).err();
        assert_eq!(error, Some(ImageError::UnknownKind { found: 99 }));
    }

    #[test]
    fn numbers_do_not_depend_on_what_is_compiled_in() {
        let numbers = [
            ("linear", 0),
            ("octree", 1),
            ("octree-hierarchy", 2),
            ("octree-r", 3),
            ("octree-r-hierarchy", 4),
            ("uniform-grid", 5),
            ("grid-hierarchy", 6),
            ("kd-tree", 7),
            ("kd-tree-hierarchy", 8),
            ("bsp-tree", 9),
            ("bsp-tree-hierarchy", 10),
            ("bvh", 11),
            ("bvh-hierarchy", 12),
            ("wide-bvh", 13),
            ("wide-bvh-hierarchy", 14),
            ("compact-bvh", 15),
            ("compact-bvh-hierarchy", 16),
            ("lean-bvh", 17),
            ("lean-bvh-hierarchy", 18),
        ];
        for kind in IndexKind::ALL {
            assert!(numbers.contains(&(kind.name(), *kind as u32)), "{}", kind.name());
        }
    }

    #[test]
    fn families_are_named_by_their_number() {
        for kind in IndexKind::ALL {
            let number = kind.image_kind() & FAMILY;
            assert!(FAMILIES.contains(&(number, kind.family())), "{}", kind.name());
        }
    }
}
