//! Reads the measurements of a bench: a TOML file with a section for each, or one CSV file.

use std::collections::BTreeMap;
use std::io;

use grammar_lang::diagnostics::did_you_mean;
use grammar_lang::units::{self, Dimension, UnitError};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::kind::{Column, Kind};
use super::problem::{Location, Problem, listed};

/// One measurement, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// What is measured.
    pub kind: Kind,
    /// What the file calls it.
    pub name: String,
    /// Where it begins.
    pub place: Location,
    /// What it says beside its columns: `for`, `target`, `tolerance`, each with its place.
    pub(super) settings: BTreeMap<String, (String, Location)>,
    /// The file that its rows stand in, as it is called from where the measurements are.
    pub source: String,
    /// Where each of its rows stands.
    pub(super) places: Vec<Location>,
    numbers: BTreeMap<&'static str, Vec<f64>>,
    words: BTreeMap<&'static str, Vec<String>>,
}

impl Section {
    /// The numbers of a column, in SI units; none where there is no such column.
    pub(super) fn numbers(&self, column: &str) -> &[f64] {
        self.numbers.get(column).map_or(&[], Vec::as_slice)
    }

    /// The words of a column; none where there is no such column.
    pub(super) fn words(&self, column: &str) -> &[String] {
        self.words.get(column).map_or(&[], Vec::as_slice)
    }

    /// The columns that it has.
    pub(super) fn columns(&self) -> impl Iterator<Item = &'static str> {
        self.numbers.keys().chain(self.words.keys()).copied()
    }

    /// Where a row stands.
    pub(super) fn place(&self, row: usize) -> &Location {
        self.places.get(row).unwrap_or(&self.place)
    }

    /// What it says beside its columns.
    pub(super) fn setting(&self, key: &str) -> Option<&(String, Location)> {
        self.settings.get(key)
    }
}

/// A cell of a column, before anything is known of it.
struct Cell {
    text: String,
    place: Location,
}

/// A column as it was found: a single value counts for all rows.
struct Raw {
    header: String,
    place: Location,
    cells: Vec<Cell>,
    is_single: bool,
}

/// Reads a file that a file of measurements names: what messages call it, and its text; or why it cannot be read.
pub type Load<'a> = dyn Fn(&str) -> io::Result<(String, String)> + 'a;

/// What a file of measurements holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// The measurements that could be read, in their order.
    pub sections: Vec<Section>,
    /// All that is wrong with the others.
    pub problems: Vec<Problem>,
}

impl Reading {
    /// How many points were measured, of all sections.
    #[must_use]
    pub fn points(&self) -> usize {
        self.sections.iter().map(|section| section.places.len()).sum()
    }
}

/// Reads measurements. `name` is what messages call the file; `load` reads another file that it names, and says
/// what messages call that. A file whose name ends with `.csv` is one section.
pub fn read(name: &str, text: &str, load: &Load<'_>) -> Reading {
    let text = text.trim_start_matches('\u{feff}');
    let mut problems = Vec::new();
    let is_csv = name.to_lowercase().ends_with(".csv");
    let sections =
        if is_csv { alone(name, text, &mut problems) } else { document(name, text, load, &mut problems) };
    if sections.is_empty() && problems.is_empty() {
        let place = Location { file: name.to_owned(), line: 1 };
        problems.push(Problem::unreadable(&place, "this file contains no measurement"));
    }
    Reading { sections, problems }
}

/// A CSV file without a TOML file around it.
fn alone(name: &str, text: &str, problems: &mut Vec<Problem>) -> Vec<Section> {
    let place = Location { file: name.to_owned(), line: 1 };
    let columns = csv(name, text, problems);
    let file = last_of(name);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    section(stem, &place, BTreeMap::new(), file, columns, problems).into_iter().collect()
}

