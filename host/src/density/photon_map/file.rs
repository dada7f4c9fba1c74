//! Files of photon maps, which save shooting the photons again.
//!
//! ```text
//! "ARBOMAP1"                           8 bytes
//! digest of the model                 32 bytes    a map is of no use for another scene
//! photons, tints                      2 x u64     number of each; tints is 0 in a grey model
//! emitted absorbed escaped cut_off refused hits rays    7 x u64
//! total flux                          f64
//! photons                             20 bytes each: x y z f32, surface u32, rank u32
//! tints                               4 bytes each
//! ```
//! All numbers are little-endian. A forged file can give wrong estimates, but does no harm.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use thiserror::Error;

use super::{MOST_PHOTONS, Normals, Photon, PhotonMap};
use crate::files::FileError;
use crate::files::output::write_file;
use crate::photon::Balance;
use crate::scene::Model;

const SIGNATURE: &[u8; 8] = b"ARBOMAP1";
/// Bytes before the photons.
const HEADER: usize = 8 + 32 + 10 * 8;

#[derive(Debug, Error)]
enum MapProblem {
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    #[error("it is not a photon map; make one with --save-map")]
    NotAMap,
    #[error("its photons are those of another scene, or of other materials")]
    OtherScene,
    #[error("it has {found} bytes, but its header says {needed}")]
    Length { needed: u128, found: usize },
    #[error("photon {photon} names triangle {triangle}, but the scene has {count}")]
    Triangle { photon: usize, triangle: u32, count: usize },
    #[error("photon {photon} has a coordinate that is not finite")]
    NotFinite { photon: usize },
    #[error("its flux is {flux} W")]
    Flux { flux: f64 },
}

impl PhotonMap {
    /// Writes the map to a file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path, model: &Model) -> anyhow::Result<()> {
        write_file(path, |file| self.write(file, model))
    }

    /// Writes the bytes of the map's file.
    ///
    /// # Errors
    /// The errors of `file`.
    pub fn write(&self, file: &mut dyn Write, model: &Model) -> io::Result<()> {
        let balance = &self.balance;
        file.write_all(SIGNATURE)?;
        file.write_all(model.digest().as_bytes())?;
        for number in [
            self.photons.len() as u64,
            self.tints.len() as u64,
            balance.emitted,
            balance.absorbed,
            balance.escaped,
            balance.cut_off,
            balance.refused,
            balance.hits,
            balance.rays,
            balance.total_flux.to_bits(),
        ] {
            file.write_all(&number.to_le_bytes())?;
        }
        for photon in &self.photons {
            let [x, y, z] = photon.position.map(f32::to_bits);
            for word in [x, y, z, photon.surface, photon.rank] {
                file.write_all(&word.to_le_bytes())?;
            }
        }
        self.tints.iter().try_for_each(|tint| file.write_all(&tint.to_le_bytes()))
    }

    /// Reads a map of a model from a file that [`PhotonMap::save`] wrote.
    ///
    /// # Errors
    /// If the file cannot be read, is not a photon map, is cut off, or is that of another model.
    pub fn load(path: &Path, model: &Model) -> Result<Self, FileError> {
        let bytes = fs::read(path).map_err(MapProblem::Unreadable);
        Self::read(&bytes.map_err(|problem| FileError::new(path, problem))?, path, model)
    }

    /// Reads a map of a model from the bytes of a file called `name`.
    ///
    /// # Errors
    /// If the bytes are not a photon map, are cut off, or are the map of another model.
    pub fn read(bytes: &[u8], name: &Path, model: &Model) -> Result<Self, FileError> {
        decode(bytes, model).map_err(|problem| FileError::new(name, problem))
    }
}

fn decode(bytes: &[u8], model: &Model) -> Result<PhotonMap, MapProblem> {
    // 1. The header.
    let Some((header, rest)) = bytes.split_at_checked(HEADER) else {
        return Err(MapProblem::NotAMap);
    };
    let (signature, header) = header.split_at(SIGNATURE.len());
    let (digest, numbers) = header.split_at(32);
    if signature != SIGNATURE {
        return Err(MapProblem::NotAMap);
    }
    if digest != model.digest().as_bytes() {
        return Err(MapProblem::OtherScene);
    }
    let number = |at: usize| {
        let mut word = [0; 8];
        word.copy_from_slice(&numbers[8 * at..8 * at + 8]);
        u64::from_le_bytes(word)
    };
    let (photons, tints) = (number(0), number(1));
    let needed = u128::from(photons) * 20 + u128::from(tints) * 4;
    let sensible = photons <= MOST_PHOTONS as u64 && (tints == 0 || tints == photons);
    if needed != rest.len() as u128 || !sensible {
        let needed = needed + HEADER as u128;
        return Err(MapProblem::Length { needed, found: bytes.len() });
    }
    let flux = f64::from_bits(number(9));
    if !(flux >= 0.0 && flux.is_finite()) {
        return Err(MapProblem::Flux { flux });
    }
    let balance = Balance {
        emitted: number(2),
        absorbed: number(3),
        escaped: number(4),
        cut_off: number(5),
        refused: number(6),
        hits: number(7),
        rays: number(8),
        total_flux: flux,
    };

    // 2. Photons and tints.
    let (photon_bytes, tint_bytes) = rest.split_at(photons as usize * 20);
    let word = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let mut read = Vec::with_capacity(photons as usize);
    for (at, bytes) in photon_bytes.chunks_exact(20).enumerate() {
        let position = [0, 4, 8].map(|first| f32::from_bits(word(&bytes[first..])));
        let photon = Photon { position, surface: word(&bytes[12..]), rank: word(&bytes[16..]) };
        if !position.iter().all(|x| x.is_finite()) {
            return Err(MapProblem::NotFinite { photon: at });
        }
        let (triangle, count) = (photon.triangle(), model.triangles.len());
        if triangle as usize >= count {
            return Err(MapProblem::Triangle { photon: at, triangle, count });
        }
        read.push(photon);
    }
    let tints = tint_bytes.chunks_exact(4).map(word).collect();
    Ok(PhotonMap { photons: read, tints, normals: Normals::of(model), balance })
}
