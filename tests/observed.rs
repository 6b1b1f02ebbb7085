//! Terms that are observed: columns of `evals.csv`, and what is saved and told of the best design.

use std::path::{Path, PathBuf};

use grammar_lang::ir::RuleSet;
use sgc::derive::random::Stream;
use sgc::derive::{Candidate, Derivation};
use sgc::drive::Drive;
use sgc::loader::Frozen;
use sgc::results::saved::{Check, Measured, SavedTask};
use sgc::results::verdict::{self, Verdict};

use crate::support::{codesign, grammar, root, said, sgc, texts};

/// A variant of a grammar with short motions, and what else is put into it.
fn variant(folder: &Path, imports: &str, edits: &str) -> PathBuf {
    let base = codesign().replace("for 20 s", "for 1 s");
    std::fs::write(folder.join("base.sgr"), base).unwrap();
    let file = folder.join("observed.sgr");
    let text = format!(
        "use std.objectives {{ fall }}
        use std.gaits {{ airborne, gait }}
        {imports}
        term low : Bool = fall < 1 mm
        ## It has no value for the initial design, which has no actuators.
        term work : Energy = mean over a in actuator of a.work
        variant observed of \"./base.sgr\" {{
          add observe gait, airborne
          add observe low, work
          {edits}
        }}"
    );
    std::fs::write(&file, text).unwrap();
    file
}

fn run(grammar: &Path, out: &Path, more: &[&str]) -> String {
    let run = ["run", grammar.to_str().unwrap(), "--max-evals", "400", "--out", out.to_str().unwrap()];
    let output = sgc(&root(), &[&run[..], more].concat());
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    said(&output)
}

fn evals(out: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(out.join("evals.csv")).unwrap();
    let head = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let rows = reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect());
    [head].into_iter().chain(rows).collect()
}

#[test]
fn what_is_observed_stands_beside_the_value() {
    let folder = tempfile::tempdir().unwrap();
    let searches = [
        ("", ""),
        ("use std.search { nested_evolution }", "replace search nested_evolution"),
        ("use std.search { many_kinds }", "replace search many_kinds"),
        ("", "set nested_annealing.bodies.chains = 3 set nested_annealing.curves.chains = 2"),
    ];
    for (number, (imports, edits)) in searches.into_iter().enumerate() {
        let grammar = variant(folder.path(), imports, edits);
        let out = folder.path().join(format!("run-{number}"));
        let told = run(&grammar, &out, &["--jobs", "2"]);
        let rows = evals(&out);
        assert_eq!(
            rows[0][15..],
            ["chain", "parent", "tuned", "at_most_in", "gait", "airborne", "low", "work", "slid", "sliding"]
        );
        assert!(rows.len() > 2, "{rows:?}");
        assert_eq!(rows[1][16], "", "the initial design is made of none");
        for row in &rows[2..] {
            let parent = &rows[1 + row[16].parse::<usize>().unwrap()];
            assert!(parent[7] == "true" && parent[0] != row[0], "{row:?} of {parent:?}");
        }
        for row in &rows[1..] {
            let (value, actuators) = (&row[6], &row[5]);
            assert_eq!(value.is_empty(), row[19].is_empty(), "{row:?}");
            assert_eq!(value.is_empty() || actuators == "0", row[22].is_empty(), "{row:?}");
            assert!(
                ["", "walker", "hopper", "crawler", "roller", "still", "unsure"].contains(&row[19].as_str())
            );
            assert!(["", "true", "false"].contains(&row[21].as_str()), "{row:?}");
        }
        // The best is told, saved, and the same when it is simulated again.
        let json = |name: &str| -> serde_json::Value {
            serde_json::from_str(&std::fs::read_to_string(out.join(name)).unwrap()).unwrap()
        };
        let (result, best) = (json("result.json"), json("best.design.json"));
        assert_eq!(result["observed"], best["observed"]);
        let gait = result["observed"]["gait"].as_str().unwrap();
        assert!(told.contains(&format!("observed gait {gait}")), "{told}");
        let again = said(&sgc(&root(), &["eval", out.to_str().unwrap()]));
        assert!(again.contains(&format!("observed gait {gait}")) && again.contains("exactly"), "{again}");
        let found = best["found_at"].as_u64().unwrap().to_string();
        let row = rows.iter().find(|row| row[0] == found).unwrap();
        assert_eq!(row[19], gait);
        assert_eq!(row[20].parse::<f64>().ok(), result["observed"]["airborne"].as_f64());

        // Neither threads nor observation change what is found.
        let other = folder.path().join(format!("other-{number}"));
        run(&grammar, &other, &["--jobs", "1"]);
        assert_eq!(evals(&other), rows);
        if out.join("archive.csv").exists() {
            let table = std::fs::read_to_string(out.join("archive.csv")).unwrap();
            assert!(
                table.lines().next().unwrap().ends_with("actuators,gait,airborne,low,work,slid,sliding"),
                "{table}"
            );
        }
    }
    let report = sgc(&root(), &["report", folder.path().join("run-0").to_str().unwrap()]);
    assert_eq!(report.status.code(), Some(0), "{}", said(&report));
    let page = std::fs::read_to_string(folder.path().join("run-0/report/index.html")).unwrap();
    assert!(page.contains("What was observed") && page.contains("value against airborne"), "{page}");
    let classes = std::fs::read_to_string(folder.path().join("run-0/report/classes.csv")).unwrap();
    assert!(classes.contains("observed,gait,walker,best of each run,"), "{classes}");
}

