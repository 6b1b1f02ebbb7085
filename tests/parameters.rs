//! Parts with parameters that their own fields read: sizes, masses, ports and strength follow from them.

use grammar_lang::eval::Value;
use grammar_lang::ir::{RuleSet, Settable};
use grammar_lang::source::SourceMap;
use sgc::derive::{Derivation, Stream};
use sgc::design::assembly::Shape;
use sgc::design::{Attachment, Body, CORE, Design, Refusal, ports};
use sgc::loader::Files;

use crate::support::grammar;

fn tree() -> RuleSet {
    grammar("grammars/tree.sgr")
}

/// What a limb of a level has in place of one of level 0.
fn shrink(level: f64) -> f64 {
    libm::exp(level * libm::log(0.8))
}

/// A part of a kind at a port of another, by name.
fn attach(design: &mut Design, rules: &RuleSet, kind: &str, level: f64, at: (usize, &str), step: u64) {
    let part = *design.parts.get_index(at.0).unwrap().0;
    let port = ports(&design.parts[&part]).iter().position(|port| port.name == at.1).unwrap() as u8;
    let params = vec![("level".to_owned(), Value::Number(level))];
    let attachment =
        Attachment { kind: kind.to_owned(), params, part, port, turn: 0.0, by: None, alone: false };
    design.attach(rules, &attachment, step).unwrap();
}

/// A limb of level 0 on top of the core, a fork of level 1 on it, and a foot of level 1 on that.
fn limb_fork_foot(rules: &RuleSet) -> Design {
    let mut design = Design::core(rules, "cube", &[]).unwrap();
    attach(&mut design, rules, "limb", 0.0, (0, "top"), 1);
    attach(&mut design, rules, "fork", 1.0, (1, "tip"), 2);
    attach(&mut design, rules, "foot", 1.0, (2, "up"), 3);
    design
}

#[test]
fn sizes_masses_and_strength_follow_from_the_parameter() {
    let rules = tree();
    for level in [0.0, 1.0, 3.0] {
        let mut design = Design::core(&rules, "cube", &[]).unwrap();
        attach(&mut design, &rules, "limb", level, (0, "top"), 1);
        let body = Body::new(&design, &rules);
        let (radius, length, density) = (8e-3 * shrink(level), 4.0 * 16e-3 * shrink(level), 1100.0);
        let id = *design.parts.get_index(1).unwrap().0;
        let elements: Vec<_> = body.elements_of(id).map(|i| &body.assembly.elements[i]).collect();
        assert_eq!(elements.len(), 4);
        for element in &elements {
            let Shape::Cylinder { radius: own, .. } = element.shape else { panic!("{:?}", element.shape) };
            assert!((own - radius).abs() < 1e-12, "{own} {radius}");
        }
        let mass: f64 = elements.iter().map(|element| element.mass).sum();
        let whole = density * std::f64::consts::PI * radius * radius * length;
        assert!((mass - whole).abs() < 1e-12, "{mass} {whole}");
        assert!((design.mass(id).unwrap() - whole).abs() < 1e-12);
        let tip = &ports(&design.parts[&id])[1];
        assert!((tip.frame.translation.vector.x - length).abs() < 1e-12);
        let hinge = body.assembly.joints.iter().flat_map(|joint| joint.kind.dofs()).next();
        let hinge = hinge.unwrap();
        assert!((hinge.effort - 0.06 * shrink(3.0 * level)).abs() < 1e-12);
        assert!((hinge.stiffness - 0.3 * shrink(3.0 * level)).abs() < 1e-12);
        // How far it bends is that of its kind.
        assert!((hinge.limits.1 - std::f64::consts::FRAC_PI_2 / 3.0).abs() < 1e-12);
    }
}

