//! Transforms of nodes, computed in `f64`.

use gltf::scene::Transform;

/// Matrix of four columns, the last of which is the translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Matrix([[f64; 4]; 4]);

impl Matrix {
    pub const IDENTITY: Self = Self([
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);

    /// Computes the transform of a node: its matrix, or else its scale, then rotation, then translation.
    pub fn of(transform: &Transform) -> Self {
        let (translation, rotation, scale) = match transform {
            Transform::Matrix { matrix } => {
                return Self(matrix.map(|column| column.map(f64::from)));
            }
            Transform::Decomposed { translation, rotation, scale } => {
                (translation.map(f64::from), rotation.map(f64::from), scale.map(f64::from))
            }
        };
        // Quaternions of any length are accepted, because few have exactly length 1 in 32 bits. Length 0 is no
        // rotation.
        let [x, y, z, w] = rotation;
        let square = x * x + y * y + z * z + w * w;
        let s = if square > 0.0 { 2.0 / square } else { 0.0 };
        let columns = [
            [1.0 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)],
            [s * (x * y - w * z), 1.0 - s * (x * x + z * z), s * (y * z + w * x)],
            [s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y)],
        ];
        let scaled = [0, 1, 2].map(|axis| {
            let [x, y, z] = columns[axis].map(|part| part * scale[axis]);
            [x, y, z, 0.0]
        });
        let [x, y, z] = translation;
        Self([scaled[0], scaled[1], scaled[2], [x, y, z, 1.0]])
    }

    /// Multiplies: the product applies `inner` first, then `self`.
    pub fn times(&self, inner: &Self) -> Self {
        Self(inner.0.map(|column| {
            [0, 1, 2, 3].map(|row| (0..4).map(|at| self.0[at][row] * column[at]).sum())
        }))
    }

    /// Transforms a point.
    pub fn apply(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [a, b, c, d] = self.0;
        [0, 1, 2].map(|row| a[row] * x + b[row] * y + c[row] * z + d[row])
    }
}
