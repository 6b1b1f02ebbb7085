//! The kinds of declarations: all that is known of each apart from what it means.

/// A kind of declaration.
#[derive(Debug)]
pub struct Kind {
    /// The word that opens it.
    pub word: &'static str,
    /// What one looks like.
    pub form: &'static str,
    /// The heading that several have on a page.
    pub several: &'static str,
    /// What its name is, where somebody asks for a value.
    pub what: &'static str,
    /// What stands between its braces.
    pub(super) clauses: Clauses,
    /// When it counts as used.
    pub counts: Counts,
}

/// The declarations that are a name and a block of fields: the checker reads them, and nothing
/// before it knows one from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockKind {
    /// A passive part.
    Part,
    /// An actuator.
    Actuator,
    /// A model of the simulation.
    Model,
    /// A cell of a lattice.
    Cell,
    /// A search.
    Search,
    /// A set of worlds.
    Scenarios,
    /// A policy that decides actions.
    Policy,
}

impl BlockKind {
    const ALL: [Self; 7] =
        [Self::Part, Self::Actuator, Self::Model, Self::Cell, Self::Search, Self::Scenarios, Self::Policy];

    /// The word that opens it.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Part => "part",
            Self::Actuator => "actuator",
            Self::Model => "model",
            Self::Cell => "cell",
            Self::Search => "search",
            Self::Scenarios => "scenarios",
            Self::Policy => "policy",
        }
    }

    /// What a word opens.
    pub(super) fn of(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.word() == word)
    }
}

/// What stands between the braces of a declaration, where that can be read clause by clause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Clauses {
    None,
    Fields,
    Rule,
    Actuation,
    Begin,
    Task,
    Example,
    Edits,
    Novelty,
}

/// When a declaration counts as used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counts {
    /// Where something names it.
    WhereUsed,
    /// In the text that declares it; who imports it must name it.
    AtHome,
    /// Wherever it is.
    Everywhere,
}

/// The heading of what says how a grammar is run.
pub const SETTINGS: &str = "Settings";

