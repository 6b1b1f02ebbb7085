//! Policies: what networks decide from what sensors read, when, and that searches for their weights are repeatable.

use sgc::derive::{Candidate, Derivation};
use sgc::drive::{Conditions, Drive, Exploration, Explorer};
use sgc::search::settings;
use sgc::simulate::{Stop, World, model};

use crate::joints::compiled;
use crate::sensors::walker;

/// What each actuator is asked for at each control moment, in degrees, with these weights.
fn commands(text: &str, weights: &[f64]) -> Vec<Vec<f64>> {
    let rules = compiled(text);
    let candidate = Candidate::new(&rules, Derivation::begin(&rules).into());
    let task = rules.first_task().unwrap();
    let drive = Drive::new(&candidate, task).unwrap();
    assert_eq!(drive.length(), weights.len(), "one weight for each node and each of its inputs");
    let law = drive.control_law(weights).unwrap();
    assert!(law.is_closed_loop());
    let mut simulation =
        model("articulated").unwrap().prepare(&candidate.body.assembly, &settings(&task.model)).unwrap();
    let motion = simulation.run_cases(Stop::NEVER, &[law.case(&World::NOMINAL)]).unwrap().remove(0).unwrap();
    let told = motion.commands.unwrap();
    told.angles.chunks(told.actuators).map(|row| row.iter().map(|x| x.to_degrees()).collect()).collect()
}

/// The walker without rules: a network is of one body.
fn one_body(policy: &str, actuation: &str) -> String {
    let grow = "rule grow { match p : block with free port q  attach cube to q }";
    walker(policy, actuation).replace(grow, "")
}

/// A policy decides at equal times; what it decided holds until then. Each actuator has outputs of its own, an image among them.
#[test]
fn decisions_hold_until_the_next() {
    // Without hidden nodes the outputs are biases and shares of the inputs: of the time, of one actuator and of the other.
    let text = one_body(
        "policy brain { inputs = [t / 1 s]  hidden = []  every = 50 ms }",
        "action push : Angle in -10 deg .. 10 deg of brain from [a.image]  drive angle = push",
    );
    let (bias, rate) = (0.2, 3.0 * libm::sqrt(3.0));
    let asked = commands(&text, &[bias, rate, 0.0, 0.0, -bias, 0.0, 0.0, libm::sqrt(3.0)]);
    for (moment, row) in asked.iter().enumerate() {
        let decided = (moment - moment % 3) as f64 / 60.0;
        let expected = [10.0 * libm::tanh(bias + 3.0 * decided), 10.0 * libm::tanh(1.0 - bias)];
        for (asked, expected) in row.iter().zip(expected) {
            assert!((asked - expected).abs() < 1e-9, "moment {moment}: {asked}, expected {expected}");
        }
    }
    assert!(asked.len() > 100);
}

/// With mirrored inputs, a policy decides for each side by the same weights: it knows the actuators of that side first, and what is mirrored has
/// the other sign for the images.
#[test]
fn two_sides_are_decided_by_the_same_weights() {
    let text = one_body(
        "policy brain { inputs = []  mirrored = [t / 1 s]  hidden = [] }",
        "action push : Angle in -10 deg .. 10 deg of brain from [1 + 2 * a.image]  drive angle = push",
    );
    // A bias, and shares of the time, of the own actuator, and of its image.
    let (bias, rate, own, other) = (0.2, 0.7, -0.3, 0.4);
    let root = libm::sqrt(3.0);
    let asked = commands(&text, &[bias, rate * root, own * root, other * root]);
    for (moment, row) in asked.iter().enumerate() {
        let t = moment as f64 / 60.0;
        let expected = [bias + rate * t + own + 3.0 * other, bias - rate * t + 3.0 * own + other];
        for (asked, expected) in row.iter().zip(expected.map(|sum| 10.0 * libm::tanh(sum))) {
            assert!((asked - expected).abs() < 1e-9, "moment {moment}: {asked}, expected {expected}");
        }
    }
    assert!(asked.len() > 100);
}

