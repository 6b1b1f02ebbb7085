//! What can be measured, and the columns that each measurement has.

use grammar_lang::units::Dimension;

/// What a section of a measurement file measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// How much thread an actuator takes for a bend.
    Thread,
    /// The bend over time while it grows.
    Inflate,
    /// The bend over time while it goes back to zero.
    Deflate,
    /// The force with which a tip pushes.
    Tip,
    /// What parts weigh.
    Mass,
    /// When parts slip on the ground.
    Friction,
    /// Robots that were built, and how fast they were.
    Prototype,
}

/// A column of numbers or words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Column {
    pub(super) name: &'static str,
    /// The name of the dimension of its numbers; a column of words has none.
    pub(super) dimension: Option<Dimension>,
    pub(super) is_needed: bool,
}

const fn numbers(name: &'static str, dimension: Dimension) -> Column {
    Column { name, dimension: Some(dimension), is_needed: true }
}

const fn words(name: &'static str) -> Column {
    Column { name, dimension: None, is_needed: true }
}

const fn if_there(column: Column) -> Column {
    Column { is_needed: false, ..column }
}

impl Column {
    /// The dimension of its numbers.
    pub(super) fn measured_in(&self) -> Option<Dimension> {
        self.dimension
    }

    /// How its header may read, with a unit.
    pub(super) fn example(&self) -> String {
        let unit = match self.dimension {
            Some(Dimension::ANGLE) => "deg",
            Some(Dimension::LENGTH) => "mm",
            Some(Dimension::TIME) => "s",
            Some(Dimension::FORCE) => "N",
            Some(Dimension::MASS) => "g",
            Some(Dimension::VELOCITY) => "m/h",
            _ => return self.name.to_owned(),
        };
        format!("{} [{unit}]", self.name)
    }
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Thread, Self::Inflate, Self::Deflate, Self::Tip, Self::Mass, Self::Friction, Self::Prototype];

    /// How a file calls it.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Thread => "thread",
            Self::Inflate => "inflate",
            Self::Deflate => "deflate",
            Self::Tip => "tip",
            Self::Mass => "mass",
            Self::Friction => "friction",
            Self::Prototype => "prototype",
        }
    }

    /// Its columns.
    pub(super) fn columns(self) -> &'static [Column] {
        const THREAD: &[Column] = &[numbers("angle", Dimension::ANGLE), numbers("thread", Dimension::LENGTH)];
        const SPEED: &[Column] =
            &[numbers("time", Dimension::TIME), numbers("angle", Dimension::ANGLE), if_there(words("run"))];
        const TIP: &[Column] = &[
            if_there(numbers("angle", Dimension::ANGLE)),
            numbers("force", Dimension::FORCE),
            numbers("arm", Dimension::LENGTH),
        ];
        const MASS: &[Column] = &[
            if_there(words("part")),
            numbers("mass", Dimension::MASS),
            if_there(numbers("segments", Dimension::NUMBER)),
        ];
        const FRICTION: &[Column] = &[
            if_there(words("part")),
            if_there(numbers("tilt", Dimension::ANGLE)),
            if_there(numbers("pull", Dimension::FORCE)),
            if_there(numbers("weight", Dimension::FORCE)),
            if_there(numbers("mass", Dimension::MASS)),
        ];
        const PROTOTYPE: &[Column] = &[
            words("name"),
            words("build"),
            numbers("simulated", Dimension::VELOCITY),
            numbers("measured", Dimension::VELOCITY),
            if_there(numbers("length", Dimension::LENGTH)),
        ];
        match self {
            Self::Thread => THREAD,
            Self::Inflate | Self::Deflate => SPEED,
            Self::Tip => TIP,
            Self::Mass => MASS,
            Self::Friction => FRICTION,
            Self::Prototype => PROTOTYPE,
        }
    }

    /// What a section of this kind may say beside its columns.
    pub(super) fn settings(self) -> &'static [&'static str] {
        match self {
            Self::Thread => &["kind", "for", "file", "target", "tolerance"],
            Self::Prototype => &["kind", "file"],
            _ => &["kind", "for", "file"],
        }
    }

    /// The kind of a section that does not say it, by the names of its columns: of a bend over time, inflation,
    /// which [`Kind::with_direction`] corrects.
    pub(super) fn by_columns(names: &[&str]) -> Option<Self> {
        let has = |name: &str| names.contains(&name);
        if has("thread") {
            Some(Self::Thread)
        } else if has("time") && has("angle") {
            Some(Self::Inflate)
        } else if has("force") && has("arm") {
            Some(Self::Tip)
        } else if has("simulated") || has("measured") {
            Some(Self::Prototype)
        } else if has("tilt") || has("pull") {
            Some(Self::Friction)
        } else if has("mass") {
            Some(Self::Mass)
        } else {
            None
        }
    }

    /// The same, where the first and the last angle tell whether a bend grows.
    pub(super) fn with_direction(self, angles: Option<&Vec<f64>>) -> Self {
        let ends = angles.and_then(|a| Some((a.first()?.abs(), a.last()?.abs())));
        match ends {
            Some((first, last)) if self == Self::Inflate && last < first => Self::Deflate,
            _ => self,
        }
    }
}
