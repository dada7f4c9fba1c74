//! Tests of builds in pieces of memory.

use std::ffi::c_void;
use std::ptr::{dangling_mut, null, null_mut};

use crate::given::*;
use arboleda::{Block, IndexKind};
use arboleda_ffi::arb_status::*;
use arboleda_ffi::*;

const BVH: u32 = arb_kind::ARB_BVH_HIERARCHY as u32;
const NO_PIECE: arb_piece =
    arb_piece { bytes: null(), byte_count: 77, offset: 77, index_bytes: 77 };

/// Build in pieces that was begun, and its memory.
struct Begun {
    build: *mut arb_piecewise_build,
    scratch: Vec<Block>,
    memory_bytes: usize,
}

fn begin(kind: u32, mesh: &arb_mesh, options: *const arb_options) -> Result<Begun, Box<arb_error>> {
    let (mut build, mut memory_bytes, mut error) = (dangling_mut(), 77, empty_error());
    let bytes = arb_piecewise_scratch_bytes(mesh.triangle_count);
    let mut scratch = vec![Block::ZERO; Block::count(bytes)];
    Block::bytes(&mut scratch).fill(0xa5);
    let first = scratch.as_mut_ptr().cast();
    let status = unsafe {
        let (to, needed) = (&raw mut build, &raw mut memory_bytes);
        arb_piecewise_begin(to, kind, mesh, options, first, bytes, needed, &mut error)
    };
    assert_eq!((status, build.is_null()), (error.status, status != ARB_OK));
    assert_eq!(memory_bytes == 77, status != ARB_OK);
    if status == ARB_OK { Ok(Begun { build, scratch, memory_bytes }) } else { Err(Box::new(error)) }
}

fn join(build: *mut arb_piecewise_build, memory: *mut c_void, bytes: usize) -> arb_error {
    let mut error = empty_error();
    let status = unsafe { arb_piecewise_join(build, memory, bytes, &mut error) };
    assert_eq!(status, error.status);
    error
}

fn next(
    build: *mut arb_piecewise_build,
    room: *mut c_void,
    room_bytes: usize,
) -> Result<arb_piece, Box<arb_error>> {
    let (mut piece, mut error) = (NO_PIECE, empty_error());
    let status = unsafe { arb_piecewise_next(build, room, room_bytes, &mut piece, &mut error) };
    assert_eq!(status, error.status);
    assert_eq!(piece.byte_count == 77, status != ARB_OK, "an error leaves the output alone");
    if status == ARB_OK { Ok(piece) } else { Err(Box::new(error)) }
}

/// Bytes of an index that is built in pieces, with as little room as its pieces allow, and the offsets of the pieces.
fn in_pieces(
    kind: u32,
    mesh: &arb_mesh,
    options: &arb_options,
    least: usize,
) -> (Vec<u8>, Vec<usize>) {
    let Begun { build, memory_bytes, scratch: _scratch } = begin(kind, mesh, options).unwrap();
    let mut memory = vec![Block::ZERO; Block::count(memory_bytes)];
    assert_eq!(join(build, memory.as_mut_ptr().cast(), memory_bytes).status, ARB_OK);
    let (mut storage, mut offsets, mut given) = (Vec::new(), Vec::new(), least);
    loop {
        let mut room = vec![Block::ZERO; Block::count(given)];
        match next(build, room.as_mut_ptr().cast(), given) {
            Ok(piece) if piece.byte_count == 0 => {
                assert_eq!((piece.bytes, piece.index_bytes), (null(), storage.len()));
                assert_eq!(next(build, null_mut(), 0).unwrap_err().status, ARB_NOT_BEGUN);
                return (storage, offsets);
            }
            Ok(piece) => {
                let end = piece.offset + piece.byte_count;
                assert!(piece.index_bytes >= end);
                storage.resize(storage.len().max(piece.index_bytes), 0);
                let bytes =
                    unsafe { std::slice::from_raw_parts(piece.bytes.cast(), piece.byte_count) };
                storage[piece.offset..end].copy_from_slice(bytes);
                offsets.push(piece.offset);
                given = least;
            }
            Err(error) => {
                assert_eq!((error.status, error.given_bytes), (ARB_INDEX_MEMORY_TOO_SMALL, given));
                assert!(error.needed_bytes > given);
                given = error.needed_bytes;
            }
        }
    }
}

