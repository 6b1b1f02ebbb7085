//! Results: the run folder, the saved design, the viewer's page.

pub mod archive;
pub mod beginning;
pub mod checkpoint;
pub mod describe;
mod evals;
pub mod folder;
pub mod gait;
pub mod judge;
pub mod leftovers;
pub mod making;
pub mod names;
pub mod novelty;
pub mod picture;
pub mod report;
pub mod saved;
pub mod series;
pub mod sittings;
pub mod view;
pub mod whole;
