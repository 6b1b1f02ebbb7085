//! Whatever goes wrong, the board comes to its safe state, and starts nothing by itself.

use std::time::Duration;

use sgc::hardware::frame::Frame;
use sgc::hardware::message::Request;
use sgc::hardware::{Error, Link, Pin, Plan, Safe, Schedule, Session, State, run};

use super::trace::{Trace, us};
use super::{MHZ, Rig, at_most, keep_running, running, servos, session, valves};

/// How long after the last sign of life all must be safe, in microseconds.
const SILENCE: f64 = 600_000.0;

fn pins(schedule: &Schedule, which: usize) -> Vec<Pin> {
    schedule.channels.iter().map(|channel| channel.output.pins()[which]).collect()
}

/// Lets two seconds pass and sees that nothing has moved since a time, given in cycles.
fn assert_still(session: &mut Session<Rig>, since: u64, what: &str) -> Trace {
    session.link().pass(Duration::from_secs(2));
    let trace = session.link().trace();
    let last = trace.last_rise().max(trace.last_fall());
    assert!(last <= since, "{what}: something moved {:.0} us later", us(last - since));
    trace
}

#[test]
fn silence_leads_to_the_safe_state() {
    for safe in [Safe::Hold, Safe::Vent] {
        let schedule = valves::eight(safe);
        let Some(mut session) = running(&schedule) else { return };
        session.link().command("cable 0");
        let pulled = session.link().cycles();
        session.link().pass(Duration::from_millis(600));
        let until = session.link().cycles();
        let trace = assert_still(&mut session, until, "silence");
        assert!(pins(&schedule, 0).iter().all(|pin| !trace.is_high(*pin)), "air still flows in");
        let open = if safe == Safe::Vent { pins(&schedule, 1) } else { Vec::new() };
        assert_eq!(trace.high(), open);
        let last = us(trace.last_rise().max(trace.last_fall()) - pulled);
        println!("{safe:?}: safe {last:.0} us after the cable was pulled");
        assert!(last < SILENCE);
        // The cable alone starts nothing; the host hears what has been.
        session.link().command("cable 1");
        let status = session.status().unwrap();
        assert_eq!(status.state, State::Fault);
        assert!(status.faults.link());
        let refused = session.start(0, Plan::default().silence).unwrap_err();
        assert!(matches!(refused, Error::Latched { state: State::Fault, .. }), "{refused}");
        assert!(matches!(session.load(&schedule), Err(Error::Latched { .. })));
        session.clear().unwrap();
        session.load(&schedule).unwrap();
        let loaded = session.link().cycles();
        assert!(assert_still(&mut session, loaded, "after clearing").high().is_empty());
    }
}

#[test]
fn silence_ends_pulses_or_brings_them_to_rest() {
    for safe in [Safe::Release, Safe::Rest] {
        let schedule = servos::eight(safe);
        let Some(mut session) = running(&schedule) else { return };
        session.link().command("cable 0");
        let pulled = session.link().cycles();
        session.link().pass(Duration::from_secs(2));
        let trace = session.link().trace();
        for pin in pins(&schedule, 0) {
            let late =
                trace.spans(pin).into_iter().filter(|span| us(span.from.saturating_sub(pulled)) > SILENCE);
            let lengths: Vec<f64> = late.filter_map(|span| span.to.map(|to| us(to - span.from))).collect();
            assert_eq!(lengths.is_empty(), safe == Safe::Release, "{pin}: {safe:?}");
            assert!(lengths.iter().all(|length| (length - 1400.0).abs() < 5.0), "{lengths:?}");
        }
    }
}

#[test]
fn a_run_tells_its_host_that_the_link_was_lost() {
    let Some(mut session) = session() else { return };
    session.load(&valves::eight(Safe::Hold)).unwrap();
    // A host that is slower than the board is told to wait.
    let plan = Plan {
        silence: Duration::from_millis(200),
        heartbeat: Duration::from_millis(400),
        ..Plan::default()
    };
    let error = run(&mut session, &plan, &mut at_most(100)).unwrap_err();
    assert!(matches!(error, Error::LinkLost), "{error}");
    assert!(matches!(session.start(0, Duration::from_secs(9)), Err(Error::Timeout { .. })));
}

