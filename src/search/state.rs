//! Where a search stands: all that it needs to go on, and nothing else.
//!
//! Streams of random numbers are named after the numbers of the moves, so that no generator
//! has to be kept. In a file derivations are kept as their steps: `State<Steps>`.

use std::collections::VecDeque;
use std::sync::Arc;

use grammar_lang::ir::RuleSet;
use serde::{Deserialize, Serialize};

use super::aim::Aim;
use super::learned::Learned;
use super::schedule::{Course, Iteration, Standing};
use super::tally::Tally;
use crate::derive::{BadStep, Derivation, Steps};
use crate::drive::Parameters;
use crate::learn::{ActorCritic, QLearning, Replay};
use crate::score::Observed;

/// Where a search stands. `D` is what there is of a derivation: itself, or its [`Steps`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct State<D = Arc<Derivation>> {
    /// Evaluations spent.
    pub(super) spent: u64,
    /// Moves made.
    pub(super) moves: usize,
    /// Bodies tuned, each counted once.
    pub(super) bodies: usize,
    /// Moves in a row that could do nothing.
    pub(super) idle_moves: usize,
    /// Failed evaluations, of all bodies judged.
    pub(super) tally: Tally,
    /// The worlds that were the hardest for the body that was judged last, where there is one task and it runs over worlds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) hardest: Vec<usize>,
    /// The design that the search began with.
    pub(super) first: Incumbent<D>,
    /// The designs that moves start from; none before the first design is judged, and where bodies are not searched
    /// for.
    pub(super) designs: Option<Designs<D>>,
    /// What a population or a front kept before each of the last moves, the earliest first: as many as are tried side by side.
    #[serde(default = "VecDeque::new", skip_serializing_if = "VecDeque::is_empty")]
    pub(super) earlier: VecDeque<Vec<Arc<Member<D>>>>,
    pub(super) course: Course,
    pub(super) iteration: Option<Iteration>,
    /// The design that is being tried.
    pub(super) trial: Option<Trial<D>>,
    /// What the learners of the body that was judged last came to, by task; empty where nothing learns.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) learned: Vec<(usize, Vec<Learned>)>,
    pub(super) best: Option<Best<D>>,
}

/// The designs that moves start from, by the method of the loop over bodies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Designs<D> {
    /// Annealing.
    Chains(BodyChains<D>),
    /// The best of each kind, by cell, in the order of cells.
    Archive(Vec<(Vec<usize>, Best<D>)>),
    /// The best since the search began, or began anew.
    Population(Members<D>),
    /// Those that no other is better than in every objective, as they came in.
    Front(Vec<Arc<Member<D>>>),
}

/// What a population keeps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Members<D> {
    /// The designs, as they came in.
    pub(super) kept: Vec<Arc<Member<D>>>,
    /// The course of their best.
    pub(super) course: Course,
}

/// A design that a population or a front keeps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Member<D> {
    pub(super) best: Best<D>,
    pub(super) tuned: Tuned,
}

/// How far the curves of a body are tuned that may be tuned further.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Tuned {
    /// How often they were.
    pub(super) times: usize,
    /// Where the search for curves stands, by task.
    pub(super) tunings: Vec<Tuning>,
}

/// Where the annealing of bodies stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct BodyChains<D> {
    pub(super) chains: Vec<BodyChain<D>>,
    /// The chain whose move is next.
    pub(super) turn: usize,
    /// The values of the random walk, as far as it is made.
    pub(super) walk: Vec<f64>,
}

/// A design that was judged, and that moves may go on from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Incumbent<D> {
    /// The move that made it; 0 is the initial design.
    pub(super) number: usize,
    pub(super) derivation: D,
    /// Its value; none if no evaluation was valid.
    pub(super) value: Option<f64>,
    /// Its curves for each task; none without a value.
    pub(super) tunes: Vec<Tune>,
}

/// Where a chain of bodies stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct BodyChain<D> {
    /// The design that its next move starts from.
    pub(super) at: Incumbent<D>,
    pub(super) standing: Standing,
}

