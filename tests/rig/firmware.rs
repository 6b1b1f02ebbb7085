//! The firmware itself: its size, its memory, and that the file in the project is made of its sources.

use std::process::Command;
use std::time::Duration;

use sgc::hardware::{Limits, Pin, Plan, Safe};

use super::{Rig, keep_running, running, servos, valves};
use crate::support::{read, root};

/// Where the memory of an ATmega328P ends.
const RAM_END: u16 = 0x8FF;
/// What a boot loader leaves of its flash memory, in bytes.
const FLASH: usize = 30 * 1024;

#[test]
fn the_stack_stays_within_its_memory() {
    let Some(mut session) = running(&servos::eight(Safe::Rest)) else { return };
    // All that the firmware can do, one after the other, so that the deepest call is among them.
    for schedule in [valves::eight(Safe::Vent), servos::eight(Safe::Rest)] {
        session.stop().unwrap();
        session.load(&schedule).unwrap();
        session.start(2, Plan::default().silence).unwrap();
        keep_running(&mut session, Duration::from_secs(5));
        session.start(0, Plan::default().silence).unwrap();
        keep_running(&mut session, Duration::from_secs(2));
        session.emergency_stop().unwrap();
        session.clear().unwrap();
        session.load(&schedule).unwrap();
        session.start(0, Plan::default().silence).unwrap();
        keep_running(&mut session, Duration::from_secs(1));
        session.link().command("stop 1");
        keep_running(&mut session, Duration::from_millis(100));
        session.link().command("stop 0");
        session.clear().unwrap();
    }
    let status = session.status().unwrap();
    let seen = RAM_END - session.link().lowest_stack();
    println!(
        "the stack has held {} bytes (its pointer says {seen}), {} were never used",
        status.stack_used, status.stack_free
    );
    // Twice as much as was ever used is there.
    assert!(status.stack_free > status.stack_used, "{status:?}");
    assert!(
        seen.abs_diff(status.stack_used) <= 2,
        "the paint says {}, the pointer {seen}",
        status.stack_used
    );
}

/// The bytes of flash memory that an Intel HEX file fills.
fn flash(hex: &str) -> usize {
    let lengths = hex.lines().filter(|line| line.get(7..9) == Some("00")).map(|line| line.get(1..3).unwrap());
    lengths.map(|digits| usize::from_str_radix(digits, 16).unwrap()).sum()
}

#[test]
fn the_firmware_fits_beside_a_boot_loader() {
    let size = flash(&read("firmware/gait.hex"));
    println!("{size} bytes of flash memory");
    assert!(size > 4000 && size < FLASH, "{size} bytes");
}

#[test]
fn the_firmware_in_the_project_is_that_of_its_sources() {
    // Another compiler makes other code of the same sources.
    let version = Command::new("avr-gcc").arg("-dumpversion").output();
    let version = version.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    if version.as_deref().ok() != Some("5.4.0") {
        eprintln!("skipped: it was made with avr-gcc 5.4.0, here is {version:?}");
        return;
    }
    let build = tempfile::tempdir().unwrap();
    let made = Command::new("make")
        .args(["-s", "-C"])
        .arg(root().join("firmware"))
        .arg(format!("BUILD={}", build.path().display()))
        .arg("check")
        .output()
        .unwrap();
    let says = String::from_utf8_lossy(&made.stderr);
    assert!(made.status.success(), "firmware/gait.hex is not of its sources: `make -C firmware hex`\n{says}");
}

#[test]
fn the_limits_are_those_that_the_firmware_tells() {
    let Some(session) = super::session() else { return };
    assert_eq!(session.welcome().limits, Limits::default());
    assert!(session.welcome().valves && session.welcome().servos);
}

#[test]
fn outputs_are_low_from_the_reset_on() {
    let Some(mut rig) = Rig::new() else { return };
    rig.pass(Duration::from_secs(1));
    assert_eq!(rig.trace().changes(), 0);
    assert_eq!(Pin::all().filter(|pin| rig.trace().is_high(*pin)).count(), 0);
}
