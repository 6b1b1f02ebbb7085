//! `sgc` turns spatial grammars into soft robots that move.

pub mod design;
pub mod simulate;
pub mod world;