/// The name of a file without its folders.
fn last_of(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

fn document(name: &str, text: &str, load: &Load<'_>, problems: &mut Vec<Problem>) -> Vec<Section> {
    let breaks: Vec<usize> = text.match_indices('\n').map(|(offset, _)| offset).collect();
    let line = |offset: usize| 1 + breaks.partition_point(|end| *end < offset);
    let at = |offset: usize| Location { file: name.to_owned(), line: line(offset) };
    let (root, errors) = DeTable::parse_recoverable(text);
    for error in &errors {
        let place = at(error.span().map_or(0, |span| span.start));
        let message = error.message();
        let message = if message.contains("duplicate key") {
            "this section or key occurs twice; give the second one another name".to_owned()
        } else {
            format!("this is not valid TOML: {message}")
        };
        problems.push(Problem::unreadable(&place, message));
    }
    if !errors.is_empty() {
        // What an error hides cannot be judged.
        return Vec::new();
    }
    let start_of = |line: usize| line.checked_sub(2).map_or(0, |before| breaks[before] + 1);
    let mut entries: Vec<_> = root.get_ref().iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    let mut sections = Vec::new();
    for (key, value) in entries {
        let place = at(key.span().start);
        let key = key.get_ref().as_ref();
        match value.get_ref() {
            DeValue::Table(table) => {
                sections.extend(one(key, &place, table, &at, load, problems));
            }
            DeValue::Array(_) if text[start_of(place.line)..].starts_with("[[") => {
                problems.push(Problem::unreadable(
                    &place,
                    format!("write `[{key}]`, and give each section a name of its own"),
                ));
            }
            _ => problems.push(Problem::unreadable(
                &place,
                format!("`{key}` is outside all sections: write a line such as `[bender_thread]` above it"),
            )),
        }
    }
    sections
}

/// A section of a document.
fn one(
    name: &str,
    place: &Location,
    table: &DeTable<'_>,
    at: &dyn Fn(usize) -> Location,
    load: &Load<'_>,
    problems: &mut Vec<Problem>,
) -> Option<Section> {
    let mut settings = BTreeMap::new();
    let mut columns = Vec::new();
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    let before = problems.len();
    for (key, value) in entries {
        let place = at(key.span().start);
        let key = key.get_ref().as_ref();
        if ["kind", "for", "file", "target", "tolerance"].contains(&key) {
            match value.get_ref() {
                DeValue::String(text) => {
                    settings.insert(key.to_owned(), (text.to_string(), place));
                }
                _ => problems.push(Problem::unreadable(
                    &place,
                    format!("write `{key} = \"...\"`, with text in quotes"),
                )),
            }
            continue;
        }
        let (cells, is_single): (Vec<&Spanned<DeValue<'_>>>, bool) = match value.get_ref() {
            DeValue::Array(array) => (array.iter().collect(), false),
            _ => (vec![value], true),
        };
        let mut read = Vec::new();
        for cell in cells {
            let place = at(cell.span().start);
            match text_of(cell.get_ref()) {
                Some(text) => read.push(Cell { text, place }),
                None => problems.push(Problem::unreadable(
                    &place,
                    format!(
                        "column `{key}` contains a value of the type {}: write numbers or text",
                        cell.get_ref().type_str()
                    ),
                )),
            }
        }
        columns.push(Raw { header: key.to_owned(), place, cells: read, is_single });
    }
    let mut source = last_of(&place.file).to_owned();
    if let Some((file, at)) = settings.get("file") {
        match load(file) {
            Ok((name, text)) => {
                let text = text.trim_start_matches('\u{feff}');
                columns.extend(csv(&name, text, problems));
                source.clone_from(file);
            }
            Err(e) => problems.push(Problem::unreadable(at, format!("cannot read {file}: {e}"))),
        }
    }
    if problems.len() > before {
        return None;
    }
    section(name, place, settings, &source, columns, problems)
}

fn text_of(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.to_string()),
        DeValue::Integer(number) => Some(number.as_str().replace('_', "")),
        DeValue::Float(number) => Some(number.as_str().replace('_', "")),
        _ => None,
    }
}

