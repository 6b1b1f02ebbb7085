//! Learning: a policy is explored in some motions, its network learns from all that are remembered, and the policy without its noise is
//! judged by the objective, as curves are.

use grammar_lang::ir::{ActionSpace, ActorCritic, CurveMethod, Learner, QLearning, Schedule};

use super::super::Failure;
use super::super::evaluated::Evaluated;
use super::super::learned::Learned;
use super::super::schedule::{Course, Iteration, Plan, Stand};
use super::super::state::{Agent, Learning, Tuning};
use super::super::tally::Missing;
use super::judging::{Counted, When};
use super::{Progress, Tuner, best};
use crate::derive::Candidate;
use crate::derive::random::Stream;
use crate::drive::{Decision, Explorer, Parameters};
use crate::learn::{self, ActorCriticSettings, Episode, Rates, Replay};

/// Actions at the very ends of a range have no finite value before `tanh`.
const NEAR_THE_END: f64 = 0.999;
/// More motions than this of one iteration are not kept in memory at once.
const MOST: usize = 1000;

/// What is remembered of a motion: an episode for each side of the robot.
type Sides = Vec<Episode>;

/// What learns.
#[derive(Clone, Copy)]
pub(super) enum Method<'r> {
    ActorCritic(&'r ActorCritic),
    QLearning(&'r QLearning),
}

impl<'r> Method<'r> {
    /// The learner that a loop over curves has, if it has one.
    pub(super) fn of(method: &'r CurveMethod) -> Option<Self> {
        match method {
            CurveMethod::ActorCritic(own) => Some(Self::ActorCritic(own)),
            CurveMethod::QLearning(own) => Some(Self::QLearning(own)),
            CurveMethod::Annealing(_) | CurveMethod::CmaEs(_) => None,
        }
    }

    fn learner(self) -> &'r Learner {
        match self {
            Self::ActorCritic(own) => &own.learner,
            Self::QLearning(own) => &own.learner,
        }
    }

    fn rates(self) -> Rates {
        let Learner { learning_rate, discount, batch, target_rate, .. } = self.learner();
        Rates {
            learning_rate: *learning_rate as f32,
            discount: *discount as f32,
            batch: *batch,
            target_rate: *target_rate as f32,
        }
    }

    /// Networks for what a policy decides.
    fn agent(self, decision: &Decision<'_>, random: &mut Stream) -> Agent {
        let hidden = &decision.policy.hidden;
        match self {
            Self::ActorCritic(own) => {
                let actions = decision.spaces.len();
                let agent =
                    learn::ActorCritic::new(decision.known.len(), hidden, actions, &own.critic, random);
                Agent::ActorCritic(Box::new(agent))
            }
            Self::QLearning(_) => {
                let values = decision.spaces.iter().map(|space| space.outputs()).collect();
                Agent::QLearning(Box::new(learn::QLearning::new(
                    decision.known.len(),
                    hidden,
                    values,
                    random,
                )))
            }
        }
    }
}

impl Agent {
    /// The weights of its policy.
    fn policy(&self) -> Parameters {
        match self {
            Self::ActorCritic(agent) => agent.policy(),
            Self::QLearning(agent) => agent.policy(),
        }
    }

    fn begin_with(&mut self, policy: &Parameters) {
        match self {
            Self::ActorCritic(agent) => agent.begin_with(policy),
            Self::QLearning(agent) => agent.begin_with(policy),
        }
    }

    fn learn(&mut self, method: Method<'_>, replay: &Replay, ends: &[usize], random: &mut Stream) {
        let rates = method.rates();
        match (self, method) {
            (Self::ActorCritic(agent), Method::ActorCritic(own)) => {
                let settings = ActorCriticSettings { rates, entropy: own.entropy as f32 };
                agent.learn(replay, ends, settings, random);
            }
            (Self::QLearning(agent), Method::QLearning(_)) => {
                agent.learn(replay, ends, rates, random);
            }
            // An agent is begun with the method that it goes on with.
            (Self::ActorCritic(_), Method::QLearning(_)) | (Self::QLearning(_), Method::ActorCritic(_)) => {}
        }
    }

    fn is_sound(&self) -> bool {
        match self {
            Self::ActorCritic(agent) => agent.is_sound(),
            Self::QLearning(agent) => agent.is_sound(),
        }
    }
}

/// One motion that explores, and what is remembered of it: an episode for each side of the robot.
#[derive(Debug)]
struct Exploring<'a> {
    agent: &'a Agent,
    /// How many values each action has; nothing for a range.
    values: Vec<Option<usize>>,
    /// How likely an action is drawn evenly.
    chance: f64,
    random: Stream,
    episodes: Sides,
}

