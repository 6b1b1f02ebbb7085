//! All tests that need more than one layer: one binary, so that it links once.

mod architecture;
mod cases;
mod command_line;
mod derivation;
mod docs;
mod grammars;
mod library;
mod search;
mod support;
