//! A schedule as text for a terminal, to be read before anything moves.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::schedule::{Channel, Micros, Output, Safe, Schedule, ValveState, seconds};

/// What the text is drawn with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marks {
    /// Blocks of Unicode.
    Blocks,
    /// Letters, for terminals that have nothing else.
    Ascii,
}

impl Marks {
    fn valve(self, state: ValveState) -> char {
        match (self, state) {
            (Self::Blocks, ValveState::Inflate) => '█',
            (Self::Blocks, ValveState::Vent) => '░',
            (Self::Blocks, ValveState::Closed) => '─',
            (Self::Ascii, ValveState::Inflate) => '#',
            (Self::Ascii, ValveState::Vent) => 'o',
            (Self::Ascii, ValveState::Closed) => '-',
        }
    }

    /// A level between 0 and 1.
    fn level(self, share: f64) -> char {
        let marks: &[char] = match self {
            Self::Blocks => &['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'],
            Self::Ascii => &['0', '1', '2', '3', '4', '5', '6', '7', '8', '9'],
        };
        let last = marks.len() - 1;
        marks[((share * last as f64).round().max(0.0) as usize).min(last)]
    }
}

/// The word for a state of valves.
pub(crate) fn word(state: ValveState) -> &'static str {
    match state {
        ValveState::Closed => "closed",
        ValveState::Inflate => "inflate",
        ValveState::Vent => "vent",
    }
}

/// What a safe state means.
pub(crate) fn safe_words(safe: Safe) -> &'static str {
    match safe {
        Safe::Hold => "hold: all valves closed, pressure is kept",
        Safe::Vent => "vent: all actuators vented",
        Safe::Release => "release: no pulses, servos give way",
        Safe::Rest => "rest: servos go to their rest, and hold it",
    }
}

/// The state of an actuator's valves at a time.
pub(crate) fn state_at(changes: &[(Micros, ValveState)], time: Micros) -> ValveState {
    changes.iter().take_while(|(at, _)| *at <= time).last().map_or(ValveState::Closed, |(_, state)| *state)
}

/// The pulse of a servo at a time, in microseconds: on the straight line between two points of its curve.
#[must_use]
pub fn pulse_at(pulses: &[u16], period: Micros, time: f64) -> f64 {
    let many = pulses.len();
    if many == 0 || period == 0 {
        return 0.0;
    }
    let at = (time / f64::from(period)).rem_euclid(1.0) * many as f64;
    let (row, part) = ((at as usize).min(many - 1), at.fract());
    let (from, to) = (f64::from(pulses[row]), f64::from(pulses[(row + 1) % many]));
    from + (to - from) * part
}

/// A pulse as an angle.
pub(crate) fn angle(pulse: f64, range: [u16; 2], degrees: [f64; 2]) -> f64 {
    let span = f64::from(range[1]) - f64::from(range[0]);
    let share = if span == 0.0 { 0.0 } else { (pulse - f64::from(range[0])) / span };
    degrees[0] + (degrees[1] - degrees[0]) * share
}

/// A schedule as text: a bar for each channel, and what it consists of. `width` is that of the terminal, in columns.
#[must_use]
pub fn text(schedule: &Schedule, width: usize, marks: Marks) -> String {
    let mut out = String::new();
    let kind = if schedule.has_valves() { "valves" } else { "servos" };
    let many = schedule.channels.len();
    let _ = writeln!(out, "{many} channels of {kind}, period {}", seconds(schedule.period));
    let _ = writeln!(out, "when it stops: {}\n", safe_words(schedule.safe));
    let heads: Vec<String> = schedule.channels.iter().map(head).collect();
    let left = heads.iter().map(|head| head.chars().count()).max().unwrap_or(0) + 2;
    let bar = width.saturating_sub(left + 1).clamp(20, 160);
    let end = seconds(schedule.period);
    let _ = writeln!(out, "{:left$}0 s{end:>pad$}", "", pad = bar - 3);
    for (channel, head) in schedule.channels.iter().zip(&heads) {
        let columns = (0..bar).map(|i| (i as f64 + 0.5) / bar as f64);
        let drawn: String = match &channel.output {
            Output::Valves { changes, .. } => columns
                .map(|share| state_at(changes, (share * f64::from(schedule.period)) as Micros))
                .map(|state| marks.valve(state))
                .collect(),
            Output::Servo { pulses, range, .. } => columns
                .map(|share| pulse_at(pulses, schedule.period, share * f64::from(schedule.period)))
                .map(|pulse| marks.level(angle(pulse, *range, [0.0, 1.0])))
                .collect(),
        };
        let _ = writeln!(out, "{head:left$}{drawn}");
    }
    out.push('\n');
    if schedule.has_valves() {
        let states = [ValveState::Inflate, ValveState::Closed, ValveState::Vent];
        let legend = states.map(|state| format!("{} {}", marks.valve(state), word(state)));
        let _ = writeln!(out, "{:left$}{}\n", "", legend.join("   "));
        valve_table(schedule, &mut out);
    } else {
        servo_table(schedule, &mut out);
    }
    out
}

