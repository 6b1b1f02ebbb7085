//! An actuator of few hinges bends as an elastic rod.

use std::sync::Arc;

use grammar_lang::ir::RuleSet;
use sgc::derive::Derivation;
use sgc::design::Body;
use sgc::simulate::{self, Settings, Targets};

use crate::support::{compile_texts, said, sgc};

/// Length in m, mass in kg, bending stiffness in N m^2.
const LENGTH: f64 = 0.12;
const MASS: f64 = 0.03;
const RIGIDITY: f64 = 1.1e-3;

/// A rod of so many hinges, held level by a heavy block. A hinge stands for an equal share of the length: its
/// stiffness is the bending stiffness of the rod over that.
fn rod(hinges: usize) -> RuleSet {
    let segments = hinges + 1;
    let text = format!(
        "grammar rod
        use std.actuation  {{ bezier_pac }}
        use std.objectives {{ travel, fall }}
        use std.models     {{ hinge_model }}
        use std.search     {{ nested_annealing }}
        part anvil {{ shape = box(20 cm, 20 cm, 20 cm) mass = 10 kg friction = 0.8 }}
        actuator rod {{
          param segments : Count in 2 .. 64 = {segments}
          segment        = cylinder(0.2 cm, {length} m)
          mass           = {mass} kg
          friction       = 0.8
          bend           = -3 rad .. 3 rad
          bending_speed  = 360 deg/s
          relaxing_speed = 360 deg/s
          torque         = 10 N*m/rad
          stiffness      = {stiffness} N*m/rad^2
          damping        = {damping} N*m*s/rad^2
        }}
        begin {{
          place core : anvil
          place arm  : rod to core.front
        }}
        rule lengthen {{ match p : part with free port q  attach rod to q }}
        actuate  rod with bezier_pac
        simulate hinge_model for 1 s
        search   nested_annealing
        maximize travel - fall in cm",
        length = LENGTH / segments as f64,
        mass = MASS / segments as f64,
        stiffness = RIGIDITY * hinges as f64 / LENGTH,
        damping = 0.1 * RIGIDITY * hinges as f64 / LENGTH,
    );
    let mut texts = crate::support::texts();
    texts.insert("rod.sgr".to_owned(), text);
    compile_texts(&texts, "rod.sgr").unwrap_or_else(|error| panic!("{error}"))
}

/// How far the tip of the rod is below its base when all has come to rest, m.
fn sag(solver: &str, hinges: usize) -> f64 {
    let rules = rod(hinges);
    let made = Arc::new(Derivation::begin(&rules));
    let body = Body::new(&made.design, &rules);
    let (_, task) = rules.tasks.first().unwrap();
    let settings = Settings { duration: 3.0, self_collision: false, ..sgc::search::settings(&task.model) };
    let mut simulation = simulate::model(solver).unwrap().prepare(&body.assembly, &settings).unwrap();
    let motion =
        simulation.run(&[Targets { interval: 1.0, actuators: 1, angles: vec![0.0] }]).remove(0).unwrap();
    let last = body.assembly.elements.len() - 1;
    let half = match body.assembly.elements[last].shape {
        sgc::design::assembly::Shape::Cylinder { half_length, .. } => half_length,
        _ => panic!("an actuator is a row of cylinders"),
    };
    let end = motion.pose(last, 3.0).unwrap() * nalgebra::Point3::new(half, 0.0, 0.0);
    let base = motion.pose(0, 3.0).unwrap().translation.vector.y;
    base - end.y
}

