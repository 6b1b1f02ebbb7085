//! Supervises a run: keeps the board alive, hears how it stands, and stops it, whatever happens.

use std::time::Duration;

use super::error::Error;
use super::link::Link;
use super::message::{Event, State, Status};
use super::schedule::Schedule;
use super::session::Session;

/// An answer may come so late: requests are said again for a second.
const LATE: Duration = Duration::from_secs(2);
/// The clocks of a board and of this machine differ by half a percent at most (`docs/hardware.md`); more is no clock.
const APART: f64 = 0.02;

/// How to run a schedule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// How many cycles; 0: until it is stopped.
    pub cycles: u32,
    /// How often the board hears of this program.
    pub heartbeat: Duration,
    /// After how long a silence the board stops by itself: 0.1 s to 5 s.
    pub silence: Duration,
    /// Whether to end an emergency stop or a fault that the board is in, before the run.
    pub clear: bool,
}

impl Default for Plan {
    /// Until it is stopped; ten heartbeats a second, and half a second of silence.
    fn default() -> Self {
        Self {
            cycles: 0,
            heartbeat: Duration::from_millis(100),
            silence: Duration::from_millis(500),
            clear: false,
        }
    }
}

/// What the observer of a run wants next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// The run goes on.
    GoOn,
    /// The run ends, in the safe state.
    Stop,
    /// The same, and the board starts nothing before it is cleared.
    EmergencyStop,
}

/// How a run has ended, if nothing went wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All cycles were run.
    Completed {
        /// How many.
        cycles: u32,
    },
    /// It was stopped, as wished.
    Stopped {
        /// Complete cycles before.
        cycles: u32,
    },
}

/// Greets a board, loads a schedule, and runs it.
///
/// `watch` is called at every heartbeat, and says how to go on.
///
/// # Errors
///
/// Whatever goes wrong; the board has then been told to stop, or stops by itself.
pub fn drive<L: Link>(
    link: L,
    schedule: &Schedule,
    plan: &Plan,
    watch: &mut dyn FnMut(&Status) -> Wish,
) -> Result<Outcome, Error> {
    let mut session = Session::open(link)?;
    if plan.clear {
        session.clear()?;
    }
    session.load(schedule)?;
    run(&mut session, plan, watch)
}

/// Runs what a session has loaded.
///
/// # Errors
///
/// [`Error::LinkLost`], [`Error::StopCircuit`], [`Error::Reset`] and whatever else goes wrong; the board has then
/// been told to stop, or stops by itself.
pub fn run<L: Link>(
    session: &mut Session<L>,
    plan: &Plan,
    watch: &mut dyn FnMut(&Status) -> Wish,
) -> Result<Outcome, Error> {
    session.take_events();
    session.start(plan.cycles, plan.silence)?;
    let result = watch_over(session, plan, watch);
    if result.is_err() {
        // What went wrong is worth more than how the stop went.
        let _ = session.stop();
    }
    result
}

/// Sees that the board's time goes as fast as that of this machine.
fn check_clock(board: Duration, host: Duration) -> Result<(), Error> {
    if board.abs_diff(host) > LATE + host.mul_f64(APART) {
        return Err(Error::Clock { board, host });
    }
    Ok(())
}

fn watch_over<L: Link>(
    session: &mut Session<L>,
    plan: &Plan,
    watch: &mut dyn FnMut(&Status) -> Wish,
) -> Result<Outcome, Error> {
    let begun = session.now();
    loop {
        let status = session.status()?;
        let wish = watch(&status);
        match status.state {
            State::Running => check_clock(session.run_for(&status), session.now() - begun)?,
            State::Armed if plan.cycles == status.cycle && plan.cycles > 0 => {
                return Ok(Outcome::Completed { cycles: status.cycle });
            }
            State::Armed => return Err(Error::EndedOtherwise { asked: plan.cycles, run: status.cycle }),
            State::Estopped if status.faults.stop_circuit() => return Err(Error::StopCircuit),
            State::Fault if status.faults.link() => return Err(Error::LinkLost),
            State::Idle => return Err(Error::Reset),
            state => return Err(Error::Latched { state, faults: status.faults }),
        }
        match wish {
            Wish::GoOn => {}
            Wish::Stop => {
                session.stop()?;
                return Ok(Outcome::Stopped { cycles: session.status()?.cycle });
            }
            Wish::EmergencyStop => {
                session.emergency_stop()?;
                return Ok(Outcome::Stopped { cycles: session.status()?.cycle });
            }
        }
        session.wait(plan.heartbeat)?;
        if session.take_events().contains(&Event::Reset) {
            return Err(Error::Reset);
        }
    }
}
