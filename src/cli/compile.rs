//! `sgc compile`: prints the typed rule set.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use grammar_lang::ir::resolved;

use super::output::{self, Fault};
use super::{exit, load};

/// Print a grammar with its variants, imports and parameters resolved
#[derive(Args)]
pub(super) struct Compile {
    /// The grammar
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Set a parameter of the grammar
    #[arg(short, long = "param", value_name = "NAME=VALUE", value_parser = super::assignment)]
    params: Vec<(String, String)>,
    /// The output format
    #[arg(long, value_enum, default_value = "ir")]
    emit: Emit,
    /// The variant to use, if the file declares several
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Emit {
    /// The typed rule set as JSON, in SI units
    Ir,
    /// Text for people, similar to a grammar file
    Resolved,
}

impl Compile {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let (rules, _) = load::grammar(&self.file, &self.params, self.variant.as_deref())?;
        let text = match self.emit {
            Emit::Ir => serde_json::to_string_pretty(&rules).map_err(|e| Fault::usage(e.to_string()))? + "\n",
            Emit::Resolved => resolved(&rules),
        };
        output::data(&text)?;
        Ok(exit::DONE)
    }
}
