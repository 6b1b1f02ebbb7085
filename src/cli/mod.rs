//! The command line. One file for each command.

mod audit;
mod calibrate;
mod check;
mod compile;
mod completions;
mod countdown;
mod derive;
mod design;
mod doc;
mod drive;
mod eval;
mod explain;
mod export;
mod fit;
mod fmt;
mod interrupt;
mod live;
mod load;
mod man;
mod mend;
mod new;
mod novelty;
mod output;
mod precision;
mod price;
mod progress;
mod refine;
mod replace;
mod report;
mod resume;
mod run;
mod scenarios;
mod session;
mod several;
mod side_by_side;
mod study;
mod test;
mod variant_file;
mod view;
mod work;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use output::Fault;

/// Exit codes; scripts rely on them.
pub mod exit {
    /// Done.
    pub const DONE: u8 = 0;
    /// The input has errors or is not laid out, no feasible design was found, or a body
    /// that was asked for cannot be made.
    pub const INPUT: u8 = 1;
    /// Usage, configuration, files.
    pub const USAGE: u8 = 2;
    /// The hardware stopped, or could not be driven.
    pub const HARDWARE: u8 = 3;
    /// Stopped before the end, with a checkpoint to go on from.
    pub const STOPPED: u8 = 75;
    /// A bug in sgc; what a panic exits with.
    pub const BUG: u8 = 101;
    /// Interrupted with nothing saved.
    pub const INTERRUPTED: u8 = 130;
}

/// Grows soft robots from spatial grammars.
///
/// A grammar (.sgr) says which parts a robot may have, how they may be joined
/// and actuated, and what counts as good. sgc checks it, and searches for
/// bodies and gaits that do well in simulation.
#[derive(Parser)]
#[command(version, arg_required_else_help = true, after_help = AFTER)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const AFTER: &str = "\
Examples:
  sgc new walker
  sgc check grammars/codesign.sgr
  sgc explain E0302
  sgc run grammars/codesign.sgr --seed 3 --max-evals 20000
  sgc resume runs/codesign-3
  sgc view runs/codesign-3
  sgc report runs/codesign-3
  sgc study legs.toml
  sgc calibrate bench.toml --for grammars/tendon.sgr

To have the shell complete commands and options (other shells: sgc help completions):
  sgc completions bash > ~/.local/share/bash-completion/completions/sgc

Exit codes: 0 done; 1 the input has errors, no feasible design was found,
`audit` did not make the body that it was asked for, or `fmt --check` names a file;
2 a usage error or a file error; 3 the hardware stopped; 75 stopped with a checkpoint,
from which `sgc resume` continues; 101 a bug in sgc; 130 interrupted with nothing saved.";

#[derive(Subcommand)]
enum Command {
    New(new::New),
    Check(check::Check),
    Audit(audit::Audit),
    Fmt(fmt::Fmt),
    Test(test::Test),
    Explain(explain::Explain),
    Compile(compile::Compile),
    Derive(derive::Derive),
    Calibrate(calibrate::Calibrate),
    Fit(fit::Fit),
    Run(run::Run),
    Resume(resume::Resume),
    Study(study::Study),
    Report(report::Report),
    Eval(eval::Eval),
    Refine(refine::Refine),
    Novelty(novelty::Novelty),
    View(view::View),
    Export(export::Export),
    Drive(drive::Drive),
    Doc(doc::Doc),
    Completions(completions::Completions),
    Man(man::Manual),
}

/// Runs the program with the process's arguments.
#[must_use]
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let code = if error.use_stderr() { exit::USAGE } else { exit::DONE };
            // A closed terminal is no reason to fail twice.
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    // A file that may not grow any more is then an error of writing, as a full disk is.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
    // These listen for signals by themselves.
    if !matches!(
        arguments.command,
        Command::Run(_) | Command::Resume(_) | Command::Study(_) | Command::Drive(_)
    ) {
        interrupt::end_at_once();
    }
    let done = match arguments.command {
        Command::New(command) => command.run(),
        Command::Check(command) => command.run(),
        Command::Audit(command) => command.run(),
        Command::Fmt(command) => command.run(),
        Command::Test(command) => command.run(),
        Command::Explain(command) => command.run(),
        Command::Compile(command) => command.run(),
        Command::Derive(command) => command.run(),
        Command::Calibrate(command) => command.run(),
        Command::Fit(command) => command.run(),
        Command::Run(command) => command.run(),
        Command::Resume(command) => command.run(),
        Command::Study(command) => command.run(),
        Command::Report(command) => command.run(),
        Command::Eval(command) => command.run(),
        Command::Refine(command) => command.run(),
        Command::Novelty(command) => command.run(),
        Command::View(command) => command.run(),
        Command::Export(command) => command.run(),
        Command::Drive(command) => command.run(),
        Command::Doc(command) => command.run(),
        Command::Completions(command) => command.run(),
        Command::Man(command) => command.run(),
    };
    match done {
        Ok(code) => ExitCode::from(code),
        Err(Fault { code, message }) => {
            if !message.is_empty() {
                output::note(&format!("error: {message}"));
            }
            ExitCode::from(code)
        }
    }
}

/// Reads `NAME=VALUE`.
fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("write NAME=VALUE, such as max_parts=12 or period=\"4 s\"".to_owned()),
    }
}
