//! What a grammar says of the hardware that runs its gaits: targets, and the robots that were built.

use serde::{Deserialize, Serialize};

use super::text::{Names, Writer, range, tabulated};
use super::{Expr, Table, Ty};
use crate::source::Span;
use crate::units::{self, Dimension};

/// The outputs of the board: those of an ATmega328P beside its serial line, the stop circuit and the lamp, named as
/// an Arduino Uno names them.
pub const PINS: &[&str] =
    &["D3", "D4", "D5", "D6", "D7", "D8", "D9", "D10", "D11", "D12", "A0", "A1", "A2", "A3", "A4", "A5"];

/// A board with what is connected to it, and what that can do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// How it bends actuators.
    pub backend: Backend,
    /// The kind of actuators that it drives.
    pub kind: String,
    /// How fast a robot is, m/s: what is compared with prototypes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<Expr>,
    /// What the hardware measures: names of sensors.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensors: Vec<String>,
    /// Where it is declared.
    pub span: Span,
}

/// How a target bends actuators.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Backend {
    /// With air.
    Pneumatic(Pneumatic),
    /// With threads.
    Tendon(Tendon),
}

impl Backend {
    /// How a grammar writes them.
    pub const NAMES: &'static [&'static str] = &["pneumatic", "tendon"];

    /// How a grammar writes it.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Pneumatic(_) => "pneumatic",
            Self::Tendon(_) => "tendon",
        }
    }

    /// For how many actuators it has outputs.
    #[must_use]
    pub fn channels(&self) -> usize {
        match self {
            Self::Pneumatic(air) => air.inflate.len(),
            Self::Tendon(threads) => threads.servo.len(),
        }
    }
}

/// Two valves for each actuator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pneumatic {
    /// The pin of the valve that lets air in, by channel.
    pub inflate: Vec<String>,
    /// The pin of the valve that lets air out, by channel.
    pub vent: Vec<String>,
    /// How long a valve stays as it is at least, s.
    pub shortest: f64,
    /// Whether actuators are emptied when something goes wrong; else all valves close.
    pub vents: bool,
    /// What the actuators share, if it is modelled.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub supply: Option<Supply>,
}

/// A supply of air that actuators share: a reservoir at constant pressure, a line, and behind it a valve with
/// its tube for each actuator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Supply {
    /// Pressure of the reservoir above that of the surroundings, Pa.
    pub pressure: f64,
    /// Pressure in an actuator that is fully bent, Pa; it is taken to grow in proportion to the bend.
    pub full: f64,
    /// Flow through the line by difference of pressure, m^3/(s Pa).
    pub line: f64,
    /// The same for one valve with its tube.
    pub valve: f64,
}

/// A servo with a wheel for each actuator, or two.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tendon {
    /// The pin of the servo, by channel.
    pub servo: Vec<String>,
    /// The pin of a second servo that pulls the other way; empty if one wheel winds both threads.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub opposite: Vec<String>,
    /// From the bend in rad to the length of thread that is wound up, m.
    pub thread: Table,
    /// Radius of the wheel, m.
    pub wheel: f64,
    /// How far a servo turns, rad.
    pub turn: (f64, f64),
    /// How fast a servo turns, rad/s.
    pub speed: f64,
    /// The pulses at the ends of the turn, s.
    pub pulse: (f64, f64),
    /// Whether servos go back to the middle when something goes wrong; else they are let go.
    pub rests: bool,
}

impl Tendon {
    /// The bends that its servos reach, rad: no further than the table says.
    #[must_use]
    pub fn reach(&self) -> (f64, f64) {
        let (low, high) = self.thread.domain();
        let ends = [self.turn.0, self.turn.1].map(|turn| self.thread.inverse(turn * self.wheel));
        let (a, b) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        (a.max(low), b.min(high))
    }

    /// The bend that is reached where one is asked for, rad.
    #[must_use]
    pub fn reachable(&self, bend: f64) -> f64 {
        let (low, high) = self.reach();
        bend.max(low).min(high)
    }

    /// How far the servo is turned for a bend, rad.
    #[must_use]
    pub fn turned(&self, bend: f64) -> f64 {
        self.thread.at(self.reachable(bend)) / self.wheel
    }

    /// The bend that a servo comes to where it is turned so far, rad.
    #[must_use]
    pub fn bend(&self, turned: f64) -> f64 {
        self.thread.inverse(turned * self.wheel)
    }
}

/// A robot that was built, and what became of its speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prototype {
    /// The kind of build: the name of a [`Backend`].
    pub backend: String,
    /// What the simulation said, m/s.
    pub simulated: f64,
    /// What was measured, m/s.
    pub measured: f64,
    /// How long the robot is, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Where it is declared.
    pub span: Span,
}

impl Writer<'_> {
    pub(super) fn target(&mut self, name: &str, target: &Target) {
        self.gap();
        self.line(0, format!("target {name} on {} for {} {{", target.backend.name(), target.kind));
        let time = |x: f64| units::shown(x, Dimension::TIME);
        let mut fields = match &target.backend {
            Backend::Pneumatic(air) => vec![
                format!("inflate = [{}]", air.inflate.join(", ")),
                format!("vent = [{}]", air.vent.join(", ")),
                format!("shortest = {}", time(air.shortest)),
                format!("safe = {}", if air.vents { "vent" } else { "hold" }),
            ],
            Backend::Tendon(threads) => vec![
                format!("servo = [{}]", threads.servo.join(", ")),
                format!("thread = {}", tabulated(&threads.thread, Dimension::ANGLE, Dimension::LENGTH)),
                format!("wheel = {}", units::shown(threads.wheel, Dimension::LENGTH)),
                format!("turn = {}", range(threads.turn, &Ty::Quantity(Dimension::ANGLE))),
                format!("servo_speed = {}", units::shown(threads.speed, Dimension::ANGULAR_VELOCITY)),
                format!("pulse = {}", range(threads.pulse, &Ty::Quantity(Dimension::TIME))),
                format!("safe = {}", if threads.rests { "rest" } else { "release" }),
            ],
        };
        if let Backend::Pneumatic(Pneumatic { supply: Some(supply), .. }) = &target.backend {
            let (pressure, full) = (
                units::shown(supply.pressure, Dimension::PRESSURE),
                units::shown(supply.full, Dimension::PRESSURE),
            );
            let flow = |x: f64| units::shown(x, Dimension::FLOW_CONDUCTANCE);
            fields.push(format!(
                "supply {{ pressure = {pressure}, full = {full}, line = {}, valve = {} }}",
                flow(supply.line),
                flow(supply.valve)
            ));
        }
        if let Backend::Tendon(Tendon { opposite, .. }) = &target.backend
            && !opposite.is_empty()
        {
            fields.insert(1, format!("opposite = [{}]", opposite.join(", ")));
        }
        fields.extend(target.speed.as_ref().map(|s| format!("speed = {}", self.expr(s, &Names::new()))));
        for field in fields {
            self.line(1, field);
        }
        self.line(0, "}");
    }

    pub(super) fn prototype(&mut self, name: &str, prototype: &Prototype) {
        let speed = |x: f64| units::shown(x, Dimension::VELOCITY);
        let length = prototype
            .length
            .map_or(String::new(), |x| format!(", length = {}", units::shown(x, Dimension::LENGTH)));
        let (simulated, measured) = (speed(prototype.simulated), speed(prototype.measured));
        self.line(
            0,
            format!(
                "prototype {name} on {} {{ simulated = {simulated}, measured = {measured}{length} }}",
                prototype.backend
            ),
        );
    }
}
