//! Reading of what others wrote: never without bound, and never from a device.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::fs::{self, FileType};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// So many bytes are read of anything.
pub const LONGEST: u64 = 64 << 20;

/// The files that this process has read, links followed: a command writes over none of them.
static READ: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

thread_local! {
    /// Whether what this thread reads now may be written over afterwards.
    static ONLY_LOOKS: Cell<bool> = const { Cell::new(false) };
}

/// Does something that reads files only to see whether they may be written over: [`was_read`] does not count them.
pub fn only_looking<T>(look: impl FnOnce() -> T) -> T {
    let before = ONLY_LOOKS.replace(true);
    let seen = look();
    ONLY_LOOKS.set(before);
    seen
}

/// Whether this process has read a file, by whatever name.
#[must_use]
pub fn was_read(path: &Path) -> bool {
    let read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    fs::canonicalize(path).is_ok_and(|path| read.contains(&path))
}

/// A file within a folder that this process has read and that has one of these endings, if there is one.
#[must_use]
pub fn read_within(folder: &Path, endings: &[&str]) -> Option<PathBuf> {
    let folder = fs::canonicalize(folder).ok()?;
    let read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    let is_it = |file: &&PathBuf| {
        let ends = |ending: &&str| file.extension().is_some_and(|extension| extension == *ending);
        file.starts_with(&folder) && endings.iter().any(ends)
    };
    read.iter().find(is_it).cloned()
}

/// What is no file to be read, in words.
fn oddity(kind: FileType, may_be_pipe: bool) -> Option<&'static str> {
    if kind.is_file() {
        return None;
    }
    if kind.is_dir() {
        return Some("this is a folder, not a file");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_char_device() || kind.is_block_device() {
            return Some("this is a device, not a file");
        }
        if kind.is_fifo() {
            return (!may_be_pipe).then_some("this is a pipe, not a file");
        }
    }
    Some("this is not a file")
}

/// All that comes, if that is no more than [`LONGEST`].
///
/// # Errors
///
/// The system's, or that there is more.
pub fn bounded(reader: impl Read) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(LONGEST + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LONGEST {
        return Err(Error::new(ErrorKind::FileTooLarge, "it is larger than 64 MB"));
    }
    Ok(bytes)
}

fn open(path: &Path, may_be_pipe: bool) -> Result<fs::File> {
    // Asked before it is opened: to open a pipe waits for somebody who writes.
    if let Some(oddity) = oddity(fs::metadata(path)?.file_type(), may_be_pipe) {
        return Err(Error::new(ErrorKind::InvalidInput, oddity));
    }
    let file = fs::File::open(path)?;
    if !ONLY_LOOKS.get()
        && let Ok(path) = fs::canonicalize(path)
    {
        READ.lock().unwrap_or_else(PoisonError::into_inner).insert(path);
    }
    Ok(file)
}

/// What a path holds that somebody named: a file, or a pipe that another program writes to.
///
/// # Errors
///
/// The system's; or it is a device, a folder, or larger than [`LONGEST`].
pub fn named(path: &Path) -> Result<Vec<u8>> {
    bounded(open(path, true)?)
}

/// What a file holds that another file named.
///
/// # Errors
///
/// The system's; or it is no regular file, or larger than [`LONGEST`].
pub fn imported(path: &Path) -> Result<Vec<u8>> {
    bounded(open(path, false)?)
}

/// What stands where a command is going to write: it may be written over.
///
/// # Errors
///
/// The system's; or it is no regular file.
pub fn to_replace(path: &Path) -> Result<Vec<u8>> {
    if let Some(oddity) = oddity(fs::metadata(path)?.file_type(), false) {
        return Err(Error::new(ErrorKind::InvalidInput, oddity));
    }
    fs::read(path)
}

/// What a file of a run's folder holds, however long it has become.
///
/// # Errors
///
/// The system's; or it is no regular file.
pub fn own(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path, false)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_long_is_not_read_to_its_end() {
        assert_eq!(bounded(&b"grammar"[..]).unwrap(), b"grammar");
        assert_eq!(bounded(std::io::repeat(0)).unwrap_err().kind(), ErrorKind::FileTooLarge);
        let most = bounded(std::io::repeat(0).take(LONGEST)).unwrap();
        assert_eq!(most.len() as u64, LONGEST);
    }

    #[test]
    fn what_was_read_is_known_by_any_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        ["a", "b"].iter().for_each(|name| fs::write(at(name), name).unwrap());
        assert_eq!((named(&at("a")).unwrap(), to_replace(&at("b")).unwrap()), (b"a".into(), b"b".into()));
        assert!(was_read(&at("a")) && was_read(&folder.path().join("./a")) && !was_read(&at("b")));
        assert_eq!(only_looking(|| own(&at("b"))).unwrap(), b"b");
        assert!(!was_read(&at("b")));
        own(&at("b")).unwrap();
        assert!(was_read(&at("b")));
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_refused() {
        let reason = |read: Result<Vec<u8>>| read.unwrap_err().to_string();
        for device in ["/dev/zero", "/dev/null"] {
            assert!(reason(named(Path::new(device))).contains("device"), "{device}");
            assert!(reason(imported(Path::new(device))).contains("device"), "{device}");
        }
        assert!(reason(named(Path::new("/dev"))).contains("folder"));
    }
}
