//! What is counted and measured: plain numbers, and the tables that hold them. Nothing here draws.

pub(crate) mod bodies;
pub(crate) mod convergence;
pub(crate) mod front;
pub(crate) mod learning;
pub(crate) mod observed;
pub(crate) mod rejections;
pub(crate) mod rules;
pub(crate) mod runs;
pub(crate) mod sizes;
pub(crate) mod spending;
pub(crate) mod spread;
pub(crate) mod temperature;

use crate::results::evals::quoted;

/// A table as the text of a csv file: the names of its columns, then its rows.
pub(crate) fn table<const N: usize>(columns: [&str; N], rows: impl Iterator<Item = [String; N]>) -> String {
    let line = |cells: &[String; N]| {
        let cells: Vec<String> = cells.iter().map(|cell| quoted(cell)).collect();
        cells.join(",") + "\n"
    };
    columns.join(",") + "\n" + &rows.map(|row| line(&row)).collect::<String>()
}

/// A cell that may be empty.
pub(crate) fn or_empty<T: ToString>(value: Option<T>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

/// Groups of runs for the tests of what is made of them.
#[cfg(test)]
pub(crate) mod tests {
    use grammar_lang::ir::Direction;
    use std::path::PathBuf;

    use crate::results::DesignError;
    use crate::results::report::moves::tests::table;
    use crate::results::report::read::{Group, Run, Standing};
    use crate::results::run_files::{Asked, Finished};

    /// A complete run with the rows of `evals.csv`.
    pub(crate) fn run(seed: u64, rows: &str) -> Run {
        let moves = table(rows);
        let last = moves.last().cloned().unwrap_or_default();
        Run {
            path: PathBuf::from(format!("seed-{seed}")),
            asked: Asked {
                command: "sgc run tiny.sgr".to_owned(),
                sgc: "0.1.0".to_owned(),
                grammar: "tiny".to_owned(),
                rules: String::new(),
                seed,
                solver: "articulated".to_owned(),
                max_evals: Some(8),
                time: None,
                from: None,
                design: None,
                entry: "tiny.sgr".to_owned(),
                parameters: Vec::new(),
                sources: Vec::new(),
            },
            rules: Err(DesignError::NoText.into()),
            learning: Vec::new(),
            standing: Standing::Complete(Box::new(Finished {
                grammar: "tiny".to_owned(),
                seed,
                value: last.best,
                unit: "cm".to_owned(),
                observed: indexmap::IndexMap::new(),
                evaluations: last.evaluations,
                moves: moves.len().saturating_sub(1),
                invalid: std::collections::BTreeMap::new(),
                unstable: 0,
                checks: None,
                nine_of_ten: None,
                over_worlds: None,
                end: "the evaluations are spent".to_owned(),
                max_evals: None,
                sum: None,
                evals: None,
                asked: None,
            })),
            moves,
            design: None,
            processes: None,
        }
    }

    /// A group that maximises a value in cm, and has no readable grammar.
    pub(crate) fn group(runs: Vec<Run>) -> Group {
        Group {
            name: "tiny".to_owned(),
            path: PathBuf::from("runs/tiny"),
            runs,
            unit: "cm".to_owned(),
            direction: Direction::Maximize,
            rules: Err(DesignError::NoText.into()),
        }
    }

    /// Two runs of a few moves: the numbers of the tests can be checked by hand.
    pub(crate) fn two() -> Group {
        let one = run(
            1,
            "0,0,,,1,0,0,true,0,0,1,0,0,\n\
             1,0,add,,2,1,4,true,4,9,2,0,0,\n\
             2,0,add,turn: solid,3,1,3,true,4,9,3,0,0,\n\
             3,1,undo,turn: solid; add: few,2,1,,false,4,6,5,1,1,1 too fast\n\
             4,1,,turn: solid; add: few; undo: no match,3,1,,false,4,6,5,0,0,\n\
             5,1,add,,4,2,8,true,8,6,8,0,0,\n",
        );
        let two = run(
            2,
            "0,0,,,1,0,0,true,0,0,1,0,0,\n\
             1,0,add,,2,1,2,true,2,9,4,0,0,\n\
             2,0,turn,,2,1,1,false,2,9,6,0,0,\n",
        );
        group(vec![one, two])
    }
}
