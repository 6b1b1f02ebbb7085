//! Why a saved design cannot be simulated again, or is not what it says.

use grammar_lang::eval::EvalError;
use grammar_lang::ir::UnfitStep;
use thiserror::Error;

use super::names::BadNames;
use crate::derive::BadStep;
use crate::simulate::export::NotMotion;
use crate::simulate::{self, Invalid};

/// Why a saved design cannot be simulated again, or is not what it says. The file is named by whoever asks.
#[derive(Debug, Error)]
pub enum DesignError {
    /// A frozen text is not there.
    #[error("the text of its grammar is missing")]
    NoText,
    /// The frozen texts are no grammar of this version.
    #[error("this version of sgc cannot read the grammar in it")]
    Unreadable,
    /// The frozen texts come to other rules.
    #[error("its grammar was changed after it was saved, or this version of sgc reads it differently")]
    OtherRules,
    /// Its derivation does not go through.
    #[error(transparent)]
    Step(#[from] BadStep),
    /// It has no task at all.
    #[error("it has no task")]
    NoTask,
    /// It has no task of this name.
    #[error("it has no task `{name}`; {}", match there.is_empty() {
        true => "its grammar names no tasks: leave --task out".to_owned(),
        false => format!("it has: {}", there.join(", ")),
    })]
    UnknownTask {
        /// The name.
        name: String,
        /// Those that it has.
        there: Vec<String>,
    },
    /// Its grammar has no task of this name.
    #[error("this grammar has no task `{0}`")]
    NotInGrammar(String),
    /// It lacks tasks of its grammar.
    #[error("its tasks are not those of this grammar")]
    OtherTasks,
    /// Its drive is of other actuators or variables.
    #[error("its drive does not fit the actuation of this grammar")]
    OtherDrive,
    /// An expression has no value for it.
    #[error("{}", .0.reason)]
    NoValue(EvalError),
    /// A feature of a novelty has no value for it.
    #[error("its feature `{name}` has no value: {}", why.reason)]
    NoFeature {
        /// Which.
        name: String,
        /// Why.
        why: EvalError,
    },
    /// There is no such solver.
    #[error("there is no solver `{0}`")]
    NoSolver(String),
    /// The solver cannot simulate it.
    #[error("{}", .0.reason)]
    Unfit(simulate::Unfit),
    /// The step that was asked for is too long.
    #[error(transparent)]
    UnfitStep(#[from] UnfitStep),
    /// The motion may not be scored.
    #[error("its motion is not valid: {}", .0.describe())]
    Motion(Invalid),
    /// A motion of another program cannot be read.
    #[error(transparent)]
    OtherMotion(#[from] NotMotion),
    /// The objective asks for what such a motion does not tell.
    #[error(
        "the objective reads values that a table of poses does not contain, such as `energy` or `work`: only sgc's own solvers \
         know these"
    )]
    NotInMotion,
    /// Somebody asked to stop.
    #[error("stopped before {0}")]
    Stopped(&'static str),
    /// Its derivation leads to another body.
    #[error("its derivation does not lead to the body that was saved: the file was changed")]
    OtherBody,
    /// Its names are none.
    #[error(transparent)]
    Names(#[from] BadNames),
    /// Its drive calls an actuator otherwise than its names do.
    #[error("`{saved}` in its drive is `{label}` by the names of its parts: the file was changed")]
    OtherLabel {
        /// As the drive says.
        saved: String,
        /// As the names say.
        label: String,
    },
    /// It comes to another value.
    #[error("simulated again, the design does not have its saved value: the file was changed")]
    OtherValue,
    /// It comes to something else, and another program saved it.
    #[error(
        "the design was saved by sgc {theirs}, and with this version, {}, {what}: use sgc {theirs} for it, or search again",
        env!("CARGO_PKG_VERSION")
    )]
    OtherProgram {
        /// The version that saved it.
        theirs: String,
        /// What has changed, in a clause.
        what: String,
    },
    /// It comes to something else that it says.
    #[error("{what} differs from the result of the simulation: the file was changed")]
    Other {
        /// What.
        what: String,
    },
    /// It was not found by this run.
    #[error("it belongs to another run (grammar {grammar}, seed {seed}): the file was replaced")]
    OtherRun {
        /// Its grammar.
        grammar: String,
        /// Its seed.
        seed: u64,
    },
    /// The run says another value.
    #[error("its value differs from that in {file}: the file was changed")]
    OtherResult {
        /// Where the run says it.
        file: &'static str,
    },
}

impl From<EvalError> for DesignError {
    fn from(error: EvalError) -> Self {
        Self::NoValue(error)
    }
}

impl From<simulate::Unfit> for DesignError {
    fn from(unfit: simulate::Unfit) -> Self {
        Self::Unfit(unfit)
    }
}

impl From<Invalid> for DesignError {
    fn from(invalid: Invalid) -> Self {
        Self::Motion(invalid)
    }
}
