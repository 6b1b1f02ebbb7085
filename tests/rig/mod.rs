//! A board that is emulated: the host library drives the real firmware on a simulated chip. In most of these tests
//! time passes only when the host waits for it, so that nothing depends on how busy this machine is; times are
//! those of the emulated chip, down to a sixteenth of a microsecond.

mod faults;
mod firmware;
mod lossy;
mod mutilated;
mod servos;
mod terminal;
mod trace;
mod valves;

use std::cell::Cell;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

use sgc::hardware::{Error, Link, Plan, Schedule, Session, Status, Wish};
use tempfile::TempDir;

use crate::support::root;
use trace::Trace;

/// Cycles of the chip in a microsecond.
pub(crate) const MHZ: u64 = 16;

/// What the tests run.
struct Built {
    board: PathBuf,
    firmware: PathBuf,
}

fn has(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
}

fn make(folder: &str, target: &str, build: &Path) -> bool {
    let output = Command::new("make")
        .args(["-s", "-C"])
        .arg(root().join(folder))
        .arg(format!("BUILD={}", build.display()))
        .arg(build.join(target))
        .output();
    let output = output.unwrap();
    if !output.status.success() {
        eprintln!("{}", String::from_utf8_lossy(&output.stderr));
    }
    output.status.success()
}

/// Builds the emulated board and the firmware. Without simavr, says that the test is skipped; without a compiler
/// for the chip takes the firmware as it comes with the project.
fn build() -> Option<Built> {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("rig");
    std::fs::create_dir_all(&folder).unwrap();
    // Every test is a process.
    let lock = File::create(folder.join("lock")).unwrap();
    lock.lock().unwrap();
    if !Path::new("/usr/include/simavr/sim_avr.h").exists() || !has("make") || !has("cc") {
        eprintln!("skipped: no simavr; apt-get install libsimavr-dev libelf-dev gcc-avr avr-libc");
        return None;
    }
    assert!(make("tests/rig", "board", &folder), "the emulated board does not build");
    let firmware = if has("avr-gcc") {
        assert!(make("firmware", "gait.hex", &folder), "the firmware does not build");
        folder.join("gait.hex")
    } else {
        root().join("firmware/gait.hex")
    };
    Some(Built { board: folder.join("board"), firmware })
}

/// An emulated board, as the other end of a line.
pub(crate) struct Rig {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    folder: TempDir,
    cycles: Cell<u64>,
}

impl Rig {
    /// A board whose time passes while its host waits; nothing if there is no emulator.
    pub(crate) fn new() -> Option<Self> {
        Self::start(&[])
    }

    /// A board in real time, and the name of its port.
    pub(crate) fn at_port(flag: &str) -> Option<(Self, String)> {
        let mut rig = Self::start(&[flag])?;
        let line = rig.line();
        let port = line.strip_prefix("pty ").unwrap().to_owned();
        Some((rig, port))
    }

    fn start(flags: &[&str]) -> Option<Self> {
        let built = build()?;
        let folder = tempfile::tempdir().unwrap();
        let mut child = Command::new(built.board)
            .arg(built.firmware)
            .arg(folder.path().join("trace"))
            .args(flags)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (input, output) = (child.stdin.take().unwrap(), BufReader::new(child.stdout.take().unwrap()));
        Some(Self { child, input, output, folder, cycles: Cell::new(0) })
    }

    /// Gives a command, and the answer.
    pub(crate) fn command(&mut self, line: &str) -> String {
        writeln!(self.input, "{line}").unwrap();
        self.line()
    }

    fn line(&mut self) -> String {
        let mut answer = String::new();
        self.output.read_line(&mut answer).unwrap();
        assert!(!answer.is_empty(), "the emulated board has ended");
        answer.trim_end().to_owned()
    }

    /// Lets time pass, and drops what the board says.
    pub(crate) fn pass(&mut self, time: Duration) {
        let until = self.now() + time;
        while self.now() < until {
            self.receive(until - self.now()).unwrap();
        }
    }

    /// The time now, in cycles.
    pub(crate) fn cycles(&mut self) -> u64 {
        let answer = self.command("status");
        self.cycles.set(answer.split(' ').next().unwrap().parse().unwrap());
        self.cycles.get()
    }

    /// The lowest that the stack pointer has been.
    pub(crate) fn lowest_stack(&mut self) -> u16 {
        self.command("status").split(' ').nth(1).unwrap().parse().unwrap()
    }

    /// What the outputs have done so far.
    pub(crate) fn trace(&mut self) -> Trace {
        self.command("status");
        Trace::read(&std::fs::read_to_string(self.folder.path().join("trace")).unwrap())
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Link for Rig {
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(self.command(&format!("send {digits}")), "ok");
        Ok(())
    }

    fn receive(&mut self, wait: Duration) -> Result<Vec<u8>, Error> {
        // Less than a cycle would be nothing, again and again.
        let wait = wait.max(Duration::from_micros(1));
        let answer = self.command(&format!("run {}", wait.as_secs_f64() * 1e6));
        let mut words = answer.split(' ').skip(1);
        self.cycles.set(words.next().unwrap().parse().unwrap());
        let digits = words.next().unwrap_or("");
        Ok((0..digits.len() / 2)
            .map(|i| u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).unwrap())
            .collect())
    }

    fn now(&self) -> Duration {
        Duration::from_nanos(self.cycles.get() * 125 / 2)
    }
}

/// A session with a new board; nothing if there is no emulator.
pub(crate) fn session() -> Option<Session<Rig>> {
    Some(Session::open_as(Rig::new()?, 0x1234_5678).unwrap())
}

/// A new board that runs a schedule, with usual times.
pub(crate) fn running(schedule: &Schedule) -> Option<Session<Rig>> {
    let mut session = session()?;
    session.load(schedule).unwrap();
    session.start(0, Plan::default().silence).unwrap();
    keep_running(&mut session, Duration::from_millis(1234));
    Some(session)
}

/// Lets a run go on for so long, with heartbeats.
pub(crate) fn keep_running(session: &mut Session<Rig>, time: Duration) {
    let until = session.link().now() + time;
    while session.link().now() < until {
        session.status().unwrap();
        let rest = until.saturating_sub(session.link().now());
        session.wait(rest.min(Duration::from_millis(100))).unwrap();
    }
}

/// Wishes to go on, but not for ever: for so many heartbeats.
pub(crate) fn at_most(mut beats: usize) -> impl FnMut(&Status) -> Wish {
    move |_| {
        assert!(beats > 0, "the run does not end");
        beats -= 1;
        Wish::GoOn
    }
}