/// The name of a channel and its pins.
fn head(channel: &Channel) -> String {
    match &channel.output {
        Output::Valves { inflate, vent, .. } => format!("{} (in {inflate}, out {vent})", channel.name),
        Output::Servo { pin, .. } => format!("{} ({pin})", channel.name),
    }
}

/// A row for each time at which anything changes; what stays is a dot.
fn valve_table(schedule: &Schedule, out: &mut String) {
    let all = schedule.channels.iter().filter_map(|channel| match &channel.output {
        Output::Valves { changes, .. } => Some((channel, changes)),
        Output::Servo { .. } => None,
    });
    let all: Vec<_> = all.collect();
    let times: BTreeSet<Micros> =
        all.iter().flat_map(|(_, changes)| changes.iter().map(|(at, _)| *at)).collect();
    let wide = |channel: &Channel| channel.name.chars().count().max(7);
    let _ = write!(out, "{:>12}", "time");
    for (channel, _) in &all {
        let _ = write!(out, "  {:width$}", channel.name, width = wide(channel));
    }
    out.push('\n');
    for time in times {
        let _ = write!(out, "{:>12}", seconds(time));
        for (channel, changes) in &all {
            let change = changes.iter().find(|(at, _)| *at == time);
            let text = change.map_or(".", |(_, state)| word(*state));
            let _ = write!(out, "  {text:width$}", width = wide(channel));
        }
        out.truncate(out.trim_end().len());
        out.push('\n');
    }
}

fn servo_table(schedule: &Schedule, out: &mut String) {
    let name = schedule.channels.iter().map(|channel| channel.name.chars().count()).max().unwrap_or(0).max(8);
    let _ =
        writeln!(out, "{:name$}  {:>8}  {:>20}  {:>20}  {:>14}", "", "points", "least", "most", "allowed");
    for channel in &schedule.channels {
        let Output::Servo { pulses, range, degrees, .. } = &channel.output else { continue };
        let told = |pulse: Option<&u16>| {
            let pulse = pulse.copied().unwrap_or_default();
            format!("{:.1} deg ({pulse} us)", angle(f64::from(pulse), *range, *degrees))
        };
        let (least, most) = (told(pulses.iter().min()), told(pulses.iter().max()));
        let range = format!("{} to {} us", range[0], range[1]);
        let _ = writeln!(
            out,
            "{:name$}  {:>8}  {least:>20}  {most:>20}  {range:>14}",
            channel.name,
            pulses.len()
        );
    }
}

#[cfg(test)]
mod tests {
    use super::super::schedule::tests::{servos, valves};
    use super::*;

    #[test]
    fn valves_are_bars_and_a_table() {
        let drawn = text(&valves(&["front", "hind leg"]), 60, Marks::Ascii);
        insta::assert_snapshot!(drawn);
    }

    #[test]
    fn servos_are_curves_and_a_table() {
        insta::assert_snapshot!(text(&servos(&["wrist", "elbow"]), 90, Marks::Blocks));
    }

    #[test]
    fn curves_are_straight_between_points_and_closed() {
        let pulses = [1000, 2000];
        assert_eq!(pulse_at(&pulses, 100, 25.0), 1500.0);
        assert_eq!(pulse_at(&pulses, 100, 75.0), 1500.0);
        assert_eq!(pulse_at(&pulses, 100, 150.0), 2000.0);
        assert_eq!(pulse_at(&pulses, 100, -25.0), 1500.0);
        assert_eq!(pulse_at(&[], 100, 3.0), 0.0);
    }
}