#[test]
fn what_hangs_on_a_part_moves_when_its_parameter_is_set() {
    let rules = tree();
    let mut design = limb_fork_foot(&rules);
    let [fork, foot] = [2, 3].map(|place| *design.parts.get_index(place).unwrap().0);
    let place = |design: &Design, id| design.parts[&id].pose.translation.vector;
    let before = (place(&design, fork), place(&design, foot), design.canonical_hash());
    design.set(&rules, fork, &Settable::Param("level".to_owned()), &Value::Number(3.0)).unwrap();
    let after = (place(&design, fork), place(&design, foot));
    // The fork is held by its back: its middle comes as much nearer as its radius shrinks.
    let nearer = 10e-3 * (shrink(1.0) - shrink(3.0));
    assert!(((before.0 - after.0).norm() - nearer).abs() < 1e-12);
    assert!((before.1 - after.1).norm() > nearer, "what hangs on it moves by its own port, too");
    assert_ne!(design.canonical_hash(), before.2, "it is another body");
    // The other way round it is the same body again.
    design.set(&rules, fork, &Settable::Param("level".to_owned()), &Value::Number(1.0)).unwrap();
    assert_eq!(design.canonical_hash(), before.2);
    let beyond = design.set(&rules, fork, &Settable::Param("level".to_owned()), &Value::Number(9.0));
    assert!(matches!(beyond, Err(Refusal::BadParameter { name, .. }) if name == "level"));
}

#[test]
fn a_search_makes_limbs_of_every_level_with_a_foot_on_every_leaf() {
    let rules = tree();
    let mut levels = [0; 4];
    for seed in 0..20 {
        let mut derivation = Derivation::begin(&rules);
        let mut random = Stream::named(seed, "tree");
        for _ in 0..30 {
            if let Some(next) = derivation.advance(&rules, &mut random, 1.0).result {
                derivation = next;
            }
        }
        let design = &derivation.design;
        for (id, part) in design.parts.iter().filter(|(_, part)| part.kind == "limb") {
            let Some(Value::Number(level)) = part.params.get("level") else { panic!("{:?}", part.params) };
            levels[*level as usize] += 1;
            let held = design.parts.values().filter(|other| other.held_by.is_some_and(|(by, _)| by == *id));
            let kinds: Vec<&str> = held.map(|other| other.kind.as_str()).collect();
            assert!(matches!(kinds.as_slice(), ["foot" | "fork"]), "{kinds:?}");
        }
        // The steps make the same body again, bit for bit.
        let again = Derivation::replay(&rules, &derivation.steps).unwrap();
        assert_eq!(again.design, derivation.design);
    }
    assert!(levels.iter().all(|count| *count > 0), "{levels:?}");
}

fn compiled(text: &str) -> RuleSet {
    let mut sources = SourceMap::default();
    let entry = sources.add("own.sgr", text);
    let compiled = grammar_lang::compile(&Files, &mut sources, entry, &[], None);
    compiled.ruleset.unwrap_or_else(|| panic!("{:#?}", compiled.diagnostics))
}

const OWN: &str = "grammar own
use std.actuators  { bender }
use std.actuation  { bezier_pac }
use std.models     { hinge_model }
use std.objectives { travel }
use std.search     { recommended }
part core_block { shape = box(3 cm, 3 cm, 3 cm) density = 1 g/cm^3 friction = 0.8 }
part slab {
  param wide : Length in 1 cm .. 4 cm = 2 cm
  shape    = box(2 cm, 1 cm, wide)
  mass     = 10 g * wide / 2 cm
  friction = 0.8
}
part stick {
  param wide : Length in 1 cm .. 4 cm = 2 cm
  param hard : Bool = false
  shape    = capsule(wide / 4, 2 * wide)
  density  = if hard then 2 g/cm^3 else 1 g/cm^3
  friction = if hard then 0.4 else 1.0
  colour   = if hard then \"#111111\" else \"#eeeeee\"
}
begin { place core : core_block }
rule grow {
  match  p : block with free port q
  choose what in { slab, stick }
  choose w in 1 cm .. 4 cm
  attach what(wide = w) to q
}
rule bend {
  match  p : block with free port q
  attach bender to q
}
require few   : count(part) <= 12
require apart : no_overlap
actuate  bender with bezier_pac
simulate hinge_model for 5 s
maximize travel in cm
search   recommended
";

