//! Real hardware: a schedule of valves or servos is loaded into a board and supervised while it runs.
//!
//! The board runs the schedule by itself and stops by itself when it no longer hears of the host
//! (`firmware/PROTOCOL.md`). But for [`backend`], which makes it of what a gait asks of actuators, and [`contents`],
//! nothing here knows a robot or a grammar: the input is a [`Schedule`].

pub mod backend;
pub mod compared;
pub mod contents;
pub mod dry_run;
pub mod error;
mod fit;
pub mod frame;
pub mod link;
pub mod message;
pub mod picture;
pub mod pin;
pub mod program;
pub mod schedule;
pub mod session;
pub mod supervise;

pub use error::{Error, Problem};
pub use link::{Link, Serial};
pub use message::{Limits, State, Status, Welcome};
pub use pin::Pin;
pub use schedule::{Channel, Micros, Output, Safe, Schedule, ValveState};
pub use session::Session;
pub use supervise::{Outcome, Plan, Wish, drive, run};
