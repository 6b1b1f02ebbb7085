//! Why a file or folder of a run cannot be used.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::DesignError;

/// Why a file or folder cannot be used. Each is a sentence that names it.
#[derive(Debug, Error)]
pub enum FileError {
    /// The system does not let it be read, or it is no text.
    #[error("cannot read {}: {why}", path.display())]
    Read {
        /// Which.
        path: PathBuf,
        /// The system's reason.
        why: io::Error,
    },
    /// The system does not let it be written.
    #[error("cannot write {}: {why}", path.display())]
    Write {
        /// Which.
        path: PathBuf,
        /// The reason.
        why: Unwritable,
    },
    /// The system does not let it be removed.
    #[error("cannot remove {}: {why}", path.display())]
    Remove {
        /// Which.
        path: PathBuf,
        /// The system's reason.
        why: io::Error,
    },
    /// It can be read, but does not say what such a file says.
    #[error("{} is damaged: {why}", path.display())]
    Damaged {
        /// Which.
        path: PathBuf,
        /// What is wrong with it.
        why: Damage,
    },
    /// It is whole, but cannot be used for what was asked.
    #[error("{} {why}", path.display())]
    Unfit {
        /// Which.
        path: PathBuf,
        /// Why not.
        why: Unfit,
    },
    /// Another process writes to it.
    #[error("a run is under way in {}: another process holds it", folder.display())]
    UnderWay {
        /// Which.
        folder: PathBuf,
    },
    /// Another folder has its name now.
    #[error("{} is not the folder of this run any more: it was moved or replaced while the run went on; nothing more is written", folder.display())]
    Elsewhere {
        /// The name.
        folder: PathBuf,
    },
    /// There is nothing more to do.
    #[error("the run in {} is complete", folder.display())]
    Complete {
        /// Where.
        folder: PathBuf,
    },
    /// What its grammar comes to is not what was saved.
    #[error("{}: {why}", path.display())]
    Inside {
        /// Which.
        path: PathBuf,
        /// What is wrong with the design or grammar in it.
        why: DesignError,
    },
}

