//! Grammars of any length that look like those that people write.

use std::fmt::Write;

/// How a grammar is wrong.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flaw {
    /// It is not.
    None,
    /// Every rule has an error that the parser finds, of several kinds in turn.
    Form,
    /// Every rule has an error that the checker finds, of several kinds in turn.
    Meaning,
}

/// A grammar of about `lines` lines, ending with a variant of many edits.
pub(crate) fn grammar(lines: usize, flaw: Flaw) -> String {
    let mut text = String::from(HEAD);
    let mut count = 0;
    // A unit and what it adds to the variant, the totals and the tail.
    while text.lines().count() < lines.saturating_sub(30 + 6 * count) {
        for _ in 0..(lines / 2000).max(1) {
            unit(&mut text, count, flaw);
            count += 1;
        }
    }
    tail(&mut text, count);
    variant(&mut text, count);
    text
}

const HEAD: &str = r#"## A grammar for measuring how long checking takes.
grammar grown

use std.blocks     { cube, ball }
use std.actuators  { bender }
use std.actuation  { bezier_pac }
use std.objectives { travel, fall }
use std.models     { hinge_model }
use std.search     { nested_annealing }

symmetry mirror xy

begin {
  place core : cube
}

"#;

/// Declarations of every kind that belong together.
fn unit(text: &mut String, i: usize, flaw: Flaw) {
    let mut add = |template: &str| {
        *text += &template.replace('@', &i.to_string());
    };
    add(VALUES);
    add(PART);
    if i.is_multiple_of(4) {
        add(HUB);
        add(ACTUATOR);
    }
    add(match flaw {
        Flaw::None => RULE,
        Flaw::Form => WRONG_FORMS[i % WRONG_FORMS.len()],
        Flaw::Meaning => WRONG_MEANINGS[i % WRONG_MEANINGS.len()],
    });
    add(CONDITIONS);
}

const VALUES: &str = r#"## How long the body of kind @ may become, and how much of it may be spare.
param longest_@ : Count in 2 .. 60 = 20
param reach_@   : Length in 5 cm .. 40 cm = 20 cm   # can be set from outside

let spare_@ = 2 cm + 3 mm * longest_@
let share_@(x : Length, whole : Length) = clamp(x / whole, 0, 1)
let used_@ = share_@(spare_@, reach_@)

enum Surface_@ { carpet, sand, glass }
let grip_@(s : Surface_@) = match s { carpet -> 0.9, sand -> 0.5, glass -> 0.2 }

## A wave, and how far the elements climb on it.
pattern swing_@ = 60 deg * sin(cycle * 360 deg) + 5 deg
term climb_@ : Length = max over e in elements of height(e.position at end) - height(e.position at start)
term drift_@ : Length = max(climb_@ - (mean over e in elements of (e.lowest at end)), 0 cm) * used_@

"#;

const PART: &str = r##"## A brick of kind @.
part brick_@ {
  shape    = box(4 cm, 2 cm, spare_@)   # edges along x, y, z
  mass     = 8.3 g
  friction = grip_@(Surface_@.carpet)
  colour   = "#e8963c"
}

"##;

const HUB: &str = r#"## A disk with places for legs around it.
part hub_@ {
  shape    = disk(4 cm, 1.5 cm)
  density  = 1 g/cm^3
  friction = 0.8

  port site[i in 0 .. 7] at vector(4 cm * cos(i * 45 deg), 0 cm, 4 cm * sin(i * 45 deg))
    facing vector(cos(i * 45 deg), 0, sin(i * 45 deg))
}

"#;

const ACTUATOR: &str = r##"## A finger of kind @ and what drives it.
actuator finger_@ {
  param segments : Count in 2 .. 12 = 5
  param channel  : Count in 0 .. 3 = 0

  segment        = cylinder(9 mm, 2 cm)     # radius, length
  density        = 1 g/cm^3                 # or mass, of one segment
  friction       = 0.8
  bend           = 0 deg .. 90 deg          # of the whole actuator
  bending_speed  = 95 deg/s
  relaxing_speed = 40 deg/s
  torque         = 0.06 N*m/rad
  stiffness      = 0.3 N*m/rad^2
  damping        = 0.01 N*m*s/rad^2
  colour         = "#4f8fc0"
}

actuation wave_@ for a : actuator {
  shared period    : Time  in 2 s .. 6 s           mutate 0.3 by normal(0 s, 1 s)
  vary   amplitude : Angle in 0 deg .. 90 deg      mutate 0.5 by normal(0 deg, 20 deg * temperature)  bound clamp
  vary   offset[2] : Angle in -45 deg .. 45 deg    mutate 0.2 by uniform(-10 deg, 10 deg)
  vary   inverted  : Bool                          flip 0.1
  let    sign  = if inverted then -1 else 1
  drive  angle = sign * amplitude * sin(t / period * 360 deg) + swing_@(fraction(t / period)) + offset[0]
}
actuate finger_@ with wave_@