impl Explorer for Exploring<'_> {
    fn gain(&mut self, reward: f64) {
        self.episodes.iter_mut().for_each(|episode| episode.gained.push(reward as f32));
    }

    fn decide(&mut self, side: usize, known: &[f64]) -> Vec<f64> {
        let Some(episode) = self.episodes.get_mut(side) else { return Vec::new() };
        let known: Vec<f32> = known.iter().map(|x| *x as f32).collect();
        let outputs = match self.agent {
            Agent::ActorCritic(agent) => {
                // Before it learns anything, it draws evenly.
                let outputs: Vec<f64> = if self.chance >= 1.0 {
                    let even = |_| libm::atanh(NEAR_THE_END * (2.0 * self.random.unit() - 1.0));
                    self.values.iter().map(even).collect()
                } else {
                    agent.explore(&known, &mut self.random).into_iter().map(f64::from).collect()
                };
                episode.done.extend(outputs.iter().map(|output| libm::tanh(*output) as f32));
                outputs
            }
            Agent::QLearning(agent) => {
                let places = agent.explore(&known, self.chance, &mut self.random);
                episode.done.extend(places.iter().map(|place| *place as f32));
                // The greatest output of an action is the one that is taken.
                let one = |(place, count): (&usize, &Option<usize>)| {
                    let place = *place;
                    (0..count.unwrap_or(0)).map(move |i| f64::from(u8::from(i == place)))
                };
                places.iter().zip(&self.values).flat_map(one).collect()
            }
        };
        episode.known.extend(known);
        outputs
    }
}

impl Exploring<'_> {
    /// What is remembered: nothing was gained yet by the last decision.
    fn remembered(mut self) -> Sides {
        let actions = self.values.len();
        self.episodes.iter_mut().for_each(|episode| episode.done.truncate(episode.gained.len() * actions));
        self.episodes
    }
}

