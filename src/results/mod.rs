//! Results: the run folder, the saved design, the viewer's page.

pub mod describe;
pub mod folder;
pub mod judge;
pub mod picture;
pub mod saved;
pub mod view;
