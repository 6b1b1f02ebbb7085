//! A real serial port, or nearly: a pseudo terminal, and a board that runs in real time.

use std::process::{Command, Stdio};
use std::time::Duration;

use sgc::hardware::{Error, Outcome, Plan, Safe, Serial, Session, Wish, drive};

use super::trace::us;
use super::{MHZ, Rig, at_most, valves};

#[test]
fn a_gait_is_driven_through_a_port() {
    let Some((mut rig, port)) = Rig::at_port("--uno") else { return };
    let schedule = valves::eight(Safe::Hold);
    let plan = Plan { cycles: 2, ..Plan::default() };
    let mut beats = 0;
    let outcome = drive(Serial::open(&port).unwrap(), &schedule, &plan, &mut |status| {
        assert!(status.cycle <= 2);
        beats += 1;
        Wish::GoOn
    });
    assert_eq!(outcome.unwrap(), Outcome::Completed { cycles: 2 });
    assert!(beats > 10);
    let trace = rig.trace();
    assert_eq!(trace.resets.len(), 1, "an Uno resets when its port is opened");
    let first = trace.spans(schedule.channels[0].output.pins()[0]);
    assert_eq!(first.len(), 2);
    assert!((us(first[1].from - first[0].from) - f64::from(schedule.period)).abs() < 150.0);
    assert!(trace.high().is_empty());
}

#[test]
fn a_port_is_opened_by_one_program_only() {
    let Some((_rig, port)) = Rig::at_port("--pty") else { return };
    let _mine = Serial::open(&port).unwrap();
    let error = Serial::open(&port).unwrap_err();
    assert!(matches!(error, Error::PortBusy { .. }), "{error}");
}

#[test]
fn a_board_that_is_gone_is_told() {
    let Some((mut rig, port)) = Rig::at_port("--pty") else { return };
    let mut beats = 0;
    let error =
        drive(Serial::open(&port).unwrap(), &valves::eight(Safe::Hold), &Plan::default(), &mut |_| {
            beats += 1;
            if beats == 5 {
                rig.child.kill().unwrap();
                rig.child.wait().unwrap();
            }
            Wish::GoOn
        });
    let error = error.unwrap_err();
    assert!(matches!(error, Error::Line { .. }), "{error}");
}

#[test]
fn a_port_without_a_board_is_told() {
    let Some((mut rig, port)) = Rig::at_port("--pty") else { return };
    rig.command("cable 0");
    let error = Session::open(Serial::open(&port).unwrap()).unwrap_err();
    assert!(matches!(error, Error::Silent { .. }), "{error}");
}

/// The host that the next test kills: no test of its own.
#[test]
#[ignore = "is run by another test"]
fn drive_until_killed() {
    let Ok(port) = std::env::var("SGC_TEST_PORT") else { return };
    drive(Serial::open(&port).unwrap(), &valves::eight(Safe::Hold), &Plan::default(), &mut at_most(100000))
        .unwrap();
}

#[test]
fn the_board_of_a_killed_host_comes_to_its_safe_state() {
    let Some((mut rig, port)) = Rig::at_port("--pty") else { return };
    let mut host = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "rig::terminal::drive_until_killed", "--ignored"])
        .env("SGC_TEST_PORT", &port)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while rig.trace().changes() < 60 {
        assert!(host.try_wait().unwrap().is_none(), "the host has ended");
        std::thread::sleep(Duration::from_millis(50));
    }
    host.kill().unwrap();
    host.wait().unwrap();
    let killed = rig.cycles();
    // Emulated time, however long it takes.
    while rig.cycles() < killed + 2_000_000 * MHZ {
        std::thread::sleep(Duration::from_millis(50));
    }
    let trace = rig.trace();
    assert!(trace.high().is_empty());
    let last = trace.last_rise().max(trace.last_fall());
    let late = us(last.saturating_sub(killed));
    println!("the last change was {late:.0} us after the host was killed");
    assert!(late < 600_000.0);
}
