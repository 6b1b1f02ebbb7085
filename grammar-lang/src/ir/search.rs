//! Searches: the loops that they have, and by what each searches.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::text::{Names, Writer};
use super::{ActorCritic, Expr, Learner, QLearning, SearchWord, Within};

/// A search, by the loops that it has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Search {
    /// Its name.
    pub name: String,
    /// What a new best must keep of its value when simulated more finely.
    pub keep: f64,
    /// What it must keep when rows that bend are simulated as elastic rods; not simulated so if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep_with_rods: Option<f64>,
    /// The worlds that the best of a run is tried in at its end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub checks: Option<Within>,
    /// The loop over bodies, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bodies: Option<BodyLoop>,
    /// The loop over curves of one body, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub curves: Option<CurveLoop>,
}

/// How bodies are searched for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyLoop {
    /// How long.
    pub schedule: Schedule,
    /// By what.
    pub method: BodyMethod,
}

/// What searches for bodies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum BodyMethod {
    /// Simulated annealing.
    Annealing(Annealing),
    /// The best of each kind.
    Archive(Archive),
    /// The best of all, so many of them.
    Population(Population),
    /// Those that no other is better than in every objective.
    Front(Front),
}

/// How curves of a body are searched for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveLoop {
    /// How long.
    pub schedule: Schedule,
    /// Whether curves start from those of the body that this one was made of.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub warm: bool,
    /// Which curves are judged in all worlds of a task, if it is said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub judge: Option<Judge>,
    /// By what.
    pub method: CurveMethod,
}

/// Which curves are judged in all worlds that the objective of a task runs over. The others have their value in the
/// nominal world only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Judge {
    /// All of them, but for those that the worst case excludes already.
    Every,
    /// Those that are better in the nominal world than the best so far is in all.
    Promising,
    /// The best of late, if it is better in the nominal world than the best so far is in all.
    Best,
}

impl Judge {
    /// All of them, as they are listed to people.
    pub const ALL: [Self; 3] = [Self::Every, Self::Promising, Self::Best];

    /// What a grammar calls it.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Every => "every",
            Self::Promising => "promising",
            Self::Best => "best",
        }
    }
}

/// What searches for curves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum CurveMethod {
    /// Simulated annealing.
    Annealing(Annealing),
    /// Evolution of a normal distribution.
    CmaEs(CmaEs),
    /// Learning by an actor and its critics.
    ActorCritic(ActorCritic),
    /// Learning what decisions are worth.
    QLearning(QLearning),
}

impl CurveMethod {
    /// What its learner is told, if it learns.
    #[must_use]
    pub fn learner(&self) -> Option<&Learner> {
        match self {
            Self::ActorCritic(own) => Some(&own.learner),
            Self::QLearning(own) => Some(&own.learner),
            Self::Annealing(_) | Self::CmaEs(_) => None,
        }
    }
}

/// How long a loop goes on: expressions of the search stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// Greatest number of iterations.
    pub iterations: Expr,
    /// Moves in an iteration, of each chain; samples of a generation.
    pub moves: Expr,
    /// Whether to stop, asked after each iteration.
    pub stop: Expr,
}

/// Simulated annealing by one chain or several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Annealing {
    /// The temperature of an iteration, of the search stage.
    pub temperature: Expr,
    /// How many moves a random walk makes before, whose values `deviation` tells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub walk: Option<usize>,
    /// How many chains go on side by side, if not one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chains: Option<usize>,
    /// Whether neighbouring chains may change places, asked after each iteration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exchange: Option<Box<Expr>>,
}

/// Covariance matrix adaptation (Hansen 2016): a normal distribution of curves that follows the better half of
/// its samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CmaEs {
    /// The first standard deviation, as a share of each value's range.
    pub spread: f64,
    /// Whether to begin anew elsewhere, asked after each iteration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restart: Option<Expr>,
}

/// The best design of each kind is kept, and each move changes one of those (MAP-Elites, Mouret and Clune 2015).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Archive {
    /// What tells kinds apart, by name.
    pub descriptors: IndexMap<String, Descriptor>,
}

