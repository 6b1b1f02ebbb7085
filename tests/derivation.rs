//! Derivation of whole designs: snapshots, symmetry, undo, hashes.

use grammar_lang::eval::{KindValue, Reference, Value};
use grammar_lang::ir::RuleSet;
use sgc::derive::Derivation;
use sgc::derive::random::Stream;
use sgc::design::{CORE, Design, PartId, first_of};
use sgc::results::names::Names;
use sgc::testing;

use crate::support::{grammar, read, root};

fn derive(rules: &RuleSet, seed: u64, moves: usize) -> Derivation {
    let mut derivation = Derivation::begin(rules);
    let mut random = Stream::named(seed, "derive");
    for _ in 0..moves {
        if let Some(next) = derivation.advance(rules, &mut random, 1.0).result {
            derivation = next;
        }
    }
    derivation
}

/// Applies a rule by name with values for its locals.
fn apply(rules: &RuleSet, derivation: &Derivation, rule: &str, locals: &[Value]) -> Option<Derivation> {
    let rule = rules.rule(rule).expect("the rule");
    derivation.apply(rules, rule, locals).ok()
}

fn cube() -> Value {
    Value::Kind(KindValue { name: "cube".into(), params: Vec::new() }.into())
}

/// Adds a cube at a port of a part.
fn add_cube(rules: &RuleSet, derivation: &Derivation, part: PartId, port: u8) -> Option<Derivation> {
    let locals = [
        Value::Reference(Reference::Part(part)),
        Value::Reference(Reference::Port(part, port)),
        cube(),
        Value::Number(0.0),
    ];
    apply(rules, derivation, "add_block", &locals)
}

#[test]
fn a_derivation_of_codesign() {
    insta::assert_snapshot!(testing::derivation(root().join("grammars/codesign.sgr"), 4, 30));
}

#[test]
fn a_derivation_of_morphology() {
    insta::assert_snapshot!(testing::derivation(root().join("grammars/morphology.sgr"), 2, 30));
}

#[test]
fn designs_keep_every_requirement_and_can_be_replayed() {
    let rules = grammar("grammars/codesign.sgr");
    let mut largest = 0;
    for seed in 0..40 {
        let derivation = derive(&rules, seed, 40);
        assert_eq!(derivation.broken(&rules).unwrap(), None, "seed {seed}");
        let again = Derivation::replay(&rules, &derivation.steps).unwrap();
        assert_eq!(again.design, derivation.design, "seed {seed}");
        let (design, taken) = (&derivation.design, derivation.design.taken_ports());
        for (id, part) in &design.parts {
            for port in 0..design.port_count(*id) {
                let is_taken = taken.contains(&(*id, port));
                assert_eq!(design.is_free(*id, port), !is_taken, "seed {seed}: port {port} of {}", part.kind);
            }
        }
        largest = largest.max(derivation.design.parts.len());
    }
    assert!(largest > 12, "designs grow: {largest}");
}

#[test]
fn designs_are_their_own_mirror_image() {
    let rules = grammar("grammars/codesign.sgr");
    for seed in 0..20 {
        let design = derive(&rules, seed, 40).design;
        for part in design.parts.values() {
            let p = part.pose.translation.vector;
            let image = design.parts.values().find(|other| {
                let q = other.pose.translation.vector;
                other.kind == part.kind && (p.x - q.x).abs() + (p.y - q.y).abs() + (p.z + q.z).abs() < 1e-9
            });
            assert!(image.is_some(), "seed {seed}: nothing mirrors {part:?}");
        }
    }
}

#[test]
fn a_part_off_the_mirror_plane_comes_with_its_image_and_goes_with_it() {
    let rules = grammar("grammars/codesign.sgr");
    let start = Derivation::begin(&rules);
    let front = add_cube(&rules, &start, CORE, 0).unwrap();
    assert_eq!(front.design.parts.len(), 2, "on the plane: one part");
    let sides = add_cube(&rules, &start, CORE, 2).unwrap();
    assert_eq!(sides.design.parts.len(), 3, "off the plane: two parts");
    let step = Value::Reference(Reference::Step(sides.steps[0].id));
    let undone = apply(&rules, &sides, "undo", &[step]).unwrap();
    assert_eq!(undone.design.parts.len(), 1);
    assert_eq!(undone.design.canonical_hash(), start.design.canonical_hash());
}

