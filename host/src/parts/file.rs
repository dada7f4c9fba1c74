//! Files of parts.
//!
//! ```text
//! "ARBOPART"              8 bytes
//! version                 u32, little-endian
//! BLAKE3 of what follows  32 bytes
//! header: job, photons, arguments, provenance    in the format of postcard, which is the same on every machine
//! sums                                          likewise
//! ```
//! A file that is torn or was changed is refused. A forged one can give wrong sums, but does no harm: of its arguments,
//! none that names an output is heeded.

use std::fs;
use std::io;
use std::ops::Range;
use std::path::Path;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{Job, JobPart, PartSums};
use crate::files::FileError;
use crate::files::output::write_file;

const SIGNATURE: &[u8; 8] = b"ARBOPART";
/// Version of the form, and of what is computed: it is raised with any change of the photons or the estimates, too, so
/// that parts of two versions of the program are not put together.
const VERSION: u32 = 3;
/// Bytes in front of the header.
const HEAD: usize = 8 + 4 + 32;

/// What a file of a part says about itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartFile {
    /// The job.
    pub job: Job,
    /// The photons.
    pub photons: Range<u64>,
    /// Arguments of the program that shot them, from which `merge` knows how to estimate; empty for a shot.
    pub arguments: Vec<String>,
    /// Where and by what the photons were shot, for people.
    pub provenance: String,
}

#[derive(Debug, Error)]
enum PartProblem {
    #[error("cannot be read: {0}")]
    Unreadable(io::Error),
    #[error("it is not a part; `shoot`, `irradiance` and `render` make parts with --part")]
    NotAPart,
    #[error("its version is {0}, but this program reads version {VERSION}")]
    Version(u32),
    #[error(
        "it is torn or was changed: its contents do not have the hash that it names; shoot its photons again"
    )]
    Torn,
    #[error("it contradicts itself")]
    Contradiction,
    #[error("it was changed meanwhile")]
    Changed,
}

impl PartFile {
    /// Writes a part, whole or not at all.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path, sums: &PartSums) -> anyhow::Result<()> {
        let body = postcard::to_extend(sums, postcard::to_stdvec(self)?)?;
        write_file(path, |file| {
            file.write_all(SIGNATURE)?;
            file.write_all(&VERSION.to_le_bytes())?;
            file.write_all(blake3::hash(&body).as_bytes())?;
            file.write_all(&body)
        })
    }

    /// Reads what the file of a part says about itself. All of the file is checked.
    ///
    /// # Errors
    /// If the file cannot be read, is not a part, is torn, or contradicts itself.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Ok(Self::read_all(path)?.0)
    }

    /// Reads the part of a file that said this about itself.
    ///
    /// # Errors
    /// The errors of [`read`](Self::read). If the file says something else by now.
    pub fn read_part(&self, path: &Path) -> Result<JobPart, FileError> {
        let (again, sums) = Self::read_all(path)?;
        if again != *self {
            return Err(FileError::new(path, PartProblem::Changed));
        }
        Ok(JobPart { photons: again.photons, sums })
    }

    fn read_all(path: &Path) -> Result<(Self, PartSums), FileError> {
        let bytes = fs::read(path).map_err(PartProblem::Unreadable);
        let read = bytes.and_then(|bytes| decode(&bytes));
        read.map_err(|problem| FileError::new(path, problem))
    }
}

fn decode(bytes: &[u8]) -> Result<(PartFile, PartSums), PartProblem> {
    // 1. The bytes.
    if !bytes.starts_with(SIGNATURE) {
        return Err(PartProblem::NotAPart);
    }
    let (head, body) = bytes.split_at_checked(HEAD).ok_or(PartProblem::Torn)?;
    let (version, hash) = head[SIGNATURE.len()..].split_at(4);
    let version = version.iter().rev().fold(0, |all, &byte| all << 8 | u32::from(byte));
    if version != VERSION {
        return Err(PartProblem::Version(version));
    }
    if blake3::hash(body).as_bytes() != hash {
        return Err(PartProblem::Torn);
    }
    // 2. What they say.
    let contradiction = |_| PartProblem::Contradiction;
    let (header, rest) = postcard::take_from_bytes::<PartFile>(body).map_err(contradiction)?;
    let (sums, rest) = postcard::take_from_bytes::<PartSums>(rest).map_err(contradiction)?;
    let PartFile { job, photons, .. } = &header;
    let is_within = photons.start <= photons.end && photons.end <= job.photons;
    if rest.is_empty() && is_within && job.is_countable() && sums.is_of(photons, job) {
        Ok((header, sums))
    } else {
        Err(PartProblem::Contradiction)
    }
}

