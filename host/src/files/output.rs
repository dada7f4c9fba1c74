//! Files that are written whole or not at all.
//!
//! ```text
//! check_writable -> the work -> write_file: writes a temporary file beside the target, then renames it
//! ```
//! An interrupted or failed write leaves the old file as it was. A target that is not a regular file, such as a pipe or
//! a device, is written directly.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use npyz::{DType, Field, WriterBuilder};
use tempfile::NamedTempFile;

use super::target::{Target, cannot_write, temporary};

/// Checks that a file can be written, for use before the work whose result it will hold. Leaves no file behind.
///
/// # Errors
/// Fails if the file's folder does not exist or cannot be written to, or if the path is a folder or a read-only file.
pub fn check_writable(path: &Path) -> anyhow::Result<()> {
    match Target::of(path)? {
        Target::Stream => Ok(()),
        Target::Regular { folder, .. } => {
            temporary(&folder).map(drop).with_context(|| cannot_write(path))
        }
    }
}

/// Checks the files of a command before its work: that each can be written, that no two are one file, and that none is
/// a file that the command reads. Pipes and devices may be named twice.
///
/// # Errors
/// The errors of [`check_writable`]; fails for two names of one file.
pub fn check_outputs<'p>(
    outputs: impl IntoIterator<Item = &'p PathBuf>,
    inputs: &[PathBuf],
) -> anyhow::Result<()> {
    let inputs: Vec<PathBuf> = inputs.iter().filter_map(|path| path.canonicalize().ok()).collect();
    let mut files = Vec::new();
    for path in outputs {
        check_writable(path)?;
        let Target::Regular { file, folder } = Target::of(path)? else { continue };
        let name = file.file_name().unwrap_or_default();
        let file = folder.canonicalize().unwrap_or(folder).join(name);
        ensure!(!files.contains(&file), "two outputs would be written to {}", path.display());
        ensure!(
            !inputs.contains(&file),
            "{}: the command reads it; name another file",
            cannot_write(path)
        );
        files.push(file);
    }
    Ok(())
}

/// Writes a file; `fill` writes the contents.
///
/// # Errors
/// The errors of [`check_writable`] and of `fill`; fails if the device is full.
pub fn write_file(
    path: &Path,
    fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> anyhow::Result<()> {
    let filled = |file: &File| -> io::Result<()> {
        let mut writer = BufWriter::new(file);
        fill(&mut writer)?;
        writer.flush()
    };
    match Target::of(path)? {
        Target::Stream => {
            let file =
                OpenOptions::new().write(true).open(path).with_context(|| cannot_write(path))?;
            filled(&file).with_context(|| cannot_write(path))
        }
        Target::Regular { file, folder } => {
            let part = temporary(&folder).with_context(|| cannot_write(path))?;
            filled(part.as_file()).with_context(|| cannot_write(path))?;
            persist(part, &file).with_context(|| cannot_write(path))
        }
    }
}

/// Makes a new file beside another, lets `fill` fill it in any order, and replaces the other by it. `fill` also receives
/// the folder, for temporary files.
///
/// # Errors
/// The errors of [`check_writable`] and of `fill`; fails for a pipe or a device, which can only be written in order.
pub fn replace_file(
    path: &Path,
    fill: impl FnOnce(&File, &Path) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    match Target::of(path)? {
        Target::Stream => bail!("{}: it is a pipe or a device, not a file", cannot_write(path)),
        Target::Regular { file, folder } => {
            let part = temporary(&folder).with_context(|| cannot_write(path))?;
            fill(part.as_file(), &folder).map_err(|error| {
                let is_of_files = error.is::<io::Error>();
                if is_of_files { error.context(cannot_write(path)) } else { error }
            })?;
            // What was written to a map is told to have failed nowhere else.
            part.as_file().sync_all().with_context(|| cannot_write(path))?;
            persist(part, &file).with_context(|| cannot_write(path))
        }
    }
}

/// Gives a temporary file the name of a file that it replaces, and its permissions.
fn persist(part: NamedTempFile, file: &Path) -> io::Result<()> {
    if let Ok(replaced) = fs::metadata(file) {
        part.as_file().set_permissions(replaced.permissions())?;
    }
    part.persist(file).map(drop).map_err(|error| error.error)
}

/// Writes values as a `.npy` array; the product of `shape` is the number of values.
///
/// # Errors
/// The errors of [`write_file`].
pub fn write_npy<T: npyz::AutoSerialize + Copy>(
    path: &Path,
    shape: &[usize],
    values: &[T],
) -> anyhow::Result<()> {
    write_npy_of(path, shape, values.iter().copied())
}

/// Writes values as [`write_npy`] does, as they are made.
fn write_npy_of<T: npyz::AutoSerialize>(
    path: &Path,
    shape: &[usize],
    values: impl Iterator<Item = T>,
) -> anyhow::Result<()> {
    let shape: Vec<u64> = shape.iter().map(|&side| side as u64).collect();
    write_file(path, |file| {
        let dtype = little_endian(T::default_dtype());
        let mut writer =
            npyz::WriteOptions::new().dtype(dtype).shape(&shape).writer(file).begin_nd()?;
        writer.extend(values)?;
        writer.finish()
    })
}

/// Makes the type of an array little-endian, so that a file has the same bytes from every machine.
fn little_endian(dtype: DType) -> DType {
    match dtype {
        DType::Plain(plain) => {
            let little = plain.to_string().replacen('>', "<", 1);
            DType::Plain(little.parse().unwrap_or(plain))
        }
        DType::Array(length, inner) => DType::Array(length, Box::new(little_endian(*inner))),
        DType::Record(fields) => {
            let little = |field: Field| Field { dtype: little_endian(field.dtype), ..field };
            DType::Record(fields.into_iter().map(little).collect())
        }
    }
}

/// Writes one row for each triangle, in the order of ids: as CSV if the name ends in .csv, else as a structured array.
/// A line of the CSV file has the triangle, then its `cells`; `columns` names all of them. Rows are written as they are
/// made, because a table of all triangles may be larger than the memory.
///
/// # Errors
/// The errors of [`write_file`].
pub fn write_triangle_rows<R, C>(
    path: &Path,
    columns: &[&str],
    rows: impl ExactSizeIterator<Item = R>,
    cells: impl Fn(&R) -> C,
) -> anyhow::Result<()>
where
    R: npyz::AutoSerialize,
    C: serde::Serialize,
{
    if path.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("csv")) {
        return write_npy_of(path, &[rows.len()], rows);
    }
    write_file(path, |file| {
        let mut writer = csv::Writer::from_writer(file);
        writer.write_record(columns)?;
        for (triangle, row) in rows.enumerate() {
            writer.serialize((triangle, cells(&row)))?;
        }
        writer.flush()
    })
}