/// So many different designs are kept, the best. Each move changes one of them, or tunes its curves further.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Population {
    /// How they are kept and chosen.
    pub selection: Selection,
    /// Whether to begin anew with the initial design, asked after each iteration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restart: Option<Expr>,
}

/// The designs are kept that no other is better than in every objective (the Pareto front). Each move weighs the objectives
/// anew, changes a design that is good by these weights, or tunes its curves further.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Front {
    /// How they are kept and chosen.
    pub selection: Selection,
}

/// How designs are kept, and chosen to go on from: expressions of the search stage, asked for each move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Selection {
    /// How many are kept at most.
    pub size: Expr,
    /// A move takes the best of so many that are drawn.
    pub tournament: Expr,
    /// The share of moves that tune curves further.
    pub further: Expr,
    /// How many moves go on side by side, if not one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side_by_side: Option<usize>,
}

/// A quantity that tells kinds of designs apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Descriptor {
    /// A quantity of the score stage, of the motion of the first task.
    pub value: Expr,
    /// Where the first cell begins, in SI units; what is less belongs to it, too.
    pub from: f64,
    /// Where the last cell ends, in SI units; what is more belongs to it, too.
    pub to: f64,
    /// How many cells there are.
    pub cells: usize,
}

/// A method of a loop, whichever loop it is of.
#[derive(Clone, Copy, Debug)]
pub enum SearchMethod<'a> {
    /// Simulated annealing.
    Annealing(&'a Annealing),
    /// The best of each kind.
    Archive(&'a Archive),
    /// The best of all.
    Population(&'a Population),
    /// What no other is better than.
    Front(&'a Front),
    /// Evolution of a normal distribution.
    CmaEs(&'a CmaEs),
    /// Learning by an actor and its critics.
    ActorCritic(&'a ActorCritic),
    /// Learning what decisions are worth.
    QLearning(&'a QLearning),
}

impl BodyLoop {
    /// Its method among all.
    #[must_use]
    pub fn method(&self) -> SearchMethod<'_> {
        match &self.method {
            BodyMethod::Annealing(annealing) => SearchMethod::Annealing(annealing),
            BodyMethod::Archive(archive) => SearchMethod::Archive(archive),
            BodyMethod::Population(population) => SearchMethod::Population(population),
            BodyMethod::Front(front) => SearchMethod::Front(front),
        }
    }
}

impl CurveLoop {
    /// Which curves are judged in all worlds. Unless it is said, what proved best (`docs/experiments.md`).
    #[must_use]
    pub fn judge(&self) -> Judge {
        self.judge.unwrap_or(Judge::Best)
    }

    /// Its method among all.
    #[must_use]
    pub fn method(&self) -> SearchMethod<'_> {
        match &self.method {
            CurveMethod::Annealing(annealing) => SearchMethod::Annealing(annealing),
            CurveMethod::CmaEs(cma_es) => SearchMethod::CmaEs(cma_es),
            CurveMethod::ActorCritic(learner) => SearchMethod::ActorCritic(learner),
            CurveMethod::QLearning(learner) => SearchMethod::QLearning(learner),
        }
    }
}

impl<'a> SearchMethod<'a> {
    /// Its name in texts.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Annealing(_) => "annealing",
            Self::Archive(_) => "archive",
            Self::Population(_) => "population",
            Self::Front(_) => "front",
            Self::CmaEs(_) => "cma_es",
            Self::ActorCritic(_) => "soft_actor_critic",
            Self::QLearning(_) => "double_dqn",
        }
    }

    /// What is said of it where its fields are not shown.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::Annealing(_) => "annealing",
            Self::Archive(_) => "the best design of each kind is kept",
            Self::Population(_) => "the best bodies are kept and changed further",
            Self::Front(_) => "the designs that no other design beats in every objective are kept",
            Self::CmaEs(_) => "evolution of a normal distribution (CMA-ES)",
            Self::ActorCritic(_) => "soft actor-critic learning of a policy",
            Self::QLearning(_) => "double Q-learning of a policy",
        }
    }

    /// Its temperature, if it has one: what is worse by no more may take the place of what is better.
    #[must_use]
    pub fn temperature(self) -> Option<&'a Expr> {
        match self {
            Self::Annealing(annealing) => Some(&annealing.temperature),
            Self::Archive(_) | Self::Population(_) | Self::Front(_) => None,
            Self::CmaEs(_) | Self::ActorCritic(_) | Self::QLearning(_) => None,
        }
    }

    /// How many states it has side by side.
    #[must_use]
    pub fn chains(self) -> usize {
        match self {
            Self::Annealing(annealing) => annealing.chains.unwrap_or(1),
            Self::Archive(_) | Self::Population(_) | Self::Front(_) => 1,
            Self::CmaEs(_) | Self::ActorCritic(_) | Self::QLearning(_) => 1,
        }
    }

    /// Whether a word of the search stage has a value with it.
    #[must_use]
    pub fn has(self, word: SearchWord) -> bool {
        match word {
            SearchWord::Deviation => matches!(self, Self::Annealing(annealing) if annealing.walk.is_some()),
            SearchWord::Spread => matches!(self, Self::CmaEs(_)),
            SearchWord::Temperature | SearchWord::Chain => matches!(self, Self::Annealing(_)),
            SearchWord::Iteration
            | SearchWord::Best
            | SearchWord::Idle
            | SearchWord::Refused
            | SearchWord::Stagnant
            | SearchWord::Tuned
            | SearchWord::Parent
            | SearchWord::Spent => true,
        }
    }

    /// Its own fields that are given, as text; the temperature stands among those that all loops have.
    fn given(self, show: &dyn Fn(&Expr) -> String) -> Vec<(&'static str, String)> {
        let fields = match self {
            Self::Annealing(annealing) => vec![
                ("walk", annealing.walk.map(|n| n.to_string())),
                ("chains", annealing.chains.map(|n| n.to_string())),
                ("exchange", annealing.exchange.as_deref().map(show)),
            ],
            Self::CmaEs(cma_es) => vec![
                ("spread", Some(cma_es.spread.to_string())),
                ("restart", cma_es.restart.as_ref().map(show)),
            ],
            Self::Population(population) => {
                let mut fields = population.selection.given(show);
                fields.push(("restart", population.restart.as_ref().map(show)));
                fields
            }
            Self::Front(front) => front.selection.given(show),
            Self::Archive(_) => Vec::new(),
            Self::ActorCritic(ActorCritic { learner, critic, entropy }) => {
                let critic: Vec<_> = critic.iter().map(ToString::to_string).collect();
                let own = [("critic", format!("[{}]", critic.join(", "))), ("entropy", entropy.to_string())];
                let own = own.map(|(name, value)| (name, Some(value)));
                own.into_iter().chain(learner.given()).collect()
            }
            Self::QLearning(QLearning { learner, exploration }) => {
                let own = [("exploration", Some(show(exploration)))];
                own.into_iter().chain(learner.given()).collect()
            }
        };
        fields.into_iter().filter_map(|(field, value)| Some((field, value?))).collect()
    }

    /// Its expressions of the search stage.
    pub fn scheduled(self) -> impl Iterator<Item = &'a Expr> {
        let own = match self {
            Self::Annealing(annealing) => vec![Some(&annealing.temperature), annealing.exchange.as_deref()],
            Self::CmaEs(cma_es) => vec![cma_es.restart.as_ref()],
            Self::Population(population) => {
                let restart = population.restart.as_ref();
                population.selection.exprs().into_iter().map(Some).chain([restart]).collect()
            }
            Self::Front(front) => front.selection.exprs().map(Some).to_vec(),
            Self::QLearning(learner) => vec![Some(&learner.exploration)],
            Self::Archive(_) | Self::ActorCritic(_) => Vec::new(),
        };
        own.into_iter().flatten()
    }
}

