//! Parameters of the grammar that rules set: each body has values of its own.

use sgc::derive::{Derivation, check_begun, check_start, overwritten, run_example};
use sgc::design::CORE;
use sgc::results::names::Names;

use crate::joints::compiled;

/// A plate with legs on both sides. All legs have one length.
const PLATE: &str = "
use std.models     { hinge_model }
use std.objectives { travel, fall }
use std.actuators  { bender }
use std.actuation  { bezier_pac }
use std.search     { nested_annealing }

param long : Length in 20 mm .. 60 mm = 40 mm
param wide : Length in 5 mm .. 30 mm = 10 mm
let half = long / 2

part plate {
  shape    = box(2 * long, 1 cm, long)
  density  = 1 g/cm^3
  friction = 0.5
  port back at vector(-long, 0 mm, 0 mm) facing vector(-1, 0, 0)
  port site[i in 0 .. 3] at vector(half * (i - 1), 0 mm, -half) facing vector(0, 0, -1)
  port other[i in 0 .. 3] at vector(half * (i - 1), 0 mm, half) facing vector(0, 0, 1)
}

part leg {
  shape    = box(long, wide, wide)
  density  = 1 g/cm^3
  friction = 0.5
  port back  at vector(-half, 0 mm, 0 mm) facing vector(-1, 0, 0)
  port front at vector(half, 0 mm, 0 mm) facing vector(1, 0, 0)
}

symmetry mirror xy

begin {
  place core : plate
  place tail : bender(segments = 3) to core.back
}

rule add_leg {
  match  p : port where p.free and p is site
  attach leg to p as l
}

rule longer {
  choose l in 20 mm .. 60 mm
  set    long = l
}

rule longer_with_a_leg {
  match  p : port where p.free and p is site
  choose l in 20 mm .. 60 mm
  set    long = l
  attach leg to p as made
  then
  set    wide = min(long / 4, 30 mm)
}

rule undo {
  match  done : step
  revert done
}

require short : long < 58 mm because \"the box is small\"

actuate  bender with bezier_pac
simulate hinge_model for 1 s
search   nested_annealing
maximize travel / long * 1 cm - fall in cm
";

fn plate(clauses: &str, more: &str) -> Result<Derivation, String> {
    let rules = compiled(&format!("grammar plates\n{PLATE}\n{more}\nexample one {{\n{clauses}\n}}"));
    assert!(check_start(&rules).is_none(), "{:?}", check_start(&rules));
    let made =
        run_example(&rules, "one", &rules.examples["one"]).map_err(|failure| format!("{failure:?}"))?;
    let again = Derivation::replay(&rules, &made.steps).unwrap();
    assert_eq!(again.design, made.design);
    Ok(made)
}

#[test]
fn all_parts_follow_and_later_parts_too() {
    plate(
        "step a = add_leg(p = core.site[0])
         expect long == 40 mm and a.l.place.z == -40 mm
         step b = longer(l = 50 mm)
         expect long == 50 mm and a.l.place.z == -50 mm and a.l.twin.place.z == 50 mm
         step c = add_leg(p = core.site[2])
         expect c.l.place.z == -50 mm
         expect core.greatest_corner.x == 50 mm
         expect forall l in leg: abs(l.greatest_corner.z - l.least_corner.z - 50 mm) < 0.001 mm
         expect forall l in leg: abs(l.greatest_corner.y - l.least_corner.y - wide) < 0.001 mm",
        "",
    )
    .unwrap();
}

/// The whole step is taken back, and what it set with it.
#[test]
fn what_is_set_is_undone_with_its_step() {
    plate(
        "step a = longer(l = 50 mm)
         step b = longer_with_a_leg(p = core.site[1], l = 30 mm)
         expect long == 30 mm and wide == 7.5 mm and b.made.place.z == -30 mm
         refuse longer(l = 59 mm) by short
         step c = undo(done = b)
         expect long == 50 mm and wide == 10 mm and count(leg) == 0
         step d = undo(done = a)
         expect long == 40 mm",
        "",
    )
    .unwrap();
}

/// A rule that is carried out always can set one as well; what it sets to a value beyond the domain is refused.
#[test]
fn they_can_follow_from_the_design() {
    let always = "rule as_wide_as_legs_allow {\n always\n set wide = 25 mm - 4 mm * count(leg)\n}";
    plate(
        "expect wide == 25 mm
         step a = add_leg(p = core.site[0])
         expect wide == 17 mm
         step b = add_leg(p = core.site[1])
         expect wide == 9 mm
         refuse add_leg(p = core.site[2])
         expect wide == 9 mm",
        always,
    )
    .unwrap();
}

