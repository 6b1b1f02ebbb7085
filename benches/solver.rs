//! How long an evaluation takes: milliseconds for a motion of 20 s at 1/240 s, by body and by the
//! number of motions side by side, beside rapier's impulse joints with the same bodies and drives, and beside elastic rods in place of
//! the rows that bend.
//!
//! `cargo bench --bench solver` (add `-- 9` for nine rounds instead of three, and saved designs
//! to measure these instead of the examples of `benches/bodies/`). All methods take
//! turns, each round every one; the least of the rounds counts. On an idle machine, please.
//!
//! The last two bodies have the same parts and degrees of freedom: one bends only, the other has joints of all kinds.
//!
//! Then what a drive takes in several worlds at once, as a multiple of what it takes in the nominal one alone.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout, missing_docs)]

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;
use sgc::derive::{Candidate, Derivation, Stream};
use sgc::design::Body;
use sgc::drive::{Drive, Parameters};
use sgc::loader::Files;
use sgc::results::saved::SavedDesign;
use sgc::search::settings;
use sgc::simulate::rapier::Rapier;
use sgc::simulate::{Case, Model, Settings, Simulation, SolverName, Stop, Targets, World, model};

const LANES: [usize; 4] = [1, 4, 8, 16];

fn main() {
    let rounds = std::env::args().filter_map(|a| a.parse().ok()).next().unwrap_or(3);
    let designs: Vec<_> = std::env::args().skip(1).map(PathBuf::from).filter(|path| path.exists()).collect();
    let bodies: Vec<_> = match designs.as_slice() {
        [] => ["two", "four", "eight"]
            .map(|name| example("bodies", name))
            .into_iter()
            .chain(["bends", "mixed"].map(|name| example("joints", name)))
            .collect(),
        some => some.iter().map(|path| saved(path)).collect(),
    };
    println!("ms for an evaluation, the least of {rounds} rounds");
    println!("{:>14}{:>8}{:>9}{:>9}   articulated, by lanes", "body", "hinges", "rapier", "rods");
    let mut ratios = [const { Vec::new() }; LANES.len()];
    for (name, body, settings, drives) in &bodies {
        let mut own = model("articulated").unwrap().prepare(&body.assembly, settings).unwrap();
        // Four sweeps in four substeps are what rapier does by default.
        let coarse = Settings { iterations: 1, ..settings.clone() };
        let rapier = Rapier { substep: settings.step / 4.0 };
        let mut other = rapier.prepare(&body.assembly, &coarse).unwrap();
        let mut rods = SolverName::Rod.model().prepare(&body.assembly, settings).unwrap();
        let (mut least, mut most, mut bent) = ([f64::INFINITY; LANES.len()], f64::INFINITY, f64::INFINITY);
        for _ in 0..rounds {
            most = most.min(time(other.as_mut(), &drives[..2], 1));
            bent = bent.min(time(rods.as_mut(), &drives[..2], 1));
            for (least, lanes) in least.iter_mut().zip(LANES) {
                *least = least.min(time(own.as_mut(), drives, lanes));
            }
        }
        let hinges: usize = body.assembly.joints.iter().map(|joint| joint.kind.dofs().len()).sum();
        let own: Vec<_> = LANES.iter().zip(least).map(|(lanes, t)| format!("{lanes}: {t:5.2}")).collect();
        println!(
            "{name:>14}{hinges:>8}{most:9.1}{bent:9.1}   {}   widest here {}",
            own.join("  "),
            widest(body, settings)
        );
        ratios.iter_mut().zip(least).for_each(|(ratios, least)| ratios.push(most / least));
    }
    in_worlds(&bodies, rounds);
    for (lanes, ratios) in LANES.iter().zip(&ratios) {
        let mean = libm::exp(ratios.iter().map(|r| libm::log(*r)).sum::<f64>() / ratios.len() as f64);
        println!("{lanes:2} lanes: {mean:5.1} times as fast as rapier (geometric mean)");
    }
}

