//! `sgc compile`: prints the typed rule set.

use std::path::PathBuf;

use clap::Args;

use super::output::{self, Fault};
use super::{exit, load};

/// Print the typed rule set of a grammar as JSON, in SI units
#[derive(Args)]
pub(super) struct Compile {
    /// The grammar
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Set a parameter of the grammar
    #[arg(short, long = "param", value_name = "NAME=VALUE", value_parser = super::assignment)]
    params: Vec<(String, String)>,
    /// The variant, where the file declares several
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
}

impl Compile {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let (rules, _) = load::grammar(&self.file, &self.params, self.variant.as_deref())?;
        let text = serde_json::to_string_pretty(&rules).map_err(|e| Fault::usage(e.to_string()))?;
        output::data(&(text + "\n"))?;
        Ok(exit::DONE)
    }
}
