//! `sgc drive`: runs the gait of a saved design on hardware.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::design::{self, Opened};
use super::output::{self, Fault};
use super::replace::Replace;
use super::{exit, interrupt, load};
use crate::hardware::backend::POINTS;
use crate::hardware::compared;
use crate::hardware::dry_run::{self, Marks};
use crate::hardware::{self, Error, Outcome, Plan, Schedule, Serial, Session, State, Status, Wish, picture};
use crate::results::gait::{self, Gait, NoGait};

/// What its drawings are sealed with.
const DRIVE: &str = "drive";

/// Run the gait of a saved design on hardware
///
/// The grammar's `target` says which board, which pins and which limits. The board plays the gait and stops by
/// itself if this program no longer sends anything; Ctrl-C stops it safely.
#[derive(Args)]
pub(super) struct Drive {
    /// The run folder, or a saved design
    #[arg(value_name = "DIR|DESIGN")]
    design: PathBuf,
    /// The target [default: the one that the design was simulated on, or the only one]
    #[arg(long, value_name = "NAME")]
    target: Option<String>,
    /// The serial port of the board, such as /dev/ttyACM0 or COM3
    #[arg(long, value_name = "PATH", required_unless_present = "dry_run")]
    port: Option<String>,
    /// How many cycles to run; 0 runs until Ctrl-C
    #[arg(long, value_name = "N", default_value_t = 0)]
    cycles: u32,
    /// Move nothing: print what the board would play, and draw it
    #[arg(long)]
    dry_run: bool,
    /// Where to write the drawing [default: schedule.svg beside the design, with --target NAME schedule.NAME.svg]
    #[arg(long, value_name = "FILE", requires = "dry_run")]
    out: Option<PathBuf>,
    #[command(flatten)]
    replace: Replace,
    /// First clear an emergency stop or a fault of the board
    #[arg(long)]
    clear: bool,
    /// The task whose gait to run [default: the first]
    #[arg(long, value_name = "NAME")]
    task: Option<String>,
    /// Take the target from this grammar, not from the one that made the design; useful if the target has
    /// been calibrated since
    #[arg(long, value_name = "FILE")]
    grammar: Option<PathBuf>,
    /// The variant of that grammar
    #[arg(long, value_name = "NAME", requires = "grammar")]
    variant: Option<String>,
    /// Continue even if the target does not let the actuators bend as they were simulated. sgc prints the
    /// differences, and draws them in difference.svg beside the design
    #[arg(long)]
    accept_changes: bool,
}

