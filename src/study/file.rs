//! `study.toml`: what a study asks, as somebody wrote it.

use std::collections::BTreeMap;
use std::path::Path;

use indexmap::IndexMap;
use serde::Deserialize;

use super::StudyError;
use grammar_lang::diagnostics::did_you_mean;

/// Seeds of a study, if it names none.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=5;
/// More runs than this are a slip of the pen.
const MOST_RUNS: usize = 100_000;

/// What a study asks. Each field that may list several values is a factor: every value is combined with every value of the others.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// What the study asks, in words; for the report.
    #[serde(default)]
    pub question: String,
    /// Grammars: paths from where the file is.
    grammar: OneOrMore<String>,
    /// Variants of them.
    variant: Option<OneOrMore<String>>,
    /// Parameters with the values that they take.
    #[serde(default)]
    parameters: IndexMap<String, OneOrMore<Scalar>>,
    /// Groups of parameters that change together.
    #[serde(default)]
    cases: Vec<Case>,
    /// Bounds on the evaluations of a run.
    evaluations: Option<Evaluations>,
    /// Seeds: `5`, `[1, 2, 7]` or `"1..10"`.
    seeds: Option<Seeds>,
    /// The example that all runs start from.
    pub from: Option<String>,
}

/// Parameters that change together, under a name.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    name: String,
    #[serde(default)]
    parameters: IndexMap<String, Scalar>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "expected a value, or a list of values of one kind")]
enum OneOrMore<T> {
    One(T),
    More(Vec<T>),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "expected a whole number of evaluations, or a list such as [1000, 4000]")]
enum Evaluations {
    One(u64),
    More(Vec<u64>),
}

/// A value of a parameter: text as on the command line, with its unit, or a plain number.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "expected a number, or text such as \"4 s\"")]
enum Scalar {
    Bool(bool),
    Whole(i64),
    Real(f64),
    Text(String),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "expected a seed, a list of seeds, or a range such as \"1..10\"")]
enum Seeds {
    One(u64),
    More(Vec<u64>),
    Range(String),
}

impl<T: Clone> OneOrMore<T> {
    fn all(&self) -> Vec<T> {
        match self {
            Self::One(one) => vec![one.clone()],
            Self::More(more) => more.clone(),
        }
    }
}

impl Scalar {
    fn text(&self) -> String {
        match self {
            Self::Bool(yes) => yes.to_string(),
            Self::Whole(number) => number.to_string(),
            Self::Real(number) => number.to_string(),
            Self::Text(text) => text.trim().to_owned(),
        }
    }
}

/// What a factor is of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Of {
    /// The grammar: its levels are paths.
    Grammar,
    /// The variant.
    Variant,
    /// A parameter of the grammar.
    Parameter(String),
    /// Parameters that change together.
    Case,
    /// The bound on evaluations.
    Evaluations,
}

impl Of {
    /// Its name in tables.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Grammar => "grammar",
            Self::Variant => "variant",
            Self::Parameter(name) => name,
            Self::Case => "case",
            Self::Evaluations => "evaluations",
        }
    }
}

/// Something that a study varies, or sets, with the values that it takes.
#[derive(Clone, Debug)]
pub struct Factor {
    /// What.
    pub of: Of,
    /// Its values as text, in the order of the file.
    pub levels: Vec<String>,
}

