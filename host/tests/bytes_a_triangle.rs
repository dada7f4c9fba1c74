//! Sizes of the compact BVH, corners and ids included, and of the lean BVH beside a mesh that the caller keeps.

use arboleda::{IndexKind, Options};
use arboleda_host::TimedIndex;
use arboleda_host::scene::builtin;

#[test]
fn a_compact_bvh_has_at_most_34_bytes_a_triangle() {
    for name in ["fig3", "fig4b", "city", "mesh-20000", "city-50000"] {
        let model = builtin::require(name).expect("a built-in scene");
        for kind in [IndexKind::CompactBvh, IndexKind::CompactBvhHierarchy] {
            let owned = TimedIndex::build(kind, &model.scene(), &Options::default());
            let bytes = owned.expect("an ordinary scene").bytes();
            let triangles = model.scene().triangles().len();
            assert!(bytes <= 34 * triangles, "{name}: {bytes} bytes for {triangles} triangles");
        }
    }
}

#[test]
fn a_lean_bvh_has_at_most_12_bytes_a_triangle() {
    for name in ["fig2", "fig3", "fig4b", "fig4e", "city", "mixed", "sphere", "mesh"] {
        let model = builtin::require(name).expect("a built-in scene");
        let count = model.triangles.len();
        for kind in [IndexKind::LeanBvh, IndexKind::LeanBvhHierarchy] {
            let scene = model.scene().beside();
            let owned = TimedIndex::build(kind, &scene, &Options::default());
            let bytes = owned.expect("an ordinary scene").bytes();
            println!("{name}: {:.1} bytes a triangle", bytes as f64 / count as f64);
            assert!(bytes <= 12 * count, "{name}: {bytes} bytes for {count} triangles");
        }
    }
}
