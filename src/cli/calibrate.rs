//! `sgc calibrate`: from a bench's measurements to a variant of a grammar.

use std::path::{Path, PathBuf};

use clap::Args;

use super::exit;
use super::load;
use super::output::{self, Fault};
use super::replace::may_replace;
use super::variant_file;
use crate::calibrate::variant::Named;
use crate::calibrate::{self, Problem};
use crate::loader::read_text;
use crate::reading::imported;
use crate::results::whole::write_whole;

/// Fit measurements from a test bench, and write the fitted values as a variant of a grammar
///
/// sgc also writes a page beside the variant, with a plot of each measurement: points, fit, residuals.
/// docs/calibration.md says what to measure, with which instruments, and how to record it.
#[derive(Args)]
pub(super) struct Calibrate {
    /// A TOML file with a section for each measurement, or a CSV file with a single measurement
    #[arg(value_name = "MEASUREMENTS")]
    measurements: PathBuf,
    /// The grammar that declares the parts that were measured
    #[arg(long = "for", value_name = "GRAMMAR")]
    grammar: PathBuf,
    /// Where to write the variant; the page is written beside it [default: GRAMMAR_bench.sgr beside MEASUREMENTS]
    #[arg(long, value_name = "FILE.sgr")]
    out: Option<PathBuf>,
    /// The name of the variant [default: the name of its file]
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// Replace existing files
    #[arg(long)]
    force: bool,
}

/// Fewer points are fitted before anybody wonders.
const MANY: usize = 500;
/// More points than this are no measurements by hand, and a fit would take hours.
const MOST: usize = 100_000;

impl Calibrate {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let name = self.measurements.to_string_lossy().into_owned();
        let text =
            read_text(&self.measurements).map_err(|e| Fault::usage(format!("cannot read {name}: {e}")))?;
        let out = variant_file::target(&self.grammar, self.out.as_deref(), &self.measurements, "bench")?;
        let page = out.with_extension("html");
        let variant = variant_file::name(&out, self.variant.as_deref())?;
        variant_file::may_write(&[&out, &page], self.force)?;
        let folder = self.measurements.parent().unwrap_or(Path::new(""));
        let beside = |file: &str| {
            let path = folder.join(file);
            // A pipe that another file names would be waited for.
            let text = imported(&path).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
            text.map(|text| (path.to_string_lossy().into_owned(), text))
        };
        let reading = calibrate::read(&name, &text, &beside);
        // Also where the measurements are bad: what is wrong with either is told at once.
        let (rules, sources) = match load::grammar(&self.grammar, &[], None) {
            Err(unsound) if !reading.problems.is_empty() => {
                if !unsound.message.is_empty() {
                    output::note(&format!("error: {}", unsound.message));
                }
                return Err(fault(reading.problems));
            }
            grammar => grammar?,
        };
        let points = reading.points();
        if points > MOST {
            return Err(Fault::usage(format!(
                "{name} has {points} rows, but a fit takes at most {MOST}: keep one row in {}",
                points.div_ceil(MOST)
            )));
        }
        if points > MANY {
            output::note(&format!("fitting {points} points: this may take minutes"));
        }
        let mut findings = calibrate::fit(&reading, &rules).map_err(fault)?;
        calibrate::rename(&mut findings, &|name| {
            sources.iter().any(|(_, source)| has_word(&source.text, name))
        });
        for file in [&out, &page] {
            may_replace(file)?;
        }
        let base = variant_file::from_folder(&self.grammar, &out)?;
        let file = self.measurements.file_name().unwrap_or_default().to_string_lossy();
        let mut worlds = "measured".to_owned();
        while sources.iter().any(|(_, source)| declares(&source.text, &worlds)) {
            worlds.push_str("_worlds");
        }
        let named = Named { variant: &variant, worlds: &worlds };
        let text = calibrate::variant::text(named, &base, &file, &findings);
        variant_file::accepted(&out, &text, "measured")?;
        for warning in findings.iter().flat_map(|finding| &finding.warnings) {
            output::note(&format!("warning: {warning}"));
        }
        // Somebody may have written there in the meantime.
        variant_file::may_write(&[&out, &page], self.force)?;
        write_whole(&page, &calibrate::page::page(&variant, &base, &file, &findings))
            .map_err(Fault::usage)?;
        write_whole(&out, &text).map_err(Fault::usage)?;
        output::data(&calibrate::summary(&findings))?;
        output::note(&format!("wrote {} and {}", out.display(), page.display()));
        output::note(&format!("next: sgc check {0}, then sgc run {0}", output::typed(&out)));
        Ok(exit::DONE)
    }
}

/// Whether a word stands in a text.
fn has_word(text: &str, word: &str) -> bool {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_')).any(|w| w == word)
}

/// Whether a text may declare a name: it stands behind a word on its line, as in `let NAME` or `scenarios NAME`.
fn declares(text: &str, name: &str) -> bool {
    text.lines().any(|line| {
        let mut words =
            line.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| !word.is_empty());
        let first = words.next();
        let begins = |word: &str| word.chars().all(|c| c.is_ascii_lowercase());
        first.is_some_and(begins) && words.take(2).any(|word| word == name)
    })
}

/// Tells everything that is wrong with measurements.
fn fault(problems: Vec<Problem>) -> Fault {
    let code = if problems.iter().all(|p| p.is_contradiction) { exit::INPUT } else { exit::USAGE };
    for problem in &problems {
        output::note(&format!("error: {problem}"));
    }
    Fault { code, message: String::new() }
}