/// The columns of a CSV file. Where semicolons part them, numbers may have a decimal comma.
fn csv(name: &str, text: &str, problems: &mut Vec<Problem>) -> Vec<Raw> {
    let at = |line: u64| Location { file: name.to_owned(), line: usize::try_from(line).unwrap_or(1).max(1) };
    let header = text.lines().find(|l| !l.trim().is_empty() && !l.starts_with('#')).unwrap_or("");
    let delimiter = [b';', b'\t', b','].into_iter().find(|d| header.as_bytes().contains(d)).unwrap_or(b',');
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .delimiter(delimiter)
        .from_reader(text.as_bytes());
    let mut columns: Vec<Raw> = Vec::new();
    for (i, record) in reader.records().enumerate() {
        let record = match record {
            Ok(record) => record,
            Err(e) => {
                let line = e.position().map_or(1, csv::Position::line);
                problems.push(Problem::unreadable(&at(line), format!("this is not valid CSV: {e}")));
                return Vec::new();
            }
        };
        let place = at(record.position().map_or(1, |position| beginning(text, position)));
        if i == 0 {
            columns.extend(record.iter().map(|header| Raw {
                header: header.to_owned(),
                place: place.clone(),
                cells: Vec::new(),
                is_single: false,
            }));
            continue;
        }
        // Spreadsheets leave rows of nothing but separators.
        if record.iter().all(str::is_empty) {
            continue;
        }
        if record.len() != columns.len() {
            problems.push(Problem::unreadable(
                &place,
                format!("this row has {} cells, but the header has {}", record.len(), columns.len()),
            ));
            continue;
        }
        for (column, cell) in columns.iter_mut().zip(record.iter()) {
            let text = if delimiter == b';' { cell.replacen(',', ".", 1) } else { cell.to_owned() };
            column.cells.push(Cell { text, place: place.clone() });
        }
    }
    columns
}

/// The line of a record: it is said to begin where the one before it ended, also where blank lines and
/// comments follow.
fn beginning(text: &str, position: &csv::Position) -> u64 {
    let rest = usize::try_from(position.byte()).ok().and_then(|byte| text.get(byte..)).unwrap_or("");
    let skipped = rest.split('\n').take_while(|line| line.trim().is_empty() || line.starts_with('#'));
    position.line() + skipped.count() as u64
}

/// The name and the unit of a header such as `angle [deg]`.
fn header(text: &str) -> (String, Option<&str>) {
    match text.split_once('[') {
        Some((name, unit)) => (name.trim().to_lowercase(), Some(unit.trim().trim_end_matches(']').trim())),
        None => (text.trim().to_lowercase(), None),
    }
}

/// Makes sense of columns.
fn section(
    name: &str,
    place: &Location,
    settings: BTreeMap<String, (String, Location)>,
    source: &str,
    columns: Vec<Raw>,
    problems: &mut Vec<Problem>,
) -> Option<Section> {
    let before = problems.len();
    let names: Vec<String> = columns.iter().map(|c| header(&c.header).0).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let kind =
        kind_of(name, place, settings.get("kind"), &names).map_err(|problem| problems.push(problem)).ok()?;
    for (key, (_, at)) in &settings {
        if !kind.settings().contains(&key.as_str()) {
            problems.push(Problem::unreadable(
                at,
                format!("`{key}` does not belong to a measurement of kind `{}`", kind.text()),
            ));
        }
    }
    // Instruments write columns that nobody asked for; people do not.
    let is_own = |raw: &Raw| raw.place.file == place.file && settings.contains_key("kind");
    unknown_columns(kind, &columns, &names, is_own, problems);
    let mut section = Section {
        kind,
        name: name.to_owned(),
        place: place.clone(),
        settings: settings.clone(),
        source: source.to_owned(),
        places: Vec::new(),
        numbers: BTreeMap::new(),
        words: BTreeMap::new(),
    };
    read_columns(&mut section, &columns, &names, problems);
    if problems.len() > before {
        return None;
    }
    let longest = columns.iter().filter(|c| !c.is_single).max_by_key(|c| c.cells.len());
    let longest = longest.or(columns.first());
    section.places = longest.map_or(Vec::new(), |c| c.cells.iter().map(|cell| cell.place.clone()).collect());
    if !settings.contains_key("kind") {
        section.kind = kind.with_direction(section.numbers.get("angle"));
    }
    Some(section)
}

