//! `sgc fit`: from materials and chambers to the hinges that stand for them.

use std::path::PathBuf;

use clap::Args;
use grammar_lang::units::{Dimension, shown};

use super::exit;
use super::load;
use super::output::{self, Fault};
use super::replace::may_replace;
use super::variant_file;
use crate::fit;
use crate::results::whole::write_whole;

/// Compute stiffness, torque and bend of actuators from their material, and write them as a variant of a grammar
///
/// Actuators that name their `material` are computed with static finite elements: free, held straight, and bent sideways. Those with a
/// `chamber` or a `thread` also get their torque and bend. docs/materials.md says what is assumed.
#[derive(Args)]
pub(super) struct Fit {
    /// The grammar with the actuators
    #[arg(value_name = "GRAMMAR")]
    grammar: PathBuf,
    /// Where to write the variant [default: GRAMMAR_fitted.sgr beside GRAMMAR]
    #[arg(long, value_name = "FILE.sgr")]
    out: Option<PathBuf>,
    /// The name of the variant [default: the name of its file]
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// Replace an existing file
    #[arg(long)]
    force: bool,
}

impl Fit {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let out = variant_file::target(&self.grammar, self.out.as_deref(), &self.grammar, "fitted")?;
        let name = variant_file::name(&out, self.variant.as_deref())?;
        variant_file::may_write(&[&out], self.force)?;
        let (rules, _) = load::grammar(&self.grammar, &[], None)?;
        let kinds = fit::kinds(&rules);
        if kinds.is_empty() {
            return Err(Fault::input(
                "no actuator that this grammar uses says what it is made of: add a line such as \
                 `material = dragon_skin_30` to it, and `use std.materials { dragon_skin_30 }` to the grammar"
                    .to_owned(),
            ));
        }
        may_replace(&out)?;
        let base = variant_file::from_folder(&self.grammar, &out)?;
        let mut fitted = Vec::with_capacity(kinds.len());
        for kind in kinds {
            let lengths: Vec<String> =
                kind.counts.iter().map(|count| shown(kind.length(*count), Dimension::LENGTH)).collect();
            output::note(&format!(
                "`{}`: computing a length of {}; this takes from seconds to minutes",
                kind.name,
                lengths.join(", then ")
            ));
            let done = |length: f64| {
                output::note(&format!("`{}`: {} done", kind.name, shown(length, Dimension::LENGTH)))
            };
            let found = kind.fit(&done).map_err(|e| Fault::input(e.to_string()))?;
            fitted.push((kind, found));
        }
        let text = fit::variant(&name, &base, &fitted);
        variant_file::accepted(&out, &text, "fitted")?;
        // Somebody may have written there in the meantime.
        variant_file::may_write(&[&out], self.force)?;
        write_whole(&out, &text).map_err(Fault::usage)?;
        output::data(&fit::summary(&fitted))?;
        output::note(&format!("wrote {}", out.display()));
        output::note(&format!("next: sgc check {0}, then sgc run {0}", output::typed(&out)));
        Ok(exit::DONE)
    }
}