/// What a field of a selection may be.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// The field.
    pub name: &'static str,
    /// The least.
    pub low: f64,
    /// The most.
    pub high: f64,
    /// What it may look like.
    pub example: &'static str,
}

impl Limit {
    /// A value as people write it.
    fn shown(self, value: f64) -> String {
        if self.name == "further" { format!("{} %", 100.0 * value) } else { value.to_string() }
    }

    /// Why values from a low to a high are not possible at all, if they are not.
    #[must_use]
    pub fn excludes(self, low: f64, high: f64) -> Option<String> {
        let Self { name, low: least, high: most, .. } = self;
        let is_beyond = high < least || low > most;
        is_beyond.then(|| format!("`{name}` must lie within {} .. {}", self.shown(least), self.shown(most)))
    }
}

/// More bodies or draws than this are a slip of the keyboard.
const MOST: f64 = 10_000.0;
/// More designs on a front nobody looks at, and it takes long to say which of them is missed least.
pub const MOST_ON_FRONT: usize = 100;
/// Some moves must change bodies: a population that is only tuned further is no search for bodies.
const MOST_FURTHER: f64 = 0.99;

impl Selection {
    /// What the fields may be, in the order of [`Selection::exprs`].
    #[must_use]
    pub fn limits(is_front: bool) -> [Limit; 3] {
        let most = if is_front { MOST_ON_FRONT as f64 } else { MOST };
        let further = if is_front { 1.0 } else { MOST_FURTHER };
        [
            Limit { name: "size", low: 2.0, high: most, example: "16" },
            Limit { name: "tournament", low: 1.0, high: MOST, example: "2" },
            Limit { name: "further", low: 0.0, high: further, example: "30 %" },
        ]
    }

