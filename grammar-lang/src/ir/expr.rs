//! Typed expressions.

use serde::{Deserialize, Serialize};

use super::{Solid, Ty};
use crate::source::Span;
pub use crate::syntax::ast::{Gather, Operator, Painting};

/// An expression with its type and place. Numbers are in SI units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Expr {
    /// What it computes.
    pub kind: ExprKind,
    /// The type of its value.
    pub ty: Ty,
    /// Where it stands.
    pub span: Span,
}

/// A collection of parts by kind.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// All parts.
    Part,
    /// All passive parts.
    Block,
    /// All actuators.
    Actuator,
    /// All cells of a lattice.
    Cell,
    /// All parts of one declared kind.
    Kind(String),
}

/// A binder of an aggregate: it fills one local slot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Binder {
    /// The local slot.
    pub slot: usize,
    /// What it runs over: a group, a list, `elements`, or a range of counts.
    pub over: Expr,
}

/// What expressions compute.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExprKind {
    /// A number in SI units (also a count).
    Number(f64),
    /// True or false.
    Bool(bool),
    /// A text.
    Text(String),
    /// A parameter of the grammar.
    Param(String),
    /// A local: what a rule matched or chose, a variable of an actuation, a binder.
    Local(usize),
    /// A word that the stage gives a value to.
    Word(Word),
    /// A part of the initial design, by its name.
    Placed(String),
    /// A collection of parts.
    Group(Group),
    /// A kind of part with the parameters that are given.
    Kind(String, Vec<(String, Expr)>),
    /// A pattern by name.
    Pattern(String),
    /// A measured function.
    Table(super::Table),
    /// A term by name.
    Term(String),
    /// The value of a task by name.
    Task(String),
    /// The value of a shared variable of an actuation.
    Shared(String, String),
    /// A port by name, and by number where several share the name: to compare with.
    PortName(String),
    /// A port of a part, by name and by number.
    Port(Box<Expr>, String, Option<Box<Expr>>),
    /// A value in a local slot, and what is computed with it.
    Bind {
        /// The local slot.
        slot: usize,
        /// What it holds.
        value: Box<Expr>,
        /// What reads it.
        body: Box<Expr>,
    },
    /// An attribute of a part, actuator, element or vector.
    Attribute(Box<Expr>, String),
    /// A quantity over time, at a time.
    At(Box<Expr>, Box<Expr>),
    /// `-x`
    Negate(Box<Expr>),
    /// `not x`
    Not(Box<Expr>),
    /// Two operands.
    Binary(Box<Expr>, Operator, Box<Expr>),
    /// `if a then b else c`
    If(Box<Expr>, Box<Expr>, Box<Expr>),
    /// Over the items of collections.
    Aggregate {
        /// How items are gathered.
        how: Gather,
        /// What is run over.
        binders: Vec<Binder>,
        /// Which items count.
        condition: Option<Box<Expr>>,
        /// What is gathered; absent for a count.
        body: Option<Box<Expr>>,
        /// The value over nothing.
        otherwise: Option<Box<Expr>>,
    },
    /// A built-in function.
    Call(Function, Vec<Expr>),
    /// A curve or a pattern at a place of the cycle.
    Apply(Box<Expr>, Box<Expr>),
    /// An item of a list, from 0.
    Index(Box<Expr>, Box<Expr>),
    /// A domain between two ends.
    Range(Box<Expr>, Box<Expr>),
    /// A domain of single values.
    Set(Vec<Expr>),
    /// A list.
    List(Vec<Expr>),
    /// A quantity as a number of units of this size.
    Convert(Box<Expr>, f64),
}

