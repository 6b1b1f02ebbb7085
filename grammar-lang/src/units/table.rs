//! The units that a grammar may write, and what they are worth in SI.

use std::f64::consts::PI;

use super::Dimension;

/// A unit: its dimension and its size in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Its dimension.
    pub dimension: Dimension,
    /// Its size in SI units, angles in radians.
    pub factor: f64,
}

/// Name, size in SI, exponents of (length, mass, time, angle, current).
const UNITS: &[(&str, f64, [i8; 5])] = &[
    ("m", 1.0, [1, 0, 0, 0, 0]),
    ("cm", 1e-2, [1, 0, 0, 0, 0]),
    ("mm", 1e-3, [1, 0, 0, 0, 0]),
    ("um", 1e-6, [1, 0, 0, 0, 0]),
    ("µm", 1e-6, [1, 0, 0, 0, 0]),
    ("μm", 1e-6, [1, 0, 0, 0, 0]),
    ("km", 1e3, [1, 0, 0, 0, 0]),
    ("kg", 1.0, [0, 1, 0, 0, 0]),
    ("g", 1e-3, [0, 1, 0, 0, 0]),
    ("mg", 1e-6, [0, 1, 0, 0, 0]),
    ("s", 1.0, [0, 0, 1, 0, 0]),
    ("ms", 1e-3, [0, 0, 1, 0, 0]),
    ("us", 1e-6, [0, 0, 1, 0, 0]),
    ("min", 60.0, [0, 0, 1, 0, 0]),
    ("h", 3600.0, [0, 0, 1, 0, 0]),
    ("rad", 1.0, [0, 0, 0, 1, 0]),
    ("deg", PI / 180.0, [0, 0, 0, 1, 0]),
    ("A", 1.0, [0, 0, 0, 0, 1]),
    ("mA", 1e-3, [0, 0, 0, 0, 1]),
    ("Hz", 1.0, [0, 0, -1, 0, 0]),
    ("N", 1.0, [1, 1, -2, 0, 0]),
    ("mN", 1e-3, [1, 1, -2, 0, 0]),
    ("J", 1.0, [2, 1, -2, 0, 0]),
    ("mJ", 1e-3, [2, 1, -2, 0, 0]),
    ("W", 1.0, [2, 1, -3, 0, 0]),
    ("Pa", 1.0, [-1, 1, -2, 0, 0]),
    ("kPa", 1e3, [-1, 1, -2, 0, 0]),
    ("MPa", 1e6, [-1, 1, -2, 0, 0]),
    ("bar", 1e5, [-1, 1, -2, 0, 0]),
    ("%", 1e-2, [0, 0, 0, 0, 0]),
];

/// Why a unit is none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UnitError {
    /// This word is no unit.
    Unknown(String),
    /// The exponents grow past all reason.
    TooHigh,
}

fn named(name: &str) -> Option<Unit> {
    UNITS
        .iter()
        .find(|(n, ..)| *n == name)
        .map(|(_, factor, d)| Unit { dimension: Dimension(*d), factor: *factor })
}

/// Reads a unit such as `mm`, `g/cm^3` or `N*m/rad`.
///
/// # Errors
///
/// [`UnitError`] names the first word that is no unit.
pub fn parse(text: &str) -> Result<Unit, UnitError> {
    let mut unit = Unit { dimension: Dimension::NUMBER, factor: 1.0 };
    let mut rest = text;
    let mut sign = 1i8;
    loop {
        let end = rest.find(['*', '/']).unwrap_or(rest.len());
        let (word, tail) = rest.split_at(end);
        let (name, exponent) = match word.split_once('^') {
            Some((name, e)) => (name, e.parse::<i8>().map_err(|_| UnitError::Unknown(word.to_owned()))?),
            None => (word, 1),
        };
        let base = named(name).ok_or_else(|| UnitError::Unknown(name.to_owned()))?;
        let exponent = exponent.checked_mul(sign).ok_or(UnitError::TooHigh)?;
        let part = base.dimension.power(exponent).ok_or(UnitError::TooHigh)?;
        unit.dimension = unit.dimension.times(part).ok_or(UnitError::TooHigh)?;
        for _ in 0..exponent.unsigned_abs() {
            if exponent > 0 {
                unit.factor *= base.factor;
            } else {
                unit.factor /= base.factor;
            }
        }
        let Some(operator) = tail.chars().next() else { return Ok(unit) };
        sign = if operator == '/' { -1 } else { 1 };
        rest = tail.get(1..).unwrap_or("");
    }
}

