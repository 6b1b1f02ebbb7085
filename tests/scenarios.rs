//! Scenarios: a saved design in other worlds.

use std::path::{Path, PathBuf};

use crate::support::{codesign, read, root, said, sgc};

/// A set of worlds that is part of a variant of a short search.
const SET: &str = "add scenarios workshop {
      friction = 75 % .. 125 %
      mass     = 90 % .. 110 %
      torque   = 85 % .. 115 %
      speed    = 90 % .. 110 %
      tilt     = 0 deg .. 2 deg
      slope    = -2 deg .. 2 deg
      late     = 0 ms .. 50 ms
      drawn    = 5
      case ice { ground_friction = 0.2 }
      case same { mass = 100 %  late = 0 ms }
    }";

/// A design of a variant of a grammar, out of a short search with short motions.
fn found(folder: &Path, grammar: &str, edits: &str) -> PathBuf {
    let text = if grammar == "codesign" { codesign() } else { read(&format!("grammars/{grammar}.sgr")) };
    let base = text.replace("for 20 s", "for 2 s").replace("for 15 s", "for 1 s");
    std::fs::write(folder.join("base.sgr"), base).unwrap();
    let file = folder.join("own.sgr");
    std::fs::write(&file, format!("variant own of \"./base.sgr\" {{\n    {edits}\n}}\n")).unwrap();
    let run = folder.join("run");
    let output = sgc(
        &root(),
        &["run", file.to_str().unwrap(), "--max-evals", "60", "--seed", "3", "--out", run.to_str().unwrap()],
    );
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    run
}

fn eval(design: &Path, more: &[&str]) -> String {
    let output = sgc(&root(), &[&["eval", design.to_str().unwrap()], more].concat());
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// The name, the value with its unit, and what differs, of each world that was printed.
fn rows(text: &str) -> Vec<(String, String, String)> {
    let worlds = text.lines().filter(|line| !line.starts_with("in "));
    let row = |line: &str| {
        let mut parts = line.split("  ").map(str::trim).filter(|part| !part.is_empty()).map(str::to_owned);
        let mut next = || parts.next().unwrap_or_default();
        (next(), next(), next())
    };
    worlds.map(row).collect()
}

#[test]
fn a_design_is_tried_in_every_world_of_a_set() {
    let folder = tempfile::tempdir().unwrap();
    let run = found(folder.path(), "codesign", SET);
    let text = eval(&run, &["--in", "workshop"]);
    let worlds = rows(&text);
    let names: Vec<&str> = worlds.iter().map(|(name, ..)| name.as_str()).collect();
    assert_eq!(
        names,
        ["nominal", "ice", "same", "drawn 1", "drawn 2", "drawn 3", "drawn 4", "drawn 5"],
        "{text}"
    );
    // The nominal world is that of a plain evaluation, and so is a case that changes nothing.
    let plain = eval(&run, &[]);
    let value = plain.lines().find_map(|line| line.strip_prefix("value ")).unwrap();
    assert_eq!((worlds[0].1.as_str(), worlds[2].1.as_str()), (value, value), "{text}{plain}");
    assert_eq!(worlds[1].2, "ground_friction 0.20");
    let mut values: Vec<&str> = worlds.iter().map(|(_, value, _)| value.as_str()).collect();
    values.sort_unstable();
    values.dedup();
    assert_eq!(values.len(), 7, "all worlds but one differ: {text}");
    let last = text.lines().last().unwrap();
    assert!(last.starts_with("in 8 worlds of `workshop`: ") && last.contains(" at worst ("), "{last}");
    // The same again, and by the same set of another grammar.
    assert_eq!(eval(&run, &["--in", "workshop"]), text);
    let file = folder.path().join("own.sgr");
    assert_eq!(eval(&run, &["--in", &format!("{}:workshop", file.display())]), text);
    // A finer step is another number in every world.
    let fine = eval(&run, &["--in", "workshop", "--step", "1/480"]);
    assert!(rows(&fine).iter().zip(&worlds).all(|(fine, own)| fine.0 == own.0), "{fine}");
    assert_ne!(fine, text);
}

#[test]
fn what_cannot_be_applied_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let press = "add scenarios pressed { case weak { pressure = 80 % } }";
    let run = found(folder.path(), "codesign", press);
    let ask = |set: &str| sgc(&root(), &["eval", run.to_str().unwrap(), "--in", set]);
    let fails = |set: &str, code: i32, parts: &[&str]| {
        let output = ask(set);
        assert_eq!(output.status.code(), Some(code), "{}", said(&output));
        for part in parts {
            assert!(said(&output).contains(part), "{part}: {}", said(&output));
        }
    };
    fails(
        "pressed",
        1,
        &["`pressure` of `pressed` cannot be applied: no task is simulated on a target with a supply"],
    );
    fails("presed", 2, &["has no scenarios `presed`", "did you mean `pressed`"]);
    fails("nowhere.sgr:pressed", 2, &["nowhere.sgr"]);
    fails(
        "grammars/codesign.sgr:any",
        2,
        &["grammars/codesign.sgr has no scenarios `any`", "it has: workshop, cross_checks"],
    );
}