/// What a move made a design of.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Origin {
    /// The move that made the design that it was made of; none for the initial design.
    pub(super) parent: Option<usize>,
    /// The chain that tries it.
    pub(super) chain: usize,
    /// The rule that made it of the current one; none if nothing could be applied.
    pub(super) rule: Option<String>,
    /// Rules that were drawn before, and what blocked each.
    pub(super) blocked: Vec<(String, String)>,
}

/// A design that is being tried.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Trial<D> {
    pub(super) derivation: D,
    pub(super) origin: Origin,
    /// How many evaluations were spent when it was drawn: what a schedule says for this move, it says once.
    pub(super) begun: u64,
    /// The random number that decides whether it is accepted.
    pub(super) drawn: f64,
    /// Curves to begin with, by task; empty where they are drawn at random.
    pub(super) warm: Vec<Parameters>,
    /// What is known of its curves, where they are tuned further.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) further: Option<Tuned>,
    /// What the move is after, where a front is searched for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) aim: Option<Aim>,
    /// What the design that it was made of comes to, by task; empty where that has no value, and for the initial design.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) parent: Vec<Worth>,
    pub(super) body: Body,
}

/// What a design comes to in a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Worth {
    /// Its value.
    pub(super) value: f64,
    /// What each objective is, where a front is searched for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) each: Vec<f64>,
}

impl Worth {
    /// What was found for a design, by task.
    pub(super) fn of(tunes: &[Tune]) -> Vec<Self> {
        tunes.iter().map(|tune| Self { value: tune.value, each: tune.each.clone() }).collect()
    }
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
    /// What it comes to in the objectives beside the first, where a front is searched for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beside: Vec<f64>,
    /// The move that found it; 0 is the initial design.
    pub found_at: usize,
}

impl<D> Best<D> {
    /// What it comes to in every objective, in their order.
    #[must_use]
    pub fn each(&self) -> Vec<f64> {
        std::iter::once(self.value).chain(self.beside.iter().copied()).collect()
    }

    /// What was observed of it in its first task, in the order of the rule set.
    #[must_use]
    pub fn observed(&self) -> &[Option<Observed>] {
        self.tasks.first().map_or(&[], |tune| &tune.observed)
    }
}

/// The best drive of a body for one task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tune {
    /// The values of its varied quantities.
    pub parameters: Parameters,
    /// Its value, as the task states its objective. While a front is searched for: as the move is after it.
    pub value: f64,
    /// What each objective is, where a front is searched for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub each: Vec<f64>,
    /// What the objective is of its motion in the nominal world alone, where it runs over others, too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal: Option<f64>,
    /// In how many worlds its value is known, where it is that of the worst of these and need not be known in all: in all
    /// together it is no better.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_most_in: Option<u64>,
    /// Its value in the nominal world at half the step, where that was checked.
    pub half_step: Option<f64>,
    /// What was observed of its motion, in the order of the rule set; empty where nothing is.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub observed: Vec<Option<Observed>>,
}

/// How far the tuning of a body for all tasks is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Body {
    /// Tasks that are done.
    pub(super) done: usize,
    /// What was found for them; nothing for a task that no motion could be valued by.
    pub(super) tunes: Vec<Tune>,
    /// Where the search for their curves stands, in case that it goes on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) tunings: Vec<Tuning>,
    /// Failed evaluations in them.
    pub(super) tally: Tally,
    /// The task after those.
    pub(super) tuning: Tuning,
}

/// How far the tuning of a body for one task is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Tuning {
    /// The best so far.
    pub(super) found: Option<Tune>,
    /// The best value in the nominal world, where more is better, if only the best of each iteration is judged in all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) highest: Option<f64>,
    /// How many curves were tried since some were judged in all worlds, and the best of them with its value in the nominal
    /// world, where more is better.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub(super) unjudged: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) offered: Option<Offered>,
    /// The worlds but for the nominal one, those first that curves failed in of late or, of a best, are the hardest; empty
    /// where that is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) hardest: Vec<usize>,
    pub(super) tally: Tally,
    /// None before the first evaluation.
    pub(super) loops: Option<Curves>,
}

