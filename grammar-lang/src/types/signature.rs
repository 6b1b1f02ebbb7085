//! The types of built-in words, functions and attributes.

use crate::ir::{Function, Ty, Word};
use crate::units::Dimension;

/// The type of a word.
pub(super) fn word(word: Word) -> Ty {
    match word {
        Word::Pi | Word::Cycle | Word::Temperature | Word::Best | Word::Deviation | Word::Spread => {
            Ty::NUMBER
        }
        Word::Time | Word::Start | Word::End | Word::Duration | Word::FrameInterval | Word::Period => {
            Ty::Quantity(Dimension::TIME)
        }
        Word::Elements => Ty::List(Box::new(Ty::Element)),
        Word::Iteration | Word::Idle | Word::Refused | Word::Stagnant | Word::Chain => Ty::Count,
        Word::Closed | Word::Inflate | Word::Vent => Ty::Valve,
        Word::Connected | Word::NoOverlap => Ty::Bool,
        Word::Middle => Ty::Cell,
    }
}

/// The attributes of a thing that the design has, with their types.
pub(super) fn attributes(of: &Ty) -> &'static [(&'static str, Ty)] {
    const PART: &[(&str, Ty)] = &[
        ("turn", Ty::Quantity(Dimension::ANGLE)),
        ("image", Ty::Count),
        ("depth", Ty::Count),
        ("mass", Ty::Quantity(Dimension::MASS)),
        ("holder", Ty::Part),
        ("twin", Ty::Part),
    ];
    const ACTUATOR: &[(&str, Ty)] = &[
        ("turn", Ty::Quantity(Dimension::ANGLE)),
        ("image", Ty::Count),
        ("depth", Ty::Count),
        ("mass", Ty::Quantity(Dimension::MASS)),
        ("holder", Ty::Part),
        ("twin", Ty::Part),
        ("least_bend", Ty::Quantity(Dimension::ANGLE)),
        ("greatest_bend", Ty::Quantity(Dimension::ANGLE)),
    ];
    match of {
        Ty::Part => PART,
        Ty::Actuator => ACTUATOR,
        Ty::Cell => &[("x", Ty::Count), ("y", Ty::Count), ("z", Ty::Count), ("filled", Ty::Bool)],
        Ty::Port => &[("part", Ty::Part), ("index", Ty::Count), ("free", Ty::Bool)],
        Ty::Joint => &[("holder", Ty::Part), ("held", Ty::Part), ("port", Ty::Port)],
        Ty::Step => &[("rule", Ty::Text), ("number", Ty::Count)],
        _ => &[],
    }
}

/// What the recorded motion adds to the attributes of a thing.
pub(super) fn motion_attribute(of: &Ty, name: &str) -> Option<Ty> {
    let track = |ty| Some(Ty::Track(Box::new(ty)));
    match (of, name) {
        (Ty::Element | Ty::Part | Ty::Actuator | Ty::Cell, "position") => {
            track(Ty::Vector(Dimension::LENGTH))
        }
        (Ty::Element | Ty::Part | Ty::Actuator, "rotation") => track(Ty::Rotation),
        (Ty::Element, "lowest") => track(Ty::Quantity(Dimension::LENGTH)),
        (Ty::Element, "size" | "path" | "slid") => Some(Ty::Quantity(Dimension::LENGTH)),
        (Ty::Element, "touching" | "sliding") => Some(Ty::Quantity(Dimension::TIME)),
        (Ty::Element, "part") => Some(Ty::Part),
        (Ty::Element, "cell") => Some(Ty::Cell),
        (Ty::Actuator, "work") => Dimension::named("Energy").map(Ty::Quantity),
        _ => None,
    }
}

/// The names that [`motion_attribute`] knows.
pub(super) const MOTION_ATTRIBUTES: &[&str] = &[
    "position", "rotation", "lowest", "size", "path", "slid", "touching", "sliding", "part", "cell", "work",
];

/// What a function takes: how people write it, and how many arguments.
pub(super) fn usage(function: Function) -> (&'static str, std::ops::RangeInclusive<usize>) {
    use Function as F;
    match function {
        F::Abs => ("abs(x)", 1..=1),
        F::Min => ("min(a, b, ...)", 2..=64),
        F::Max => ("max(a, b, ...)", 2..=64),
        F::Clamp => ("clamp(x, low, high)", 3..=3),
        F::Floor => ("floor(number)", 1..=1),
        F::Ceil => ("ceil(number)", 1..=1),
        F::Round => ("round(number)", 1..=1),
        F::Fraction => ("fraction(number)", 1..=1),
        F::Sqrt => ("sqrt(x)", 1..=1),
        F::Exp => ("exp(number)", 1..=1),
        F::Ln => ("ln(number)", 1..=1),
        F::Sin => ("sin(angle)", 1..=1),
        F::Cos => ("cos(angle)", 1..=1),
        F::Tan => ("tan(angle)", 1..=1),
        F::Arc => ("arc(radius, angle)", 2..=2),
        F::Length => ("length(vector)", 1..=1),
        F::Horizontal => ("horizontal(vector)", 1..=1),
        F::Height => ("height(vector)", 1..=1),
        F::Vector => ("vector(x, y, z)", 3..=3),
        F::Angle => ("angle(rotation, rotation)", 2..=2),
        F::Heading => ("heading(rotation)", 1..=1),
        F::Bearing => ("bearing(vector)", 1..=1),
        F::Wrap => ("wrap(angle)", 1..=1),
        F::Count => ("count(kind)", 1..=1),
        F::Each => ("each(list, n)", 2..=2),
        F::Repeat => ("repeat(x, n)", 2..=2),
        F::First => ("first(list)", 1..=1),
        F::Last => ("last(list)", 1..=1),
        F::Bezier => ("bezier(list)", 1..=1),
        F::Cycle => ("cycle(period, shares, states, phase)", 4..=4),
        F::Solid(solid) => (solid.usage(), solid.lengths()..=solid.lengths()),
        F::Normal => ("normal(mean, deviation)", 2..=2),
        F::Uniform => ("uniform(low, high)", 2..=2),
        F::Gain => ("gain(iterations)", 1..=1),
        F::Cell => ("cell(x, y, z)", 3..=3),
        F::Region => ("region(c, x, y, z)", 4..=4),
        F::Neighbours => ("neighbours(part)", 1..=1),
        F::Images => ("images(part)", 1..=1),
    }
}