/// What is measured: what is said, or what the columns tell.
fn kind_of(
    name: &str,
    place: &Location,
    said: Option<&(String, Location)>,
    names: &[&str],
) -> Result<Kind, Problem> {
    if let Some((text, at)) = said {
        let all = Kind::ALL.map(Kind::text);
        return Kind::ALL.into_iter().find(|kind| kind.text() == text).ok_or_else(|| {
            let help = did_you_mean(text, all).unwrap_or_else(|| format!("the kinds are {}", listed(all)));
            Problem::unreadable(at, format!("there is no kind of measurement `{text}`: {help}"))
        });
    }
    Kind::by_columns(names).ok_or_else(|| {
        let there = if names.is_empty() {
            "there are no columns".to_owned()
        } else {
            format!("they are {}", listed(names))
        };
        Problem::unreadable(
            place,
            format!(
                "the columns of `{name}` do not show what it measures: {there}. Write `kind = \"...\"` with one of {}",
                listed(Kind::ALL.map(Kind::text))
            ),
        )
    })
}

/// Reports columns that a kind does not have: those that people wrote, and those that are nearly a known one.
fn unknown_columns(
    kind: Kind,
    columns: &[Raw],
    names: &[&str],
    is_own: impl Fn(&Raw) -> bool,
    problems: &mut Vec<Problem>,
) {
    let known = kind.columns();
    for (raw, name) in columns.iter().zip(names) {
        let is_known = known.iter().any(|c| c.name == *name);
        let guess = did_you_mean(name, known.iter().map(|c| c.name).filter(|c| !names.contains(c)));
        if !is_known && (is_own(raw) || guess.is_some()) {
            let help = guess.unwrap_or_else(|| format!("its columns can be {}", examples(known)));
            problems.push(Problem::unreadable(
                &raw.place,
                format!("`{}` is not a column of the kind `{}`: {help}", raw.header, kind.text()),
            ));
        }
    }
}

/// Fills a section with the columns that its kind has.
fn read_columns(section: &mut Section, columns: &[Raw], names: &[&str], problems: &mut Vec<Problem>) {
    let rows = columns.iter().filter(|c| !c.is_single).map(|c| c.cells.len()).max();
    let rows = rows.unwrap_or_else(|| usize::from(!columns.is_empty()));
    let mut missing = Vec::new();
    for column in section.kind.columns() {
        let mut there = columns.iter().zip(names).filter(|(_, name)| **name == column.name);
        let Some((raw, _)) = there.next() else {
            if column.is_needed {
                missing.push(column.example());
            }
            continue;
        };
        if let Some((again, _)) = there.next() {
            problems
                .push(Problem::unreadable(&again.place, format!("there are two columns `{}`", column.name)));
        }
        if !raw.is_single && raw.cells.len() != rows {
            problems.push(Problem::unreadable(
                &raw.place,
                format!("`{}` has {} values, but another column has {rows}", raw.header, raw.cells.len()),
            ));
        } else {
            fill(section, column, raw, rows, problems);
        }
    }
    let name = &section.name;
    if !missing.is_empty() {
        let there = if names.is_empty() {
            "it has no columns".to_owned()
        } else {
            format!("its columns are {}", listed(columns.iter().map(|c| &c.header)))
        };
        problems.push(Problem::unreadable(
            columns.first().map_or(&section.place, |c| &c.place),
            format!("`{name}` of kind `{}` needs {}, but {there}", section.kind.text(), listed(&missing)),
        ));
    } else if rows == 0 {
        let message = format!("`{name}` has no rows: nothing was measured");
        problems.push(Problem::unreadable(&section.place, message));
    }
}

fn examples(columns: &[Column]) -> String {
    listed(columns.iter().map(Column::example))
}