/// Units as people write them out or shorten them, and as they are written here.
const WRITTEN_OUT: &[(&[&str], &str)] = &[
    (&["meter", "meters", "metre", "metres"], "m"),
    (&["centimeter", "centimeters", "centimetre", "centimetres"], "cm"),
    (&["millimeter", "millimeters", "millimetre", "millimetres"], "mm"),
    (&["micrometer", "micrometre", "micron", "microns"], "um"),
    (&["gram", "grams", "gramme", "grammes"], "g"),
    (&["kilogram", "kilograms", "kilo", "kilos"], "kg"),
    (&["second", "seconds", "sec", "secs"], "s"),
    (&["millisecond", "milliseconds", "msec", "msecs"], "ms"),
    (&["minute", "minutes", "mins"], "min"),
    (&["hour", "hours", "hr", "hrs"], "h"),
    (&["°", "degree", "degrees", "degs"], "deg"),
    (&["radian", "radians", "rads"], "rad"),
    (&["ampere", "amperes", "amp", "amps"], "A"),
    (&["hertz"], "Hz"),
    (&["newton", "newtons"], "N"),
    (&["joule", "joules"], "J"),
    (&["watt", "watts"], "W"),
    (&["pascal", "pascals"], "Pa"),
    (&["percent"], "%"),
    (&["ccm", "cc", "ml", "milliliter", "milliliters", "millilitre", "millilitres"], "cm^3"),
];

/// The unit that a word such as `degrees` or `sec` stands for.
#[must_use]
pub fn written_out(word: &str) -> Option<&'static str> {
    let lower = word.to_lowercase();
    WRITTEN_OUT.iter().find(|(words, _)| words.contains(&lower.as_str())).map(|(_, unit)| *unit)
}

/// Every unit's name.
pub fn unit_names() -> impl Iterator<Item = &'static str> {
    UNITS.iter().map(|(n, ..)| *n)
}

/// The unit that a message suggests for a quantity of this dimension.
#[must_use]
pub fn suggest(dimension: Dimension) -> String {
    let usual = [
        "mm",
        "g",
        "s",
        "deg",
        "mA",
        "N",
        "N*m/rad",
        "N*m/rad^2",
        "N*m*s/rad^2",
        "N/m",
        "N*s/m",
        "g/cm^3",
        "deg/s",
        "mm/s",
        "kPa",
        "cm^3/s/bar",
        "Hz",
        "J",
        "W",
    ];
    for usual in usual {
        if parse(usual).is_ok_and(|u| u.dimension == dimension) {
            return usual.to_owned();
        }
    }
    dimension.si()
}

/// The SI unit of a dimension for printing values: empty for a bare number.
#[must_use]
pub fn display_unit(dimension: Dimension) -> String {
    // Those that people have a name for; all are of size one.
    let named = ["N", "Pa", "J", "W", "N*m/rad", "N*m/rad^2", "N*m*s/rad^2", "N/m", "N*s/m"];
    let is_it = |name: &&str| parse(name).is_ok_and(|unit| unit.dimension == dimension);
    match named.into_iter().find(is_it) {
        Some(name) => name.to_owned(),
        None if dimension.is_number() => String::new(),
        None => dimension.si(),
    }
}

/// A number in SI units with the unit that people would write.
#[must_use]
pub fn shown(value: f64, dimension: Dimension) -> String {
    if dimension.is_number() {
        return rounded(value, 1e9).to_string();
    }
    let unit = suggest(dimension);
    let factor = parse(&unit).map_or(1.0, |u| u.factor);
    let shown = rounded(value / factor, 1e6);
    // What is too large for its unit is not infinite.
    if shown.is_finite() { format!("{shown} {unit}") } else { format!("{value:e} {}", dimension.si()) }
}

/// A number in SI units so that a grammar that reads it has the same bits: in the unit that people would write, or else in SI units.
#[must_use]
pub fn exact(value: f64, dimension: Dimension) -> String {
    let number = |x: f64| if x.abs() < 1e15 { x.to_string() } else { format!("{x:e}") };
    if dimension.is_number() {
        return number(value);
    }
    let unit = suggest(dimension);
    let factor = parse(&unit).map_or(1.0, |u| u.factor);
    let near = value / factor;
    let candidates = [rounded(near, 1e6), near, near.next_up(), near.next_down()];
    match candidates.into_iter().find(|x| x * factor == value) {
        Some(x) => format!("{} {unit}", number(x)),
        None => format!("{} {}", number(value), dimension.si()),
    }
}

/// What is smaller than this, in its unit, is rounding.
const ROUNDING: f64 = 1e-12;

