//! A variant that a command writes: where, under which name, and only if the grammar accepts it.

use std::fs;
use std::path::{Component, Path, PathBuf};

use grammar_lang::diagnostics::render::{Format, render};

use super::load;
use super::output::{self, Fault};
use crate::document::is_name;
use crate::loader::Files;

/// Where to write the variant of a grammar: `out`, or beside a file, under the name of the grammar with an ending.
pub(super) fn target(
    grammar: &Path,
    out: Option<&Path>,
    beside: &Path,
    ending: &str,
) -> Result<PathBuf, Fault> {
    if grammar.extension().is_none_or(|e| e != "sgr") {
        return Err(Fault::usage(format!(
            "{} is not a grammar file: its name does not end with .sgr, so a variant cannot name it",
            grammar.display()
        )));
    }
    let stem = grammar.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let out = out.map_or_else(|| beside.with_file_name(format!("{stem}_{ending}.sgr")), Path::to_path_buf);
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
        return Err(Fault::usage(format!("there is no folder {}", folder.display())));
    }
    if out.is_dir() {
        return Err(Fault::usage(format!("{} is a folder; write --out NAME.sgr", out.display())));
    }
    if out.extension().is_none_or(|e| e != "sgr") {
        return Err(Fault::usage(format!("{} does not end with .sgr; write --out NAME.sgr", out.display())));
    }
    if fs::canonicalize(&out).is_ok_and(|out| fs::canonicalize(grammar).is_ok_and(|g| g == out)) {
        return Err(Fault::usage("--out names the grammar itself; choose another file".to_owned()));
    }
    Ok(out)
}

/// What the variant is called: as asked for, or as its file.
pub(super) fn name(out: &Path, asked: Option<&str>) -> Result<String, Fault> {
    let stem = out.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = asked.map_or(stem, str::to_owned);
    if is_name(&name) {
        return Ok(name);
    }
    Err(Fault::usage(format!(
        "`{name}` cannot name a variant: a name is a word of letters, digits and `_` that does not begin with \
         a digit and is not reserved; give one with --variant NAME"
    )))
}

/// Existing files are kept, unless they are to be replaced.
pub(super) fn may_write(files: &[&Path], force: bool) -> Result<(), Fault> {
    for file in files {
        // A link that leads nowhere is there, too.
        if !force && fs::symlink_metadata(file).is_ok() {
            return Err(Fault::usage(format!(
                "{} exists already; choose another name with --out, or replace it with --force",
                file.display()
            )));
        }
    }
    Ok(())
}

/// Checks the variant where it is to stand: what would be refused later is not written. `values` says which values are new.
pub(super) fn accepted(out: &Path, text: &str, values: &str) -> Result<(), Fault> {
    let checked = load::check(&Files, &out.to_string_lossy(), text, &[], None);
    if checked.sound {
        return Ok(());
    }
    let found = render(&checked.diagnostics, &checked.sources, Format::Full, output::colour_err());
    output::note(found.trim_end());
    Err(Fault::input(format!("the grammar has errors with the {values} values; nothing is written")))
}

/// How a text names the grammar from the folder that it stands in.
pub(super) fn from_folder(grammar: &Path, text: &Path) -> Result<String, Fault> {
    let folder = text.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let whole = |path: &Path| {
        fs::canonicalize(path).map_err(|e| Fault::usage(format!("cannot read {}: {e}", path.display())))
    };
    let path = relative(&whole(grammar)?, &whole(folder)?);
    if path.contains(['"', '\\', '\n', '{', '}']) {
        return Err(Fault::usage(format!("a variant cannot name the file {path}; rename it")));
    }
    Ok(path)
}

/// The way from a folder to a file, both from the root.
fn relative(file: &Path, folder: &Path) -> String {
    let (file, folder): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (file.components().collect(), folder.components().collect());
    let common = file.iter().zip(&folder).take_while(|(a, b)| a == b).count();
    let up = folder.len() - common;
    let mut parts = if up == 0 { vec![".".to_owned()] } else { vec!["..".to_owned(); up] };
    parts.extend(file.iter().skip(common).map(|c| c.as_os_str().to_string_lossy().into_owned()));
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_to_a_grammar_is_that_from_the_folder_of_the_text() {
        let way = |file: &str, folder: &str| relative(Path::new(file), Path::new(folder));
        assert_eq!(way("/a/b/c.sgr", "/a/b"), "./c.sgr");
        assert_eq!(way("/a/b/c.sgr", "/a/d/e"), "../../b/c.sgr");
        assert_eq!(way("/a/b/c.sgr", "/a"), "./b/c.sgr");
    }
}