/// Curves that may be judged in all worlds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Offered {
    pub(super) parameters: Parameters,
    /// Their value in the nominal world, where more is better.
    pub(super) fitness: f64,
    /// What each objective is there, where a front is searched for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) each: Vec<f64>,
}

/// Whether there is nothing to write.
fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// Where the search for curves stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Curves {
    /// Annealing.
    Chains(Chains),
    /// Covariance matrix adaptation.
    Distribution(Distribution),
    /// Learning of a policy.
    Learning(Box<Learning>),
}

/// Where the learning of a policy stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Learning {
    pub(super) course: Course,
    pub(super) agent: Agent,
    pub(super) replay: Replay,
    /// Motions made that explore.
    pub(super) motions: u64,
    /// What each iteration came to.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) learned: Vec<Learned>,
}

/// The networks that learn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Agent {
    ActorCritic(Box<ActorCritic>),
    QLearning(Box<QLearning>),
}

/// Where the annealing of curves stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Chains {
    pub(super) course: Course,
    pub(super) iteration: Option<Iteration>,
    pub(super) chains: Vec<Chain>,
    /// The chain whose move is next.
    pub(super) turn: usize,
    /// The values of the random walk, as far as it is made, and how many points of it were tried.
    pub(super) walk: (Vec<f64>, usize),
}

/// Where one chain stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Chain {
    pub(super) current: Parameters,
    /// The value of the current ones where more is better; none where they have no value.
    pub(super) fitness: Option<f64>,
    pub(super) standing: Standing,
    /// Moves made.
    pub(super) number: u64,
}

/// Where the adaptation of a normal distribution of curves stands. Each value is a share of its range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Distribution {
    pub(super) course: Course,
    pub(super) mean: Vec<f64>,
    /// The step size.
    pub(super) sigma: f64,
    /// The covariance matrix, by columns.
    pub(super) covariance: Vec<f64>,
    /// The evolution paths of the step size and of the covariance matrix.
    pub(super) sigma_path: Vec<f64>,
    pub(super) path: Vec<f64>,
    /// Generations since it began, or began anew; and how often it did.
    pub(super) generation: u64,
    pub(super) restarts: u64,
}

impl Curves {
    /// The loop begins again where it stands, with this as its best value.
    fn again(&mut self, best: Option<f64>) {
        let course = match self {
            Self::Chains(chains) => {
                chains.iteration = None;
                &mut chains.course
            }
            Self::Distribution(distribution) => &mut distribution.course,
            Self::Learning(learning) => &mut learning.course,
        };
        *course = Course { deviation: course.deviation, ..Course::new(course.direction, best) };
    }
}

impl Tuning {
    /// The same, to be gone on with as a loop of its own, and after something else if there is an aim.
    pub(super) fn again(&self, aim: Option<&Aim>) -> Self {
        let mut next = Self { tally: Tally::default(), ..self.clone() };
        if let (Some(aim), Some(found)) = (aim, &mut next.found) {
            found.value = aim.value(&found.each);
            // These are of what the moves before were after.
            (next.highest, next.offered) = (None, None);
        }
        if let Some(loops) = &mut next.loops {
            loops.again(self.found.as_ref().map(|found| found.value));
        }
        next
    }

    /// What each iteration of its learner came to; none where nothing learns.
    pub(super) fn learned(&self) -> Option<&[Learned]> {
        match &self.loops {
            Some(Curves::Learning(learning)) => Some(&learning.learned),
            Some(Curves::Chains(_) | Curves::Distribution(_)) | None => None,
        }
    }

    /// The temperature of the first chain; zero where nothing anneals.
    pub(super) fn temperature(&self) -> f64 {
        match &self.loops {
            Some(Curves::Chains(chains)) => {
                chains.chains.first().map_or(0.0, |chain| chain.standing.temperature)
            }
            _ => 0.0,
        }
    }
}

