//! Index and arena in one value, for a field of a struct or a static.
//!
//! Not for ROM: there, open an `Index<'static, _>` once; see [`include_index!`](crate::include_index).
//!
//! An [`Index`] borrows its arena, so a struct with both would borrow from itself. A [`Stored`] owns the arena, and
//! lends the index:
//!
//! ```text
//! Stored: blocks, checked once --index()--> Index, from the header alone, in constant time
//! ```
//! While a [`Stored`] owns its blocks, nothing can write to them. So [`Stored::index`] does not check them again.

use core::marker::PhantomData;

use super::Index;
use crate::error::{BuildError, OpenError};
use crate::input::{Options, Scene};
use crate::memory::Block;
use crate::sealed::Sealed;
use crate::structure::{Representation, Sections};

/// Storage of an index: blocks whose contents stay the same as long as they are not borrowed mutably.
///
/// Implemented for `[Block; N]` and for slices of blocks. The trait is sealed, because another type could return other
/// blocks each time.
pub trait Storage: Sealed {
    /// The blocks.
    fn blocks(&self) -> &[Block];
}

impl<const N: usize> Sealed for [Block; N] {}
impl Sealed for &[Block] {}
impl Sealed for &mut [Block] {}

impl<const N: usize> Storage for [Block; N] {
    fn blocks(&self) -> &[Block] {
        self
    }
}

impl Storage for &[Block] {
    fn blocks(&self) -> &[Block] {
        self
    }
}

impl Storage for &mut [Block] {
    fn blocks(&self) -> &[Block] {
        self
    }
}

/// Index that owns its arena, triangles included. An index [beside](Scene::beside) a mesh cannot be stored.
///
/// # Examples
/// ```
/// use arboleda::{Block, Options, Ray, Scene, Stored, Triangle, Vec3};
/// use arboleda::kinds::Linear;
///
/// struct Robot {
///     obstacles: Stored<[Block; 8], Linear>,
/// }
///
/// let triangles = [Triangle::new(Vec3::ZERO, Vec3::X, Vec3::Y)];
/// let (scene, options) = (Scene::new(&triangles), Options::default());
/// let mut scratch = [Block::ZERO; 8];
/// let obstacles = Stored::build(&scene, &options, [Block::ZERO; 8], Block::bytes(&mut scratch))?;
/// let robot = Robot { obstacles };
/// assert!(robot.obstacles.index().occluded(&Ray::new(Vec3::new(0.25, 0.25, -1.0), Vec3::Z)?));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
pub struct Stored<S, R> {
    storage: S,
    representation: PhantomData<R>,
}

impl<S: Storage, R: Representation> Stored<S, R> {
    /// Opens blocks that hold an index, and checks them as [`Index::from_bytes`] does. Cost: linear.
    ///
    /// # Errors
    /// Any of [`OpenError`].
    pub fn open(storage: S) -> Result<Self, OpenError> {
        Index::<R>::from_bytes(bytemuck::must_cast_slice(storage.blocks()))?;
        Ok(Self { storage, representation: PhantomData })
    }

    /// The index. Its header is read, and nothing is checked again. Cost: constant, some hundred instructions.
    pub fn index(&self) -> Index<'_, R> {
        let view = Sections::view(bytemuck::must_cast_slice(self.storage.blocks()), None);
        debug_assert!(view.is_ok(), "the blocks were checked");
        Index::of_checked(view.unwrap_or(Sections::EMPTY))
    }

    /// Returns the blocks.
    pub fn into_storage(self) -> S {
        self.storage
    }
}

impl<const N: usize, R: Representation> Stored<[Block; N], R> {
    /// Builds an index of a scene in `blocks`; see [`Index::build`].
    ///
    /// # Errors
    /// Any of [`BuildError`], and [`BuildError::CannotBeStored`] for a scene whose index lies
    /// [beside](Scene::beside) the mesh.
    pub fn build(
        scene: &Scene<'_>,
        options: &Options,
        mut blocks: [Block; N],
        scratch: &mut [u8],
    ) -> Result<Self, BuildError> {
        build_in::<R>(scene, options, &mut blocks, scratch)?;
        Ok(Self { storage: blocks, representation: PhantomData })
    }
}

impl<'a, R: Representation> Stored<&'a mut [Block], R> {
    /// Builds an index of a scene in blocks that live elsewhere; see [`Index::build`].
    ///
    /// # Errors
    /// The errors of [`Stored::build`].
    pub fn build_in(
        scene: &Scene<'_>,
        options: &Options,
        blocks: &'a mut [Block],
        scratch: &mut [u8],
    ) -> Result<Self, BuildError> {
        build_in::<R>(scene, options, blocks, scratch)?;
        Ok(Self { storage: blocks, representation: PhantomData })
    }
}

fn build_in<R: Representation>(
    scene: &Scene<'_>,
    options: &Options,
    blocks: &mut [Block],
    scratch: &mut [u8],
) -> Result<(), BuildError> {
    if scene.kept().is_some() {
        return Err(BuildError::CannotBeStored);
    }
    Index::<R>::build(scene, options, Block::bytes(blocks), scratch).map(drop)
}