/// Two bodies whose parts are alike are two bodies if a value is another one: a term may read it.
#[test]
fn a_body_with_another_value_is_another_body() {
    let wider = "rule wider {\n choose w in 5 mm .. 30 mm\n set wide = w\n}";
    let made = plate("step a = wider(w = 20 mm)", wider).unwrap();
    let rules = compiled(&format!("grammar plates\n{PLATE}\n{wider}"));
    let begun = Derivation::begin(&rules);
    assert_eq!(begun.design.parts[&CORE], made.design.parts[&CORE]);
    assert_ne!(begun.design.canonical_hash(), made.design.canonical_hash());
}

/// Outside of rules a parameter is the same for all bodies.
#[test]
fn a_parameter_that_no_rule_sets_belongs_to_no_body() {
    let text = PLATE.replace("  then\n  set    wide = min(long / 4, 30 mm)\n", "");
    let rules = compiled(&format!("grammar plates\n{text}"));
    assert!(rules.params["long"].set_by_rules);
    assert!(!rules.params["wide"].set_by_rules);
}

/// A value that a rule sets back to what it was is none of the body's own: it is the same body again.
#[test]
fn what_is_set_back_is_as_it_was() {
    let made = plate("step a = longer(l = 50 mm)\nstep b = longer(l = 40 mm)", "").unwrap();
    let rules = compiled(&format!("grammar plates\n{PLATE}"));
    assert_eq!(made.design.canonical_hash(), Derivation::begin(&rules).design.canonical_hash());
}

/// Where a rule sets it before the first step, a value from outside would say nothing.
#[test]
fn a_value_from_outside_that_is_overwritten_at_once_is_refused() {
    let found = |always: &str| {
        let mut sources = grammar_lang::source::SourceMap::default();
        let entry = sources.add("own.sgr", format!("grammar plates\n{PLATE}\n{always}"));
        let given = [("wide".to_owned(), "20 mm".to_owned())];
        let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &given, None);
        check_begun(&compiled, entry, &sources).iter().filter(|found| found.is_error()).count()
    };
    assert_eq!(found("rule follows {\n always\n set wide = long / 4\n}"), 1);
    assert_eq!(found("rule follows {\n always\n when count(leg) == 0\n set wide = 12 mm\n}"), 1);
    assert_eq!(found("rule follows {\n always\n when count(leg) > 0\n set wide = 12 mm\n}"), 0);
    assert_eq!(found("rule follows {\n always\n set wide = max(wide, 20 mm)\n}"), 0);
}

/// And where an example does that a search begins with.
#[test]
fn a_value_from_outside_that_the_first_step_overwrites_is_refused() {
    let lost = |value: &str, step: &str| {
        let mut sources = grammar_lang::source::SourceMap::default();
        let example = format!("example begun {{\n step a = {step}\n}}");
        let entry = sources.add("own.sgr", format!("grammar plates\n{PLATE}\n{example}"));
        let given = [("long".to_owned(), value.to_owned())];
        let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &given, None);
        let rules = compiled.ruleset.clone().unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
        let first = Derivation::start(&rules, Some("begun")).unwrap();
        overwritten(&rules, &first.design).len()
    };
    assert_eq!(lost("60 mm", "longer(l = 50 mm)"), 1);
    assert_eq!(lost("50 mm", "longer(l = 50 mm)"), 0);
}

/// A field of a kind whose name another kind gives to a parameter: what the part has is read.
#[test]
fn a_field_and_a_parameter_of_one_name_are_told_apart() {
    let flag = "part flag {
  param stiffness : Number in 0 .. 5 = 3
  shape = box(1 cm, 1 mm, 1 cm)  mass = 1 g  friction = 0.5
}
rule raise {
  match  p : port where p.free and p is other
  attach flag to p as f
}
require stiff : forall a in bender: a.stiffness >= 0.2 N*m/rad^2
require flags : forall f in flag: f.stiffness > 1";
    plate(
        "step a = raise(p = core.other[0])
         expect a.f.stiffness == 3 and tail.stiffness == 0.3 N*m/rad^2 and tail.twin.stiffness == 0.3 N*m/rad^2",
        flag,
    )
    .unwrap();
}

