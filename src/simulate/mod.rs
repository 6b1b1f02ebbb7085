//! Simulation: an assembly and its actuators' targets become a recorded motion.
//!
//! A [`Model`] lowers an [`Assembly`] to its own bodies once; the [`Simulation`]
//! it returns then runs as many drives of that body as wanted without
//! allocating anew. Four solvers implement it: `articulated` (hinges in reduced
//! coordinates), `balls` (soft material as balls and springs), `rapier` (maximal
//! coordinates, the second opinion on both) and `rod` (actuators as elastic rods). This layer knows no grammar.

pub mod articulated;
pub mod balls;
mod check;
mod contacts;
pub mod export;
mod feedback;
mod ice;
mod lattice;
mod lowering;
pub mod motion;
pub mod rapier;
pub mod rod;
mod run;
mod schedule;
mod servo;
mod sliding;
mod stop;
#[cfg(test)]
pub(crate) mod tests;
mod turning;
mod widths;
mod world;

use serde::{Deserialize, Serialize};

use crate::design::assembly::Assembly;
pub use feedback::{ControlLoop, Controller, Measured, Snapshot};
pub use motion::{Motion, Placement, Targets};
pub use sliding::Sliding;
pub use stop::Stop;
pub use world::World;

/// The numbers of a simulation, in SI units; a grammar's `model` gives them.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Time step in s. For `balls` it must be short enough for the stiffest springs, or the body is refused.
    pub step: f64,
    /// Simulated time in s.
    pub duration: f64,
    /// Time between recorded frames in s. It need not be a multiple of `step`: a frame within a step is
    /// interpolated between the states at its ends.
    pub record: f64,
    /// Gravity, downwards, in m/s^2.
    pub gravity: f64,
    /// Coulomb coefficient of the ground.
    pub ground_friction: f64,
    /// Sweeps of the contact solver per step, at most. For `balls` those of balls that touch each other: the ground
    /// needs none.
    pub iterations: usize,
    /// A sweep that changes no impulse by more than this share of all is the last.
    pub tolerance: f64,
    /// Whether parts of the body collide with each other.
    pub self_collision: bool,
    /// An element faster than this (m/s) makes the evaluation invalid.
    pub speed_limit: f64,
    /// An element that is faster than this (m/s) on its way to where it ends makes the evaluation invalid: along
    /// the ground, in the mean from any whole second until the end, at least [`LAST_STRETCH`].
    pub pace_limit: Option<f64>,
}

/// A body may turn so far in a step, rad. Solvers take the chord for the arc: of this angle it is a hundredth shorter.
pub const MOST_TURN: f64 = 0.25;

/// The shortest stretch of a motion, s, of which a pace is asked.
pub const LAST_STRETCH: f64 = 2.0;

impl Settings {
    /// The same model, simulated with more care: half the step, contacts solved ten times as far, and twice as many frames,
    /// since a body can shake between two of them. Balls and springs take about twice as long for it.
    #[must_use]
    pub fn finer(&self) -> Self {
        Self {
            step: self.step / 2.0,
            record: self.record / 2.0,
            iterations: self.iterations * 10,
            tolerance: self.tolerance / 10.0,
            ..self.clone()
        }
    }

    /// How fast a body may turn, rad/s: see [`MOST_TURN`].
    #[must_use]
    pub fn turn_limit(&self) -> f64 {
        MOST_TURN / self.step
    }

    /// The same model with so many whole steps that they end when the motion does: the step is shortened, by less
    /// than one part in the number of steps. A step that divides the duration already stays what it is, bit for bit.
    #[must_use]
    pub fn in_whole_steps(&self) -> Self {
        let steps = self.duration / self.step;
        let fits = (steps - libm::round(steps)).abs() <= 1e-9 * steps;
        let step = if steps > 1.0 && !fits { self.duration / libm::ceil(steps) } else { self.step };
        Self { step, ..self.clone() }
    }
}

/// Why an assembly or its settings cannot be simulated at all.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unfit {
    /// A sentence for people: what is wrong and how to mend it.
    pub reason: String,
}

/// Why one run gave no motion that may be scored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Invalid {
    /// A number stopped being finite.
    NotFinite,
    /// An element went faster than the model's speed limit.
    TooFast,
    /// A body turned so far in each of many steps that its way and its momentum are wrong.
    TurnsTooFast,
    /// An element was faster than the model's pace limit on its way to where it ended.
    TooFar,
    /// The centre of a body went through the ground.
    Sunk,
    /// There was energy that no servo had put in.
    EnergyFromNowhere,
    /// The solver could not hold joints within their limits.
    BeyondLimits,
    /// What its feedback asks for has no value.
    NoCommand,
    /// The observer stopped it: the motion is not known.
    GivenUp,
    /// The solver cannot simulate the body in this world, though it can in the nominal one.
    Unfit,
}