macro_rules! words {
    ($(#[$meta:meta])* $name:ident { $($variant:ident $text:literal $doc:literal;)* }
     $($(#[$of_meta:meta])* $of:ident { $($one:ident)* })?) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $name { $(#[doc = $doc] $variant,)* $($(#[$of_meta])* $of($of))? }
        impl $name {
            /// Every one, in the order of the reference.
            pub const ALL: &[Self] = &[$(Self::$variant,)* $($(Self::$of($of::$one)),*)?];
            /// How a grammar writes it.
            #[must_use]
            pub fn text(self) -> &'static str { match self { $(Self::$variant => $text,)* $(Self::$of(of) => of.text())? } }
            /// What it means.
            #[must_use]
            pub fn doc(self) -> &'static str { match self { $(Self::$variant => $doc,)* $(Self::$of(of) => of.doc())? } }
            /// The one that a grammar writes like this.
            #[must_use]
            pub fn named(text: &str) -> Option<Self> { Self::ALL.iter().copied().find(|w| w.text() == text) }
        }
    };
}

words! {
    /// Words that a stage gives a value to.
    Word {
        Pi "pi" "The number 3.14159...";
        Cycle "cycle" "Where a pattern is in its cycle, from 0 to 1.";
        Time "t" "The time since the motion began.";
        Period "period" "The period of the cyclic actuation.";
        Start "start" "The time at which the motion begins.";
        End "end" "The time at which the motion ends.";
        Duration "duration" "How long the motion lasts.";
        FrameInterval "frame_interval" "The time between two recorded frames of the motion.";
        Elements "elements" "All rigid pieces of the body.";
        Temperature "temperature" "The temperature of the annealing, on the scale of the objective.";
        Iteration "iteration" "How many iterations have been completed.";
        Best "best" "The best value so far.";
        Idle "idle" "Iterations since the best value improved.";
        Refused "refused" "Moves in a row that were not accepted.";
        Stagnant "stagnant" "Iterations in a row in which no move was accepted.";
        Deviation "deviation" "The standard deviation of the values of the random walk.";
        Chain "chain" "The number of an annealing chain, from 0.";
        Spread "spread" "The standard deviation of the samples, as a share of the ranges.";
        Closed "closed" "Both valves of an actuator are closed: it keeps its air.";
        Inflate "inflate" "An actuator's valve lets air in.";
        Vent "vent" "An actuator's valve lets air out.";
        Middle "middle" "The place in the middle of the lattice.";
        Connected "connected" "Whether the design is in one piece.";
        NoOverlap "no_overlap" "Whether no two parts overlap; touching is allowed.";
    }
}

words! {
    /// Built-in functions.
    Function {
        Abs "abs" "The size without the sign.";
        Min "min" "The least of several values.";
        Max "max" "The greatest of several values.";
        Clamp "clamp" "clamp(x, low, high): x, or the end that it is beyond.";
        Floor "floor" "The next whole number below.";
        Ceil "ceil" "The next whole number above.";
        Round "round" "The nearest whole number.";
        Fraction "fraction" "What is left of a number after floor.";
        Sqrt "sqrt" "The square root.";
        Exp "exp" "The exponential of a number.";
        Ln "ln" "The natural logarithm of a number.";
        Sin "sin" "The sine of an angle.";
        Cos "cos" "The cosine of an angle.";
        Tan "tan" "The tangent of an angle.";
        Arc "arc" "arc(radius, angle): the length of an arc.";
        Length "length" "The length of a vector.";
        Horizontal "horizontal" "The length of a vector's part along the ground.";
        Height "height" "The vertical part of a vector.";
        Vector "vector" "vector(x, y, z), with y up.";
        Angle "angle" "angle(a, b): the angle of the rotation from a to b.";
        Heading "heading" "heading(rotation): where x points along the ground, seen from above; left of forward is positive.";
        Bearing "bearing" "bearing(vector): where a vector points along the ground, seen from above; left of forward is positive.";
        Wrap "wrap" "wrap(angle): the same direction within -180 deg .. 180 deg.";
        Count "count" "How many parts of a kind, or items of a list, there are.";
        Each "each" "each(list, n): every item n times in a row.";
        Repeat "repeat" "repeat(x, n): a list of n times x.";
        First "first" "The first item of a list.";
        Last "last" "The last item of a list.";
        Bezier "bezier" "A Bezier curve over a cycle, through the first and last of its control points.";
        Cycle "cycle" "cycle(period, shares, states, phase): states of valves that take turns, each for its share of the period.";
        Normal "normal" "normal(mean, standard deviation): a distribution.";
        Uniform "uniform" "uniform(low, high): a distribution.";
        Gain "gain" "gain(n): what the best value gained in the last n iterations.";
        Cell "cell" "cell(x, y, z): a place of the lattice, counted from 0.";
        Region "region" "region(c, x, y, z): the places whose offsets from a cell are these numbers or ranges, as far as the lattice reaches.";
        Neighbours "neighbours" "The parts that are joined to a part, or the cells to a cell: up to 18.";
        Images "images" "The images of a part under the symmetry, without itself.";
    }
    /// A function that makes shapes.
    #[serde(untagged)]
    Solid { Box Sphere Cylinder Disk Capsule }
}

impl Expr {
    /// Visits what the expression is made of, but not what that is made of.
    pub fn each<'e>(&'e self, visit: &mut impl FnMut(&'e Self)) {
        match &self.kind {
            ExprKind::Attribute(a, _) | ExprKind::Negate(a) | ExprKind::Not(a) | ExprKind::Convert(a, _) => {
                visit(a)
            }
            ExprKind::Port(a, _, b) => {
                visit(a);
                b.iter().for_each(|b| visit(b));
            }
            ExprKind::Bind { value, body, .. } => [value, body].into_iter().for_each(|e| visit(e)),
            ExprKind::At(a, b)
            | ExprKind::Binary(a, _, b)
            | ExprKind::Apply(a, b)
            | ExprKind::Index(a, b)
            | ExprKind::Range(a, b) => [a, b].into_iter().for_each(|e| visit(e)),
            ExprKind::If(a, b, c) => [a, b, c].into_iter().for_each(|e| visit(e)),
            ExprKind::Call(_, items) | ExprKind::Set(items) | ExprKind::List(items) => {
                items.iter().for_each(visit)
            }
            ExprKind::Kind(_, items) => items.iter().for_each(|(_, e)| visit(e)),
            ExprKind::Aggregate { binders, condition, body, otherwise, .. } => {
                binders.iter().for_each(|b| visit(&b.over));
                [condition, body, otherwise].into_iter().flatten().for_each(|e| visit(e));
            }
            _ => {}
        }
    }

    /// Whether the expression, or one that it is made of, satisfies `test`.
    pub fn any(&self, test: &mut impl FnMut(&Self) -> bool) -> bool {
        if test(self) {
            return true;
        }
        match &self.kind {
            ExprKind::Attribute(a, _) | ExprKind::Negate(a) | ExprKind::Not(a) | ExprKind::Convert(a, _) => {
                a.any(test)
            }
            ExprKind::Port(a, _, b) => a.any(test) || b.as_ref().is_some_and(|b| b.any(test)),
            ExprKind::Bind { value, body, .. } => value.any(test) || body.any(test),
            ExprKind::At(a, b)
            | ExprKind::Binary(a, _, b)
            | ExprKind::Apply(a, b)
            | ExprKind::Index(a, b)
            | ExprKind::Range(a, b) => a.any(test) || b.any(test),
            ExprKind::If(a, b, c) => a.any(test) || b.any(test) || c.any(test),
            ExprKind::Call(_, items) | ExprKind::Set(items) | ExprKind::List(items) => {
                items.iter().any(|e| e.any(test))
            }
            ExprKind::Kind(_, items) => items.iter().any(|(_, e)| e.any(test)),
            ExprKind::Aggregate { binders, condition, body, otherwise, .. } => {
                binders.iter().any(|b| b.over.any(test))
                    || [condition, body, otherwise].into_iter().flatten().any(|e| e.any(test))
            }
            _ => false,
        }
    }
}