impl Tuner<'_> {
    /// A learner that has made nothing yet, and the weights that it begins with.
    pub(super) fn learner(&self, method: Method<'_>) -> Option<(Agent, Parameters)> {
        let decision = self.evaluator.drive.decision()?;
        let mut agent = method.agent(&decision, &mut self.stream("learner"));
        if let Some(warm) = &self.warm {
            agent.begin_with(&warm.curves);
        }
        let policy = agent.policy();
        Some((agent, policy))
    }

    /// Goes on by an iteration: explores, learns, and judges what was learned.
    pub(super) fn learn(
        &mut self,
        schedule: &Schedule,
        method: Method<'_>,
        tuning: &mut Tuning,
        state: &mut Learning,
        spent: &mut u64,
    ) -> Result<Progress, Failure> {
        if let Some(end) = self.bounds.exhausted(*spent) {
            return Ok(Progress::Cut(end));
        }
        self.spent = self.bounds.share(*spent);
        let Some(Iteration { moves, .. }) = self.plan_to_learn(schedule, &state.course).begin()? else {
            let is_judged = self.judge_offered(tuning, spent, When::AtTheEnd)?;
            return if is_judged { Ok(Progress::Done) } else { self.stopped() };
        };
        let chance = self.chance(schedule, method, state)?;
        // Nothing is simulated that could not be counted.
        let motions = moves.min(MOST).min(self.bounds.left(*spent));
        let in_worlds = method.learner().worlds;
        let Some(explored) = self.explore(state, motions, (chance, in_worlds))? else {
            return self.stopped();
        };
        // An iteration is made whole or not at all.
        let (mut now, mut counted, mut next) = (tuning.clone(), *spent, state.clone());
        let mut made = 0;
        let mut rewards = Vec::new();
        for episode in explored {
            counted += 1;
            next.motions += 1;
            match episode {
                Ok(episodes) => {
                    // All sides gain the same.
                    let gained = episodes.first().map_or(&[][..], |episode| &episode.gained);
                    made += gained.len();
                    rewards.push(gained.iter().map(|reward| f64::from(*reward)).sum::<f64>());
                    episodes.into_iter().for_each(|one| next.replay.add(one, method.learner().replay));
                }
                Err(Missing::Expression(error)) if state.motions == 0 => return Err(error.into()),
                Err(why) => now.tally.count(why),
            }
        }
        if next.motions > method.learner().warm_up as u64 && !self.study(method, &mut next, made) {
            return self.stopped();
        }
        if !next.agent.is_sound() {
            now.tally.count(Missing::Diverged);
            if !self.judge_offered(&mut now, &mut counted, When::AtTheEnd)? {
                return self.stopped();
            }
            (*tuning, *spent) = (now, counted);
            return Ok(Progress::Done);
        }
        if let Some(end) = self.bounds.exhausted(counted) {
            if !end.is_early() {
                (*tuning, *spent, *state) = (now, counted, next);
            }
            return Ok(Progress::Cut(end));
        }
        let policy = next.agent.policy();
        let judged = self.evaluator.evaluate(self.bounds.stop, std::slice::from_ref(&policy));
        let Some(judged) = judged else { return self.stopped() };
        let value = judged.first().and_then(|evaluated| evaluated.value.as_ref().ok().copied());
        for evaluated in judged {
            let Evaluated { each, .. } = &evaluated;
            let each = each.clone();
            match self.count(&mut now, &policy, evaluated, &mut counted)? {
                Counted::Stopped => return self.stopped(),
                counted => {
                    counted.fitness().into_iter().for_each(|new| self.offer(&mut now, &policy, new, &each));
                }
            }
        }
        if !self.judge_offered(&mut now, &mut counted, When::Underway)? {
            return self.stopped();
        }
        next.course.complete(best(&now));
        self.spent = self.bounds.share(counted);
        let is_over = self.plan_to_learn(schedule, &next.course).stops()?;
        if is_over && !self.judge_offered(&mut now, &mut counted, When::AtTheEnd)? {
            return self.stopped();
        }
        next.learned.push(Learned {
            evaluations: counted,
            motions: next.motions,
            reward: (!rewards.is_empty()).then(|| rewards.iter().sum::<f64>() / rewards.len() as f64),
            exploration: chance,
            value,
            best: best(&now),
        });
        (*tuning, *spent, *state) = (now, counted, next);
        Ok(if is_over { Progress::Done } else { Progress::More })
    }

    /// How likely an action is drawn evenly in the iteration that begins.
    fn chance(&self, schedule: &Schedule, method: Method<'_>, state: &Learning) -> Result<f64, Failure> {
        if state.motions < method.learner().warm_up as u64 {
            return Ok(1.0);
        }
        Ok(match method {
            Method::ActorCritic(_) => 0.0,
            Method::QLearning(own) => {
                self.plan_to_learn(schedule, &state.course).exploration(&own.exploration)?
            }
        })
    }

    /// Makes motions in which the policy is explored. None if it was asked to stop before all were made.
    fn explore(
        &mut self,
        state: &Learning,
        motions: usize,
        (chance, in_worlds): (f64, bool),
    ) -> Result<Option<Vec<Result<Sides, Missing>>>, Failure> {
        let Some(decision) = self.evaluator.drive.decision() else { return Ok(Some(Vec::new())) };
        let values = |space: &&ActionSpace| match space {
            ActionSpace::Continuous(..) => None,
            ActionSpace::Discrete(values) => Some(values.len()),
        };
        let values: Vec<Option<usize>> = decision.spaces.iter().map(values).collect();
        let exploring = |number: usize| Exploring {
            agent: &state.agent,
            values: values.clone(),
            chance,
            random: self.stream(&format!("motion {}", state.motions + number as u64)),
            episodes: vec![Episode::default(); decision.sides],
        };
        let mut all: Vec<Exploring<'_>> = (0..motions).map(exploring).collect();
        let policy = state.agent.policy();
        let mut explorers: Vec<&mut dyn Explorer> = Vec::with_capacity(motions);
        explorers.extend(all.iter_mut().map(|one| one as &mut dyn Explorer));
        let Some(came_to) =
            self.evaluator.explore(self.bounds.stop, &policy, (state.motions, in_worlds), explorers)?
        else {
            return Ok(None);
        };
        let remembered = all.into_iter().map(Exploring::remembered);
        Ok(Some(
            came_to.into_iter().zip(remembered).map(|(came_to, episode)| came_to.map(|()| episode)).collect(),
        ))
    }

    /// Learns from what is remembered, so many steps as go with the decisions that were made. Whether it was not stopped.
    fn study(&self, method: Method<'_>, next: &mut Learning, made: usize) -> bool {
        let ends = next.replay.ends();
        if ends.is_empty() {
            return true;
        }
        let mut random = self.stream(&format!("learning after {}", next.motions));
        let steps = libm::round(made as f64 * method.learner().updates) as usize;
        let Learning { agent, replay, .. } = next;
        let bounds = self.bounds;
        self.evaluator.crew().run(|| {
            for _ in 0..steps {
                if bounds.stopped().is_some() {
                    return false;
                }
                agent.learn(method, replay, &ends, &mut random);
            }
            true
        })
    }

    fn plan_to_learn<'p>(&'p self, schedule: &'p Schedule, course: &'p Course) -> Plan<'p> {
        let Candidate { rules, derivation, .. } = self.candidate();
        Plan { rules, derivation, schedule, course, stand: Stand::Bodies, around: self.around() }
    }
}

impl Learning {
    /// A learner that has made nothing yet.
    pub(super) fn begin(agent: Agent, course: Course) -> Self {
        Self { course, agent, replay: Replay::default(), motions: 0, learned: Vec::new() }
    }
}