/// A number without what comes behind its first decimals; a huge one has none, a small one keeps six digits.
fn rounded(value: f64, one: f64) -> f64 {
    if (ROUNDING..1e-3).contains(&value.abs()) {
        let scale = libm::pow(10.0, 5.0 - libm::floor(libm::log10(value.abs())));
        return (value * scale).round() / scale;
    }
    let scaled = (value * one).round();
    if scaled.is_finite() { scaled / one } else { value }
}

/// What is smaller is rounding.
const LEAST: f64 = 1e-12;

/// A value with its unit: four places, or three digits where those would be lost.
#[must_use]
pub fn quantity(value: f64, unit: &str) -> String {
    let number = match value.abs() {
        // No minus sign before a zero.
        size if size < LEAST => "0.0000".to_owned(),
        size if size < 5e-4 => format!("{value:.2e}"),
        size if size < 1e9 => format!("{value:.4}"),
        _ => format!("{value:.4e}"),
    };
    if unit.is_empty() { number } else { format!("{number} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn huge_quantities_are_finite() {
        assert_eq!(shown(1e308, Dimension::LENGTH), "1e308 m");
        assert!(shown(1e303, Dimension::TIME).starts_with('1'), "{}", shown(1e303, Dimension::TIME));
        assert_eq!(shown(0.012_345_678, Dimension::LENGTH), "12.345678 mm");
    }

    #[test]
    fn what_is_exact_is_read_back_with_the_same_bits() {
        let dimensions = ["mm", "deg", "g/cm^3", "N*m/rad", "s", "cm^3/s/bar"];
        let mut value = 0.1;
        for unit in dimensions.into_iter().cycle().take(600) {
            let dimension = parse(unit).unwrap().dimension;
            value = (value * 1.618_033_988_749) % 7.3;
            let text = exact(value, dimension);
            let (number, unit) = text.split_once(' ').unwrap();
            assert_eq!(number.parse::<f64>().unwrap() * parse(unit).unwrap().factor, value, "{text}");
        }
        assert_eq!(exact(0.02, Dimension::LENGTH), "20 mm");
        assert_eq!(exact(1e20, Dimension::NUMBER), "1e20");
    }

    #[test]
    fn small_quantities_are_not_zero() {
        let told = |value: f64, unit: &str| shown(value, parse(unit).unwrap().dimension);
        assert_eq!(told(2e-8, "m^2"), "0.00000002 m^2");
        assert_eq!(told(9e-9, "m^3"), "0.000000009 m^3");
        assert_eq!(told(1.234_567_89e-5, "m^2"), "0.0000123457 m^2");
        assert_eq!(told(6.1e-17, "m"), "0 mm");
        assert_eq!(told(0.02, "m"), "20 mm");
    }

    #[test]
    fn products_and_powers() {
        let density = parse("g/cm^3").unwrap();
        assert_eq!(density.dimension, Dimension::DENSITY);
        assert!((density.factor - 1000.0).abs() < 1e-9);
        let torque = parse("N*m/rad").unwrap();
        assert_eq!(torque.dimension, Dimension::TORQUE);
        assert_eq!(parse("gg"), Err(UnitError::Unknown("gg".into())));
        assert_eq!(parse("m^9*m^99*m^99"), Err(UnitError::TooHigh));
    }

    #[test]
    fn units_written_out_are_units_and_their_words_are_not() {
        assert_eq!(written_out("Degrees"), Some("deg"));
        for (words, unit) in WRITTEN_OUT {
            assert!(parse(unit).is_ok(), "{unit}");
            assert!(words.iter().all(|w| named(w).is_none()), "{words:?}");
        }
    }

    #[test]
    fn energies_are_told_in_joules() {
        let told = |unit: &str| display_unit(parse(unit).unwrap().dimension);
        assert_eq!(["mJ", "N*m", "W", "bar", "mN", "cm"].map(told), ["J", "J", "W", "Pa", "N", "m"]);
        assert_eq!(told("N*m/rad"), "N*m/rad");
        assert_eq!(told("g/cm^3"), "kg/m^3");
        assert_eq!(told("%"), "");
        assert_eq!(parse("J").unwrap().factor, 1.0);
    }

    #[test]
    fn every_suggestion_parses_back() {
        for name in Dimension::names() {
            let dimension = Dimension::named(name).unwrap();
            if dimension.is_number() || dimension.si().starts_with('1') {
                continue;
            }
            assert_eq!(parse(&suggest(dimension)).unwrap().dimension, dimension, "{name}");
        }
    }
}
