//! Every number of the standard library is the grammar's, not the engine's:
//! editing it in the text changes the typed rule set, and what the engine does.

use std::collections::BTreeMap;
use std::sync::Arc;

use grammar_lang::ir::{RuleSet, without_spans};
use nalgebra::{Isometry3, Vector3};
use sgc::derive::random::Stream;
use sgc::derive::{Candidate, Derivation};
use sgc::design::assembly::Element;
use sgc::drive::Drive;
use sgc::score::Recording;
use sgc::simulate::Motion;
use sgc::simulate::motion::Placement;

use crate::support::{compile_texts, read, root, texts};

/// The places of the numbers in a text, outside comments and quotes.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let (mut i, mut quoted, mut comment) = (0, false, false);
    while i < bytes.len() {
        let before = if i == 0 { b' ' } else { bytes[i - 1] };
        let in_word = before.is_ascii_alphanumeric() || b"_^.".contains(&before);
        match bytes[i] {
            b'\n' => (quoted, comment) = (false, false),
            b'#' if !quoted => comment = true,
            b'"' if !comment => quoted = !quoted,
            c if c.is_ascii_digit() && !quoted && !comment && !in_word => {
                let start = i;
                while i < bytes.len()
                    && (bytes[i].is_ascii_digit() || bytes[i] == b'.' && bytes.get(i + 1) != Some(&b'.'))
                {
                    i += 1;
                }
                found.push(start..i);
                continue;
            }
            _ => {}
        }
        i += 1;
    }
    found
}

/// What the engine makes of a rule set: bodies, targets, mutations, settings, scores.
fn engine(rules: &RuleSet) -> String {
    let mut derivation = Derivation::start(rules, rules.from.as_deref()).unwrap();
    let mut moving = derivation.clone();
    let mut random = Stream::named(5, "test");
    for _ in 0..60 {
        if let Some(next) = derivation.advance(rules, &mut random, 1.0).result {
            derivation = next;
        }
        // The test needs a body that moves: the last one that does.
        if derivation.design.parts.values().any(|p| rules.is_driven(&p.kind)) {
            moving = derivation.clone();
        }
    }
    let derivation = Arc::new(moving);
    let candidate = Candidate::new(rules, derivation);
    let body = &candidate.body;
    assert!(!body.actuators.is_empty(), "the test needs a body that moves");
    let task = rules.first_task().unwrap();
    let drive = Drive::new(&candidate, task).unwrap();
    let first = drive.draw(&mut random);
    // Many mutations: a chance of 0.3 or 0.303 shows only in the long run.
    let mut second = first.clone();
    for _ in 0..2000 {
        second = drive.mutate(&second, 0.03, 3, &mut random).unwrap();
    }
    // Several drives: a switch may stand either way in one of them.
    let drives: Vec<_> = (0..4).map(|_| drive.draw(&mut random)).chain([second.clone()]).collect();
    let targets: Vec<_> = drives.iter().map(|d| drive.targets(d).unwrap()).collect();
    // Made-up motions in which every element drifts, and sinks or rises.
    let scores = [-0.1, 0.1].map(|rise| {
        let elements = body.assembly.elements.len();
        let poses = (0..21 * elements)
            .map(|i| ((i / elements) as f64 / 10.0, (i % elements) as f64))
            .map(|(frame, element)| {
                // Bent paths and turning elements: every term has something to see.
                let place = Vector3::new(frame * (1.0 + element), rise * frame, -0.3 * frame * frame);
                Isometry3::new(place, Vector3::new(0.1 * element, 0.4, 0.2) * frame * frame)
            })
            .collect();
        let placement = |(body, e): (usize, &Element)| Placement::new(body, Isometry3::identity(), e.shape);
        let placements: Vec<_> = body.assembly.elements.iter().enumerate().map(placement).collect();
        let motion = Motion {
            interval: task.model.duration / 20.0,
            duration: task.model.duration,
            bodies: elements,
            poses,
            bends: Vec::new(),
            work: vec![0.5; body.actuators.len()],
            commands: None,
            placements: placements.into(),
        };
        let recording = Recording::nominal(&drive, &second, &motion);
        // A number that makes a term ask for a time outside the motion changes what it says, too.
        sgc::score::score(recording).map_err(|error| error.reason)
    });
    let places = [0.0, 0.1, 0.3, 0.6].map(grammar_lang::eval::Value::Number);
    let patterns: Vec<_> = rules
        .patterns
        .keys()
        .map(|name| places.clone().map(|place| pattern_at(rules, name, place)))
        .collect();
    let worlds: Vec<_> = rules
        .scenarios
        .iter()
        .flat_map(|(name, set)| sgc::scenarios::worlds(name, set))
        .map(|scenario| (scenario.world(), scenario.conditions(2)))
        .collect();
    // What `sgc fit` computes with.
    let made: Vec<_> = rules.actuators.values().map(|actuator| actuator.construction).collect();
    format!(
        "{:?} {made:?} {first:?} {second:?} {:?} {:?} {scores:?} {patterns:?} {worlds:?}",
        body.assembly,
        targets,
        sgc::search::settings(&task.model),
    )
}

