//! Tests of builds in slices of time.

use std::ffi::c_void;
use std::ptr::{null, null_mut};

use crate::given::*;
use arboleda::Block;
use arboleda_ffi::arb_status::*;
use arboleda_ffi::*;

const WIDE: u32 = arb_kind::ARB_WIDE_BVH as u32;

/// Memory and scratch of a build in slices.
struct Rooms {
    memory: Vec<Block>,
    scratch: Vec<Block>,
    memory_bytes: usize,
    scratch_bytes: usize,
}

impl Rooms {
    /// Room for an index of `memory_bytes`, and exactly the scratch for `count` triangles.
    fn new(memory_bytes: usize, count: usize) -> Self {
        let scratch_bytes = arb_sliced_scratch_bytes(count);
        // What lies there is arbitrary.
        let block = |_| {
            let mut block = [Block::ZERO];
            Block::bytes(&mut block).fill(0xa5);
            block[0]
        };
        Self {
            memory: (0..Block::count(memory_bytes)).map(block).collect(),
            scratch: (0..Block::count(scratch_bytes)).map(block).collect(),
            memory_bytes,
            scratch_bytes,
        }
    }

    fn memory(&mut self) -> *mut c_void {
        self.memory.as_mut_ptr().cast()
    }

    fn scratch(&mut self) -> *mut c_void {
        self.scratch.as_mut_ptr().cast()
    }

    fn begin(
        &mut self,
        mesh: &arb_mesh,
        options: *const arb_options,
    ) -> (*mut arb_sliced_build, arb_error) {
        let (memory, scratch) = (self.memory(), self.scratch());
        self.begin_in(mesh, options, memory, scratch)
    }

    fn begin_in(
        &mut self,
        mesh: *const arb_mesh,
        options: *const arb_options,
        memory: *mut c_void,
        scratch: *mut c_void,
    ) -> (*mut arb_sliced_build, arb_error) {
        let mut build = std::ptr::dangling_mut();
        let mut error = empty_error();
        let (bytes, scratch_bytes) = (self.memory_bytes, self.scratch_bytes);
        let status = unsafe {
            arb_sliced_begin(
                &mut build,
                mesh,
                options,
                memory,
                bytes,
                scratch,
                scratch_bytes,
                &mut error,
            )
        };
        assert_eq!(status, error.status);
        assert_eq!(build.is_null(), status != ARB_OK);
        (build, error)
    }
}

/// Steps until the build is done or fails; returns the number of steps that were not the last.
fn step_all(build: *mut arb_sliced_build, looks: usize) -> Result<usize, Box<arb_error>> {
    let (mut error, mut is_done, mut count) = (empty_error(), false, 0);
    loop {
        match unsafe { arb_sliced_step(build, looks, &mut is_done, &mut error) } {
            ARB_OK if is_done => return Ok(count),
            ARB_OK => count += 1,
            _ => return Err(Box::new(error)),
        }
    }
}

fn finish(build: *mut arb_sliced_build) -> (arb_index, arb_error) {
    let mut index = arb_index { opaque: [7; ARB_INDEX_WORDS] };
    let mut error = empty_error();
    let status = unsafe { arb_sliced_finish(build, &mut index, &mut error) };
    assert_eq!(status, error.status);
    (index, error)
}

/// The steps of a build at once.
fn steps_of(mesh: &arb_mesh) -> u64 {
    let mut scratch = vec![Block::ZERO; 4000];
    let mut capacity = arb_capacity { index_bytes: 0, scratch_bytes: 0, steps: 0 };
    let (first, bytes, no_error) = (scratch.as_mut_ptr().cast(), 64 * 4000, null_mut());
    let status = unsafe { arb_measure(WIDE, mesh, null(), first, bytes, &mut capacity, no_error) };
    assert_eq!(status, ARB_OK);
    capacity.steps
}

