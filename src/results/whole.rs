//! Files that are written whole or not at all.

use std::fs;
use std::io::ErrorKind::{InvalidInput, NotFound, PermissionDenied, Unsupported};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use tempfile::NamedTempFile;

use super::{FileError, Unfit, Unwritable};
use crate::reading;

/// How the names of files and folders begin that are not written to their end; the name that they are to have follows.
const UNFINISHED: &str = ".sgc-";
/// In the names of files, so many letters and digits that nobody else has follow that, and an ending.
const DRAWN: usize = 6;
const PART: &str = ".part";
/// So much of the name that a file is to have is in that which it has meanwhile, in bytes: no name may be longer than 255.
const NAMED: usize = 200;
/// A file of this age is locked by the process that writes it, if there is one.
const LOCKED_WITHIN: Duration = Duration::from_secs(10);

/// The files that this process is writing.
static UNDER_WAY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A file that is being written: it is removed if the process is told to end meanwhile.
struct UnderWay<'a>(&'a Path);

/// Makes a file that is to be written. No signal finds it made but not yet known as one that is under way.
fn begin(make: impl FnOnce() -> std::io::Result<NamedTempFile>) -> std::io::Result<NamedTempFile> {
    let mut under_way = UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner);
    let file = make()?;
    under_way.push(file.path().to_owned());
    Ok(file)
}

impl Drop for UnderWay<'_> {
    fn drop(&mut self) {
        UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner).retain(|path| path != self.0);
    }
}

/// Older runs that wait for a best of the one that replaces them: where they are, and their place.
static REPLACED: Mutex<Vec<(PathBuf, PathBuf)>> = Mutex::new(Vec::new());

/// Notes that an older run waits for the first best of the one in its place, and is to be given back if none comes.
pub(super) fn wait_for_best(older: &Path, place: &Path) {
    REPLACED.lock().unwrap_or_else(PoisonError::into_inner).push((older.to_owned(), place.to_owned()));
}

/// Notes that it waits no more.
pub(super) fn wait_no_more(older: &Path) {
    REPLACED.lock().unwrap_or_else(PoisonError::into_inner).retain(|(waits, _)| waits != older);
}

/// Removes what is not written to its end, and gives older runs back whose replacement has found nothing, as the process is about to
/// end. Whether a run was given back.
pub(crate) fn abandon() -> bool {
    let mut is_back = false;
    for (older, place) in REPLACED.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        // Another name first: what other threads still write is not written into the older run.
        let doomed = place.with_file_name(format!("{}{}", unfinished(&place), std::process::id()));
        is_back |= fs::rename(&place, &doomed).and_then(|()| fs::rename(&older, &place)).is_ok();
        let _ = fs::remove_dir_all(doomed);
    }
    let under_way = UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner);
    for path in under_way.iter() {
        // What cannot be removed does no harm.
        let _ = fs::remove_file(path);
    }
    // No thread begins another file until the process has ended.
    std::mem::forget(under_way);
    is_back
}

/// How often a lock is tried again: whoever only asks about one holds it for a moment.
const PATIENCE: usize = 5;