/// Sees that nothing can be started before the stop is cleared, and that it can after.
fn assert_latched(session: &mut Session<Rig>, schedule: &Schedule) {
    for _ in 0..2 {
        let refused = session.start(0, Plan::default().silence).unwrap_err();
        assert!(matches!(refused, Error::Latched { state: State::Estopped, .. }), "{refused}");
        assert!(matches!(session.load(schedule), Err(Error::Latched { .. })));
    }
    session.clear().unwrap();
    assert_eq!(session.status().unwrap().state, State::Idle);
    session.load(schedule).unwrap();
    session.start(0, Plan::default().silence).unwrap();
    let before = session.link().trace().changes();
    keep_running(session, Duration::from_secs(1));
    assert!(session.link().trace().changes() > before, "it does not start again");
}

#[test]
fn an_emergency_stop_by_message_is_at_once_and_stays() {
    let schedule = valves::eight(Safe::Hold);
    let Some(mut session) = running(&schedule) else { return };
    // From a host that has no session.
    let frame = Frame { kind: Request::Estop.kind(), session: 99, sequence: 0, payload: Vec::new() };
    session.link().send(&frame.encode()).unwrap();
    let sent = session.link().cycles();
    let trace = assert_still(&mut session, sent + 3000 * MHZ, "after the stop");
    assert!(trace.high().is_empty());
    println!("all closed {:.0} us after the message began", us(trace.last_fall() - sent));
    assert!(session.status().unwrap().faults.stop_message());
    assert_latched(&mut session, &schedule);
    session.emergency_stop().unwrap();
    assert_eq!(session.status().unwrap().state, State::Estopped);
}

#[test]
fn the_stop_circuit_stops_and_stays() {
    let schedule = valves::eight(Safe::Hold);
    let Some(mut session) = running(&schedule) else { return };
    // What is shorter than any button is no button.
    session.link().command("stop 1");
    session.link().pass(Duration::from_micros(300));
    session.link().command("stop 0");
    assert_eq!(session.status().unwrap().state, State::Running);
    session.link().command("stop 1");
    let pressed = session.link().cycles();
    let trace = assert_still(&mut session, pressed + 2000 * MHZ, "after the button");
    println!("all closed {:.0} us after the button", us(trace.last_fall() - pressed));
    assert!(trace.high().is_empty());
    assert!(session.status().unwrap().faults.stop_circuit());
    assert!(matches!(session.clear(), Err(Error::StopCircuit)));
    session.link().command("stop 0");
    assert_still(&mut session, pressed + 2000 * MHZ, "after the button was released");
    assert_latched(&mut session, &schedule);
}

#[test]
fn a_run_tells_its_host_that_the_button_was_pressed() {
    let Some(mut session) = session() else { return };
    session.load(&servos::eight(Safe::Release)).unwrap();
    session.link().command("stop 1");
    session.link().pass(Duration::from_millis(20));
    let error = run(&mut session, &Plan::default(), &mut at_most(100)).unwrap_err();
    assert!(matches!(error, Error::Latched { state: State::Estopped, .. }), "{error}");
    assert_eq!(session.link().trace().changes(), 0);
}

#[test]
fn a_reset_forgets_all_and_starts_nothing() {
    for schedule in [valves::eight(Safe::Vent), servos::eight(Safe::Rest)] {
        let Some(mut session) = running(&schedule) else { return };
        session.link().command("reset");
        let reset = session.link().cycles();
        let trace = assert_still(&mut session, reset, "after the reset");
        assert!(trace.high().is_empty(), "an output is high after the reset");
        let error = session.status().unwrap_err();
        assert!(matches!(error, Error::Reset), "{error}");
        assert!(matches!(session.start(0, Plan::default().silence), Err(Error::Reset)));
    }
}