rule extend_@ {
  match   p : block with free port q where q is left or q is right
  choose  n in 3 .. 5
  attach  finger_@(segments = n) to q as shin
  attach  hub_@ to shin.tip
}

rule channels_@ {
  match   a : finger_@
  choose  c in 0 .. 3
  set     a.channel = c
}

"##;

const RULE: &str = r#"## Adds a brick of kind @ at a free port.
rule add_@ {
  match   p : part with free port q where p is not core
  choose  what in { brick_@, cube, ball }
  choose  turn in { 0 deg, 90 deg, 180 deg, 270 deg }
  when    count(brick_@) < longest_@ and p.depth <= 8
  attach  what to q turned turn
  weight  1 + used_@ / 2
}

"#;

const CONDITIONS: &str = r#"## Takes a brick of kind @ away again.
rule lighten_@ {
  match   a - m - b
  let     heavy = m.mass > 20 g
  when    heavy and m is brick_@ and (a is block or b is block)
  unless  exists n in neighbours(m): n is actuator
  remove  m
}

require few_@   : count(brick_@) <= longest_@                        because "larger designs cost more"
require light_@ : sum over p in brick_@ of p.mass <= 250 g           because "the servos lift no more"
prefer simple_@ : forall a in actuator: a.depth <= 4 or a.image > 0 weight 3 because "every actuator is a day of work"

example built_@ {
  step head = add_@(p = core, q = core.front, what = brick_@, turn = 0 deg)
  expect count(brick_@) == 1 and head.depth == 1
  refuse lighten_@(a = head, m = core, b = head)
}

"#;

/// Rules with an error each that the parser finds.
const WRONG_FORMS: &[&str] = &[
    "rule add_@ {\n  match   p : part with free port q\n  choose  what in { brick_@, cube \n  attach  what to q\n}\n\n",
    "rule add_@ {\n  match   p : part with free port q\n  atach   brick_@ to q\n}\n\n",
    "rule add_@ {\n  match   p : part with free port q\n  when    count(part) = 3\n  attach  brick_@ to q\n}\n\n",
    "rule add_@ {\n  match   p : part with port q\n  attach  brick_@ to q;\n}\n\n",
    "rule add_@ {\n  match   p : part with free port q\n  attach  brick_@ to q\n\n",
    "rul add_@ {\n  match   p : part with free port q\n  attach  brick_@ to q\n}\n\n",
];

/// Rules with an error each that the checker finds.
const WRONG_MEANINGS: &[&str] = &[
    "rule add_@ {\n  match   p : part with free port q\n  attach  bric_@ to q\n}\n\n",
    "rule add_@ {\n  match   p : part with free port q\n  when    p.mass > 20\n  attach  brick_@ to q\n}\n\n",
    "rule add_@ {\n  match   p : part with free port q\n  when    p.masss > 20 g\n  attach  brick_@ to q\n}\n\n",
    "rule add_@ {\n  match   p : part with free port q\n  when    p.mass + p.turn > 20 g\n  attach  brick_@ to q\n}\n\n",
    "rule add_@ {\n  match   p : part with free port q\n  when    travel > 3 cm\n  attach  brick_@ to q\n}\n\n",
    "rule add_@ {\n  match   p : prt with free port q\n  attach  brick_@ to q by frnt\n}\n\n",
];

/// What a grammar has once. No expression is longer than the language allows.
fn tail(text: &mut String, count: usize) {
    let numbers: Vec<usize> = (0..count).collect();
    let mut sums = Vec::new();
    for (i, some) in numbers.chunks(50).enumerate() {
        let all: Vec<String> = some.iter().map(|n| format!("drift_{n}")).collect();
        let _ = writeln!(text, "term all_{i} : Length =\n  {}", all.join("\n    + "));
        sums.push(format!("all_{i}"));
    }
    *text += "\nactuate  bender with bezier_pac\nsimulate hinge_model for 20 s\n";
    let _ = writeln!(text, "maximize travel - fall + {} in cm", sums.join(" + "));
    *text += "search   nested_annealing\n\n";
}

/// A variant that changes something of every unit.
fn variant(text: &mut String, count: usize) {
    *text += "## The same as the workshop can build it.\nvariant workshop of grown {\n";
    for i in 0..count {
        let edit = [
            "  set     longest_@ = 12\n  set     brick_@.mass = 9 g\n",
            "  narrow  add_@.turn in { 0 deg, 90 deg }\n  set     lighten_@.weight = 2\n",
            "  drop    few_@\n  add     require few_more_@ : count(brick_@) <= 9\n",
            "  replace require light_@ : count(ball) == 0 because \"we have no balls\"\n",
        ][i % 4];
        *text += &edit.replace('@', &i.to_string());
    }
    *text += "}\n";
}
