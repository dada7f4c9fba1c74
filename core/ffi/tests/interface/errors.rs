//! Tests of what the interface refuses: each reason has its status, and nothing is written but the error.

use std::collections::BTreeSet;
use std::ffi::CStr;
use std::ptr::{dangling_mut, null, null_mut};

use crate::given::*;
use arboleda::Block;
use arboleda_ffi::arb_status::*;
use arboleda_ffi::*;

const WIDE: u32 = arb_kind::ARB_WIDE_BVH as u32;
const BVH: u32 = arb_kind::ARB_BVH as u32;

#[test]
fn arguments_that_overlap_are_not_written_to() {
    let given = Given::groups();
    let built = build(WIDE, &given.indexed(), &default_options()).expect("an index");
    let mut rays = given.rays(64);
    let before = rays.clone();
    let first = rays.as_mut_ptr();
    let bytes = built.memory.as_ptr().cast_mut();
    let copy: Vec<u8> = bytemuck::cast_slice(&built.memory).to_vec();
    let mut hits = [NO_HIT; 64];
    let to = hits.as_mut_ptr();
    let index = &raw const built.index;
    let (mut count, mut truncated) = (0, false);
    unsafe {
        let over_rays = arb_closest_each(index, first, 64, first.cast(), null_mut(), 0, null_mut());
        let over_index =
            arb_closest_each(index, first, 64, bytes.cast(), null_mut(), 0, null_mut());
        let scratch_over_rays = arb_closest_each(index, first, 64, to, first.cast(), 9, null_mut());
        let scratch_over_hits =
            arb_occluded_each(index, first, 64, to.cast(), to.cast(), 9, null_mut());
        let all = arb_all_hits(index, first, bytes.cast(), 9, &mut count, &mut truncated);
        let handle = index.cast_mut().cast();
        let over_handle = arb_closest_each(index, first, 8, handle, null_mut(), 0, null_mut());
        let statuses =
            [over_rays, over_index, scratch_over_rays, scratch_over_hits, all, over_handle];
        assert_eq!(statuses, [ARB_OVERLAP; 6]);
    }
    let beside = arb_options { beside: 1, ..default_options() };
    let lean = build(arb_kind::ARB_LEAN_BVH as u32, &given.indexed(), &beside).expect("an index");
    let mesh =
        [given.vertices.as_ptr().cast_mut().cast(), given.corners.as_ptr().cast_mut().cast()];
    for array in mesh {
        let status =
            unsafe { arb_closest_each(&lean.index, first, 64, array, null_mut(), 0, null_mut()) };
        assert_eq!(status, ARB_OVERLAP);
    }
    assert_eq!(rays, before);
    assert_eq!(bytemuck::cast_slice::<Block, u8>(&built.memory), copy);
}

#[test]
fn a_handle_is_open_or_refused() {
    let given = Given::groups();
    let built = build(BVH, &given.indexed(), &default_options()).expect("an index");
    let rays = given.rays(1);
    let ray = rays.as_ptr();
    let (mut hit, mut occluded) = (NO_HIT, false);
    let mut counters = arb_counters { nodes_visited: 0, triangle_tests: 0 };
    let (mut count, mut more) = (0, false);
    let mut ask = |index: *const arb_index| unsafe {
        let mut description = std::mem::MaybeUninit::uninit();
        let error = null_mut();
        let (flag, many) = (&raw mut occluded, &raw mut hit);
        [
            arb_closest(index, ray, &mut hit),
            arb_occluded(index, ray, flag),
            arb_closest_counted(index, ray, many, &mut counters),
            arb_occluded_counted(index, ray, flag, &mut counters),
            arb_all_hits(index, ray, many, 1, &mut count, &mut more),
            arb_closest_each(index, ray, 1, many, null_mut(), 0, error),
            arb_occluded_each(index, ray, 1, flag, null_mut(), 0, error),
            arb_describe(index, description.as_mut_ptr()),
        ]
    };
    assert_eq!(ask(&built.index), [ARB_OK; 8]);
    assert_eq!(ask(null()), [ARB_NULL_POINTER; 8]);
    assert_eq!(ask(odd((&raw const built.index).cast_mut())), [ARB_MISALIGNED_POINTER; 8]);
    let mut other = built.index;
    other.opaque[0] ^= 1;
    for opaque in [[0; ARB_INDEX_WORDS], [u64::MAX; ARB_INDEX_WORDS], other.opaque] {
        assert_eq!(ask(&arb_index { opaque }), [ARB_NOT_OPEN; 8]);
    }
    let mut closed = built.index;
    assert_eq!(unsafe { arb_close(&mut closed) }, ARB_OK);
    assert_eq!(unsafe { arb_close(&mut closed) }, ARB_OK);
    assert_eq!(ask(&closed), [ARB_NOT_OPEN; 8]);
    assert_eq!(unsafe { arb_close(null_mut()) }, ARB_NULL_POINTER);
    assert_eq!(unsafe { arb_close(odd(&mut closed)) }, ARB_MISALIGNED_POINTER);
}