/// Of several values the one with the greatest output is taken, the first of equals. What was decided last is known.
#[test]
fn one_of_several_values_is_taken() {
    let text = one_body(
        "policy brain { hidden = []  every = 100 ms }",
        "action way : Count in 1 .. 3 of brain from []
         action up : Bool in { false, true } of brain from []
         drive angle = way * (if up then 1 deg else -1 deg)",
    );
    let asked = commands(&text, &[0.1, 0.3, 0.2, 0.0, 0.0, 0.5, 0.1, 0.5, -1.0, 1.0]);
    assert!(asked.iter().all(|row| (row[0] + 2.0).abs() < 1e-9 && (row[1] - 1.0).abs() < 1e-9));
    // Each turns over what it decided before.
    let turning = one_body(
        "policy brain { hidden = []  every = 100 ms }",
        "action on : Bool in { false, true } of brain from [if on then 1 else 0]
         drive angle = if on then 5 deg else 0 deg",
    );
    // By actuator the output for `false` and that for `true`: a bias, and a weight for each of the two inputs.
    let own = |first: f64, second: f64| vec![0.0, 0.0, 0.0, 1.0, first, second];
    let asked = commands(&turning, &[own(-2.0, 0.0), own(0.0, -2.0)].concat());
    let ons: Vec<bool> = asked.iter().step_by(6).map(|row| row[0] > 1.0).take(8).collect();
    assert_eq!(ons, [true, false, true, false, true, false, true, false]);
}

/// A body whose gait a small network decides, which a search may tune.
pub(crate) fn learner() -> String {
    let text = one_body(
        "use std.sensors { lean }
         sense bent(a : bender) : Angle = a.angle at now noise 1 deg
         policy brain { inputs = [lean / 30 deg]  hidden = [4]  every = 0.1 s }",
        "action push : Number in -1 .. 1 of brain from [bent(a) / 60 deg, sin(t / 1 s * 360 deg)]
         state aim : Angle from 0 deg next clamp(aim + push * 180 deg/s * control_interval, -60 deg, 60 deg)
         drive angle = aim",
    );
    text.replace("{ recommended }", "{ gait_evolution }")
        .replace("search recommended", "search gait_evolution")
}

/// The same with a reward, learned by a method: `push` is within a range, or one of three values.
pub(crate) fn learner_by(method: &str) -> String {
    let reward = "reward = ((first(elements).position at now).x - (first(elements).position at before).x) / 1 cm\n  every = 0.1 s }";
    let text =
        learner().replace("every = 0.1 s }", reward).replace("use std.search     { gait_evolution }\n", "");
    let text = match method {
        "double_dqn" => text.replace("Number in -1 .. 1 of brain", "Number in { -1, 0, 1 } of brain"),
        _ => text,
    };
    let own = if method == "double_dqn" {
        "exploration = max(5 %, 90 % - 20 % * iteration)"
    } else {
        "critic = [8]"
    };
    text.replace("search gait_evolution", "search learning")
        + &format!(
            "\nsearch learning {{ keep = 80 %  curves {method} {{ {own}  warm_up = 3  batch = 32  replay = 200  iterations = 100  moves = 3  stop = false }} }}\n"
        )
}

/// Weights mean something for their own network only, however many another one needs.
#[test]
fn weights_of_another_network_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_string_lossy().into_owned()
    };
    // Two hidden nodes of one input, or none of six: seven weights for one actuator.
    let own = |inputs: &str, hidden: &str| {
        let policy = format!("policy brain {{ inputs = [{inputs}]  hidden = {hidden} }}");
        one_body(&policy, "action push : Angle in -9 deg .. 9 deg of brain from []  drive angle = push")
            .replace("symmetry mirror xy", "")
            .replace("{ recommended }", "{ gait_evolution }")
            .replace("search recommended", "search gait_evolution")
    };
    let base = own("t / 1 s", "[2]");
    let (base, other) = (file("base.sgr", &base), file("other.sgr", &own(&["t / 1 s"; 6].join(", "), "[]")));
    let run = folder.path().join("run").to_string_lossy().into_owned();
    let made = crate::command_line::sgc(&["run", &base, "--max-evals", "9", "--quiet", "--out", &run]);
    assert_eq!(made.status.code(), Some(0), "{}", String::from_utf8_lossy(&made.stderr));
    let told = |grammar: &str| {
        let output = crate::command_line::sgc(&["eval", &run, "--grammar", grammar]);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    assert_eq!(told(&base).0, Some(0));
    let (code, message) = told(&other);
    assert_eq!(code, Some(1), "{message}");
    assert!(
        message
            .contains("`brain` is a network (inputs: 1, hidden: [2]) that decides `push` (Angle, inputs: 0)"),
        "{message}"
    );
    let again = folder.path().join("again").to_string_lossy().into_owned();
    let begun = crate::command_line::sgc(&[
        "run",
        &other,
        "--from-design",
        &run,
        "--max-evals",
        "1",
        "--out",
        &again,
    ]);
    assert!(String::from_utf8_lossy(&begun.stderr).contains("do not fit"), "another network begins anew");
}

