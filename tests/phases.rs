//! Rules that do one thing and then another: effects below `then` read what those above have made. Rules that are carried out after
//! every step.

use sgc::derive::{Derivation, check_start, run_example};

use crate::joints::compiled;

/// A sledge with a tray on a sprung strut: the preload of the spring follows from what it carries.
const SLEDGE: &str = "
use std.blocks     { cube }
use std.actuators  { bender }
use std.actuation  { bezier_pac }
use std.objectives { travel, fall }
use std.models     { hinge_model }
use std.search     { nested_annealing }

part strut {
  param carries : Mass in 0 g .. 500 g = 0 g
  shape     = box(1 cm, 1 cm, 1 cm)
  mass      = 5 g
  friction  = 0.5
  joint     = slide along y passive
  range     = -30 mm .. 30 mm
  neutral   = -carries * hinge_model.gravity / (100 N/m)
  stiffness = 100 N/m
  damping   = 1 N*s/m
  port back  at vector(-5 mm, 0 mm, 0 mm) facing vector(-1, 0, 0)
  port front at vector(5 mm, 0 mm, 0 mm)  facing vector(1, 0, 0)
}

part tray {
  param load : Mass in 0 g .. 400 g = 50 g
  shape    = box(4 cm, 1 cm, 4 cm)
  mass     = 30 g + load
  friction = 0.5
  port back  at vector(-2 cm, 0 mm, 0 mm) facing vector(-1, 0, 0)
  port front at vector(2 cm, 0 mm, 0 mm)  facing vector(1, 0, 0)
}

begin {
  place core : cube
  place s    : strut to core.front
  place b    : tray to s.front
}

rule fill_tray {
  choose  load in 0 g .. 400 g
  set     b.load = load
  then
  set     s.carries = b.mass
}

# The same without `then`: what it reads is what was there before the rule.
rule late {
  choose  load in 0 g .. 400 g
  set     b.load    = load
  set     s.carries = b.mass
}

# Another tray in the place of a load, then all trays are made alike, those just made among them.
rule lengthen {
  choose  load in 0 g .. 400 g
  attach  tray(load = 0 g) to b.front as c
  then
  let     all = count(tray)
  set     t.load = load / all for t in tray
  then
  set     s.carries = sum over t in tray of t.mass
}

rule bend {
  attach  bender(segments = 4) to core.back as a
  attach  cube to a.tip
}

rule undo {
  match   done : step where done adds part
  revert  done
}

actuate  bender with bezier_pac
simulate hinge_model for 1 s
search   nested_annealing
maximize travel - fall in cm
";

/// Runs the only example of a grammar.
fn example(clauses: &str) -> Result<Derivation, String> {
    let rules = compiled(&format!("grammar feature\n{SLEDGE}\nexample one {{\n{clauses}\n}}"));
    assert!(check_start(&rules).is_none(), "{:?}", check_start(&rules));
    run_example(&rules, "one", &rules.examples["one"]).map_err(|failure| format!("{failure:?}"))
}

#[test]
fn below_then_effects_read_what_was_done_above() {
    example(
        "step a = fill_tray(load = 100 g)
         expect s.carries == 130 g
         step b2 = late(load = 200 g)
         expect s.carries == 130 g and b.mass == 230 g
         step c = fill_tray(load = 300 g)
         expect s.carries == 330 g",
    )
    .unwrap();
}

#[test]
fn what_stands_below_then_runs_over_what_was_just_made() {
    example(
        "step more = lengthen(load = 100 g)
         expect count(tray) == 2 and more.c.load == 50 g and b.load == 50 g
         expect s.carries == 160 g",
    )
    .unwrap();
}

/// The whole step is taken back, whatever stands on which side of `then`; what came later is done again.
#[test]
fn a_step_of_several_phases_is_one_step() {
    example(
        "step more = lengthen(load = 100 g)
         step bent = bend()
         step less = undo(done = more)
         expect count(tray) == 1 and count(bender) == 1 and s.carries == 0 g and b.load == 50 g",
    )
    .unwrap();
}

/// The sledge, where a rule that is carried out always sets what the spring carries.
fn kept(clauses: &str) -> Result<Derivation, String> {
    let sledge = SLEDGE.replace("  then\n  set     s.carries = b.mass\n", "");
    let sledge = sledge.replace("  then\n  set     s.carries = sum over t in tray of t.mass\n", "");
    let always = "rule springs_carry {\n always\n let load = sum over w in hanging_on(s) of w.mass\n set s.carries = load\n}\n";
    let rules = compiled(&format!("grammar feature\n{sledge}\n{always}\nexample one {{\n{clauses}\n}}"));
    assert!(check_start(&rules).is_none(), "{:?}", check_start(&rules));
    let made =
        run_example(&rules, "one", &rules.examples["one"]).map_err(|failure| format!("{failure:?}"))?;
    let again = Derivation::replay(&rules, &made.steps).unwrap();
    assert_eq!(again.design.canonical_hash(), made.design.canonical_hash());
    Ok(made)
}