/// Reads the cells of a column into a section.
fn fill(section: &mut Section, column: &Column, raw: &Raw, rows: usize, problems: &mut Vec<Problem>) {
    let (_, unit) = header(&raw.header);
    let Some(dimension) = column.measured_in() else {
        let words: Vec<String> = raw.cells.iter().map(|cell| cell.text.clone()).collect();
        for cell in raw.cells.iter().filter(|cell| cell.text.trim().is_empty()) {
            problems.push(Problem::unreadable(
                &cell.place,
                format!("the cell in column `{}` is empty", raw.header),
            ));
        }
        let all = if raw.is_single { words.iter().cycle().take(rows).cloned().collect() } else { words };
        section.words.insert(column.name, all);
        return;
    };
    let factor = match factor(column, dimension, unit) {
        Ok(factor) => factor,
        Err(message) => {
            problems.push(Problem::unreadable(&raw.place, format!("column `{}`: {message}", raw.header)));
            return;
        }
    };
    let most = if dimension == Dimension::ANGLE { LARGEST_ANGLE / factor } else { LARGEST };
    let mut numbers = Vec::with_capacity(raw.cells.len());
    for cell in &raw.cells {
        match cell.text.trim().replace('\u{2212}', "-").parse::<f64>() {
            Ok(number) if number.abs() <= most => numbers.push(number * factor),
            Ok(number) => {
                let why = if number.is_finite() { "too large for a measurement" } else { "not finite" };
                problems.push(Problem::unreadable(
                    &cell.place,
                    format!("`{}` in column `{}` is {why}", cell.text, raw.header),
                ));
            }
            Err(_) if cell.text.trim().is_empty() => problems.push(Problem::unreadable(
                &cell.place,
                format!("the cell in column `{}` is empty", raw.header),
            )),
            Err(_) => problems.push(Problem::unreadable(
                &cell.place,
                format!("`{}` in column `{}` is not a number", cell.text, raw.header),
            )),
        }
    }
    section.numbers.insert(column.name, if raw.is_single { numbers.repeat(rows) } else { numbers });
}

/// A reading beyond this is none, and statistics of it would overflow.
const LARGEST: f64 = 1e30;
/// So is an angle beyond this, rad: hundreds of turns.
const LARGEST_ANGLE: f64 = 1e4;

/// How much one of a column's unit is in SI units.
fn factor(column: &Column, dimension: Dimension, unit: Option<&str>) -> Result<f64, String> {
    let Some(text) = unit else {
        return if dimension.is_number() {
            Ok(1.0)
        } else {
            Err(format!("this needs a unit: write `{}`", column.example()))
        };
    };
    match units::parse(text) {
        Ok(unit) if unit.dimension == dimension => Ok(unit.factor),
        Ok(unit) => Err(format!(
            "`{text}` is a unit of {}, but {} is {}: {}",
            unit.dimension,
            column.name,
            with_article(dimension),
            would_do(dimension)
        )),
        Err(UnitError::TooHigh) => {
            Err(format!("the exponents of `{text}` are too large: {}", would_do(dimension)))
        }
        Err(UnitError::Unknown(word)) => {
            let meant = units::written_out(&word).map(|unit| format!("did you mean `{unit}`?"));
            let meant = meant.or_else(|| did_you_mean(&word, units::unit_names()));
            let meant = meant.map_or(String::new(), |meant| format!("{meant} "));
            Err(format!("there is no unit `{word}`: {meant}{}", would_do(dimension)))
        }
    }
}

fn with_article(dimension: Dimension) -> String {
    let name = dimension.to_string();
    let article = if name.starts_with(['A', 'E']) { "an" } else { "a" };
    format!("{article} {name}")
}

/// The units that a column could have.
fn would_do(dimension: Dimension) -> String {
    if dimension.is_number() {
        return "write no unit".to_owned();
    }
    let plain: Vec<String> = units::unit_names()
        .filter(|name| name.is_ascii() && units::parse(name).is_ok_and(|u| u.dimension == dimension))
        .map(str::to_owned)
        .collect();
    if !plain.is_empty() {
        return format!("write for example {}", listed(plain));
    }
    let speeds = ["m/s", "m/h", "cm/s", "mm/s"];
    let those = speeds.into_iter().filter(|s| units::parse(s).is_ok_and(|u| u.dimension == dimension));
    let those: Vec<&str> = those.collect();
    if those.is_empty() {
        format!("write for example `{}`", units::suggest(dimension))
    } else {
        format!("write for example {}", listed(those))
    }
}

/// Reads a quantity such as `1.5 mm`, in SI units.
pub(super) fn quantity(text: &str, dimension: Dimension) -> Option<f64> {
    let text = text.trim();
    let end = text.find(|c: char| c.is_alphabetic() || c == '%' || c == '°').unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    let number: f64 = number.trim().parse().ok()?;
    let unit = units::parse(unit.trim()).ok().filter(|unit| unit.dimension == dimension)?;
    Some(number * unit.factor).filter(|x| x.is_finite())
}
