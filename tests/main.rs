//! All tests that need more than one layer: one binary, so that it links once.

// Helpers of tests fail the test that calls them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod architecture;
mod at_rest;
mod audit;
mod body_values;
mod browser;
mod calibrate;
mod cases;
mod catalogue;
mod checking;
mod command_line;
mod derivation;
mod docs;
mod drive;
mod features;
mod files;
mod fit;
mod format;
mod fronts;
mod fuzz;
mod gait_motions;
mod gaits;
mod grammars;
mod hostile;
mod ice;
mod joints;
mod lattice;
mod library;
mod mending;
mod mirrored;
mod new;
mod novelty;
mod observed;
mod parameters;
mod phases;
mod policies;
mod report;
mod resume;
mod rhythms;
mod rig;
mod rods;
mod runs;
mod saved_designs;
mod scenarios;
mod search;
mod sensors;
mod states;
mod stops;
mod study;
mod support;
mod tutorial;
mod verdicts;
mod view;
mod worlds;
