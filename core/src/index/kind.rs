//! Methods of `IndexKind` and `AnyIndex`.

use super::description::FAMILY;
use super::registry::FAMILIES;
use super::{AnyIndex, Capacity, IndexKind};
use crate::error::{BuildError, OpenError};
use crate::geometry::Ray;
use crate::input::{CostModel, Executor, Float64, Mesh, Options, Scene, Sequential};
use crate::query::{AllHits, Counters, Hit};
use crate::structure::sections::{MESH_BESIDE, format_of};
use crate::structure::{Statistics, Weights};

impl IndexKind {
    /// The name of the kind, on command lines and in tables.
    pub const fn name(self) -> &'static str {
        self.description().name
    }

    /// The name of the family: that of the index without clusters, and the feature that compiles the kind in.
    pub const fn family(self) -> &'static str {
        self.description().family
    }

    /// The number of the format; see [`Representation::FORMAT`](crate::kinds::Representation::FORMAT).
    pub const fn format(self) -> u32 {
        self.description().format
    }

    /// Tells whether the index holds the triangles in a form of its own, and cannot lie [beside](Scene::beside) them.
    pub const fn holds_triangles(self) -> bool {
        self.description().holds_triangles
    }

    /// Tells whether [`Scene::rays`] influence what is built. Query results never depend on them.
    pub const fn uses_rays(self) -> bool {
        self.description().uses_rays
    }

    /// Tells whether the kind divides the scene into clusters.
    pub const fn is_clustered(self) -> bool {
        self.description().is_clustered
    }

    /// The cost model of builds that estimate: the cost of a node in triangle tests.
    pub const fn cost_model(self) -> CostModel {
        self.description().cost
    }

    /// The weights of a query, on processors with `f64` in hardware or in software.
    pub const fn weights(self, float64: Float64) -> Weights {
        match float64 {
            Float64::Hardware => self.description().weights,
            Float64::Software => self.description().software_weights,
        }
    }

    /// Measures the memory and the work of a build, by a dry run; see [`Index::capacity`](crate::Index::capacity).
    ///
    /// # Errors
    /// The errors of [`Index::capacity`](crate::Index::capacity).
    pub fn capacity(
        self,
        scene: &Scene<'_>,
        options: &Options,
        scratch: &mut [u8],
    ) -> Result<Capacity, BuildError> {
        self.capacity_with(scene, options, scratch, &Sequential)
    }

    /// Builds an index of this kind in the first bytes of `arena`; see [`Index::build`](crate::Index::build).
    ///
    /// # Errors
    /// The errors of [`Index::build`](crate::Index::build).
    pub fn build<'a>(
        self,
        scene: &Scene<'a>,
        options: &Options,
        arena: &'a mut [u8],
        scratch: &mut [u8],
    ) -> Result<AnyIndex<'a>, BuildError> {
        self.build_with(scene, options, arena, scratch, &Sequential)
    }

    /// Builds an index of this kind, with the help of an executor; see [`Index::build_with`](crate::Index::build_with).
    ///
    /// # Errors
    /// The errors of [`Index::build`](crate::Index::build).
    pub fn build_with<'a>(
        self,
        scene: &Scene<'a>,
        options: &Options,
        arena: &'a mut [u8],
        scratch: &mut [u8],
        executor: &impl Executor,
    ) -> Result<AnyIndex<'a>, BuildError> {
        self.build_counted(scene, options, arena, scratch, executor, &mut 0)
    }

    /// Opens the bytes of an index of this kind; see [`Index::from_bytes`](crate::Index::from_bytes).
    ///
    /// # Errors
    /// Any of [`OpenError`].
    pub fn from_bytes(self, bytes: &[u8]) -> Result<AnyIndex<'_>, OpenError> {
        self.read(bytes, None).map(|(index, _)| index)
    }

    /// Opens the bytes of an index of this kind that lies beside a mesh; see
    /// [`Index::from_bytes_beside`](crate::Index::from_bytes_beside).
    ///
    /// # Errors
    /// Any of [`OpenError`].
    pub fn from_bytes_beside<'a>(
        self,
        bytes: &'a [u8],
        mesh: Mesh<'a>,
    ) -> Result<AnyIndex<'a>, OpenError> {
        self.read(bytes, Some(mesh)).map(|(index, _)| index)
    }
}

