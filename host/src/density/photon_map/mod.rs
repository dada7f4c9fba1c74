//! Photon map: where photons fell, in a balanced kd-tree, for estimates of irradiance.
//!
//! ```text
//! PhotonSource -> deposit (chunks in parallel) -> build (kd-tree in one array) -> search -> gather -> Estimate
//!                                                       \-> file
//! ```
//! A photon takes 20 bytes: position, triangle and side, and its rank by (photon, bounce). All photons carry the same
//! flux. In a coloured model a photon takes 4 bytes more, for its colour.
//!
//! # Layout
//! The tree is the order of the array. A run of more than [`LEAF`](build::LEAF) photons has its root in the middle; all
//! photons before it are on the lower side of the plane through the root, all behind it on the upper side:
//!
//! ```text
//! run    [ lower half ... | root | ... upper half ]        the root knows the axis of its plane
//! leaf   [ at most 12 photons, by rank ]
//! ```
//! The order depends on the photons only: not on the threads, nor on the order in which they came.
//!
//! # Source
//! H. W. Jensen, *Global Illumination using Photon Maps*, 1996; *Realistic Image Synthesis Using Photon Mapping*, 2001,
//! for the balanced tree in an array.

mod build;
mod deposit;
mod file;
mod gather;
mod search;
#[cfg(test)]
mod tests;
mod tint;

use arboleda::{Triangle, Vec3};
use bytemuck::{Pod, Zeroable};
use thiserror::Error;

pub use deposit::Deposits;
pub use gather::{Gather, MapEstimator};
pub use search::{Facing, Found, Neighbourhood};

use super::receiver::unit_normal;
use crate::photon::{Balance, Side};
use crate::scene::vector::Vector64;
use crate::scene::{Column, Model};

/// Most photons of a map: 2^31 - 1, which take 43 GB.
pub const MOST_PHOTONS: usize = (1 << 31) - 1;

/// Top bit of a word. In `surface` and in `rank` it is a bit of the split axis.
const TOP: u32 = 1 << 31;

/// Photon of the map. 20 bytes, little-endian in files.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct Photon {
    position: [f32; 3],
    /// Twice the triangle's id, plus 1 if the photon fell on its back. The top bit is the lower bit of the axis.
    surface: u32,
    /// Rank by (photon, bounce). The top bit is the upper bit of the axis.
    rank: u32,
}

impl Photon {
    fn new(position: Vec3, triangle: u32, side: Side) -> Self {
        // A scene has at most 2^30 triangles.
        let surface = triangle << 1 | u32::from(side == Side::Back);
        Self { position: position.to_array(), surface: surface & !TOP, rank: 0 }
    }

    #[inline]
    fn point(&self) -> Vector64 {
        Vec3::from_array(self.position).into()
    }

    fn triangle(&self) -> u32 {
        (self.surface & !TOP) >> 1
    }

    fn side(&self) -> Side {
        if self.surface & 1 == 0 { Side::Front } else { Side::Back }
    }

    fn rank(&self) -> u32 {
        self.rank & !TOP
    }

    /// Returns the axis of the plane through an inner node, 0 to 2.
    #[inline]
    fn axis(&self) -> usize {
        (self.surface >> 31 | self.rank >> 31 << 1) as usize % 3
    }

    fn set_axis(&mut self, axis: usize) {
        self.surface = self.surface & !TOP | (axis as u32 & 1) << 31;
        self.rank = self.rank & !TOP | (axis as u32 >> 1) << 31;
    }
}

