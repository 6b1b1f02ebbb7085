//! Grammars that nobody would write: real ones, mutated, and what must hold of them all the same.
//!
//! The tests try some of them; `cargo run --release --example fuzz` tries as many as there is time for.

// Two programs share it.
#![allow(unreachable_pub)]

pub mod corpus;
pub mod holds;
pub mod mutate;
