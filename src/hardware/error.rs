//! What can go wrong with a board, where, and how to mend it.

use std::fmt;
use std::time::Duration;

use super::message::{Faults, Refusal, State};

/// Something in a schedule that no board can run, with how to mend it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The channel, by its name; nothing if it is the schedule as a whole.
    pub channel: Option<String>,
    /// What is wrong.
    pub text: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.channel {
            Some(channel) => write!(f, "`{channel}`: {}", self.text),
            None => write!(f, "the schedule: {}", self.text),
        }
    }
}

/// Why a board could not be driven.
#[derive(Debug)]
pub enum Error {
    /// There is no such port.
    NoPort {
        /// What was asked for.
        port: String,
        /// The ports of this machine.
        there_are: Vec<String>,
    },
    /// Another program has the port.
    PortBusy {
        /// What was asked for.
        port: String,
    },
    /// This user may not open the port.
    NotPermitted {
        /// What was asked for.
        port: String,
    },
    /// The port failed: a cable was pulled, or it is no serial port.
    Line {
        /// The port.
        port: String,
        /// What the system says.
        cause: String,
    },
    /// Nothing was answered.
    Silent {
        /// How long.
        waited: Duration,
    },
    /// The board speaks another version of the protocol.
    OtherVersion {
        /// Which.
        board: u8,
    },
    /// Another host drives the board.
    OtherHost,
    /// The board was reset, or lost its power: it has forgotten all.
    Reset,
    /// The stop circuit is open.
    StopCircuit,
    /// The board has stopped, and waits for leave to go on.
    Latched {
        /// Its state.
        state: State,
        /// Why.
        faults: Faults,
    },
    /// The board did not hear of this program for too long, and has stopped.
    LinkLost,
    /// The schedule is not for this board.
    Unfit(Vec<Problem>),
    /// A time of a plan is beyond what boards take.
    Timeout {
        /// The time.
        asked: Duration,
    },
    /// The board ended the run by itself, too early or too late.
    EndedOtherwise {
        /// How many cycles were asked for; 0: until it is stopped.
        asked: u32,
        /// How many it says that it has run.
        run: u32,
    },
    /// The board has taken the order to stop, and runs on.
    StillRunning,
    /// The time that the board says it has run for is not the time that has passed here.
    Clock {
        /// By the board.
        board: Duration,
        /// Here.
        host: Duration,
    },
    /// The board refuses.
    Refused {
        /// The number of the request.
        request: u8,
        /// Why.
        refusal: Refusal,
        /// More: a row of the table, say.
        detail: u16,
    },
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoPort { port, there_are } if there_are.is_empty() => {
                write!(f, "there is no port {port}, and no serial port at all: is the board plugged in?")
            }
            Self::NoPort { port, there_are } => {
                write!(f, "there is no port {port}; there are {}", there_are.join(", "))
            }
            Self::PortBusy { port } => {
                write!(f, "another program has {port} open: close it (a serial monitor, another `sgc drive`)")
            }
            Self::NotPermitted { port } => write!(
                f,
                "you may not open {port}: become a member of its group (`ls -l {port}` shows which; on Debian \
                 and Ubuntu `sudo usermod -aG dialout $USER`), then log in again"
            ),
            Self::Line { port, cause } => {
                write!(
                    f,
                    "the line at {port} failed ({cause}): the board stops by itself; is its cable plugged in?"
                )
            }
            Self::Silent { waited } => write!(
                f,
                "the board has not answered for {:.1} s: is it the right port, and is the firmware on the board?",
                waited.as_secs_f64()
            ),
            Self::OtherVersion { board } => write!(
                f,
                "the board speaks version {board} of the protocol, this program {}: flash its firmware",
                super::message::VERSION
            ),
            Self::OtherHost => {
                write!(f, "another program drives this board: stop it first")
            }
            Self::Reset => write!(
                f,
                "the board was reset: it has stopped and forgotten its schedule. If nobody pressed its button, \
                 its power failed; give valves or servos a supply of their own"
            ),
            Self::StopCircuit => write!(
                f,
                "the stop circuit is open: release the stop button; if it is released, a wire between D2 and \
                 ground is broken"
            ),
            Self::Latched { state: State::Estopped, faults } if faults.stop_circuit() => write!(
                f,
                "the board is in an emergency stop, because its stop circuit was opened: release the button (without a \
                 button, D2 needs a wire to ground), see that all is well at the robot, then clear it"
            ),
            Self::Latched { state: State::Estopped, .. } => write!(
                f,
                "the board is in an emergency stop: see that all is well at the robot, then clear it"
            ),
            Self::Latched { faults, .. } if faults.watchdog() => write!(
                f,
                "the board's program hung and was reset by its watchdog: see that all is well at the robot, \
                 then clear it; if it happens again, report it"
            ),
            Self::Latched { .. } => write!(
                f,
                "the board stopped because it lost the connection to its host: see that all is well at the robot, then clear it"
            ),
            Self::LinkLost => write!(
                f,
                "the board did not hear from this program for too long, and has stopped: is the machine overloaded, \
                 or the cable loose?"
            ),
            Self::Unfit(problems) => {
                write!(f, "the board cannot run this schedule:")?;
                problems.iter().try_for_each(|problem| write!(f, "\n  {problem}"))
            }
            Self::Timeout { asked } => {
                write!(f, "the board can wait 0.1 s to 5 s for its host, not {} s", asked.as_secs_f64())
            }
            Self::EndedOtherwise { asked: 0, run } => {
                write!(
                    f,
                    "the board ended the run by itself after {run} cycles: look at the robot, and at its power supply"
                )
            }
            Self::EndedOtherwise { asked, run } => write!(
                f,
                "the board ended the run after {run} cycles, not {asked}: look at the robot, and flash the firmware again"
            ),
            Self::StillRunning => write!(
                f,
                "the board accepted the order to stop, but reports that it still runs: open its stop circuit or cut its power"
            ),
            Self::Clock { board, host } => write!(
                f,
                "the board reports that it ran for {:.1} s, but {:.1} s have passed here: sgc stopped it, because the motion \
                 is not the one that was simulated. Is the firmware that of this program?",
                board.as_secs_f64(),
                host.as_secs_f64()
            ),
            Self::Refused { request, refusal, detail } => write!(
                f,
                "the board refuses message {request:#04x} ({refusal:?}, {detail}): its firmware is not that of this \
                 program; flash it again"
            ),
        }
    }
}

impl std::error::Error for Error {}
