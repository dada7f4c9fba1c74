//! Checks of surfaces, which every reader of scene files must pass for a file that it accepts.

use std::collections::HashSet;

use arboleda::{Triangle, Vec3};
use arboleda_host::scene::{Origin, SceneError, Surface};

/// Bits of a position, for comparison: with `==` on floats, -0.0 would equal 0.0.
type Bits = [u32; 3];

fn bits(position: Vec3) -> Bits {
    position.to_array().map(f32::to_bits)
}

/// Places a surface, with its own and with the automatic origin, and compares the triangles with the faces.
///
/// # Panics
/// If a face of `n` finite corners does not become `n - 2` triangles between its corners, in the order of the file; or
/// if a triangle lacks an object, or a reflectance from 0 to 1.
pub fn becomes_triangles(surface: &Surface) {
    assert!(surface.faces().next().is_some(), "a surface without faces is an error");
    for origin in [Origin::Unchanged, Origin::Automatic] {
        let model = match surface.clone().place(origin) {
            Ok(import) => import.model,
            Err(SceneError::NoFiniteFaces { faces, .. }) => {
                assert_eq!(faces, surface.faces().count());
                continue;
            }
            Err(error) => panic!("a surface is refused: {error}"),
        };
        assert!(model.origin.iter().all(|x| x.is_finite()), "{:?}", model.origin);
        assert!(model.triangles.iter().all(Triangle::is_finite));
        assert_eq!(model.objects.len(), model.triangles.len());
        assert!(model.objects.iter().all(|&at| (at as usize) < model.object_names.len()));
        assert_eq!(model.reflectance.len(), model.triangles.len());
        assert!(model.reflectance.iter().all(|share| (0.0..=1.0).contains(share)));

        let placed = |&corner: &u32| {
            let position = surface.vertices()[corner as usize];
            Vec3::from_array([0, 1, 2].map(|axis| (position[axis] - model.origin[axis]) as f32))
        };
        let mut rest = model.triangles.as_slice();
        for face in surface.faces() {
            let corners: Vec<Vec3> = face.iter().map(placed).collect();
            if corners.iter().all(|corner| corner.is_finite()) {
                let (triangles, after) = rest
                    .split_at_checked(corners.len() - 2)
                    .expect("n - 2 triangles for each finite face");
                rest = after;
                covers(&corners, triangles);
            }
        }
        assert!(rest.is_empty(), "{} triangles too many", rest.len());
    }
}

/// Checks that the triangles use each corner, and nothing else.
fn covers(corners: &[Vec3], triangles: &[Triangle]) {
    let used = triangles.iter().flat_map(|triangle| [triangle.a, triangle.b, triangle.c]);
    let used: HashSet<Bits> = used.map(bits).collect();
    let given: HashSet<Bits> = corners.iter().copied().map(bits).collect();
    assert_eq!(used, given, "corners {corners:?}, triangles {triangles:?}");
}