/// Learning gives the same bits for one thread and for two, and its design evaluates to what it says.
#[test]
fn what_is_learned_is_repeatable() {
    for (method, sides) in
        [("soft_actor_critic", 1), ("soft_actor_critic", 2), ("double_dqn", 1), ("double_dqn", 2)]
    {
        let folder = tempfile::tempdir().unwrap();
        let grammar = folder.path().join("own.sgr");
        let of_both =
            if sides == 2 { "policy brain { mirrored = [sin(t / 1 s * 360 deg)]" } else { "policy brain {" };
        std::fs::write(&grammar, learner_by(method).replace("policy brain {", of_both)).unwrap();
        let run = |name: &str, jobs: &str| {
            let out = folder.path().join(name);
            let (file, to) = (grammar.to_string_lossy(), out.to_string_lossy());
            let command = ["run", &file, "--max-evals", "60", "--jobs", jobs, "--quiet", "--out", &to];
            let output = crate::command_line::sgc(&command);
            assert_eq!(
                output.status.code(),
                Some(0),
                "{method}: {}",
                String::from_utf8_lossy(&output.stderr)
            );
            out
        };
        let (one, two) = (run("one", "1"), run("two", "2"));
        let read = |folder: &std::path::Path, file: &str| std::fs::read_to_string(folder.join(file)).unwrap();
        for file in ["evals.csv", "learning.csv", "best.design.json"] {
            assert_eq!(read(&one, file), read(&two, file), "{method}: {file}");
        }
        // Of 60 evaluations, an iteration takes three motions that explore and one of the policy, and checks of a best.
        let curve = read(&one, "learning.csv");
        let rows: Vec<Vec<&str>> = curve.lines().skip(1).map(|line| line.split(',').collect()).collect();
        assert!(rows.len() > 5, "{curve}");
        for (place, row) in rows.iter().enumerate() {
            assert_eq!([row[1], row[3]], [(place + 1).to_string(), (3 * (place + 1)).to_string()], "{curve}");
            assert!(row[4].parse::<f64>().is_ok_and(|reward| reward != 0.0), "{curve}");
        }
        let result: serde_json::Value = serde_json::from_str(&read(&one, "result.json")).unwrap();
        let best: f64 = rows.last().unwrap()[7].parse().unwrap();
        assert_eq!(Some(best), result["value"].as_f64());
        let report = crate::command_line::sgc(&["report", &one.to_string_lossy()]);
        assert_eq!(report.status.code(), Some(0));
        assert!(read(&one, "report/index.html").contains("Learning</h2>"));
        assert_eq!(read(&one, "report/learning.csv").lines().count(), rows.len() + 1);
        let again = crate::command_line::sgc(&["eval", &one.to_string_lossy()]);
        assert!(String::from_utf8_lossy(&again.stderr).contains("exactly the saved value"), "{method}");
    }
}

/// A schedule that has no value at a late iteration ends the learner, and what was found before is kept.
#[test]
fn a_schedule_that_fails_late_keeps_the_best() {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (folder.path().join("late.sgr"), folder.path().join("late"));
    let text = learner_by("double_dqn");
    let late = text.replace(
        "max(5 %, 90 % - 20 % * iteration)",
        "10 % / (if iteration >= 12 and idle >= 0 then 0 else 1)",
    );
    assert_ne!(text, late);
    std::fs::write(&file, late).unwrap();
    let command =
        ["run", &file.to_string_lossy(), "--max-evals", "200", "--quiet", "--out", &out.to_string_lossy()];
    let output = crate::command_line::sgc(&command);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{told}");
    let result = std::fs::read_to_string(out.join("result.json")).unwrap();
    let result: serde_json::Value = serde_json::from_str(&result).unwrap();
    assert!(result["evaluations"].as_u64().is_some_and(|made| made < 100), "{result}");
    assert!(out.join("best.design.json").exists());
    // All iterations before it are in the table.
    let curve = std::fs::read_to_string(out.join("learning.csv")).unwrap();
    assert_eq!(curve.lines().count(), 13, "{curve}");
}

/// Motions explore in the worlds of the objective where the learner says so.
#[test]
fn a_learner_may_explore_in_worlds() {
    let folder = tempfile::tempdir().unwrap();
    let text = learner_by("soft_actor_critic")
        .replace(
            "simulate hinge_model for 2 s",
            "scenarios rough { case slick { friction = 30 % } }\nsimulate hinge_model for 2 s in rough",
        )
        .replace("maximize travel", "maximize min over w in rough of travel");
    let rewards = |name: &str, text: &str| {
        let (file, out) = (folder.path().join(format!("{name}.sgr")), folder.path().join(name));
        std::fs::write(&file, text).unwrap();
        let command =
            ["run", &file.to_string_lossy(), "--max-evals", "20", "--quiet", "--out", &out.to_string_lossy()];
        let output = crate::command_line::sgc(&command);
        // Whether anything is found in so few evaluations or not.
        assert_ne!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
        let curve = std::fs::read_to_string(out.join("learning.csv")).unwrap();
        curve.lines().nth(1).unwrap().split(',').nth(4).unwrap().to_owned()
    };
    let nominal = rewards("nominal", &text);
    let worlds = rewards("worlds", &text.replace("warm_up = 3", "warm_up = 3  worlds = true"));
    assert_ne!(nominal, worlds);
    assert_eq!(nominal, rewards("again", &text));
}

