//! Triangles as applications keep them, by the vertices that they share.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use arboleda::{Triangle, Vec3};

/// Corners, each once, and three of them for each triangle.
pub struct WeldedMesh {
    pub(super) corners: Vec<[f32; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl WeldedMesh {
    /// Gives corners with the same bits one place.
    pub fn of(triangles: &[Triangle]) -> Self {
        let mut places: HashMap<[u32; 3], u32> = HashMap::new();
        let mut corners = Vec::new();
        let mut place = |corner: Vec3| match places.entry(corner.to_array().map(f32::to_bits)) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(new) => {
                corners.push(corner.to_array());
                *new.insert(corners.len() as u32 - 1)
            }
        };
        let triangles = triangles.iter().map(|t| [place(t.a), place(t.b), place(t.c)]).collect();
        Self { corners, triangles }
    }

    /// Returns it as the mesh that an index of ours lies beside.
    pub fn kept(&self) -> arboleda::Mesh<'_> {
        let vertices = bytemuck::cast_slice(&self.corners);
        arboleda::Mesh::Indexed { vertices, corners: &self.triangles }
    }
}