#[test]
fn observing_changes_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let (with, without) = (folder.path().join("with"), folder.path().join("without"));
    let grammar = variant(folder.path(), "", "");
    run(&grammar, &with, &[]);
    let text = std::fs::read_to_string(&grammar).unwrap();
    std::fs::write(&grammar, text.replace("add observe", "#")).unwrap();
    run(&grammar, &without, &[]);
    let cut = |rows: Vec<Vec<String>>| rows.into_iter().map(|row| row[..16].to_vec()).collect::<Vec<_>>();
    assert_eq!(cut(evals(&with)), cut(evals(&without)));
}

#[test]
fn variants_add_drop_and_replace_what_is_observed() {
    let compiled = |edits: &str| {
        let mut texts = texts();
        let text = format!(
            "use std.objectives {{ fall, energy, clearance }}
            variant first of \"./codesign.sgr\" {{ add observe fall, energy add observe clearance }}
            variant second of first {{ {edits} }}"
        );
        texts.insert("grammars/observed.sgr".to_owned(), text);
        let loader = Frozen { texts: texts.clone() };
        let mut sources = grammar_lang::source::SourceMap::default();
        let file = sources.add("grammars/observed.sgr", texts["grammars/observed.sgr"].clone());
        let compiled = grammar_lang::compile(&loader, &mut sources, file, &[], Some("second"));
        compiled.ruleset.expect("a grammar").observed
    };
    // What a module observes comes after what the grammar does.
    assert_eq!(compiled(""), ["fall", "energy", "clearance", "slid", "sliding"]);
    assert_eq!(compiled("drop observe clearance, fall, sliding"), ["energy", "slid"]);
    assert_eq!(compiled("replace observe clearance"), ["clearance"]);
    let edits = "drop observe fall, slid add observe travel";
    assert_eq!(compiled(edits), ["energy", "clearance", "travel", "sliding"]);
}

/// A grammar that has a term of the same name means that, and observes it only if it says so.
#[test]
fn a_module_observes_nothing_under_a_name_that_is_taken() {
    let base = codesign();
    let compiled = |more: &str| {
        let mut texts = texts();
        texts.insert("grammars/codesign.sgr".to_owned(), format!("{base}\n{more}"));
        crate::support::compile_texts(&texts, "grammars/codesign.sgr").unwrap().observed
    };
    assert_eq!(compiled(""), ["slid", "sliding"]);
    assert_eq!(compiled("term slid : Length = travel"), ["sliding"]);
    assert_eq!(compiled("term slid : Length = travel\nobserve slid"), ["slid", "sliding"]);
}

