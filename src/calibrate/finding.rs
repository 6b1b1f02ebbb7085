//! What measurements come to: numbers with the digits that the data support, and what is drawn of them.

use std::fmt;

use grammar_lang::units;

use super::problem::Location;

/// A number in a unit, with as many decimals as its error allows.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// The number in [`Figure::unit`].
    pub value: f64,
    /// The unit; empty for a bare number.
    pub unit: &'static str,
    decimals: usize,
}

impl Figure {
    /// A number in SI units and how far it may be off, to be written in a unit. The last digit is about as large as
    /// that; without it, at most three digits are written.
    pub(super) fn of(value: f64, error: Option<f64>, unit: &'static str) -> Self {
        let factor = units::parse(unit).map_or(1.0, |u| u.factor);
        let value = value / factor;
        let magnitude = |x: f64| libm::floor(libm::log10(x.abs()));
        let first = if value == 0.0 { 0.0 } else { magnitude(value) };
        let decimals = |last: f64| (-last).clamp(0.0, 9.0) as usize;
        match error.map(|e| e / factor) {
            Some(error) if error > 0.0 && error.is_finite() => {
                // One digit at least, four at most.
                let last = magnitude(error).clamp(first - 3.0, first);
                let step = libm::exp10(last);
                let value = if last > 0.0 { libm::round(value / step) * step } else { value };
                Self { value, unit, decimals: decimals(last) }
            }
            _ => Self::shortened(value, unit, decimals(first - 2.0)),
        }
    }

    /// A number in a unit with so many decimals.
    pub(super) fn with_decimals(value: f64, unit: &'static str, decimals: usize) -> Self {
        Self { value: value / units::parse(unit).map_or(1.0, |u| u.factor), unit, decimals }
    }

    /// A number in SI units as somebody wrote it down in a unit.
    pub(super) fn as_written(value: f64, unit: &'static str) -> Self {
        Self::shortened(value / units::parse(unit).map_or(1.0, |u| u.factor), unit, 6)
    }

    /// A number without zeros at its end.
    fn shortened(value: f64, unit: &'static str, decimals: usize) -> Self {
        let full = Self { value, unit, decimals };
        let decimals = full.digits(true).split_once('.').map_or(0, |(_, decimals)| decimals.len());
        Self { decimals, ..full }
    }

    /// The number in its unit as it is written: with its digits, and no others.
    pub(super) fn written(&self) -> f64 {
        self.digits(false).parse().unwrap_or(self.value)
    }

    /// The number without its unit, and without zeros that say nothing where `is_short`.
    pub(super) fn digits(&self, is_short: bool) -> String {
        let text = format!("{:.*}", self.decimals, self.value);
        let text = if is_short && text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        };
        // No minus sign before a zero.
        if text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.')) { text.replace('-', "") } else { text }
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.digits(false))?;
        if self.unit.is_empty() { Ok(()) } else { write!(f, " {}", self.unit) }
    }
}

/// A measured function: straight lines between its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Its name.
    pub name: String,
    /// What its first column measures, such as `Angle`.
    pub from: &'static str,
    /// What its second column measures.
    pub to: &'static str,
    /// Its rows; the first column ascends strictly.
    pub rows: Vec<(Figure, Figure)>,
    /// Where the second column lies nine times of ten, row by row, as far as the points say so.
    pub within: Vec<Option<(Figure, Figure)>>,
}

/// What is to be changed in the grammar.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// A field gets a number.
    Number {
        /// The field, such as `bender.torque`.
        path: String,
        /// Its new value.
        value: Figure,
    },
    /// A field gets a table.
    Table {
        /// The field; none if nothing in the grammar takes such a table.
        path: Option<String>,
        /// The table.
        table: Table,
    },
    /// A robot that was built is added.
    Prototype {
        /// Its name.
        name: String,
        /// What kind of robot it is.
        build: String,
        /// What a simulation made of it.
        simulated: Figure,
        /// What it did.
        measured: Figure,
        /// How long it is.
        length: Option<Figure>,
    },
}

impl Change {
    /// Whether all its numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        match self {
            Self::Number { value, .. } => value.value.is_finite(),
            Self::Table { table, .. } => {
                table.rows.iter().all(|(x, y)| x.value.is_finite() && y.value.is_finite())
            }
            Self::Prototype { simulated, measured, .. } => {
                simulated.value.is_finite() && measured.value.is_finite()
            }
        }
    }

    /// The new value in a few words.
    #[must_use]
    pub fn shown(&self) -> String {
        match self {
            Self::Number { value, .. } => value.to_string(),
            Self::Table { table, .. } => match (table.rows.first(), table.rows.last()) {
                (Some((_, first)), Some((_, last))) => {
                    format!("{} .. {last} ({} rows)", first.digits(false), table.rows.len())
                }
                _ => "no rows".to_owned(),
            },
            Self::Prototype { simulated, measured, .. } => {
                let share = format!("{:.2}", measured.value / simulated.value);
                format!("{measured}, {share} of the simulated speed")
            }
        }
    }
}

