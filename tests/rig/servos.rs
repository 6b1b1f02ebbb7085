//! Servos get the pulses that they should.

use std::time::Duration;

use sgc::hardware::dry_run::pulse_at;
use sgc::hardware::{Channel, Output, Pin, Plan, Safe, Schedule, Wish, run};

use super::trace::us;
use super::{keep_running, running, session};
use crate::support::is_long;

/// Eight servos with curves of 64 points: waves, and steps as hard as there are.
pub(crate) fn eight(safe: Safe) -> Schedule {
    let wave = |i: usize, k: usize| {
        let turn = (k as f64 / 64.0 + i as f64 / 8.0) * std::f64::consts::TAU;
        (1500.0 + 850.0 * libm::sin(turn)).round() as u16
    };
    let steps = |i: usize, k: usize| if (k * (i + 1) / 5).is_multiple_of(2) { 600 } else { 2400 };
    let channel = |(i, pin): (usize, Pin)| Channel {
        name: format!("servo {i}"),
        output: Output::Servo {
            pin,
            pulses: (0..64).map(|k| if i < 5 { wave(i, k) } else { steps(i, k) }).collect(),
            range: [600, 2400],
            rest: 1400,
            degrees: [-90.0, 90.0],
        },
    };
    // Every other pin, so that all three ports are used.
    let channels = Pin::all().step_by(2).enumerate().map(channel).collect();
    Schedule { period: 1_700_003, safe, channels }
}

#[test]
fn pulses_are_as_long_as_the_curve_says() {
    let Some(mut session) = session() else { return };
    let schedule = eight(Safe::Release);
    session.load(&schedule).unwrap();
    let seconds = if is_long() { 600 } else { 30 };
    let mut beats = 0;
    run(&mut session, &Plan::default(), &mut |_| {
        beats += 1;
        if beats < seconds * 10 { Wish::GoOn } else { Wish::Stop }
    })
    .unwrap();
    let trace = session.link().trace();
    let spans = |channel: &Channel| trace.spans(channel.output.pins()[0]);
    let begin = schedule.channels.iter().map(|channel| spans(channel)[0].from).min().unwrap();
    let (mut worst, mut seen) = (0.0_f64, 0);
    let (mut shortest, mut longest) = (f64::INFINITY, 0.0_f64);
    for channel in &schedule.channels {
        let Output::Servo { pulses, .. } = &channel.output else { panic!("no servo") };
        let spans = spans(channel);
        for span in &spans {
            let time = us(span.from - begin);
            let length = us(span.to.unwrap() - span.from);
            let error = (length - pulse_at(pulses, schedule.period, time)).abs();
            assert!(
                error < 5.0,
                "{} at {time:.1} us: a pulse of {length:.2} us is {error:.2} us off",
                channel.name
            );
            worst = worst.max(error);
            seen += 1;
        }
        for pair in spans.windows(2) {
            let frame = us(pair[1].from - pair[0].from);
            shortest = shortest.min(frame);
            longest = longest.max(frame);
        }
    }
    println!(
        "{seen} pulses in {:.0} s: at most {worst:.2} us off; frames of {shortest:.2} to {longest:.2} us",
        us(trace.last_fall() - begin) / 1e6
    );
    assert!(seen > seconds * 8 * 49, "only {seen} pulses");
    assert!(shortest > 19_995.0 && longest < 20_005.0);
}

#[test]
fn stopped_servos_are_released_or_rest() {
    for safe in [Safe::Release, Safe::Rest] {
        let Some(mut session) = running(&eight(safe)) else { return };
        session.stop().unwrap();
        let stopped = session.link().cycles();
        session.link().pass(Duration::from_secs(1));
        let trace = session.link().trace();
        for channel in eight(safe).channels {
            let after = trace.spans(channel.output.pins()[0]);
            let after: Vec<_> = after.into_iter().filter(|span| span.from > stopped).collect();
            if safe == Safe::Release {
                assert!(after.is_empty(), "{} still gets pulses", channel.name);
            } else {
                assert!(after.len() >= 48, "{} gets {} pulses of rest", channel.name, after.len());
                let lengths = after.iter().filter_map(|span| span.to.map(|to| us(to - span.from)));
                lengths.for_each(|length| assert!((length - 1400.0).abs() < 5.0, "{length}"));
            }
        }
    }
}

#[test]
fn a_run_can_be_followed_by_another() {
    let Some(mut session) = running(&eight(Safe::Release)) else { return };
    session.stop().unwrap();
    session.load(&super::valves::eight(Safe::Hold)).unwrap();
    session.start(0, Plan::default().silence).unwrap();
    let begun = session.link().cycles();
    keep_running(&mut session, Duration::from_secs(3));
    session.stop().unwrap();
    session.load(&eight(Safe::Release)).unwrap();
    session.start(1, Plan::default().silence).unwrap();
    keep_running(&mut session, Duration::from_secs(3));
    let trace = session.link().trace();
    assert!(trace.of(Pin::all().next().unwrap()).iter().filter(|(at, _)| *at > begun).count() > 80);
    assert_eq!(trace.high(), Vec::new());
    assert_eq!(session.status().unwrap().cycle, 1);
}
