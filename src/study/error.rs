//! What is wrong with a study.

use std::path::PathBuf;

use thiserror::Error;

use crate::results::FileError;

/// Why a study cannot be begun, read or gone on with. Each is a sentence that names the place.
#[derive(Debug, Error)]
pub enum StudyError {
    /// A file or folder of it.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is no TOML, or has fields that no study has.
    #[error("cannot read the study {}:\n{why}", path.display())]
    NotStudy {
        /// The file.
        path: PathBuf,
        /// Where, and what.
        why: String,
    },
    /// The file can be read, but asks for something that cannot be.
    #[error("{}: {why}", path.display())]
    Wrong {
        /// The file.
        path: PathBuf,
        /// What, and what to write instead.
        why: String,
    },
    /// A folder without a study.
    #[error("{} is not the folder of a study: it has no plan.json; `sgc study FILE.toml` makes one", path.display())]
    NoStudy {
        /// The folder.
        path: PathBuf,
    },
    /// The file of a study where its folder is asked for.
    #[error("{} is a file: name the folder of the study, studies/NAME unless --out said another", path.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
    },
    /// The plan was changed by hand, or only half of it is there.
    #[error("{} is damaged: {why}. Put a copy of it back, or begin anew with --out; the runs in `runs/` are intact, and sgc report reads each", path.display())]
    Damaged {
        /// The plan.
        path: PathBuf,
        /// What is wrong.
        why: String,
    },
    /// Another program would go on in another way.
    #[error("the study in {} was begun by sgc {theirs}; this is {}. One study needs one version: use that version, or begin anew with --out", path.display(), env!("CARGO_PKG_VERSION"))]
    OtherVersion {
        /// The folder.
        path: PathBuf,
        /// The version that began it.
        theirs: String,
    },
    /// A grammar, or what it is run with, was changed since the study began.
    #[error(
        "`{cell}` has changed since the study in {} began: {what}. Its runs could not be compared: undo the change, or begin anew with --out",
        path.display()
    )]
    OtherCell {
        /// The folder.
        path: PathBuf,
        /// The cell.
        cell: String,
        /// What was changed.
        what: String,
    },
    /// A run of before that the plan knows again, but with another grammar.
    #[error(
        "{} is an earlier run with another text of its grammar, so it could not be compared: move it away, restore the grammar, or begin anew \
         with --out",
        path.display()
    )]
    OtherRun {
        /// Its folder.
        path: PathBuf,
    },
    /// The study of another file.
    #[error("{} is the folder of another study, that of {theirs}; choose another folder with --out", path.display())]
    OtherFile {
        /// The folder.
        path: PathBuf,
        /// The file that it is of.
        theirs: String,
    },
    /// Somebody edited the copy of the file.
    #[error("{} was changed since sgc wrote it, and would be replaced: it is only a copy. Change the file of the study instead, and move this one away", path.display())]
    Edited {
        /// The copy.
        path: PathBuf,
    },
    /// A folder with something else in it.
    #[error("{} contains \"{foreign}\", but no study; choose another folder with --out", path.display())]
    Foreign {
        /// The folder.
        path: PathBuf,
        /// Something in it.
        foreign: String,
    },
    /// Its path cannot be written into a script.
    #[error(
        "{path:?}: a script's options cannot hold a path with a quote, a line break or another control character; move the study elsewhere"
    )]
    NoScript {
        /// The folder.
        path: PathBuf,
    },
    /// Two cells that are the same, under two names.
    #[error("{}: `{one}` and `{other}` are the same; leave one of their values out", path.display())]
    Alike {
        /// The file.
        path: PathBuf,
        /// A cell.
        one: String,
        /// Another.
        other: String,
    },
    /// Values in several units, or of objectives with opposite directions.
    #[error("`{one}` {how}, and `{other}` {otherwise}: they cannot be compared in one study")]
    Incomparable {
        /// A cell.
        one: String,
        /// What it does.
        how: String,
        /// Another cell.
        other: String,
        /// What that does.
        otherwise: String,
    },
}