#[test]
fn the_bytes_are_those_of_a_build_at_once_for_any_slices() {
    let given = Given::groups();
    let (triangles, rays) = (given.triangles(), given.rays(200));
    let list = arb_mesh {
        triangles: triangles.as_ptr().cast(),
        triangle_count: triangles.len(),
        ..no_mesh()
    };
    for mesh in [given.indexed(), list, no_mesh()] {
        let at_once = build(WIDE, &mesh, &default_options()).expect("a build at once");
        let expected = &bytemuck::cast_slice::<_, u8>(&at_once.memory)[..at_once.bytes];
        let mut paused = Vec::new();
        for looks in [0, 1, 7, 100, 5000, usize::MAX] {
            let mut rooms = Rooms::new(at_once.bytes, mesh.triangle_count);
            let (build, _) = rooms.begin(&mesh, null());
            paused.push(step_all(build, looks).expect("a build in slices"));
            let (index, error) = finish(build);
            assert_eq!((error.status, message(&error)), (ARB_OK, String::new()));
            assert!(
                &bytemuck::cast_slice::<_, u8>(&rooms.memory)[..at_once.bytes] == expected,
                "{looks}"
            );
            let hits = closest_each(&index, &rays, &mut []);
            assert_eq!(hits, closest_each(&at_once.index, &rays, &mut []));
        }
        assert_eq!(paused.last(), Some(&0));
        assert!(
            mesh.triangle_count == 0 || (paused[0] == paused[1] && paused[1] > 500),
            "{paused:?}"
        );
        assert!(paused.is_sorted_by(|a, b| a >= b), "{paused:?}");
        // Nothing but the end.
        let mut rooms = Rooms::new(at_once.bytes, mesh.triangle_count);
        let (build, _) = rooms.begin(&mesh, &default_options());
        assert_eq!(finish(build).1.status, ARB_OK);
        assert!(&bytemuck::cast_slice::<_, u8>(&rooms.memory)[..at_once.bytes] == expected);
    }
}

/// The bytes that the header states.
#[test]
fn scratch_is_as_large_as_is_said() {
    let build = arb_sliced_scratch_bytes(0);
    assert!((12_000..14_000).contains(&build), "{build}");
    assert_eq!(arb_sliced_scratch_bytes(1_000_000) - build, 48_000_000);
}

#[test]
fn what_cannot_be_begun_says_why() {
    let given = Given::groups();
    let mesh = given.indexed();
    let mut rooms = Rooms::new(40_000, 456);
    let (memory, scratch) = (rooms.memory(), rooms.scratch());
    let status = |(_, error): (_, arb_error)| error.status;
    assert_eq!(status(rooms.begin_in(null(), null(), memory, scratch)), ARB_NULL_POINTER);
    assert_eq!(status(rooms.begin_in(&mesh, null(), null_mut(), scratch)), ARB_NULL_POINTER);
    assert_eq!(status(rooms.begin_in(&mesh, null(), memory, null_mut())), ARB_NULL_POINTER);
    assert_eq!(status(rooms.begin_in(&mesh, null(), odd(memory), scratch)), ARB_MISALIGNED_POINTER);
    let off = scratch.wrapping_byte_add(8);
    assert_eq!(status(rooms.begin_in(&mesh, null(), memory, off)), ARB_MISALIGNED_POINTER);
    let beside = arb_options { beside: 1, ..default_options() };
    assert_eq!(status(rooms.begin(&mesh, &beside)), ARB_HOLDS_TRIANGLES);
    let wrong = arb_options { leaf_capacity: 0, ..default_options() };
    assert_eq!(status(rooms.begin(&mesh, &wrong)), ARB_INVALID_OPTION);
    let triangles = given.triangles();
    let both = arb_mesh { triangles: triangles.as_ptr().cast(), ..mesh };
    assert_eq!(status(rooms.begin(&both, null())), ARB_TWO_MESHES);

    let needed = arb_sliced_scratch_bytes(456);
    rooms.scratch_bytes = needed - 1;
    let (_, full) = rooms.begin(&mesh, null());
    assert_eq!((full.status, full.needed_bytes), (ARB_SCRATCH_TOO_SMALL, needed));
    assert_eq!(full.given_bytes, needed - 1);
    rooms.scratch_bytes = 0;
    assert_eq!(status(rooms.begin_in(&mesh, null(), memory, null_mut())), ARB_SCRATCH_TOO_SMALL);
    rooms.scratch_bytes = needed;

    let mut build = std::ptr::dangling_mut();
    let begin = |build: *mut *mut arb_sliced_build, memory, scratch| unsafe {
        let (bytes, error) = (rooms.memory_bytes, null_mut());
        arb_sliced_begin(build, &mesh, null(), memory, bytes, scratch, needed, error)
    };
    assert_eq!(begin(null_mut(), memory, scratch), ARB_NULL_POINTER);
    assert_eq!(begin(odd(&raw mut build), memory, scratch), ARB_MISALIGNED_POINTER);
    assert_eq!(begin(&mut build, memory, memory), ARB_OVERLAP);
    assert_eq!(begin(scratch.cast(), memory, scratch), ARB_OVERLAP);
    assert_eq!(begin(&mut build, given.corners.as_ptr().cast_mut().cast(), scratch), ARB_OVERLAP);
    assert_eq!(build, std::ptr::dangling_mut());
}

