//! Typed slices of caller-provided bytes.

use bytemuck::{Pod, Zeroable};

/// Alignment in bytes of an arena, of a scratch and of each section of an index: a cache line.
pub const ALIGNMENT: usize = 64;

/// Block of 64 aligned bytes: the unit of which callers make arenas and scratches.
///
/// # Examples
/// ```
/// use arboleda::Block;
/// let mut arena = [Block::ZERO; 16];
/// assert_eq!(Block::bytes(&mut arena).len(), 1024);
/// assert_eq!(Block::count(1000), 16);
/// ```
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Block([u8; ALIGNMENT]);

impl Block {
    /// A block of zeros.
    pub const ZERO: Self = Self([0; ALIGNMENT]);

    /// The number of blocks that hold `bytes` bytes.
    pub const fn count(bytes: usize) -> usize {
        bytes.div_ceil(ALIGNMENT)
    }

    /// The bytes of `blocks`, as an arena or a scratch.
    pub fn bytes(blocks: &mut [Self]) -> &mut [u8] {
        bytemuck::must_cast_slice_mut(blocks)
    }
}

/// Value that starts at a multiple of [`ALIGNMENT`] bytes, as the bytes of an index must. See
/// [`include_index!`](crate::include_index).
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Aligned<T: ?Sized>(pub T);

/// Includes the bytes of a file as a `&'static [u8]`, as `include_bytes!` does, but aligned.
///
/// The file was written from [`Index::as_bytes`](crate::Index::as_bytes). The index is opened where the bytes lie, for
/// example in ROM: once at start-up, because opening checks all links and cannot run in a constant.
///
/// # Examples
/// ```
/// # #[cfg(all(feature = "bvh", target_endian = "little"))] {
/// use arboleda::kinds::Bvh;
/// use arboleda::{Index, include_index};
///
/// static BYTES: &[u8] = include_index!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/square.arb"));
/// let index: Index<'static, Bvh> = Index::from_bytes(BYTES)?;
/// assert_eq!(index.as_bytes().as_ptr(), BYTES.as_ptr());
/// # }
/// # Ok::<(), arboleda::OpenError>(())
/// ```
#[macro_export]
macro_rules! include_index {
    ($file:expr $(,)?) => {{
        static BYTES: &$crate::Aligned<[u8]> = &$crate::Aligned(*::core::include_bytes!($file));
        &BYTES.0
    }};
}

/// Rounds `bytes` up to a multiple of [`ALIGNMENT`]; saturates.
pub(crate) const fn padded(bytes: usize) -> usize {
    bytes.saturating_add(ALIGNMENT - 1) & !(ALIGNMENT - 1)
}

/// The number of bytes that `Arena::take::<T>(count)` uses up.
pub(crate) const fn size_of_slice<T>(count: usize) -> usize {
    padded(count.saturating_mul(size_of::<T>()))
}

/// Allocator that hands out aligned slices of a byte slice, front to back.
pub(crate) struct Arena<'a> {
    rest: &'a mut [u8],
}

impl<'a> Arena<'a> {
    /// Starts with bytes that begin at a multiple of [`ALIGNMENT`]; `None` if they do not.
    pub fn new(bytes: &'a mut [u8]) -> Option<Self> {
        (bytes.as_ptr().addr().is_multiple_of(ALIGNMENT) || bytes.is_empty())
            .then_some(Self { rest: bytes })
    }

    /// Takes `count` elements, whose contents are undefined; `None` if too few bytes are left.
    pub fn take<T: Pod>(&mut self, count: usize) -> Option<&'a mut [T]> {
        if count == 0 {
            return Some(&mut []); // an empty slice of bytes may be misaligned
        }
        let size = count.checked_mul(size_of::<T>())?;
        let rest = core::mem::take(&mut self.rest);
        let (bytes, rest) = rest.split_at_mut_checked(size)?;
        // The last section may end before its padding does.
        let padding = (padded(size) - size).min(rest.len());
        self.rest = rest.split_at_mut_checked(padding)?.1;
        bytemuck::try_cast_slice_mut(bytes).ok()
    }

    /// The bytes that are left.
    pub fn into_rest(self) -> &'a mut [u8] {
        self.rest
    }
}