/// A chosen kind takes a parameter that all that may be chosen have.
#[test]
fn a_chosen_kind_takes_the_parameters_that_its_choices_share() {
    let rules = compiled(OWN);
    let mut kinds = std::collections::BTreeMap::new();
    for seed in 0..30 {
        let mut derivation = Derivation::begin(&rules);
        let mut random = Stream::named(seed, "own");
        for _ in 0..20 {
            if let Some(next) = derivation.advance(&rules, &mut random, 1.0).result {
                derivation = next;
            }
        }
        let body = Body::new(&derivation.design, &rules);
        for (id, part) in &derivation.design.parts {
            let Some(Value::Number(wide)) = part.params.get("wide") else { continue };
            let [element] = body.elements_of(*id).collect::<Vec<_>>()[..] else { panic!("one element") };
            let element = &body.assembly.elements[element];
            *kinds.entry(part.kind.clone()).or_insert(0) += 1;
            match (part.kind.as_str(), element.shape) {
                ("slab", Shape::Box { half }) => {
                    assert!((2.0 * half.z - wide).abs() < 1e-12);
                    assert!((element.mass - 0.01 * wide / 0.02).abs() < 1e-12);
                }
                ("stick", Shape::Capsule { radius, .. }) => assert!((radius - wide / 4.0).abs() < 1e-12),
                other => panic!("{other:?}"),
            }
        }
    }
    assert!(kinds.len() == 2 && kinds.values().all(|many| *many > 10), "{kinds:?}");
}

/// What a field comes to is written by `compile` as the grammar says it.
#[test]
fn the_resolved_text_shows_what_fields_read() {
    let text = grammar_lang::ir::resolved(&compiled(OWN));
    for line in [
        "  param wide : Length in 10 mm .. 40 mm = 20 mm",
        "  shape = box(20 mm, 10 mm, wide)",
        "  friction = (if hard then 0.4 else 1)",
        "  attach what(wide = w) to q",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }
}

/// Parts that differ in a parameter only are different bodies, also where nothing moves by it.
#[test]
fn the_core_has_parameters_too() {
    let rules =
        compiled(&OWN.replace("place core : core_block", "place core : stick(wide = 3 cm, hard = true)"));
    let design = Derivation::begin(&rules).design;
    let body = Body::new(&design, &rules);
    let [core] = body.assembly.elements.as_slice() else { panic!("one element") };
    assert!((core.friction - 0.4).abs() < 1e-12);
    let volume = core.shape.volume();
    assert!((core.mass - 2000.0 * volume).abs() < 1e-12, "{} {volume}", core.mass);
    assert!((design.mass(CORE).unwrap() - core.mass).abs() < 1e-15);
    let other = compiled(&OWN.replace("place core : core_block", "place core : stick(wide = 3 cm)"));
    assert_ne!(design.canonical_hash(), Derivation::begin(&other).design.canonical_hash());
}