/// Says something again and again, and minds no answers.
fn keep_heard(session: &mut Session<Rig>, time: Duration) {
    let until = session.link().now() + time;
    while session.link().now() < until {
        session.link().send(&[0]).unwrap();
        session.link().pass(Duration::from_millis(10));
    }
}

#[test]
fn a_program_that_hangs_is_reset_and_starts_nothing() {
    for how in ["hang", "freeze", "stop-clock"] {
        for schedule in [valves::eight(Safe::Hold), servos::eight(Safe::Release)] {
            let Some(mut session) = running(&schedule) else { return };
            session.link().command(how);
            let hung = session.link().cycles();
            // A board that does not hang, and hears nothing, would not be reset.
            keep_heard(&mut session, Duration::from_millis(350));
            let until = session.link().cycles();
            let trace = assert_still(&mut session, until, how);
            let [reset] = trace.resets[..] else { panic!("{how}: {} resets", trace.resets.len()) };
            println!("{how}: reset after {:.0} us", us(reset - hung));
            assert!(us(reset - hung) < 300_000.0);
            assert!(trace.high().is_empty(), "{how}: an output is high after the reset");
            // A new session sees what has happened.
            let frame =
                Frame { kind: 1, session: 5, sequence: 0, payload: Request::Hello { nonce: 7 }.payload() };
            session.link().send(&frame.encode()).unwrap();
            let answer = super::mutilated::answers(session.link(), Duration::from_millis(50));
            let [sgc::hardware::message::Reply::Welcome(welcome)] = &answer[..] else { panic!("{answer:?}") };
            assert_eq!(welcome.state, State::Fault);
            assert!(welcome.faults.watchdog() && welcome.reset_cause & 8 != 0, "{welcome:?}");
        }
    }
}

#[test]
fn a_second_host_is_refused_while_the_first_is_alive() {
    let schedule = valves::eight(Safe::Hold);
    let Some(mut session) = running(&schedule) else { return };
    let hello = |session: u32| {
        let payload = Request::Hello { nonce: 7 }.payload();
        Frame { kind: 1, session, sequence: 0, payload }.encode()
    };
    let ask = |rig: &mut Rig, line: &[u8]| {
        rig.send(line).unwrap();
        format!("{:?}", super::mutilated::answers(rig, Duration::from_millis(50)))
    };
    for _ in 0..5 {
        let answer = ask(session.link(), &hello(77));
        assert!(answer.contains("Busy"), "{answer}");
        // Nor may it do anything else.
        let stop = Frame { kind: Request::Stop.kind(), session: 77, sequence: 1, payload: Vec::new() };
        let answer = ask(session.link(), &stop.encode());
        assert!(answer.contains("NoSession"), "{answer}");
        assert_eq!(session.status().unwrap().state, State::Running);
    }
    session.stop().unwrap();
    session.link().pass(Duration::from_millis(600));
    let answer = ask(session.link(), &hello(77));
    assert!(answer.contains("Welcome"), "{answer}");
    assert!(matches!(session.status(), Err(Error::Reset)));
}

#[test]
fn a_session_that_is_dropped_stops_the_board() {
    let Some(rig) = Rig::new() else { return };
    /// A line that outlives its session.
    struct Lent<'a>(&'a mut Rig);
    impl Link for Lent<'_> {
        fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
            self.0.send(bytes)
        }
        fn receive(&mut self, wait: Duration) -> Result<Vec<u8>, Error> {
            self.0.receive(wait)
        }
        fn now(&self) -> Duration {
            self.0.now()
        }
    }
    let mut rig = rig;
    let mut session = Session::open(Lent(&mut rig)).unwrap();
    session.load(&valves::eight(Safe::Hold)).unwrap();
    session.start(0, Plan::default().silence).unwrap();
    session.wait(Duration::from_millis(100)).unwrap();
    drop(session);
    let now = rig.cycles();
    rig.pass(Duration::from_secs(1));
    let trace = rig.trace();
    assert!(trace.high().is_empty());
    assert!(trace.last_fall() <= now, "it ran on for {:.0} us", us(trace.last_fall().saturating_sub(now)));
}