impl State {
    /// What the iterations of all learners came to so far, by the number of the task. Empty where nothing learns.
    #[must_use]
    pub fn learned(&self) -> Vec<(usize, &[Learned])> {
        let Some(trial) = &self.trial else {
            return self.learned.iter().map(|(task, all)| (*task, all.as_slice())).collect();
        };
        let tunings = trial.body.tunings.iter().chain([&trial.body.tuning]).enumerate();
        tunings.filter_map(|(task, tuning)| Some((task, tuning.learned()?))).collect()
    }

    /// Where a search starts that begins with a design.
    #[must_use]
    pub fn begin(first: Derivation) -> Self {
        Self::begin_with(first, Vec::new())
    }

    /// Where a search starts that begins with a design and its curves, by task; curves that are not there are drawn.
    #[must_use]
    pub fn begin_with(first: Derivation, curves: Vec<Parameters>) -> Self {
        let first = Arc::new(first);
        Self {
            spent: 0,
            moves: 0,
            bodies: 0,
            idle_moves: 0,
            tally: Tally::default(),
            hardest: Vec::new(),
            first: Incumbent { number: 0, derivation: Arc::clone(&first), value: None, tunes: Vec::new() },
            designs: None,
            earlier: VecDeque::new(),
            course: Course::default(),
            iteration: None,
            trial: Some(Trial {
                derivation: first,
                origin: Origin::default(),
                begun: 0,
                drawn: 0.0,
                warm: curves,
                further: None,
                aim: None,
                parent: Vec::new(),
                body: Body::default(),
            }),
            learned: Vec::new(),
            best: None,
        }
    }

    /// The best design so far.
    #[must_use]
    pub fn best(&self) -> Option<&Best> {
        self.best.as_ref()
    }

    /// The designs that no other is better than in every objective; none where no front is searched for.
    pub fn front(&self) -> impl Iterator<Item = &Best> {
        let front = match &self.designs {
            Some(Designs::Front(front)) => front.as_slice(),
            Some(Designs::Chains(_) | Designs::Archive(_) | Designs::Population(_)) | None => &[],
        };
        front.iter().map(|member| &member.best)
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
    /// Why a design cannot be made by these rules.
    pub fn restore(self, rules: &RuleSet) -> Result<State, BadStep> {
        self.map(&mut |steps| Derivation::restore(rules, &steps).map(Arc::new))
    }
}

impl<D> State<D> {
    /// The annealing chains; none where something else searches.
    pub(super) fn chains(&self) -> &[BodyChain<D>] {
        match &self.designs {
            Some(Designs::Chains(BodyChains { chains, .. })) => chains,
            Some(Designs::Archive(_) | Designs::Population(_) | Designs::Front(_)) | None => &[],
        }
    }

    /// The annealing, to change it.
    pub(super) fn annealing(&mut self) -> Option<&mut BodyChains<D>> {
        match &mut self.designs {
            Some(Designs::Chains(chains)) => Some(chains),
            Some(Designs::Archive(_) | Designs::Population(_) | Designs::Front(_)) | None => None,
        }
    }

    /// A chain, to change it.
    pub(super) fn chain(&mut self, number: usize) -> Option<&mut BodyChain<D>> {
        self.annealing()?.chains.get_mut(number)
    }

    /// The best of each kind, by cell; none where something else searches.
    #[must_use]
    pub fn archive(&self) -> &[(Vec<usize>, Best<D>)] {
        match &self.designs {
            Some(Designs::Archive(archive)) => archive,
            Some(Designs::Chains(_) | Designs::Population(_) | Designs::Front(_)) | None => &[],
        }
    }

    /// What a population or a front keeps; none where something else searches.
    pub(super) fn members(&self) -> &[Arc<Member<D>>] {
        match &self.designs {
            Some(Designs::Population(members)) => &members.kept,
            Some(Designs::Front(front)) => front,
            Some(Designs::Chains(_) | Designs::Archive(_)) | None => &[],
        }
    }