#[test]
fn pointers_of_queries() {
    let given = Given::groups();
    let built = build(BVH, &given.indexed(), &default_options()).expect("an index");
    let rays = given.rays(2);
    let (index, ray) = (&raw const built.index, rays.as_ptr());
    let (mut hit, mut flag, mut count) = (NO_HIT, false, 0);
    let mut counters = arb_counters { nodes_visited: 0, triangle_tests: 0 };
    let (to, many, truth) = (&raw mut hit, &raw mut count, &raw mut flag);
    let work = &raw mut counters;
    let odd_ray = odd(ray.cast_mut()).cast_const();
    unsafe {
        let nothing = null_mut();
        assert_eq!(arb_check_ray(null()), ARB_NULL_POINTER);
        assert_eq!(arb_check_ray(odd_ray), ARB_MISALIGNED_POINTER);
        assert_eq!(arb_closest(index, null(), to), ARB_NULL_POINTER);
        assert_eq!(arb_closest(index, odd_ray, to), ARB_MISALIGNED_POINTER);
        assert_eq!(arb_closest(index, ray, null_mut()), ARB_NULL_POINTER);
        assert_eq!(arb_closest(index, ray, odd(to)), ARB_MISALIGNED_POINTER);
        assert_eq!(arb_occluded(index, null(), truth), ARB_NULL_POINTER);
        assert_eq!(arb_occluded(index, ray, null_mut()), ARB_NULL_POINTER);
        assert_eq!(arb_closest_counted(index, ray, to, null_mut()), ARB_NULL_POINTER);
        assert_eq!(arb_closest_counted(index, ray, null_mut(), work), ARB_NULL_POINTER);
        assert_eq!(arb_occluded_counted(index, ray, truth, odd(work)), ARB_MISALIGNED_POINTER);
        assert_eq!(arb_all_hits(index, ray, null_mut(), 1, many, truth), ARB_NULL_POINTER);
        assert_eq!(arb_all_hits(index, ray, to, 1, null_mut(), truth), ARB_NULL_POINTER);
        assert_eq!(arb_all_hits(index, ray, to, 1, many, null_mut()), ARB_NULL_POINTER);
        assert_eq!(arb_all_hits(index, ray, to, usize::MAX, many, truth), ARB_LENGTH_OVERFLOW);
        assert_eq!(arb_all_hits(index, ray, null_mut(), 0, many, truth), ARB_OK);
        let mut error = empty_error();
        let each = arb_closest_each(index, null(), 2, to, nothing, 0, &mut error);
        assert_eq!((each, &*message(&error)), (ARB_NULL_POINTER, "rays is NULL"));
        let each = arb_closest_each(index, ray, 2, null_mut(), nothing, 0, &mut error);
        assert_eq!((each, &*message(&error)), (ARB_NULL_POINTER, "hits is NULL"));
        let each = arb_closest_each(index, ray, usize::MAX / 16, to, nothing, 0, null_mut());
        assert_eq!(each, ARB_LENGTH_OVERFLOW);
        let each = arb_closest_each(index, ray, 2, to, dangling_mut(), usize::MAX, null_mut());
        assert_eq!(each, ARB_LENGTH_OVERFLOW);
        let each = arb_occluded_each(index, ray, 2, null_mut(), nothing, 0, odd(&mut error));
        assert_eq!(each, ARB_MISALIGNED_POINTER);
        assert_eq!(arb_describe(index, null_mut()), ARB_NULL_POINTER);
        assert_eq!(arb_scratch_bytes(0, 1, null(), null_mut(), null_mut()), ARB_NULL_POINTER);
    }
    // The last query of all hits found some, and had no room.
    assert_eq!((hit, flag, count), (NO_HIT, true, 0));
}