#[test]
fn the_hash_ignores_the_order_of_derivation() {
    let rules = grammar("grammars/codesign.sgr");
    let start = Derivation::begin(&rules);
    let (top, side) = (4, 2);
    let one = add_cube(&rules, &add_cube(&rules, &start, CORE, top).unwrap(), CORE, side).unwrap();
    let other = add_cube(&rules, &add_cube(&rules, &start, CORE, side).unwrap(), CORE, top).unwrap();
    assert_ne!(one.steps, other.steps);
    assert_eq!(one.design.canonical_hash(), other.design.canonical_hash());
    let less = add_cube(&rules, &start, CORE, top).unwrap();
    assert_ne!(less.design.canonical_hash(), one.design.canonical_hash());
}

#[test]
fn a_step_that_others_build_on_cannot_be_undone() {
    let rules = grammar("grammars/codesign.sgr");
    let one = add_cube(&rules, &Derivation::begin(&rules), CORE, 0).unwrap();
    let child = *one.design.parts.keys().last().unwrap();
    let two = add_cube(&rules, &one, child, 0).unwrap();
    let undo = |step: usize| {
        let step = Value::Reference(Reference::Step(two.steps[step].id));
        apply(&rules, &two, "undo", &[step])
    };
    assert!(undo(0).is_none(), "the first cube holds the second");
    assert_eq!(undo(1).unwrap().design, one.design);
}

#[test]
fn parts_may_touch_but_not_overlap() {
    let rules = grammar("grammars/codesign.sgr");
    // Round the corner: front, then left of it, then back: beside the core's left.
    let mut design = add_cube(&rules, &Derivation::begin(&rules), CORE, 0).unwrap();
    let front = *design.design.parts.keys().last().unwrap();
    design = add_cube(&rules, &design, front, 2).unwrap();
    assert!(add_cube(&rules, &design, CORE, 2).is_some(), "cubes that touch face to face");
    // A cube whose place is taken by another that hangs elsewhere.
    let side = design.design.parts.keys().copied().nth(2).unwrap();
    let beside_core = (0..6).filter_map(|port| add_cube(&rules, &design, side, port)).find(|d| {
        d.design
            .parts
            .values()
            .any(|p| (p.pose.translation.vector.x).abs() < 1e-9 && p.pose.translation.vector.z > 0.01)
    });
    let taken = beside_core.expect("a cube beside the core");
    assert!(add_cube(&rules, &taken, CORE, 2).is_none(), "the place beside the core is taken");
}

#[test]
fn every_rule_can_apply_and_the_draw_is_even() {
    let rules = grammar("grammars/codesign.sgr");
    let mut counts = std::collections::BTreeMap::new();
    for seed in 0..60 {
        let mut derivation = Derivation::begin(&rules);
        let mut random = Stream::named(seed, "draw");
        for _ in 0..20 {
            let step = derivation.advance(&rules, &mut random, 1.0);
            if let (Some(next), Some(rule)) = (step.result, step.rule) {
                *counts.entry(rules.rules[rule].name.clone()).or_insert(0) += 1;
                derivation = next;
            }
        }
    }
    assert_eq!(counts.len(), rules.rules.len(), "{counts:?}");
    assert!(counts.values().all(|n| *n > 100), "{counts:?}");
}

#[test]
fn a_design_as_the_begin_of_a_grammar_is_the_same_body() {
    let imports = "use std.blocks { cube, ball }\nuse std.actuators { bender }\n";
    let mut images = 0;
    for path in [
        "codesign",
        "morphology",
        "worm",
        "pneumatic",
        "millipede",
        "disk",
        "tree",
        "turtle",
        "rover",
        "salamander",
    ] {
        let path = format!("grammars/{path}.sgr");
        let rules = grammar(&path);
        for seed in 0..8 {
            let derivation = derive(&rules, seed, 30);
            let names = Names::through(&rules, &derivation);
            let design = derivation.design;
            let text = sgc::results::beginning::beginning(&rules, &names, &design);
            images += text.matches(".twin.").count() + text.matches("images(").count();
            // The kinds that the grammar's own parts are called by must be imported to be named.
            let known = read(&path);
            let imports: String = imports
                .lines()
                .filter(|line| known.contains(*line) || known.contains(" of \"./codesign"))
                .collect();
            let name = rules.name.clone();
            let whole = if known.contains("grammar ") {
                let begin = known.find("\nbegin {").expect("a beginning") + 1;
                let end = begin + known[begin..].find("\n}").expect("its end") + 3;
                let whole = format!("{}{text}{}", &known[..begin], &known[end..]);
                let lacks = text.contains("ball") && !known.contains("ball }");
                let import = if lacks { "\nuse std.blocks { ball }\n\nbegin {" } else { "\nbegin {" };
                whole.replacen("\nbegin {", import, 1)
            } else {
                let edit = text.replace("begin {", "replace begin {");
                format!("{imports}\nvariant again of \"{}\" {{\n{edit}}}\n", root().join(&path).display())
            };
            let mut sources = grammar_lang::source::SourceMap::default();
            let entry = sources.add(root().join("grammars/again.sgr").to_string_lossy(), whole);
            let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &[], None);
            let again =
                compiled.ruleset.unwrap_or_else(|| panic!("{name}: {:#?}\n{text}", compiled.diagnostics));
            let begun = Derivation::begin(&again).design;
            assert_eq!(begun.canonical_hash(), design.canonical_hash(), "{path} {seed}\n{text}");
            // What drives an image differs from what drives its original.
            let originals = |design: &Design| {
                let places = design.parts.values().map(|part| {
                    let place = part.pose.translation.vector.map(|x| (x * 1e6).round() as i64);
                    (place.x, place.y, place.z, part.kind.clone(), part.image)
                });
                places.collect::<std::collections::BTreeSet<_>>()
            };
            assert_eq!(originals(&begun), originals(&design), "{path} {seed}\n{text}");
        }
    }
    assert!(images > 10, "rules were applied to images, too");
}

