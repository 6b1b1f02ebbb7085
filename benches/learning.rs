//! How long a step of a learner takes, beside the simulation of the decisions that it learns from.
//!
//! `cargo bench --bench learning` (add `-- 9` for nine rounds instead of three). Times are of the processor, of all threads, least of
//! the rounds; both learners and the simulation take turns. On an idle machine, please.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout, missing_docs)]

use std::sync::Arc;
use std::time::Duration;

use cpu_time::ProcessTime;
use grammar_lang::source::SourceMap;
use sgc::derive::random::Stream;
use sgc::derive::{Candidate, Derivation};
use sgc::drive::Drive;
use sgc::learn::{ActorCritic, ActorCriticSettings, Episode, QLearning, Rates, Replay};
use sgc::loader::Files;
use sgc::search::settings;
use sgc::simulate::{Stop, World, model};

/// What a walker of two actuators knows, and what it decides.
const INPUTS: usize = 17;
const ACTIONS: usize = 2;
/// Values of an action of Q-learning.
const VALUES: usize = 3;
/// Decisions of a motion of 20 s, three a second.
const DECISIONS: usize = 60;
const HIDDEN: &[usize] = &[64, 64];
const RATES: Rates = Rates { learning_rate: 0.003, discount: 0.98, batch: 256, target_rate: 0.005 };
const STEPS: u32 = 200;
const MOTIONS: u32 = 20;

fn main() {
    let rounds = std::env::args().filter_map(|a| a.parse().ok()).next().unwrap_or(3);
    let mut random = Stream::named(1, "bench");
    let mut actor = ActorCritic::new(INPUTS, HIDDEN, ACTIONS, HIDDEN, &mut random);
    let mut values = QLearning::new(INPUTS, HIDDEN, vec![VALUES; ACTIONS], &mut random);
    let (of_actor, of_values) = (replay(1.0, &mut random), replay(VALUES as f64, &mut random));
    let mut least = [Duration::MAX; 3];
    for _ in 0..rounds {
        let ends = of_values.ends();
        least[0] = least[0].min(timed(|| {
            for _ in 0..STEPS {
                values.learn(&of_values, &ends, RATES, &mut random);
            }
        }));
        let ends = of_actor.ends();
        least[1] = least[1].min(timed(|| {
            for _ in 0..STEPS {
                actor.learn(
                    &of_actor,
                    &ends,
                    ActorCriticSettings { rates: RATES, entropy: -1.0 },
                    &mut random,
                );
            }
        }));
        least[2] = least[2].min(timed(simulate));
    }
    let ms = |time: Duration, count: u32| 1e3 * time.as_secs_f64() / f64::from(count);
    println!(
        "a step of double Q-learning, one network of 64 x 64, a batch of 256: {:.2} ms",
        ms(least[0], STEPS)
    );
    println!(
        "a step of soft actor-critic, an actor and two critics of 64 x 64:    {:.2} ms",
        ms(least[1], STEPS)
    );
    println!(
        "the simulation of one decision of a leg on a body, in motions of 20 s: {:.2} ms",
        ms(least[2], MOTIONS * DECISIONS as u32)
    );
}

fn timed(work: impl FnOnce()) -> Duration {
    let begun = ProcessTime::now();
    work();
    begun.elapsed()
}

/// A hundred motions of random numbers; actions lie below `most`.
fn replay(most: f64, random: &mut Stream) -> Replay {
    let mut replay = Replay::default();
    for _ in 0..100 {
        let known = (0..(DECISIONS + 1) * INPUTS).map(|_| random.normal(0.0, 1.0) as f32).collect();
        let done = (0..DECISIONS * ACTIONS).map(|_| libm::floor(most * random.unit()) as f32).collect();
        let gained = (0..DECISIONS).map(|_| random.unit() as f32).collect();
        replay.add(Episode { known, done, gained }, 100_000);
    }
    replay
}

/// Motions of a leg on a body, of 20 s each.
fn simulate() {
    let text = "grammar leg
        use std.blocks     { cube, ball }
        use std.actuators  { bender }
        use std.actuation  { bezier_pac }
        use std.models     { hinge_model }
        use std.objectives { travel }
        use std.search     { gait_evolution }
        symmetry mirror xy
        begin {
          place core : cube
          place leg  : bender to core.left
          place foot : ball to leg.tip
        }
        actuate  bender with bezier_pac
        simulate hinge_model for 20 s
        maximize travel in cm
        search   gait_evolution";
    let mut sources = SourceMap::default();
    let entry = sources.add("leg.sgr", text);
    let rules = grammar_lang::compile(&Files, &mut sources, entry, &[], None).ruleset.expect("it compiles");
    let candidate = Candidate::new(&rules, Arc::new(Derivation::begin(&rules)));
    let task = rules.first_task().expect("one task");
    let drive = Drive::new(&candidate, task).expect("it is driven");
    let mut simulation = model("articulated")
        .expect("a model")
        .prepare(&candidate.body.assembly, &settings(&task.model))
        .expect("it is simulated");
    for seed in 0..u64::from(MOTIONS) {
        let law = drive.control_law(&drive.draw(&mut Stream::named(seed, "curves"))).expect("a law");
        let motions = simulation.run_cases(Stop::NEVER, &[law.case(&World::NOMINAL)]).expect("not stopped");
        assert!(motions.iter().any(Result::is_ok) || !motions.is_empty());
    }
}
