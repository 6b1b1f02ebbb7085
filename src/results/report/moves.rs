//! The table of moves, read again. Columns are found by their names: others may stand beside them.

use std::collections::BTreeMap;
use std::path::Path;

use csv::StringRecord;
use grammar_lang::ir::RuleSet;

use crate::results::whole::read;

/// One row of `evals.csv`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Move {
    /// 0 is the initial design.
    pub(crate) number: u64,
    pub(crate) iteration: u64,
    /// The rule that was applied; none if none could be, and for the initial design.
    pub(crate) rule: Option<String>,
    /// Rules that were drawn before it, and what stopped each.
    pub(crate) blocked: Vec<(String, String)>,
    pub(crate) parts: u64,
    pub(crate) actuators: u64,
    /// None if no evaluation was valid.
    pub(crate) value: Option<f64>,
    pub(crate) accepted: bool,
    /// The best value so far.
    pub(crate) best: Option<f64>,
    pub(crate) temperature: f64,
    /// Evaluations spent in all.
    pub(crate) evaluations: u64,
    /// Candidates that lost their value in a finer simulation.
    pub(crate) unstable: u64,
    /// Evaluations without a value, by reason.
    pub(crate) missing: Vec<(String, u64)>,
    /// The annealing chain that it belongs to, where several share a run.
    pub(crate) chain: u64,
    /// What was observed of it, by name; empty where it has no value.
    pub(crate) observed: Vec<(String, String)>,
    /// The value of the design that it started from: the current one of its chain.
    pub(crate) from: Option<f64>,
}

/// From which designs the moves of a search start: what `evals.csv` does not say of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Starts {
    /// How many designs with a value a random walk makes, after which all begins anew.
    pub(crate) walk: Option<usize>,
    /// Whether chains may change places between iterations, which no row tells.
    pub(crate) exchange: bool,
    /// Whether a move starts from any of several designs that are kept, and no row tells which.
    pub(crate) archive: bool,
}

impl Starts {
    /// Those of a grammar's search.
    pub(crate) fn of(rules: &RuleSet) -> Self {
        let outer = &rules.search.outer;
        let several = outer.chains.is_some_and(|chains| chains > 1);
        Self {
            walk: outer.walk,
            exchange: several && outer.exchange.is_some(),
            archive: outer.archive.is_some(),
        }
    }

    /// Whether it is known which moves led to a design.
    pub(crate) fn are_known(self) -> bool {
        !self.exchange && !self.archive
    }
}

/// Reads the moves of a run. A last row that is not written to its end is left out where the run
/// `may_be_cut`: it is under way, or was killed.
///
/// # Errors
///
/// A sentence that names the place.
pub(crate) fn moves(path: &Path, may_be_cut: bool, starts: Starts) -> Result<Vec<Move>, String> {
    parse(&read(path)?, may_be_cut, starts).map_err(|why| {
        format!("{} is damaged: {why}; restore it, or leave this run out of the report", path.display())
    })
}

fn parse(text: &str, may_be_cut: bool, starts: Starts) -> Result<Vec<Move>, String> {
    let whole = match text.rfind('\n') {
        Some(end) if may_be_cut => text.get(..=end).unwrap_or(text),
        _ if text.is_empty() => return Err("it is empty".to_owned()),
        Some(end) if end + 1 == text.len() => text,
        _ => return Err("its last row is not complete".to_owned()),
    };
    let mut reader = csv::Reader::from_reader(whole.as_bytes());
    let head = reader.headers().map_err(|e| told(&e))?.clone();
    let columns = Columns::new(&head)?;
    let mut moves = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| told(&e))?;
        moves.push(columns.read(&record)?);
    }
    start(&mut moves, starts);
    Ok(moves)
}

/// Finds what each move started from.
fn start(moves: &mut [Move], starts: Starts) {
    let Some((first, made)) = moves.split_first_mut() else { return };
    if starts.archive {
        return;
    }
    // All chains begin with the initial design. A value that is not known is none.
    let mut current: BTreeMap<u64, Option<f64>> = BTreeMap::new();
    let (mut iteration, mut walked) = (first.iteration, 0);
    for made in made {
        if starts.exchange && made.iteration != iteration {
            current.values_mut().for_each(|value| *value = None);
        }
        iteration = made.iteration;
        made.from = current.get(&made.chain).copied().unwrap_or(first.value);
        if made.accepted {
            current.insert(made.chain, made.value);
        }
        walked += usize::from(made.value.is_some());
        if starts.walk == Some(walked) {
            current.clear();
            // Only once.
            walked = usize::MAX / 2;
        }
    }
}

