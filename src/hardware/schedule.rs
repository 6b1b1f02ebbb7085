//! What a board is to do: a period, and for each actuator what its outputs do within it.

use serde::{Deserialize, Serialize};

use super::pin::Pin;

/// Microseconds.
pub type Micros = u32;

/// A gait, as a board runs it over and over.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// How long one cycle takes, in microseconds. Each cycle begins exactly this long after the one before.
    pub period: Micros,
    /// What outputs do when the board has stopped, for whatever reason.
    pub safe: Safe,
    /// The actuators; all of one kind.
    pub channels: Vec<Channel>,
}

/// One actuator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// What people call it.
    pub name: String,
    /// What drives it.
    pub output: Output,
}

/// What drives an actuator, and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Output {
    /// A pneumatic actuator with two valves.
    Valves {
        /// The valve between the supply and the actuator.
        inflate: Pin,
        /// The valve between the actuator and the air.
        vent: Pin,
        /// The least time between two changes, in microseconds: what the valve needs to open or close.
        least: Micros,
        /// From when on which valve is open, in microseconds since the beginning of the cycle; in order of
        /// time, the first at 0.
        changes: Vec<(Micros, ValveState)>,
    },
    /// A servo.
    Servo {
        /// Its signal.
        pin: Pin,
        /// Lengths of its pulses in microseconds, at equal distances over the period. Between them the board
        /// draws straight lines, also from the last to the first.
        pulses: Vec<u16>,
        /// The shortest and the longest pulse that it may get, in microseconds.
        range: [u16; 2],
        /// The pulse at rest, in microseconds: see [`Safe::Rest`].
        rest: u16,
        /// The angles at the ends of the range, in degrees; only drawings use them.
        degrees: [f64; 2],
    },
}

/// What an actuator's two valves do. Both are never open at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ValveState {
    /// Both closed: the actuator keeps its air.
    Closed,
    /// Air flows in.
    Inflate,
    /// Air flows out.
    Vent,
}

/// What the outputs do when the board has stopped: at the end, on a stop, when the host falls silent.
/// After a reset they are off whatever this says, as the board has forgotten it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Safe {
    /// Valves: both closed. The pressure is trapped, and the robot keeps its pose.
    Hold,
    /// Valves: the venting ones open. The robot goes limp.
    Vent,
    /// Servos: no pulses. Most servos then give way.
    Release,
    /// Servos: pulses of rest, held with force.
    Rest,
}

impl Output {
    /// The pins that it uses.
    #[must_use]
    pub fn pins(&self) -> Vec<Pin> {
        match self {
            Self::Valves { inflate, vent, .. } => vec![*inflate, *vent],
            Self::Servo { pin, .. } => vec![*pin],
        }
    }
}

impl Schedule {
    /// Whether it drives valves; else it drives servos.
    #[must_use]
    pub fn has_valves(&self) -> bool {
        matches!(self.channels.first(), Some(Channel { output: Output::Valves { .. }, .. }))
    }
}