#[test]
fn the_bytes_are_those_of_a_build_at_once() {
    let given = Given::groups();
    let triangles = given.triangles();
    let list = arb_mesh {
        triangles: triangles.as_ptr().cast(),
        triangle_count: triangles.len(),
        ..no_mesh()
    };
    let beside = arb_options { beside: 1, ..default_options() };
    let mut count = 0;
    for kind in IndexKind::ALL.iter().filter(|kind| kind.can_be_built_in_pieces()) {
        for mesh in [given.indexed(), list, no_mesh()] {
            for options in [default_options(), beside] {
                let at_once = build(*kind as u32, &mesh, &options).expect("a build at once");
                let expected = &bytemuck::cast_slice::<_, u8>(&at_once.memory)[..at_once.bytes];
                for least in [0, 64, 100_000] {
                    let (bytes, offsets) = in_pieces(*kind as u32, &mesh, &options, least);
                    assert!(bytes == expected, "{}, {least} bytes of room", kind.name());
                    assert_eq!(offsets.last(), Some(&0), "the header is last");
                    assert!(offsets[..offsets.len() - 1].iter().all(|&offset| offset >= 64));
                    count += 1;
                }
            }
        }
    }
    assert_eq!(count, 6 * 3 * 2 * 3);
}

#[test]
fn what_cannot_be_begun_says_why() {
    let given = Given::groups();
    let mesh = given.indexed();
    let status = |kind: u32, mesh: &arb_mesh, options: &arb_options| {
        begin(kind, mesh, options).err().map(|error| error.status)
    };
    let options = default_options();
    for kind in IndexKind::ALL.iter().filter(|kind| !kind.can_be_built_in_pieces()) {
        assert_eq!(status(*kind as u32, &mesh, &options), Some(ARB_NOT_IN_PIECES));
    }
    assert_eq!(status(19, &mesh, &options), Some(ARB_UNKNOWN_KIND));
    let wrong = arb_options { size_classes: 9, ..options };
    assert_eq!(status(BVH, &mesh, &wrong), Some(ARB_INVALID_OPTION));
    let mut corners = given.corners.clone();
    corners[5][1] = 305;
    let broken = arb_mesh { corners: corners.as_ptr().cast(), ..mesh };
    assert_eq!(status(BVH, &broken, &options), Some(ARB_CORNER_OUT_OF_RANGE));

    let needed = arb_piecewise_scratch_bytes(456);
    let mut scratch = vec![Block::ZERO; Block::count(needed)];
    let (first, mut build, mut memory_bytes) = (scratch.as_mut_ptr(), dangling_mut(), 77);
    let (to, bytes) = (&raw mut build, &raw mut memory_bytes);
    let begin_in = |build, scratch: *mut Block, scratch_bytes, memory_bytes| {
        let mut error = empty_error();
        unsafe {
            let (options, scratch) = (null(), scratch.cast());
            let mesh = &raw const mesh;
            arb_piecewise_begin(
                build,
                BVH,
                mesh,
                options,
                scratch,
                scratch_bytes,
                memory_bytes,
                &mut error,
            );
        }
        (error.status, error.needed_bytes, error.given_bytes)
    };
    let short = (ARB_SCRATCH_TOO_SMALL, needed, needed - 1);
    assert_eq!(begin_in(to, first, needed - 1, bytes), short);
    assert_eq!(begin_in(to, null_mut(), 0, bytes), (ARB_SCRATCH_TOO_SMALL, needed, 0));
    assert_eq!(begin_in(to, null_mut(), needed, bytes).0, ARB_NULL_POINTER);
    assert_eq!(begin_in(null_mut(), first, needed, bytes).0, ARB_NULL_POINTER);
    assert_eq!(begin_in(to, first, needed, null_mut()).0, ARB_NULL_POINTER);
    assert_eq!(begin_in(to, odd(first), needed, bytes).0, ARB_MISALIGNED_POINTER);
    assert_eq!(begin_in(first.cast(), first, needed, bytes).0, ARB_OVERLAP);
    assert_eq!(begin_in(to, first, needed, first.cast()).0, ARB_OVERLAP);
    assert_eq!((build, memory_bytes), (null_mut(), 77));
}

