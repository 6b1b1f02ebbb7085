//! What a study comes to: its cells, which differ in anything but the seed, and their runs.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::file::{Factor, Of, StudyFile};
use crate::results::run_files::EVALUATIONS;
use crate::results::saved::hex;

/// A name longer than this is cut: folders may have 255 bytes.
const LONGEST_NAME: usize = 120;

/// What one cell of a study asks: the runs of it differ in nothing but the seed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// Its name, which is that of its folder. It is made of the values alone, so that a file that lists more leaves it.
    pub name: String,
    /// Its value of each factor, in their order.
    pub levels: Vec<String>,
    /// The grammar, from where the study's file is.
    pub grammar: PathBuf,
    /// The variant of it.
    pub variant: Option<String>,
    /// Parameters that are set, with their values.
    pub parameters: Vec<(String, String)>,
    /// The bound on evaluations; none where the grammar's schedule ends the run.
    pub max_evals: Option<u64>,
}

/// All cells that a file asks for: each value of each factor with each of the others, the last factor changing fastest.
#[must_use]
pub fn cells(file: &StudyFile) -> Vec<Wanted> {
    let factors = file.factors();
    let mut rows: Vec<Vec<String>> = vec![Vec::new()];
    for factor in &factors {
        let longer = |row: &Vec<String>| {
            let row = row.clone();
            factor.levels.iter().map(move |level| [row.as_slice(), std::slice::from_ref(level)].concat())
        };
        rows = rows.iter().flat_map(longer).collect();
    }
    let mut cells: Vec<Wanted> = rows.into_iter().map(|levels| cell(file, &factors, levels)).collect();
    let plain: Vec<String> = cells.iter().map(|cell| cell.name.clone()).collect();
    for (cell, name) in cells.iter_mut().zip(&plain) {
        if name.len() > LONGEST_NAME || plain.iter().filter(|other| *other == name).count() > 1 {
            cell.name = told_apart(name, &cell.levels);
        }
    }
    cells
}

fn cell(file: &StudyFile, factors: &[Factor], levels: Vec<String>) -> Wanted {
    let mut wanted = Wanted {
        name: String::new(),
        grammar: PathBuf::new(),
        variant: None,
        parameters: Vec::new(),
        max_evals: Some(EVALUATIONS),
        levels: Vec::new(),
    };
    let mut pieces = Vec::with_capacity(levels.len());
    for (factor, level) in factors.iter().zip(&levels) {
        pieces.push(match &factor.of {
            Of::Grammar => {
                wanted.grammar = PathBuf::from(level);
                plain(&Path::new(level).file_stem().unwrap_or_default().to_string_lossy())
            }
            Of::Variant => {
                wanted.variant = Some(level.clone());
                plain(level)
            }
            Of::Case => {
                wanted.parameters.extend(file.case(level));
                plain(level)
            }
            Of::Parameter(name) => {
                wanted.parameters.push((name.clone(), level.clone()));
                format!("{}={}", plain(name), plain(level))
            }
            Of::Evaluations => {
                // With none, the grammar's schedule ends the run.
                wanted.max_evals = level.parse().ok().filter(|most| *most > 0);
                format!("evaluations={level}")
            }
        });
    }
    wanted.name = pieces.join(",");
    wanted.levels = levels;
    wanted
}

/// A text as a part of a file's name.
fn plain(text: &str) -> String {
    let kept = |c: char| c.is_ascii_alphanumeric() || ".-+_".contains(c);
    let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let text: String = text.chars().map(|c| if kept(c) { c } else { '-' }).collect();
    // A folder that begins with a dot is hidden.
    let text = text.trim_start_matches('.');
    if text.is_empty() { "-".to_owned() } else { text.to_owned() }
}

/// A name that says by a part of a checksum which values are meant.
fn told_apart(name: &str, levels: &[String]) -> String {
    let sum = hex(&Sha256::digest(levels.join("\u{1f}")));
    let name: String = name.chars().take(LONGEST_NAME - 9).collect();
    format!("{name}~{}", sum.chars().take(8).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<String> {
        let file = StudyFile::parse(Path::new("study.toml"), text).unwrap();
        cells(&file).into_iter().map(|cell| cell.name).collect()
    }

    #[test]
    fn every_value_is_combined_with_every_other() {
        let text =
            "grammar = [\"a/walker.sgr\", \"worm.sgr\"]\nparameters = { legs = [2, 4], period = \"4 s\" }";
        assert_eq!(
            names(text),
            [
                "walker,legs=2,period=4s",
                "walker,legs=4,period=4s",
                "worm,legs=2,period=4s",
                "worm,legs=4,period=4s"
            ]
        );
    }

    #[test]
    fn a_case_sets_several_parameters_at_once() {
        let text = "grammar = \"a.sgr\"\n[[cases]]\nname = \"light\"\nparameters = { mass = \"10 g\", n = 2 }\n\
                    [[cases]]\nname = \"plain\"";
        let file = StudyFile::parse(Path::new("study.toml"), text).unwrap();
        let cells = cells(&file);
        assert_eq!(cells[0].name, "a,light");
        let set: Vec<String> =
            cells[0].parameters.iter().map(|(name, value)| format!("{name}={value}")).collect();
        assert_eq!(set, ["mass=10 g", "n=2"]);
        assert_eq!((cells[1].name.as_str(), cells[1].parameters.len()), ("a,plain", 0));
    }

    #[test]
    fn names_stay_when_a_file_lists_more() {
        let few = names("grammar = \"a.sgr\"\nevaluations = 100\nparameters = { n = 2 }");
        let more = names("grammar = \"a.sgr\"\nevaluations = [100, 200]\nparameters = { n = [2, 3] }");
        assert!(more.contains(&few[0]), "{few:?} {more:?}");
    }

    #[test]
    fn no_two_cells_share_a_name() {
        let mut alike = names("grammar = [\"a/x.sgr\", \"b/x.sgr\"]\nparameters = { n = [\"1 s\", \"1s\"] }");
        let all = alike.len();
        alike.sort();
        alike.dedup();
        assert_eq!(alike.len(), all);
        let long = format!("grammar = \"{}.sgr\"\nparameters = {{ n = [1, 2] }}", "x".repeat(300));
        let long = names(&long);
        assert!(long.iter().all(|name| name.len() <= LONGEST_NAME) && long[0] != long[1], "{long:?}");
    }
}