    fn map<T, E>(self, change: &mut impl FnMut(D) -> Result<T, E>) -> Result<State<T>, E>
    where
        D: Clone,
    {
        let Self { spent, moves, bodies, idle_moves, tally, hardest, course, iteration, learned, .. } = self;
        let first = self.first.map(change)?;
        let designs = match self.designs {
            Some(designs) => Some(designs.map(change)?),
            None => None,
        };
        let earlier: Result<_, E> = self.earlier.into_iter().map(|members| all(members, change)).collect();
        let earlier = earlier?;
        let trial = match self.trial {
            Some(Trial { derivation, origin, begun, drawn, warm, further, aim, parent, body }) => {
                let derivation = change(derivation)?;
                Some(Trial { derivation, origin, begun, drawn, warm, further, aim, parent, body })
            }
            None => None,
        };
        let best = match self.best {
            Some(best) => Some(best.map(change)?),
            None => None,
        };
        Ok(State {
            spent,
            moves,
            bodies,
            idle_moves,
            tally,
            hardest,
            first,
            designs,
            earlier,
            course,
            iteration,
            trial,
            learned,
            best,
        })
    }
}

impl<D: Clone> BodyChains<D> {
    /// So many chains at one design.
    pub(super) fn at(design: &Incumbent<D>, count: usize) -> Self {
        let chain = BodyChain { at: design.clone(), standing: Standing::default() };
        Self { chains: vec![chain; count], turn: 0, walk: Vec::new() }
    }
}

impl<D> Designs<D> {
    /// Gives the turn to the next chain; whether all have had theirs.
    pub(super) fn next_turn(&mut self) -> bool {
        let Self::Chains(BodyChains { chains, turn, .. }) = self else { return true };
        *turn = if *turn + 1 < chains.len() { *turn + 1 } else { 0 };
        *turn == 0
    }

    fn map<T, E>(self, change: &mut impl FnMut(D) -> Result<T, E>) -> Result<Designs<T>, E>
    where
        D: Clone,
    {
        Ok(match self {
            Self::Chains(BodyChains { chains, turn, walk }) => {
                let map = |BodyChain { at, standing }| Ok(BodyChain { at: at.map(change)?, standing });
                let chains: Result<Vec<_>, E> = chains.into_iter().map(map).collect();
                Designs::Chains(BodyChains { chains: chains?, turn, walk })
            }
            Self::Archive(archive) => {
                let map = |(cell, best): (Vec<usize>, Best<D>)| Ok((cell, best.map(change)?));
                let archive: Result<Vec<_>, E> = archive.into_iter().map(map).collect();
                Designs::Archive(archive?)
            }
            Self::Population(Members { kept, course }) => {
                Designs::Population(Members { kept: all(kept, change)?, course })
            }
            Self::Front(front) => Designs::Front(all(front, change)?),
        })
    }
}

/// All members with other derivations.
fn all<D: Clone, T, E>(
    members: Vec<Arc<Member<D>>>,
    change: &mut impl FnMut(D) -> Result<T, E>,
) -> Result<Vec<Arc<Member<T>>>, E> {
    let map = |member| {
        let Member { best, tuned } = Arc::unwrap_or_clone(member);
        Ok(Arc::new(Member { best: best.map(change)?, tuned }))
    };
    members.into_iter().map(map).collect()
}

impl<D> Incumbent<D> {
    fn map<T, E>(self, change: &mut impl FnMut(D) -> Result<T, E>) -> Result<Incumbent<T>, E> {
        let Self { number, derivation, value, tunes } = self;
        Ok(Incumbent { number, derivation: change(derivation)?, value, tunes })
    }
}

impl<D> Best<D> {
    fn map<T, E>(self, change: &mut impl FnMut(D) -> Result<T, E>) -> Result<Best<T>, E> {
        let Self { derivation, tasks, value, beside, found_at } = self;
        Ok(Best { derivation: change(derivation)?, tasks, value, beside, found_at })
    }
}