/// Soft bodies of cells stand on slopes and on ice, too; they have no torques.
#[test]
fn balls_are_tried_in_worlds() {
    let folder = tempfile::tempdir().unwrap();
    let sets = "add scenarios outside {
      mass  = 90 % .. 110 %
      tilt  = 0 deg .. 2 deg
      drawn = 2
      case uphill { slope = 2 deg }
    }
    add scenarios strong { case strong { torque = 120 % } }";
    let run = found(folder.path(), "study1", sets);
    let worlds = rows(&eval(&run, &["--in", "outside"]));
    assert_eq!(worlds.len(), 4, "{worlds:?}");
    let plain = eval(&run, &[]);
    assert!(plain.starts_with(&format!("value {}\n", worlds[0].1)), "{plain}{worlds:?}");
    let output = sgc(&root(), &["eval", run.to_str().unwrap(), "--in", "strong"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("balls and springs have no torques"), "{}", said(&output));
}

/// A variant changes, narrows, adds and drops fields, and cases by their names.
#[test]
fn variants_change_fields_and_cases() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("base.sgr"), codesign()).unwrap();
    let set = "add scenarios workshop {
      friction = 75 % .. 125 %
      mass     = 90 % .. 110 %
      drawn    = 3
      case ice    { ground_friction = 0.2 }
      case carpet { ground_friction = 1.1 }
    }";
    let bench = format!("variant bench of \"./base.sgr\" {{\n{set}\n}}\n");
    std::fs::write(folder.path().join("bench.sgr"), bench).unwrap();
    let own = folder.path().join("own.sgr");
    let variant = |edits: &str| {
        std::fs::write(&own, format!("variant own of \"./bench.sgr\" {{\n{edits}\n}}\n")).unwrap()
    };
    variant(
        "set workshop.mass = 80 % .. 120 %
         set workshop.tilt = 0 deg .. 2 deg
         set workshop.drawn = 5
         narrow workshop.friction in 80 % .. 110 %
         set workshop.ice.ground_friction = 0.3
         set workshop.ice.slope = 1 deg
         drop workshop.carpet",
    );
    let resolved = sgc::testing::resolved(&own);
    let block =
        resolved.split("scenarios workshop {\n").nth(1).and_then(|rest| rest.split("\n}").next()).unwrap();
    let lines: Vec<&str> = block.lines().map(str::trim).collect();
    assert_eq!(
        lines,
        [
            "friction = 80 % .. 110 %",
            "mass = 80 % .. 120 %",
            "tilt = 0 deg .. 2 deg",
            "drawn = 5",
            "case ice { ground_friction = 0.3  slope = 1 deg }",
        ]
    );
    for (edit, told) in [
        ("drop workshop.tilt", "`workshop` has no `tilt` to drop"),
        ("set workshop.icy.mass = 90 %", "there is no `workshop.icy.mass` to set"),
        ("narrow workshop.tilt in 0 deg .. 1 deg", "there is no `workshop.tilt` to narrow"),
        ("set workshop.weight = 1 .. 2", "a set of worlds has no `weight`"),
        ("set workshop.ice.weight = 2", "a case has no `weight`"),
        ("narrow workshop.mass in 80 % .. 105 %", "narrow"),
    ] {
        variant(edit);
        let findings = sgc::testing::findings(&own);
        assert!(findings.contains(told), "{edit}: {findings}");
    }
}