/// Whether a name is of a file that was not written to its end.
pub(crate) fn is_unfinished(name: &str) -> bool {
    let whole = name.strip_prefix(UNFINISHED).and_then(|name| name.strip_suffix(PART));
    let drawn = whole.and_then(|name| name.rsplit_once('-')).map(|(_, drawn)| drawn);
    drawn.is_some_and(|drawn| drawn.len() == DRAWN && drawn.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}

/// How the names of files begin that are to become this one.
fn unfinished_file(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let end = (0..=name.len().min(NAMED)).rev().find(|end| name.is_char_boundary(*end)).unwrap_or(0);
    format!("{UNFINISHED}{}-", &name[..end])
}

/// Removes what processes have left that were killed while they wrote this file.
fn clear_unfinished_of(path: &Path, folder: &Path) {
    let beginning = unfinished_file(path);
    let names = entries(folder).unwrap_or_default();
    for name in names.iter().filter(|name| name.starts_with(&beginning) && is_unfinished(name)) {
        let place = folder.join(name);
        let Ok(data) = fs::symlink_metadata(&place) else { continue };
        let age = data.modified().ok().and_then(|then| then.elapsed().ok());
        if data.is_file() && age.is_some_and(|age| age > LOCKED_WITHIN) && !is_locked(&place) {
            // What cannot be removed does no harm.
            let _ = fs::remove_file(place);
        }
    }
}

/// Removes the files in a folder that a process was writing when it was killed.
pub(super) fn clear_unfinished_files(folder: &Path) {
    for name in entries(folder).unwrap_or_default().iter().filter(|name| is_unfinished(name)) {
        let path = folder.join(name);
        if fs::symlink_metadata(&path).is_ok_and(|data| data.is_file()) {
            // What cannot be removed does no harm.
            let _ = fs::remove_file(path);
        }
    }
}

/// Writes a file so that it is there whole or not at all: beside it first,
/// flushed to the disk, then renamed; it is on the disk when this returns.
///
/// # Errors
///
/// A sentence with the path and the system's reason.
pub fn write_whole(path: &Path, text: &str) -> Result<(), FileError> {
    write_with(path, text, None)
}

/// Writes a file of a run, as [`write_whole`] does, but not into what a link leads to: somebody may have moved the file away to
/// keep it.
///
/// # Errors
///
/// A sentence with the path and the reason.
pub(crate) fn write_own(path: &Path, text: &str) -> Result<(), FileError> {
    check_no_link(path)?;
    write_whole(path, text)
}

/// Checks that a file or folder of a run is no link.
///
/// # Errors
///
/// It is one.
pub(super) fn check_no_link(path: &Path) -> Result<(), FileError> {
    if path.is_symlink() { Err(FileError::unfit(path, Unfit::Link)) } else { Ok(()) }
}

/// Replaces the text of a file that exists, as [`write_whole`] does; who may read
/// and write it stays as it is.
///
/// # Errors
///
/// A sentence with the path and the reason: also if the file may not be written.
pub fn rewrite(path: &Path, text: &str) -> Result<(), FileError> {
    if is_open_already(path) {
        return Err(FileError::write(path)(Unwritable::Open));
    }
    let metadata = fs::metadata(path).map_err(FileError::write(path))?;
    #[cfg(unix)]
    if std::os::unix::fs::MetadataExt::nlink(&metadata) > 1 {
        return Err(FileError::write(path)(Unwritable::Linked));
    }
    let permissions = metadata.permissions();
    // A rename would replace even a file that may not be written.
    if permissions.readonly() {
        return Err(FileError::write(path)(Unwritable::ReadOnly));
    }
    write_with(path, text, Some(permissions))
}

/// Whether a path is a way to a file that this process has been given open, as `/dev/stdin` is: whoever redirects a file to
/// be read has not said that it may be written.
pub(crate) fn is_open_already(path: &Path) -> bool {
    let folder = path.parent().and_then(|folder| fs::canonicalize(folder).ok());
    folder.is_some_and(|folder| ["/dev", "/proc"].iter().any(|root| folder.starts_with(root)))
}

/// Whether a name still is that of a file that is open.
pub(super) fn is_same(path: &Path, file: &fs::File) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let (Ok(there), Ok(held)) = (fs::metadata(path), file.metadata()) else { return false };
        (there.dev(), there.ino()) == (held.dev(), held.ino())
    }
    #[cfg(not(unix))]
    {
        let _ = file;
        path.exists()
    }
}

fn write_with(path: &Path, text: &str, permissions: Option<fs::Permissions>) -> Result<(), FileError> {
    let named = path;
    let fault = |why: std::io::Error| FileError::write(named)(why);
    // A link is followed; a device or pipe is no file to be replaced.
    let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if path.exists() && !path.is_file() {
        return Err(FileError::write(named)(Unwritable::NotRegular));
    }
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    clear_unfinished_of(path, parent);
    let mut builder = tempfile::Builder::new();
    let prefix = unfinished_file(path);
    builder.prefix(&prefix).rand_bytes(DRAWN).suffix(PART);
    // As any other file: readable by whom the user's mask allows.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = begin(|| builder.tempfile_in(parent)).map_err(|why| match why.kind() {
        NotFound => FileError::write(named)(Unwritable::NoFolder { folder: parent.to_owned() }),
        // The error names the file that is written first, which nobody has asked for.
        kind @ PermissionDenied => fault(kind.into()),
        _ => fault(why),
    })?;
    let place = file.path().to_owned();
    let under_way = UnderWay(&place);
    let mut open = file.as_file();
    // So that others see that it is written. Some file systems know no locks.
    let _ = open.try_lock();
    if let Ok(old) = fs::metadata(path) {
        // What replaces a file is of the same owner, if that may be said, and open to the same people.
        #[cfg(unix)]
        {
            use std::os::unix::fs::{MetadataExt, fchown};
            let _ = fchown(open, Some(old.uid()), Some(old.gid()));
        }
        open.set_permissions(old.permissions()).map_err(fault)?;
    }
    open.write_all(text.as_bytes()).map_err(fault)?;
    if let Some(permissions) = permissions {
        open.set_permissions(permissions).map_err(fault)?;
    }
    open.sync_all().map_err(fault)?;
    file.persist(path).map_err(|e| fault(e.error))?;
    drop(under_way);
    sync_folder(parent).map_err(fault)
}