/// A grammar with a part of each of two materials, and one with a text for a colour.
const MADE_OF: &str = "grammar made_of
use std.actuators  { bender }
use std.actuation  { bezier_pac }
use std.blocks     { cube }
use std.models     { hinge_model }
use std.objectives { travel }
use std.search     { recommended }
enum Mat { foam, steel }
param usual_width : Length in 1 cm .. 4 cm = 2 cm
part slab {
  param mat  : Mat
  param wide : Length in 1 cm .. 4 cm = usual_width
  param tint : Text = \"#aaaaaa\"
  shape    = box(2 cm, 1 cm, wide)
  density  = if mat == Mat.foam then 0.1 g/cm^3 else 7.8 g/cm^3
  friction = 0.8
  colour   = tint
}
begin {
  place core : cube
  place one  : bender(segments = 4) to core.back
}
rule add {
  match  p : block with free port q
  choose m in Mat
  attach slab(mat = m, tint = \"#00ff00\") to q
}
require few : count(part) <= 4
actuate  bender with bezier_pac
simulate hinge_model for 3 s
maximize travel in cm
search   recommended
example two {
  step first = add(p = core, q = core.front, m = Mat.steel)
}
";

#[test]
fn the_order_in_which_parameters_are_declared_makes_no_other_body() {
    let mat = "  param mat  : Mat\n";
    let wide = "  param wide : Length in 1 cm .. 4 cm = usual_width\n";
    let other = MADE_OF.replace(&format!("{mat}{wide}"), &format!("{wide}{mat}"));
    assert_ne!(other, MADE_OF);
    let hash = |text: &str| Derivation::start(&compiled(text), Some("two")).unwrap().design.canonical_hash();
    assert_eq!(hash(MADE_OF), hash(&other));
    let foam = MADE_OF.replace("m = Mat.steel", "m = Mat.foam");
    assert_ne!(hash(MADE_OF), hash(&foam));
}

#[test]
fn a_begin_quotes_texts_and_writes_what_a_parameter_may_change() {
    let rules = compiled(MADE_OF);
    let derivation = Derivation::start(&rules, Some("two")).unwrap();
    let names = sgc::results::names::Names::through(&rules, &derivation);
    let text = sgc::results::beginning::beginning(&rules, &names, &derivation.design);
    assert!(text.contains("slab(mat = Mat.steel, wide = 20 mm, tint = \"#00ff00\")"), "{text}");
    let begin = MADE_OF.find("begin {").unwrap();
    let end = begin + MADE_OF[begin..].find("\n}\n").unwrap() + 3;
    let again =
        compiled(&format!("{}{text}{}", &MADE_OF[..begin], &MADE_OF[end..]).replace("step first", "step a"));
    assert_eq!(Derivation::begin(&again).design.canonical_hash(), derivation.design.canonical_hash());
}

/// A saved design keeps values of an enumeration by their place: a grammar that has others there refuses it.
#[test]
fn a_design_is_not_read_with_other_values_of_an_enumeration() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        file.to_string_lossy().into_owned()
    };
    let own = file("own.sgr", MADE_OF);
    let run = ["run", &own, "--from", "two", "--max-evals", "12", "--quiet", "--out", "r"];
    let output = crate::support::sgc(folder.path(), &run);
    assert_eq!(output.status.code(), Some(0), "{}", crate::support::said(&output));
    let before = file("before.sgr", &MADE_OF.replace("{ foam, steel }", "{ wood, foam, steel }"));
    let after = file("after.sgr", &MADE_OF.replace("{ foam, steel }", "{ foam, steel, wood }"));
    for (arguments, code) in [
        (vec!["eval", "r", "--grammar", &before], 1),
        (vec!["audit", &before, "--design", "r", "--walks", "1", "--steps", "2"], 1),
        (vec!["run", &before, "--from-design", "r", "--max-evals", "5", "--out", "b"], 1),
        (vec!["eval", "r", "--grammar", &after], 0),
    ] {
        let output = crate::support::sgc(folder.path(), &arguments);
        let said = crate::support::said(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert_eq!(said.contains("as its place in the list"), code == 1, "{arguments:?}: {said}");
    }
}

/// What differs from the end of a domain by rounding only lies within it.
#[test]
fn a_domain_holds_what_is_its_end_but_for_rounding() {
    let rules = compiled(
        "grammar feet
        use std.blocks     { cube }
        use std.actuators  { bender }
        use std.actuation  { bezier_pac }
        use std.objectives { travel }
        use std.models     { hinge_model }
        use std.search     { nested_annealing }
        part foot {
          shape = box(1 cm, 1 cm, 1 cm)  density = 1 g/cm^3  friction = 0.8
          param share : Number in 0 % .. 30 % = 0 %
        }
        begin {
          place core : cube
          place leg : bender(segments = 3) to core.left
        }
        rule add {
          match  p : cube with free port q
          choose k in 1 .. 3
          attach foot(share = k * 10 %) to q
        }
        actuate bender with bezier_pac
        simulate hinge_model for 2 s
        maximize travel in cm
        search nested_annealing
        example third { step a = add(p = core, q = core.right, k = 3)  expect a.share == 30 % }",
    );
    let third = sgc::derive::run_example(&rules, "third", &rules.examples["third"]);
    assert!(third.is_ok(), "{:?}", third.map(|_| ()));
}
