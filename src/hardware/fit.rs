//! Whether a board can run a schedule.

use std::collections::BTreeMap;

use super::error::Problem;
use super::message::Limits;
use super::pin::Pin;
use super::program;
use super::schedule::{Micros, Output, Safe, Schedule, ValveState, seconds};

impl Schedule {
    /// All that is wrong with it, by itself and for a board with these limits; empty if a board can run it.
    #[must_use]
    pub fn check(&self, limits: &Limits) -> Vec<Problem> {
        let mut problems = Vec::new();
        let mut whole = |text: String| problems.push(Problem { channel: None, text });
        if self.channels.is_empty() {
            whole("it has no channels: there is nothing to drive".into());
        }
        if self.channels.len() > limits.channels {
            whole(format!(
                "it has {} channels, and the board drives {}: leave out actuators, or use a second board",
                self.channels.len(),
                limits.channels
            ));
        }
        let (least, most) = limits.periods;
        if !(least..=most).contains(&self.period) {
            whole(format!(
                "its period is {}: the board runs periods of {} to {}",
                seconds(self.period),
                seconds(least),
                seconds(most)
            ));
        }
        let fits = match self.safe {
            Safe::Hold | Safe::Vent => self.has_valves(),
            Safe::Release | Safe::Rest => !self.has_valves(),
        };
        if !fits && !self.channels.is_empty() {
            whole("its safe state is of the other kind: valves hold or vent, servos release or rest".into());
        }
        self.check_size(limits, &mut problems);
        self.check_pins(limits, &mut problems);
        for channel in &self.channels {
            let texts = match &channel.output {
                Output::Valves { .. } if !self.has_valves() => vec![MIXED.to_owned()],
                Output::Servo { .. } if self.has_valves() => vec![MIXED.to_owned()],
                Output::Valves { changes, least, .. } => changes_at_fault(changes, *least, self.period),
                Output::Servo { pulses, range, rest, .. } => pulses_at_fault(pulses, *range, *rest, limits),
            };
            problems
                .extend(texts.into_iter().map(|text| Problem { channel: Some(channel.name.clone()), text }));
        }
        problems
    }

    fn check_size(&self, limits: &Limits, problems: &mut Vec<Problem>) {
        let mut points = self.channels.iter().filter_map(|channel| match &channel.output {
            Output::Servo { pulses, .. } => Some(pulses.len()),
            Output::Valves { .. } => None,
        });
        if let Some(first) = points.next()
            && !points.all(|other| other == first)
        {
            let text = "its servos have different numbers of points: give all the same number".into();
            problems.push(Problem { channel: None, text });
        }
        let bytes = program::table(self).len();
        if bytes > limits.table {
            let text = format!(
                "it needs {bytes} bytes in the board, which has {}: fewer changes (of 6 bytes) or points (of 2)",
                limits.table
            );
            problems.push(Problem { channel: None, text });
        }
    }

    fn check_pins(&self, limits: &Limits, problems: &mut Vec<Problem>) {
        let mut taken: BTreeMap<Pin, &str> = BTreeMap::new();
        for channel in &self.channels {
            let mut wrong = |text| problems.push(Problem { channel: Some(channel.name.clone()), text });
            for pin in channel.output.pins() {
                if limits.pins >> pin.number() & 1 == 0 {
                    wrong(format!("this board has no output {pin}"));
                }
                match taken.insert(pin, &channel.name) {
                    Some(other) if other == channel.name => {
                        wrong(format!("{pin} is used for both its valves: each needs a pin of its own"));
                    }
                    Some(other) => {
                        wrong(format!("{pin} is used by `{other}`, too: give one of them another"))
                    }
                    None => {}
                }
            }
        }
    }
}

const MIXED: &str = "one schedule drives valves or servos, not both: use a second board";

fn changes_at_fault(changes: &[(Micros, ValveState)], least: Micros, period: Micros) -> Vec<String> {
    let mut out = Vec::new();
    match changes.first() {
        None => return vec!["it has no changes: give at least the state of its valves from 0 on".into()],
        Some((0, _)) => {}
        Some((at, _)) => out.push(format!("its first change is at {}: it must be at 0", seconds(*at))),
    }
    // The state that ends the cycle may go on at its beginning.
    let goes_on = match (changes.first(), changes.last()) {
        (Some((_, first)), Some((last, state))) if first == state => period.saturating_sub(*last),
        _ => 0,
    };
    for (i, pair) in changes.windows(2).enumerate() {
        let ((before, _), (at, _)) = (pair[0], pair[1]);
        let since = if i == 0 { goes_on } else { 0 };
        if at <= before {
            out.push(format!("the change at {} comes after the one at {}", seconds(at), seconds(before)));
        } else if at - before + since < least {
            out.push(too_fast(before, at, least));
        }
    }
    if let Some((last, state)) = changes.last() {
        if *last >= period {
            out.push(format!("the change at {} is after the end of the period", seconds(*last)));
        } else if changes.len() > 1 && changes[0].1 != *state && period - last < least {
            out.push(too_fast(*last, period, least));
        }
    }
    out
}

fn too_fast(from: Micros, to: Micros, least: Micros) -> String {
    format!(
        "its valves change at {} and again at {}, and need {} to: longer phases, or faster valves",
        seconds(from),
        seconds(to),
        seconds(least)
    )
}

fn pulses_at_fault(pulses: &[u16], range: [u16; 2], rest: u16, limits: &Limits) -> Vec<String> {
    let mut out = Vec::new();
    let [low, high] = range;
    let (least, most) = limits.pulses;
    if low > high || low < least || high > most {
        out.push(format!("its range is {low} to {high} us: the board makes pulses of {least} to {most} us"));
    }
    if pulses.is_empty() {
        out.push("its curve has no points".into());
    }
    if let Some(i) = pulses.iter().position(|pulse| !(low..=high).contains(pulse)) {
        out.push(format!("point {} of its curve is {} us, outside of {low} to {high} us", i + 1, pulses[i]));
    }
    if !(low..=high).contains(&rest) {
        out.push(format!("its rest is {rest} us, outside of {low} to {high} us"));
    }
    out
}