#[test]
fn errors_of_the_triangles_come_with_the_steps_and_stay() {
    let given = Given::groups();
    let mut vertices = given.vertices.clone();
    vertices[given.corners[9][2] as usize][1] = f32::INFINITY;
    let first = given.corners.iter().position(|c| c.contains(&given.corners[9][2])).unwrap();
    let mesh = arb_mesh { vertices: vertices.as_ptr().cast(), ..given.indexed() };
    let mut rooms = Rooms::new(40_000, 456);
    let (build, _) = rooms.begin(&mesh, null());
    for looks in [3, 1000, 1] {
        let error = step_all(build, looks).expect_err("an infinite vertex");
        assert_eq!((error.status, error.element), (ARB_NON_FINITE_VERTEX, first));
    }
    let (index, error) = finish(build);
    assert_eq!((error.status, error.element), (ARB_NON_FINITE_VERTEX, first));
    assert_eq!(index.opaque, CLOSED.opaque);
    assert_eq!(finish(build).1.status, ARB_NOT_BEGUN);

    let mesh = given.indexed();
    let limited = |work_limit| arb_options { work_limit, ..default_options() };
    let steps = steps_of(&mesh);
    let (build, _) = rooms.begin(&mesh, &limited(steps - 1));
    assert_eq!(step_all(build, 50).expect_err("too much work").status, ARB_TOO_MUCH_WORK);
    let (build, _) = rooms.begin(&mesh, &limited(steps));
    assert_eq!(finish(build).1.status, ARB_OK);
    // Each triangle is looked at once or more, which is known before.
    assert_eq!(rooms.begin(&mesh, &limited(1)).1.status, ARB_TOO_MUCH_WORK);

    // Memory that is too small: the error says how much is enough.
    let mut rooms = Rooms::new(4096, 456);
    let (build, _) = rooms.begin(&mesh, null());
    let full = step_all(build, 1000).expect_err("too little memory");
    assert_eq!((full.status, full.given_bytes), (ARB_INDEX_MEMORY_TOO_SMALL, 4096));
    let mut rooms = Rooms::new(full.needed_bytes, 456);
    let (build, _) = rooms.begin(&mesh, null());
    assert_eq!(finish(build).1.status, ARB_OK);
    let mut rooms = Rooms::new(full.needed_bytes - 1, 456);
    let (build, _) = rooms.begin(&mesh, null());
    assert_eq!(finish(build).1.status, ARB_INDEX_MEMORY_TOO_SMALL);
}

#[test]
fn only_a_build_is_stepped() {
    let given = Given::groups();
    let mesh = given.indexed();
    let mut rooms = Rooms::new(40_000, 456);
    let mut is_done = true;
    let step = |build: *mut c_void, is_done: *mut bool| {
        let mut error = empty_error();
        let status = unsafe { arb_sliced_step(build.cast(), 9, is_done, &mut error) };
        assert_eq!(status, error.status);
        status
    };
    // No build: null, memory of something else, a build of another address, one that is over.
    assert_eq!(step(null_mut(), &mut is_done), ARB_NULL_POINTER);
    assert_eq!(step(rooms.scratch(), &mut is_done), ARB_NOT_BEGUN);
    assert_eq!(finish(null_mut()).1.status, ARB_NULL_POINTER);
    let (build, _) = rooms.begin(&mesh, null());
    assert_eq!(step(odd(build).cast(), &mut is_done), ARB_MISALIGNED_POINTER);
    assert_eq!(step(build.cast(), null_mut()), ARB_NULL_POINTER);
    let mut copy = rooms.scratch.clone();
    assert_eq!(step(copy.as_mut_ptr().cast(), &mut is_done), ARB_NOT_BEGUN);
    // Nothing is written into what the build borrows.
    let (memory, scratch) = (rooms.memory(), rooms.scratch());
    assert_eq!(step(build.cast(), memory.cast()), ARB_OVERLAP);
    assert_eq!(step(build.cast(), scratch.wrapping_byte_add(20_000).cast()), ARB_OVERLAP);
    let handle = memory.cast::<arb_index>();
    let mut error = empty_error();
    assert_eq!(unsafe { arb_sliced_finish(build, handle, &mut error) }, ARB_OVERLAP);
    assert_eq!(message(&error), "index overlaps memory");
    assert!(is_done, "an error leaves the output alone");

    // The build has gone on all the same.
    assert_eq!(step(build.cast(), &mut is_done), ARB_OK);
    assert!(!is_done);
    let (index, error) = finish(build);
    assert_eq!((error.status, index.opaque == CLOSED.opaque), (ARB_OK, false));
    assert_eq!(step(build.cast(), &mut is_done), ARB_NOT_BEGUN);
    let (index, error) = finish(build);
    assert_eq!((error.status, index.opaque == CLOSED.opaque), (ARB_NOT_BEGUN, true));
    assert_eq!(message(&error), "the build was not begun, is over, or was moved");
}