/// Why something cannot be written.
#[derive(Debug, Error)]
pub enum Unwritable {
    /// The system's reason.
    #[error(transparent)]
    System(#[from] io::Error),
    /// It may only be read.
    #[error("it is read-only")]
    ReadOnly,
    /// It is a way to a file that this process has been given open.
    #[error(
        "it stands for a file that is open already; write `-` for standard input, and say with `>` where the result goes"
    )]
    Open,
    /// It has several names: a new file in its place would be the content of one of them only.
    #[error(
        "it has other names, too (hard links), which would keep the old text: write `-` for standard input, and say with `>` where the result goes"
    )]
    Linked,
    /// It is a device, a pipe or a folder.
    #[error("it is not a regular file")]
    NotRegular,
    /// Its folder is missing.
    #[error("there is no folder {}: make it first, or choose another place", folder.display())]
    NoFolder {
        /// The folder that it should be in.
        folder: PathBuf,
    },
    /// A folder cannot be made here.
    #[error("{0}; choose another place with --out")]
    NoPlace(io::Error),
    /// A run goes on where it can write.
    #[error(
        "{0}; a run goes on only where it can write: copy its folder to such a place, and resume the copy"
    )]
    NoSession(io::Error),
    /// What it should say cannot be written as TOML.
    #[error(transparent)]
    Toml(#[from] toml::ser::Error),
    /// What it should say cannot be written as JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

/// What is wrong with the contents of a file.
#[derive(Debug, Error)]
pub enum Damage {
    /// It is not JSON, or lacks something.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// It is not TOML, or lacks something.
    #[error(transparent)]
    Toml(#[from] toml::de::Error),
    /// It was changed.
    #[error("its contents do not fit its checksum")]
    Sum,
}

/// Why something that is whole cannot be used; the path stands before it.
#[derive(Debug, Error)]
pub enum Unfit {
    /// It would be overwritten.
    #[error("exists already; choose another folder with --out, another --seed, or replace it with --force")]
    Exists,
    /// There is something in it that no run wrote.
    #[error(
        "is not only a run folder: \"{foreign}\" in it was not written by a run; --force replaces only run folders"
    )]
    NotOnlyRun {
        /// Its name.
        foreign: String,
    },
    /// Somebody changed it, and it would be removed.
    #[error(
        "was changed since the run wrote it, and --force would remove it: move it elsewhere, or choose another folder with --out"
    )]
    Touched,
    /// Somebody put it there, and it would be removed.
    #[error("is a design of another run, and would be removed with this one: move it elsewhere")]
    OtherRunsDesign,
    /// What is to be run is in the folder that the run would replace.
    #[error(
        "holds {file}, which this run was made of: --force would remove it; copy it elsewhere, or choose another place with --out"
    )]
    HoldsGrammar {
        /// The file.
        file: String,
    },
    /// There is something in it that the runs did not write.
    #[error(
        "is not only a folder of runs: \"{foreign}\" in it was not written by them; --force replaces only such folders"
    )]
    NotOnlyRuns {
        /// Its name.
        foreign: String,
    },
    /// The process that was to replace it was killed.
    #[error(
        "is not there: the process that was to replace it was killed. The older run is intact: rename {} back",
        older.display()
    )]
    MovedAway {
        /// Where the older run is.
        older: PathBuf,
    },
    /// A line of a table is none.
    #[error("is damaged: line {line} is no row of {table}; restore it, or remove it")]
    NoRow {
        /// From 1 on.
        line: usize,
        /// What such a table is called.
        table: &'static str,
    },
    /// There is no run in it.
    #[error("is not a run folder: it has no {file}")]
    NoRun {
        /// What is missing.
        file: &'static str,
    },
    /// There is nothing to go on from.
    #[error("has no checkpoint to go on from: begin anew with sgc run --force")]
    NoCheckpoint,
    /// Another file than a checkpoint.
    #[error("is not a checkpoint")]
    NotCheckpoint,
    /// Another program would go on in another way.
    #[error("was written by sgc {theirs}; this is {}, which would not go on in the same way: use that version, or begin anew", env!("CARGO_PKG_VERSION"))]
    OtherProgram {
        /// The version that wrote it.
        theirs: String,
    },
    /// Another form than this program writes, though it says that it is of this program.
    #[error(
        "is not in format {wanted}, which this version of sgc writes: another build wrote it, or it was changed; use that build, or begin anew"
    )]
    OtherFormat {
        /// The format of this program.
        wanted: u32,
    },
    /// Not the best design of this run.
    #[error(
        "does not belong to this run, which would overwrite it: move it away, and the run goes on ({why})"
    )]
    NotOwn {
        /// What is wrong with it.
        why: String,
    },
    /// A run in the folder of another seed.
    #[error("holds a run of seed {seed}: the folder was copied or renamed; restore it")]
    OtherSeed {
        /// That of the run.
        seed: u64,
    },
    /// A result that is not of what was asked.
    #[error(
        "belongs to grammar {grammar} and seed {seed}, but run.toml beside it names others: one of them was changed; restore it, or leave this run out of the report"
    )]
    OtherAsked {
        /// The grammar of the result.
        grammar: String,
        /// Its seed.
        seed: u64,
    },
    /// Somebody removed, replaced or changed the table while its run went on.
    #[error(
        "was removed, replaced or changed while the run went on: put it back as it was, and go on with sgc resume; without its rows, begin anew"
    )]
    TakenAway,
    /// What the run was asked was changed after it had ended.
    #[error("was changed after the run had ended: restore it, or leave this run out")]
    OtherRun,
    /// A link where a run keeps a file or folder of its own: what it leads to is not the run's.
    #[error("is a link, and a run does not write through links: put the file or folder itself in its place")]
    Link,
    /// The table of moves was changed after the run had ended.
    #[error(
        "was changed after the run ended: it is not the table that result.json counts; restore it, or leave this run out of the report"
    )]
    OtherTable,
    /// What the run was asked was changed.
    #[error("was changed after the run began: a run goes on only as it was asked")]
    OtherOrder,
    /// A frozen text was changed.
    #[error("was changed after the run began: a run goes on only with the grammar that it began with")]
    OtherText,
    /// The table of moves was changed.
    #[error("was changed: it does not begin with the rows that the checkpoint counts")]
    OtherRows,
    /// A grammar, where a design is asked.
    #[error(
        "is a grammar, not a saved design: `sgc run` grows designs from it, into a folder that this command reads"
    )]
    Grammar,
    /// Not JSON, where a design is asked.
    #[error("is not a saved design: {0}")]
    NotJson(serde_json::Error),
    /// Another JSON file, where a design is asked.
    #[error("is not a saved design: it lacks \"format\": \"{format}\"")]
    NoDesign {
        /// What its format should be.
        format: &'static str,
    },
    /// Another version of the format of designs.
    #[error("has {theirs} of the file format; this sgc reads version {own}")]
    OtherVersion {
        /// Its version.
        theirs: String,
        /// The version that is read.
        own: u32,
    },
    /// A run of another grammar than that beside it.
    #[error(
        "is a run of {grammar} with other rules than {}, which is beside it: they are not runs of one grammar; move it \
         out of this folder",
        first.display()
    )]
    OtherRules {
        /// Its grammar.
        grammar: String,
        /// The first run of the folder.
        first: PathBuf,
    },
    /// A design that somebody edited.
    #[error(
        "was changed after it was saved: it does not fit its checksum, and is not the result of a search"
    )]
    Edited,
}

impl FileError {
    /// What cannot be read.
    pub(crate) fn read(path: &Path) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |why| Self::Read { path, why }
    }

    /// What cannot be written.
    pub(crate) fn write<E: Into<Unwritable>>(path: &Path) -> impl FnOnce(E) -> Self + use<E> {
        let path = path.to_owned();
        move |why| Self::Write { path, why: why.into() }
    }

    /// What cannot be removed.
    pub(crate) fn remove(path: &Path) -> impl FnOnce(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |why| Self::Remove { path, why }
    }

    /// What is damaged.
    pub(super) fn damaged<E: Into<Damage>>(path: &Path) -> impl FnOnce(E) -> Self + use<E> {
        let path = path.to_owned();
        move |why| Self::Damaged { path, why: why.into() }
    }

    /// What is whole, but of no use.
    pub(super) fn unfit(path: &Path, why: Unfit) -> Self {
        Self::Unfit { path: path.to_owned(), why }
    }

    /// What is wrong within a file.
    pub(crate) fn inside<E: Into<DesignError>>(path: &Path) -> impl FnOnce(E) -> Self + use<E> {
        let path = path.to_owned();
        move |why| Self::Inside { path, why: why.into() }
    }
}
