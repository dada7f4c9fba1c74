//! Size of the compact BVH: at most 34 bytes a triangle, corners and ids included.

use arboleda::{IndexKind, Options};
use arboleda_host::TimedIndex;
use arboleda_host::scene::builtin;

#[test]
fn at_most_34_bytes_a_triangle() {
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