/// In a lattice, too, and what the cells are made of follows.
#[test]
fn lattices_have_values_of_their_own() {
    let rules = compiled(
        "grammar gels
        use std.models     { ball_springs }
        use std.objectives { travel }
        use std.search     { nested_annealing }
        param soft : Stiffness in 100 N/m .. 400 N/m = 200 N/m
        cell gel {
          spacing = 1 cm  mass = 1 g  friction = sqrt(abs(beat - 1.5) - 0.2)  stiffness = soft / 2  damping = 0.1 N*s/m
          param beat : Number in 0 .. 3 = 0
        }
        lattice 3 x 1 x 1 of gel
        begin { fill region(middle, -1 .. 1, 0, 0) with gel }
        rule softer {
          choose s in 100 N/m .. 400 N/m
          set    soft = s
        }
        rule paints {
          match  c : cell
          choose n in 0.0 .. 3.0
          paint  c with gel(beat = n)
        }
        actuation pulse for c : gel {
          vary  size : Number in 0 .. 0.2 mutate 0.5 by normal(0, 0.1)
          drive strain = size * sin(t * 360 deg / 1 s)
        }
        actuate gel with pulse
        example one {
          expect soft == 200 N/m
          step a = softer(s = 300 N/m)
          expect soft == 300 N/m
        }
        example two {
          step a = paints(c = middle, n = 1)
          step b = paints(c = middle, n = 1.5)
        }
        simulate ball_springs for 2 s
        maximize travel in cm
        search nested_annealing",
    );
    let made = run_example(&rules, "one", &rules.examples["one"]).unwrap();
    let refused = run_example(&rules, "two", &rules.examples["two"]).map(|_| ());
    assert!(format!("{refused:?}").contains("no `friction`"), "{refused:?}");
    let springs = |derivation: &Derivation| {
        let body = sgc::design::Body::new(&derivation.design, &rules);
        body.assembly.springs.iter().map(|spring| spring.stiffness).collect::<Vec<_>>()
    };
    let (before, after) = (springs(&Derivation::begin(&rules)), springs(&made));
    assert!(!before.is_empty());
    assert!(
        before.iter().zip(&after).all(|(soft, stiff)| (stiff / soft - 1.5).abs() < 1e-9),
        "{before:?} {after:?}"
    );
}

/// An example that breaks a requirement on each part of a kind says for which one, and what it compares.
#[test]
fn a_requirement_on_each_part_is_told_with_its_numbers() {
    let slender = "require slender : forall l in leg: long / wide >= 4 and l.mass <= 20 g";
    let told = plate("step a = add_leg(p = core.site[0])\nstep b = longer(l = 30 mm)", slender).unwrap_err();
    assert!(told.contains("it is 3 for one `leg`, and must be at least 4"), "{told}");
}

/// Rules and requirements read what a kind says of its joint and of its surface.
#[test]
fn fields_of_kinds_are_read_of_their_parts() {
    plate(
        "expect tail.torque == 0.06 N*m/rad and tail.stiffness == 0.3 N*m/rad^2
         expect core.friction == 0.5 and forall a in bender: a.damping > 0 N*m*s/rad^2",
        "require bends_far : forall a in bender: (a.segments - 1) * a.torque / a.stiffness >= 20 deg",
    )
    .unwrap();
}

/// A body as the text of a grammar says what it was given from outside, and not what a rule sets in any body.
#[test]
fn a_beginning_names_what_was_given() {
    let mut sources = grammar_lang::source::SourceMap::default();
    let always = "rule follows {\n always\n set wide = 12 mm\n}";
    let entry = sources.add("own.sgr", format!("grammar plates\n{PLATE}\n{always}"));
    let given = [("long".to_owned(), "50 mm".to_owned())];
    let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &given, None);
    let rules = compiled.ruleset.unwrap();
    let derivation = Derivation::begin(&rules);
    let names = Names::through(&rules, &derivation);
    let text = sgc::results::beginning::beginning(&rules, &names, &derivation.design);
    assert!(text.contains("write `param long : Length ... = 50 mm`"), "{text}");
    assert!(!text.contains("param wide"), "{text}");
}

/// What takes a step back is no step itself: to take it back in turn does not take back another one.
#[test]
fn a_step_that_takes_one_back_names_no_step() {
    let steps =
        "step a = add_leg(p = core.site[0])\nstep b = add_leg(p = core.site[1])\nstep c = undo(done = b)";
    plate(&format!("{steps}\nexpect count(leg) == 2"), "").unwrap();
    let told = plate(&format!("{steps}\nstep d = undo(done = c)"), "").unwrap_err();
    assert!(told.contains("cannot be applied") || told.contains("not there"), "{told}");
}
