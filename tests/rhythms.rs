//! One rhythm for several actuations: `shared` outside of them.

use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;
use sgc::derive::{Candidate, Derivation, Stream};
use sgc::drive::Drive;
use sgc::loader::Files;

/// A finger of air and one of threads on a cube, which read one period.
const TWO: &str = "grammar two
use std.blocks     { cube }
use std.models     { hinge_model }
use std.objectives { travel }
use std.search     { recommended }
use std.actuators  { bender }
shared period : Time in 2 s .. 6 s mutate 0.3 by normal(0 s, 1 s)
actuator finger {
  param segments : Count in 2 .. 6 = 4
  segment = cylinder(8 mm, 16 mm)  density = 1.1 g/cm^3  friction = 0.8
  bend = 0 deg .. 90 deg  bending_speed = 95 deg/s  relaxing_speed = 40 deg/s
  torque = 0.06 N*m/rad  stiffness = 0.3 N*m/rad^2  damping = 0.01 N*m*s/rad^2
}
actuation swing for a : bender {
  vary  amplitude : Angle in 10 deg .. 80 deg mutate 0.5 by normal(0 deg, 5 deg)
  drive angle = amplitude * sin(t / period * 360 deg)
}
actuation puff for a : finger {
  vary  open : Number in 0.2 .. 0.8 mutate 0.5 by normal(0, 0.1)
  drive valves = cycle(period, [open, 1 - open], [inflate, vent], 0)
}
begin {
  place core : cube
  place one  : bender(segments = 4) to core.front
  place two  : finger to core.back
}
rule grow {
  match  p : part with free port q
  attach cube to q
}
require few : count(part) <= 6
actuate bender with swing
actuate finger with puff
simulate hinge_model for 12 s
maximize travel in cm
search recommended
";

fn compiled(text: &str) -> RuleSet {
    let mut sources = SourceMap::default();
    let entry = sources.add("own.sgr", text);
    let compiled = grammar_lang::compile(&Files, &mut sources, entry, &[], None);
    compiled.ruleset.unwrap_or_else(|| panic!("{:#?}", compiled.diagnostics))
}

fn drive(rules: &RuleSet) -> Drive<'_> {
    let candidate = Candidate::new(rules, Derivation::begin(rules).into());
    Drive::new(&candidate, rules.first_task().unwrap()).unwrap()
}

#[test]
fn all_actuations_read_one_variable() {
    let rules = compiled(TWO);
    let drive = drive(&rules);
    let labels = drive.labels(|_| "a".to_owned());
    assert_eq!(labels.iter().filter(|label| label.starts_with("period")).count(), 1, "{labels:?}");
    assert_eq!(drive.length(), 3, "{labels:?}");
    let place = labels.iter().position(|label| label == "period").unwrap();
    let mut parameters = drive.draw(&mut Stream::named(1, "rhythm"));
    for period in [2.0, 4.0] {
        parameters[place] = period;
        assert_eq!(drive.period(&parameters).unwrap(), period);
        let targets = drive.targets(&parameters).unwrap();
        // Both repeat after it: the angle from the beginning, the finger once it has settled.
        let step = (period / targets.interval).round() as usize;
        for column in 0..2 {
            let at = |row: usize| targets.angles[row * targets.actuators + column];
            let rows = targets.angles.len() / targets.actuators;
            let apart =
                (rows / 2..rows - step).map(|row| (at(row + step) - at(row)).abs()).fold(0.0, f64::max);
            assert!(apart < 0.03, "{column} {period} {apart}");
            let moves = (rows / 2..rows - step).map(|row| (at(row + step / 2) - at(row)).abs());
            assert!(moves.fold(0.0, f64::max) > 0.1, "{column} {period}");
        }
    }
}

/// What terms read as `period` is that one; two periods of their own have none.
#[test]
fn terms_read_the_period_of_all() {
    let reads = "term often : Number = duration / period\nmaximize often * travel in cm";
    compiled(&TWO.replace("maximize travel in cm", reads));
    let own = "  shared period : Time in 2 s .. 6 s mutate 0.3 by normal(0 s, 1 s)\n";
    let apart = TWO
        .replace("shared period : Time in 2 s .. 6 s mutate 0.3 by normal(0 s, 1 s)\n", "")
        .replace("  vary  amplitude", &format!("{own}  vary  amplitude"))
        .replace("  vary  open", &format!("{own}  vary  open"))
        .replace("maximize travel in cm", reads);
    let mut sources = SourceMap::default();
    let entry = sources.add("own.sgr", apart);
    let compiled = grammar_lang::compile(&Files, &mut sources, entry, &[], None);
    let told = format!("{:?}", compiled.diagnostics);
    assert!(told.contains("declare `shared period : Time in ...` once, outside the actuations"), "{told}");
}

