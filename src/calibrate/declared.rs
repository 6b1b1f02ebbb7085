//! What the grammar declares of what is measured.

use grammar_lang::diagnostics::did_you_mean;
use grammar_lang::ir::{Actuator, Backend, Field, JointKind, Kind, Motor, Part, RuleSet, Table, Tendon};
use grammar_lang::units::{Dimension, parse, shown, suggest};

use super::measurements::Section;
use super::problem::{Location, Problem, listed};

/// A part or an actuator.
pub(super) enum Declared<'a> {
    /// A passive part.
    Part(&'a Part),
    /// An actuator.
    Actuator(&'a Actuator),
}

impl Declared<'_> {
    /// Mass in kg; of an actuator, that of one segment. None if it depends on parameters of the part.
    pub(super) fn mass(&self) -> Option<f64> {
        match self {
            Self::Part(part) => part.mass.fixed(),
            Self::Actuator(actuator) => actuator.mass.fixed(),
        }
    }

    /// Coulomb coefficient of its surface; none if it depends on parameters of the part.
    pub(super) fn friction(&self) -> Option<f64> {
        match self {
            Self::Part(part) => part.friction.fixed().copied(),
            Self::Actuator(actuator) => actuator.friction.fixed().copied(),
        }
    }
}

/// What one number cannot say, as it is another for each part.
pub(super) fn varies(name: &str, field: &str, place: &Location) -> Problem {
    Problem::contradiction(
        place,
        format!(
            "`{name}.{field}` depends on the parameters of each `{name}`, so one number cannot replace it: measure the values that it is calculated from, and write them into the grammar"
        ),
    )
}

/// An actuator that bends: what a bench measures.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bender<'a> {
    /// How far it bends, rad; none if it depends on parameters of each.
    pub(super) bend: Option<(f64, f64)>,
    /// What drives it.
    pub(super) motor: &'a Motor,
}

impl<'a> Bender<'a> {
    fn of(actuator: &'a Actuator) -> Option<Self> {
        let motor = actuator.motor.as_ref().filter(|_| actuator.joint.kind == JointKind::Bend)?;
        Some(Self { bend: actuator.joint.range.as_ref().and_then(Field::fixed).copied(), motor })
    }
}

/// The bending actuator that a section is for: the one that it names, or the only one that there is.
pub(super) fn actuator<'a>(rules: &'a RuleSet, section: &Section) -> Result<(String, Bender<'a>), Problem> {
    let benders: Vec<(&String, Bender<'_>)> =
        rules.actuators.iter().filter_map(|(name, actuator)| Some((name, Bender::of(actuator)?))).collect();
    let names = || benders.iter().map(|(name, _)| name.as_str());
    match section.setting("for") {
        Some((name, place)) => match benders.iter().find(|(known, _)| *known == name) {
            Some((_, bender)) => Ok((name.clone(), *bender)),
            None => Err(unknown("bending actuator", name, names(), place)),
        },
        None => match benders.as_slice() {
            [(name, bender)] => Ok(((*name).clone(), *bender)),
            _ => Err(unsaid("bending actuator", names(), section)),
        },
    }
}

/// The target whose threads bend an actuator: the one that the section names, or the only one that there is.
/// None, if the grammar declares none.
pub(super) fn threads<'a>(
    rules: &'a RuleSet,
    section: &Section,
    actuator: &str,
) -> Result<Option<(&'a str, &'a Tendon)>, Problem> {
    let fit: Vec<(&str, &Tendon)> = (rules.targets.iter())
        .filter_map(|(name, target)| match &target.backend {
            Backend::Tendon(threads) if target.kind == actuator => Some((name.as_str(), threads)),
            _ => None,
        })
        .collect();
    let names = || fit.iter().map(|(name, _)| *name);
    match (section.setting("target"), fit.as_slice()) {
        (Some((wanted, place)), _) => match fit.iter().find(|(name, _)| name == wanted) {
            Some(found) => Ok(Some(*found)),
            None => Err(unknown("target on tendon", wanted, names(), place)),
        },
        (None, []) => Ok(None),
        (None, [only]) => Ok(Some(*only)),
        (None, _) => Err(Problem::unreadable(
            &section.place,
            format!(
                "`{}` does not name its target; write `target = \"...\"`: the grammar declares {}",
                section.name,
                listed(names())
            ),
        )),
    }
}

/// A table of the grammar in a few words.
pub(super) fn tabulated(table: &Table, dimension: Dimension) -> String {
    let ends = table.rows.first().zip(table.rows.last());
    let factor = parse(&suggest(dimension)).map_or(1.0, |unit| unit.factor);
    let number = |x: f64| shown(x / factor, Dimension::NUMBER);
    ends.map_or_else(String::new, |(first, last)| {
        format!("{} .. {} ({} rows)", number(first[1]), shown(last[1], dimension), table.rows.len())
    })
}

/// The part or actuator with a name.
pub(super) fn part<'a>(rules: &'a RuleSet, name: &str, place: &Location) -> Result<Declared<'a>, Problem> {
    match rules.kind(name) {
        Some(Kind::Block(part)) => Ok(Declared::Part(part)),
        Some(Kind::Actuator(actuator)) => Ok(Declared::Actuator(actuator)),
        Some(Kind::Cell(_)) | None => Err(unknown("part or actuator", name, part_names(rules), place)),
    }
}

fn part_names(rules: &RuleSet) -> impl Iterator<Item = &str> {
    rules.parts.keys().chain(rules.actuators.keys()).map(String::as_str)
}

/// The part that each row of a section is about: its column `part`, or what the section is for.
pub(super) fn parts(rules: &RuleSet, section: &Section) -> Result<Vec<String>, Problem> {
    let words = section.words("part");
    match section.setting("for") {
        _ if !words.is_empty() => Ok(words.to_vec()),
        Some((name, _)) => Ok(vec![name.clone(); section.places.len()]),
        None => Err(unsaid("part", part_names(rules), section)),
    }
}

fn unsaid<'a>(what: &str, names: impl Iterator<Item = &'a str>, section: &Section) -> Problem {
    let names: Vec<&str> = names.collect();
    let there = if names.is_empty() {
        "the grammar declares none".to_owned()
    } else {
        format!("the grammar declares {}", listed(names))
    };
    let how = if section.place.file.to_lowercase().ends_with(".csv") {
        format!("name the file in a section of a TOML file, with `for = \"...\"`: {there}")
    } else {
        format!("write `for = \"...\"`: {there}")
    };
    Problem::unreadable(
        &section.place,
        format!("`{}` does not name the {what} that it is for; {how}", section.name),
    )
}

fn unknown<'a>(what: &str, name: &str, names: impl Iterator<Item = &'a str>, place: &Location) -> Problem {
    let names: Vec<&str> = names.collect();
    let help = did_you_mean(name, names.iter().copied()).unwrap_or_else(|| {
        if names.is_empty() {
            "it declares none".to_owned()
        } else {
            format!("it declares {}", listed(&names))
        }
    });
    Problem::contradiction(place, format!("the grammar declares no {what} `{name}`: {help}"))
}