/// Photons of a source, searchable by place.
///
/// # Examples
/// ```
/// use arboleda::{IndexKind, Options, OwnedIndex, Vec3};
/// use arboleda_host::density::{
///     Facing, Gather, Kernel, MapEstimator, PhotonMap, PhotonSource, Receiver,
/// };
/// use arboleda_host::scene::{AreaLight, Model};
///
/// let mut model = Model::named("a floor under a lamp");
/// let far = 8.0;
/// let corners = [Vec3::new(-far, -far, 0.0), Vec3::new(far, -far, 0.0), Vec3::new(0.0, far, 0.0)];
/// model.add_object("floor", [arboleda::Triangle::new(corners[0], corners[1], corners[2])], 0.5);
/// model.lights.push(AreaLight::facing_down(Vec3::Z, 1.0, 1.0, 100.0));
/// let built = OwnedIndex::build(IndexKind::WideBvh, &model.scene(), &Options::DEFAULT)?;
/// let index = built.index();
/// let source = PhotonSource::new(&model, index.as_ray_index(), 100_000, 1);
/// let map = PhotonMap::shoot(&source, &|_| {})?;
/// let estimator = MapEstimator {
///     gather: Gather::Nearest { k: 200, max_radius: 0.5 },
///     facing: Facing::within_degrees(10.0),
///     kernel: Kernel::Constant,
/// };
/// let middle = Receiver::new(Vec3::ZERO, Vec3::Z).ok_or("a valid normal")?;
/// let estimate = estimator.estimate(&map, &middle, None, &mut Vec::new());
/// assert!((estimate.mean() - 23.9).abs() < 4.0 * estimate.standard_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PhotonMap {
    photons: Vec<Photon>,
    /// Colours of the photons, in the order of the array; empty in a grey model.
    tints: Vec<u32>,
    normals: Normals,
    balance: Balance,
}

/// Error of making a photon map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum MapError {
    /// The photons hit triangles more often than a map can hold.
    #[error(
        "the photons hit triangles {hits} times or more; a photon map holds {MOST_PHOTONS} hits: fewer photons"
    )]
    TooManyHits {
        /// Number of hits so far.
        hits: usize,
    },
}

impl PhotonMap {
    /// Returns the number of photons in the map: hits of the bounces that count.
    pub fn len(&self) -> usize {
        self.photons.len()
    }

    /// Iterates over the positions of the photons, in the order of the array.
    pub fn positions(&self) -> impl Iterator<Item = Vec3> {
        self.photons.iter().map(|photon| Vec3::from_array(photon.position))
    }

    /// Tells whether the map has no photons.
    pub fn is_empty(&self) -> bool {
        self.photons.is_empty()
    }

    /// Returns the bytes of the photons.
    pub fn bytes(&self) -> usize {
        size_of_val(self.photons.as_slice()) + size_of_val(self.tints.as_slice())
    }

    /// Returns the ends of the photons, and their flux.
    pub fn balance(&self) -> &Balance {
        &self.balance
    }

    fn weights(&self, at: usize) -> [f32; 3] {
        self.tints.get(at).map_or([1.0; 3], |&tint| tint::decoded(tint))
    }
}

/// Unit normals of triangles; zero without area.
#[derive(Clone, Debug)]
enum Normals {
    /// Table with a normal for each triangle, by id.
    Table(Vec<Vector64>),
    /// Triangles, whose normals are computed when they are asked for. Those of a file that processes share may be far more
    /// than photons, and the table would take 24 bytes of each process for each.
    Computed(Column<Triangle>),
}

impl Normals {
    fn of(model: &Model) -> Self {
        if model.triangles.is_mapped() {
            return Self::Computed(model.triangles.clone());
        }
        Self::Table(model.triangles.iter().map(Self::compute).collect())
    }

    fn compute(triangle: &Triangle) -> Vector64 {
        unit_normal(triangle).unwrap_or(Vector64::ZERO)
    }

    /// Returns the normal of a triangle; `None` if there is no such triangle.
    #[inline]
    fn get(&self, triangle: u32) -> Option<Vector64> {
        match self {
            Self::Table(normals) => normals.get(triangle as usize).copied(),
            Self::Computed(triangles) => triangles.get(triangle as usize).map(Self::compute),
        }
    }
}
