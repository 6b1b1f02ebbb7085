//! `sgc test`: derives the examples of grammars and checks what they expect.

use std::path::{Path, PathBuf};

use clap::Args;
use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::diagnostics::render::{Format, render};

use super::output::{self, Fault};
use super::{exit, load};
use crate::derive::run_example;
use crate::loader::Files;

/// Derive the examples of grammars and check what they expect
#[derive(Args)]
pub(super) struct Test {
    /// The grammars
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Test only the examples whose names contain this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Set a parameter of the grammars
    #[arg(short, long = "param", value_name = "NAME=VALUE", value_parser = super::assignment)]
    params: Vec<(String, String)>,
    /// Only this variant, if a file declares several
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
}

/// How many examples held, and how many failed.
#[derive(Default)]
struct Tally {
    passed: usize,
    failed: usize,
    code: u8,
    /// Examples that are there, whatever they are called.
    there: usize,
}

impl Test {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let mut tally = Tally::default();
        for file in &self.files {
            // The other files are tested all the same; the worst exit code counts.
            if let Err(fault) = self.file(file, &mut tally) {
                if !fault.message.is_empty() {
                    output::note(&format!("error: {}", fault.message));
                }
                tally.code = tally.code.max(fault.code);
            }
        }
        let Tally { passed, failed, mut code, there } = tally;
        if self.only.is_some() && passed + failed == 0 && there > 0 {
            code = code.max(exit::INPUT);
        }
        // What has errors was not tested, and that has been told.
        if code == exit::DONE || passed + failed > 0 {
            output::note(&format!("{passed} passed, {failed} failed"));
        }
        Ok(if failed > 0 { code.max(exit::INPUT) } else { code })
    }

    /// Tests the grammar of a file and each of its variants.
    fn file(&self, file: &Path, tally: &mut Tally) -> Result<(), Fault> {
        // A pipe is read once.
        let text = load::read(file)?;
        let offers = match &self.variant {
            Some(variant) => vec![variant.clone()],
            None => {
                let checked = load::check(&Files, &text.name, &text.text, &self.params, None);
                if !checked.is_grammar && !checked.diagnostics.iter().any(Diagnostic::is_error) {
                    output::note(&format!(
                        "{}: a module; examples are those of a grammar (`grammar NAME`)",
                        file.display()
                    ));
                    return Ok(());
                }
                checked.offers
            }
        };
        let named = offers.len() > 1 || self.variant.is_some();
        let wanted: Vec<Option<&str>> =
            if named { offers.iter().map(|o| Some(o.as_str())).collect() } else { vec![None] };
        let mut any = false;
        let mut left_out = 0;
        for wanted in wanted {
            let (rules, sources) =
                load::grammar_of(&text, &self.params, wanted, ", so there is nothing to test")?;
            left_out += rules.examples.len();
            tally.there += rules.examples.len();
            let named = |name: &str| self.only.as_ref().is_none_or(|text| name.contains(text));
            for (name, example) in rules.examples.iter().filter(|(name, _)| named(name)) {
                any = true;
                match run_example(&rules, name, example) {
                    Ok(made) => {
                        let (steps, parts) = (made.steps.len(), made.design.parts.len());
                        output::data(&format!(
                            "ok      {}.{name}: {}, {}\n",
                            rules.name,
                            output::counted(steps, "step"),
                            output::counted(parts, "part")
                        ))?;
                        tally.passed += 1;
                    }
                    Err(failure) => {
                        output::data(&format!("failed  {}.{name}\n", rules.name))?;
                        output::data(&render(&[*failure], &sources, Format::Full, output::colour_out()))?;
                        tally.failed += 1;
                    }
                }
            }
        }
        if !any {
            let what = if left_out > 0 { "no example has this name" } else { "no examples" };
            output::note(&format!("{}: {what}", file.display()));
        }
        Ok(())
    }
}