/// Makes a folder for files, and the folders above it.
///
/// # Errors
/// Fails if the folder or a file in it cannot be made.
pub fn make_folder(folder: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(folder)
        .and_then(|()| temporary(folder).map(drop))
        .with_context(|| format!("cannot write into the folder {}", folder.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_file_is_written_whole_or_stays_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        check_writable(&path).unwrap();
        assert!(names(folder.path()).is_empty(), "checking leaves nothing");
        write_file(&path, |writer| writer.write_all(b"first")).unwrap();
        let failed = write_file(&path, |writer| {
            writer.write_all(b"second")?;
            Err(io::Error::other("no more"))
        });
        assert_eq!(
            format!("{:#}", failed.unwrap_err()),
            format!("{}: no more", cannot_write(&path))
        );
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(names(folder.path()), ["a.txt"]);
    }

    #[test]
    fn what_cannot_be_written_is_told_beforehand() {
        let folder = tempfile::tempdir().unwrap();
        let missing = check_writable(&folder.path().join("no/a.txt")).unwrap_err().to_string();
        assert!(missing.contains("there is no folder"), "{missing}");
        let is_folder = check_writable(folder.path()).unwrap_err().to_string();
        assert!(is_folder.ends_with("it is a folder"), "{is_folder}");
        let path = folder.path().join("kept.txt");
        fs::write(&path, "kept").unwrap();
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        let read_only = check_writable(&path).unwrap_err().to_string();
        assert!(read_only.ends_with("it is read-only"), "{read_only}");
    }

    #[test]
    fn two_names_of_one_file_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("in")).unwrap();
        fs::write(at("a.txt"), "kept").unwrap();
        let check = |outputs: &[&str], inputs: &[&str]| {
            let [outputs, inputs]: [Vec<PathBuf>; 2] =
                [outputs, inputs].map(|names| names.iter().map(|name| at(name)).collect());
            check_outputs(&outputs, &inputs).err().map(|error| error.to_string())
        };
        assert_eq!(check(&["a.txt", "b.txt", "in/a.txt"], &["none"]), None);
        assert_eq!(check(&["/dev/null", "/dev/null"], &["/dev/null"]), None);
        let twice = check(&["new.txt", "in/../new.txt"], &[]).unwrap();
        assert!(twice.starts_with("two outputs would be written to "), "{twice}");
        let read = check(&["in/../a.txt"], &["a.txt"]).unwrap();
        assert!(read.ends_with("the command reads it; name another file"), "{read}");
    }

    #[cfg(unix)]
    #[test]
    fn links_lead_on_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [path, link] = ["a.txt", "link.txt"].map(|name| folder.path().join(name));
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&path, &link).unwrap();
        write_file(&link, |writer| writer.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
    }

    #[test]
    fn arrays_are_little_endian_on_every_machine() {
        let plain = |text: &str| DType::Plain(text.parse().unwrap());
        let record = |number: &str, byte: &str| {
            let inner = DType::Array(3, Box::new(plain(number)));
            let field = |name: &str, dtype| Field { name: name.into(), dtype };
            DType::Record(vec![field("a", inner), field("b", plain(byte))])
        };
        assert_eq!(little_endian(plain(">f8")), plain("<f8"));
        assert_eq!(little_endian(record(">u4", "|u1")), record("<u4", "|u1"));
        assert_eq!(little_endian(record("<u4", "|u1")), record("<u4", "|u1"));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_is_an_error() {
        let full = Path::new("/dev/full");
        check_writable(full).unwrap();
        let error = write_file(full, |writer| writer.write_all(b"lost")).unwrap_err();
        assert!(format!("{error:#}").starts_with("cannot write /dev/full: "), "{error:#}");
    }
}
