//! From what actuators are asked for to what a board plays.

use grammar_lang::eval::Valve;
use grammar_lang::ir::{Backend as Declared, Pneumatic, Target, Tendon};
use thiserror::Error;

use super::error::Problem;
use super::pin::{NoPin, Pin};
use super::schedule::{Channel, Micros, Output, Safe, Schedule, ValveState};
use crate::drive::{Asked, Cycle};

/// At so many points of a period servos get a pulse of their own; the board draws straight lines in between.
pub const POINTS: usize = 64;

/// Bends in rad that differ by less are the same.
const CLOSE: f64 = 1e-6;

/// Why the outputs of a channel cannot do what is asked of its actuator.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Unplayable {
    /// Valves know no angle.
    #[error(
        "it follows an angle, but the target drives valves: actuate it with an actuation that says `drive valves = ...`"
    )]
    Angle,
    /// Servos know no valves.
    #[error(
        "it follows valves, but the target drives servos: actuate it with an actuation that says `drive angle = ...`"
    )]
    Valves,
    /// A time is beyond what a board counts.
    #[error("its cycle is too long for a board to count")]
    TooLong,
    /// The target names too few pins.
    #[error("the target has no pin for channel {channel}")]
    NoPin {
        /// Which, from 1.
        channel: usize,
    },
    /// A pin is none.
    #[error(transparent)]
    Pin(#[from] NoPin),
}

/// A way to bend actuators.
pub trait Backend {
    /// For how many actuators it has outputs.
    fn channels(&self) -> usize;
    /// What outputs do when the board has stopped.
    fn safe(&self) -> Safe;
    /// What the outputs of a channel do, for an actuator with a name.
    ///
    /// # Errors
    ///
    /// Why they cannot do what is asked for.
    fn outputs(&self, channel: usize, name: &str, asked: &Asked) -> Result<Vec<Channel>, Unplayable>;
    /// What it leaves out of what an actuator is asked for, in words.
    fn cut(&self, asked: &Asked) -> Option<String>;
}

/// The back end of a target.
#[must_use]
pub fn backend(target: &Target) -> Box<dyn Backend + '_> {
    match &target.backend {
        Declared::Pneumatic(air) => Box::new(Valves { air }),
        Declared::Tendon(threads) => Box::new(Servos { threads }),
    }
}

/// What a board plays for a cycle of some actuators, in the order of the target's channels; `names` are what people
/// call the actuators.
///
/// # Errors
///
/// All that does not fit together.
pub fn schedule(backend: &dyn Backend, cycle: &Cycle, names: &[String]) -> Result<Schedule, Vec<Problem>> {
    let mut problems = Vec::new();
    let mut whole = |text: String| problems.push(Problem { channel: None, text });
    if cycle.actuators.len() > backend.channels() {
        whole(format!(
            "the design has {} actuators, the target has {} channels: name more pins in the target, or ask for fewer \
             actuators with a requirement",
            cycle.actuators.len(),
            backend.channels()
        ));
    }
    let period = micros(cycle.period);
    if period.is_none() {
        whole(format!("a board cannot count a period of {} s", cycle.period));
    }
    let mut channels = Vec::new();
    for (number, ((_, asked), name)) in cycle.actuators.iter().zip(names).enumerate().take(backend.channels())
    {
        match backend.outputs(number, name, asked) {
            Ok(outputs) => channels.extend(outputs),
            Err(why) => problems.push(Problem { channel: Some(name.clone()), text: why.to_string() }),
        }
    }
    match period {
        Some(period) if problems.is_empty() => Ok(Schedule { period, safe: backend.safe(), channels }),
        _ => Err(problems),
    }
}

/// A time in whole microseconds.
fn micros(seconds: f64) -> Option<Micros> {
    let micros = libm::round(seconds * 1e6);
    (0.0..=f64::from(Micros::MAX)).contains(&micros).then_some(micros as Micros)
}

fn pin(pins: &[String], channel: usize) -> Result<Pin, Unplayable> {
    let name = pins.get(channel).ok_or(Unplayable::NoPin { channel: channel + 1 })?;
    Ok(name.parse()?)
}

/// Two valves for each actuator.
struct Valves<'a> {
    air: &'a Pneumatic,
}

