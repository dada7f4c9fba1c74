//! Records of files that were validated on this machine, so that only its first process validates them.
//!
//! ```text
//! /run/user/1000/arboleda/DEVICE-INODE.validated     or below the folder of temporary files
//!     program, then for each file: device, inode, bytes, time of the last write, time of the last change
//! ```
//! A file that was written to, replaced or copied has another identity, and is validated again. The time of the last
//! change is the system's: no program sets it, so a record cannot be made for a file that comes from elsewhere. The
//! folder is this user's, and nobody else writes to it.

use std::fs::{File, Metadata};
use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use super::PROGRAM;
use crate::files::output::write_file;

/// Age of the youngest file that gets a record. The clock of files stands still for some milliseconds, in which a file
/// may be changed once more without another time; and that of a disk elsewhere may differ from this machine's.
const SETTLED: Duration = Duration::from_secs(2);

/// Record of files, as they are.
#[derive(Debug)]
pub struct Record {
    path: PathBuf,
    text: String,
    is_settled: bool,
}

impl PartialEq for Record {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl Record {
    /// Makes the record of files; `None` where the system does not tell what is needed. Nothing is written yet.
    pub fn of(files: &[Metadata]) -> Option<Self> {
        let now = SystemTime::now();
        let folder = folder()?;
        let name = system::name(files.first()?);
        let identities: Option<Vec<String>> = files.iter().map(system::identity).collect();
        let text = format!("{PROGRAM}\n{}\n", identities?.join("\n"));
        let is_settled = files.iter().all(|file| system::is_older(file, now, SETTLED));
        Some(Self { path: folder.join(format!("{name}.validated")), text, is_settled })
    }

    /// Tells whether the record is there.
    pub fn is_there(&self) -> bool {
        std::fs::read_to_string(&self.path).is_ok_and(|text| text == self.text)
    }

    /// Waits until no other process of this user holds the lock, and holds it until the result is dropped; `None` where
    /// there are no locks. So of processes that start together, one validates.
    pub fn lock(&self) -> Option<File> {
        let file = File::create(self.path.with_extension("lock")).ok()?;
        file.lock().ok().map(|()| file)
    }

    /// Writes the record, after the files were validated. Tells whether it is there now: a folder that cannot be written
    /// to, or files of this moment, only mean that the next process validates them too.
    pub fn write(&self) -> bool {
        let written =
            || write_file(&self.path, |file| file.write_all(self.text.as_bytes())).is_ok();
        self.is_settled && written()
    }
}

#[cfg(test)]
impl Record {
    pub fn forget(&self) {
        std::fs::remove_file(&self.path).unwrap();
    }
}

/// Finds the folder of this user's records, and makes it. `None` if somebody else could write to it.
fn folder() -> Option<PathBuf> {
    let of_user = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    let user = system::user()?;
    let folder = match of_user.filter(|folder| folder.is_absolute() && folder.is_dir()) {
        Some(folder) => folder.join("arboleda"),
        None => std::env::temp_dir().join(format!("arboleda-{user}")),
    };
    system::make_private(&folder, user).then_some(folder)
}

#[cfg(target_os = "linux")]
mod system {
    use std::fs::{DirBuilder, Metadata, symlink_metadata};
    use std::os::unix::fs::{DirBuilderExt, MetadataExt};
    use std::path::Path;
    use std::time::{Duration, SystemTime, UNIX_EPOCH};

    /// The number of this process's user.
    pub fn user() -> Option<u32> {
        Some(symlink_metadata("/proc/self").ok()?.uid())
    }

    /// Makes a folder of this user's, if it is not there. Tells whether it is that user's alone.
    pub fn make_private(folder: &Path, user: u32) -> bool {
        // One that is there is judged below.
        let _ = DirBuilder::new().mode(0o700).create(folder);
        symlink_metadata(folder)
            .is_ok_and(|it| it.is_dir() && it.uid() == user && it.mode() & 0o022 == 0)
    }

    /// The name of a file that stays when its path does not.
    pub fn name(file: &Metadata) -> String {
        format!("{:x}-{:x}", file.dev(), file.ino())
    }

    /// The identity of a file with its contents: another one if the file is another, or was changed.
    pub fn identity(file: &Metadata) -> Option<String> {
        let written = (file.mtime(), file.mtime_nsec());
        let changed = (file.ctime(), file.ctime_nsec());
        let (device, inode, bytes) = (file.dev(), file.ino(), file.size());
        file.is_file().then(|| format!("{device} {inode} {bytes} {written:?} {changed:?}"))
    }

    /// Tells whether a file was not changed for some time.
    pub fn is_older(file: &Metadata, now: SystemTime, age: Duration) -> bool {
        let changed = u64::try_from(file.ctime()).unwrap_or(u64::MAX);
        let now = now.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs();
        changed.saturating_add(age.as_secs()) < now
    }
}

/// Other systems have no such identity: each process validates.
#[cfg(not(target_os = "linux"))]
mod system {
    use std::fs::Metadata;
    use std::path::Path;
    use std::time::{Duration, SystemTime};

    pub fn user() -> Option<u32> {
        None
    }

    pub fn make_private(_: &Path, _: u32) -> bool {
        false
    }

    pub fn name(_: &Metadata) -> String {
        String::new()
    }

    pub fn identity(_: &Metadata) -> Option<String> {
        None
    }

    pub fn is_older(_: &Metadata, _: SystemTime, _: Duration) -> bool {
        false
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn a_record_is_of_files_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "b"].map(|name| folder.path().join(name));
        for path in [&a, &b] {
            fs::write(path, "same").unwrap();
        }
        let of = || [&a, &b].map(|path| fs::metadata(path).unwrap());
        let make = || Record { is_settled: true, ..Record::of(&of()).unwrap() };
        let record = make();
        assert!(!record.is_there());
        assert!(!Record::of(&of()).unwrap().write(), "files of this moment get no record");
        assert!(record.write() && record.is_there() && make().is_there());

        // Contents of the same length, and even the same time of the last write.
        let written = fs::metadata(&b).unwrap().modified().unwrap();
        std::thread::sleep(Duration::from_millis(20));
        fs::write(&b, "else").unwrap();
        fs::File::options().write(true).open(&b).unwrap().set_modified(written).unwrap();
        assert!(!make().is_there());
        assert!(make().write() && make().is_there());
        // Another file in its place.
        fs::write(folder.path().join("c"), "else").unwrap();
        fs::rename(folder.path().join("c"), &b).unwrap();
        assert!(!make().is_there());
        record.forget();
    }

    #[test]
    fn folders_of_others_are_not_trusted() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let user = system::user().unwrap();
        let own = folder.path().join("own");
        assert!(system::make_private(&own, user) && system::make_private(&own, user));
        assert!(!system::make_private(&own, user + 1));
        let link = folder.path().join("link");
        std::os::unix::fs::symlink(&own, &link).unwrap();
        assert!(!system::make_private(&link, user));
        fs::set_permissions(&own, fs::Permissions::from_mode(0o777)).unwrap();
        assert!(!system::make_private(&own, user));
    }
}