#[test]
fn what_follows_from_the_design_is_set_after_begin_and_after_every_step() {
    kept(
        "expect s.carries == 80 g
         step a = fill_tray(load = 100 g)
         expect s.carries == 130 g
         step b2 = late(load = 200 g)
         expect s.carries == 230 g
         step more = lengthen(load = 100 g)
         expect s.carries == 160 g and count(tray) == 2
         step less = undo(done = more)
         expect s.carries == 230 g and count(tray) == 1",
    )
    .unwrap();
}

/// More than 500 g is beyond what the spring can be set for.
#[test]
fn a_step_after_which_it_cannot_be_carried_out_is_undone() {
    let always = "rule springs_carry {\n always\n set s.carries = 1.2 * b.mass\n}\n";
    let sledge = SLEDGE.replace("  then\n  set     s.carries = b.mass\n", "");
    let clauses = "step a = fill_tray(load = 300 g)
         refuse fill_tray(load = 400 g)
         expect s.carries == 396 g and b.load == 300 g";
    let rules = compiled(&format!("grammar feature\n{sledge}\n{always}\nexample one {{\n{clauses}\n}}"));
    run_example(&rules, "one", &rules.examples["one"]).unwrap();
}

/// Of several, each reads what those before it have left, and one whose condition does not hold is left out.
#[test]
fn those_carried_out_always_follow_each_other() {
    let sledge =
        SLEDGE.replace("  place b    : tray to s.front\n", "  place b    : tray(load = 0 g) to s.front\n");
    let always = "rule first_this {\n always\n set t.load = 20 g for t in tray\n}
        rule then_that {\n always\n when b.load == 20 g\n set s.carries = b.mass\n}
        rule never {\n always\n unless b.load == 20 g\n set s.carries = 400 g\n}\n";
    let text = format!("grammar feature\n{sledge}\n{always}\nexample one {{\nexpect s.carries == 50 g\n}}");
    let rules = compiled(&text);
    run_example(&rules, "one", &rules.examples["one"]).unwrap();
}

/// What passes from part to part settles in the same step, so it does not matter how a body was made: after a step is taken back, it is what its
/// other steps make.
#[test]
fn what_passes_from_part_to_part_settles() {
    let limbs = "part limb {
  param wide : Length in 3 mm .. 20 mm = 10 mm
  shape    = box(2 cm, wide, wide)
  density  = 1 g/cm^3
  friction = 0.5
  port back  at vector(-1 cm, 0 mm, 0 mm) facing vector(-1, 0, 0)
  port front at vector(1 cm, 0 mm, 0 mm)  facing vector(1, 0, 0)
}
rule tapers {\n always\n set l.wide = max(0.8 * l.holder.wide, 3 mm) for l in limb where l.holder is limb\n}
rule widen {\n choose w in 3 mm .. 20 mm\n set first.wide = w\n}
rule grow {\n match p : limb with free port q where q is front\n attach limb to q as l\n}
";
    let sledge = SLEDGE.replace(
        "  place b    : tray to s.front\n",
        "  place b    : tray to s.front\n  place first : limb to b.front\n",
    );
    let clauses = "step a = grow(p = first, q = first.front)
         step b2 = grow(p = a.l, q = a.l.front)
         step more = grow(p = b2.l, q = b2.l.front)
         step w = widen(w = 20 mm)
         expect abs(b2.l.wide - 12.8 mm) < 1 um
         expect abs(more.l.wide - 10.24 mm) < 1 um
         step less = undo(done = more)
         expect abs(b2.l.wide - 12.8 mm) < 1 um and count(limb) == 3";
    let rules = compiled(&format!("grammar feature\n{sledge}\n{limbs}\nexample one {{\n{clauses}\n}}"));
    let made = run_example(&rules, "one", &rules.examples["one"]).unwrap();
    let again = Derivation::replay(&rules, &made.steps).unwrap();
    assert_eq!(again.design, made.design);
}

#[test]
fn what_never_settles_is_an_error() {
    let always = "rule flips {\n always\n set b.load = 100 g - b.load\n}\n";
    let sledge = SLEDGE.replace("b    : tray to", "b    : tray(load = 20 g) to");
    let rules = compiled(&format!("grammar feature\n{sledge}\n{always}"));
    let found = check_start(&rules).unwrap();
    assert!(format!("{found:?}").contains("do not settle"), "{found:?}");
}

#[test]
fn a_beginning_where_it_cannot_be_carried_out_is_an_error() {
    let always = "rule springs_carry {\n always\n set s.carries = 10 * b.mass\n}\n";
    let rules = compiled(&format!("grammar feature\n{SLEDGE}\n{always}"));
    let found = check_start(&rules).unwrap();
    assert!(format!("{found:?}").contains("carries"), "{found:?}");
}
