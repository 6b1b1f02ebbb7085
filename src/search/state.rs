//! Where a search stands: all that it needs to go on, and nothing else.
//!
//! Streams of random numbers are named after the numbers of the moves, so that no generator
//! has to be kept. In a file derivations are kept as their steps: `State<Steps>`.

use std::sync::Arc;

use grammar_lang::ir::RuleSet;
use serde::{Deserialize, Serialize};

use super::schedule::{Course, Iteration};
use super::tally::Tally;
use crate::derive::{Derivation, Steps};
use crate::drive::Parameters;

/// Where a search stands. `D` is what there is of a derivation: itself, or its [`Steps`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State<D = Arc<Derivation>> {
    /// Evaluations spent.
    pub(super) spent: u64,
    /// Moves made.
    pub(super) moves: usize,
    /// Bodies tuned.
    pub(super) bodies: usize,
    /// Moves in a row that could do nothing.
    pub(super) idle_moves: usize,
    /// Evaluations that came to nothing, of all bodies judged.
    pub(super) tally: Tally,
    /// The design that the next move starts from.
    pub(super) current: D,
    /// Its value.
    pub(super) value: Option<f64>,
    pub(super) course: Course,
    pub(super) iteration: Option<Iteration>,
    /// The design that is being tried.
    pub(super) trial: Option<Trial<D>>,
    pub(super) best: Option<Best<D>>,
}

/// A design that is being tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Trial<D> {
    pub(super) derivation: D,
    /// The rule that made it of the current one.
    pub(super) rule: Option<String>,
    /// Rules that were drawn before, and what blocked each.
    pub(super) blocked: Vec<(String, String)>,
    /// The random number that decides whether it is accepted.
    pub(super) drawn: f64,
    pub(super) body: Body,
}

/// The best design so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Best<D = Arc<Derivation>> {
    /// The design and how it came to be.
    pub derivation: D,
    /// What was found for each task, in their order.
    pub tasks: Vec<Tune>,
    /// Its value, as the grammar states the objective.
    pub value: f64,
    /// The outer move that found it; 0 is the initial design.
    pub found_at: usize,
}

/// The best drive of a body for one task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tune {
    /// The values of its varied quantities.
    pub parameters: Parameters,
    /// Its value, as the task states its objective.
    pub value: f64,
    /// Its value at half the step, where that was checked.
    pub half_step: Option<f64>,
}

/// How far the tuning of a body for all tasks is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Body {
    /// Tasks that are done.
    pub(super) done: usize,
    /// What was found for them; nothing for a task that no motion could be valued by.
    pub(super) tunes: Vec<Tune>,
    /// Evaluations that came to nothing in them.
    pub(super) tally: Tally,
    /// The task after those.
    pub(super) tuning: Tuning,
}

/// How far the tuning of a body for one task is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Tuning {
    /// The best so far.
    pub(super) found: Option<Tune>,
    pub(super) tally: Tally,
    /// None before the first evaluation.
    pub(super) chain: Option<Chain>,
}

/// Where the annealing of curves stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Chain {
    pub(super) current: Parameters,
    /// The value of the current ones where more is better; none where they have no value.
    pub(super) fitness: Option<f64>,
    pub(super) course: Course,
    pub(super) iteration: Option<Iteration>,
    /// Moves made.
    pub(super) number: u64,
}

impl State {
    /// Where a search starts that begins with a design.
    #[must_use]
    pub fn begin(first: Derivation) -> Self {
        let first = Arc::new(first);
        Self {
            spent: 0,
            moves: 0,
            bodies: 0,
            idle_moves: 0,
            tally: Tally::default(),
            current: Arc::clone(&first),
            value: None,
            course: Course::default(),
            iteration: None,
            trial: Some(Trial {
                derivation: first,
                rule: None,
                blocked: Vec::new(),
                drawn: 0.0,
                body: Body::default(),
            }),
            best: None,
        }
    }

    /// The best design so far.
    #[must_use]
    pub fn best(&self) -> Option<&Best> {
        self.best.as_ref()
    }

    /// Evaluations spent.
    #[must_use]
    pub fn spent(&self) -> u64 {
        self.spent
    }

    /// Moves made.
    #[must_use]
    pub fn moves(&self) -> usize {
        self.moves
    }

    /// What is kept in a file.
    #[must_use]
    pub fn kept(&self) -> State<Steps> {
        let kept: Result<_, std::convert::Infallible> = self.clone().map(&mut |d| Ok(d.kept()));
        let Ok(kept) = kept;
        kept
    }
}

impl State<Steps> {
    /// Makes the designs again.
    ///
    /// # Errors
    ///
    /// A sentence that says why a design cannot be made by these rules.
    pub fn restore(self, rules: &RuleSet) -> Result<State, String> {
        self.map(&mut |steps| Derivation::restore(rules, &steps).map(Arc::new))
    }
}

impl<D> State<D> {
    fn map<T, E>(self, change: &mut impl FnMut(D) -> Result<T, E>) -> Result<State<T>, E> {
        let Self { spent, moves, bodies, idle_moves, tally, current, value, course, iteration, trial, best } =
            self;
        let current = change(current)?;
        let trial = match trial {
            Some(Trial { derivation, rule, blocked, drawn, body }) => {
                Some(Trial { derivation: change(derivation)?, rule, blocked, drawn, body })
            }
            None => None,
        };
        let best = match best {
            Some(Best { derivation, tasks, value, found_at }) => {
                Some(Best { derivation: change(derivation)?, tasks, value, found_at })
            }
            None => None,
        };
        Ok(State { spent, moves, bodies, idle_moves, tally, current, value, course, iteration, trial, best })
    }
}
