//! Memory of the C caller: the only place where pointers become references.
//!
//! ```text
//! pointer, count --check--> Input, Output --apart--> no overlap --Caller--> &[T], &mut [T]
//! ```
//! 1. [`Input::check`] and [`Output::check`] refuse null pointers, misaligned ones, and lengths that no memory has.
//! 2. [`apart`] refuses outputs that overlap another argument.
//! 3. [`Caller`] borrows. What no check can see, it takes from the caller's promise: that memory of the stated length
//!    lies at a pointer.
//!
//! A build that takes several calls lies in the caller's scratch between them: [`Output::split`], [`Caller::keep`],
//! [`Caller::kept`].
//!
//! ```text
//! scratch: | mark, address, build | what the build uses |
//! ```

use core::ffi::c_void;
use core::mem::{MaybeUninit, offset_of};
use core::{ptr, slice};

use arboleda::{AnyIndex, Block, BuildError, Mesh, Ray, Triangle, Vec3};

use crate::error::{Failure, arb_status};
use crate::index::arb_index;
use crate::query::{arb_counters, arb_hit, arb_ray};
use crate::scene::arb_mesh;

/// Type of which any bytes are a value.
///
/// # Safety
/// No value of the type's size is invalid.
pub unsafe trait Plain: Copy {}

// SAFETY: numbers, and structs of numbers or of raw pointers, have no invalid values.
unsafe impl Plain for u8 {}
// SAFETY: as above.
unsafe impl Plain for u32 {}
// SAFETY: as above.
unsafe impl Plain for [u32; 3] {}
// SAFETY: as above.
unsafe impl Plain for Vec3 {}
// SAFETY: as above.
unsafe impl Plain for Triangle {}
// SAFETY: as above.
unsafe impl Plain for arb_ray {}
// SAFETY: as above.
unsafe impl Plain for arb_hit {}
// SAFETY: as above.
unsafe impl Plain for arb_counters {}
// SAFETY: as above.
unsafe impl Plain for arb_mesh {}

/// Addresses of an argument.
#[derive(Clone, Copy)]
pub struct Region {
    name: &'static str,
    first: usize,
    end: usize,
}

impl Region {
    /// The addresses of bytes that were borrowed before.
    pub fn of<T>(values: &[T], name: &'static str) -> Self {
        let first = values.as_ptr().addr();
        Self { name, first, end: first.saturating_add(size_of_val(values)) }
    }

    fn overlaps(&self, other: &Self) -> bool {
        let are_full = self.first < self.end && other.first < other.end;
        are_full && self.first < other.end && other.first < self.end
    }
}

/// The addresses of an open handle's index and of what it borrows: its bytes and, beside a mesh, the mesh's arrays.
pub fn borrowed(index: &AnyIndex<'_>) -> [Region; 4] {
    let first = ptr::from_ref(index).addr().saturating_sub(offset_of!(Opened, index));
    let end = first.saturating_add(size_of::<arb_index>());
    let handle = Region { name: "the handle", first, end };
    let bytes = Region::of(index.as_bytes(), "the index");
    match index.sections().triangles() {
        Mesh::Triangles(list) => [handle, bytes, Region::of(list, "the index's triangles"), bytes],
        Mesh::Indexed { vertices, corners } => {
            let vertices = Region::of(vertices, "the index's vertices");
            [handle, bytes, vertices, Region::of(corners, "the index's corners")]
        }
    }
}

/// Checks that no output overlaps another output or an input.
pub fn apart(outputs: &[Region], inputs: &[Region]) -> Result<(), Failure> {
    for (at, output) in outputs.iter().enumerate() {
        let others = outputs.iter().take(at).chain(inputs);
        for other in others {
            if output.overlaps(other) {
                return Err(Failure::Overlap { output: output.name, other: other.name });
            }
        }
    }
    Ok(())
}

/// Checks a pointer to `count` values.
fn check<T>(first: *const T, count: usize, name: &'static str) -> Result<Region, Failure> {
    let failure = |status| Failure::Argument { status, name };
    let too_long = failure(arb_status::ARB_LENGTH_OVERFLOW);
    let bytes = count.checked_mul(size_of::<T>()).filter(|&bytes| bytes <= isize::MAX as usize);
    let bytes = bytes.ok_or(too_long)?;
    if count == 0 {
        return Ok(Region { name, first: 0, end: 0 });
    }
    if first.is_null() {
        return Err(failure(arb_status::ARB_NULL_POINTER));
    }
    if !first.is_aligned() {
        return Err(failure(arb_status::ARB_MISALIGNED_POINTER));
    }
    let end = first.addr().checked_add(bytes).ok_or(too_long)?;
    Ok(Region { name, first: first.addr(), end })
}

/// Checked pointer to values that are read.
#[derive(Clone, Copy)]
pub struct Input<T> {
    first: *const T,
    count: usize,
    region: Region,
}

impl<T: Plain> Input<T> {
    /// Checks a pointer to `count` values; of none, it may be null.
    pub fn check(first: *const T, count: usize, name: &'static str) -> Result<Self, Failure> {
        Ok(Self { first, count, region: check(first, count, name)? })
    }