impl Drive {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let stop = interrupt::listen();
        // Until the board has greeted, nothing can move: a signal ends the process.
        let quiet = interrupt::Cuttable::begin();
        let path = design::file(&self.design);
        let Opened { design, rules, .. } = design::open(&path)?;
        let design = design::as_simulated(&path, &rules, design)?;
        let other = match &self.grammar {
            Some(file) => Some(load::grammar(file, &[], self.variant.as_deref())?.0),
            None => None,
        };
        let (task, target) = (self.task.as_deref(), self.target.as_deref());
        let gait =
            gait::gait(&rules, other.as_ref(), &design, task, target).map_err(|why| unfit(&path, &why))?;
        self.compare(&gait, &path)?;
        match &self.port {
            Some(port) if !self.dry_run => self.play(&gait.schedule, port, stop, quiet),
            _ => self.show(&gait.schedule, &path),
        }
    }

    /// Says what the target leaves out, and where what would be played is not what was simulated.
    fn compare(&self, gait: &Gait, design: &Path) -> Result<(), Fault> {
        if !gait.elsewhere.is_empty() {
            output::note(&format!(
                "this target does not drive {}: the simulated motion moves them, too, and they need a board of their own",
                gait.elsewhere.join(", ")
            ));
        }
        for cut in &gait.cut {
            let also = if gait.changed.is_empty() && gait.contents.is_empty() {
                "; so it was simulated, too"
            } else {
                ""
            };
            output::note(&format!("{cut}{also}"));
        }
        let differ = gait.changed.iter().filter(|one| !one.is_same());
        let mut text: Vec<String> = differ.map(|one| format!("\n  {}", one.told())).collect();
        text.extend(gait.contents.iter().map(|line| format!("\n  the target: {line}")));
        if gait.changed.is_empty() {
            if !text.is_empty() {
                let same = "the target differs from the one that was simulated, but its actuators move in the same way:";
                let start = if gait.begins_otherwise {
                    "\n  only the first period, which begins at rest, is different"
                } else {
                    ""
                };
                output::note(&format!("{same}{}{start}", text.concat()));
            }
            return Ok(());
        }
        let mut told =
            format!("on this target, the robot would not move as in the simulation:{}", text.concat());
        if gait.coarse {
            told += &format!(
                "\n  a board interpolates linearly between {POINTS} points of a period, but this actuation changes \
                 faster than that: give it a shorter `period`"
            );
        }
        if !self.accept_changes {
            return Err(Fault::usage(format!(
                "{}: {told}\nsimulate the grammar with this target and search again; or look at what changes with \
                 --accept-changes --dry-run, and play it with --accept-changes",
                design.display()
            )));
        }
        let out = design.with_file_name("difference.svg");
        if self.out.as_ref().is_some_and(|other| is_same_file(other, &out)) {
            return Err(Fault::usage(format!(
                "{}: this file shows what changes; name another file for the schedule with `--out`",
                out.display()
            )));
        }
        output::note(&told);
        let drawing = compared::svg("Simulated and played", &gait.changed);
        self.replace.write_sealed(&out, &drawing, DRIVE)?;
        output::note(&format!("drawn in {}", out.display()));
        Ok(())
    }

    fn show(&self, schedule: &Schedule, design: &Path) -> Result<u8, Fault> {
        output::data(&dry_run::text(schedule, 100, Marks::Blocks))?;
        // Each board has a drawing of its own where the text names several.
        let name = match &self.target {
            Some(target) => format!("schedule.{target}.svg"),
            None => "schedule.svg".to_owned(),
        };
        let out = self.out.clone().unwrap_or_else(|| design.with_file_name(name));
        self.replace.write_sealed(&out, &picture::svg(schedule), DRIVE)?;
        output::note(&format!("drawn in {}", out.display()));
        Ok(exit::DONE)
    }

    fn play(
        &self,
        schedule: &Schedule,
        port: &str,
        stop: &AtomicBool,
        quiet: interrupt::Cuttable,
    ) -> Result<u8, Fault> {
        interrupt::undone(
            "stopped before the board had answered: this program has moved nothing, and does not know the state of the outputs",
        );
        let link = Serial::open(port).map_err(|error| fault(&error))?;
        let bar = ProgressBar::new_spinner();
        bar.set_style(
            ProgressStyle::with_template("{spinner} {msg}")
                .unwrap_or_else(|_| ProgressStyle::default_spinner()),
        );
        bar.enable_steady_tick(Duration::from_millis(200));
        bar.set_message(format!("connecting to the board at {port}"));
        let plan = Plan { cycles: self.cycles, clear: self.clear, ..Plan::default() };
        let mut watch = |status: &Status| {
            bar.set_message(self.status(schedule, status));
            if stop.load(Ordering::Relaxed) { Wish::Stop } else { Wish::GoOn }
        };
        let opened = Session::open(link);
        drop(quiet);
        let outcome = opened.and_then(|mut session| {
            if stop.load(Ordering::Relaxed) {
                return Ok(Outcome::Stopped { cycles: 0 });
            }
            if plan.clear {
                session.clear()?;
            }
            session.load(schedule)?;
            // The user may have stopped the command while the board was loaded: then nothing moves.
            if stop.load(Ordering::Relaxed) {
                return Ok(Outcome::Stopped { cycles: 0 });
            }
            hardware::run(&mut session, &plan, &mut watch)
        });
        bar.finish_and_clear();
        match outcome.map_err(|error| fault(&error))? {
            Outcome::Completed { cycles } => {
                let run = if cycles == 1 {
                    "one cycle was run".to_owned()
                } else {
                    format!("{cycles} cycles were run")
                };
                output::note(&format!("{run}; the outputs are in their safe state"));
                Ok(exit::DONE)
            }
            Outcome::Stopped { cycles } => {
                output::note(&format!(
                    "stopped after {cycles} whole cycles; the outputs are in their safe state"
                ));
                Ok(exit::INTERRUPTED)
            }
        }
    }

    fn status(&self, schedule: &Schedule, status: &Status) -> String {
        let of = if self.cycles == 0 { String::new() } else { format!(" of {}", self.cycles) };
        let (now, all) = (f64::from(status.phase) / 1e6, f64::from(schedule.period) / 1e6);
        let state = match status.state {
            State::Running => "running",
            State::Armed => "armed",
            State::Idle => "idle",
            State::Estopped => "emergency stop",
            State::Fault => "fault",
        };
        format!("{state}: cycle {}{of}, {now:.1} s of {all:.1} s; Ctrl-C stops", u64::from(status.cycle) + 1)
    }
}

/// Whether two paths lead to one file, which need not be there yet.
fn is_same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some((std::fs::canonicalize(folder).ok()?, path.file_name()?.to_owned()))
    };
    place(a).is_some_and(|a| place(b) == Some(a))
}

/// The design and its target do not fit: nothing has been moved.
fn unfit(path: &Path, why: &NoGait) -> Fault {
    let path = path.display();
    match why {
        NoGait::Schedule(problems) if problems.len() > 1 => {
            let lines: String = problems.iter().map(|problem| format!("\n  {problem}")).collect();
            Fault::usage(format!("{path} cannot be driven:{lines}"))
        }
        one => Fault::usage(format!("{path}: {one}")),
    }
}

/// What is wrong before the board has heard of anything is a matter of usage.
fn fault(error: &Error) -> Fault {
    let code = match error {
        Error::NoPort { .. } | Error::PortBusy { .. } | Error::NotPermitted { .. } | Error::Unfit(_) => {
            exit::USAGE
        }
        _ => exit::HARDWARE,
    };
    Fault { code, message: error.to_string() }
}
