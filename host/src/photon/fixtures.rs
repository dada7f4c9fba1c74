//! Fixtures of this folder's tests: small models with known answers, and indices over them.

use arboleda::{AnyIndex, Block, IndexKind, Options, Triangle, Vec3};

use crate::photon::{Segment, Visitor};
use crate::scene::{AreaLight, Model};

/// Index with its memory.
pub struct BuiltIndex {
    kind: IndexKind,
    arena: Vec<Block>,
    size: usize,
}

impl BuiltIndex {
    pub fn new(model: &Model, kind: IndexKind) -> Self {
        let (scene, options) = (model.scene(), Options::default());
        let scratch_size = kind.scratch_capacity(model.triangles.len(), &options);
        let mut scratch = vec![Block::ZERO; Block::count(scratch_size)];
        let scratch = Block::bytes(&mut scratch);
        let size = kind.capacity(&scene, &options, scratch).unwrap().index;
        let mut arena = vec![Block::ZERO; Block::count(size)];
        kind.build(&scene, &options, Block::bytes(&mut arena), scratch).unwrap();
        Self { kind, arena, size }
    }

    pub fn index(&mut self) -> AnyIndex<'_> {
        self.kind.from_bytes(&Block::bytes(&mut self.arena)[..self.size]).unwrap()
    }
}

/// Makes a model whose triangles have the same reflectance.
pub fn model(triangles: Vec<Triangle>, reflectance: f32, light: AreaLight) -> Model {
    Model {
        name: "fixture".into(),
        objects: vec![0; triangles.len()].into(),
        object_names: vec!["all".into()],
        reflectance: vec![reflectance; triangles.len()].into(),
        triangles: triangles.into(),
        lights: vec![light],
        ..Model::default()
    }
}

/// Makes a square light around `centre` that shines down.
pub fn lamp(centre: Vec3, size: f32, flux: f32) -> AreaLight {
    let corner = centre - Vec3::new(0.5, 0.5, 0.0) * size;
    AreaLight { corner, edge_u: Vec3::Y * size, edge_v: Vec3::X * size, flux }
}

/// Makes the parallelogram of `corner`, `edge_u` and `edge_v` in two triangles.
pub fn quad(corner: Vec3, edge_u: Vec3, edge_v: Vec3) -> [Triangle; 2] {
    let opposite = corner + edge_u + edge_v;
    [
        Triangle::new(corner, corner + edge_u, opposite),
        Triangle::new(corner, opposite, corner + edge_v),
    ]
}

/// Makes the closed box between two corners: 12 triangles.
pub fn closed_box(lo: Vec3, hi: Vec3) -> Vec<Triangle> {
    let size = hi - lo;
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * size);
    (0..3)
        .flat_map(|axis| {
            let (across, u, v) = (axes[axis], axes[(axis + 1) % 3], axes[(axis + 2) % 3]);
            [quad(lo, u, v), quad(lo + across, u, v)]
        })
        .flatten()
        .collect()
}

/// Makes a closed sphere: an octahedron whose faces are divided into four `level` times.
pub fn sphere(centre: Vec3, radius: f32, level: u32) -> Vec<Triangle> {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let mut faces: Vec<[Vec3; 3]> = (0..8)
        .map(|octant| {
            [0, 1, 2].map(|axis| if octant >> axis & 1 == 0 { axes[axis] } else { -axes[axis] })
        })
        .collect();
    for _ in 0..level {
        faces = faces
            .into_iter()
            .flat_map(|[a, b, c]| {
                // Addition is commutative in floats, so neighbours get the same midpoint.
                let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| (p + q).normalize());
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    faces
        .into_iter()
        .map(|face| {
            let [a, b, c] = face.map(|corner| centre + corner * radius);
            Triangle::new(a, b, c)
        })
        .collect()
}

/// Collects segments.
pub(crate) struct SegmentCollector;

impl Visitor for SegmentCollector {
    type State = Vec<Segment>;

    fn begin(&self) -> Vec<Segment> {
        Vec::new()
    }

    fn visit(&self, segments: &mut Vec<Segment>, segment: &Segment) {
        segments.push(*segment);
    }
}