    /// The addresses of the values.
    pub fn region(&self) -> Region {
        self.region
    }
}

/// Checked pointer to values that are written.
pub struct Output<T> {
    first: *mut T,
    count: usize,
    region: Region,
}

impl<T> Output<T> {
    /// Checks a pointer to room for `count` values; for none, it may be null.
    pub fn check(first: *mut T, count: usize, name: &'static str) -> Result<Self, Failure> {
        Ok(Self { first, count, region: check(first, count, name)? })
    }

    /// Checks a pointer to room for a value.
    pub fn one(first: *mut T, name: &'static str) -> Result<Self, Failure> {
        Self::check(first, 1, name)
    }

    /// The addresses of the values.
    pub fn region(&self) -> Region {
        self.region
    }

    /// Tells whether there is no room.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }
}

/// Room for a build in its scratch, and the rest of the scratch.
pub type SplitScratch<T> = (Output<Slot<Kept<T>>>, Output<u8>);

impl Output<u8> {
    /// Splits the scratch of a build, of which `needed` bytes are enough, into room for the build and the rest.
    pub fn split_scratch<T>(self, needed: usize) -> Result<SplitScratch<T>, Failure> {
        let full = BuildError::ScratchFull { needed, given: self.count };
        if self.count < needed {
            return Err(full.into());
        }
        self.check_alignment()?;
        self.split().ok_or(Failure::Build(full))
    }

    /// Checks that the memory, if there is any, begins at a multiple of 64 bytes.
    pub fn check_alignment(&self) -> Result<(), Failure> {
        let is_aligned = self.count == 0 || self.first.cast::<Block>().is_aligned();
        if is_aligned { Ok(()) } else { Err(BuildError::Misaligned.into()) }
    }

    /// Splits memory that begins at a multiple of 64 bytes into room for a value and the rest. `None` if it is too short.
    pub fn split<T>(self) -> Option<(Output<Slot<T>>, Self)> {
        let Self { first, count, region } = self;
        let rest = count.checked_sub(size_of::<Slot<T>>())?;
        let slot = Output { first: first.cast::<Slot<T>>(), count: 1, region };
        let first = first.wrapping_add(size_of::<Slot<T>>());
        Some((slot, Self { first, count: rest, region }))
    }
}

/// Room for a value in the caller's memory.
#[repr(C, align(64))]
pub struct Slot<T>(MaybeUninit<T>);

/// Build that lies in the caller's memory between two calls.
pub trait Keep: 'static {
    /// Number by which it is told from any other memory, another for each type.
    const MARK: u64;
    /// Name of the argument that points to it.
    const NAME: &'static str;
}

/// Contents of memory in which a build lies.
#[repr(C)]
pub struct Kept<T> {
    mark: u64,
    /// The address of this. A copy elsewhere is no build: two would use the same scratch.
    address: usize,
    /// Regions that the build borrows: no output of a later call may overlap them.
    pub borrowed: [Region; 6],
    /// The build.
    pub value: T,
}

impl<T> Kept<T> {
    /// Ends the build: its memory is not taken for one again.
    pub fn end(&mut self) {
        self.mark = 0;
    }
}

/// Number by which an open handle is told from any other memory.
const OPEN: u64 = 0x4152_4244_6865_6c64;

/// Contents of an open [`arb_index`].
#[repr(C)]
struct Opened {
    mark: u64,
    index: MaybeUninit<AnyIndex<'static>>,
}

const _: () = assert!(size_of::<Opened>() <= size_of::<arb_index>());
const _: () = assert!(align_of::<Opened>() <= align_of::<arb_index>());

/// Promise of the caller of an exported function.
#[derive(Clone, Copy)]
pub struct Caller(());

impl Caller {
    /// Takes the promise.
    ///
    /// # Safety
    /// - Each pointer that is given to this value's methods is null, or memory for as many values as are stated lies
    ///   there. Nothing else writes to that memory during the call.
    /// - The caller allocated that memory. So no compiler sees that it may not be written yet, and its bytes are
    ///   arbitrary numbers at worst.
    /// - Memory that an index borrows stays as it is for as long as its handle is used.
    /// - Memory of a build that takes several calls is neither read nor written by anybody else, and its mesh stays as it
    ///   is, until the build is over.
    pub const unsafe fn promises() -> Self {
        Self(())
    }

    /// Borrows values for as long as the caller says.
    pub fn borrow<'a, T: Plain>(self, input: Input<T>) -> &'a [T] {
        if input.count == 0 {
            return &[];
        }
        // SAFETY: the pointer is not null, it is aligned, and the length is at most `isize::MAX` bytes (`check`). The
        // caller promises the rest. `T` has no invalid values.
        unsafe { slice::from_raw_parts(input.first, input.count) }
    }

    /// Borrows room for values. The caller of this function has checked that nothing else overlaps it.
    pub fn borrow_mut<'a, T: Plain>(self, output: Output<T>) -> &'a mut [T] {
        if output.count == 0 {
            return &mut [];
        }
        // SAFETY: as in `borrow`; `apart` has checked that no other reference of this call overlaps it.
        unsafe { slice::from_raw_parts_mut(output.first, output.count) }
    }