/// A body's new parts read the rhythm that the others have found.
#[test]
fn a_child_inherits_the_rhythm_of_all() {
    let rules = compiled(TWO);
    // Without the bender, the rhythm is first read by the other actuation.
    let less = compiled(&TWO.replace("  place one  : bender(segments = 4) to core.front\n", ""));
    let (parent, child) = (drive(&less), drive(&rules));
    let own = parent.labels(|_| "a".to_owned()).iter().position(|label| label == "period").unwrap();
    let place = child.labels(|_| "a".to_owned()).iter().position(|label| label == "period").unwrap();
    let mut parameters = parent.draw(&mut Stream::named(1, "parent"));
    parameters[own] = 3.25;
    let others = child.draw(&mut Stream::named(2, "child"));
    assert_ne!(others[place], 3.25);
    let inherited = child.inherit(&parent, &parameters, others);
    assert_eq!(inherited[place], 3.25);
}

/// `from` says where a search for curves begins: for each actuator by itself, with what is drawn for the others unchanged.
#[test]
fn curves_begin_where_the_grammar_says() {
    let text = TWO
        .replace(
            "shared period : Time in 2 s .. 6 s mutate",
            "shared period : Time in 2 s .. 6 s from 2.5 s mutate",
        )
        .replace("in 10 deg .. 80 deg mutate", "in 10 deg .. 80 deg from 20 deg * a.segments / 2 mutate");
    assert_ne!(text, TWO);
    let (plain, begun) = (compiled(TWO), compiled(&text));
    let (one, other) = (drive(&plain), drive(&begun));
    let labels = other.labels(|_| "a".to_owned());
    let values = |drive: &Drive<'_>| drive.begin(&mut Stream::named(7, "begin"));
    for ((label, drawn), begun) in labels.iter().zip(values(&one)).zip(values(&other)) {
        match label.as_str() {
            "period" => assert_eq!(begun, 2.5),
            "amplitude of a" => assert!((begun - 40_f64.to_radians()).abs() < 1e-12, "{begun}"),
            _ => assert_eq!(begun, drawn, "{label}"),
        }
    }
    // A restart begins elsewhere, and the walk of annealing measures how values spread.
    assert_eq!(other.draw(&mut Stream::named(7, "begin")), values(&one));
    // A value beyond the domain becomes the end of the domain; one that cannot be computed is drawn.
    let place = labels.iter().position(|label| label == "amplitude of a").unwrap();
    for (from, expected) in
        [("20 deg * a.segments", 80_f64.to_radians()), ("20 deg / (a.segments - 4)", values(&one)[place])]
    {
        let text = text.replace("20 deg * a.segments / 2", from);
        let rules = compiled(&text);
        assert!((values(&drive(&rules))[place] - expected).abs() < 1e-12, "{from}");
    }
    // A list begins with one value for each item.
    let list = TWO
        .replace(
            "open : Number in 0.2 .. 0.8 mutate",
            "open[2] : Number in 0.2 .. 0.8 from [0.3, 0.7] mutate",
        )
        .replace("[open, 1 - open]", "open");
    let list = compiled(&list);
    let drive = drive(&list);
    let labels = drive.labels(|_| "a".to_owned());
    let drawn = drive.begin(&mut Stream::named(7, "begin"));
    let of = |name: &str| labels.iter().position(|label| label == name).map(|place| drawn[place]);
    assert_eq!((of("open[0] of a"), of("open[1] of a")), (Some(0.3), Some(0.7)), "{labels:?}");
}

/// A value that is declared outside of the actuations drives as one that each of them declares within itself.
#[test]
fn values_outside_of_actuations_are_those_within() {
    let within = TWO
        .replace("t / period * 360", "t / slow * 360")
        .replace("cycle(period,", "cycle(slow,")
        .replace("  drive", "  let slow = 2 * period\n  drive");
    let outside = within
        .replace("  let slow = 2 * period\n", "")
        .replace("actuation swing", "let slow = twice()\nlet twice() = 2 * period\nactuation swing");
    assert_eq!(outside.matches("slow").count(), 3);
    let (one, other) = (compiled(&within), compiled(&outside));
    let (one, other) = (drive(&one), drive(&other));
    let parameters = one.draw(&mut Stream::named(1, "values"));
    assert_eq!(other.draw(&mut Stream::named(1, "values")), parameters);
    let (one, other) = (one.targets(&parameters).unwrap(), other.targets(&parameters).unwrap());
    assert_eq!(one.angles, other.angles);
    // It is no constant.
    assert!(one.angles.iter().any(|angle| *angle != one.angles[0]));
}

