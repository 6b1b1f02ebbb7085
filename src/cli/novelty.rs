//! `sgc novelty`: how few of a set of known designs share the features of a design.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use grammar_lang::diagnostics::did_you_mean;
use grammar_lang::ir::{self, RuleSet};

use super::design::{self, Opened};
use super::output::{self, Fault};
use super::{exit, load};
use crate::results::novelty::{self, Member};

/// Score the novelty of designs against a set of known designs
///
/// The set is the `novelty` declaration of a grammar: FILE.sgr, --grammar FILE, or the grammar that made the
/// designs. The designs on the command line belong to the set, too. Without designs, sgc scores the known
/// ones.
#[derive(Args)]
pub(super) struct Novelty {
    /// A grammar (.sgr) that names the set; saved designs, or run folders that hold them
    #[arg(value_name = "GRAMMAR|DESIGN", required_unless_present = "grammar")]
    paths: Vec<PathBuf>,
    /// Evaluate all designs with this grammar and its set, not with the grammars that made them
    #[arg(long, value_name = "FILE")]
    grammar: Option<PathBuf>,
    /// The variant of that grammar
    #[arg(long, value_name = "NAME")]
    variant: Option<String>,
    /// The novelty set to use, if the grammar has several
    #[arg(long, value_name = "NAME")]
    set: Option<String>,
    /// How to write it
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// How scores are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A table for people
    Text,
    /// Comma-separated values: a row for each feature of each design
    Csv,
    /// One JSON document
    Json,
}

impl Novelty {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let is_grammar = |path: &PathBuf| path.extension().is_some_and(|e| e == "sgr");
        let (mut grammars, designs): (Vec<PathBuf>, Vec<PathBuf>) =
            self.paths.iter().cloned().partition(is_grammar);
        grammars.extend(self.grammar.clone());
        if let [_, second, ..] = grammars.as_slice() {
            return Err(Fault::usage(format!(
                "only one grammar can give the novelty set, but {} is a second grammar: name one",
                second.display()
            )));
        }
        let grammar = grammars.pop();
        if grammar.is_none() && self.variant.is_some() {
            return Err(Fault::usage("--variant names a variant of a grammar: name that, too"));
        }
        // One file may have several paths.
        let place = |path: &PathBuf| {
            let file = design::file(path);
            std::fs::canonicalize(&file).unwrap_or(file)
        };
        // A copy is the same design, too.
        let texts: Vec<Option<Vec<u8>>> =
            designs.iter().map(|path| std::fs::read(design::file(path)).ok()).collect();
        let twice = |(number, path): &(usize, &PathBuf)| {
            let own = texts.get(*number);
            let mut before = designs.iter().zip(&texts).take(*number);
            before.any(|(other, text)| place(other) == place(path) || text.is_some() && own == Some(text))
        };
        if let Some((_, path)) = designs.iter().enumerate().find(twice) {
            let name = path.display();
            return Err(Fault::usage(format!(
                "{name} is named twice, or is a copy of another one: name each design once"
            )));
        }
        // The set is that of the grammar that is named, or of the first design.
        let mut found: Option<(RuleSet, ir::Novelty)> = match &grammar {
            Some(file) => {
                let rules = load::grammar(file, &[], self.variant.as_deref())?.0;
                let set = self.set_of(&rules)?;
                Some((rules, set))
            }
            None => None,
        };
        let mut others: Vec<(String, Vec<f64>)> = Vec::new();
        for path in &designs {
            let name = path.display().to_string();
            let file = design::file(path);
            let opened = design::open_by(&file, grammar.as_deref(), &[], self.variant.as_deref())?;
            let Opened { design, rules, .. } = opened;
            let set = self.set_of(&rules)?;
            let (_, first) = found.get_or_insert_with(|| (rules.clone(), set.clone()));
            if !same(first, &set) {
                return Err(Fault::input(format!(
                    "{name} was made by the grammar `{}`, which has another novelty set: judge all designs by one grammar with --grammar FILE",
                    design.grammar.name
                )));
            }
            if rules.name != design.grammar.name {
                output::note(&format!(
                    "{name} was made by `{}`: here it is simulated with the model, the time and the target of `{}`",
                    design.grammar.name, rules.name
                ));
            }
            let values = novelty::features(&rules, &set, &design)
                .map_err(|why| Fault::input(format!("{}: {why}", file.display())))?;
            others.push((name, values));
        }
        let Some((rules, set)) = found else {
            return Err(Fault::usage("name a grammar, or saved designs"));
        };
        let members = novelty::scores(&rules, &set, &others);
        output::data(&match self.format {
            Format::Text => text(&members),
            Format::Csv => csv(&members),
            Format::Json => json(&members),
        })?;
        Ok(exit::DONE)
    }

    /// The set that is asked for, or the only one.
    fn set_of(&self, rules: &RuleSet) -> Result<ir::Novelty, Fault> {
        let grammar = &rules.name;
        let names: Vec<&str> = rules.novelties.keys().map(String::as_str).collect();
        if names.is_empty() {
            return Err(Fault::input(format!(
                "the grammar `{grammar}` has no novelty set: import one, as in `use std.novelty {{ literature }}`, or judge by a grammar that has one with --grammar FILE"
            )));
        }
        let all = names.join(", ");
        match (&self.set, names.as_slice()) {
            (Some(wanted), _) => rules.novelties.get(wanted).cloned().ok_or_else(|| {
                let help = did_you_mean(wanted, names.iter().copied());
                let help = help.unwrap_or_else(|| format!("it has: {all}"));
                Fault::usage(format!("the grammar `{grammar}` has no novelty set `{wanted}`: {help}"))
            }),
            (None, [only]) => Ok(rules.novelties[*only].clone()),
            (None, _) => Err(Fault::usage(format!(
                "the grammar `{grammar}` has several novelty sets: name one with --set ({all})"
            ))),
        }
    }
}