/// A pattern's angle at a place of its cycle.
fn pattern_at(rules: &RuleSet, name: &str, place: grammar_lang::eval::Value) -> String {
    use grammar_lang::ir::{Expr, ExprKind, Ty};
    let span = grammar_lang::source::Span::default();
    let expr = |kind, ty| Box::new(Expr { kind, ty, span });
    let apply = ExprKind::Apply(
        expr(ExprKind::Pattern(name.into()), Ty::Pattern),
        expr(ExprKind::Local(0), Ty::NUMBER),
    );
    let apply = Expr { kind: apply, ty: Ty::NUMBER, span };
    format!("{:?}", grammar_lang::eval::evaluate(&apply, rules, &mut vec![place]).unwrap())
}

/// Grammars that use what those of the project leave out.
const OTHERS: &[(&str, &str)] = &[
    (
        "grammars/terms.sgr",
        "use std.objectives
        variant terms of \"./codesign.sgr\" {
          replace maximize mean_speed / 1 m * 1 s + body_lengths_per_hour + lasting_travel / 1 cm + energy / 1 J
            + heading_error / 1 deg + turning / 1 deg + clearance / 1 cm
            + headway / 1 cm + turning_right / 1 deg
        }",
    ),
    (
        "grammars/short.sgr",
        "use std.objectives { lasting_travel, settled_speed }
        variant short of \"./codesign.sgr\" {
          replace maximize lasting_travel + settled_speed * 1 s in cm
          replace simulate hinge_model for 8 s
        }",
    ),
    (
        "grammars/gaits.sgr",
        "use std.search { gait_annealing }
        variant gaits of \"./codesign.sgr\" { replace search gait_annealing }",
    ),
    (
        "grammars/evolution.sgr",
        "use std.search { nested_evolution }
        variant evolution of \"./codesign.sgr\" { replace search nested_evolution }",
    ),
    (
        "grammars/gait_evolution.sgr",
        "use std.search { gait_evolution }
        variant gait_evolution of \"./codesign.sgr\" { replace search gait_evolution }",
    ),
    (
        "grammars/tempering.sgr",
        "use std.search { gait_tempering }
        variant tempering of \"./codesign.sgr\" { replace search gait_tempering }",
    ),
    (
        "grammars/reheated.sgr",
        "use std.search { reheated_annealing }
        variant reheated of \"./codesign.sgr\" { replace search reheated_annealing }",
    ),
    (
        "grammars/novel.sgr",
        "use std.novelty { literature }
        use std.gaits { airborne, alternation, bounce, extent, gait, progress, roll }
        variant novel of \"./codesign.sgr\" {
          add observe airborne, alternation, bounce, extent, gait, progress, roll
        }",
    ),
    (
        "grammars/feeling.sgr",
        "use std.sensors { lean, course, turn_rate, bent, grounded }
        variant feeling of \"./codesign.sgr\" {
          add actuation felt for a : bender {
            shared period : Time in 1 s .. 2 s mutate 0.3 by normal(0 s, 1 s)
            let push = if grounded(a) then lean + course else bent(a)
            drive angle = push * sin(t / period * 360 deg) + turn_rate * 1 s
          }
          replace actuate bender with felt
        }",
    ),
    (
        "grammars/cast.sgr",
        "use std.materials {
          ecoflex_30, dragon_skin_30, elastosil_m4601, smooth_sil_950, elastic_50a, tpu_85a, printed_abs,
          bar_stiffness, tube_stiffness, strip_stiffness, twist_stiffness, stretch_stiffness
        }
        variant cast of \"./codesign.sgr\" {
          set bender.density = (
            ecoflex_30.density + dragon_skin_30.density + elastosil_m4601.density + smooth_sil_950.density
            + elastic_50a.density + tpu_85a.density + printed_abs.density
          ) / 7
          set bender.stiffness =
            bar_stiffness(ecoflex_30, 9 mm, 2 cm) + tube_stiffness(dragon_skin_30, 9 mm, 2 mm, 2 cm)
            + strip_stiffness(elastosil_m4601, 2 cm, 2 mm, 2 cm) + twist_stiffness(smooth_sil_950, 5 mm, 2 cm)
            + stretch_stiffness(elastic_50a, 1 mm, 2 cm) * 1 mm * 1 mm / (1 rad * 1 rad)
            + bar_stiffness(tpu_85a, 3 mm, 2 cm) + bar_stiffness(printed_abs, 1 mm, 2 cm)
          set bender.material = printed_abs
        }",
    ),
    (
        "grammars/fitted.sgr",
        "grammar fitted
        use std.blocks { cube }
        use std.actuators { silicone_bender, thread_bender }
        use std.actuation { bezier_pac }
        use std.models { hinge_model }
        use std.objectives { travel }
        use std.search { gait_annealing }
        begin {
          place core  : cube
          place leg   : silicone_bender to core.left
          place other : thread_bender to core.right
        }
        actuate silicone_bender with bezier_pac
        actuate thread_bender with bezier_pac
        simulate hinge_model for 20 s
        maximize travel in cm
        search gait_annealing",
    ),
    (
        "grammars/kinds.sgr",
        "use std.search { many_kinds }
        variant kinds of \"./codesign.sgr\" { replace search many_kinds }",
    ),
    (
        "grammars/shortly.sgr",
        "use std.search { shortly_many_kinds }
        variant shortly of \"./codesign.sgr\" { replace search shortly_many_kinds }",
    ),
    (
        "grammars/recommended.sgr",
        "use std.search { recommended }
        variant searched of \"./codesign.sgr\" { replace search recommended }",
    ),
    (
        "grammars/front.sgr",
        "use std.objectives { energy }
        use std.search { trade_offs }
        variant traded of \"./codesign.sgr\" { add minimize energy in J  replace search trade_offs }",
    ),
    (
        "grammars/joints.sgr",
        "grammar joints
        use std.blocks { cube }
        use std.actuators { bellows, motor, strip, twister }
        use std.actuation { bezier_pac, extending_pac, steady_spin }
        use std.models { hinge_model }
        use std.objectives { travel }
        use std.search { nested_annealing }
        symmetry mirror xy
        begin {
          place core  : cube
          place neck  : twister to core.front
          place wheel : motor to core.back
          place leg   : bellows to core.left
          place hip   : cube to core.bottom
          place foot  : bellows to hip.left
          place fin   : strip to core.top
        }
        rule head {
          match  a : twister with free port q
          attach cube to q
        }
        require apart : no_overlap
        actuate twister with bezier_pac
        actuate bellows with extending_pac
        actuate motor with steady_spin
        simulate hinge_model for 20 s
        maximize travel in cm
        search nested_annealing",
    ),
    (
        "grammars/limbs.sgr",
        "grammar limbs
        use std.blocks { cube }
        use std.limbs { wheel, axle, paddle }
        use std.actuators { bender }
        use std.actuation { alternating_pac }
        use std.models { hinge_model }
        use std.objectives { travel }
        use std.search { nested_annealing }
        actuator spine {
          segment        = cylinder(9 mm, 16 mm)
          joint          = bend about y
          bend           = -130 deg .. 130 deg
          bending_speed  = 360 deg/s
          relaxing_speed = 360 deg/s
          density        = 1 g/cm^3
          friction       = 0.4
          torque         = 0.08 N*m/rad
          stiffness      = 0.4 N*m/rad^2
          damping        = 0.01 N*m*s/rad^2
        }
        symmetry mirror xy
        begin {
          place core : cube
          place back : spine to core.back
          place hip  : cube to back.tip
          place roll : axle to hip.left
          place tyre : wheel to roll.tip by hub
          place leg  : bender to core.left
          place fin  : paddle to leg.tip by root
        }
        rule head {
          match  p : cube with free port q
          attach cube to q
        }
        require apart : no_overlap
        actuate bender with alternating_pac
        actuate spine with alternating_pac
        simulate hinge_model for 20 s
        maximize travel in cm
        search nested_annealing",
    ),
    (
        "grammars/study2_plain.sgr",
        "use std.search { walked_annealing }
        variant study2_plain of \"./study2.sgr\" { replace search walked_annealing }",
    ),
    (
        "grammars/two_sided.sgr",
        "use std.actuation { two_sided_pac }
        variant two_sided of \"./codesign.sgr\" { replace actuate bender with two_sided_pac }",
    ),
    (
        "grammars/actor.sgr",
        "grammar actor
        use std.blocks { cube }
        use std.actuators { bender }
        use std.models { hinge_model }
        use std.objectives { travel }
        use std.rewards { advance, distance_and_speed }
        use std.search { actor_critic_learning }
        begin {
          place core : cube
          place leg  : bender to core.left
        }
        policy brain { reward = advance(1 cm) + distance_and_speed(4 cm) }
        actuation learned for a : bender {
          action push : Angle in -9 deg .. 9 deg of brain from [t / 20 s]
          drive  angle = push
        }
        actuate bender with learned
        simulate hinge_model for 20 s
        maximize travel in cm
        search actor_critic_learning",
    ),
    (
        "grammars/values.sgr",
        "grammar values
        use std.blocks { cube }
        use std.actuators { bender }
        use std.models { hinge_model }
        use std.objectives { travel }
        use std.rewards { milestones }
        use std.search { q_learning }
        begin {
          place core : cube
          place leg  : bender to core.left
        }
        policy brain { reward = milestones(4 mm) }
        actuation learned for a : bender {
          action push : Angle in { -9 deg, 9 deg } of brain from [t / 20 s]
          drive  angle = push
        }
        actuate bender with learned
        simulate hinge_model for 20 s
        maximize travel in cm
        search q_learning",
    ),
];