#[test]
fn calls_have_an_order() {
    let given = Given::groups();
    let mesh = given.indexed();
    let mut begun = begin(BVH, &mesh, null()).unwrap();
    let (build, bytes) = (begun.build, begun.memory_bytes);
    let mut memory = vec![Block::ZERO; Block::count(bytes) + 100];
    let mut room = vec![Block::ZERO; 1000];
    let (first, free) = (memory.as_mut_ptr().cast::<c_void>(), room.as_mut_ptr().cast::<c_void>());
    let early = next(build, free, 64_000).unwrap_err();
    assert_eq!(
        (early.status, &*message(&early)),
        (ARB_NOT_BEGUN, "arb_piecewise_join has to be called first")
    );

    // The memory: errors, after which it is called again.
    let short = join(build, first, bytes - 1);
    assert_eq!(
        (short.status, short.needed_bytes, short.given_bytes),
        (ARB_SCRATCH_TOO_SMALL, bytes, bytes - 1)
    );
    assert_eq!(join(build, null_mut(), bytes).status, ARB_NULL_POINTER);
    assert_eq!(join(build, odd(first), bytes).status, ARB_MISALIGNED_POINTER);
    assert_eq!(join(build, build.cast(), bytes).status, ARB_OVERLAP);
    assert_eq!(join(build, given.corners.as_ptr().cast_mut().cast(), 64).status, ARB_OVERLAP);
    assert_eq!(join(null_mut(), first, bytes).status, ARB_NULL_POINTER);
    assert_eq!(join(free.cast(), first, bytes).status, ARB_NOT_BEGUN);
    let mut copy = begun.scratch.clone();
    assert_eq!(join(copy.as_mut_ptr().cast(), first, bytes).status, ARB_NOT_BEGUN);
    assert_eq!(join(build, first, bytes).status, ARB_OK);
    let again = join(build, first, bytes);
    assert_eq!(
        (again.status, &*message(&again)),
        (ARB_NOT_BEGUN, "the clusters are joined already")
    );

    // The room and the piece.
    let refused = |room, bytes| next(build, room, bytes).unwrap_err().status;
    assert_eq!(refused(first, bytes), ARB_OVERLAP);
    assert_eq!(refused(build.cast(), 64), ARB_OVERLAP);
    assert_eq!(refused(null_mut(), 64), ARB_NULL_POINTER);
    assert_eq!(refused(odd(free), 64), ARB_MISALIGNED_POINTER);
    assert_eq!(refused(free, usize::MAX), ARB_LENGTH_OVERFLOW);
    let full = next(build, free, 35).unwrap_err();
    assert_eq!(
        (full.status, full.needed_bytes, full.given_bytes),
        (ARB_INDEX_MEMORY_TOO_SMALL, 36, 35)
    );
    let into = |piece: *mut c_void| unsafe {
        arb_piecewise_next(build, free, 64_000, piece.cast(), null_mut())
    };
    assert_eq!(into(null_mut()), ARB_NULL_POINTER);
    assert_eq!(into(free), ARB_OVERLAP);
    assert_eq!(into(first), ARB_OVERLAP);
    assert_eq!(into(begun.scratch.last_mut().unwrap() as *mut Block as *mut c_void), ARB_OVERLAP);
    let piece = next(build, free, 64_000).unwrap();
    assert_eq!((piece.offset, piece.byte_count, piece.bytes), (64, 36 * 456, free.cast_const()));

    // A build of one type is none of the other.
    let (mut is_done, mut error) = (false, empty_error());
    let status = unsafe { arb_sliced_step(build.cast(), 1, &mut is_done, &mut error) };
    assert_eq!(status, ARB_NOT_BEGUN);
    let limited = arb_options { work_limit: 1, ..default_options() };
    let Begun { build, scratch: _scratch, .. } = begin(BVH, &mesh, &limited).unwrap();
    assert_eq!(join(build, first, bytes).status, ARB_OK);
    next(build, free, 64_000).expect("the triangles");
    assert_eq!(next(build, free, 64_000).unwrap_err().status, ARB_TOO_MUCH_WORK);
}
