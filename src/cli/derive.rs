//! `sgc derive`: makes a design without simulating it.

use std::path::PathBuf;

use clap::Args;

use super::output::{self, Fault};
use super::{exit, load};
use crate::results::describe;

/// Apply rules at random and print the design, without simulating it
#[derive(Args)]
pub(super) struct Derive {
    /// The grammar
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Set a parameter of the grammar
    #[arg(short, long = "param", value_name = "NAME=VALUE", value_parser = super::assignment)]
    params: Vec<(String, String)>,
    /// The seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many moves to make
    #[arg(long, default_value_t = 20)]
    steps: usize,
}

impl Derive {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let (rules, sources) = load::grammar(&self.file, &self.params)?;
        let text = describe::derived(&rules, self.seed, self.steps)
            .map_err(|e| Fault::input(load::no_value(&e, &sources)))?;
        output::data(&text)?;
        Ok(exit::DONE)
    }
}