/// All kinds, in the order in which they are listed to people.
pub const KINDS: &[Kind] = &[
    Kind {
        word: "grammar",
        form: "grammar my_walker",
        several: "grammar",
        what: "a declaration",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "use",
        form: "use std.blocks { cube, ball }",
        several: "use",
        what: "a declaration",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "param",
        form: "param longest : Length in 5 cm .. 40 cm = 20 cm",
        several: "Parameters",
        what: "a parameter",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "part",
        form: "part brick { ... }",
        several: "Parts",
        what: "a part",
        clauses: Clauses::Fields,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "actuator",
        form: "actuator finger { ... }",
        several: "Actuators",
        what: "an actuator",
        clauses: Clauses::Fields,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "symmetry",
        form: "symmetry radial 3 about y",
        several: SETTINGS,
        what: "a declaration",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "cell",
        form: "cell soft { ... }",
        several: "Cells",
        what: "a cell",
        clauses: Clauses::Fields,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "lattice",
        form: "lattice 15 x 15 x 15 of soft",
        several: "Lattices",
        what: "a lattice",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "fallback",
        form: "fallback undo when count(cell) >= 800",
        several: "Fallbacks",
        what: "a declaration",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "begin",
        form: "begin { place core : cube }",
        several: SETTINGS,
        what: "a declaration",
        clauses: Clauses::Begin,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "rule",
        form: "rule grow { ... }",
        several: "Rules",
        what: "a rule",
        clauses: Clauses::Rule,
        counts: Counts::Everywhere,
    },
    Kind {
        word: "require",
        form: "require few : count(part) <= 20 because \"the box is small\"",
        several: "Requirements",
        what: "a requirement",
        clauses: Clauses::None,
        counts: Counts::Everywhere,
    },
    Kind {
        word: "shared",
        form: "shared period : Time in 2 s .. 6 s mutate 0.3 by normal(0 s, 1 s)",
        several: "Shared variables",
        what: "a shared variable",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "pattern",
        form: "pattern swing = 60 deg * sin(cycle * 360 deg)",
        several: "Patterns",
        what: "a pattern",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "actuation",
        form: "actuation wave for a : actuator { ... }",
        several: "Actuations",
        what: "an actuation",
        clauses: Clauses::Actuation,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "actuate",
        form: "actuate bender with bezier_pac",
        several: SETTINGS,
        what: "a declaration",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "model",
        form: "model slow { ... }",
        several: "Models",
        what: "a model",
        clauses: Clauses::Fields,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "simulate",
        form: "simulate hinge_model for 20 s in workshop",
        several: SETTINGS,
        what: "a declaration",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "scenarios",
        form: "scenarios workshop { ... }",
        several: "Scenarios",
        what: "a set of worlds",
        clauses: Clauses::Fields,
        counts: Counts::Everywhere,
    },
    Kind {
        word: "sense",
        form: "sense lean : Angle = inclination(core.rotation at now) noise 1 deg delay 10 ms",
        several: "Sensors",
        what: "a sensor",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "state",
        form: "state phase : Number from 0 next fraction(phase + control_interval / 2 s)",
        several: "States",
        what: "a state",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "policy",
        form: "policy brain { hidden = [16]  every = 0.2 s }",
        several: "Policies",
        what: "a policy",
        clauses: Clauses::Fields,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "term",
        form: "term far : Length = max over e in elements of height(e.position at end)",
        several: "Terms",
        what: "a term",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "maximize",
        form: "maximize travel in cm",
        several: SETTINGS,
        what: "a declaration",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "minimize",
        form: "minimize travel in cm",
        several: SETTINGS,
        what: "a declaration",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "search",
        form: "search nested_annealing",
        several: "Searches",
        what: "a search",
        clauses: Clauses::Fields,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "let",
        form: "let width = 3 mm",
        several: "Constants",
        what: "a constant",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "enum",
        form: "enum Surface { carpet, sand }",
        several: "Enumerations",
        what: "an enumeration",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "record",
        form: "record Servo { torque : Torque, mass : Mass }",
        several: "Records",
        what: "a record",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "prefer",
        form: "prefer simple : count(actuator) <= 4 weight 3 because \"actuators are work\"",
        several: "Preferences",
        what: "a preference",
        clauses: Clauses::None,
        counts: Counts::Everywhere,
    },
    Kind {
        word: "task",
        form: "task ahead { maximize travel in cm }",
        several: "Tasks",
        what: "a task",
        clauses: Clauses::Task,
        counts: Counts::AtHome,
    },
    Kind {
        word: "example",
        form: "example two_legs { ... }",
        several: "Examples",
        what: "an example",
        clauses: Clauses::Example,
        counts: Counts::AtHome,
    },
    Kind {
        word: "variant",
        form: "variant workshop of \"./codesign.sgr\" { ... }",
        several: "Variants",
        what: "a variant",
        clauses: Clauses::Edits,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "table",
        form: "table lengths : Angle -> Length { 0 deg -> 0 mm, 90 deg -> 21 mm }",
        several: "Tables",
        what: "a table",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "target",
        form: "target valves on pneumatic for bender { ... }",
        several: "Targets",
        what: "a target",
        clauses: Clauses::None,
        counts: Counts::Everywhere,
    },
    Kind {
        word: "prototype",
        form: "prototype A on pneumatic { simulated = 35.6 m/h  measured = 5 m/h }",
        several: "Prototypes",
        what: "a prototype",
        clauses: Clauses::None,
        counts: Counts::Everywhere,
    },
    Kind {
        word: "allow",
        form: "allow unusual-value because \"a robot for the Moon\"",
        several: SETTINGS,
        what: "a declaration",
        clauses: Clauses::None,
        counts: Counts::Everywhere,
    },
    Kind {
        word: "observe",
        form: "observe travel, fall",
        several: SETTINGS,
        what: "a declaration",
        clauses: Clauses::None,
        counts: Counts::WhereUsed,
    },
    Kind {
        word: "novelty",
        form: "novelty mine { ... }",
        several: "Novelty sets",
        what: "a novelty set",
        clauses: Clauses::Novelty,
        counts: Counts::Everywhere,
    },
];

/// The words that open a declaration.
pub(crate) const ITEM_WORDS: &[&str] = &{
    let mut words = [""; KINDS.len()];
    let mut i = 0;
    while i < KINDS.len() {
        words[i] = KINDS[i].word;
        i += 1;
    }
    words
};

/// The kind that a word opens.
#[must_use]
pub fn kind(word: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.word == word)
}