/// A period that is computed outside of the actuations is one for all of them, so that terms can read it.
#[test]
fn terms_read_a_period_that_is_computed_for_all() {
    let text = TWO
        .replace("shared period", "let period = 2 * beat\nshared beat")
        .replace("maximize travel in cm", "maximize duration / period * travel in cm");
    let rules = compiled(&text);
    let drive = drive(&rules);
    let labels = drive.labels(|_| "a".to_owned());
    let place = labels.iter().position(|label| label == "beat").unwrap();
    let mut parameters = drive.draw(&mut Stream::named(1, "rhythm"));
    parameters[place] = 1.5;
    assert_eq!(drive.period(&parameters).unwrap(), 3.0);
}

/// Names of a module mean what they mean there, and its functions read its variables, whatever the grammar that imports them calls so.
#[test]
fn values_of_modules_keep_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let module = "shared rhythm : Time in 1 s .. 3 s mutate 0.3 by normal(0 s, 1 s)
let double = 2 * rhythm
let angle_after(late : Number) = (t / rhythm + late) * 360 deg
";
    std::fs::write(folder.path().join("beat.sgr"), module).unwrap();
    let made = |name: &str, own: &str, text: &str| {
        let path = folder.path().join(name);
        let text = text.replace(
            "shared period : Time in 2 s .. 6 s mutate 0.3 by normal(0 s, 1 s)",
            &format!("use \"./beat.sgr\" {{ double, angle_after }}\n{own}"),
        );
        let mut sources = SourceMap::default();
        let entry = sources.add(path.to_str().unwrap(), &text);
        grammar_lang::compile(&Files, &mut sources, entry, &[], None)
    };
    let text = |pace: &str| {
        TWO.replace(
            "sin(t / period * 360 deg)",
            &format!("(sin(t / {pace} * 360 deg) + sin(angle_after(0.25)))"),
        )
        .replace("cycle(period,", "cycle(double,")
    };
    let other = made("other.sgr", "let pace = 5 s", &text("pace")).ruleset.unwrap();
    let drive = drive(&other);
    let labels = drive.labels(|_| "a".to_owned());
    assert_eq!(labels.iter().filter(|label| label.starts_with("rhythm")).count(), 1, "{labels:?}");
    drive.targets(&drive.draw(&mut Stream::named(1, "modules"))).unwrap();
    // Two things of one name cannot be told apart in results; neither is taken for the other.
    let shared = "shared rhythm : Time in 5 s .. 6 s mutate 0.3 by normal(0 s, 1 s)";
    for (own, reason) in [
        ("let rhythm = 5 s", "two modules declare `rhythm`"),
        (shared, "this actuation has two variables `rhythm`"),
    ] {
        let told = format!("{:?}", made("two.sgr", own, &text("rhythm")).diagnostics);
        assert!(told.contains(reason), "{told}");
    }
}

/// What terms read as `period` is a time.
#[test]
fn a_period_is_a_time() {
    for wrong in [
        "shared period[3] : Time in 2 s .. 6 s mutate 0.3 by normal(0 s, 1 s)",
        "shared period : Number in 2.0 .. 6.0 mutate 0.3 by normal(0, 1)",
    ] {
        let text = TWO
            .replace("shared period : Time in 2 s .. 6 s mutate 0.3 by normal(0 s, 1 s)", wrong)
            .replace("  drive angle", "  let turns = first([period])\n  drive angle")
            .replace("sin(t / period * 360 deg)", "sin(t / 2 s * 360 deg)")
            .replace("cycle(period,", "cycle(2 s,")
            .replace("maximize travel in cm", "maximize duration / period * travel in cm");
        let mut sources = SourceMap::default();
        let entry = sources.add("own.sgr", text);
        let compiled = grammar_lang::compile(&Files, &mut sources, entry, &[], None);
        let told = format!("{:?}", compiled.diagnostics);
        assert!(told.contains("is not a single time"), "{wrong}: {told}");
    }
}