#[cfg(test)]
mod tests {
    use arboleda::{IndexKind, Vec3};

    use super::*;
    use crate::density::{Harvest, LightPiece, LightSums};
    use crate::parts::JobKind;
    use crate::photon::fixtures::{BuiltIndex, closed_box, lamp, model};
    use crate::photon::{Balance, RangeSums, ShootOptions, shoot_range};
    use crate::scene::{AreaLight, Model};

    /// Counts near 2^64, which the paths of so many photons might have: with those of another part they would wrap.
    #[test]
    fn sums_that_would_wrap_are_refused() {
        let (header, _) = part();
        let photons = 0..1_u64 << 62;
        let job = Job {
            kind: JobKind::Irradiance,
            photons: 1 << 63,
            max_bounces: u32::MAX,
            ..header.job.clone()
        };
        let mut all = Harvest::default();
        all.balance.emitted = photons.end;
        all.balance.escaped = photons.end;
        all.balance.rays = u64::MAX;
        let piece = LightPiece { pass: 0, photons: photons.clone(), all, direct: None };
        let sums = PartSums::Light(LightSums::of(piece));
        let forged = |job: Job| {
            let header = PartFile { job, photons: photons.clone(), ..header.clone() };
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("forged.part");
            header.write(&path, &sums).unwrap();
            PartFile::read(&path)
        };
        let error = forged(job.clone()).unwrap_err().to_string();
        assert!(error.contains("forged.part: it contradicts itself"), "{error}");
        // Without a wrap, the same file is sound.
        let mut sound = sums.clone();
        if let PartSums::Light(light) = &mut sound {
            let mut piece = light.take(0).unwrap();
            piece.all.balance.rays = photons.end;
            *light = LightSums::of(piece);
        }
        assert!(sound.is_of(&photons, &Job { max_bounces: 0, ..job.clone() }));
        assert!(Job { max_bounces: 0, ..job.clone() }.is_countable() && !job.is_countable());
    }

    /// Whole numbers are in groups of seven bits, the lowest first; floats are little-endian: on any machine, whatever its
    /// byte order.
    #[test]
    fn bytes_are_those_of_the_layout() {
        fn number(mut value: u64) -> Vec<u8> {
            let mut bytes = Vec::new();
            while value > 127 {
                bytes.push(value as u8 & 127 | 128);
                value >>= 7;
            }
            bytes.push(value as u8);
            bytes
        }
        let text = |text: &str| [number(text.len() as u64), text.as_bytes().to_vec()].concat();
        let numbers =
            |all: &[u64]| all.iter().flat_map(|&value| number(value)).collect::<Vec<u8>>();

        let job = Job {
            program: "1.2".into(),
            kind: JobKind::Irradiance,
            model: [7; 32],
            triangles: 300,
            photons: 100_000,
            passes: 1,
            seed: u64::MAX,
            max_bounces: 64,
            options: vec![("--k".into(), "9".into())],
        };
        let mut all = Harvest::default();
        all.balance = Balance {
            emitted: 1_000,
            absorbed: 900,
            escaped: 100,
            hits: 2_000,
            rays: 2_100,
            total_flux: 0.15625,
            ..Balance::default()
        };
        let piece = LightPiece { pass: 0, photons: 500..1_500, all, direct: None };
        let header = PartFile {
            job,
            photons: 500..1_500,
            arguments: vec!["arboleda".into()],
            provenance: "a test".into(),
        };
        let body = [
            text("1.2"),
            numbers(&[1]), // irradiance
            vec![7; 32],
            numbers(&[300, 100_000, 1, u64::MAX, 64, 1]),
            text("--k"),
            text("9"),
            numbers(&[500, 1_500, 1]),
            text("arboleda"),
            text("a test"),
            // Light; one piece: pass, photons, balance, no sums, no deposits, no direct light.
            numbers(&[1, 1, 0, 500, 1_500, 1_000, 900, 100, 0, 0, 2_000, 2_100]),
            vec![0, 0, 0, 0, 0, 0, 0xc4, 0x3f], // 0.15625
            vec![0, 0, 0, 0, 0],
        ]
        .concat();
        let version = [3, 0, 0, 0];
        let digest = blake3::hash(&body);
        let expected = [&b"ARBOPART"[..], &version, digest.as_bytes(), &body].concat();

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.part");
        let sums = PartSums::Light(LightSums::of(piece));
        header.write(&path, &sums).unwrap();
        assert_eq!(fs::read(&path).unwrap(), expected);
        assert_eq!(decode(&expected).unwrap(), (header, sums));
    }