#[test]
fn checks_doubt_in_both_directions() {
    let rules = grammar("grammars/codesign.sgr");
    let saved = SavedTask {
        name: RuleSet::ONLY_TASK.to_owned(),
        value: 10.0,
        nominal: None,
        at_rest: None,
        unit: "cm".to_owned(),
        terms: Vec::new(),
        checks: Vec::new(),
        tests: Vec::new(),
        tested: None,
        drive: Vec::new(),
    };
    let verdict = |value, measured| {
        verdict::verdict(&rules, &saved, &Check { name: "elsewhere".to_owned(), value, measured, why: None })
    };
    // What keeps 80 % confirms; and what the value is 80 % of.
    for (value, expected) in [
        (Some(10.0), Verdict::Confirmed),
        (Some(8.1), Verdict::Confirmed),
        (Some(7.9), Verdict::Worse),
        (Some(-30.0), Verdict::Worse),
        (Some(12.4), Verdict::Confirmed),
        (Some(12.6), Verdict::Better),
        (Some(219.0), Verdict::Better),
        (None, Verdict::Refuted),
    ] {
        let verdict = verdict(value, Measured::Value);
        assert_eq!(verdict, expected, "{value:?}");
        assert_eq!(verdict.remark().is_empty(), expected == Verdict::Confirmed, "{value:?}");
    }
    assert_eq!(verdict(Some(1e-4), Measured::Drift), Verdict::Confirmed);
    assert_eq!(verdict(Some(3e-4), Measured::Drift), Verdict::Refuted);
    assert_eq!(verdict(Some(0.06), Measured::Spin), Verdict::Refuted);
    // What comes without the actuators may be a fifth of the value.
    assert_eq!(verdict(Some(1.9), Measured::Held), Verdict::Confirmed);
    assert_eq!(verdict(Some(-30.0), Measured::Held), Verdict::Confirmed);
    assert_eq!(verdict(Some(2.1), Measured::Held), Verdict::ByItself);
    assert!(!Verdict::ByItself.remark().is_empty());
    // Of 10 cm a body has 6 where it stands: the motion is worth 4, of which it keeps 80 %.
    let standing = SavedTask { at_rest: Some(6.0), ..saved.clone() };
    let verdict = |value, measured| {
        let check = Check { name: "elsewhere".to_owned(), value: Some(value), measured, why: None };
        verdict::verdict(&rules, &standing, &check)
    };
    assert_eq!(verdict(9.3, Measured::Value), Verdict::Confirmed);
    assert_eq!(verdict(9.1, Measured::Value), Verdict::Worse);
    assert_eq!(verdict(6.7, Measured::Held), Verdict::Confirmed);
    assert_eq!(verdict(6.9, Measured::Held), Verdict::ByItself);
    // A value over worlds is compared with one over worlds.
    let everywhere = SavedTask { nominal: Some(20.0), ..saved.clone() };
    let check = |measured| Check { name: "elsewhere".to_owned(), value: Some(10.0), measured, why: None };
    assert_eq!(verdict::verdict(&rules, &everywhere, &check(Measured::InWorlds)), Verdict::Confirmed);
    assert_eq!(verdict::verdict(&rules, &everywhere, &check(Measured::Value)), Verdict::Worse);
}

/// The rotation of an element is that of its part: x is forward, also of a disk, whose own axis stands upright.
#[test]
fn a_disk_has_the_heading_of_its_part() {
    let mut sources = grammar_lang::source::SourceMap::default();
    let text = "grammar hub
        use std.models { hinge_model }
        use std.search { gait_annealing }
        part hub {
          shape = disk(4 cm, 2 cm)  density = 1 g/cm^3  friction = 0.8
          port side at vector(4 cm, 0 cm, 0 cm) facing vector(1, 0, 0)
        }
        part arm {
          shape = box(6 cm, 2 cm, 2 cm)  density = 1 g/cm^3  friction = 0.8
          port root at vector(-3 cm, 0 cm, 0 cm) facing vector(-1, 0, 0)
        }
        begin { place core : hub  place out : arm to core.side by root }
        simulate hinge_model for 1 s
        term apart : Angle = angle(first(elements).rotation at end, last(elements).rotation at end)
        maximize apart + abs(heading(first(elements).rotation at start)) in deg
        search gait_annealing";
    let entry = sources.add("own.sgr", text);
    let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &[], None);
    let rules = compiled.ruleset.unwrap_or_else(|| panic!("{:#?}", compiled.diagnostics));
    let candidate = sgc::derive::Candidate::new(&rules, sgc::derive::Derivation::begin(&rules).into());
    let task = rules.first_task().unwrap();
    let drive = sgc::drive::Drive::new(&candidate, task).unwrap();
    let settings = sgc::search::settings(&task.model);
    let solver = sgc::simulate::model("articulated").unwrap();
    let mut simulation = solver.prepare(&candidate.body.assembly, &settings).unwrap();
    let motion = simulation.run(&[drive.targets(&[]).unwrap()]).remove(0).unwrap();
    let score = sgc::score::score(sgc::score::Recording::nominal(&drive, &[], &motion)).unwrap();
    assert!(score.value.abs() < 0.1, "{} deg", score.value);
}

