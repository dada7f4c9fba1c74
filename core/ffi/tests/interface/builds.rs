//! Tests of builds that are refused: each reason has its status and its numbers.

use std::ffi::c_void;
use std::ptr::{null, null_mut};

use crate::given::*;
use arboleda::Block;
use arboleda_ffi::arb_status::*;
use arboleda_ffi::*;

const WIDE: u32 = arb_kind::ARB_WIDE_BVH as u32;
const BVH: u32 = arb_kind::ARB_BVH as u32;

/// Changes a mesh, and expects that neither measuring nor building takes it.
fn refused_mesh(
    change: impl FnOnce(&mut arb_mesh, &mut arb_options),
) -> (arb_status, usize, String) {
    let given = Given::groups();
    let (mut mesh, mut options) = (given.indexed(), default_options());
    change(&mut mesh, &mut options);
    let Err(error) = build(BVH, &mesh, &options) else { panic!("the mesh was taken") };
    (error.status, error.element, message(&error))
}

#[test]
fn meshes() {
    let given = Given::groups();
    let triangles = given.triangles();
    let mut corners = given.corners.clone();
    corners[5][1] = 305;
    let mut vertices = given.vertices.clone();
    vertices[given.corners[9][2] as usize][0] = f32::NAN;
    let first = given.corners.iter().position(|c| c.contains(&given.corners[9][2])).unwrap();
    let objects: Vec<u32> = (0..456).map(|i| if i == 3 { 456 } else { 0 }).collect();

    let status = |(status, element, _): (arb_status, usize, String)| (status, element);
    let both = refused_mesh(|mesh, _| mesh.triangles = triangles.as_ptr().cast());
    assert_eq!(status(both), (ARB_TWO_MESHES, 0));
    let corner = refused_mesh(|mesh, _| mesh.corners = corners.as_ptr().cast());
    assert_eq!(status(corner), (ARB_CORNER_OUT_OF_RANGE, 5));
    let vertex = refused_mesh(|mesh, _| mesh.vertices = vertices.as_ptr().cast());
    assert_eq!(status(vertex), (ARB_NON_FINITE_VERTEX, first));
    let object = refused_mesh(|mesh, _| mesh.objects = objects.as_ptr());
    assert_eq!(status(object), (ARB_OBJECT_OUT_OF_RANGE, 3));
    let (status, _, text) = refused_mesh(|mesh, _| mesh.vertices = null());
    assert_eq!((status, &*text), (ARB_NULL_POINTER, "mesh.vertices is NULL"));
    let (status, _, text) = refused_mesh(|mesh, _| mesh.corners = null());
    assert_eq!((status, &*text), (ARB_NULL_POINTER, "mesh.corners is NULL"));
    let (status, _, text) =
        refused_mesh(|mesh, _| (mesh.vertices, mesh.corners) = (null(), null()));
    assert_eq!((status, &*text), (ARB_NULL_POINTER, "mesh.triangles is NULL"));
    let (status, _, text) = refused_mesh(|mesh, _| mesh.objects = odd(mesh.corners.cast_mut()));
    assert_eq!(
        (status, &*text),
        (ARB_MISALIGNED_POINTER, "mesh.objects is not aligned for its type")
    );
    let (status, _, text) = refused_mesh(|mesh, _| mesh.vertex_count = usize::MAX / 3);
    assert_eq!((status, &*text), (ARB_LENGTH_OVERFLOW, "mesh.vertices is longer than any memory"));
}

#[test]
fn options() {
    let refused = |change: fn(&mut arb_options)| {
        let (status, _, text) = refused_mesh(|_, options| change(options));
        assert_eq!(status, ARB_INVALID_OPTION, "{text}");
        text
    };
    assert!(refused(|options| options.leaf_capacity = 0).starts_with("leaf_capacity"));
    assert!(refused(|options| options.level = 21).starts_with("level"));
    assert!(refused(|options| options.level = -2).starts_with("level"));
    assert!(refused(|options| options.least_side = f32::NAN).starts_with("least_side"));
    assert!(refused(|options| options.proximity = f32::NAN).starts_with("proximity"));
    assert!(refused(|options| options.size_classes = 5).starts_with("size_classes"));
    assert!(refused(|options| options.resolution = 3).starts_with("resolution"));
    assert!(
        refused(|options| (options.resolution, options.cells) = (ARB_CELLS, [0; 3]))
            .starts_with("resolution")
    );
    assert!(
        refused(|options| {
            (options.resolution, options.cells_per_triangle) = (ARB_CELLS_PER_TRIANGLE, f32::NAN);
        })
        .starts_with("resolution")
    );
    assert!(refused(|options| options.bvh_build = 2).starts_with("bvh_build"));
    assert!(refused(|options| options.traversal_cost = f64::NAN).starts_with("cost"));
    assert!(refused(|options| options.intersection_cost = 1.0).starts_with("cost"));
    assert!(refused(|options| options.beside = 2).starts_with("beside"));
    assert!(refused(|options| options.reserved = 1).starts_with("reserved"));
    assert!(refused(|options| options.size = 79).starts_with("options.size"));
    assert!(refused(|options| options.size = u32::MAX).starts_with("options.size"));
    let (status, ..) = refused_mesh(|_, options| options.work_limit = 1);
    assert_eq!(status, ARB_TOO_MUCH_WORK);
}