fn told(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => format!(
            "line {} has {len} fields, where its first line names {expected_len} columns",
            pos.as_ref().map_or(0, csv::Position::line)
        ),
        _ => error.to_string(),
    }
}

/// Where the columns are.
struct Columns<'a> {
    head: &'a StringRecord,
}

impl<'a> Columns<'a> {
    /// The columns without which there is nothing to report.
    const NEEDED: [&'static str; 14] = [
        "move",
        "iteration",
        "rule",
        "blocked",
        "parts",
        "actuators",
        "value",
        "accepted",
        "best",
        "temperature",
        "evaluations",
        "invalid",
        "unstable",
        "why_invalid",
    ];

    fn new(head: &'a StringRecord) -> Result<Self, String> {
        match Self::NEEDED.iter().find(|needed| !head.iter().any(|name| name == **needed)) {
            Some(missing) => Err(format!("it has no column `{missing}`")),
            None => Ok(Self { head }),
        }
    }

    /// A field by the name of its column; empty if there is no such column.
    fn field<'r>(&self, record: &'r StringRecord, name: &str) -> &'r str {
        self.head.iter().position(|column| column == name).and_then(|i| record.get(i)).unwrap_or("")
    }

    fn read(&self, record: &StringRecord) -> Result<Move, String> {
        let text = |name| self.field(record, name);
        let wrong = |name: &str| {
            let line = record.position().map_or(0, csv::Position::line);
            format!("line {line} has `{}` in the column `{name}`", self.field(record, name))
        };
        let count = |name| text(name).parse::<u64>().map_err(|_| wrong(name));
        let finite =
            |name| text(name).parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| wrong(name));
        let number = |name| if text(name).is_empty() { Ok(None) } else { finite(name).map(Some) };
        Ok(Move {
            number: count("move")?,
            iteration: count("iteration")?,
            rule: Some(text("rule").to_owned()).filter(|rule| !rule.is_empty()),
            blocked: blocked(text("blocked")),
            parts: count("parts")?,
            actuators: count("actuators")?,
            value: number("value")?,
            accepted: text("accepted").parse().map_err(|_| wrong("accepted"))?,
            best: number("best")?,
            temperature: finite("temperature")?,
            evaluations: count("evaluations")?,
            unstable: count("unstable")?,
            missing: reasons(text("why_invalid")).ok_or_else(|| wrong("why_invalid"))?,
            chain: if text("chain").is_empty() { 0 } else { count("chain")? },
            observed: self.observed(record),
            from: None,
        })
    }

    /// The columns that stand after the last of every table.
    fn observed(&self, record: &StringRecord) -> Vec<(String, String)> {
        let Some(last) = self.head.iter().position(|column| column == "chain") else { return Vec::new() };
        let more = self.head.iter().zip(record).skip(last + 1).filter(|(_, text)| !text.is_empty());
        more.map(|(name, text)| (name.to_owned(), text.to_owned())).collect()
    }
}

/// Reads `rule: why; rule: why`.
fn blocked(text: &str) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = Vec::new();
    for piece in text.split("; ").filter(|piece| !piece.is_empty()) {
        match (piece.split_once(": "), all.last_mut()) {
            (Some((rule, why)), _) => all.push((rule.to_owned(), why.to_owned())),
            // The name of a requirement may be the text of a condition.
            (None, Some((_, why))) => *why += &format!("; {piece}"),
            (None, None) => all.push((piece.to_owned(), String::new())),
        }
    }
    all
}

/// Reads `3 too fast, 1 not finite`.
fn reasons(text: &str) -> Option<Vec<(String, u64)>> {
    let pieces = text.split(", ").filter(|piece| !piece.is_empty());
    pieces
        .map(|piece| {
            let (n, why) = piece.split_once(' ')?;
            Some((why.to_owned(), n.parse().ok()?))
        })
        .collect()
}

