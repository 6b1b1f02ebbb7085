//! What the cross-checks of a run say, whatever the unit of the objective is, and of robots that are worse than one at rest.

use std::path::Path;

use crate::support::{read, said, sgc};

/// Runs a text: what it says, the value of its best, and how many cross-checks kept it, of how many.
fn run(folder: &Path, text: &str, name: &str, more: &[&str]) -> (String, f64, serde_json::Value) {
    let file = folder.join(format!("{name}.sgr"));
    std::fs::write(&file, text).unwrap();
    let (file, out) = (file.to_string_lossy(), folder.join(name));
    let run = sgc(
        folder,
        &[&["run", &*file, "--quiet", "--jobs", "1", "--out", &*out.to_string_lossy()], more].concat(),
    );
    let result =
        std::fs::read_to_string(out.join("result.json")).unwrap_or_else(|_| panic!("{}", said(&run)));
    let result: serde_json::Value = serde_json::from_str(&result).unwrap();
    (said(&run), result["value"].as_f64().unwrap(), result["checks"].clone())
}

/// Verdicts went by differences of 1e-4 in the unit of the objective: in m/s, a slow robot kept its value in every check.
#[test]
fn the_unit_of_an_objective_changes_no_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let slow = read("tests/creeper.sgr");
    let (_, fine, in_mm) = run(folder.path(), &slow, "fine", &["--max-evals", "60"]);
    let coarse = slow.replace("in mm/s", "in m/s");
    let (text, value, in_m) = run(folder.path(), &coarse, "coarse", &["--max-evals", "60"]);
    assert!((value * 1000.0 / fine - 1.0).abs() < 1e-9, "{value} {fine}");
    assert_eq!(in_m, in_mm, "{text}");
    // One of them says no, or nothing would be tested.
    assert_ne!(in_mm[0], in_mm[1]);
}

/// A robot that turns the wrong way is worse than one that stands still, and the run says so.
#[test]
fn a_robot_that_is_worse_than_one_at_rest_is_no_robot_to_look_at() {
    let folder = tempfile::tempdir().unwrap();
    let text = read("tests/creeper.sgr")
        .replace("{ mean_speed }", "{ turning }")
        .replace("maximize mean_speed in mm/s", "maximize turning in deg")
        .replace("to core.back", "to core.left");
    let mut worse = 0;
    for seed in ["1", "2", "3", "4"] {
        let (said, value, _) = run(folder.path(), &text, seed, &["--max-evals", "1", "--seed", seed]);
        let is_told = said.contains("this robot does no better than one that stands still");
        assert_eq!(is_told, value < 1e-4, "{seed}: {value} {said}");
        worse += usize::from(value < -1e-3);
    }
    assert!(worse > 0);
}

/// What shakes in time with frames is seen by closer looks, which record more often: of an arc they see more. At half the
/// step there are twice as many frames, and at an eighth seven times as many.
#[test]
fn closer_looks_record_more_often() {
    let folder = tempfile::tempdir().unwrap();
    let (said, value, _) = run(folder.path(), &read("tests/rotor.sgr"), "rotor", &["--max-evals", "3"]);
    let best = std::fs::read_to_string(folder.path().join("rotor/best.design.json")).unwrap();
    let best: serde_json::Value = serde_json::from_str(&best).unwrap();
    let check = |name: &str| {
        let checks = best["tasks"][0]["checks"].as_array().unwrap();
        let one = checks.iter().find(|check| check["name"].as_str().unwrap().contains(name));
        one.unwrap_or_else(|| panic!("{name}: {said}"))["value"].as_f64().unwrap()
    };
    // Chord over arc of an angle; the arm turns by so many degrees in a frame.
    let seen = |degrees: f64| libm::sin(degrees.to_radians() / 2.0) / (degrees.to_radians() / 2.0);
    let speed = best["tasks"][0]["drive"][0][1].as_f64().unwrap().to_degrees();
    let turn = speed / 10.0;
    for (name, times) in [("half the step, finer", 2.0), ("an eighth of the step", 7.0)] {
        let due = seen(turn / times) / seen(turn);
        assert!(
            (check(name) / value / due - 1.0).abs() < 1e-3,
            "{name}: {} {value} {due} {said}",
            check(name)
        );
    }
}