impl IndexKind {
    /// Reads the kind from the header of an index; the rest of the bytes is not read. Cost: constant.
    ///
    /// # Errors
    /// - [`OpenError::KindLeftOut`] for a kind that was left out of this build, [`OpenError::UnknownKind`].
    /// - The errors of a header: `Misaligned`, `Truncated`, `NotAnIndex`, `OtherByteOrder`, `OtherVersion`.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, OpenError> {
        let found = format_of(bytes)? & !MESH_BESIDE;
        if let Some(&kind) = Self::ALL.iter().find(|kind| kind.format() == found) {
            return Ok(kind);
        }
        match FAMILIES.iter().find(|(family, _)| *family == found & FAMILY) {
            Some((_, feature)) => Err(OpenError::KindLeftOut { feature }),
            None => Err(OpenError::UnknownKind { found }),
        }
    }
}

impl<'a> AnyIndex<'a> {
    /// Opens the bytes of an index of any kind that is compiled in; see
    /// [`Index::from_bytes`](crate::Index::from_bytes).
    ///
    /// # Errors
    /// Any of [`OpenError`].
    ///
    /// # Examples
    /// ```
    /// use arboleda::{AnyIndex, Block, Index, IndexKind, Options, RayIndex, Scene, Triangle, Vec3};
    /// use arboleda::kinds::Linear;
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
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, OpenError> {
        IndexKind::of_bytes(bytes)?.from_bytes(bytes)
    }

    /// Opens the bytes of an index, as [`AnyIndex::from_bytes`] does, and returns what it consists of: the validation
    /// counts that anyway. A [`check`](AnyIndex::check) afterwards would validate them again.
    ///
    /// # Errors
    /// Any of [`OpenError`].
    ///
    /// # Examples
    /// ```
    /// use arboleda::{AnyIndex, IndexKind, Block, Options, Scene, Triangle, Vec3};
    ///
    /// let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)];
    /// let (mut arena, mut scratch) = ([Block::ZERO; 8], [Block::ZERO; 8]);
    /// let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
    /// let built = IndexKind::Linear.build(&Scene::new(&triangles), &Options::DEFAULT, arena, scratch)?;
    ///
    /// let (opened, statistics) = AnyIndex::from_bytes_counted(built.as_bytes())?;
    /// assert_eq!(statistics.references, 1);
    /// assert_eq!(statistics, opened.check()?);
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn from_bytes_counted(bytes: &'a [u8]) -> Result<(Self, Statistics), OpenError> {
        IndexKind::of_bytes(bytes)?.read(bytes, None)
    }

    /// Opens bytes that were validated before, from the header alone: by [`AnyIndex::from_bytes`] in this process, or in
    /// another one that shares the memory or the file. Cost: constant.
    ///
    /// The bytes must not have changed since. On other bytes a query reads nothing out of bounds, but it may find anything,
    /// panic where overflow is checked, or not end.
    ///
    /// # Errors
    /// The errors of a header, as [`IndexKind::of_bytes`], and [`OpenError::Malformed`], [`OpenError::Truncated`] or
    /// [`OpenError::MeshMissing`].
    ///
    /// # Examples
    /// ```
    /// use arboleda::{AnyIndex, Block, IndexKind, Options, Scene, Triangle, Vec3};
    ///
    /// let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)];
    /// let (mut arena, mut scratch) = ([Block::ZERO; 8], [Block::ZERO; 8]);
    /// let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
    /// let built = IndexKind::Linear.build(&Scene::new(&triangles), &Options::DEFAULT, arena, scratch)?;
    /// let again = AnyIndex::from_validated_bytes(built.as_bytes())?;
    /// assert_eq!(again.kind(), IndexKind::Linear);
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub fn from_validated_bytes(bytes: &'a [u8]) -> Result<Self, OpenError> {
        IndexKind::of_bytes(bytes)?.view(bytes)
    }