    /// Borrows room for truth values, and makes all of them false.
    pub fn borrow_flags<'a>(self, output: Output<bool>) -> &'a mut [bool] {
        if output.count == 0 {
            return &mut [];
        }
        // SAFETY: as in `borrow_mut`. What the caller has left there may be neither true nor false, so it is overwritten
        // before there is a reference.
        unsafe {
            output.first.write_bytes(0, output.count);
            slice::from_raw_parts_mut(output.first, output.count)
        }
    }

    /// Reads a value.
    pub fn read<T: Plain>(self, first: *const T, name: &'static str) -> Result<T, Failure> {
        let input = Input::check(first, 1, name)?;
        // SAFETY: as in `borrow`.
        Ok(unsafe { input.first.read() })
    }

    /// Writes a value.
    pub fn write<T>(self, output: Output<T>, value: T) {
        if output.count > 0 {
            // SAFETY: as in `borrow_mut`, and no reference is made.
            unsafe { output.first.write(value) };
        }
    }

    /// Writes an open handle.
    pub fn write_index(self, output: Output<arb_index>, index: AnyIndex<'static>) {
        let opened = Opened { mark: OPEN, index: MaybeUninit::new(index) };
        let output = Output {
            first: output.first.cast::<Opened>(),
            count: output.count,
            region: output.region,
        };
        self.write(output, opened);
    }

    /// Writes a value into memory that nobody else uses as long as the value is used, and borrows it.
    pub fn place<'a, T>(self, to: Output<Slot<T>>, value: T) -> &'a T {
        let first = to.first;
        self.write(to, Slot(MaybeUninit::new(value)));
        // SAFETY: `split` made the output, of memory that was checked; the value was just written.
        unsafe { (*first).0.assume_init_ref() }
    }

    /// Leaves a build, which `begin` makes where it stays, in memory that begins at a multiple of 64 bytes, and returns its
    /// address.
    pub fn keep<T: Keep>(
        self,
        to: Output<Slot<Kept<T>>>,
        borrowed: [Region; 6],
        begin: impl FnOnce(&mut MaybeUninit<T>) -> Result<(), Failure>,
    ) -> Result<*mut c_void, Failure> {
        let first = to.first.cast::<Kept<MaybeUninit<T>>>();
        // SAFETY: `split` made the output, of memory that was checked; nobody else uses it. No reference to its old
        // contents is made but to the value, which has none.
        let value = unsafe {
            (&raw mut (*first).mark).write(0);
            &mut (*first).value
        };
        begin(value)?;
        // SAFETY: as above.
        unsafe {
            (&raw mut (*first).borrowed).write(borrowed);
            (&raw mut (*first).address).write(first.addr());
            (&raw mut (*first).mark).write(T::MARK);
        }
        Ok(first.cast())
    }

    /// The build that [`keep`](Self::keep) has left.
    pub fn kept<'a, T: Keep>(self, first: *mut c_void) -> Result<&'a mut Kept<T>, Failure> {
        let region = check(first.cast::<Slot<Kept<T>>>(), 1, T::NAME)?;
        let kept = first.cast::<Kept<T>>();
        // SAFETY: the pointer was checked; mark and address are numbers.
        let (mark, address) =
            unsafe { ((&raw const (*kept).mark).read(), (&raw const (*kept).address).read()) };
        if mark != T::MARK || address != region.first {
            return Err(Failure::NotBegun);
        }
        // SAFETY: only `keep` writes the mark of this type and this address, together with all else. The caller promises
        // not to forge them, and to leave the memory alone between the calls.
        Ok(unsafe { &mut *kept })
    }

    /// The index of an open handle.
    pub fn index<'a>(self, handle: *const arb_index) -> Result<&'a AnyIndex<'static>, Failure> {
        let region = check(handle, 1, "index")?;
        debug_assert!(region.first < region.end, "a handle has a size");
        // SAFETY: the pointer was checked; the first word of a handle is a number.
        let mark = unsafe { handle.cast::<u64>().read() };
        if mark != OPEN {
            return Err(Failure::NotOpen);
        }
        // SAFETY: only `write_index` writes the mark, together with an index. The caller promises not to forge it.
        Ok(unsafe { (*handle.cast::<Opened>()).index.assume_init_ref() })
    }
}

/// Writes rays into bytes that are not needed otherwise, as many as find room.
pub fn rays_in(bytes: &mut [u8], rays: impl Iterator<Item = Ray>) -> &[Ray] {
    // SAFETY: `MaybeUninit<Ray>` has no invalid values. A ray has no padding, so the bytes stay numbers.
    let (_, slots, _) = unsafe { bytes.align_to_mut::<MaybeUninit<Ray>>() };
    let mut count = 0;
    for (slot, ray) in slots.iter_mut().zip(rays) {
        slot.write(ray);
        count += 1;
    }
    let written = slots.get(..count).unwrap_or_default();
    // SAFETY: the first `count` slots were written, and `MaybeUninit<Ray>` has the layout of `Ray`.
    unsafe { &*(ptr::from_ref(written) as *const [Ray]) }
}