/// A reward reads what was so at the decision before: what it adds up to is how far the core came.
#[test]
fn rewards_read_two_decisions() {
    #[derive(Debug, Default)]
    struct Still(Vec<f64>, usize);
    impl Explorer for Still {
        fn gain(&mut self, reward: f64) {
            self.0.push(reward);
        }
        fn decide(&mut self, _: usize, known: &[f64]) -> Vec<f64> {
            self.1 += 1;
            assert!(known.iter().all(|x| x.abs() <= 10.0));
            // The first actuator bends, the other does not.
            vec![2.0, 0.0]
        }
    }
    let text = one_body(
        "policy brain { hidden = []  every = 100 ms
           reward = (sum over e in elements of (e.position at now).z - (e.position at before).z) / 1 mm * (100 ms / (now - before))
             + (if (first(elements).position at before).y > 0 m then 1000 else 0) }",
        "action push : Angle in -50 deg .. 50 deg of brain from []  drive angle = push",
    );
    let rules = compiled(&text);
    let candidate = Candidate::new(&rules, Derivation::begin(&rules).into());
    let task = rules.first_task().unwrap();
    let drive = Drive::new(&candidate, task).unwrap();
    let mut explorer = Still::default();
    let weights = vec![0.0; drive.length()];
    let exploration = Exploration::new(&drive, &weights, &Conditions::nominal(), &mut explorer).unwrap();
    let mut simulation =
        model("articulated").unwrap().prepare(&candidate.body.assembly, &settings(&task.model)).unwrap();
    let motions = simulation.run_cases(Stop::NEVER, &[exploration.case(&World::NOMINAL)]).unwrap();
    let motion = motions.into_iter().next().unwrap().unwrap();
    assert!(exploration.failed().is_none());
    let Still(gained, decisions) = explorer;
    assert_eq!(gained.len() + 1, decisions);
    let elements = candidate.body.assembly.elements.len();
    let came =
        |time: f64| -> f64 { (0..elements).map(|i| motion.pose(i, time).unwrap().translation.z).sum() };
    let until = 0.1 * gained.len() as f64;
    let sum: f64 = gained.iter().map(|reward| reward - 1000.0).sum();
    assert!(
        (sum - 1000.0 * (came(until) - came(0.0))).abs() < 0.01,
        "{sum} mm of {}",
        came(until) - came(0.0)
    );
    assert!(sum.abs() > 1.0, "nothing moved: {sum}");
}

/// A search for weights gives the same bits for one thread and for two; its design evaluates to what it says, and one with an edited
/// weight is refused.
#[test]
fn learned_gaits_are_repeatable() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = folder.path().join("own.sgr");
    std::fs::write(&grammar, learner()).unwrap();
    let sgc = |command: &[&str]| {
        let output = crate::command_line::sgc(command);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        output
    };
    let run = |name: &str, jobs: &str| {
        let out = folder.path().join(name);
        let (file, to) = (grammar.to_string_lossy(), out.to_string_lossy());
        sgc(&["run", &file, "--max-evals", "60", "--jobs", jobs, "--quiet", "--out", &to]);
        out
    };
    let read = |folder: &std::path::Path| std::fs::read_to_string(folder.join("evals.csv")).unwrap();
    let (one, two) = (run("one", "1"), run("two", "2"));
    assert_eq!(read(&one), read(&two));
    let again = crate::command_line::sgc(&["eval", &one.to_string_lossy()]);
    assert!(String::from_utf8_lossy(&again.stderr).contains("exactly the saved value"));

    let best = one.join("best.design.json");
    let saved = std::fs::read_to_string(&best).unwrap();
    assert!(saved.contains("brain[0]"));
    let mut design: serde_json::Value = serde_json::from_str(&saved).unwrap();
    let weight = &mut design["tasks"][0]["drive"][0];
    assert_eq!(weight[0], "brain[0]");
    weight[1] = 0.125.into();
    std::fs::write(&best, design.to_string()).unwrap();
    let edited = crate::command_line::sgc(&["eval", &best.to_string_lossy()]);
    assert_ne!(edited.status.code(), Some(0));
}
