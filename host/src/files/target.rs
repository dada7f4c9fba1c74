//! Target of an output: a stream, or a file that a temporary one beside it replaces.

use std::path::{Path, PathBuf};
use std::{fs, io};

use anyhow::{Context, bail, ensure};
use tempfile::NamedTempFile;

pub(super) fn cannot_write(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

/// Kind of output that a path names.
pub(super) enum Target {
    /// A pipe, a terminal or a device: written directly.
    Stream,
    /// A file that exists or can be made: replaced by a rename.
    Regular { file: PathBuf, folder: PathBuf },
}

impl Target {
    pub fn of(path: &Path) -> anyhow::Result<Self> {
        if let Ok(present) = fs::metadata(path) {
            ensure!(!present.is_dir(), "{}: it is a folder", cannot_write(path));
            // /dev/stdout redirected to a file is a regular file; a rename would replace the file instead of writing
            // it.
            if !present.is_file() || path.starts_with("/dev") || path.starts_with("/proc") {
                return Ok(Self::Stream);
            }
            ensure!(!present.permissions().readonly(), "{}: it is read-only", cannot_write(path));
        }
        ensure!(!ends_in_separator(path), "{}: it is not a folder", cannot_write(path));
        let file = followed(path).with_context(|| cannot_write(path))?;
        let folder = match file.parent() {
            Some(folder) if folder.as_os_str().is_empty() => PathBuf::from("."),
            Some(folder) => folder.to_owned(),
            None => bail!("{}: it is a folder", cannot_write(path)),
        };
        ensure!(folder.is_dir(), "{}: there is no folder {}", cannot_write(path), folder.display());
        Ok(Self::Regular { file, folder })
    }
}

/// Returns the path of the file that a path leads to, whether the file is there or not. A symbolic link stays; the file
/// that it leads to is written.
///
/// # Errors
/// If the path can lead to no file: by a circle of links, or a name that is too long.
fn followed(path: &Path) -> io::Result<PathBuf> {
    /// Most links in a row, as in Linux.
    const LINKS: usize = 40;
    let mut file = path.to_owned();
    for _ in 0..LINKS {
        match file.symlink_metadata() {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(file),
            Err(error) => return Err(error),
            Ok(found) if !found.is_symlink() => return file.canonicalize(),
            Ok(_) => {
                let target = file.read_link()?;
                file = file.parent().unwrap_or(Path::new("")).join(target);
            }
        }
    }
    Err(io::Error::other("too many symbolic links"))
}

/// Tells whether a path is written as that of a folder.
fn ends_in_separator(path: &Path) -> bool {
    let last = path.as_os_str().as_encoded_bytes().last();
    last.is_some_and(|&byte| std::path::is_separator(char::from(byte)))
}

/// Makes a file that is deleted when dropped unless it was renamed. Its permissions are those of any new file: 0666
/// less the process's mask.
pub(super) fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".arboleda-").suffix(".part");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn what_leads_to_no_file_is_told_beforehand() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::os::unix::fs::symlink("circle.txt", at("circle.txt")).unwrap();
        let long = "a".repeat(300);
        for (name, message) in [
            ("circle.txt", "too many symbolic links"),
            (long.as_str(), "too long"),
            ("a.txt/", "it is not a folder"),
        ] {
            let error = format!("{:#}", Target::of(&at(name)).err().unwrap());
            assert!(error.contains(message), "{error}");
        }
        // A link whose file is not there yet leads to it.
        std::os::unix::fs::symlink("new.txt", at("link.txt")).unwrap();
        let Ok(Target::Regular { file, .. }) = Target::of(&at("link.txt")) else { panic!() };
        assert_eq!(file, at("new.txt"));
    }
}
