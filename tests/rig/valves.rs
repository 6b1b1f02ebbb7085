//! Valves open and close when they should.

use std::time::Duration;

use sgc::hardware::{Channel, Outcome, Output, Pin, Plan, Safe, Schedule, ValveState, Wish, run};

use super::trace::us;
use super::{MHZ, at_most, session};
use crate::support::is_long;

/// Eight actuators with phases of their own, of an odd period: nothing in it is a multiple of the board's tick.
pub(crate) fn eight(safe: Safe) -> Schedule {
    use ValveState::{Closed, Inflate, Vent};
    let pins: Vec<Pin> = Pin::all().collect();
    let channel = |i: usize| {
        let at = 13_007 * i as u32;
        let changes = match i % 4 {
            0 => vec![(0, Inflate), (200_003 + at, Closed), (400_001 + at, Vent), (800_009 + at, Closed)],
            1 => vec![(0, Vent), (250_033 + at, Inflate), (600_007 + at, Vent)],
            2 => vec![(0, Closed), (70_001 + at, Inflate), (100_013 + at, Vent), (900_001, Closed)],
            _ => vec![(0, Vent), (500_001, Inflate)],
        };
        let (inflate, vent) = (pins[2 * i], pins[2 * i + 1]);
        Channel {
            name: format!("actuator {i}"),
            output: Output::Valves { inflate, vent, least: 10_000, changes },
        }
    };
    Schedule { period: 1_000_003, safe, channels: (0..8).map(channel).collect() }
}

/// The edges that a pin of a channel should have in a run: when, in microseconds since its beginning, and to which level.
pub(crate) fn edges(output: &Output, pin: Pin, period: u32, cycles: u32) -> Vec<(u64, bool)> {
    let Output::Valves { inflate, vent, changes, .. } = output else { panic!("no valves") };
    let level = |state: ValveState| match state {
        ValveState::Inflate => pin == *inflate,
        ValveState::Vent => pin == *vent,
        ValveState::Closed => false,
    };
    let cycle = |n: u32| {
        let begin = u64::from(n) * u64::from(period);
        changes.iter().map(move |(at, state)| (begin + u64::from(*at), level(*state)))
    };
    // Before the first cycle all are closed, and after the last.
    let end = u64::from(cycles) * u64::from(period);
    let mut now = false;
    let all = (0..cycles).flat_map(cycle).chain([(end, false)]);
    all.filter(|(_, level)| std::mem::replace(&mut now, *level) != *level).collect()
}

#[test]
fn valves_keep_their_times() {
    let Some(mut session) = session() else { return };
    let schedule = eight(Safe::Hold);
    session.load(&schedule).unwrap();
    let cycles = if is_long() { 600 } else { 30 };
    let plan = Plan { cycles, ..Plan::default() };
    assert_eq!(
        run(&mut session, &plan, &mut at_most(12 * cycles as usize)).unwrap(),
        Outcome::Completed { cycles }
    );
    session.link().pass(Duration::from_millis(700));
    let trace = session.link().trace();
    // A cycle begins as the first valve opens.
    let pin = schedule.channels[0].output.pins()[0];
    let begin = trace.of(pin)[0].0;
    let (mut least, mut most, mut seen) = (f64::INFINITY, f64::NEG_INFINITY, 0);
    for channel in &schedule.channels {
        let [inflate, vent] = channel.output.pins()[..] else { panic!("not two pins") };
        assert!(!trace.overlap(inflate, vent), "both valves of {} were open", channel.name);
        for pin in [inflate, vent] {
            let found = trace.of(pin);
            let expected = edges(&channel.output, pin, schedule.period, cycles);
            assert_eq!(found.len(), expected.len(), "{pin}: as many changes");
            for ((at, level), (due, wanted)) in found.iter().zip(expected) {
                assert_eq!(*level, wanted, "{pin} at {due} us");
                let late = us(*at) - us(begin) - due as f64;
                least = least.min(late);
                most = most.max(late);
                seen += 1;
            }
        }
    }
    println!("{seen} edges in {cycles} s: {least:.1} to {most:.1} us late");
    assert!(least > -300.0 && most < 300.0, "edges are {least:.1} to {most:.1} us late");
    assert!(trace.high().is_empty(), "at the end all are closed");
}

#[test]
fn a_run_that_is_stopped_ends_in_its_safe_state() {
    for (safe, open) in [(Safe::Hold, 0), (Safe::Vent, 8)] {
        let Some(mut session) = session() else { return };
        session.load(&eight(safe)).unwrap();
        let mut beats = 0;
        let outcome = run(&mut session, &Plan::default(), &mut |_| {
            beats += 1;
            if beats < 15 { Wish::GoOn } else { Wish::Stop }
        });
        assert_eq!(outcome.unwrap(), Outcome::Stopped { cycles: 1 });
        let changes = session.link().trace().changes();
        session.link().pass(Duration::from_secs(2));
        let trace = session.link().trace();
        assert_eq!(trace.changes(), changes, "something moved after the stop");
        assert_eq!(trace.high().len(), open);
        let vents: Vec<Pin> = eight(safe).channels.iter().map(|channel| channel.output.pins()[1]).collect();
        assert!(trace.high().iter().all(|pin| vents.contains(pin)));
    }
}

#[test]
fn nothing_moves_before_the_start() {
    let Some(mut session) = session() else { return };
    session.load(&eight(Safe::Vent)).unwrap();
    session.link().pass(Duration::from_secs(2));
    assert_eq!(session.link().trace().changes(), 0);
    // Nor does the emulated clock stand still.
    assert!(session.link().cycles() > 2_000_000 * MHZ);
}