impl StudyFile {
    /// Reads the text of the file at a path.
    ///
    /// # Errors
    ///
    /// It is no TOML, or a field is unknown, missing or of another kind: the message shows the line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, StudyError> {
        let file: Self = toml::from_str(text)
            .map_err(|why| StudyError::NotStudy { path: path.to_owned(), why: told(&why, text) })?;
        file.check(path)?;
        Ok(file)
    }

    fn check(&self, path: &Path) -> Result<(), StudyError> {
        let wrong = |why: String| Err(StudyError::Wrong { path: path.to_owned(), why });
        let factors = self.factors();
        for factor in &factors {
            let name = factor.of.name();
            if factor.levels.is_empty() {
                // Every study has a grammar.
                let or = if factor.of == Of::Grammar { "" } else { ", or leave the line out" };
                return wrong(format!("`{name}` lists no value; give one{or}"));
            }
            if let (Of::Case, Some(twice)) = (&factor.of, repeated(&factor.levels)) {
                return wrong(format!("two cases are called \"{twice}\"; give each a name of its own"));
            }
            if let Some(twice) = repeated(&factor.levels) {
                return wrong(format!("`{name}` lists {twice} twice; each value is run once for each seed"));
            }
            if let Of::Parameter(name) = &factor.of
                && FIELDS.contains(&name.as_str())
            {
                return wrong(format!(
                    "`{name}` is below `[parameters]`, which makes it a parameter of the grammar: move the line above `[parameters]`. A parameter of \
                     that name cannot be set by a study"
                ));
            }
            if let Of::Parameter(name) = &factor.of
                && RESERVED.contains(&name.as_str())
            {
                return wrong(format!(
                    "a parameter cannot be called `{name}` here: a column of the study's tables has this name; rename the parameter in the \
                     grammar"
                ));
            }
        }
        for case in &self.cases {
            if let Some(both) = case.parameters.keys().find(|name| self.parameters.contains_key(*name)) {
                return wrong(format!(
                    "`{both}` is in [parameters] and in the case \"{}\"; let one of them set it",
                    case.name
                ));
            }
        }
        let seeds = self.seeds().map_err(|why| StudyError::Wrong { path: path.to_owned(), why })?;
        if seeds.is_empty() {
            return wrong("`seeds` lists no seed; write `seeds = \"1..10\"`".to_owned());
        }
        if let Some(twice) = repeated(&seeds) {
            return wrong(format!("`seeds` lists {twice} twice: the same seed gives the same run"));
        }
        let runs = factors.iter().fold(seeds.len(), |all, factor| all.saturating_mul(factor.levels.len()));
        if runs > MOST_RUNS {
            let counts = factors.iter().filter(|factor| factor.levels.len() > 1);
            let counts: Vec<String> =
                counts.map(|factor| format!("{} of `{}`", factor.levels.len(), factor.of.name())).collect();
            return wrong(format!(
                "this is {runs} runs ({}, {} seeds); the most is {MOST_RUNS}: every value is combined with every value of the others",
                counts.join(", "),
                seeds.len()
            ));
        }
        Ok(())
    }

    /// All that it varies or sets, in the order of names of runs.
    #[must_use]
    pub fn factors(&self) -> Vec<Factor> {
        let mut factors = vec![Factor { of: Of::Grammar, levels: self.grammar.all() }];
        let variants = self.variant.iter().map(|all| Factor { of: Of::Variant, levels: all.all() });
        factors.extend(variants);
        if !self.cases.is_empty() {
            let levels = self.cases.iter().map(|case| case.name.clone()).collect();
            factors.push(Factor { of: Of::Case, levels });
        }
        factors.extend(self.parameters.iter().map(|(name, values)| Factor {
            of: Of::Parameter(name.clone()),
            levels: values.all().iter().map(Scalar::text).collect(),
        }));
        let bounds = self.evaluations.iter().map(|all| Factor {
            of: Of::Evaluations,
            levels: match all {
                Evaluations::One(most) => vec![most.to_string()],
                Evaluations::More(all) => all.iter().map(u64::to_string).collect(),
            },
        });
        factors.extend(bounds);
        factors
    }

    /// The parameters of a case.
    #[must_use]
    pub fn case(&self, name: &str) -> BTreeMap<String, String> {
        let case = self.cases.iter().find(|case| case.name == name);
        let parameters = case.into_iter().flat_map(|case| &case.parameters);
        parameters.map(|(name, value)| (name.clone(), value.text())).collect()
    }

    /// The seeds.
    ///
    /// # Errors
    ///
    /// What is wrong with a range.
    pub fn seeds(&self) -> Result<Vec<u64>, String> {
        match &self.seeds {
            None => Ok(SEEDS.collect()),
            Some(Seeds::One(seed)) => Ok(vec![*seed]),
            Some(Seeds::More(seeds)) => Ok(seeds.clone()),
            Some(Seeds::Range(text)) => {
                let ends = text.split_once("..").map(|(first, last)| (first.trim(), last.trim()));
                let ends = ends.and_then(|(first, last)| {
                    Some((first.parse::<u64>().ok()?, last.trim_start_matches('=').parse::<u64>().ok()?))
                });
                match ends {
                    Some((first, last)) if first <= last && last - first < MOST_RUNS as u64 => {
                        Ok((first..=last).collect())
                    }
                    Some((first, last)) if first <= last => {
                        Err(format!("`seeds` from {first} to {last} are more than {MOST_RUNS} runs"))
                    }
                    Some((first, last)) => {
                        Err(format!("`seeds = \"{text}\"` runs backwards: write \"{last}..{first}\""))
                    }
                    None => Err(format!(
                        "`seeds = \"{text}\"` is not a range: write \"1..10\", which is ten seeds, or a list such as [1, 2, 7]"
                    )),
                }
            }
        }
    }
}

