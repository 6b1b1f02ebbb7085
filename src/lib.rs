//! `sgc` turns spatial grammars into soft robots that move.

pub mod audit;
pub mod calibrate;
pub mod cli;
pub mod deep;
pub mod derive;
pub mod design;
pub mod document;
pub mod drive;
pub mod fit;
pub mod hardware;
pub mod learn;
pub mod loader;
mod markup;
pub mod reading;
pub mod results;
pub mod scenarios;
pub mod score;
pub mod search;
pub mod simulate;
pub mod solid;
pub mod study;
pub mod testing;
pub mod trials;