/// A program compiled against a later header gives a longer struct.
#[test]
fn options_of_a_later_version_are_taken_if_they_are_zero() {
    #[repr(C)]
    struct Later {
        options: arb_options,
        more: [u64; 2],
    }
    let mut later = Later { options: default_options(), more: [9; 2] };
    let (first, size) = (&raw mut later.options, size_of::<Later>());
    assert_eq!(unsafe { arb_options_default(first, size) }, ARB_OK);
    assert_eq!((later.options.size as usize, later.more), (size, [0; 2]));
    let mut bytes = 0;
    let mut ask = |later: &Later| unsafe {
        let options = (&raw const *later).cast();
        let mut error = empty_error();
        let status = arb_scratch_bytes(BVH, 10, options, &mut bytes, &mut error);
        (status, message(&error))
    };
    assert_eq!(ask(&later).0, ARB_OK);
    later.more[1] = 1;
    let (status, text) = ask(&later);
    assert!(status == ARB_INVALID_OPTION && text.contains("later version"), "{text}");
    let one = &raw mut later.options;
    unsafe {
        assert_eq!(arb_options_default(null_mut(), 80), ARB_NULL_POINTER);
        assert_eq!(arb_options_default(odd(one), 80), ARB_MISALIGNED_POINTER);
        assert_eq!(arb_options_default(one, 79), ARB_INVALID_OPTION);
        assert_eq!(arb_options_default(one, 4097), ARB_INVALID_OPTION);
    }
}

/// Calls `arb_build` with memory at an offset; returns the error.
fn build_in(memory: (*mut c_void, usize), scratch: (*mut c_void, usize), kind: u32) -> arb_error {
    let given = Given::groups();
    let mut error = empty_error();
    let mut index = arb_index { opaque: [7; ARB_INDEX_WORDS] };
    let (memory, bytes) = memory;
    let (scratch, scratch_bytes) = scratch;
    let mesh = given.indexed();
    let status = unsafe {
        let options = null();
        arb_build(
            &mut index,
            kind,
            &mesh,
            options,
            memory,
            bytes,
            scratch,
            scratch_bytes,
            &mut error,
        )
    };
    assert_eq!(status, error.status);
    assert!(status == ARB_OK || status == ARB_OVERLAP || index.opaque == [0; ARB_INDEX_WORDS]);
    error
}

#[test]
fn memory_of_a_build() {
    let (mut memory, mut scratch) = (vec![Block::ZERO; 2000], vec![Block::ZERO; 2000]);
    let bytes = 64 * 2000;
    let (room, work): (*mut c_void, *mut c_void) =
        (memory.as_mut_ptr().cast(), scratch.as_mut_ptr().cast());
    assert_eq!(build_in((room, bytes), (work, bytes), WIDE).status, ARB_OK);

    let full = build_in((null_mut(), 0), (work, bytes), WIDE);
    assert_eq!((full.status, full.given_bytes), (ARB_INDEX_MEMORY_TOO_SMALL, 0));
    let needed = full.needed_bytes;
    assert_eq!(build_in((room, needed), (work, bytes), WIDE).status, ARB_OK);
    let short = build_in((room, needed - 1), (work, bytes), WIDE);
    assert_eq!(short.status, ARB_INDEX_MEMORY_TOO_SMALL);
    assert_eq!((short.needed_bytes, short.given_bytes), (needed, needed - 1));
    assert_eq!(
        message(&short),
        format!("the index needs {needed} bytes, the arena has {}", needed - 1)
    );

    let full = build_in((room, bytes), (null_mut(), 0), WIDE);
    assert_eq!((full.status, full.given_bytes), (ARB_SCRATCH_TOO_SMALL, 0));
    assert_eq!(build_in((room, bytes), (work, full.needed_bytes), WIDE).status, ARB_OK);

    let misaligned = build_in((odd(room), bytes - 64), (work, bytes), WIDE);
    assert_eq!(misaligned.status, ARB_MISALIGNED_POINTER);
    let misaligned = build_in((room, bytes), (odd(work), bytes - 64), WIDE);
    assert_eq!(misaligned.status, ARB_MISALIGNED_POINTER);
    assert_eq!(build_in((null_mut(), 64), (work, bytes), WIDE).status, ARB_NULL_POINTER);
    assert_eq!(build_in((room, bytes), (null_mut(), 64), WIDE).status, ARB_NULL_POINTER);
    let endless = build_in((room, usize::MAX), (work, bytes), WIDE);
    assert_eq!(endless.status, ARB_LENGTH_OVERFLOW);
    let overlap = build_in((room, bytes), (room, bytes), WIDE);
    assert_eq!((overlap.status, &*message(&overlap)), (ARB_OVERLAP, "scratch overlaps memory"));
    let next = room.wrapping_byte_add(bytes - 64);
    assert_eq!(build_in((room, bytes), (next, 64), WIDE).status, ARB_OVERLAP);

    let unknown = build_in((room, bytes), (work, bytes), 19);
    assert_eq!(
        (unknown.status, &*message(&unknown)),
        (ARB_UNKNOWN_KIND, "no kind of index has the number 19")
    );
}