impl Backend for Valves<'_> {
    fn channels(&self) -> usize {
        self.air.inflate.len()
    }

    fn safe(&self) -> Safe {
        if self.air.vents { Safe::Vent } else { Safe::Hold }
    }

    fn outputs(&self, channel: usize, name: &str, asked: &Asked) -> Result<Vec<Channel>, Unplayable> {
        let Asked::Valves(valves) = asked else {
            return Err(Unplayable::Angle);
        };
        let settled = valves.settled(self.air.shortest);
        let changes = settled.changes.iter().map(|(from, state)| {
            let state = match state {
                Valve::Closed => ValveState::Closed,
                Valve::Inflate => ValveState::Inflate,
                Valve::Vent => ValveState::Vent,
            };
            Ok((micros(*from).ok_or(Unplayable::TooLong)?, state))
        });
        let output = Output::Valves {
            inflate: pin(&self.air.inflate, channel)?,
            vent: pin(&self.air.vent, channel)?,
            // Rounding both ends of a state may have made it two microseconds shorter.
            least: micros(self.air.shortest).ok_or(Unplayable::TooLong)?.saturating_sub(2),
            changes: changes.collect::<Result<_, Unplayable>>()?,
        };
        Ok(vec![Channel { name: name.to_owned(), output }])
    }

    fn cut(&self, asked: &Asked) -> Option<String> {
        let Asked::Valves(valves) = asked else { return None };
        let settled = valves.settled(self.air.shortest);
        let least = (self.air.shortest * 1e9).round() / 1e6;
        match valves.changes.len().saturating_sub(settled.changes.len()) {
            0 if settled == *valves => None,
            0 => Some(format!("states of its valves are moved: each holds for {least} ms at least")),
            1 => Some(format!(
                "a state of its valves is shorter than the {least} ms that they need, and is left out"
            )),
            n => Some(format!(
                "{n} states of its valves are shorter than the {least} ms that they need, and are left out"
            )),
        }
    }
}

/// A servo for each actuator, or two.
struct Servos<'a> {
    threads: &'a Tendon,
}

impl Servos<'_> {
    /// A servo that winds as far as bends ask for.
    fn servo(&self, pin: Pin, bends: impl Iterator<Item = f64>) -> Output {
        let Tendon { turn, pulse, .. } = self.threads;
        let of = |turned: f64| {
            let share = ((turned - turn.0) / (turn.1 - turn.0)).clamp(0.0, 1.0);
            libm::round((pulse.0 + (pulse.1 - pulse.0) * share) * 1e6) as u16
        };
        Output::Servo {
            pin,
            pulses: bends.map(|bend| of(self.threads.turned(bend))).collect(),
            range: [of(turn.0), of(turn.1)],
            rest: of(self.threads.turned(0.0)),
            degrees: [turn.0.to_degrees(), turn.1.to_degrees()],
        }
    }
}

