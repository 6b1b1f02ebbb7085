//! The table of moves, read again. Columns are found by their names: others may stand beside them.

use super::error::{BadMoves, ReportError};
use std::path::Path;

use csv::StringRecord;

use crate::results::columns::OBSERVED;
use crate::results::evals::BESIDE;
use crate::results::whole::read;

/// One row of `evals.csv`.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Move {
    /// 0 is the initial design.
    pub(crate) number: u64,
    pub(crate) iteration: u64,
    /// The rule that was applied; none if none could be, where curves were tuned further, and for the initial design.
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
    /// What it comes to in the objectives beside the first, where a front is searched for and it has a value.
    pub(crate) beside: Vec<f64>,
    /// What was observed of it, by name; empty where it has no value.
    pub(crate) observed: Vec<(String, String)>,
    /// The move that made the design that it started from; none for the initial design, and in tables of before version
    /// 0.2, which do not tell.
    pub(crate) parent: Option<u64>,
    /// How often the curves of this body were tuned before.
    pub(crate) tuned: u64,
    /// The value of that design.
    pub(crate) from: Option<f64>,
}

impl Move {
    /// Whether no rule could be applied.
    pub(crate) fn did_nothing(&self) -> bool {
        self.number > 0 && self.rule.is_none() && self.tuned == 0
    }
}

/// Reads the moves of a run. A last row that is not written to its end is left out where the run
/// `may_be_cut`: it is under way, or was killed.
///
/// # Errors
///
/// What is wrong with the file, and where.
pub(crate) fn moves(path: &Path, may_be_cut: bool) -> Result<Vec<Move>, ReportError> {
    parse(&read(path)?, may_be_cut).map_err(|why| ReportError::Moves { path: path.to_owned(), why })
}

fn parse(text: &str, may_be_cut: bool) -> Result<Vec<Move>, BadMoves> {
    let whole = match text.rfind('\n') {
        Some(end) if may_be_cut => text.get(..=end).unwrap_or(text),
        _ if text.is_empty() => return Err(BadMoves::Empty),
        Some(end) if end + 1 == text.len() => text,
        _ => return Err(BadMoves::Cut),
    };
    let mut reader = csv::Reader::from_reader(whole.as_bytes());
    let head = reader.headers().map_err(unread)?.clone();
    let columns = Columns::new(&head)?;
    let mut moves = Vec::new();
    for record in reader.records() {
        let record = record.map_err(unread)?;
        let made = columns.read(&record)?;
        if let Some(before) = moves
            .last()
            .filter(|before: &&Move| made.number <= before.number || made.evaluations < before.evaluations)
        {
            let line = record.position().map_or(0, csv::Position::line);
            return Err(BadMoves::Order { line, number: made.number, before: before.number });
        }
        moves.push(made);
    }
    start(&mut moves);
    Ok(moves)
}

/// Finds the values that moves started from.
fn start(moves: &mut [Move]) {
    let from: Vec<_> = moves.iter().map(|made| numbered(moves, made.parent?)?.value).collect();
    moves.iter_mut().zip(from).for_each(|(made, from)| made.from = from);
}

/// The move of a number. They stand in their order.
fn numbered(moves: &[Move], number: u64) -> Option<&Move> {
    moves.binary_search_by_key(&number, |made| made.number).ok().and_then(|i| moves.get(i))
}

/// The moves that led to one of them, from it back to the initial design; none if that is not known.
pub(crate) fn lineage<'a>(moves: &'a [Move], last: &'a Move) -> Option<Vec<&'a Move>> {
    let mut line = vec![last];
    let mut at = last;
    while at.number > 0 {
        // A parent is older than what is made of it.
        at = numbered(moves, at.parent.filter(|parent| *parent < at.number)?)?;
        line.push(at);
    }
    Some(line)
}