/// Makes sure that what was renamed in a folder stays so after a loss of power.
pub(super) fn sync_folder(path: &Path) -> std::io::Result<()> {
    if !cfg!(unix) {
        // Elsewhere a folder cannot be opened as a file.
        return Ok(());
    }
    match fs::File::open(path).and_then(|folder| folder.sync_all()) {
        // Some file systems do not know this, and some folders may be written but not read.
        Err(e) if matches!(e.kind(), InvalidInput | Unsupported | PermissionDenied) => Ok(()),
        done => done,
    }
}

/// Makes a folder so that it is there whole or not at all: filled beside its place first, then
/// renamed. Where an empty folder is already, that one is filled: it may be where a disk is mounted.
/// What else is there is moved `aside`, and back again if nothing comes of it.
///
/// Of several processes that make the same folder at once, one does and the others fail. `check`
/// looks at the place once more when there is something to put there.
pub(super) fn make_folder<T, E: From<FileError>>(
    path: &Path,
    aside: Option<&Path>,
    check: impl FnOnce() -> Result<(), E>,
    fill: impl FnOnce(&Path) -> Result<T, E>,
) -> Result<T, E> {
    let fault = |why| FileError::write(path)(Unwritable::NoPlace(why));
    if aside.is_none() && path.exists() {
        return fill_empty(path, fill);
    }
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(parent).map_err(fault)?;
    let mut builder = tempfile::Builder::new();
    let prefix = unfinished(path);
    builder.prefix(&prefix);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
    let beside = builder.tempdir_in(parent).map_err(fault)?;
    // Others who look for what was left unfinished see that this is not.
    let filled = fs::File::open(beside.path()).ok();
    let filled = filled.map(|folder| hold(&beside.path().join(UNFINISHED), folder)).transpose()?;
    let made = fill(beside.path())?;
    check()?;
    if let Some(aside) = aside {
        fs::rename(path, aside).map_err(fault)?;
    }
    if let Err(e) = fs::rename(beside.path(), path) {
        if let Some(aside) = aside {
            let _ = fs::rename(aside, path);
        }
        // Somebody was faster by less than the check sees.
        let is_taken = e.kind() == std::io::ErrorKind::DirectoryNotEmpty;
        return Err(if is_taken { FileError::unfit(path, Unfit::Exists) } else { fault(e) }.into());
    }
    // It has another name now: there is nothing to remove.
    let _ = beside.keep();
    drop(filled);
    sync_folder(parent).map_err(fault)?;
    Ok(made)
}

/// Fills a folder that is there and empty, and that no other process fills.
fn fill_empty<T, E: From<FileError>>(path: &Path, fill: impl FnOnce(&Path) -> Result<T, E>) -> Result<T, E> {
    // A folder can be locked like a file. Elsewhere than on Unix it cannot be opened as one.
    let folder = fs::File::open(path).ok();
    let lock = folder.map(|folder| hold(&path.join(UNFINISHED), folder)).transpose()?;
    if !entries(path).map_err(FileError::read(path))?.is_empty() {
        return Err(FileError::unfit(path, Unfit::Exists).into());
    }
    let made = fill(path);
    drop(lock);
    made
}

/// How the names of folders begin that are made to become this one.
pub(super) fn unfinished(path: &Path) -> String {
    format!("{UNFINISHED}{}-", path.file_name().unwrap_or_default().to_string_lossy())
}

/// The names in a folder.
pub(crate) fn entries(path: &Path) -> std::io::Result<Vec<String>> {
    fs::read_dir(path)?.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
}

/// How the names of folders begin that were to be replaced by this one.
pub(super) fn replaced(path: &Path) -> String {
    format!("{}.replaced-", path.file_name().unwrap_or_default().to_string_lossy())
}

/// Where what is to be replaced waits until it is known that something comes of it.
pub(super) fn aside(path: &Path) -> PathBuf {
    path.with_file_name(format!("{}{}", replaced(path), std::process::id()))
}

/// Keeps other processes from writing what a file stands for. The system gives the lock back
/// with the process, however that ends.
pub(super) fn lock(path: &Path) -> Result<fs::File, FileError> {
    let file = fs::OpenOptions::new().read(true).write(true).open(path);
    hold(path, file.map_err(FileError::write(path))?)
}

/// The same for a run that is to go on: nothing is begun in a folder that cannot be written.
pub(super) fn lock_again(path: &Path) -> Result<fs::File, FileError> {
    let folder = path.parent().unwrap_or(path);
    let file = tempfile::Builder::new()
        .prefix(&unfinished_file(path))
        .rand_bytes(DRAWN)
        .suffix(PART)
        .tempfile_in(folder);
    let file = file.and_then(|_| fs::OpenOptions::new().read(true).write(true).open(path));
    let file = file.map_err(|why| FileError::write(folder)(Unwritable::NoSession(why)))?;
    hold(path, file)
}