#[test]
fn rays_that_are_none() {
    let given = Given::groups();
    let built = build(WIDE, &given.indexed(), &default_options()).expect("an index");
    let good = given.rays(1)[0];
    let wrong = [
        (ARB_RAY_ORIGIN_NOT_FINITE, arb_ray { origin: [0.0, f32::NAN, 0.0], ..good }),
        (ARB_RAY_DIRECTION_NOT_FINITE, arb_ray { direction: [f32::INFINITY, 0.0, 0.0], ..good }),
        (ARB_RAY_DIRECTION_ZERO, arb_ray { direction: [0.0, -0.0, 0.0], ..good }),
        (ARB_RAY_INTERVAL_NAN, arb_ray { t_max: f32::NAN, ..good }),
        (ARB_RAY_INTERVAL_EMPTY, arb_ray { t_min: 2.0, t_max: 1.0, ..good }),
    ];
    for (status, ray) in wrong {
        let mut rays = given.rays(3000);
        rays[2500] = ray;
        let mut hits = vec![NO_HIT; rays.len()];
        let (mut hit, mut error) = (NO_HIT, empty_error());
        unsafe {
            assert_eq!(arb_check_ray(&ray), status);
            assert_eq!(arb_closest(&built.index, &ray, &mut hit), status);
            let (first, to) = (rays.as_ptr(), hits.as_mut_ptr());
            let each = arb_closest_each(&built.index, first, 3000, to, null_mut(), 0, &mut error);
            assert_eq!((each, error.status, error.element), (status, status, 2500));
            assert!(message(&error).starts_with("ray 2500: "));
        }
        assert!(hit == NO_HIT && hits.iter().all(|hit| *hit == NO_HIT));
    }
}