    /// A range that ends before it begins has no photons, so that no count contradicts it.
    #[test]
    fn ranges_that_run_backwards_are_refused() {
        let (header, sums) = part_lit_by(Vec::new());
        assert!(decode(&bytes_of(&header, &sums)).is_ok());
        let backwards = PartFile { photons: Range { start: 5, end: 3 }, ..header };
        let error = decode(&bytes_of(&backwards, &sums)).unwrap_err();
        assert!(matches!(error, PartProblem::Contradiction), "{error}");
    }

    type Forge = &'static dyn Fn(&mut PartFile, &mut RangeSums);

    fn part() -> (PartFile, RangeSums) {
        part_lit_by(vec![lamp(Vec3::new(0.5, 0.5, 0.9), 0.5, 40.0)])
    }

    fn part_lit_by(lights: Vec<AreaLight>) -> (PartFile, RangeSums) {
        let walls = closed_box(Vec3::ZERO, Vec3::ONE);
        let light = lamp(Vec3::splat(0.5), 0.5, 40.0);
        let model = Model { lights, ..model(walls, 0.5, light) };
        let options = ShootOptions { photons: 100_000, ..ShootOptions::default() };
        let mut built = BuiltIndex::new(&model, IndexKind::Bvh);
        let index = built.index();
        let photons = 500..70_001;
        let sums = shoot_range(&model, index.as_ray_index(), &options, photons.clone(), &|_| {});
        let job = Job::of_shot(&model, &options);
        let (arguments, provenance) = (Vec::new(), "a test".into());
        (PartFile { job, photons, arguments, provenance }, sums)
    }

    /// The bytes of a file with this header and these sums.
    fn bytes_of(header: &PartFile, sums: &RangeSums) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.part");
        header.write(&path, &PartSums::Shot(sums.clone())).unwrap();
        fs::read(path).unwrap()
    }

    #[test]
    fn a_part_is_read_as_it_was_written() {
        let (header, sums) = part();
        let bytes = bytes_of(&header, &sums);
        assert!(bytes.len() < 100_000, "{} bytes", bytes.len());
        assert_eq!(decode(&bytes).unwrap(), (header, PartSums::Shot(sums)));
    }

    #[test]
    fn torn_and_changed_files_are_refused() {
        let (header, sums) = part();
        let bytes = bytes_of(&header, &sums);
        for length in (0..bytes.len()).step_by(97) {
            let error = decode(&bytes[..length]).unwrap_err();
            let expected = matches!(error, PartProblem::NotAPart if length < 8)
                || matches!(error, PartProblem::Torn if length >= 8);
            assert!(expected, "{length}: {error}");
        }
        for at in (0..bytes.len()).step_by(131) {
            let mut changed = bytes.clone();
            changed[at] ^= 4;
            assert!(decode(&changed).is_err(), "{at}");
        }
    }

    #[test]
    fn forged_sums_are_refused() {
        let (header, part) = part();
        let forged: [Forge; 12] = [
            &|header, _| header.photons.start -= 1,
            &|header, _| header.photons.end += 1,
            &|header, _| header.job.photons = 60_000,
            &|header, _| header.job.triangles += 1,
            &|_, sums| sums.hits[3][0] += 1,
            &|_, sums| sums.hits[3][0] = u64::MAX,
            &|_, sums| sums.balance.escaped += 1,
            &|_, sums| sums.balance.total_flux = f64::NAN,
            &|_, sums| sums.balance.emitted = 0,
            // Sums with those of another part would wrap.
            &|_, sums| {
                sums.hits[3][0] += 1 << 63;
                sums.balance.hits += 1 << 63;
            },
            &|_, sums| sums.bounce_count = u64::MAX,
            &|_, sums| sums.balance.rays = u64::MAX,
        ];
        for (number, forge) in forged.iter().enumerate() {
            let (mut header, mut sums) = (header.clone(), part.clone());
            forge(&mut header, &mut sums);
            let error = decode(&bytes_of(&header, &sums)).unwrap_err();
            assert!(matches!(error, PartProblem::Contradiction), "{number}: {error}");
        }
    }
}
