//! The types of built-in words, and what built-in functions take.

use crate::ir::{DesignFunction, DesignWord, Function, MotionWord, SearchWord, Ty, Word};
use crate::units::Dimension;

/// The type of a word.
pub(super) fn word(word: Word) -> Ty {
    match word {
        Word::Pi
        | Word::Cycle
        | Word::Search(
            SearchWord::Temperature
            | SearchWord::Best
            | SearchWord::Deviation
            | SearchWord::Spread
            | SearchWord::Parent
            | SearchWord::Spent,
        ) => Ty::NUMBER,
        Word::Time
        | Word::Now
        | Word::Before
        | Word::ControlInterval
        | Word::Motion(
            MotionWord::Start
            | MotionWord::End
            | MotionWord::Duration
            | MotionWord::FrameInterval
            | MotionWord::Period,
        ) => Ty::Quantity(Dimension::TIME),
        Word::Motion(MotionWord::Elements) => Ty::List(Box::new(Ty::Element)),
        Word::Search(
            SearchWord::Iteration
            | SearchWord::Idle
            | SearchWord::Refused
            | SearchWord::Stagnant
            | SearchWord::Chain
            | SearchWord::Tuned,
        ) => Ty::Count,
        Word::Closed | Word::Inflate | Word::Vent => Ty::Valve,
        Word::Design(DesignWord::Connected | DesignWord::NoOverlap) => Ty::Bool,
        Word::Design(DesignWord::Middle) => Ty::Cell,
    }
}

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
        F::Asin => ("asin(number)", 1..=1),
        F::Acos => ("acos(number)", 1..=1),
        F::Atan2 => ("atan2(y, x)", 2..=2),
        F::Arc => ("arc(radius, angle)", 2..=2),
        F::Length => ("length(vector)", 1..=1),
        F::Horizontal => ("horizontal(vector)", 1..=1),
        F::Height => ("height(vector)", 1..=1),
        F::Vector => ("vector(x, y, z)", 3..=3),
        F::Angle => ("angle(rotation, rotation)", 2..=2),
        F::Heading => ("heading(rotation)", 1..=1),
        F::Bearing => ("bearing(vector)", 1..=1),
        F::Inclination => ("inclination(rotation)", 1..=1),
        F::Rotated => ("rotated(vector, rotation)", 2..=2),
        F::Inverse => ("inverse(rotation)", 1..=1),
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
        F::Design(DesignFunction::Cell) => ("cell(x, y, z)", 3..=3),
        F::Design(DesignFunction::Region) => ("region(c, x, y, z)", 4..=4),
        F::Design(DesignFunction::Neighbours) => ("neighbours(part)", 1..=1),
        F::Design(DesignFunction::Images) => ("images(part)", 1..=1),
        F::Design(DesignFunction::HangingOn) => ("hanging_on(part)", 1..=1),
    }
}