/// Locks a file that is open.
fn hold(path: &Path, file: fs::File) -> Result<fs::File, FileError> {
    let mut locked = file.try_lock();
    for _ in 0..PATIENCE {
        if !matches!(locked, Err(fs::TryLockError::WouldBlock)) {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
        locked = file.try_lock();
    }
    match locked {
        Err(fs::TryLockError::WouldBlock) => {
            Err(FileError::UnderWay { folder: path.parent().unwrap_or(path).to_owned() })
        }
        // Some file systems know no locks.
        Ok(()) | Err(fs::TryLockError::Error(_)) => Ok(file),
    }
}

/// Whether another process holds the lock of a file. Asking holds it for a moment.
pub(crate) fn is_locked(path: &Path) -> bool {
    let file = fs::File::open(path);
    file.is_ok_and(|file| matches!(file.try_lock_shared(), Err(fs::TryLockError::WouldBlock)))
}

/// Reads a text.
pub(crate) fn read(path: &Path) -> Result<String, FileError> {
    let text = reading::own(path).and_then(|bytes| String::from_utf8(bytes).map_err(std::io::Error::other));
    text.map_err(FileError::read(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_there_whole_or_not_at_all() {
        let parent = tempfile::tempdir().unwrap();
        let at = |name: &str| parent.path().join(name);
        let fill = |path: &Path| write_whole(&path.join("a"), "1");
        let free = || Ok(());
        make_folder(&at("new"), None, free, fill).unwrap();
        assert_eq!(read(&at("new/a")).unwrap(), "1");

        let fails = |path: &Path| fill(path).and(Err::<(), _>(FileError::unfit(path, Unfit::Edited)));
        assert!(make_folder(&at("other"), None, free, fails).is_err());
        assert!(make_folder(&at("new"), Some(&at("old")), free, fails).is_err());
        assert_eq!(entries(parent.path()).unwrap(), ["new"], "nothing is left, and nothing was moved");

        let changed = |path: &Path| write_whole(&path.join("a"), "2");
        make_folder(&at("new"), Some(&at("old")), free, changed).unwrap();
        assert_eq!(read(&at("new/a")).unwrap(), "2");
        assert_eq!(read(&at("old/a")).unwrap(), "1");
    }

    #[test]
    fn what_a_killed_process_left_of_a_file_goes_when_it_is_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let left = |name: &str, age: Duration| {
            let file = fs::File::create(at(name)).unwrap();
            file.set_modified(std::time::SystemTime::now() - age).unwrap();
            file
        };
        let old = 2 * LOCKED_WITHIN;
        let written = left(".sgc-page.html-Aaaaaa.part", old);
        written.lock().unwrap();
        for name in [".sgc-page.html-Bbbbbb.part", ".sgc-other.html-Cccccc.part", ".sgc-page.html-notes"] {
            left(name, old);
        }
        left(".sgc-page.html-Dddddd.part", Duration::ZERO);
        write_whole(&at("page.html"), "").unwrap();
        let mut names = entries(folder.path()).unwrap();
        names.sort_unstable();
        let stays = [
            ".sgc-other.html-Cccccc.part",
            ".sgc-page.html-Aaaaaa.part",
            ".sgc-page.html-Dddddd.part",
            ".sgc-page.html-notes",
            "page.html",
        ];
        assert_eq!(names, stays);
        drop(written);

        // A name may be as long as the system lets it.
        let long = "ä".repeat(125) + ".html";
        write_whole(&at(&long), "").unwrap();
        assert!(at(&long).exists());
    }

    #[test]
    fn of_several_that_make_a_folder_one_does() {
        let parent = tempfile::tempdir().unwrap();
        for (round, is_there) in [false, true].into_iter().cycle().take(40).enumerate() {
            let place = parent.path().join(round.to_string());
            if is_there {
                fs::create_dir(&place).unwrap();
            }
            let start = std::sync::Barrier::new(4);
            let make = |name: &str| {
                start.wait();
                let fill = |path: &Path| write_whole(&path.join(name), name);
                make_folder(&place, None, || Ok(()), fill).is_ok()
            };
            let made = std::thread::scope(|threads| {
                let make = &make;
                let all = ["a", "b", "c", "d"].map(|name| threads.spawn(move || make(name)));
                all.map(|one| one.join().unwrap())
            });
            assert_eq!(made.iter().filter(|made| **made).count(), 1, "{made:?}");
            assert_eq!(entries(&place).unwrap().len(), 1);
        }
    }

    #[test]
    fn a_lock_is_for_one_and_goes_with_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.toml");
        write_whole(&path, "").unwrap();
        assert!(!is_locked(&path));
        let held = lock(&path).unwrap();
        assert!(lock(&path).unwrap_err().to_string().contains("under way"));
        assert!(is_locked(&path));
        drop(held);
        assert!(!is_locked(&path));
        lock(&path).unwrap();
    }
}
