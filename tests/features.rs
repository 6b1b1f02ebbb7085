//! What the clauses of the language do to designs: each on a grammar of a few lines.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;
use sgc::derive::random::Stream;
use sgc::derive::{Candidate, Derivation, check_start, run_example};
use sgc::design::Body;
use sgc::drive::Drive;
use sgc::results::names::Names;
use sgc::search::{Best, Jobs, Limits, Observer, Row, Unkept};
use sgc::simulate;

use crate::support::{grammar, root};

/// What most of the grammars below have in common.
const COMMON: &str = "
use std.blocks     { cube, ball }
use std.actuators  { bender }
use std.actuation  { bezier_pac }
use std.objectives { travel, fall }
use std.models     { hinge_model }
use std.search     { nested_annealing }
actuate  bender with bezier_pac
simulate hinge_model for 1 s
search   nested_annealing
";

fn compile(text: &str) -> Result<RuleSet, String> {
    let mut sources = SourceMap::default();
    let name = root().join("grammars/feature.sgr").to_string_lossy().into_owned();
    let entry = sources.add(name, format!("grammar feature\n{COMMON}\n{text}"));
    let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &[], None);
    let mut errors: Vec<_> = compiled.diagnostics.into_iter().filter(|d| d.is_error()).collect();
    errors.extend(compiled.ruleset.as_ref().and_then(check_start));
    match compiled.ruleset {
        Some(rules) if errors.is_empty() => Ok(rules),
        _ => Err(format!("{errors:#?}")),
    }
}

