//! The design: what a rule set makes and a model simulates.

pub mod assembly;