fn unread(error: csv::Error) -> BadMoves {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => BadMoves::OtherLength {
            line: pos.as_ref().map_or(0, csv::Position::line),
            found: *len,
            wanted: *expected_len,
        },
        _ => BadMoves::Csv(error),
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

    fn new(head: &'a StringRecord) -> Result<Self, BadMoves> {
        match Self::NEEDED.iter().find(|needed| !head.iter().any(|name| name == **needed)) {
            Some(missing) => Err(BadMoves::NoColumn(missing)),
            None => Ok(Self { head }),
        }
    }

    /// A field by the name of its column; empty if there is no such column.
    fn field<'r>(&self, record: &'r StringRecord, name: &str) -> &'r str {
        self.head.iter().position(|column| column == name).and_then(|i| record.get(i)).unwrap_or("")
    }

    fn read(&self, record: &StringRecord) -> Result<Move, BadMoves> {
        let text = |name| self.field(record, name);
        let wrong = |column: &'static str| {
            let line = record.position().map_or(0, csv::Position::line);
            BadMoves::Field { line, text: self.field(record, column).to_owned(), column }
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
            beside: self.beside(record)?,
            observed: self.observed(record),
            parent: if text("parent").is_empty() { None } else { Some(count("parent")?) },
            tuned: if text("tuned").is_empty() { 0 } else { count("tuned")? },
            from: None,
        })
    }

    /// The columns of the objectives beside the first; nothing where one is empty.
    fn beside(&self, record: &StringRecord) -> Result<Vec<f64>, BadMoves> {
        let own = self.head.iter().zip(record).filter(|(name, _)| name.starts_with(BESIDE));
        let wrong = |text: &str| {
            let line = record.position().map_or(0, csv::Position::line);
            BadMoves::Field { line, text: text.to_owned(), column: "objective" }
        };
        let mut values = Vec::new();
        for (_, text) in own {
            match text.parse::<f64>() {
                _ if text.is_empty() => return Ok(Vec::new()),
                Ok(value) if value.is_finite() => values.push(value),
                Ok(_) | Err(_) => return Err(wrong(text)),
            }
        }
        Ok(values)
    }

    /// The columns that stand after the last of every table.
    fn observed(&self, record: &StringRecord) -> Vec<(String, String)> {
        let place = |name| self.head.iter().position(|column| column == name);
        let Some(last) = ["at_most_in", "tuned", "parent", "chain"].into_iter().find_map(place) else {
            return Vec::new();
        };
        let more = self.head.iter().zip(record).skip(last + 1).filter(|(_, text)| !text.is_empty());
        let own = |name: &str| name.strip_prefix(OBSERVED).unwrap_or(name).to_owned();
        more.map(|(name, text)| (own(name), text.to_owned())).collect()
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

/// Reads `3 too fast, 1 not finite`. What stands in brackets after a reason, of which worlds it is true, is left out.
fn reasons(text: &str) -> Option<Vec<(String, u64)>> {
    let pieces = text.split(", ").filter(|piece| !piece.is_empty());
    pieces
        .map(|piece| {
            let (n, why) = piece.split_once(' ')?;
            let worlds =
                why.split_once(" (").filter(|(_, more)| more.starts_with(|c: char| c.is_ascii_digit()));
            let why = worlds.map_or(why, |(why, _)| why);
            Some((why.to_owned(), n.parse().ok()?))
        })
        .collect()
}

/// Tables for the tests of what is made of them.
#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::search::Tally;
    use crate::simulate::Invalid;

    const HEAD: &str = "move,iteration,rule,blocked,parts,actuators,value,accepted,best,temperature,evaluations,invalid,unstable,why_invalid";

    /// The moves of a table of rows without its head, each made of the last that was accepted.
    pub(crate) fn table(rows: &str) -> Vec<Move> {
        let mut moves = parse(&format!("{HEAD}\n{rows}"), false).unwrap();
        let mut current = None;
        for made in &mut moves {
            made.parent = current;
            current = if made.accepted { Some(made.number) } else { current };
        }
        start(&mut moves);
        moves
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
    fn what_a_run_counted_is_read_again() {
        let tally = Tally {
            elsewhere: [("`icy`: too fast".to_owned(), 2), ("`wet`: too fast".to_owned(), 1)].into(),
            invalid: [(Invalid::NotFinite, 1)].into(),
            diverged: 3,
            ..Tally::default()
        };
        let text = tally.reasons_in_worlds();
        assert!(text.contains("(2 in `icy`: too fast; 1 in `wet`: too fast)"), "{text}");
        let read = reasons(&text).unwrap();
        let counted: Vec<(String, u64)> = tally.by_reason().map(|(why, n)| (why.to_owned(), n)).collect();
        assert_eq!(read, counted);
    }

    #[test]
    fn columns_are_found_by_name_and_what_is_observed_stands_behind_them() {
        let text = format!("later,{HEAD},chain,parent,gait\n")
            + "x,0,0,,,1,0,1,true,1,0,1,0,0,,0,,still\n"
            + "x,1,0,add,,2,0,5,true,5,9,2,0,0,,0,0,walker\n"
            + "x,2,0,add,,2,0,2,true,5,9,3,0,0,,1,0,\n"
            + "x,3,0,add,,2,0,6,false,6,9,4,0,0,,1,2,\n"
            + "x,4,0,add,,2,0,6,false,6,9,5,0,0,,0,1,\n";
        let moves = parse(&text, false).unwrap();
        let from: Vec<_> = moves.iter().map(|m| m.from).collect();
        assert_eq!(from, [None, Some(1.0), Some(1.0), Some(2.0), Some(5.0)]);
        assert_eq!(moves[1].observed, [("gait".to_owned(), "walker".to_owned())]);
        let line = |number: usize| {
            let line = lineage(&moves, &moves[number]).unwrap();
            line.iter().map(|made| made.number).collect::<Vec<_>>()
        };
        assert_eq!((line(0), line(3), line(4)), (vec![0], vec![3, 2, 0], vec![4, 1, 0]));
    }

    #[test]
    fn what_a_table_does_not_tell_is_not_known() {
        let rows = "0,0,,,1,0,1,true,1,0,1,0,0,\n1,0,add,,2,0,2,true,2,9,2,0,0,\n";
        let moves = parse(&format!("{HEAD}\n{rows}"), false).unwrap();
        assert_eq!((moves[1].from, lineage(&moves, &moves[1])), (None, None));
        // Nor does it go round in circles.
        let rows = "0,0,,,1,0,1,true,1,0,1,0,0,,\n1,0,add,,2,0,2,true,2,9,2,0,0,,1\n";
        let moves = parse(&format!("{HEAD},parent\n{rows}"), false).unwrap();
        assert_eq!(lineage(&moves, &moves[1]), None);
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
            (format!("{good}0,0,add,,2,0,2,true,2,9,2,0,0,\n"), "line 3 tells of move 0 after move 0"),
            (format!("{good}1,0,add,,2,0,2,true,2,9,0,0,0,\n"), "line 3 tells of move 1 after move 0"),
        ] {
            let told = parse(&text, false).unwrap_err().to_string();
            assert!(told.contains(says), "{told} / {says}");
        }
        assert_eq!(parse(&cut, true).unwrap().len(), 1, "a run under way may have half a row");
        assert_eq!(parse(&format!("{HEAD}\n"), false).unwrap(), []);
    }

    #[test]
    fn a_condition_may_stand_for_the_name_of_a_requirement() {
        let pairs = blocked("add: a; b; undo: c: d");
        assert_eq!(pairs, [("add".into(), "a; b".into()), ("undo".into(), "c: d".into())]);
    }
}