/// A time in words.
pub(crate) fn seconds(time: Micros) -> String {
    let text = format!("{:.6}", f64::from(time) / 1e6);
    format!("{} s", text.trim_end_matches('0').trim_end_matches('.'))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::super::message::Limits;
    use super::*;

    pub(crate) fn valves(names: &[&str]) -> Schedule {
        let mut pins = Pin::all();
        let mut pin = || pins.next().unwrap();
        let changes =
            vec![(0, ValveState::Inflate), (300_000, ValveState::Closed), (500_000, ValveState::Vent)];
        let channel = |name: &&str| Channel {
            name: (*name).to_owned(),
            output: Output::Valves { inflate: pin(), vent: pin(), least: 10_000, changes: changes.clone() },
        };
        let channels = names.iter().map(channel).collect();
        Schedule { period: 1_000_000, safe: Safe::Hold, channels }
    }

    pub(crate) fn servos(names: &[&str]) -> Schedule {
        let curve = |i: usize| (0..64).map(|k| (1500 + (k * 20 + i * 100) % 400) as u16).collect();
        let channel = |(i, (name, pin)): (usize, (&&str, Pin))| Channel {
            name: (*name).to_owned(),
            output: Output::Servo {
                pin,
                pulses: curve(i),
                range: [600, 2400],
                rest: 1500,
                degrees: [-90.0, 90.0],
            },
        };
        let channels = names.iter().zip(Pin::all()).enumerate().map(channel).collect();
        Schedule { period: 2_000_000, safe: Safe::Release, channels }
    }

    /// The problems of a schedule after an edit, as text.
    fn problems(mut schedule: Schedule, edit: impl FnOnce(&mut Schedule)) -> String {
        edit(&mut schedule);
        let problems = schedule.check(&Limits::default());
        problems.iter().map(|problem| format!("{problem}\n")).collect()
    }

    fn changes(schedule: &mut Schedule, channel: usize) -> &mut Vec<(Micros, ValveState)> {
        match &mut schedule.channels[channel].output {
            Output::Valves { changes, .. } => changes,
            Output::Servo { .. } => panic!("a servo"),
        }
    }

    #[test]
    fn sound_schedules_have_no_problems() {
        assert_eq!(problems(valves(&["a", "b", "c", "d", "e", "f", "g", "h"]), |_| ()), "");
        assert_eq!(problems(servos(&["a", "b", "c", "d", "e", "f", "g", "h"]), |_| ()), "");
    }

    #[test]
    fn each_problem_names_its_channel() {
        let two = || valves(&["front", "back"]);
        let same_pin = |s: &mut Schedule| {
            let pin = s.channels[0].output.pins()[0];
            if let Output::Valves { vent, .. } = &mut s.channels[1].output {
                *vent = pin;
            }
        };
        assert_eq!(
            problems(two(), same_pin),
            "`back`: D3 is used by `front`, too: give one of them another\n"
        );
        assert!(
            problems(two(), |s| changes(s, 1)[0].0 = 5)
                .starts_with("`back`: its first change is at 0.000005 s")
        );
        assert!(
            problems(two(), |s| changes(s, 1).swap(1, 2))
                .starts_with("`back`: the change at 0.3 s comes after")
        );
        assert!(
            problems(two(), |s| changes(s, 1)[1].0 = 5000)
                .starts_with("`back`: its valves change at 0 s and")
        );
        // What ends the cycle and begins it is one state.
        let goes_on = |s: &mut Schedule| {
            *changes(s, 1) =
                vec![(0, ValveState::Vent), (5_000, ValveState::Inflate), (500_000, ValveState::Vent)]
        };
        assert_eq!(problems(two(), goes_on), "");
        let is_short = |s: &mut Schedule| {
            *changes(s, 1) =
                vec![(0, ValveState::Vent), (3_000, ValveState::Inflate), (996_000, ValveState::Vent)]
        };
        assert!(problems(two(), is_short).starts_with("`back`: its valves change at 0 s and"));
        assert!(
            problems(two(), |s| changes(s, 0)[2].0 = 995_000)
                .contains("`front`: its valves change at 0.995 s")
        );
        assert!(
            problems(two(), |s| changes(s, 0)[2].0 = 1_000_000)
                .contains("`front`: the change at 1 s is after")
        );
        assert!(problems(two(), |s| changes(s, 0).clear()).contains("`front`: it has no changes"));
        assert!(
            problems(two(), |s| s.channels[1] = servos(&["x"]).channels.remove(0))
                .contains("`x`: one schedule")
        );
        assert!(problems(two(), |s| s.channels.clear()).contains("nothing to drive"));
        assert!(problems(two(), |s| s.period = 1000).contains("its period is 0.001 s"));
        assert!(problems(two(), |s| s.safe = Safe::Rest).contains("other kind"));
    }

    #[test]
    fn servos_stay_within_their_range() {
        let edit = |range: [u16; 2], rest: u16, pulse: u16| {
            problems(servos(&["wrist"]), |s| {
                if let Output::Servo { range: r, rest: t, pulses, .. } = &mut s.channels[0].output {
                    (*r, *t, pulses[7]) = (range, rest, pulse);
                }
            })
        };
        assert_eq!(edit([600, 2400], 1500, 2400), "");
        assert_eq!(
            edit([600, 2000], 1500, 2001),
            "`wrist`: point 8 of its curve is 2001 us, outside of 600 to 2000 us\n"
        );
        assert!(edit([600, 2000], 500, 1000).contains("its rest is 500 us"));
        assert!(edit([400, 2000], 1500, 1000).contains("the board makes pulses of 500 to 2400 us"));
    }

    #[test]
    fn what_does_not_fit_is_told() {
        let many = |s: &mut Schedule| {
            *changes(s, 0) = (0..200).map(|i| (i * 5000, ValveState::Closed)).collect();
            s.channels[0].output = match s.channels[0].output.clone() {
                Output::Valves { inflate, vent, changes, .. } => {
                    Output::Valves { inflate, vent, least: 0, changes }
                }
                other => other,
            };
        };
        assert!(problems(valves(&["a"]), many).contains("it needs 1200 bytes"));
        let uneven = |s: &mut Schedule| {
            if let Output::Servo { pulses, .. } = &mut s.channels[1].output {
                pulses.pop();
            }
        };
        assert!(problems(servos(&["a", "b"]), uneven).contains("different numbers of points"));
        let nine: Vec<String> = (0..9).map(|i| i.to_string()).collect();
        let nine: Vec<&str> = nine.iter().map(String::as_str).collect();
        assert!(problems(servos(&nine), |_| ()).contains("9 channels, and the board drives 8"));
    }

    #[test]
    fn a_schedule_is_plain_data() {
        for schedule in [valves(&["a"]), servos(&["a"])] {
            let text = serde_json::to_string(&schedule).unwrap();
            assert_eq!(serde_json::from_str::<Schedule>(&text).unwrap(), schedule);
        }
        let text = serde_json::to_string(&valves(&["a"])).unwrap();
        assert!(text.contains(r#""inflate":"D3""#), "{text}");
        let error = serde_json::from_str::<Schedule>(&text.replace("D3", "D2")).unwrap_err().to_string();
        assert!(error.contains("stop circuit"), "{error}");
    }
}
