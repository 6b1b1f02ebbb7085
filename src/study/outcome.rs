//! What the runs of a study came to.

use super::folder::{Run, Study};
use super::shell_word;
use super::standing::{Standing, reason, standing};
use crate::results::genuine;
use crate::results::run_files::{self, Finished};

/// What one run came to.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The run.
    pub run: Run,
    /// How far it is.
    pub standing: Standing,
    /// What it says at its end, if it has come there.
    pub finished: Option<Finished>,
    /// Why it failed, or why what it says at its end does not count.
    pub problem: Option<String>,
}

/// Which number of a run a study compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum By {
    /// The value of the objective.
    Value,
    /// The value that the robot reaches in nine of ten worlds that its search never saw.
    NineOfTen,
}

impl By {
    /// In words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Value => "the value of the objective",
            Self::NineOfTen => "the value reached in nine of ten other worlds",
        }
    }
}

impl Outcome {
    /// The number that is compared, if the run has come to it.
    #[must_use]
    pub fn number(&self, by: By) -> Option<f64> {
        let finished = self.finished.as_ref()?;
        match by {
            By::Value => finished.value,
            By::NineOfTen => finished.nine_of_ten,
        }
    }
}

/// What all runs of a study have come to so far. A run whose result is damaged, or is that of another run, counts as failed.
#[must_use]
pub fn outcomes(study: &Study) -> Vec<Outcome> {
    let outcome = |run: Run| {
        let folder = study.folder(run);
        let finished = run_files::finished(&folder).and_then(|finished| {
            if let Some(finished) = &finished {
                genuine::check_result(&folder, &study.asked(run), finished)?;
            }
            Ok(finished)
        });
        match finished {
            Ok(Some(finished)) => {
                Outcome { run, standing: Standing::Complete, finished: Some(finished), problem: None }
            }
            Ok(None) => {
                let standing = standing(study, run);
                let failed = standing == Standing::Failed;
                let problem = if failed { reason(study, run) } else { None };
                Outcome { run, standing, finished: None, problem }
            }
            Err(why) => {
                let name = study.name(run);
                let problem = format!(
                    "its result does not count: {why}; `sgc study retry {} --anew --run {}` begins it anew",
                    shell_word(study.path()),
                    shell_word(name.as_ref())
                );
                Outcome { run, standing: Standing::Failed, finished: None, problem: Some(problem) }
            }
        }
    };
    study.runs().map(outcome).collect()
}

/// What runs are compared by: what they reach in other worlds, where every robot that was found was tested there.
#[must_use]
pub fn compared_by(outcomes: &[Outcome]) -> By {
    let mut found =
        outcomes.iter().filter_map(|one| one.finished.as_ref()).filter(|f| f.value.is_some()).peekable();
    match found.peek().is_some() && found.all(|finished| finished.nine_of_ten.is_some()) {
        true => By::NineOfTen,
        false => By::Value,
    }
}
