//! Where modules come from: the standard library inside the program, and files.

use std::collections::BTreeMap;
use std::io;
use std::path::{Component, Path, PathBuf};

use grammar_lang::source::{Loader, NoModule, Source};

use crate::reading;

/// The standard library: module name and text.
pub const LIBRARY: &[(&str, &str)] = &[
    ("std.actuation", include_str!("../std-rules/actuation.sgr")),
    ("std.actuators", include_str!("../std-rules/actuators.sgr")),
    ("std.blocks", include_str!("../std-rules/blocks.sgr")),
    ("std.gaits", include_str!("../std-rules/gaits.sgr")),
    ("std.lattice", include_str!("../std-rules/lattice.sgr")),
    ("std.limbs", include_str!("../std-rules/limbs.sgr")),
    ("std.materials", include_str!("../std-rules/materials.sgr")),
    ("std.models", include_str!("../std-rules/models.sgr")),
    ("std.novelty", include_str!("../std-rules/novelty.sgr")),
    ("std.objectives", include_str!("../std-rules/objectives.sgr")),
    ("std.prototypes", include_str!("../std-rules/prototypes.sgr")),
    ("std.rewards", include_str!("../std-rules/rewards.sgr")),
    ("std.sensors", include_str!("../std-rules/sensors.sgr")),
    ("std.scenarios", include_str!("../std-rules/scenarios.sgr")),
    ("std.search", include_str!("../std-rules/search.sgr")),
];

/// The standard library and the files around the grammar.
#[derive(Debug, Default)]
pub struct Files;

/// The standard library and files named from a folder: what is found in them
/// has the same name on every machine.
#[derive(Debug, Default)]
pub struct Folder {
    /// The folder.
    pub path: PathBuf,
}

/// The files around the grammar as they would be after some edits.
#[derive(Clone, Debug, Default)]
pub struct Edited {
    texts: BTreeMap<PathBuf, String>,
}

impl Edited {
    /// The one path by which a file is known, whatever it was called.
    #[must_use]
    pub fn key(name: &str) -> PathBuf {
        std::fs::canonicalize(name).unwrap_or_else(|_| PathBuf::from(name))
    }

    /// Changes a text.
    pub fn set(&mut self, key: &Path, text: String) {
        self.texts.insert(key.to_owned(), text);
    }

    /// The text with this name, if it was changed.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&str> {
        self.at(&Self::key(name))
    }

    /// The text with this key, if it was changed.
    #[must_use]
    pub fn at(&self, key: &Path) -> Option<&str> {
        self.texts.get(key).map(String::as_str)
    }
}

/// A frozen set of texts, such as the sources kept in a run folder, or edited
/// copies in a test. What it lacks is looked up in the standard library.
#[derive(Debug, Default)]
pub struct Frozen {
    /// Text by module name.
    pub texts: BTreeMap<String, String>,
}

/// So many files of a folder are looked at for a suggestion.
const SUGGESTED: usize = 1000;

fn from_library(module: &str) -> Option<Source> {
    let (name, text) = LIBRARY.iter().find(|(name, _)| *name == module)?;
    Some(Source { name: (*name).to_owned(), text: (*text).to_owned() })
}

fn library_names() -> Vec<String> {
    LIBRARY.iter().map(|(name, _)| (*name).to_owned()).collect()
}

/// A path without `.` and `..` where they can be resolved by name alone.
#[must_use]
pub fn tidy(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if out.file_name().is_some() => {
                out.pop();
            }
            part => out.push(part),
        }
    }
    out
}

/// The path that a `use "./file.sgr"` in `from` means.
fn beside(from: &str, module: &str) -> PathBuf {
    tidy(&Path::new(from).parent().unwrap_or(Path::new("")).join(module))
}

/// Reads a file as text; bytes that are no UTF-8 become U+FFFD, which the parser refuses with its place.
///
/// # Errors
///
/// The system's reason, or that it is a device or too long.
pub fn read_text(path: &Path) -> io::Result<String> {
    Ok(String::from_utf8_lossy(&reading::named(path)?).into_owned())
}

impl Loader for Files {
    fn beside(&self, module: &str, from: &str) -> Vec<String> {
        Folder::default().beside(module, from)
    }

    fn load(&self, module: &str, from: &str) -> Result<Source, NoModule> {
        Folder::default().load(module, from)
    }

    fn leads_to_one(&self, one: &str, other: &str) -> bool {
        Folder::default().leads_to_one(one, other)
    }

    fn library(&self) -> Vec<String> {
        library_names()
    }
}

impl Loader for Folder {
    fn load(&self, module: &str, from: &str) -> Result<Source, NoModule> {
        if let Some(source) = from_library(module) {
            return Ok(source);
        }
        if !module.ends_with(".sgr") {
            return Err(NoModule::NotInLibrary);
        }
        if from.starts_with("std.") {
            return Err(NoModule::FromLibrary);
        }
        let path = beside(from, module);
        let bytes = reading::imported(&self.path.join(&path))?;
        let text = String::from_utf8_lossy(&bytes).into_owned();
        Ok(Source { name: path.to_string_lossy().into_owned(), text })
    }

    fn beside(&self, module: &str, from: &str) -> Vec<String> {
        let path = self.path.join(beside(from, module));
        let folder = module.rfind('/').map_or("", |end| &module[..=end]);
        let entries = path.parent().map(std::fs::read_dir).into_iter().flatten().flatten();
        let names = entries.flatten().take(SUGGESTED).map(|entry| entry.file_name());
        let mut files: Vec<String> = names
            .filter_map(|name| {
                Some(format!("{folder}{}", name.to_str().filter(|name| name.ends_with(".sgr"))?))
            })
            .collect();
        files.sort_unstable();
        files
    }

    fn leads_to_one(&self, one: &str, other: &str) -> bool {
        let real = |name: &str| std::fs::canonicalize(self.path.join(name));
        one == other || matches!((real(one), real(other)), (Ok(one), Ok(other)) if one == other)
    }

    fn library(&self) -> Vec<String> {
        library_names()
    }
}

impl Loader for Edited {
    fn beside(&self, module: &str, from: &str) -> Vec<String> {
        Files.beside(module, from)
    }

    fn leads_to_one(&self, one: &str, other: &str) -> bool {
        Files.leads_to_one(one, other)
    }

    fn load(&self, module: &str, from: &str) -> Result<Source, NoModule> {
        let source = Files.load(module, from)?;
        match self.get(&source.name) {
            Some(text) if from_library(&source.name).is_none() => {
                Ok(Source { text: text.to_owned(), ..source })
            }
            _ => Ok(source),
        }
    }

    fn library(&self) -> Vec<String> {
        library_names()
    }
}

impl Loader for Frozen {
    fn load(&self, module: &str, from: &str) -> Result<Source, NoModule> {
        let path = beside(from, module).to_string_lossy().into_owned();
        for name in [module, path.as_str()] {
            if let Some(text) = self.texts.get(name) {
                return Ok(Source { name: name.to_owned(), text: text.clone() });
            }
        }
        from_library(module).ok_or(NoModule::NotGiven)
    }

    fn library(&self) -> Vec<String> {
        library_names()
    }
}