#[test]
fn bytes_that_are_no_index() {
    let given = Given::groups();
    let mesh = given.indexed();
    let built = build(BVH, &mesh, &default_options()).expect("an index");
    let beside = arb_options { beside: 1, ..default_options() };
    let lean = build(arb_kind::ARB_LEAN_BVH as u32, &mesh, &beside).expect("an index");
    let open = |bytes: *const Block, count: usize, mesh: *const arb_mesh| {
        let (mut index, mut error) = (arb_index { opaque: [7; ARB_INDEX_WORDS] }, empty_error());
        let status = unsafe { arb_open(&mut index, bytes.cast(), count, mesh, &mut error) };
        assert!(status == ARB_OK || index.opaque == [0; ARB_INDEX_WORDS]);
        assert_eq!(status, error.status);
        (status, error.element)
    };
    let forged = |at: usize, word: u32| {
        let mut memory = built.memory.clone();
        bytemuck::cast_slice_mut::<Block, u32>(&mut memory)[at] = word;
        open(memory.as_ptr(), built.bytes, null())
    };
    let whole = built.memory.as_ptr();
    assert_eq!(open(whole, built.bytes, null()), (ARB_OK, 0));
    assert_eq!(open(whole, built.bytes + 1 - 1, null()).0, ARB_OK);
    assert_eq!(open(whole, built.bytes - 1, null()).0, ARB_TRUNCATED);
    assert_eq!(open(null(), 0, null()).0, ARB_TRUNCATED);
    assert_eq!(open(null(), 64, null()).0, ARB_NULL_POINTER);
    assert_eq!(open(odd(whole.cast_mut()), built.bytes - 64, null()).0, ARB_MISALIGNED_POINTER);
    assert_eq!(open(whole, usize::MAX, null()).0, ARB_LENGTH_OVERFLOW);
    assert_eq!(forged(0, 1).0, ARB_NOT_AN_INDEX);
    assert_eq!(forged(2, 9), (ARB_OTHER_FORMAT, 9));
    assert_eq!(forged(3, 99).0, ARB_UNKNOWN_KIND);
    assert_eq!(forged(9, 1).0, ARB_MALFORMED);
    assert_eq!(forged(16, f32::NAN.to_bits()), (ARB_MALFORMED, 0));
    let mut swapped = built.memory.clone();
    for word in &mut bytemuck::cast_slice_mut::<Block, u32>(&mut swapped)[..16] {
        *word = word.swap_bytes();
    }
    assert_eq!(open(swapped.as_ptr(), built.bytes, null()).0, ARB_OTHER_BYTE_ORDER);

    assert_eq!(open(whole, built.bytes, &mesh).0, ARB_MESH_NOT_WANTED);
    let (first, bytes) = (lean.memory.as_ptr(), lean.bytes);
    assert_eq!(open(first, bytes, &mesh).0, ARB_OK);
    assert_eq!(open(first, bytes, null()).0, ARB_MESH_MISSING);
    assert_eq!(open(first, bytes, &arb_mesh { triangle_count: 455, ..mesh }).0, ARB_OTHER_MESH);
    let mut moved = given.vertices.clone();
    moved[3][0] += 1.0;
    let other = arb_mesh { vertices: moved.as_ptr().cast(), ..mesh };
    assert_eq!(open(first, bytes, &other).0, ARB_OTHER_MESH);
    let wide = build(WIDE, &mesh, &beside);
    assert!(wide.is_err_and(|error| error.status == ARB_HOLDS_TRIANGLES));
}

#[test]
fn versions() {
    assert_eq!(arb_abi_version(), ARB_ABI_VERSION);
    assert_eq!(arb_check_abi(ARB_ABI_VERSION), ARB_OK);
    // An older header of the same major version.
    assert_eq!(arb_check_abi(ARB_ABI_VERSION & 0xffff_0000), ARB_OK);
    let major = 1 << 16;
    for other in [0, ARB_ABI_VERSION + 1, ARB_ABI_VERSION + major, ARB_ABI_VERSION - major] {
        assert_eq!(arb_check_abi(other), ARB_OTHER_ABI);
    }
}

#[test]
fn every_number_of_the_header_has_a_text_of_its_own() {
    let text = |status: i32| unsafe { CStr::from_ptr(arb_status_text(status)) }.to_str().unwrap();
    let kind = |kind: u32| unsafe { CStr::from_ptr(arb_kind_name(kind)) }.to_str().unwrap();
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/include/arboleda.h");
    let header = std::fs::read_to_string(path).expect("the header");
    let (mut texts, mut kinds, mut in_kinds) = (BTreeSet::new(), BTreeSet::new(), false);
    for line in header.lines() {
        in_kinds = (in_kinds || line == "enum arb_kind") && line != "enum arb_status";
        let Some((name, number)) = line.trim_end_matches(',').split_once(" = ") else { continue };
        if !name.trim_start().starts_with("ARB_") {
            continue;
        }
        let number: u32 = number.parse().expect(line);
        let is_new =
            if in_kinds { kinds.insert(kind(number)) } else { texts.insert(text(number as i32)) };
        assert!(is_new, "{line}");
    }
    assert_eq!((texts.len(), kinds.len()), (36, 19));
    assert!(!texts.contains("unknown status") && !kinds.contains("unknown"));
    assert_eq!((text(-1), text(1000), kind(19)), ("unknown status", "unknown status", "unknown"));
}