    /// Its expressions.
    #[must_use]
    pub fn exprs(&self) -> [&Expr; 3] {
        [&self.size, &self.tournament, &self.further]
    }

    /// How many moves go on side by side: each begins with what was kept before the first of them.
    #[must_use]
    pub fn side_by_side(&self) -> usize {
        self.side_by_side.unwrap_or(1)
    }

    /// Its fields as text.
    fn given(&self, show: &dyn Fn(&Expr) -> String) -> Vec<(&'static str, Option<String>)> {
        let names = ["size", "tournament", "further"];
        let own = names.into_iter().zip(self.exprs().map(|expr| Some(show(expr))));
        own.chain([("side_by_side", self.side_by_side.map(|n| n.to_string()))]).collect()
    }
}

impl Schedule {
    /// Its expressions.
    pub fn exprs(&self) -> [&Expr; 3] {
        [&self.iterations, &self.moves, &self.stop]
    }
}

impl<'s> SearchMethod<'s> {
    /// When a search by covariance matrix adaptation begins anew, and the first spread of its distribution.
    #[must_use]
    pub fn restart_and_spread(self) -> Option<(&'s Expr, f64)> {
        match self {
            Self::CmaEs(method) => Some((method.restart.as_ref()?, method.spread)),
            _ => None,
        }
    }
}

impl Search {
    /// Its loops: the schedule and the method of each.
    pub fn loops(&self) -> impl Iterator<Item = (&Schedule, SearchMethod<'_>)> {
        let bodies = self.bodies.iter().map(|bodies| (&bodies.schedule, bodies.method()));
        bodies.chain(self.curves.iter().map(|curves| (&curves.schedule, curves.method())))
    }

    /// The archive of kinds, where bodies are searched for by one.
    #[must_use]
    pub fn archive(&self) -> Option<&Archive> {
        match &self.bodies.as_ref()?.method {
            BodyMethod::Archive(archive) => Some(archive),
            BodyMethod::Annealing(_) | BodyMethod::Population(_) | BodyMethod::Front(_) => None,
        }
    }

    /// The population, where bodies are searched for by one.
    #[must_use]
    pub fn population(&self) -> Option<&Population> {
        match &self.bodies.as_ref()?.method {
            BodyMethod::Population(population) => Some(population),
            BodyMethod::Annealing(_) | BodyMethod::Archive(_) | BodyMethod::Front(_) => None,
        }
    }