fn rules(text: &str) -> RuleSet {
    compile(&format!("{text}\nmaximize travel - fall in cm\n")).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn quantities_that_differ_by_rounding_are_equal() {
    let held = [
        "7 mm == 0.7 cm",
        "7 mm <= 0.7 cm and 0.7 cm >= 7 mm",
        "not (0.7 cm < 7 mm) and not (7 mm != 0.7 cm)",
        "0.1 s * 3 == 300 ms",
        "35 % == 0.35",
        "floor(0.7 cm / 1 mm) == 7 and ceil(0.3 / 0.1) == 3",
        "[7 mm, 1 cm] == [0.7 cm, 10 mm]",
        "wrap(540 deg) == 180 deg and wrap(-180 deg) == 180 deg and wrap(190 deg) == -170 deg",
        "(count over d in { 7 mm, 8 mm } where d == 0.7 cm) == 1",
        "not (7 mm == 0.7000001 cm) and 7 mm < 0.7000001 cm",
    ];
    let expects: String = held.iter().map(|held| format!("  expect {held}\n")).collect();
    let text = format!("{GROW}\nparam long : Length in 0 mm .. 0.7 cm = 7 mm\nexample x {{\n{expects}}}");
    example(&rules(&text)).unwrap();
    assert!(
        compile(&format!(
            "{GROW}\nparam long : Length in 0 mm .. 0.7 cm = 7.0001 mm\nmaximize travel in cm\n"
        ))
        .is_err()
    );
}

/// Derives the example `x`.
fn example(rules: &RuleSet) -> Result<Derivation, String> {
    run_example(rules, "x", &rules.examples["x"]).map_err(|e| format!("{}: {}", e.message, e.labels[0].text))
}

fn positions(derivation: &Derivation) -> Vec<[f64; 3]> {
    let at = |p: &sgc::design::Part| {
        let t = p.pose.translation.vector * 1e3;
        [t.x, t.y, t.z].map(|x| (x * 10.0).round() / 10.0 + 0.0)
    };
    derivation.design.parts.values().map(at).collect()
}

const GROW: &str = "
begin { place core : cube }
rule bud {
  match  p : part with free port q
  choose what in { cube, ball }
  attach what to q
}
rule leg {
  match  p : part with free port q
  choose n in 2 .. 6
  choose turn in { 0 deg, 90 deg, 180 deg, 270 deg }
  attach bender(segments = n) to q turned turn
}
";

#[test]
fn radial_symmetry_repeats_an_application_about_its_axis() {
    let rules = rules(&format!(
        "symmetry radial 4 about y {GROW}
        example x {{
          step a = bud(p = core, q = core.front, what = cube)
          step b = leg(p = a, q = a.front, n = 3, turn = 0 deg)
          step c = bud(p = core, q = core.top, what = ball)
          expect count(part) == 10
          expect count(images(a)) == 3 and count(images(c)) == 0
          expect exists i in images(b): i.image == 2 and i.holder.image == 2
        }}"
    ));
    let made = example(&rules).unwrap();
    let places = positions(&made);
    // Front, left, back, right: a quarter of a turn about the vertical each.
    assert_eq!(places[1..5], [[25.0, 0.0, 0.0], [0.0, 0.0, -25.0], [-25.0, 0.0, 0.0], [0.0, 0.0, 25.0]]);
    assert_eq!(places[9], [0.0, 25.0, 0.0], "what lies on the axis is there once");
    // What is no image of itself cannot stand on the axis.
    let on_axis = "symmetry radial 4 about y".to_owned()
        + GROW
        + "example x { refuse leg(p = core, q = core.top, n = 3, turn = 0 deg) }";
    example(&super::features::rules(&on_axis)).unwrap();
}

/// What turns about the axis or slides along it moves as all its images would: it is there once, and what hangs on it is repeated.
#[test]
fn a_row_along_the_axis_is_its_own_image() {
    for (joint, fits) in
        [("slide along x", true), ("twist", true), ("spin about x", true), ("slide along y", false)]
    {
        let limits = match joint {
            "twist" => {
                "range = -60 deg .. 60 deg  speed = 90 deg/s  effort = 0.1 N*m/rad  stiffness = 0.3 N*m/rad^2  damping = 0.01 N*m*s/rad^2"
            }
            "spin about x" => "speed = 90 deg/s  effort = 0.1 N*m/rad  damping = 0.01 N*m*s/rad^2",
            _ => {
                "range = 0 mm .. 5 mm  speed = 50 mm/s  effort = 5 N  stiffness = 500 N/m  damping = 10 N*s/m"
            }
        };
        let answer = if fits {
            "step a = lift(p = core, q = core.top)
             step b = bud(p = a, q = a.tip, what = cube)
             expect count(jack) == 1 and count(images(b)) == 0 and count(part) == 3"
        } else {
            "refuse lift(p = core, q = core.top)"
        };
        let rules = rules(&format!(
            "symmetry radial 4 about y {GROW}
            actuator jack {{
              segment = cylinder(6 mm, 10 mm)  joint = {joint}  {limits}
              density = 1 g/cm^3  friction = 0.5  colour = \"#5a9e8f\"
            }}
            rule lift {{
              match  p : part with free port q
              attach jack to q
            }}
            actuation still for a : jack {{ drive {} }}
            actuate jack with still
            example x {{ {answer} }}",
            match joint {
                "twist" => "angle = a.greatest_bend * sin(t / 2 s * 360 deg)",
                "spin about x" => "speed = a.greatest_speed",
                _ => "distance = a.greatest_distance * (1 - cos(t / 2 s * 360 deg)) / 2",
            }
        ));
        example(&rules).unwrap();
    }
}

#[test]
fn replacing_keeps_what_hangs_on_the_part_and_the_side_of_the_core() {
    let replace = "
    symmetry mirror xy
    rule soften {
      match   a - m : cube - b
      replace m with bender(segments = 4) from a to b
    }
    rule swap {
      match   m : cube where m is not core
      replace m with ball
    }";
    let toward = rules(&format!(
        "{GROW} {replace}
        example x {{
          step a = bud(p = core, q = core.front, what = cube)
          step b = bud(p = a, q = a.front, what = ball)
          step c = soften(a = core, m = a, b = b)
          expect count(cube) == 1 and count(bender) == 1
          expect b.holder is c and c.holder is core
        }}"
    ));
    // The base of the bender at the core: the ball moves to its tip, 8 cm further.
    assert_eq!(positions(&example(&toward).unwrap())[2], [12.5 + 80.0 + 12.5, 0.0, 0.0]);
    let away = rules(&format!(
        "{GROW} {replace}
        example x {{
          step a = bud(p = core, q = core.left, what = cube)
          step b = bud(p = a, q = a.front, what = ball)
          step c = soften(a = b, m = a, b = core)
          expect b.holder is c and c.holder is core and c.twin is not c
          expect not c.tip.free and not c.base.free
        }}"
    ));
    let away = example(&away).unwrap();
    // The base at the ball: the bender is held by its tip, on both sides of the body.
    assert_eq!(positions(&away)[3], [0.0, 0.0, -(12.5 + 80.0 + 12.5)]);
    assert_eq!(positions(&away)[4], [0.0, 0.0, 12.5 + 80.0 + 12.5]);
    let swapped = rules(&format!(
        "{GROW} {replace}
        example x {{
          step a = bud(p = core, q = core.front, what = cube)
          step b = bud(p = a, q = a.top, what = ball)
          step c = swap(m = a)
          expect c is ball and b.holder is c and count(part) == 3
          refuse swap(m = core)
        }}"
    ));
    example(&swapped).unwrap();
}

#[test]
fn an_actuator_held_by_its_tip_is_driven_like_any_other() {
    let rules = rules(
        "begin { place core : cube }
        rule hang {
          match  p : part with free port q
          attach bender(segments = 4) to q by tip as a
          attach ball to a.base
        }
        example x { step a = hang(p = core, q = core.front) expect count(ball) == 1 }",
    );
    let made = Arc::new(example(&rules).unwrap());
    let body = Body::new(&made.design, &rules);
    // Core, then the segments from the tip inwards, then the ball at the base.
    let x: Vec<f64> =
        body.assembly.elements.iter().map(|e| (e.pose.translation.vector.x * 1e4).round() / 10.0).collect();
    assert_eq!(x, [0.0, 19.2, 39.2, 65.8, 85.8, 105.0]);
    let (_, task) = rules.tasks.first().unwrap();
    let model = simulate::model("articulated").unwrap();
    let mut simulation = model.prepare(&body.assembly, &sgc::search::settings(&task.model)).unwrap();
    let targets = simulate::Targets { interval: 1.0, actuators: 1, angles: vec![0.5, 0.5] };
    let motion = simulation.run(&[targets]).remove(0).unwrap();
    let bend = motion.bends.last().copied().unwrap();
    assert!((bend - 0.5).abs() < 0.1, "it bends by what it is told: {bend}");
}

#[test]
fn removing_takes_what_hangs_on_the_part_and_its_images() {
    let rules = rules(&format!(
        "symmetry mirror xy {GROW}
        rule prune {{
          match  p : part where p is not core
          remove p
        }}
        rule undo {{
          match  s : step where s.rule == \"prune\"
          revert s
        }}
        example x {{
          step a = bud(p = core, q = core.left, what = cube)
          step b = leg(p = a, q = a.front, n = 3, turn = 0 deg)
          step c = bud(p = core, q = core.front, what = ball)
          expect count(part) == 6
          step d = prune(p = a.twin)
          expect count(part) == 2
          expect exists p in part: p is ball
          refuse bud(p = a, q = a.top, what = cube)
          step e = undo(s = d)
          expect count(part) == 6
        }}"
    ));
    example(&rules).unwrap();

    // What is taken away has a name as long as the story speaks of it, after those that stay.
    let mut gone = 0;
    for seed in 0..10 {
        let mut now = Derivation::begin(&rules);
        let mut random = Stream::named(seed, "names");
        for _ in 0..12 {
            now = now.advance(&rules, &mut random, 1.0).result.unwrap_or(now);
        }
        let (kept, all) = (Names::of(&rules, &now.design), Names::through(&rules, &now));
        now.retrace(&rules, |_, before, after| {
            for id in before.parts.keys().chain(after.parts.keys()) {
                gone += usize::from(kept.get(*id).is_none());
                assert!(all.get(*id).is_some_and(|name| kept.get(*id).is_none_or(|kept| kept == name)));
            }
        });
        assert_eq!(all.check(&[]), Ok(()));
    }
    assert!(gone > 0, "nothing was taken away");
}

#[test]
fn what_is_made_of_several_kinds_of_actuators_is_an_actuator() {
    let rules = rules(
        "use std.actuators { twister }
        actuate twister with bezier_pac
        rule limb {
          match  p : part with free port q where p is core
          choose kind in { bender, twister }
          choose n    in { 2, 3 }
          attach match n { 2 -> bender(segments = 4), else -> twister(segments = 3) } to q as first
          attach kind to first.tip as second
          attach if n == 2 then kind(segments = 2) else bender(segments = 2) to second.tip as third
        }
        example x {
          step a = limb(p = core, q = core.front, n = 2, kind = twister)
          expect a.greatest_bend > 0 deg and a.first.greatest_bend > 0 deg
          expect a.second.greatest_bend > 0 deg and a.third.greatest_bend > 0 deg
        }
        begin { place core : cube }",
    );
    example(&rules).unwrap();
}

#[test]
fn matches_bind_different_things_and_chains_follow_joints() {
    let rules = rules(&format!(
        "{GROW}
        rule row {{
          match a - b - c where c is ball
          attach cube to a.bottom
        }}
        rule pair {{
          match a : cube
          match b : cube where a.depth < b.depth
          attach ball to b.top
        }}
        rule joints {{
          match j : joint where j.port is front
          attach ball to j.held.bottom
        }}
        rule ports {{
          match p : cube
          match q : port of p where q is top and q.free
          attach ball to q
        }}
        example x {{
          step a = bud(p = core, q = core.front, what = cube)
          step b = bud(p = a, q = a.front, what = ball)
        }}"
    ));
    let made = example(&rules).unwrap();
    let count = |name: &str| {
        let rule = rules.rule(name).unwrap();
        made.matches(&rules, rule).unwrap().len()
    };
    assert_eq!(count("row"), 1, "core - cube - ball, and no way back to where it came from");
    assert_eq!(count("pair"), 1);
    assert_eq!(count("joints"), 2, "cube and ball are held by a front");
    assert_eq!(count("ports"), 2, "both cubes have a free top");
}

/// How often each value of the choice `n` of the rule `draw` is drawn.
fn drawn(clause: &str, temperature: f64) -> [usize; 10] {
    let rules = rules(&format!(
        "begin {{ place core : cube }}
        rule draw {{ match p : cube with free port q {clause} attach bender(segments = n + 2) to q }}"
    ));
    let mut counts = [0; 10];
    let mut random = Stream::named(3, "draws");
    for _ in 0..2000 {
        let next = Derivation::begin(&rules).advance(&rules, &mut random, temperature).result.unwrap();
        let part = next.design.parts.values().last().unwrap();
        counts[part.params["segments"].as_number().unwrap() as usize - 2] += 1;
    }
    counts
}

#[test]
fn choices_follow_their_spread() {
    let even = drawn("choose n in 0 .. 3", 0.0);
    assert!(even[..4].iter().all(|c| (400..600).contains(c)), "{even:?}");
    let weights = drawn("choose n in { 1, 4, 6 } by [3, 0, 1]", 0.0);
    assert!((1400..1600).contains(&weights[1]) && weights[4] == 0 && weights[6] > 400, "{weights:?}");
    let normal = drawn("choose n in 0 .. 8 by normal(4, 1)", 0.0);
    assert!(normal[4] > normal[3] && normal[3] > normal[2] && normal[0] < 5, "{normal:?}");
    assert!((700..900).contains(&normal[4]), "40 % of a normal distribution: {normal:?}");
    let uniform = drawn("choose n in 0 .. 8 by uniform(2, 3)", 0.0);
    assert_eq!(uniform[2] + uniform[3], 2000);
    let guarded = drawn("choose n in 0 .. 8 when n == 5 or n == 7", 0.0);
    assert_eq!(guarded[5] + guarded[7], 2000);
    let hot = drawn("choose n in 0 .. floor(temperature)", 2.5);
    assert_eq!((hot[0] + hot[1] + hot[2], hot[3]), (2000, 0));
}

#[test]
fn a_choice_may_depend_on_the_size_of_the_design() {
    let rules = rules(
        "begin { place core : cube }
        rule leg {
          match  p : cube with free port q
          choose n in 2 .. 2 * count(actuator)
          attach bender(segments = n) to q
        }
        rule bud { match p : cube with free port q attach cube to q weight 1 / count(part) }",
    );
    // Without an actuator the domain is empty, and so no leg can ever be added.
    let mut derivation = Derivation::begin(&rules);
    let mut random = Stream::named(1, "size");
    for _ in 0..20 {
        if let Some(next) = derivation.advance(&rules, &mut random, 0.0).result {
            derivation = next;
        }
    }
    assert!(derivation.design.parts.values().all(|p| p.kind == "cube"));
    assert!(derivation.design.parts.len() > 3);
}

/// What a finger is made of.
const FINGER: &str = "segment = cylinder(9 mm, 2 cm)
      density = 1 g/cm^3
      friction = 0.8
      bend = -90 deg .. 90 deg
      bending_speed = 95 deg/s
      relaxing_speed = 40 deg/s
      torque = 0.06 N*m/rad
      stiffness = 0.3 N*m/rad^2
      damping = 0.01 N*m*s/rad^2";

#[test]
fn actuators_of_a_group_share_their_curves() {
    let text = "
    pattern rest = 0 deg
    actuator finger {
      param segments : Count in 2 .. 9 = 3
      param channel : Count in 0 .. 2 = 0
      FINGER
    }
    actuation shared_valves for a : actuator {
      shared period : Time in 1 s .. 2 s mutate 0.5 by normal(0 s, 1 s)
      vary   bend[2] : Angle in 0 deg .. 90 deg per a.channel mutate 0.5 by normal(0 deg, 9 deg)
      vary   late : Bool flip 0.5
      drive  angle = bend[0] * sin(t / period * 360 deg)
    }
    actuate finger with shared_valves
    begin { place core : cube }
    rule leg {
      match  p : cube with free port q
      choose c in 0 .. 2
      attach finger(channel = c) to q
    }
    example x {
      step a = leg(p = core, q = core.left, c = 1)
      step b = leg(p = core, q = core.right, c = 2)
      step c = leg(p = core, q = core.front, c = 1)
    }";
    let rules = rules(&text.replace("FINGER", FINGER));
    let made = Arc::new(example(&rules).unwrap());
    let drive = Drive::new(&Candidate::new(&rules, made), &rules.tasks[0]).unwrap();
    // One period, a pair of bends for each of two channels, one switch for each of three fingers.
    assert_eq!(drive.length(), 1 + 2 * 2 + 3, "{:?}", drive.labels(|id| id.to_string()));
    let parameters = drive.draw(&mut Stream::named(1, "groups"));
    let targets = drive.targets(&parameters).unwrap();
    let row: Vec<f64> = targets.angles.iter().skip(10 * 3).take(3).copied().collect();
    let channel: Vec<f64> =
        drive.candidate().body.actuators.iter().map(|id| drive_channel(&rules, id)).collect();
    for i in 0..3 {
        for j in 0..3 {
            assert_eq!(row[i] == row[j], channel[i] == channel[j], "{row:?} {channel:?}");
        }
    }
}

/// Several numbers group together: those of one channel that have as many segments.
#[test]
fn actuators_are_grouped_by_several_things() {
    let text = "
    actuator finger {
      param segments : Count in 2 .. 9 = 3
      param channel : Count in 0 .. 2 = 0
      param strong : Bool = false
      FINGER
    }
    actuation groups for a : actuator {
      vary   bend : Angle in 0 deg .. 90 deg per [a.strong, a.channel] mutate 0.5 by normal(0 deg, 9 deg)
      drive  angle = bend
    }
    actuate finger with groups
    begin {
      place core : cube
      place one : finger(channel = 1) to core.left
      place two : finger(channel = 1, strong = true) to core.right
      place three : finger(channel = 1) to core.front
      place four : finger(channel = 2) to core.back
    }";
    let rules = rules(&text.replace("FINGER", FINGER));
    let made = Arc::new(Derivation::begin(&rules));
    let drive = Drive::new(&Candidate::new(&rules, made), &rules.tasks[0]).unwrap();
    let labels = drive.labels(|id| id.to_string());
    assert_eq!(labels, ["bend of group 0, 1", "bend of group 0, 2", "bend of group 1, 1"]);
    let mut targets = drive.targets(&[0.1, 0.2, 0.3]).unwrap().angles[..4].to_vec();
    targets.sort_by(f64::total_cmp);
    assert_eq!(targets, [0.1, 0.1, 0.2, 0.3]);
}

fn drive_channel(rules: &RuleSet, id: &sgc::design::PartId) -> f64 {
    let made = example(rules).unwrap();
    made.design.parts[id].params["channel"].as_number().unwrap()
}

#[test]
fn what_the_beginning_carries_stays() {
    let rules = rules(&format!(
        "symmetry mirror xy
        part battery {{ shape = box(3 cm, 4 cm, 4 cm) mass = 60 g friction = 0.5 }}
        {}
        rule prune {{ match p : part remove p }}
        require carries : count(battery) == 1
        example x {{
          expect pack.holder is core and pack.mass == 60 g
          expect left_fin.twin is not left_fin and count(bender) == 2
          refuse prune(p = pack)
          refuse prune(p = left_fin)
        }}",
        GROW.replace(
            "place core : cube",
            "place core : cube
             place pack : battery to core.top turned 90 deg
             place left_fin : bender(segments = 3) to core.left turned 90 deg"
        )
    ));
    example(&rules).unwrap();
}

#[test]
fn the_core_may_be_an_actuator() {
    let rules = rules(
        "begin { place core : bender(segments = 4) }
        rule lengthen {
          match  a : actuator with free port q
          attach bender(segments = 3) to q turned 90 deg
        }
        example x {
          step a = lengthen(a = core, q = core.tip)
          step b = lengthen(a = core, q = core.base)
          expect count(block) == 0 and count(actuator) == 3
        }",
    );
    let made = example(&rules).unwrap();
    assert_eq!(positions(&made), [[0.0; 3], [80.0, 0.0, 0.0], [0.0; 3]]);
    let body = Body::new(&made.design, &rules);
    // A spine of ten segments: nothing hangs in the wrong place.
    let mut x: Vec<f64> =
        body.assembly.elements.iter().map(|e| (e.pose.translation.vector.x * 1e4).round() / 10.0).collect();
    x.sort_by(f64::total_cmp);
    // Each actuator ends in segments half as long as its others.
    assert_eq!(x, [-52.5, -30.0, -7.5, 6.7, 26.7, 53.3, 73.3, 87.5, 110.0, 132.5]);
    for joint in &body.assembly.joints {
        let place = |i: usize| body.assembly.elements[i].pose.translation.vector;
        assert!((place(joint.parent) - place(joint.child)).norm() < 0.0267, "{joint:?}");
    }
}

#[derive(Default)]
struct Log(Vec<f64>);

impl Observer for Log {
    fn evaluated(&mut self, _: u64, _: Option<f64>, _: f64) {}
    fn moved(&mut self, _: &Row) -> Result<(), Unkept> {
        Ok(())
    }
    fn improved(&mut self, best: &Best) -> Result<(), Unkept> {
        self.0.push(best.value);
        self.0.extend(best.tasks.iter().flat_map(|t| &t.parameters));
        Ok(())
    }
}

fn search(rules: &RuleSet, jobs: usize, max: u64) -> (Option<Best>, Vec<f64>) {
    let limits = Limits {
        seed: 2,
        jobs: Jobs::new(jobs),
        max_evaluations: Some(max),
        lanes: None,
        gives_up: true,
        deadline: None,
    };
    let model = simulate::model("articulated").unwrap();
    let mut log = Log::default();
    let first = Derivation::start(rules, rules.from.as_deref()).unwrap();
    let outcome = sgc::search::run(rules, first, model, &limits, &AtomicBool::new(false), &mut log).unwrap();
    (outcome.best, log.0)
}

#[test]
fn tasks_have_their_own_curves_and_one_value() {
    let rules = compile(&format!(
        "{GROW}
        task far {{ maximize travel in cm }}
        task low {{ simulate hinge_model for 0.5 s minimize fall in mm }}
        maximize far.value / 1 cm - low.value / 1 mm - count(part)
        prefer few : count(part) <= 2 weight 0.5"
    ))
    .unwrap();
    let (best, log) = search(&rules, 1, 400);
    assert_eq!(log, search(&rules, 3, 400).1, "whatever the number of threads");
    let best = best.unwrap();
    assert_eq!(best.tasks.len(), 2);
    let parts = best.derivation.design.parts.len() as f64;
    let lost = if parts > 2.0 { 0.5 } else { 0.0 };
    assert_eq!(best.value, best.tasks[0].value - best.tasks[1].value - parts - lost);
}

#[test]
fn a_search_may_start_from_an_example() {
    let rules = compile(&format!(
        "{GROW}
            example x {{
              step a = bud(p = core, q = core.front, what = cube)
              step b = leg(p = a, q = a.left, n = 3, turn = 0 deg)
            }}
            maximize travel - fall in cm"
    ));
    // `search` stands in the common part: the example is asked for from outside, as by `--from`.
    let mut rules = rules.unwrap();
    rules.from = Some("x".to_owned());
    rules.search.bodies = None;
    let (best, _) = search(&rules, 1, 50);
    let best = best.unwrap();
    assert_eq!(best.derivation.design.parts.len(), 3);
    assert_eq!(best.derivation.steps.len(), 2);
}

#[test]
fn a_choice_may_be_a_value_of_an_enumeration_or_a_record() {
    let rules = rules(
        "
        enum Surface { carpet, sand }
        record Servo { tilt : Angle, segments : Count }
        let small = Servo(tilt = 0 deg, segments = 3)
        let large = Servo(tilt = 90 deg, segments = 6)
        begin { place core : cube }
        rule grow {
          match  p : block with free port q
          choose on in Surface
          choose servo in { small, large }
          let    near = neighbours(p)
          let    edge = vector(1 cm, 0 cm, 2 cm)
          attach bender(segments = servo.segments) to q turned if on == Surface.sand then servo.tilt else 0 deg
        }
        rule undo {
          match  s : step where s adds part
          revert s
        }
        require few : count(part) <= 5 because \"of the test\"
        example x {
          step a = grow(p = core, q = core.left, on = Surface.carpet, servo = small)
          step b = grow(p = core, q = core.right, on = Surface.sand, servo = large)
        }
        ",
    );
    let both = example(&rules).unwrap();
    let text = sgc::results::describe::derivation(&rules, &both);
    let first = "grow(p = core, q = left, on = carpet, servo = Servo(tilt = 0 deg, segments = 3))";
    let second = "on = sand, servo = Servo(tilt = 90 deg, segments = 6))";
    assert!(text.contains(first) && text.contains(second), "{text}");

    // Steps are repeated with such values, too: the second can be taken back, and the rest stays.
    let undo = rules.rule("undo").unwrap();
    let last = both.steps.last().unwrap().id;
    let step = grammar_lang::eval::Value::Reference(grammar_lang::eval::Reference::Step(last));
    let one = both.apply(&rules, undo, &[step]).expect("it can be undone");
    assert_eq!(one.steps, both.steps[..1]);
    assert_eq!(one.design.parts.len(), 2);
}

/// What an objective can still come to, seen from the middle of a motion, holds what it comes to.
#[test]
fn limits_of_an_objective_under_way_hold() {
    use sgc::score::ceiling::{Underway, limits};
    use sgc::simulate::model;
    let mut decided = 0;
    for (path, is_bounded) in [
        ("grammars/codesign.sgr", true),
        ("grammars/shepherd.sgr", true),
        ("grammars/steering.sgr", false),
        ("grammars/pneumatic.sgr", false),
    ] {
        let rules = grammar(path);
        let (_, task) = rules.tasks.first().unwrap();
        let mut derivation = Derivation::start(&rules, rules.from.as_deref()).unwrap();
        let mut random = Stream::named(7, "limits");
        for _ in 0..12 {
            if let Some(next) = derivation.advance(&rules, &mut random, 1.0).result {
                derivation = next;
            }
        }
        let candidate = Candidate::new(&rules, Arc::new(derivation));
        let drive = Drive::new(&candidate, task).unwrap();
        let settings = sgc::search::settings(&task.model);
        let mut simulation =
            model("articulated").unwrap().prepare(&candidate.body.assembly, &settings).unwrap();
        for _ in 0..4 {
            let parameters = drive.draw(&mut random);
            let targets = drive.targets(&parameters).unwrap();
            let Ok(motion) = simulation.run(&[targets]).remove(0) else { continue };
            let recording = sgc::score::Recording::nominal(&drive, &parameters, &motion);
            let value = sgc::score::objective(recording).unwrap();
            for pace in [0.002, 0.02, 0.2] {
                if motion.outpaces(pace) {
                    continue;
                }
                for second in 0..=18 {
                    let now = f64::from(second);
                    let frames = (now / motion.interval).round() as usize + 1;
                    let mut part = motion.clone();
                    part.poses.truncate(frames * motion.bodies);
                    let recording = sgc::score::Recording { motion: &part, ..recording };
                    let underway = Underway { recording, now, pace };
                    let (low, high) = limits(underway).unwrap();
                    assert!(
                        low <= value + 1e-9 && value <= high + 1e-9,
                        "{path} {now} s: {low} {value} {high}"
                    );
                    assert!(high.is_finite() || !is_bounded, "{path}: {high}");
                    decided += usize::from(high < 1.5 * value.abs() + 5.0);
                }
            }
        }
    }
    assert!(decided > 20, "the limits say something: {decided}");
}
