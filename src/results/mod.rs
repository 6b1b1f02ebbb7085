//! Results: the run folder, the saved design, the viewer's page.

pub mod archive;
pub mod beginning;
pub mod checkpoint;
pub mod closely;
mod columns;
pub mod describe;
mod design_error;
mod edited;
pub mod elsewhere;
mod evals;
mod file_error;
pub mod folder;
pub mod front;
pub mod gait;
pub mod genuine;
pub mod leftovers;
pub mod making;
pub mod names;
pub mod novelty;
pub mod picture;
pub mod place;
pub mod processes;
pub mod replay;
pub mod report;
pub mod robustness;
pub mod run_files;
pub mod saved;
pub mod saving;
pub mod seal;
pub mod series;
pub mod summary;
mod unambiguous;
pub mod view;
pub mod whole;

pub use design_error::DesignError;
pub use file_error::{Damage, FileError, Unfit, Unwritable};
