//! What a search finds on a floor without friction: nobody gets away from where it began, or turns by angular momentum.

use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use sgc::derive::Derivation;
use sgc::design::assembly::Assembly;
use sgc::search::{Best, Jobs, Limits, Observer, Row, Unkept};
use sgc::simulate::{
    Case, Invalid, Model, Motion, Settings, Simulation, SolverName, Stop, Unfit, Watch, model,
};

use crate::support::{compile_texts, is_long, texts};

/// The furthest that the centre of mass of any body got from where it began, along the ground, m.
static FURTHEST: Mutex<f64> = Mutex::new(0.0);

/// The furthest that angular momentum turned any body about the vertical, rad.
static SPUN: Mutex<f64> = Mutex::new(0.0);

/// The solver of hinges, which looks at every motion. What is to be simulated more finely is not, so that no check
/// of a best design hides what the search could live on.
struct Witness;

impl Model for Witness {
    fn name(&self) -> SolverName {
        SolverName::Articulated
    }

    fn prepare(&self, body: &Assembly, settings: &Settings) -> Result<Box<dyn Simulation>, Unfit> {
        let step = 1.0 / 240.0;
        let coarse = Settings { step, record: step, iterations: 10, tolerance: 2e-3, ..settings.clone() };
        let inner = model("articulated").unwrap().prepare(body, &coarse)?;
        Ok(Box::new(Watched { inner, body: body.clone() }))
    }
}

struct Watched {
    inner: Box<dyn Simulation>,
    body: Assembly,
}

impl Simulation for Watched {
    fn lanes(&self) -> usize {
        self.inner.lanes()
    }

    fn run_watched(
        &mut self,
        stop: Stop<'_>,
        cases: &[Case<'_>],
        watch: &dyn Watch,
    ) -> Option<Vec<Result<Motion, Invalid>>> {
        let motions = self.inner.run_watched(stop, cases, watch)?;
        for motion in motions.iter().flatten() {
            for (most, found) in [(&FURTHEST, motion.drift(&self.body)), (&SPUN, motion.spin(&self.body))] {
                let mut most = most.lock().unwrap();
                *most = most.max(found);
            }
        }
        Some(motions)
    }
}

struct Nobody;

impl Observer for Nobody {
    fn evaluated(&mut self, _: u64, _: Option<f64>, _: f64) {}
    fn moved(&mut self, _: &Row) -> Result<(), Unkept> {
        Ok(())
    }
    fn improved(&mut self, _: &Best) -> Result<(), Unkept> {
        Ok(())
    }
}

/// A search on ice, ten seeds of 3000 evaluations each in the profile `long`.
#[test]
fn a_search_on_ice_moves_nobody() {
    let mut texts = texts();
    let on_ice = texts["std.models"].replace("ground_friction = 0.8", "ground_friction = 0");
    assert_ne!(on_ice, texts["std.models"]);
    texts.insert("std.models".into(), on_ice);
    // Without worlds that slope: on ice, all slide down those.
    let rover = texts["grammars/rover.sgr"]
        .replace("use std.scenarios  { workshop }", "")
        .replace(" in workshop of", "")
        .replace(" in workshop", "")
        .replace("min over w", "");
    assert!(!rover.contains("workshop"), "{rover}");
    texts.insert("grammars/rover.sgr".into(), rover);
    let (seeds, evaluations) = if is_long() { (10, 3000) } else { (2, 120) };
    let of = |entry: &str| compile_texts(&texts, entry).unwrap();
    let bodies = [of("grammars/codesign.sgr"), of("grammars/rover.sgr")];
    for (rules, seed) in bodies.iter().flat_map(|rules| (1..=seeds).map(move |seed| (rules, seed))) {
        let limits = Limits {
            seed,
            jobs: Jobs::new(2),
            max_evaluations: Some(evaluations),
            lanes: None,
            gives_up: false,
            deadline: None,
        };
        let stop = AtomicBool::new(false);
        let outcome =
            sgc::search::run(rules, Derivation::begin(rules), &Witness, &limits, &stop, &mut Nobody).unwrap();
        // A check that has begun is made to its end.
        assert!((evaluations..evaluations + 16).contains(&outcome.evaluations));
        let furthest = *FURTHEST.lock().unwrap();
        assert!(furthest < 2e-4, "seed {seed}: a centre of mass went {furthest} m");
        let spun = *SPUN.lock().unwrap();
        assert!(spun < 0.01, "seed {seed}: a body turned by {spun} rad");
        println!(
            "{}, seed {seed}: furthest {furthest:e} m, turned {spun:e} rad, best {:?}",
            rules.name,
            outcome.best.map(|best| best.value)
        );
    }
}