/// Modules whose numbers change no motion and no value.
const OF_NO_ACT: [&str; 6] =
    ["std.search", "std.prototypes", "std.gaits", "std.novelty", "std.sensors", "std.rewards"];

#[test]
fn every_number_of_the_library_changes_the_rule_set() {
    let mut original = texts();
    original.extend(OTHERS.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())));
    let entries = [
        "grammars/codesign.sgr",
        "grammars/morphology.sgr",
        "grammars/pneumatic.sgr",
        "grammars/tendon.sgr",
        "grammars/shepherd.sgr",
        "grammars/terms.sgr",
        "grammars/short.sgr",
        "grammars/two_sided.sgr",
        "grammars/gaits.sgr",
        "grammars/evolution.sgr",
        "grammars/gait_evolution.sgr",
        "grammars/tempering.sgr",
        "grammars/reheated.sgr",
        "grammars/cast.sgr",
        "grammars/fitted.sgr",
        "grammars/kinds.sgr",
        "grammars/shortly.sgr",
        "grammars/recommended.sgr",
        "grammars/front.sgr",
        "grammars/joints.sgr",
        "grammars/limbs.sgr",
        "grammars/study1.sgr",
        "grammars/study2.sgr",
        "grammars/study2_plain.sgr",
        "grammars/novel.sgr",
        "grammars/feeling.sgr",
        "grammars/actor.sgr",
        "grammars/values.sgr",
    ];
    let compiled: BTreeMap<&str, RuleSet> =
        entries.iter().map(|e| (*e, compile_texts(&original, e).unwrap())).collect();
    let before: BTreeMap<&str, _> =
        compiled.iter().map(|(e, r)| (*e, (without_spans(r).unwrap(), engine(r)))).collect();
    let mut edited = 0;
    for (module, text) in original.iter().filter(|(name, _)| name.starts_with("std.")) {
        for place in numbers(text) {
            let old = &text[place.clone()];
            let x: f64 = old.parse().unwrap();
            let new = match old.contains('.') {
                true if x == 0.0 => "0.25".to_owned(),
                true => format!("{}", x * 1.01),
                false => format!("{}", x + 1.0),
            };
            let mut texts = original.clone();
            texts.insert(module.clone(), format!("{}{new}{}", &text[..place.start], &text[place.end..]));
            let line = text[..place.start].lines().count();
            // A direction is one whatever its length.
            let is_direction =
                text.lines().nth(line.max(1) - 1).is_some_and(|line| line.contains(" facing "));
            let (mut seen, mut acted) = (is_direction, is_direction);
            for entry in entries {
                if seen && acted {
                    break;
                }
                let rules = match compile_texts(&texts, entry) {
                    Ok(rules) => rules,
                    // A list that is longer than what it belongs to was read, and so was a range that no longer holds rest, or a stiffness
                    // that is zero: nobody could tell otherwise.
                    Err(error)
                        if ["E0308", "must contain 0 ", "has no valid"].iter().any(|e| error.contains(e)) =>
                    {
                        (seen, acted) = (true, true);
                        break;
                    }
                    Err(error) => panic!("{module}:{line}: {old} -> {new} does not compile: {error}"),
                };
                // The same rules do the same.
                if without_spans(&rules).unwrap() == before[entry].0 {
                    continue;
                }
                seen = true;
                // Schedules act only in a search.
                acted |= OF_NO_ACT.contains(&module.as_str()) || engine(&rules) != before[entry].1;
            }
            assert!(seen, "{module}:{line}: {old} -> {new} changes no rule set");
            // Bounds of parameters act only when somebody leaves them, schedules only in a search,
            // and a hundred samples of a motion see what a hundred and one do.
            // Prototypes and known designs are compared with, not simulated; gaits and sensors have tests of their own.
            let passive = OF_NO_ACT.contains(&module.as_str())
                || text.lines().nth(line.max(1) - 1).is_some_and(|l| {
                    ["param ", ".. 100", "still -> 0", "neighbours(c)"].iter().any(|idle| l.contains(idle))
                });
            assert!(acted || passive, "{module}:{line}: {old} -> {new} changes nothing that the engine does");
            edited += 1;
        }
    }
    assert!(edited > 50, "only {edited} numbers found");
}

/// A grammar may use any modules together: no two of them give different things the same name.
#[test]
fn no_two_modules_declare_the_same_name() {
    let mut known: BTreeMap<String, String> = BTreeMap::new();
    for entry in std::fs::read_dir(root().join("std-rules")).unwrap() {
        let module = entry.unwrap().file_name().to_string_lossy().into_owned();
        for line in read(&format!("std-rules/{module}")).lines() {
            let mut words = line.split(|c: char| !(c.is_alphanumeric() || c == '_'));
            let (first, name) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
            if !["use", "observe", ""].contains(&first) && !name.is_empty() {
                let other = known.insert(name.to_owned(), module.clone());
                assert!(
                    other.as_ref().is_none_or(|other| *other == module),
                    "{name}: {module} and {other:?}"
                );
            }
        }
    }
    assert!(known.len() > 80, "{}", known.len());
}