/// Whether two sets hold the same, wherever they are declared.
fn same(one: &ir::Novelty, other: &ir::Novelty) -> bool {
    let plain = |set: &ir::Novelty| {
        let features = set.features.iter().map(|(name, f)| (name.clone(), f.ty.clone(), f.weight));
        (features.collect::<Vec<_>>(), set.known.clone())
    };
    plain(one) == plain(other)
}

/// A table: a row for each design; of each feature what it is, and what it contributes.
fn text(members: &[Member]) -> String {
    let Some(first) = members.first() else { return "the set is empty\n".to_owned() };
    let mut rows: Vec<Vec<String>> = Vec::new();
    let heads = first.features.iter().map(|share| share.feature.clone());
    rows.push(["".to_owned()].into_iter().chain(heads).chain(["novelty".to_owned()]).collect());
    for member in members {
        let shares = member.features.iter().map(|share| format!("{} {:.1}", share.value, share.score));
        let score = format!("{:.1}", member.score);
        rows.push([member.name.clone()].into_iter().chain(shares).chain([score]).collect());
    }
    let widths: Vec<usize> = (0..first.features.len() + 2)
        .map(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0))
        .collect();
    let last = widths.len() - 1;
    let mut out = String::new();
    for row in &rows {
        let cells: Vec<String> = row
            .iter()
            .zip(&widths)
            .enumerate()
            .map(|(column, (cell, width))| match column {
                _ if column == last => format!("{cell:>width$}"),
                _ => format!("{cell:<width$}"),
            })
            .collect();
        out += &format!("{}\n", cells.join("  "));
    }
    let line = |what: &str, mean: Option<f64>| mean.map_or(String::new(), |m| format!("{what} {m:.1}\n"));
    let designs = if members.len() == 1 { "design" } else { "designs" };
    out += &format!("{} {designs} in the set\n", members.len());
    out += &line("mean of the known", novelty::mean(members.iter().filter(|m| m.known)));
    out + &line("mean of the others", novelty::mean(members.iter().filter(|m| !m.known)))
}

fn csv(members: &[Member]) -> String {
    let quoted = |text: &str| {
        if text.contains([',', '"', '\n']) {
            format!("\"{}\"", text.replace('"', "\"\""))
        } else {
            text.to_owned()
        }
    };
    let mut out = String::from("design,known,novelty,feature,value,count,contributes\n");
    for member in members {
        for share in &member.features {
            out += &format!(
                "{},{},{},{},{},{},{}\n",
                quoted(&member.name),
                member.known,
                member.score,
                share.feature,
                quoted(&share.value),
                share.count,
                share.score
            );
        }
    }
    out
}

fn json(members: &[Member]) -> String {
    let value = serde_json::json!({
        "size": members.len(),
        "mean_known": novelty::mean(members.iter().filter(|m| m.known)),
        "mean_others": novelty::mean(members.iter().filter(|m| !m.known)),
        "designs": members,
    });
    serde_json::to_string_pretty(&value).unwrap_or_default() + "\n"
}