impl Backend for Servos<'_> {
    fn channels(&self) -> usize {
        self.threads.servo.len()
    }

    fn safe(&self) -> Safe {
        if self.threads.rests { Safe::Rest } else { Safe::Release }
    }

    fn outputs(&self, channel: usize, name: &str, asked: &Asked) -> Result<Vec<Channel>, Unplayable> {
        let Asked::Bends(bends) = asked else {
            return Err(Unplayable::Valves);
        };
        let one = self.servo(pin(&self.threads.servo, channel)?, bends.iter().copied());
        if self.threads.opposite.is_empty() {
            return Ok(vec![Channel { name: name.to_owned(), output: one }]);
        }
        // What the one thread gives, the other takes.
        let other = self.servo(pin(&self.threads.opposite, channel)?, bends.iter().map(|bend| -bend));
        let named = |side: &str, output| Channel { name: format!("{name} {side}"), output };
        Ok(vec![named("+", one), named("-", other)])
    }

    fn cut(&self, asked: &Asked) -> Option<String> {
        let Asked::Bends(bends) = asked else { return None };
        let (low, high) = self.threads.reach();
        let beyond = |bend: f64| (bend - self.threads.reachable(bend)).abs();
        let most = bends.iter().copied().max_by(|a, b| beyond(*a).total_cmp(&beyond(*b)))?;
        (beyond(most) > CLOSE).then(|| {
            format!(
                "it is asked to bend by {:.1} deg, and its servo and its table end at {:.1} and {:.1} deg",
                most.to_degrees(),
                low.to_degrees(),
                high.to_degrees()
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use grammar_lang::eval::Valves as States;
    use grammar_lang::ir::Table;

    use super::*;
    use crate::design::CORE;

    fn cycle(asked: Vec<Asked>) -> Cycle {
        let part = |asked| (CORE, asked);
        Cycle { period: 2.0, actuators: asked.into_iter().map(part).collect() }
    }

    fn air() -> Pneumatic {
        let pins = |names: [&str; 2]| names.map(str::to_owned).to_vec();
        let (inflate, vent) = (pins(["D3", "D5"]), pins(["D4", "D6"]));
        Pneumatic { inflate, vent, shortest: 0.04, vents: true, supply: None }
    }

    fn threads() -> Tendon {
        Tendon {
            servo: vec!["D3".to_owned()],
            opposite: Vec::new(),
            thread: Table { rows: vec![[-1.0, -0.01], [1.0, 0.01]] },
            wheel: 0.01,
            turn: (-1.0, 1.0),
            speed: 5.0,
            pulse: (1e-3, 2e-3),
            rests: true,
        }
    }

    fn breathing() -> Asked {
        let states = [Valve::Closed, Valve::Inflate, Valve::Closed, Valve::Vent];
        Asked::Valves(States::cycle(2.0, &[0.25, 0.25, 0.01, 0.49], &states, 0.0).unwrap())
    }

    fn made(backend: &dyn Backend, cycle: &Cycle) -> Result<Schedule, Vec<Problem>> {
        schedule(backend, cycle, &["one", "two", "three"].map(str::to_owned))
    }

    #[test]
    fn valves_change_when_the_cycle_says_but_for_what_is_too_short() {
        let air = air();
        let played = made(&Valves { air: &air }, &cycle(vec![breathing()])).unwrap();
        let Output::Valves { changes, .. } = &played.channels[0].output else { panic!("no valves") };
        use ValveState::{Closed, Inflate, Vent};
        assert_eq!(*changes, [(0, Closed), (500_000, Inflate), (1_020_000, Vent)]);
        assert_eq!((played.period, played.safe), (2_000_000, Safe::Vent));
        let cut = Valves { air: &air }.cut(&breathing()).unwrap();
        assert!(cut.starts_with("a state of its valves is shorter than the 40 ms"), "{cut}");
        let fast = Pneumatic { shortest: 0.005, ..air };
        assert_eq!(Valves { air: &fast }.cut(&breathing()), None);
    }

    #[test]
    fn servos_turn_as_the_table_says() {
        let mut threads = threads();
        let asked = cycle(vec![Asked::Bends(vec![-1.0, 0.0, 0.5, 1.4])]);
        let played = made(&Servos { threads: &threads }, &asked).unwrap();
        let Output::Servo { pulses, rest, .. } = &played.channels[0].output else { panic!("no servo") };
        assert_eq!((pulses.as_slice(), *rest), ([1000, 1500, 1750, 2000].as_slice(), 1500));
        threads.opposite = vec!["D4".to_owned()];
        let played = made(&Servos { threads: &threads }, &asked).unwrap();
        let Output::Servo { pulses, .. } = &played.channels[1].output else { panic!("no servo") };
        assert_eq!(pulses.as_slice(), [2000, 1500, 1250, 1000]);
        let servos = Servos { threads: &threads };
        assert!(servos.cut(&asked.actuators[0].1).unwrap().contains("80.2 deg"));
        assert_eq!(servos.cut(&Asked::Bends(vec![-1.0, 0.9])), None);
    }

    #[test]
    fn what_does_not_fit_together_is_told_at_once() {
        let (air, threads) = (air(), threads());
        let three = cycle(vec![breathing(), Asked::Bends(vec![0.0]), breathing()]);
        let refused = made(&Valves { air: &air }, &three).unwrap_err();
        let texts: Vec<String> = refused.iter().map(ToString::to_string).collect();
        assert!(texts[0].contains("3 actuators, the target has 2 channels"), "{texts:?}");
        assert!(texts[1].contains("`two`: it follows an angle"), "{texts:?}");
        let refused = made(&Servos { threads: &threads }, &cycle(vec![breathing()]));
        assert!(refused.unwrap_err()[0].text.contains("it follows valves"));
    }
}