/// Quantities are read back with the same bits, values of an enumeration with their type.
#[test]
fn a_begin_keeps_what_its_parts_are_given() {
    let compiled = |text: String| {
        let mut sources = grammar_lang::source::SourceMap::default();
        let entry = sources.add(root().join("grammars/legs.sgr").to_string_lossy(), text);
        let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &[], None);
        compiled.ruleset.unwrap_or_else(|| panic!("{:#?}", compiled.diagnostics))
    };
    let params = "param lean : Angle = 0 deg\n  param beat : Beat = Beat.still\n  param row ";
    // An example would have to choose what is chosen here in addition.
    let known = read("grammars/millipede.sgr");
    let (text, _) = known.split_once("\nexample ").expect("an example");
    let text = text
        .replacen("part segment {", "enum Beat { still, late }\n\npart segment {", 1)
        .replacen("param row ", params, 1)
        .replacen("row = 0)", "row = 0, lean = lean, beat = beat)", 1)
        .replacen("{\n  match   p : segment with free port q where q is left", "{\n  match   p : segment with free port q where q is left\n  choose  lean in 0 deg .. 90 deg\n  choose  beat in Beat", 1);
    let rules = compiled(text.clone());
    let mut given = 0;
    for seed in 0..40 {
        let derivation = derive(&rules, seed, 6);
        let design = &derivation.design;
        let begin = sgc::results::beginning::beginning(&rules, &Names::through(&rules, &derivation), design);
        given += begin.matches("beat = Beat.late").count();
        let again = compiled(text.replacen("begin {\n  place core : segment\n}\n", &begin, 1));
        let begun = Derivation::begin(&again).design;
        let params = |design: &Design| {
            let mut all: Vec<String> = design
                .parts
                .values()
                .filter(|part| part.image == 0)
                .map(|part| format!("{:?}", part.params))
                .collect();
            all.sort();
            all
        };
        assert_eq!(params(&begun), params(design), "{begin}");
    }
    assert!(given > 3, "{given}");
}

#[test]
fn every_part_has_one_name_whatever_step_is_spoken_of() {
    for path in ["codesign", "morphology", "pneumatic", "millipede", "disk", "tree"] {
        let rules = grammar(&format!("grammars/{path}.sgr"));
        for seed in 0..8 {
            let derivation = derive(&rules, seed, 30);
            let (of, through) = (Names::of(&rules, &derivation.design), Names::through(&rules, &derivation));
            let parts: Vec<PartId> = derivation.design.parts.keys().copied().collect();
            assert_eq!(of.check(&parts), Ok(()));
            assert_eq!(through.check(&parts), Ok(()));
            let mut numbers: Vec<(String, usize)> = Vec::new();
            for (id, part) in &derivation.design.parts {
                let name = of.get(*id).unwrap();
                assert_eq!(through.get(*id), Some(name), "{path} {seed}: the story calls it the same");
                match part.image_of {
                    Some(original) => {
                        let original = of.get(original).unwrap();
                        assert!(name.starts_with(&format!("{original}.twin")), "{name} of {original}");
                    }
                    None if derivation.design.placed.values().any(|placed| placed == id) => {}
                    None => {
                        let (kind, number) = name.rsplit_once('-').unwrap();
                        numbers.push((kind.to_owned(), number.parse().unwrap()));
                    }
                }
            }
            // In the order of making, without gaps.
            for (i, (kind, number)) in numbers.iter().enumerate() {
                let before = numbers[..i].iter().filter(|(other, _)| other == kind).count();
                assert_eq!(*number, before + 1, "{path} {seed}: {numbers:?}");
            }
            derivation.retrace(&rules, |_, before, after| {
                for id in before.parts.keys().chain(after.parts.keys()) {
                    assert!(through.get(*id).is_some(), "{path} {seed}: part {id} has no name");
                }
            });
        }
    }
}

