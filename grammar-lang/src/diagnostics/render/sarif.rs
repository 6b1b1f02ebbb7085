//! Findings as one SARIF 2.1.0 document, which editors and code-hosting sites show.
//!
//! The rules are the whole registry of codes, each with its page.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::sorted;
use crate::diagnostics::{CODES, Code, Diagnostic, Fix, Label};
use crate::source::{SourceMap, Span};

/// Writes the findings of any number of compilations; one that two of them share is written once.
#[must_use]
pub fn render(compilations: &[(&[Diagnostic], &SourceMap)]) -> String {
    let mut results: Vec<Value> = Vec::new();
    let mut seen = BTreeSet::new();
    for (diagnostics, sources) in compilations {
        for diagnostic in sorted(diagnostics) {
            let result = result(diagnostic, sources);
            if seen.insert(result.to_string()) {
                results.push(result);
            }
        }
    }
    let document = json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": {
                "name": "sgc",
                "version": env!("CARGO_PKG_VERSION"),
                "rules": CODES.iter().map(|code| rule(code)).collect::<Vec<_>>(),
            } },
            "columnKind": "unicodeCodePoints",
            "results": results,
        }],
    });
    format!("{document:#}\n")
}

fn rule(code: &Code) -> Value {
    json!({
        "id": code.id,
        "name": pascal_case(code.name),
        "shortDescription": { "text": code.title() },
        "fullDescription": { "text": code.meaning() },
        "help": { "text": code.page, "markdown": code.page },
        "defaultConfiguration": { "level": code.severity.name() },
    })
}

/// `wrong-dimension` as SARIF wants names: `WrongDimension`.
fn pascal_case(name: &str) -> String {
    name.split('-')
        .flat_map(|word| {
            let mut letters = word.chars();
            letters.next().into_iter().flat_map(char::to_uppercase).chain(letters).collect::<Vec<_>>()
        })
        .collect()
}

fn result(diagnostic: &Diagnostic, sources: &SourceMap) -> Value {
    let rule = CODES.iter().position(|c| *c == diagnostic.code);
    let help = diagnostic.help.as_ref().map_or(String::new(), |h| format!("\n{h}"));
    let mut result = json!({
        "ruleId": diagnostic.code.id,
        "level": diagnostic.code.severity.name(),
        "message": { "text": format!("{}{help}", diagnostic.message) },
        "locations": diagnostic.labels.iter().take(1).map(|l| location(l, sources)).collect::<Vec<_>>(),
    });
    if let Some(rule) = rule {
        set(&mut result, "ruleIndex", json!(rule));
    }
    let related: Vec<Value> =
        diagnostic.labels.iter().enumerate().skip(1).map(|(i, l)| related(i, l, sources)).collect();
    if !related.is_empty() {
        set(&mut result, "relatedLocations", json!(related));
    }
    if let Some(fix) = &diagnostic.fix {
        set(&mut result, "fixes", json!([mend(fix, sources)]));
    }
    result
}

/// Adds a member to an object.
fn set(object: &mut Value, name: &str, value: Value) {
    if let Some(members) = object.as_object_mut() {
        members.insert(name.to_owned(), value);
    }
}

fn location(label: &Label, sources: &SourceMap) -> Value {
    let mut location = json!({ "physicalLocation": {
        "artifactLocation": artifact(label.span, sources),
        "region": region(label.span, sources),
    } });
    if !label.text.is_empty() {
        set(&mut location, "message", json!({ "text": label.text }));
    }
    location
}

fn related(id: usize, label: &Label, sources: &SourceMap) -> Value {
    let mut location = location(label, sources);
    set(&mut location, "id", json!(id));
    location
}

fn region(span: Span, sources: &SourceMap) -> Value {
    let (line, column) = sources.line_column(span);
    let (end_line, end_column) = sources.line_column(Span { start: span.end, ..span });
    json!({
        "startLine": line,
        "startColumn": column,
        "endLine": end_line,
        "endColumn": end_column,
        "byteOffset": span.start,
        "byteLength": span.end.saturating_sub(span.start),
    })
}

fn artifact(span: Span, sources: &SourceMap) -> Value {
    let name = sources.get(span.file).map_or("", |s| s.name.as_str());
    json!({ "uri": uri(name) })
}

/// The address of a text: a file's path, absolute or not, or `sgc:std.blocks` for one that is no
/// file.
fn uri(name: &str) -> String {
    let plain = |b: u8| b.is_ascii_alphanumeric() || b"-._~/".contains(&b);
    let path: String = name
        .replace('\\', "/")
        .bytes()
        .map(|b| if plain(b) { char::from(b).to_string() } else { format!("%{b:02X}") })
        .collect();
    let is_library = name.starts_with("std.") && !name.ends_with(".sgr");
    match path {
        path if is_library || name.starts_with('<') => format!("sgc:{path}"),
        path if path.starts_with('/') => format!("file://{path}"),
        path => path,
    }
}

fn mend(fix: &Fix, sources: &SourceMap) -> Value {
    let mut changes: Vec<(Span, Vec<Value>)> = Vec::new();
    for edit in &fix.edits {
        let replacement = json!({
            "deletedRegion": region(edit.span, sources),
            "insertedContent": { "text": edit.replacement },
        });
        match changes.iter_mut().find(|(span, _)| span.file == edit.span.file) {
            Some((_, replacements)) => replacements.push(replacement),
            None => changes.push((edit.span, vec![replacement])),
        }
    }
    let changes: Vec<Value> = changes
        .into_iter()
        .map(|(span, edits)| json!({ "artifactLocation": artifact(span, sources), "replacements": edits }))
        .collect();
    json!({ "description": { "text": fix.message }, "artifactChanges": changes })
}