/// Prints what one drive takes in several worlds, the nominal one among them.
fn in_worlds(bodies: &[Measured], rounds: usize) {
    println!("in worlds at once, as a multiple of the nominal one alone");
    for (name, body, settings, drives) in bodies {
        let mut own = model("articulated").unwrap().prepare(&body.assembly, settings).unwrap();
        let mut least = [f64::INFINITY; LANES.len()];
        for _ in 0..rounds {
            for (least, count) in least.iter_mut().zip(LANES) {
                let worlds: Vec<World> = (0..count).map(world).collect();
                let start = Instant::now();
                for drive in &drives[..4] {
                    let cases: Vec<Case<'_>> = worlds.iter().map(|world| Case::new(drive, world)).collect();
                    let motions = own.run_cases(Stop::NEVER, &cases).unwrap();
                    assert!(motions.iter().all(Result::is_ok));
                }
                *least = least.min(start.elapsed().as_secs_f64());
            }
        }
        let multiples = LANES.iter().zip(least).map(|(count, t)| format!("{count}: {:.2}", t / least[0]));
        println!("{name:>14}   {}", multiples.collect::<Vec<_>>().join("  "));
    }
}

/// The nominal world, and others around it.
fn world(number: usize) -> World {
    if number == 0 {
        return World::NOMINAL;
    }
    let mut random = Stream::named(number as u64, "worlds");
    let mut around = |by: f64| 1.0 + by * (2.0 * random.unit() - 1.0);
    World {
        friction: around(0.25),
        ground_friction: None,
        mass: around(0.1),
        torque: around(0.15),
        speed: around(0.1),
        slope: 0.035 * (around(1.0) - 1.0),
        tilt: 0.0175 * around(1.0),
        heading: std::f64::consts::PI * around(1.0),
    }
}

/// Milliseconds for each of several drives, so many side by side.
fn time(simulation: &mut dyn Simulation, drives: &[Targets], lanes: usize) -> f64 {
    let start = Instant::now();
    for some in drives.chunks(lanes) {
        assert!(simulation.run(some).iter().all(Result::is_ok));
    }
    start.elapsed().as_secs_f64() * 1e3 / drives.len() as f64
}

fn widest(body: &Body, settings: &Settings) -> usize {
    model("articulated").unwrap().prepare(&body.assembly, settings).unwrap().lanes()
}

/// What is measured: its name, a body, the model's numbers and sixteen drives.
type Measured = (String, Body, Settings, Vec<Targets>);

/// An example of the bodies, and drives of it as the search would start with.
fn example(file: &str, name: &str) -> Measured {
    let path = format!("{}/benches/bodies/{file}.sgr", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(Path::new(&path)).unwrap();
    let mut sources = SourceMap::default();
    let entry = sources.add(path, text);
    let rules = grammar_lang::compile(&Files, &mut sources, entry, &[], None).ruleset.unwrap();
    let derivation = Arc::new(Derivation::start(&rules, Some(name)).unwrap());
    measured(name, &rules, derivation, |drive, random| drive.draw(random))
}

/// A saved design, and drives that the search would try after its own.
fn saved(path: &Path) -> Measured {
    let file = if path.is_dir() { path.join("best.design.json") } else { path.to_owned() };
    let design = SavedDesign::read(&file).unwrap();
    let rules = design.grammar.compile(&design.sgc).unwrap();
    let derivation = Arc::new(Derivation::replay(&rules, &design.derivation).unwrap());
    let own = design.tasks[0].parameters();
    let name = path.file_name().unwrap().to_string_lossy();
    measured(&name, &rules, derivation, |drive, random| drive.mutate(&own, 9.0, 0, random).unwrap())
}

fn measured(
    name: &str,
    rules: &RuleSet,
    derivation: Arc<Derivation>,
    parameters: impl Fn(&Drive<'_>, &mut Stream) -> Parameters,
) -> Measured {
    let candidate = Candidate::new(rules, derivation);
    let task = rules.first_task().unwrap();
    let drive = Drive::new(&candidate, task).unwrap();
    let body = &candidate.body;
    let settings = settings(&task.model);
    let mut simulation = model("articulated").unwrap().prepare(&body.assembly, &settings).unwrap();
    // What is not a valid motion ends early, and would flatter.
    let drives = (0..)
        .map(|n| drive.targets(&parameters(&drive, &mut Stream::named(n, "bench"))).unwrap())
        .filter(|targets| simulation.run(std::slice::from_ref(targets)).iter().all(Result::is_ok))
        .take(16)
        .collect();
    (name.to_owned(), Body::clone(body), settings, drives)
}
