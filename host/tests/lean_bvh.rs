//! Size of the lean BVH: at most 12 bytes a triangle beside a mesh that the caller keeps.

use arboleda::{IndexKind, Options};
use arboleda_host::TimedIndex;
use arboleda_host::scene::builtin;

#[test]
fn at_most_12_bytes_a_triangle_beside_the_mesh() {
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