/// The lines that a study can have.
const FIELDS: [&str; 8] =
    ["question", "grammar", "variant", "evaluations", "seeds", "from", "parameters", "cases"];
/// Columns of the tables of a study, besides those called as lines.
const RESERVED: [&str; 3] = ["case", "seed", "run"];

/// Where a text is no study and why, with what mends it, if that is known.
fn told(why: &toml::de::Error, text: &str) -> String {
    let before =
        why.span().and_then(|place| text.get(..place.start)).map_or(0, |before| before.lines().count());
    let line = text.lines().nth(before.saturating_sub(1)).unwrap_or_default();
    let is_range = line.contains("..") && !line.contains('"');
    let message = why.message();
    let unknown = message.strip_prefix("unknown field `").and_then(|rest| rest.split('`').next());
    let meant = unknown.and_then(|name| did_you_mean(name, FIELDS));
    match meant {
        Some(meant) => format!("{why}{meant}\n"),
        None if is_range => {
            format!("{why}a range of seeds is text: write `seeds = \"1..10\"`\n")
        }
        None if message.contains("invalid type: map, expected a sequence") => {
            format!("{why}a case is a table in a list: write `[[cases]]`, with two brackets\n")
        }
        None => why.to_string(),
    }
}

/// Something that is listed twice.
fn repeated<T: PartialEq>(all: &[T]) -> Option<&T> {
    all.iter().enumerate().find(|(place, one)| all[..*place].contains(one)).map(|(_, one)| one)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<StudyFile, String> {
        StudyFile::parse(Path::new("study.toml"), text).map_err(|why| why.to_string())
    }

    #[test]
    fn seeds_are_a_number_a_list_or_a_range() {
        for (text, seeds) in [
            ("", vec![1, 2, 3, 4, 5]),
            ("seeds = 7", vec![7]),
            ("seeds = [3, 1]", vec![3, 1]),
            ("seeds = \"2..4\"", vec![2, 3, 4]),
        ] {
            let file = parse(&format!("grammar = \"a.sgr\"\n{text}")).unwrap();
            assert_eq!(file.seeds().unwrap(), seeds, "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_what_mends_it() {
        for (text, told) in [
            ("grammar = \"a.sgr\"\nseeds = \"1-10\"", "write \"1..10\""),
            ("grammar = \"a.sgr\"\nseeds = [1, 1]", "lists 1 twice"),
            ("grammar = []", "`grammar` lists no value; give one"),
            ("grammar = \"a.sgr\"\nevaluations = [10, 10]", "`evaluations` lists 10 twice"),
            ("grammar = \"a.sgr\"\nseed = 3", "unknown field `seed`"),
            ("seeds = 3", "missing field `grammar`"),
            ("grammar = \"a.sgr\"\nseeds = \"1..200000\"", "more than 100000 runs"),
            (
                "grammar = \"a.sgr\"\nparameters = { n = [1, 2] }\ncases = [{ name = \"x\", parameters = { n = 3 } }]",
                "`n` is in [parameters] and in the case \"x\"",
            ),
            ("grammar = \"a.sgr\"\nparameters = { seed = 3 }", "a parameter cannot be called `seed` here"),
            ("grammar = \"a.sgr\"\n[parameters]\nseeds = 3", "move the line above `[parameters]`"),
            ("grammar = \"a.sgr\"\nevalutions = 3", "did you mean `evaluations`?"),
            ("grammar = \"a.sgr\"\nseeds = 1..3", "write `seeds = \"1..10\"`"),
            ("grammar = \"a.sgr\"\nseeds = \"3..1\"", "runs backwards: write \"1..3\""),
            (
                "grammar = \"a.sgr\"\ncases = [{ name = \"x\" }, { name = \"x\" }]",
                "two cases are called \"x\"; give each a name of its own",
            ),
            ("grammar = \"a.sgr\"\nevaluations = -5", "expected a whole number of evaluations"),
            ("grammar = \"a.sgr\"\n[cases]\nname = \"x\"", "write `[[cases]]`"),
        ] {
            let why = parse(text).unwrap_err();
            assert!(why.contains(told), "{text}\n{why}");
        }
    }
}
