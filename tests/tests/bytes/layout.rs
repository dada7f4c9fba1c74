//! Tests of layouts that other languages may rely on: the fields of triangles, hits and counters. The fields of rays
//! are private, so a test in the core checks them.

use core::mem::{align_of, offset_of, size_of};

use arboleda::{Aabb, Aligned, Block, Counters, Hit, Ray, Triangle, TriangleId, Vec3};

#[test]
fn fields_lie_where_the_documentation_says() {
    assert_eq!((size_of::<TriangleId>(), align_of::<TriangleId>()), (4, 4));
    assert_eq!((size_of::<Vec3>(), align_of::<Vec3>()), (12, 4));
    assert_eq!((offset_of!(Vec3, x), offset_of!(Vec3, y), offset_of!(Vec3, z)), (0, 4, 8));

    assert_eq!((size_of::<Hit>(), align_of::<Hit>()), (16, 4));
    assert_eq!((offset_of!(Hit, triangle), offset_of!(Hit, t)), (0, 4));
    assert_eq!((offset_of!(Hit, u), offset_of!(Hit, v)), (8, 12));

    assert_eq!((size_of::<Ray>(), align_of::<Ray>()), (32, 4));
    assert_eq!((size_of::<Triangle>(), align_of::<Triangle>()), (36, 4));
    let corners = [offset_of!(Triangle, a), offset_of!(Triangle, b), offset_of!(Triangle, c)];
    assert_eq!(corners, [0, 12, 24]);

    assert_eq!((size_of::<Aabb>(), align_of::<Aabb>()), (24, 4));
    assert_eq!((offset_of!(Aabb, lo), offset_of!(Aabb, hi)), (0, 12));

    assert_eq!(size_of::<Counters>(), 16);
    assert_eq!(offset_of!(Counters, nodes_visited), 0);
    assert_eq!(offset_of!(Counters, triangle_tests), 8);

    assert_eq!((size_of::<Block>(), align_of::<Block>()), (64, 64));
    assert_eq!(align_of::<Aligned<[u8; 3]>>(), 64);
}