impl Invalid {
    /// In words, for "so many evaluations were invalid: ...".
    #[must_use]
    pub fn describe(self) -> &'static str {
        match self {
            Self::NotFinite => "not finite",
            Self::TooFast => "too fast",
            Self::TurnsTooFast => "turning too fast for its steps",
            Self::TooFar => "too far in its time",
            Self::NoCommand => "an actuation or a state without a value",
            Self::GivenUp => "given up",
            Self::Unfit => "not to be simulated there",
            Self::Sunk => "through the ground",
            Self::EnergyFromNowhere => "energy from nowhere",
            Self::BeyondLimits => "joints beyond their limits",
        }
    }
}

/// The solvers. Here alone it is said which there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolverName {
    /// Hinges in reduced coordinates: fast, for searches.
    Articulated,
    /// Balls and springs.
    Balls,
    /// Hinges by another engine: the second opinion.
    Rapier,
    /// Actuators as elastic rods: softer than hinges, and dearer.
    Rod,
}

impl SolverName {
    /// Every one, the default first.
    pub const ALL: [Self; 4] = [Self::Articulated, Self::Balls, Self::Rapier, Self::Rod];

    /// What `--solver` and saved designs call it.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Articulated => "articulated",
            Self::Balls => "balls",
            Self::Rapier => "rapier",
            Self::Rod => "rod",
        }
    }

    /// The one that is called so.
    #[must_use]
    pub fn named(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|name| name.text() == text)
    }

    /// The solver.
    #[must_use]
    pub fn model(self) -> &'static dyn Model {
        match self {
            Self::Articulated => &articulated::Articulated,
            Self::Balls => &balls::Balls,
            Self::Rapier => &rapier::Rapier::FINE,
            Self::Rod => &rod::Rod::FINE,
        }
    }
}

/// The solver of a name.
#[must_use]
pub fn model(name: &str) -> Option<&'static dyn Model> {
    SolverName::named(name).map(SolverName::model)
}

/// A simulation method.
pub trait Model: Sync {
    /// Which method it is.
    fn name(&self) -> SolverName;

    /// Lowers an assembly to the solver's own bodies, resting on the ground.
    ///
    /// # Errors
    ///
    /// [`Unfit`] when a mass, size, limit or step makes no sense.
    fn prepare(&self, assembly: &Assembly, settings: &Settings) -> Result<Box<dyn Simulation>, Unfit>;
}

/// Looks at runs under way and gives up those that cannot come to anything.
pub trait Watch: Sync {
    /// Whether to give up a case, by its place among those that run; asked at every whole second of the motion
    /// with what has been recorded until then.
    fn gives_up(&self, case: usize, motion: &Motion, now: f64) -> bool;
}

/// Gives up nothing.
struct Unwatched;

impl Watch for Unwatched {
    fn gives_up(&self, _: usize, _: &Motion, _: f64) -> bool {
        false
    }
}

/// A motion to make.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    /// What the actuators are asked for, as far as it is known ahead.
    pub drive: &'a Targets,
    /// What commands the others, if there are any.
    pub controller: Option<&'a dyn Controller>,
    /// Where it moves.
    pub world: &'a World,
}

impl<'a> Case<'a> {
    /// A drive without feedback.
    #[must_use]
    pub const fn new(drive: &'a Targets, world: &'a World) -> Self {
        Self { drive, controller: None, world }
    }

    /// The same in the nominal world.
    #[must_use]
    pub const fn nominal(drive: &'a Targets) -> Self {
        Self::new(drive, &World::NOMINAL)
    }
}

/// One body, ready to be driven any number of times.
pub trait Simulation: Send {
    /// How many cases it runs side by side: give it as many at once, if there are.
    fn lanes(&self) -> usize;

    /// Simulates each case from rest; one outcome per case, in order. Runs
    /// are independent: an outcome does not depend on the others in the batch
    /// nor on earlier calls, bit for bit. What the watch gives up ends as [`Invalid::GivenUp`].
    /// None if it was asked to stop before all were done.
    fn run_watched(
        &mut self,
        stop: Stop<'_>,
        cases: &[Case<'_>],
        watch: &dyn Watch,
    ) -> Option<Vec<Result<Motion, Invalid>>>;

    /// The same, unwatched.
    fn run_cases(&mut self, stop: Stop<'_>, cases: &[Case<'_>]) -> Option<Vec<Result<Motion, Invalid>>> {
        self.run_watched(stop, cases, &Unwatched)
    }

    /// Simulates each drive in the nominal world.
    fn run_until(&mut self, stop: Stop<'_>, drives: &[Targets]) -> Option<Vec<Result<Motion, Invalid>>> {
        let cases: Vec<Case<'_>> = drives.iter().map(Case::nominal).collect();
        self.run_cases(stop, &cases)
    }

    /// Simulates each drive in the nominal world to its end.
    fn run(&mut self, drives: &[Targets]) -> Vec<Result<Motion, Invalid>> {
        self.run_until(Stop::NEVER, drives).unwrap_or_default()
    }
}