    /// The front, where bodies are searched for by one.
    #[must_use]
    pub fn front(&self) -> Option<&Front> {
        match &self.bodies.as_ref()?.method {
            BodyMethod::Front(front) => Some(front),
            BodyMethod::Annealing(_) | BodyMethod::Archive(_) | BodyMethod::Population(_) => None,
        }
    }

    /// How a population or a front keeps and chooses designs.
    #[must_use]
    pub fn selection(&self) -> Option<&Selection> {
        match &self.bodies.as_ref()?.method {
            BodyMethod::Population(population) => Some(&population.selection),
            BodyMethod::Front(front) => Some(&front.selection),
            BodyMethod::Annealing(_) | BodyMethod::Archive(_) => None,
        }
    }

    /// How bodies are annealed, where they are.
    #[must_use]
    pub fn annealing(&self) -> Option<&Annealing> {
        match &self.bodies.as_ref()?.method {
            BodyMethod::Annealing(annealing) => Some(annealing),
            BodyMethod::Archive(_) | BodyMethod::Population(_) | BodyMethod::Front(_) => None,
        }
    }

    /// Whether curves start from those of the body that this one was made of.
    #[must_use]
    pub fn is_warm(&self) -> bool {
        self.curves.as_ref().is_some_and(|curves| curves.warm)
    }
}

impl Writer<'_> {
    pub(super) fn search(&mut self, search: &Search, from: Option<&str>) {
        let from = from.map_or(String::new(), |from| format!(" from {from}"));
        self.line(0, format!("search {}{from} {{", search.name));
        self.line(1, format!("keep = {}", search.keep));
        if let Some(keep) = search.keep_with_rods {
            self.line(1, format!("keep_with_rods = {keep}"));
        }
        if let Some(checks) = &search.checks {
            self.line(1, format!("checks = {}", checks.name));
        }
        if let Some(bodies) = &search.bodies {
            self.searched("bodies", &bodies.schedule, bodies.method(), &[]);
        }
        if let Some(curves) = &search.curves {
            let warm = curves.warm.then_some(("warm", "true"));
            let judge = curves.judge.map(|judge| ("judge", judge.text()));
            let own: Vec<_> = warm.into_iter().chain(judge).collect();
            self.searched("curves", &curves.schedule, curves.method(), &own);
        }
        self.line(0, "}");
    }

    /// A loop of a search.
    fn searched(
        &mut self,
        name: &str,
        schedule: &Schedule,
        method: SearchMethod<'_>,
        own: &[(&'static str, &str)],
    ) {
        self.line(1, format!("{name} {} {{", method.name()));
        let show = |value: &Expr| self.expr(value, &Names::new());
        let mut given = method.given(&show);
        given.extend(own.iter().map(|(field, value)| (*field, (*value).to_owned())));
        given.push(("iterations", show(&schedule.iterations)));
        given.push(("moves", show(&schedule.moves)));
        given.extend(method.temperature().map(|temperature| ("temperature", show(temperature))));
        given.push(("stop", show(&schedule.stop)));
        let mut lines: Vec<String> =
            given.into_iter().map(|(field, value)| format!("{field} = {value}")).collect();
        if let SearchMethod::Archive(Archive { descriptors }) = method {
            lines.extend(descriptors.iter().map(|(name, kind)| self.descriptor(name, kind)));
        }
        for line in lines {
            self.line(2, line);
        }
        self.line(1, "}");
    }

    fn descriptor(&self, name: &str, kind: &Descriptor) -> String {
        let scale = |x: f64| self.constant(x, &kind.value.ty);
        let (value, from, to) = (self.expr(&kind.value, &Names::new()), scale(kind.from), scale(kind.to));
        let cells = kind.cells;
        format!("descriptor {name} {{ value = {value}, from = {from}, to = {to}, cells = {cells} }}")
    }
}