#[test]
fn names_that_a_file_gives_are_each_of_one_part() {
    let names = |text: &str| serde_json::from_str::<Names>(text).unwrap();
    assert_eq!(names(r#"{"0":"core","256":"left leg"}"#).check(&[CORE, first_of(1)]), Ok(()));
    for (text, says) in [
        (r#"{"0":"core"}"#, "its part 256 has no name in it"),
        (r#"{"0":"core","256":"core"}"#, "two of its parts are called `core`"),
        (r#"{"0":"core","256":" "}"#, "` ` cannot be the name of its part 256"),
        (r#"{"0":"core","256":"a\u001b[2J"}"#, "cannot be the name of its part 256"),
    ] {
        let said = names(text).check(&[CORE, first_of(1)]).unwrap_err();
        assert!(said.to_string().contains(says), "{said}");
    }
}

/// A repeated effect attaches a part for each value, in one step that is taken back as a whole.
#[test]
fn an_effect_can_attach_several_parts() {
    let rules = crate::joints::compiled(
        "grammar ring
        use std.blocks     { ball }
        use std.actuators  { bender }
        use std.actuation  { bezier_pac }
        use std.models     { hinge_model }
        use std.objectives { travel }
        use std.search     { recommended }
        part hub {
          shape = disk(4 cm, 1 cm)  density = 1 g/cm^3  friction = 0.8
          port site[i in 0 .. 5] at vector(4 cm * cos(i * 60 deg), 0 cm, 4 cm * sin(i * 60 deg))
            facing vector(cos(i * 60 deg), 0, sin(i * 60 deg))
        }
        begin { place core : hub }
        rule legs {
          match  nothing
          choose step in 1 .. 3
          attach bender(segments = 2 + i) to core.site[i * step] for i in 0 .. 1
          attach ball to core.site[5] as nose
          attach ball to nose.front
        }
        rule far_legs {
          match  nothing
          for i in 3 .. 4, j in 0 .. 0 {
            attach bender(segments = i) to core.site[i + j] as shin
            attach ball to shin.tip as toe
            set    toe.turn = 10 deg * i
          }
        }
        rule undo { match s : step  revert s }
        actuate bender with bezier_pac
        simulate hinge_model for 2 s
        maximize travel in cm
        search recommended",
    );
    let begun = Derivation::begin(&rules);
    let made = apply(&rules, &begun, "legs", &[Value::Number(2.0)]).unwrap();
    let kinds: Vec<&str> = made.design.parts.values().map(|part| part.kind.as_str()).collect();
    assert_eq!(kinds, ["hub", "bender", "bender", "ball", "ball"]);
    let long = made.design.parts.values().filter(|part| part.kind == "bender");
    let long: Vec<f64> = long.map(|part| part.params["segments"].as_number().unwrap()).collect();
    assert_eq!(long, [2.0, 3.0]);
    // The same steps make the same body, and are taken back at once.
    let again = Derivation::replay(&rules, &made.steps).unwrap();
    assert_eq!(again.design.canonical_hash(), made.design.canonical_hash());
    let step = made.steps[0].id;
    let undone = apply(&rules, &made, "undo", &[Value::Reference(Reference::Step(step))]).unwrap();
    assert_eq!(undone.design.parts.len(), 1);

    // What a block makes can be named in it: each ball hangs on its own bender.
    let made = apply(&rules, &made, "far_legs", &[]).unwrap();
    let balls: Vec<_> = made.design.parts.iter().filter(|(_, part)| part.kind == "ball").skip(2).collect();
    let turns: Vec<f64> = balls.iter().map(|(_, ball)| ball.turn.to_degrees().round()).collect();
    assert_eq!(turns, [30.0, 40.0]);
    for (_, ball) in &balls {
        let shin = &made.design.parts[&ball.held_by.unwrap().0];
        assert_eq!(shin.params["segments"].as_number().unwrap() * 10.0, ball.turn.to_degrees().round());
    }
    // A port that is taken refuses the whole step.
    assert!(apply(&rules, &made, "far_legs", &[]).is_none());
    let again = Derivation::replay(&rules, &made.steps).unwrap();
    assert_eq!(again.design.canonical_hash(), made.design.canonical_hash());
    let step = made.steps[1].id;
    let undone = apply(&rules, &made, "undo", &[Value::Reference(Reference::Step(step))]).unwrap();
    assert_eq!(undone.design.parts.len(), 5);
}

/// A grammar of balls on a cube, with these rules beside, for what repetition does to later steps.
fn balls(rules: &str) -> grammar_lang::ir::RuleSet {
    crate::joints::compiled(&format!(
        "grammar balls
        use std.blocks     {{ cube, ball }}
        use std.objectives {{ travel }}
        use std.models     {{ hinge_model }}
        use std.search     {{ plain_annealing }}
        begin {{ place core : cube }}
        rule put {{ match p : part with free port q where p is core  attach ball to q }}
        {rules}
        rule undo {{ match s : step  revert s }}
        simulate hinge_model for 2 s
        maximize travel in cm
        search plain_annealing"
    ))
}

/// What is repeated for other parts after a reversion makes other parts: a step that built on one of them forbids it.
#[test]
fn a_reversion_that_would_give_later_steps_other_parts_is_refused() {
    let rules = balls(
        "rule caps { match nothing  for b in ball { attach cube to b.front } }
         rule grow { match c : cube where c is not core  attach ball to c.front }",
    );
    let put = |derivation: &Derivation, port: u8| {
        let locals = [Value::Reference(Reference::Part(CORE)), Value::Reference(Reference::Port(CORE, port))];
        apply(&rules, derivation, "put", &locals).unwrap()
    };
    let two = put(&put(&Derivation::begin(&rules), 0), 1);
    let capped = apply(&rules, &two, "caps", &[]).unwrap();
    let caps = capped.design.parts.iter().filter(|(id, part)| part.kind == "cube" && **id != CORE);
    let caps: Vec<PartId> = caps.map(|(id, _)| *id).collect();
    let step = |number: usize| Value::Reference(Reference::Step(capped.steps[number].id));
    for (cap, first, second) in [(caps[0], false, true), (caps[1], false, false)] {
        let grown = apply(&rules, &capped, "grow", &[Value::Reference(Reference::Part(cap))]).unwrap();
        // Without the first ball the only cap, the first, sits on the other ball; without the second it stays where it was.
        assert_eq!(apply(&rules, &grown, "undo", &[step(0)]).is_some(), first);
        assert_eq!(apply(&rules, &grown, "undo", &[step(1)]).is_some(), second);
    }
    assert!(apply(&rules, &capped, "undo", &[step(0)]).is_some(), "nothing has built on the caps");
}

/// Blocks within each other are repeated a thousand times in all, however few times each is.
#[test]
fn nested_blocks_have_one_limit() {
    let rules = balls(
        "rule few  { match nothing for i in 0 .. 9 { for j in 0 .. 9 { set b.turn = 1 deg * (i + j) for b in ball } } }
         rule many { match nothing for i in 0 .. 99 { for j in 0 .. 9 { set b.turn = 1 deg * (i + j) for b in ball } } }",
    );
    let locals = [Value::Reference(Reference::Part(CORE)), Value::Reference(Reference::Port(CORE, 0))];
    let one = apply(&rules, &Derivation::begin(&rules), "put", &locals).unwrap();
    assert!(apply(&rules, &one, "few", &[]).is_some());
    assert!(apply(&rules, &one, "many", &[]).is_none());
}

#[test]
fn an_example_tells_what_a_broken_requirement_compares() {
    let name = "grammars/codesign.sgr";
    let text = read(name);
    let own = text.lines().find(|line| line.starts_with("param max_parts")).unwrap();
    let few = own.replace("= 20", "= 2");
    assert_ne!(few, own);
    let step = "step a = add_block(p = core, q = core.left, what = cube, turn = 0 deg)";
    let mut texts = crate::support::texts();
    texts.insert(name.into(), text.replace(own, &few) + "\nexample many {\n" + step + "\n}\n");
    let rules = crate::support::compile_texts(&texts, name).unwrap();
    let failure = sgc::derive::run_example(&rules, "many", &rules.examples["many"]).unwrap_err();
    let reason = &failure.labels[0].text;
    assert!(reason.contains("`few_parts` would be broken"), "{reason}");
    assert!(reason.ends_with("(it is 3, and must be at most 2)"), "{reason}");
}
