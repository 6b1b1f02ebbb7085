//! Writes the variant that holds what was measured.

use std::fmt::Write;

use grammar_lang::source::SourceMap;

use super::finding::{Change, Finding, Table};
use super::worlds;

/// How wide comments are.
const WIDTH: usize = 96;

/// What a variant and the worlds in it are called.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// The variant.
    pub variant: &'a str,
    /// The set of worlds that lie as far apart as the measurements may be off.
    pub worlds: &'a str,
}

/// The text of a file: a table for each measured function, and a variant of the grammar in the file
/// `base` (a path from the folder of the text) with an edit for each finding. Above each stands where it comes
/// from: `measurements` is the file that was read. Last comes a set of worlds, where the findings say how far they may be
/// off. It is laid out as `sgc fmt` does.
#[must_use]
pub fn text(named: Named<'_>, base: &str, measurements: &str, findings: &[Finding]) -> String {
    let Named { variant: name, worlds: set } = named;
    let mut out = String::new();
    let begin = format!(
        "Measured on the bench: {measurements}. Written by `sgc calibrate`; to change a number, measure again."
    );
    comment(&mut out, "##", "", &begin);
    for finding in findings {
        if let Change::Table { table, .. } = &finding.change {
            out.push('\n');
            comment(&mut out, "##", "", &origin(finding));
            write_table(&mut out, table);
        }
    }
    // Writing to a String never fails.
    let _ = writeln!(out, "\nvariant {name} of \"{base}\" {{");
    let mut above = None;
    for finding in findings {
        let Some(edit) = edit(&finding.change) else { continue };
        // What is said of a table stands above it.
        let is_table = matches!(finding.change, Change::Table { .. });
        if above.is_some_and(|(section, was_table)| {
            (section, was_table) != (&finding.section, is_table) && !(was_table && is_table)
        }) {
            out.push('\n');
        }
        above = Some((&finding.section, is_table));
        if !is_table {
            comment(&mut out, "#", "  ", &origin(finding));
        }
        let _ = writeln!(out, "  {edit}");
    }
    if let Some(block) = worlds::block(set, findings) {
        out.push('\n');
        let about = format!(
            "The 90 % intervals of the measured values, as worlds to search and test in. \
             To use them, write `simulate MODEL for TIME in {set}`, or try a design with `sgc eval --in`."
        );
        comment(&mut out, "#", "  ", &about);
        out.push_str(&block);
    }
    out.push_str("}\n");
    laid_out(out)
}

/// As `sgc fmt` lays it out; as it is where that cannot be.
pub(crate) fn laid_out(text: String) -> String {
    let mut sources = SourceMap::default();
    let file = sources.add("variant.sgr", text.clone());
    grammar_lang::format::format(&sources, file).unwrap_or(text)
}

/// Where a finding comes from, in words.
fn origin(finding: &Finding) -> String {
    let points =
        if finding.points == 1 { "1 point".to_owned() } else { format!("{} points", finding.points) };
    let mut out = format!("{}, {}: {points}", finding.source, finding.section);
    if let Some(residual) = &finding.residual {
        let _ = write!(out, ", residual {} (rms), {} at most", residual.rms, residual.largest);
    }
    if let Some((low, high)) = &finding.interval {
        let _ = write!(out, ", 90 % interval {} .. {high}", low.digits(false));
    }
    out.push('.');
    for note in finding.warnings.iter().chain(&finding.notes) {
        let _ = write!(out, " {note}");
    }
    out
}

/// Writes a comment in lines of some width.
pub(crate) fn comment(out: &mut String, sign: &str, indent: &str, text: &str) {
    let begin = format!("{indent}{sign}");
    let mut line = begin.clone();
    // What ends a line ends a comment.
    for word in text.split_whitespace() {
        if line.chars().count() + word.chars().count() >= WIDTH && line != begin {
            out.push_str(&line);
            out.push('\n');
            line.clone_from(&begin);
        }
        line.push(' ');
        line.push_str(word);
    }
    out.push_str(&line);
    out.push('\n');
}

fn write_table(out: &mut String, table: &Table) {
    let _ = writeln!(out, "table {} : {} -> {} {{", table.name, table.from, table.to);
    let rows: Vec<(String, String)> =
        table.rows.iter().map(|(x, y)| (x.digits(true), y.digits(false))).collect();
    let wide = |of: fn(&(String, String)) -> &String| rows.iter().map(|row| of(row).len()).max().unwrap_or(0);
    let (first, second) = (wide(|row| &row.0), wide(|row| &row.1));
    for (i, ((x, y), (from, to))) in rows.iter().zip(&table.rows).enumerate() {
        let within = table.within.get(i).and_then(Option::as_ref);
        let within = within.map_or(String::new(), |(low, high)| {
            format!("   # {} .. {}", low.digits(false), high.digits(false))
        });
        let _ = writeln!(out, "  {x:>first$} {} -> {y:>second$} {},{within}", from.unit, to.unit);
    }
    out.push_str("}\n");
}

/// The edit that makes a change.
fn edit(change: &Change) -> Option<String> {
    match change {
        Change::Number { path, value } => Some(format!("set {path} = {value}")),
        Change::Table { path, table } => path.as_ref().map(|path| format!("set {path} = {}", table.name)),
        Change::Prototype { name, build, simulated, measured, length } => {
            let length =
                length.as_ref().map_or(String::new(), |length| format!("    length    = {length}\n"));
            Some(format!(
                "add prototype {name} on {build} {{\n    simulated = {simulated}\n    measured  = {measured}\n{length}  }}"
            ))
        }
    }
}