    /// Opens the bytes of an index of any kind that lies [beside](crate::Scene::beside) a mesh; see
    /// [`Index::from_bytes_beside`](crate::Index::from_bytes_beside).
    ///
    /// # Errors
    /// Any of [`OpenError`].
    pub fn from_bytes_beside(bytes: &'a [u8], mesh: Mesh<'a>) -> Result<Self, OpenError> {
        IndexKind::of_bytes(bytes)?.from_bytes_beside(bytes, mesh)
    }
}

/// Queries. Each chooses the kind by a branch, and calls the query of [`Index`](crate::Index).
impl<'a> AnyIndex<'a> {
    /// The bytes of the index; see [`Index::as_bytes`](crate::Index::as_bytes).
    pub fn as_bytes(&self) -> &'a [u8] {
        self.sections().bytes()
    }

    /// Finds the closest hit; see [`Index::closest_hit`](crate::Index::closest_hit).
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.as_ray_index().closest_hit(ray)
    }

    /// Tells whether any triangle is hit; see [`Index::occluded`](crate::Index::occluded).
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.as_ray_index().occluded(ray)
    }

    /// Finds the closest hit of each ray; see [`Index::closest_hits`](crate::Index::closest_hits).
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.as_ray_index().closest_hits(rays, hits);
    }

    /// Finds the closest hit of each ray, in memory of the caller; see
    /// [`Index::closest_hits_in`](crate::Index::closest_hits_in).
    pub fn closest_hits_in(&self, rays: &[Ray], hits: &mut [Hit], scratch: &mut [u8]) {
        self.as_ray_index().closest_hits_in(rays, hits, scratch);
    }

    /// Tells for each ray whether any triangle is hit; see [`Index::occluded_each`](crate::Index::occluded_each).
    pub fn occluded_each(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.as_ray_index().occluded_each(rays, occluded);
    }

    /// Tells for each ray whether any triangle is hit, in memory of the caller; see
    /// [`Index::occluded_each_in`](crate::Index::occluded_each_in).
    pub fn occluded_each_in(&self, rays: &[Ray], occluded: &mut [bool], scratch: &mut [u8]) {
        self.as_ray_index().occluded_each_in(rays, occluded, scratch);
    }

    /// Finds all hits, sorted by `(t, id)`; see [`Index::all_hits`](crate::Index::all_hits).
    pub fn all_hits<'h>(&self, ray: &Ray, buffer: &'h mut [Hit]) -> AllHits<'h> {
        self.as_ray_index().all_hits(ray, buffer)
    }

    /// Finds the closest hit and counts the work; see
    /// [`Index::closest_hit_counted`](crate::Index::closest_hit_counted).
    pub fn closest_hit_counted(&self, ray: &Ray, counters: &mut Counters) -> Option<Hit> {
        self.as_ray_index().closest_hit_counted(ray, counters)
    }

    /// Tells whether any triangle is hit and counts the work; see
    /// [`Index::occluded_counted`](crate::Index::occluded_counted).
    pub fn occluded_counted(&self, ray: &Ray, counters: &mut Counters) -> bool {
        self.as_ray_index().occluded_counted(ray, counters)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;
    use crate::geometry::Triangle;
    use crate::input::{Options, Scene};
    use crate::memory::Block;

    /// Builds an index of one triangle, and writes another kind into its header.
    fn bytes_of_kind(kind: u32) -> [Block; 8] {
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
        for &(number, feature) in FAMILIES {
            for kind in [number, number | 1 << 16] {
                let mut arena = bytes_of_kind(kind);
                let error = AnyIndex::from_bytes(Block::bytes(&mut arena)).err();
                let is_here = IndexKind::ALL.iter().any(|kind| kind.family() == feature);
                let left_out = Some(OpenError::KindLeftOut { feature });
                assert!(is_here || error == left_out, "{feature}: {error:?}");
            }
        }
        let mut arena = bytes_of_kind(99);
        let error = AnyIndex::from_bytes(Block::bytes(&mut arena)).err();
        assert_eq!(error, Some(OpenError::UnknownKind { found: 99 }));
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
            let number = kind.format() & FAMILY;
            assert!(FAMILIES.contains(&(number, kind.family())), "{}", kind.name());
        }
    }
}
