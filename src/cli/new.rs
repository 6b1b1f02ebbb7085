//! `sgc new`: begins a grammar from a template.

use std::fs;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::exit;
use super::output::{self, Fault};
use super::replace::may_replace;
use crate::document::is_name;
use crate::results::whole::write_whole;

/// Start a grammar: write NAME.sgr from a template
#[derive(Args)]
pub(super) struct New {
    /// The name of the grammar, and of its file without `.sgr`
    #[arg(value_name = "NAME")]
    name: String,
    /// The template to start from
    #[arg(long, value_enum, value_name = "TEMPLATE", default_value = "walker")]
    from: Template,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Template {
    /// Cubes and balls on bending actuators, with mirror symmetry
    Walker,
    /// Bending actuators one after another, with cubes between them
    Worm,
}

/// What a template calls its grammar.
const PLACEHOLDER: &str = "NAME";

impl Template {
    fn text(self) -> &'static str {
        match self {
            Self::Walker => include_str!("templates/walker.sgr"),
            Self::Worm => include_str!("templates/worm.sgr"),
        }
    }
}

/// A name near to one that cannot be: without folder and ending, other signs as `_`.
fn suggestion(name: &str) -> Option<String> {
    let last = name.rsplit(['/', '\\']).find(|part| !part.is_empty())?;
    let stem = last.strip_suffix(".sgr").unwrap_or(last);
    let plain: String = stem.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    let plain = Some(plain.trim_matches('_')).filter(|p| !p.is_empty())?;
    [plain.to_owned(), format!("my_{plain}")].into_iter().find(|candidate| is_name(candidate))
}

impl New {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let name = &self.name;
        if !is_name(name) {
            let help = suggestion(name).map_or_else(String::new, |s| format!("; try `sgc new {s}`"));
            return Err(Fault::usage(format!(
                "`{name}` cannot name a grammar: a name is a word of letters, digits and `_` that does not \
                 begin with a digit and is not reserved{help}"
            )));
        }
        let path = PathBuf::from(format!("{name}.sgr"));
        // A link that leads nowhere is there, too.
        if !self.force && fs::symlink_metadata(&path).is_ok() {
            return Err(Fault::usage(format!(
                "{} exists already; choose another name, or replace it with --force",
                path.display()
            )));
        }
        may_replace(&path)?;
        write_whole(&path, &self.from.text().replace(PLACEHOLDER, name)).map_err(Fault::usage)?;
        output::data(&format!("{}\n", path.display()))?;
        output::note(&format!(
            "change it as you like, then:\n  sgc check {name}.sgr    says what is wrong with it\n  \
             sgc run {name}.sgr      searches for a good robot"
        ));
        Ok(exit::DONE)
    }
}
