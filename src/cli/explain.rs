//! `sgc explain`: the page of a finding.

use clap::Args;
use grammar_lang::diagnostics::{CODES, did_you_mean, find};

use super::exit;
use super::output::{self, Fault};

/// Explain a finding: what it means, an example, and how to avoid it
#[derive(Args)]
pub(super) struct Explain {
    /// The code or name of the finding, such as E0301 or wrong-dimension; without it, all findings are listed
    #[arg(value_name = "CODE|NAME")]
    finding: Option<String>,
    /// List all findings
    #[arg(long, conflicts_with = "finding")]
    list: bool,
}

impl Explain {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let text = match &self.finding {
            Some(finding) => page(finding)?.to_owned(),
            None => list(),
        };
        output::data(&text)?;
        Ok(exit::DONE)
    }
}

fn page(finding: &str) -> Result<&'static str, Fault> {
    if let Some(code) = find(finding) {
        return Ok(code.page);
    }
    let known = CODES.iter().flat_map(|c| [c.id, c.name]);
    let meant = did_you_mean(finding, known).map_or(String::new(), |m| format!("; {m}"));
    Err(Fault::usage(format!("there is no finding `{finding}`{meant} (`sgc explain --list` lists all)")))
}

fn list() -> String {
    let width = CODES.iter().map(|c| c.name.len()).max().unwrap_or(0);
    CODES.iter().map(|c| format!("{}  {:width$}  {}\n", c.id, c.name, c.title())).collect()
}