/// The sag of the elastica under its own weight: EI t'' = -w (L - s) cos t with t(0) = 0 and t'(L) = 0, by
/// shooting with Runge and Kutta's method.
fn elastica() -> f64 {
    let weight = MASS * 9.81 / LENGTH;
    let steps = 2000;
    let h = LENGTH / f64::from(steps);
    let shoot = |curvature: f64| {
        let slope =
            |s: f64, [t, k, _]: [f64; 3]| [k, -weight * (LENGTH - s) * libm::cos(t) / RIGIDITY, libm::sin(t)];
        let mut at = [0.0, curvature, 0.0];
        for step in 0..steps {
            let s = f64::from(step) * h;
            let along = |by: [f64; 3], part: f64| [0, 1, 2].map(|i| at[i] + by[i] * part);
            let a = slope(s, at);
            let b = slope(s + h / 2.0, along(a, h / 2.0));
            let c = slope(s + h / 2.0, along(b, h / 2.0));
            let d = slope(s + h, along(c, h));
            at = [0, 1, 2].map(|i| at[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        }
        at
    };
    // The curvature at the base that leaves none at the tip; more of it leaves more.
    let (mut low, mut high) = (0.0, weight * LENGTH * LENGTH / RIGIDITY);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if shoot(middle)[1] < 0.0 { low = middle } else { high = middle }
    }
    shoot(low)[2]
}

#[test]
fn few_hinges_bend_as_the_elastica() {
    let truth = elastica();
    assert!(truth > 0.3 * LENGTH, "it bends far: {truth} m");
    let errors = [3, 5, 10].map(|hinges| (sag("articulated", hinges) - truth).abs() / LENGTH);
    assert!(errors[1] < 0.02, "{errors:?} of the length");
    // Of second order: half as wide, a quarter of the error.
    assert!(errors[2] < errors[1] / 3.0, "{errors:?} of the length");
    // The solver of rods is given the same row. Where the middle of its last segment is, is known, and its tip from that.
    let errors = [3, 5, 10].map(|hinges| (sag("rod", hinges) - truth).abs() / LENGTH);
    println!("{errors:?}");
    assert!(errors[0] < 0.02 && errors[1] < 0.01 && errors[2] < errors[1], "{errors:?} of the length");
}

/// What is found is ranked by what it comes to with rods, and what is no design is told.
#[test]
fn refine_ranks_the_designs_of_runs_by_their_values_with_rods() {
    let folder = tempfile::tempdir().unwrap();
    let text = crate::support::read("grammars/codesign.sgr")
        .replace("for 20 s in workshop", "for 2 s")
        .replace("min over w in workshop of travel - fall", "travel - fall");
    std::fs::write(folder.path().join("short.sgr"), text).unwrap();
    let run = ["run", "short.sgr", "--runs", "3", "--max-evals", "150", "--quiet", "--out", "runs"];
    assert!(sgc(folder.path(), &run).status.success());
    let output = sgc(folder.path(), &["refine", "runs", "runs/seed-1"]);
    assert!(output.status.success(), "{}", said(&output));
    let table = String::from_utf8(output.stdout).unwrap();
    let rows: Vec<Vec<&str>> =
        table.lines().skip(1).take(3).map(|row| row.split_whitespace().collect()).collect();
    // A design that is named twice is there once.
    assert_eq!(table.matches("best.design.json\n").count(), 3, "{table}");
    // Where nothing bends, the value at half the step counts.
    let rods = |row: &[&str]| row[0].parse::<f64>().ok();
    let counts = |row: &[&str]| rods(row).unwrap_or_else(|| row[row.len() - 5].parse().unwrap());
    assert!(rows.windows(2).all(|pair| counts(&pair[0]) >= counts(&pair[1])), "{table}");
    assert!(rows.iter().filter(|row| rods(row).is_some()).count() > 1, "{table}");
    for row in &rows {
        let eval = |more: &[&str]| {
            let arguments = [&["eval", row[row.len() - 1]], more].concat();
            let text = String::from_utf8(sgc(folder.path(), &arguments).stdout).unwrap();
            text.lines().next().unwrap().split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
        };
        assert!(rods(row).is_none_or(|value| value == eval(&["--solver", "rod"])), "{table}");
        assert_eq!(row[row.len() - 3].parse::<f64>(), Ok(eval(&[])), "{table}");
    }
    // A search that asks for all of the value with rods refuses what is worse there, and says so where it begins with it.
    let strict = |direction: &str| {
        let text = format!(
            "use std.objectives {{ travel, fall }}
            variant strict of \"./short.sgr\" {{
              set recommended.keep_with_rods = 100 %
              replace {direction} travel - fall in cm
            }}"
        );
        std::fs::write(folder.path().join(format!("{direction}.sgr")), text).unwrap();
    };
    strict("maximize");
    strict("minimize");
    for (row, number) in rows.iter().zip(0..) {
        let Some(with_rods) = rods(row) else { continue };
        let found: f64 = row[row.len() - 3].parse().unwrap();
        for (direction, is_worse) in [("maximize", with_rods < found), ("minimize", with_rods > found)] {
            let (grammar, out) = (format!("{direction}.sgr"), format!("{direction}-{number}"));
            let design = row[row.len() - 1];
            let run =
                ["run", &grammar, "--from-design", design, "--max-evals", "10", "--quiet", "--out", &out];
            let told = said(&sgc(folder.path(), &run))
                .contains("with soft rods, which is less than `keep_with_rods` requires");
            assert_eq!(told, is_worse, "{direction}: {with_rods} {found}");
        }
    }
    let none = sgc(folder.path(), &["refine", "short.sgr"]);
    assert_eq!(none.status.code(), Some(2), "{}", said(&none));
}