/// How far points are from what was made of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// The root of the mean square.
    pub rms: Figure,
    /// The largest.
    pub largest: Figure,
}

impl Residual {
    /// Of residuals in SI units; nothing of none.
    pub(super) fn of(residuals: &[f64], unit: &'static str) -> Option<Self> {
        if residuals.is_empty() {
            return None;
        }
        let rms = (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt();
        let largest = residuals.iter().fold(0.0, |most: f64, r| most.max(r.abs()));
        // Two digits of a residual say all that there is to it.
        let figure = |x: f64| Figure::of(x, Some(x / 10.0), unit);
        // What is left of sums that come out even is no residual.
        let clean = |x: f64| if x < 1e-12 { 0.0 } else { x };
        Some(Self { rms: figure(clean(rms)), largest: figure(clean(largest)) })
    }
}

/// Points and the line through them, in the units of the axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// What is to be seen.
    pub title: String,
    /// The axis across, with its unit.
    pub x: String,
    /// The axis upwards, with its unit.
    pub y: String,
    /// The points with the number of their run.
    pub points: Vec<(f64, f64, usize)>,
    /// Lines through them, each with the number of its run.
    pub fit: Vec<(Vec<(f64, f64)>, usize)>,
    /// The rows of a table, drawn as marks.
    pub rows: Vec<(f64, f64)>,
    /// The unit of the residuals.
    pub unit: String,
    /// Residuals over the axis across, with the number of their run.
    pub residuals: Vec<(f64, f64, usize)>,
}

/// What one measurement comes to.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The section that it comes from.
    pub section: String,
    /// Where that begins.
    pub place: Location,
    /// The file that the points stand in.
    pub source: String,
    /// What is measured, such as `bender.torque`.
    pub quantity: String,
    /// What the grammar says of it so far.
    pub old: Option<String>,
    /// What it is to say.
    pub change: Change,
    /// Where the new value lies nine times of ten, if the points say so.
    pub interval: Option<(Figure, Figure)>,
    /// How many times the old value the new one is, if both are numbers; of a table, its largest.
    pub factor: Option<f64>,
    /// How well the points agree.
    pub residual: Option<Residual>,
    /// How many points it rests on.
    pub points: usize,
    /// What else is to be known, in sentences.
    pub notes: Vec<String>,
    /// What is to be looked at before anything is believed, in sentences.
    pub warnings: Vec<String>,
    /// What is drawn.
    pub plots: Vec<Plot>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_has_the_digits_that_its_error_allows() {
        let of = |value, error, unit| Figure::of(value, error, unit).to_string();
        assert_eq!(of(0.008_312_4, Some(0.000_05), "g"), "8.31 g");
        assert_eq!(of(0.008_312_4, Some(0.000_4), "g"), "8.3 g");
        assert_eq!(of(0.008_312_4, Some(0.1), "g"), "8 g", "never less than one digit");
        assert_eq!(of(2.07, Some(0.4), "deg/s"), "120 deg/s", "to tens, as it may be 23 off");
        assert_eq!(of(95_f64.to_radians(), Some(0.002), "deg/s"), "95.0 deg/s");
        assert_eq!(of(0.008_312_4, Some(1e-9), "g"), "8.312 g", "never more than four");
        assert_eq!(of(0.008_312_4, None, "g"), "8.31 g");
        assert_eq!(of(0.0584, Some(0.002), "N*m/rad"), "0.058 N*m/rad");
        assert_eq!(of(0.618, None, ""), "0.618");
        assert_eq!(of(0.0, Some(0.1), "mm"), "0 mm");
        assert_eq!(Figure::with_decimals(-0.00001, "mm", 1).to_string(), "0.0 mm");
        assert_eq!(Figure::with_decimals(std::f64::consts::FRAC_PI_2, "deg", 2).digits(true), "90");
    }

    #[test]
    fn residuals_are_summed_up() {
        let residual = Residual::of(&[0.003, -0.004], "mm").unwrap();
        assert_eq!(
            (residual.rms.to_string(), residual.largest.to_string()),
            ("3.5 mm".into(), "4.0 mm".into())
        );
        assert_eq!(Residual::of(&[], "mm"), None);
        assert_eq!(Residual::of(&[0.0], "mm").unwrap().rms.to_string(), "0 mm");
    }
}
