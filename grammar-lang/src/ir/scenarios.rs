//! Scenarios: the worlds that a gait is judged in beside the one that the grammar describes.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::text::Writer;
use super::{Backend, Method, RuleSet, Task, Ty};
use crate::source::Span;
use crate::units::{self, Dimension};

/// What can differ between worlds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Difference {
    /// Factor of the coefficient of every contact.
    Friction,
    /// The coefficient of the ground in place of the model's.
    GroundFriction,
    /// Factor of masses and moments of inertia.
    Mass,
    /// Factor of the greatest torques.
    Torque,
    /// Factor of the speeds of actuators and servos.
    Speed,
    /// Factor of the pressure of a supply.
    Pressure,
    /// How far the body is turned about its core before it is set down, rad.
    Tilt,
    /// How far the ground rises towards +x, rad.
    Slope,
    /// How late an actuator is, s: each draws its own.
    Late,
}

impl Difference {
    /// All of them, as they are listed to people.
    pub const ALL: [Self; 9] = [
        Self::Friction,
        Self::GroundFriction,
        Self::Mass,
        Self::Torque,
        Self::Speed,
        Self::Pressure,
        Self::Tilt,
        Self::Slope,
        Self::Late,
    ];

    /// What a grammar calls it.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Friction => "friction",
            Self::GroundFriction => "ground_friction",
            Self::Mass => "mass",
            Self::Torque => "torque",
            Self::Speed => "speed",
            Self::Pressure => "pressure",
            Self::Tilt => "tilt",
            Self::Slope => "slope",
            Self::Late => "late",
        }
    }

    /// Its dimension. Factors are numbers.
    #[must_use]
    pub const fn dimension(self) -> Dimension {
        match self {
            Self::Friction
            | Self::GroundFriction
            | Self::Mass
            | Self::Torque
            | Self::Speed
            | Self::Pressure => Dimension::NUMBER,
            Self::Tilt | Self::Slope => Dimension::ANGLE,
            Self::Late => Dimension::TIME,
        }
    }

    /// The least and the greatest that it may be, in SI units.
    #[must_use]
    pub const fn limits(self) -> (f64, f64) {
        const STEEP: f64 = std::f64::consts::FRAC_PI_4;
        match self {
            Self::Friction | Self::GroundFriction => (0.0, 10.0),
            Self::Mass | Self::Torque | Self::Speed | Self::Pressure => (0.1, 10.0),
            Self::Tilt => (0.0, STEEP),
            Self::Slope => (-STEEP, STEEP),
            Self::Late => (0.0, 10.0),
        }
    }

    /// One as a text may give it.
    #[must_use]
    pub const fn example(self) -> &'static str {
        match self {
            Self::Friction => "75 % .. 125 %",
            Self::GroundFriction => "0.6 .. 1.0",
            Self::Mass | Self::Speed | Self::Pressure => "90 % .. 110 %",
            Self::Torque => "85 % .. 115 %",
            Self::Tilt => "0 deg .. 2 deg",
            Self::Slope => "-2 deg .. 2 deg",
            Self::Late => "0 ms .. 50 ms",
        }
    }

    /// A value of it as text.
    #[must_use]
    pub fn shown(self, value: f64) -> String {
        match self {
            Self::GroundFriction => value.to_string(),
            Self::Friction | Self::Mass | Self::Torque | Self::Speed | Self::Pressure => {
                // Rounding of the percentage is not of interest.
                format!("{} %", libm::round(value * 1e6) / 1e4)
            }
            Self::Tilt | Self::Slope | Self::Late => units::shown(value, self.dimension()),
        }
    }
}

/// A set of worlds: the nominal one, named cases, and some that are drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scenarios {
    /// What drawn worlds differ in: least and greatest, in SI units.
    pub ranges: IndexMap<Difference, (f64, f64)>,
    /// How many are drawn.
    pub drawn: usize,
    /// Worlds that differ in just this.
    pub cases: IndexMap<String, IndexMap<Difference, f64>>,
    /// Where it is declared.
    pub span: Span,
}

impl Scenarios {
    /// The most worlds that may be drawn.
    pub const MOST: usize = 1000;

    /// How many worlds there are, the nominal one among them.
    #[must_use]
    pub fn count(&self) -> usize {
        1 + self.cases.len() + self.drawn
    }
}

impl RuleSet {
    /// Whether bodies can differ in something when they do some of the tasks.
    ///
    /// # Errors
    ///
    /// Why not.
    pub fn can_differ<'t>(
        &self,
        difference: Difference,
        tasks: impl IntoIterator<Item = &'t Task>,
    ) -> Result<(), &'static str> {
        let balls = matches!(self.method(), Method::Balls(_));
        let is_supplied = |task: &Task| {
            self.targets_of(task)
                .any(|(_, target)| matches!(&target.backend, Backend::Pneumatic(air) if air.supply.is_some()))
        };
        match difference {
            Difference::Torque if balls => Err("balls and springs have no torques"),
            Difference::Speed if balls => Err("balls and springs have no servos whose speed could differ"),
            Difference::Pressure if !tasks.into_iter().any(is_supplied) => {
                Err("no task is simulated on a target with a supply")
            }
            _ => Ok(()),
        }
    }

    /// What of a set of worlds bodies cannot differ in when they do some of the tasks, with the reason.
    pub fn cannot_apply<'t>(
        &self,
        set: &Scenarios,
        tasks: impl IntoIterator<Item = &'t Task> + Clone,
    ) -> Option<(Difference, &'static str)> {
        let given = set.ranges.keys().chain(set.cases.values().flat_map(IndexMap::keys));
        given
            .copied()
            .find_map(|difference| Some((difference, self.can_differ(difference, tasks.clone()).err()?)))
    }
}

impl From<Difference> for Ty {
    fn from(difference: Difference) -> Self {
        Self::Quantity(difference.dimension())
    }
}

impl Writer<'_> {
    pub(super) fn scenarios(&mut self, name: &str, scenarios: &Scenarios) {
        self.gap();
        self.line(0, format!("scenarios {name} {{"));
        for (difference, (low, high)) in &scenarios.ranges {
            let (low, high) = (difference.shown(*low), difference.shown(*high));
            self.line(1, format!("{} = {low} .. {high}", difference.text()));
        }
        if scenarios.drawn > 0 {
            self.line(1, format!("drawn = {}", scenarios.drawn));
        }
        for (name, case) in &scenarios.cases {
            let fields = case.iter().map(|(of, value)| format!("{} = {}", of.text(), of.shown(*value)));
            self.line(1, format!("case {name} {{ {} }}", fields.collect::<Vec<_>>().join("  ")));
        }
        self.line(0, "}");
    }
}