/// Tables for the tests of what is made of them.
#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    const HEAD: &str = "move,iteration,rule,blocked,parts,actuators,value,accepted,best,temperature,evaluations,invalid,unstable,why_invalid";

    /// The moves of a table of rows without its head.
    pub(crate) fn table(rows: &str) -> Vec<Move> {
        parse(&format!("{HEAD}\n{rows}"), false, Starts::default()).unwrap()
    }

    #[test]
    fn a_move_starts_from_the_current_design() {
        let moves = table(
            "0,0,,,1,0,1,true,1,0,1,0,0,\n\
             1,0,add,turn: solid; undo: no match,2,0,3,true,3,9,3,1,1,\"2 too fast, 1 not finite\"\n\
             2,0,turn,,2,0,2,false,3,9,4,0,0,\n\
             3,0,undo,,1,0,,false,3,9,5,0,0,\n\
             4,0,,add: no match,2,0,,false,3,9,5,0,0,\n\
             5,0,add,,2,0,4,true,4,9,6,0,0,\n",
        );
        let from: Vec<_> = moves.iter().map(|m| m.from).collect();
        assert_eq!(from, [None, Some(1.0), Some(3.0), Some(3.0), Some(3.0), Some(3.0)]);
        let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        assert_eq!(moves[1].blocked, [pair("turn", "solid"), pair("undo", "no match")]);
        assert_eq!(moves[1].missing, [("too fast".to_owned(), 2), ("not finite".to_owned(), 1)]);
        assert_eq!((moves[4].rule.as_deref(), moves[5].rule.as_deref()), (None, Some("add")));
    }

    #[test]
    fn columns_are_found_by_name_and_chains_have_designs_of_their_own() {
        let text = format!("later,{HEAD},chain\n")
            + "x,0,0,,,1,0,1,true,1,0,1,0,0,,0\n"
            + "x,1,0,add,,2,0,5,true,5,9,2,0,0,,0\n"
            + "x,2,0,add,,2,0,2,true,5,9,3,0,0,,1\n"
            + "x,3,0,add,,2,0,6,false,6,9,4,0,0,,1\n"
            + "x,4,0,add,,2,0,6,false,6,9,5,0,0,,0\n";
        let from: Vec<_> = parse(&text, false, Starts::default()).unwrap().iter().map(|m| m.from).collect();
        assert_eq!(from, [None, Some(1.0), Some(1.0), Some(2.0), Some(5.0)]);
    }

    #[test]
    fn what_rows_do_not_tell_is_not_known() {
        let rows = "0,0,,,1,0,1,true,1,0,1,0,0,\n\
                    1,0,add,,2,0,2,true,2,9,2,0,0,\n\
                    2,0,add,,2,0,3,true,3,9,3,0,0,\n\
                    3,1,add,,2,0,4,false,4,9,4,0,0,\n\
                    4,1,add,,2,0,5,true,5,9,5,0,0,\n\
                    5,1,add,,2,0,6,true,6,9,6,0,0,\n";
        let from = |starts| {
            let moves = parse(&format!("{HEAD}\n{rows}"), false, starts).unwrap();
            moves.iter().skip(1).map(|m| m.from).collect::<Vec<_>>()
        };
        let none = Starts::default();
        let plain = [Some(1.0), Some(2.0), Some(3.0), Some(3.0), Some(5.0)];
        assert_eq!(from(none), plain);
        assert_eq!(from(Starts { archive: true, ..none }), [None; 5]);
        // After the walk all begins with the initial design again.
        let walked = [Some(1.0), Some(2.0), Some(1.0), Some(1.0), Some(5.0)];
        assert_eq!(from(Starts { walk: Some(2), ..none }), walked);
        // Places may have been changed before the fourth row.
        assert_eq!(from(Starts { exchange: true, ..none }), [Some(1.0), Some(2.0), None, None, Some(5.0)]);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        let good = format!("{HEAD}\n0,0,,,1,0,1,true,1,0,1,0,0,\n");
        let cut = format!("{good}1,0,add,,2,0,5,tr");
        for (text, says) in [
            (String::new(), "it is empty"),
            (cut.clone(), "its last row is not complete"),
            (good.replace("rule,", "ruler,"), "no column `rule`"),
            (format!("{good}1,0\n"), "line 3 has 2 fields, where its first line names 14 columns"),
            (good.replace(",1,true", ",one,true"), "line 2 has `one` in the column `value`"),
            (good.replace(",1,true", ",NaN,true"), "line 2 has `NaN` in the column `value`"),
            (good.replace("true", "yes"), "line 2 has `yes` in the column `accepted`"),
            (good.replace("1,0,0,\n", "1,0,0,many\n"), "`many` in the column `why_invalid`"),
        ] {
            let told = parse(&text, false, Starts::default()).unwrap_err();
            assert!(told.contains(says), "{told} / {says}");
        }
        assert_eq!(
            parse(&cut, true, Starts::default()).unwrap().len(),
            1,
            "a run under way may have half a row"
        );
        assert_eq!(parse(&format!("{HEAD}\n"), false, Starts::default()).unwrap(), []);
    }

    #[test]
    fn a_condition_may_stand_for_the_name_of_a_requirement() {
        let pairs = blocked("add: a; b; undo: c: d");
        assert_eq!(pairs, [("add".into(), "a; b".into()), ("undo".into(), "c: d".into())]);
    }
}