/// Servos at their torque limits that let a pulled row tremble: the weight hangs still, but the work is several times too high.
#[test]
fn work_that_is_gone_at_half_the_step_is_in_doubt() {
    let folder = tempfile::tempdir().unwrap();
    let text = |mass: &str| {
        format!(
            "grammar hang
            use std.actuators  {{ bender }}
            use std.models     {{ hinge_model }}
            use std.objectives {{ energy }}
            use std.search     {{ gait_annealing }}
            part desk {{
              shape    = box(24 cm, 2 cm, 24 cm)
              density  = 3 g/cm^3
              friction = 1
              port under at vector(0 cm, -1 cm, 0 cm) facing vector(0, -1, 0)
              port leg[i in 0 .. 2] at vector(10 cm * cos(i * 120 deg), -1 cm, 10 cm * sin(i * 120 deg)) facing vector(0, -1, 0)
            }}
            part leg {{
              shape    = capsule(1.5 cm, 40 cm)
              density  = 1 g/cm^3
              friction = 1
            }}
            part bob {{
              shape    = sphere(3 cm)
              mass     = {mass}
              friction = 1
            }}
            begin {{
              place core  : desk
              place one   : leg to core.leg[0]
              place two   : leg to core.leg[1]
              place three : leg to core.leg[2]
              place row   : bender(segments = 8) to core.under
              place load  : bob to row.tip
            }}
            actuation swing for a : actuator {{
              shared period : Time in 1 s .. 2 s mutate 0.3 by normal(0 s, 0.2 s)
              drive  angle = 45 deg + 45 deg * sin(360 deg * t / period)
            }}
            actuate  bender with swing
            simulate hinge_model for 6 s
            observe  energy
            term up : Length = (load.position at end).y
            maximize up in cm
            search   gait_annealing"
        )
    };
    for (mass, doubtful) in [("100 g", false), ("900 g", true)] {
        std::fs::write(folder.path().join("hang.sgr"), text(mass)).unwrap();
        let run = sgc(folder.path(), &["run", "hang.sgr", "--max-evals", "12", "--force", "--out", "run"]);
        let told = said(&run);
        let line = told.lines().find(|line| line.contains("with half the step (energy)")).unwrap_or(&told);
        assert_eq!(line.contains("energy and work are in doubt"), doubtful, "{mass}: {told}");
    }
}

/// What objectives are of a body that does not move: it stands on the ground, and what has no value there is left out.
#[test]
fn a_body_at_rest_stands_on_the_ground() {
    let at_rest = |objective: &str| {
        let mut texts = texts();
        let text = codesign().replace("travel - fall in cm", &format!("({objective}) in cm"));
        let text =
            text.replace("use std.objectives { travel, fall", "use std.objectives { travel, energy, fall");
        texts.insert("grammars/codesign.sgr".into(), text);
        let rules = crate::support::compile_texts(&texts, "grammars/codesign.sgr").unwrap();
        let candidate = Candidate::new(&rules, std::sync::Arc::new(Derivation::begin(&rules)));
        let drive = Drive::new(&candidate, rules.first_task().unwrap()).unwrap();
        let parameters = drive.draw(&mut Stream::named(1, "rest"));
        sgc::score::at_rest(&drive, &parameters).unwrap()[0]
    };
    // The first body is a cube of 2.5 cm.
    for (objective, value) in [
        ("travel - fall + 20 cm * count(part)", 20.0),
        ("travel + first(elements).lowest at end", 0.0),
        ("travel + height(first(elements).position at start)", 1.25),
        ("1 cm * (sum over e in elements of e.touching / (1 s))", 20.0),
        ("1 cm * (travel / energy / (1 m / 1 J) + 5.0 * count(part))", 5.0),
        ("if energy > 0 J then travel else 3 cm", 3.0),
    ] {
        let found = at_rest(objective);
        assert!((found - value).abs() < 1e-9, "{objective}: {found}");
    }
}
