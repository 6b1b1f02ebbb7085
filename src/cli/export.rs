//! `sgc export`: a saved design for other simulators, and as text of a grammar.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use grammar_lang::ir::RuleSet;

use super::design::{self, Opened};
use super::exit;
use super::output::{self, Fault};
use super::precision::Precision;
use super::replace::Replace;
use super::scenarios::OneWorld;
use crate::derive::Candidate;
use crate::results::beginning::beginning;
use crate::results::replay;
use crate::results::saved::SavedDesign;
use crate::results::signals;
use crate::scenarios::Scenario;
use crate::simulate::{SolverName, export};

/// What a design is written as.
#[derive(Clone, Copy, ValueEnum)]
enum Format {
    /// The body with its servos and the ground as a MuJoCo model
    Mjcf,
    /// The target of every servo over time, as comma-separated values
    Drive,
    /// The body as the `begin` of a grammar, to edit it, keep it or start from it
    Begin,
    /// The poses of all elements over time, as comma-separated values
    Motion,
    /// The readings of sensors, the values of states and the targets of actuators over time, as comma-separated values
    Signals,
}

/// Write a saved design for other simulators (its body, its drive or its motion), or as the text of a grammar
#[derive(Args)]
pub(super) struct Export {
    /// The saved design, or the run folder that holds it
    #[arg(value_name = "DESIGN")]
    design: PathBuf,
    /// What to write
    #[arg(long, value_name = "FORMAT")]
    to: Format,
    /// Where to write it [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    replace: Replace,
    /// The task to write [default: the first]
    #[arg(long, value_name = "NAME")]
    task: Option<String>,
    #[command(flatten)]
    precision: Precision,
    /// The simulation method [default: the method of the run]
    #[arg(long, value_parser = clap::builder::PossibleValuesParser::new(SolverName::ALL.map(SolverName::text)))]
    solver: Option<String>,
    #[command(flatten)]
    place: OneWorld,
}

impl Export {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let path = design::file(&self.design);
        let Opened { design, rules, .. } = design::open(&path)?;
        let fault = |e| design::fault(&path, &e);
        let Candidate { derivation, .. } = replay::candidate(&rules, &design).map_err(fault)?;
        let names = design.names(&rules, &derivation);
        let world = self.place.asked(&rules)?;
        if world.is_some() && !matches!(self.to, Format::Motion | Format::Signals) {
            return Err(Fault::usage(
                "a world changes what is simulated, so it works only with `--to motion` and `--to signals`\nhelp: leave `--in` and `--world` out".to_owned(),
            ));
        }
        if matches!(self.to, Format::Begin) {
            if self.task.is_some()
                || self.solver.is_some()
                || self.precision.asked() != replay::Precision::Model
            {
                return Err(Fault::usage(
                    "`--to begin` writes a body, and simulates nothing\nhelp: leave `--task`, `--solver`, `--step` and `--sweeps` out".to_owned(),
                ));
            }
            if rules.lattice.is_some() {
                return Err(Fault::usage(format!(
                    "{}: `--to begin` writes parts, and this body is made of cells of a lattice; begin another search with it by \
                     `sgc run GRAMMAR --from-design {0}`",
                    path.display()
                )));
            }
            return self.write(&beginning(&rules, &names, &derivation.design));
        }
        let design = design::as_simulated(&path, &rules, design)?;
        if matches!(self.to, Format::Mjcf) && rules.lattice.is_some() {
            return Err(Fault::usage(format!(
                "{}: a body of balls and springs has no model of hinges for MuJoCo; `--to motion` writes its motion",
                path.display()
            )));
        }
        let precision = self.precision.asked();
        let setup = replay::setup(&rules, &design, self.task.as_deref(), precision).map_err(fault)?;
        let assembly = &setup.body.assembly;
        if matches!(self.to, Format::Signals) {
            let solver = self.solver.as_deref().unwrap_or(&design.solver);
            let world = world.unwrap_or_else(Scenario::nominal);
            let trace = replay::signals(&rules, &design, self.task.as_deref(), &world, solver, precision);
            return match trace.map_err(fault)? {
                Some(trace) => self.write(&signals::table(&rules, &names, &trace)),
                None => Err(Fault::usage(format!(
                    "{}: no actuation of this design reads a sensor or has a state\nhelp: `--to drive` writes the commands for its actuators",
                    path.display()
                ))),
            };
        }
        let names = names.all(&setup.body.parts_of_elements);
        let text = match self.to {
            Format::Mjcf => export::mjcf(assembly, &setup.settings, &self.title(&design), &names),
            Format::Drive if setup.law.is_closed_loop() => {
                let solver = self.solver.as_deref().unwrap_or(&design.solver);
                let motion = setup.motion(solver).map_err(fault)?;
                output::note(
                    "the drive of this design depends on the motion itself: these are the commands of its motion in the nominal world",
                );
                let settings = &setup.settings;
                let commands =
                    motion.commands.map(|commands| commands.held(settings.step, settings.duration));
                let commands = commands.unwrap_or_else(|| setup.law.targets.clone());
                export::drive(assembly, settings, &commands, &names)
            }
            Format::Drive => export::drive(assembly, &setup.settings, &setup.law.targets, &names),
            // Written already.
            Format::Begin | Format::Signals => Ok(String::new()),
            Format::Motion => {
                let solver = self.solver.as_deref().unwrap_or(&design.solver);
                let task = self.task.as_deref();
                let motion = match &world {
                    Some(world) => replay::motion_in(&rules, &design, task, world, solver, precision)
                        .and_then(|motion| Ok(motion?)),
                    None => setup.motion(solver),
                };
                Ok(export::motion(&motion.map_err(fault)?))
            }
        };
        let text = text.map_err(|unfit| fault(unfit.into()))?;
        self.write(&text)
    }

    /// Writes what was made of a saved design.
    fn write(&self, text: &str) -> Result<u8, Fault> {
        match &self.out {
            Some(out) => {
                match self.to {
                    Format::Mjcf => self.replace.write_sealed(out, text, "export")?,
                    Format::Drive | Format::Begin | Format::Motion | Format::Signals => {
                        self.replace.write(out, text)?;
                    }
                }
                output::data(&format!("{}\n", out.display()))?;
            }
            None => output::data(text)?,
        }
        Ok(exit::DONE)
    }

    fn title(&self, design: &SavedDesign) -> String {
        let task = design.task(self.task.as_deref()).map_or(RuleSet::ONLY_TASK, |task| task.name.as_str());
        let task = if task == RuleSet::ONLY_TASK { String::new() } else { format!(", task {task}") };
        format!("{}, seed {}{task}", design.grammar.name, design.seed)
    }
}
