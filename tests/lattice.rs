//! Lattices: what rules do to cells, and what becomes of them.

use std::collections::BTreeSet;
use std::sync::Arc;

use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;
use sgc::derive::random::Stream;
use sgc::derive::{Candidate, Derivation, run_example};
use sgc::design::lattice::place_of;
use sgc::design::{Body, Design};
use sgc::drive::Drive;

use crate::command_line::{code, errors, printed, sgc};
use crate::support::{grammar, root};

const HEAD: &str = "
grammar lump
use std.objectives { travel }
use std.models     { ball_springs }
use std.search     { walked_annealing }
enum Beat { none, early, late }
cell gel {
  spacing   = 1 cm
  mass      = if heavy then 3 g else 1 g
  friction  = 0.8
  stiffness = if heavy then 300 N/m else 100 N/m
  damping   = 0.1 N*s/m
  param beat  : Beat             = Beat.none
  param side  : Count in -1 .. 1 = 0
  param heavy : Bool             = false
}
actuation pulse for c : gel {
  let   period = 1 s
  drive strain = if c.beat == Beat.none then 0 else c.side * 20 % * sin(t / period * 360 deg)
}
actuate  gel with pulse
simulate ball_springs for 1 s
maximize travel in cm
search   walked_annealing
";

fn rules(text: &str) -> RuleSet {
    rules_of(&format!("{HEAD}\n{text}"))
}

fn rules_of(text: &str) -> RuleSet {
    let mut sources = SourceMap::default();
    let entry = sources.add(root().join("grammars/lump.sgr").to_string_lossy(), text);
    let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &[], None);
    let errors: Vec<_> = compiled.diagnostics.iter().filter(|d| d.is_error()).collect();
    assert!(errors.is_empty(), "{errors:#?}");
    compiled.ruleset.unwrap()
}

/// Derives the example `x`.
fn example(rules: &RuleSet) -> Derivation {
    run_example(rules, "x", &rules.examples["x"])
        .unwrap_or_else(|e| panic!("{}: {}", e.message, e.labels[0].text))
}

fn places(design: &Design) -> BTreeSet<[usize; 3]> {
    design.parts.keys().map(|id| place_of(*id).unwrap()).collect()
}

#[test]
fn regions_are_cut_at_the_grid_and_later_effects_overwrite_earlier_ones() {
    let rules = rules(
        "lattice 5 x 4 x 3 of gel
        begin { fill middle with gel }
        rule grow {
          match c : cell
          fill  region(c, -9 .. 9, 0, 0) with gel(beat = Beat.early, side = 1)
          fill  region(c, 1 .. 2, -1 .. 0, 0) with gel(beat = Beat.late)
          paint region(c, 0 .. 9, -3 .. 3, -3 .. 3) with gel(heavy = true)
          clear region(c, -2, 0, 0)
        }
        example x {
          step s = grow(c = middle)
          expect count(cell) == 6
          expect cell(1, 2, 1).beat == Beat.early and not cell(1, 2, 1).heavy
          expect cell(2, 2, 1).beat == Beat.early and cell(2, 2, 1).heavy
          expect cell(3, 2, 1).beat == Beat.late and cell(3, 2, 1).side == 0 and cell(3, 2, 1).heavy
          expect cell(4, 1, 1).filled and not cell(0, 2, 1).filled and not cell(2, 1, 1).filled
          expect count(region(cell(0, 0, 0), -1 .. 1, -1 .. 1, -1 .. 1)) == 8
          expect cell(4, 1, 1).x == 4 and cell(4, 1, 1).y == 1 and cell(4, 1, 1).z == 1
          expect count(neighbours(cell(3, 2, 1))) == 4
          expect connected
        }",
    );
    example(&rules);
}

/// What is far too large ends soon, and says why.
#[test]
fn endless_regions_are_cut_and_endless_repetitions_refused() {
    let rules = rules(
        "lattice 5 x 4 x 3 of gel
        begin { fill middle with gel }
        rule all {
          match c : cell
          fill  region(c, -1000000 .. 1000000, -1000000 .. 1000000, -1000000 .. 1000000) with gel(side = 1)
        }
        rule often {
          match c : cell
          fill  region(c, i, j, 0) with gel(side = 1) for i in 0 .. 99, j in 0 .. 1000000000
        }
        example x {
          step s = all(c = middle)
          expect count(cell) == 60
        }",
    );
    let derivation = example(&rules);
    let often = rules.rule("often").unwrap();
    let cell = *derivation.design.parts.keys().next().unwrap();
    let locals = [grammar_lang::eval::Value::Reference(grammar_lang::eval::Reference::Part(cell))];
    let refused = derivation.apply(&rules, often, &locals).unwrap_err().sentence(&rules);
    assert!(refused.contains("more than 1000 times"), "{refused}");
}

/// A term reads the cell of an element: its parameters and its place.
#[test]
fn terms_read_the_cells_of_elements() {
    let text = HEAD.replace(
        "maximize travel in cm",
        "term counted : Number = count over e in elements where e.cell.side == 1 and e.cell.filled and e.cell.x < 3
         maximize counted",
    );
    let rules = rules_of(&format!(
        "{text}
        lattice 5 x 1 x 2 of gel
        begin {{ fill region(cell(0, 0, 0), 0 .. 4, 0, 0 .. 1) with gel(side = 1) }}
        rule other {{
          match c : cell
          paint c with gel(side = -1)
        }}
        example x {{
          step s = other(c = cell(1, 0, 0))
        }}"
    ));
    let candidate = Candidate::new(&rules, Arc::new(example(&rules)));
    let drive = Drive::new(&candidate, rules.first_task().unwrap()).unwrap();
    let parameters = drive.draw(&mut Stream::named(1, "cells"));
    let settings = sgc::search::settings(&drive.task().model);
    let model = sgc::simulate::model("balls").unwrap();
    let mut simulation = model.prepare(&candidate.body.assembly, &settings).unwrap();
    let motion = simulation.run(&[drive.targets(&parameters).unwrap()]).remove(0).unwrap();
    let recording = sgc::score::Recording::nominal(&drive, &parameters, &motion);
    assert_eq!(sgc::score::objective(recording), Ok(5.0));
}

#[test]
fn effects_are_repeated_for_values() {
    let rules = rules(
        "lattice 9 x 9 x 9 of gel
        begin { fill cell(0, 8, 4) with gel }
        rule stair {
          match  c : cell
          choose way in { -1, 1 }
          fill   region(c, way * (i + j), -i, 0) with gel(side = j) for i in 0 .. 3, j in 0 .. 1
        }
        example x {
          step s = stair(c = cell(0, 8, 4), way = 1)
        }",
    );
    let stair = [0, 1, 2, 3].into_iter().flat_map(|i| [[i, 8 - i, 4], [i + 1, 8 - i, 4]]);
    assert_eq!(places(&example(&rules).design), stair.collect());
}

#[test]
fn what_is_done_is_done_to_the_images_too() {
    for (symmetry, wanted) in [
        ("none", vec![[1, 0, 2]]),
        ("mirror xy", vec![[1, 0, 2], [1, 0, 4]]),
        ("mirror yz", vec![[1, 0, 2], [5, 0, 2]]),
        ("mirror xz", vec![[1, 0, 2], [1, 6, 2]]),
        ("radial 2 about y", vec![[1, 0, 2], [5, 0, 4]]),
        ("radial 4 about y", vec![[1, 0, 2], [2, 0, 5], [5, 0, 4], [4, 0, 1]]),
    ] {
        let rules = rules(&format!(
            "symmetry {symmetry}
            lattice 7 x 7 x 7 of gel
            begin {{ fill middle with gel }}
            rule grow {{
              match c : cell
              fill  cell(1, 0, 2) with gel(side = 1)
              paint region(cell(1, 0, 2), 0, 0, 0) with gel(heavy = true)
            }}
            example x {{ step s = grow(c = middle) }}"
        ));
        let mut wanted: BTreeSet<[usize; 3]> = wanted.into_iter().collect();
        wanted.insert([3, 3, 3]);
        let design = example(&rules).design;
        assert_eq!(places(&design), wanted, "{symmetry}");
        let heavy = |part: &sgc::design::Part| format!("{:?}", part.params["heavy"]) == "Bool(true)";
        assert_eq!(design.parts.values().filter(|cell| heavy(cell)).count(), wanted.len() - 1, "{symmetry}");
    }
}

#[test]
fn groups_of_neighbours_that_share_a_value_are_counted() {
    let rules = rules(
        "lattice 9 x 3 x 3 of gel
        begin { fill region(cell(0, 0, 0), 0 .. 8, 0, 0) with gel }
        rule grow {
          match c : cell
          fill  region(c, 0 .. 2, 0, 0) with gel(beat = Beat.early)
          fill  region(c, 4 .. 5, 0, 0) with gel(beat = Beat.early)
          fill  region(c, 6, 0, 0)      with gel(beat = Beat.late)
          fill  region(c, 6, 1, 1)      with gel(beat = Beat.late)
        }
        example x {
          step s = grow(c = cell(0, 0, 0))
          expect (clusters over c in cell where c.beat != Beat.none of c.beat) == 4
          expect (clusters over c in cell where c.beat != Beat.none) == 3
          expect (clusters over c in cell of c.beat) == 6
          expect (clusters over c in cell where c.heavy) == 0
        }",
    );
    example(&rules);
}

const UNDO: &str = "
lattice 9 x 3 x 3 of gel
begin { fill cell(0, 0, 0) with gel }
rule grow {
  match c : cell
  fill  region(c, 0 .. 2, 0, 0) with gel(side = 1)
}
rule undo {
  match  s : step where s adds cell
  revert s
}
require whole : connected
";

#[test]
fn a_step_is_taken_back_unless_that_splits_the_design() {
    let rules = rules(
        &format!(
            "{UNDO}
        example x {{
          step a = grow(c = cell(0, 0, 0))
          step b = grow(c = cell(2, 0, 0))
          step d = grow(c = cell(1, 0, 0))
          refuse undo(s = b) by whole
        }}",
        )
        .replace("refuse undo(s = b) by whole", "expect count(cell) == 5"),
    );
    let derivation = example(&rules);
    let undo = rules.rule("undo").unwrap();
    let step = |n: usize| {
        vec![grammar_lang::eval::Value::Reference(grammar_lang::eval::Reference::Step(
            derivation.steps[n].id,
        ))]
    };
    // The last one has added nothing that others have not: without it all is as it was.
    let same = derivation.apply(&rules, undo, &step(2)).unwrap();
    assert_eq!(places(&same.design), places(&derivation.design));
    // The second one is needed by none: what it was applied to stays.
    let shorter = derivation.apply(&rules, undo, &step(1)).unwrap();
    assert_eq!(places(&shorter.design).len(), 4);
    // Without the first one, too, the rest still hangs together through the third, although the cell that the
    // second was applied to is made by it only.
    let other = derivation.apply(&rules, undo, &step(0)).unwrap();
    assert_eq!(places(&other.design).len(), 5);
    // Without the third one, the first one holds the second.
    let alone = same.apply(&rules, undo, &step(0));
    assert!(alone.is_err(), "the design would be split");
}

#[test]
fn only_the_fallback_is_drawn_while_a_limit_is_passed() {
    let rules = rules(&format!("{UNDO}\nfallback undo when count(cell) >= 5"));
    let mut random = Stream::named(3, "test");
    let mut now = Derivation::begin(&rules);
    let mut shrunk = 0;
    for _ in 0..200 {
        let large = now.design.parts.len() >= 5;
        let step = now.advance(&rules, &mut random, 1.0);
        let Some(next) = step.result else { continue };
        if large {
            assert_eq!(rules.rules[step.rule.unwrap()].name, "undo");
            shrunk += 1;
        }
        now = next;
    }
    assert!(shrunk > 10);
}

#[test]
fn a_body_has_a_ball_for_each_cell_and_springs_between_neighbours() {
    let rules = rules(
        "lattice 4 x 4 x 4 of gel
        begin { fill region(cell(1, 0, 1), 0 .. 1, 0 .. 1, 0 .. 1) with gel(beat = Beat.early, side = 1) }
        rule grow {
          match c : cell
          fill  region(cell(1, 1, 1), 0 .. 1, 0, 0 .. 1) with gel(beat = Beat.early, side = -1, heavy = true)
        }
        example x { step s = grow(c = cell(1, 0, 1)) }",
    );
    let body = Body::new(&example(&rules).design, &rules);
    let assembly = &body.assembly;
    // All pairs of a cube of eight but those across it.
    assert_eq!((assembly.elements.len(), assembly.springs.len(), assembly.actuators), (8, 24, 2));
    let mass: f64 = assembly.elements.iter().map(|element| element.mass).sum();
    assert!((mass - 16e-3).abs() < 1e-12);
    let lowest = assembly.elements.iter().map(|e| e.pose.translation.y).fold(f64::INFINITY, f64::min);
    assert!((lowest - 5e-3).abs() < 1e-12);
    let mut kinds: Vec<f64> = assembly.springs.iter().map(|spring| spring.stiffness).collect();
    kinds.sort_by(f64::total_cmp);
    // Half of a spring is of each: 100 N/m and 300 N/m one behind the other, each twice as stiff.
    let mixed = 150.0;
    let counts = [100.0, mixed, 300.0].map(|k| kinds.iter().filter(|x| (*x - k).abs() < 1e-9).count());
    assert_eq!(counts, [6, 12, 6]);
    for spring in &assembly.springs {
        let at = |i: usize| assembly.elements[i].pose.translation.vector;
        let length = (at(spring.from) - at(spring.to)).norm();
        assert!(length < 0.0142 && spring.from < spring.to, "{spring:?}");
    }
    let actuators: BTreeSet<usize> = assembly.swellings.iter().map(|swelling| swelling.actuator).collect();
    assert_eq!((actuators.len(), assembly.swellings.len()), (2, 8));
}

/// What holds of every design that the studies make.
#[test]
fn the_studies_make_designs_that_are_whole_symmetric_and_not_too_large() {
    for (path, most) in [("grammars/study1.sgr", 340), ("grammars/study2.sgr", 800)] {
        let rules = grammar(path);
        let mut random = Stream::named(1, "test");
        let mut now = Derivation::begin(&rules);
        let (mut made, mut sizes) = (BTreeSet::new(), Vec::new());
        for _ in 0..300 {
            let before = now.design.parts.len();
            let step = now.advance(&rules, &mut random, 1.0);
            let Some(next) = step.result else { continue };
            made.insert(rules.rules[step.rule.unwrap()].name.clone());
            now = next;
            let after = now.design.parts.len();
            assert!(after <= before || before <= most, "{path}: {before} cells grew to {after}");
            let lattice = rules.lattice.as_ref().unwrap();
            assert!(now.design.is_one_piece(lattice), "{path}");
            for (id, cell) in &now.design.parts {
                let [x, y, z] = place_of(*id).unwrap().map(|at| at as i64);
                let twin = sgc::design::lattice::cell_at(lattice, [x, y, 14 - z]).unwrap();
                assert_eq!(
                    now.design.parts.get(&twin).map(|twin| &twin.params),
                    Some(&cell.params),
                    "{path}"
                );
            }
            sizes.push(after);
        }
        assert_eq!(made.len(), rules.rules.len(), "{path}: {made:?}");
        let mean = sizes.iter().sum::<usize>() / sizes.len();
        assert!((150..=700).contains(&mean), "{path}: {mean} cells");
        // What is kept leads to the same design.
        let again = Derivation::restore(&rules, &now.kept()).unwrap();
        assert_eq!(again, now);
    }
}

/// One body, two models: the shapes of parts filled with balls.
#[test]
fn a_body_of_parts_is_filled_with_balls_that_bend_as_its_hinges_do() {
    let text = |filling: &str| {
        format!(
            "grammar filled
            use std.blocks     {{ cube }}
            use std.actuators  {{ bender }}
            use std.actuation  {{ bezier_pac }}
            use std.objectives {{ travel }}
            use std.search     {{ nested_annealing }}
            model both {{
              {filling}
              step = 1 s / 8000  control = 1 s / 60  record = 1 s / 30  gravity = 0 m/s^2  ground_friction = 0.8
              iterations = 10  tolerance = 0.2 %  self_collision = true  speed_limit = 10 m/s
            }}
            symmetry mirror xy
            begin {{
              place core : cube
              place tail : bender(segments = 4) to core.back
            }}
            rule grow {{
              match  p : part with free port q
              attach cube to q
            }}
            require few : count(part) < 9
            actuate  bender with bezier_pac
            simulate both for 2 s
            maximize travel in cm
            search   nested_annealing"
        )
    };
    let compile = |filling: &str| {
        let mut sources = SourceMap::default();
        let entry = sources.add(root().join("grammars/filled.sgr").to_string_lossy(), text(filling));
        let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &[], None);
        compiled.ruleset.unwrap_or_else(|| panic!("{:#?}", compiled.diagnostics))
    };
    let hinged = compile("");
    let filled =
        compile("method = balls  filling { spacing = 5 mm  stiffness = 100 N/m  damping = 0.02 N*s/m }");
    let bodies = [&hinged, &filled].map(|rules| Body::new(&Derivation::begin(rules).design, rules));
    let [of_hinges, of_balls] = &bodies;
    let mass = |body: &Body| body.assembly.elements.iter().map(|element| element.mass).sum::<f64>();
    assert!((mass(of_hinges) - mass(of_balls)).abs() < 1e-12);
    assert_eq!(of_hinges.actuators, of_balls.actuators);
    let balls = &of_balls.assembly;
    assert!(balls.joints.is_empty() && balls.elements.len() > 100, "{}", balls.elements.len());
    // All hangs together.
    let mut group: Vec<usize> = (0..balls.elements.len()).collect();
    for _ in 0..balls.elements.len() {
        for spring in &balls.springs {
            let least = group[spring.from].min(group[spring.to]);
            (group[spring.from], group[spring.to]) = (least, least);
        }
    }
    assert!(group.iter().all(|g| *g == 0));
    // What is above the axis of the actuator gets shorter, by its distance over the length of the actuator.
    let length = 4.0 * 2.0 * 0.01;
    for swelling in &balls.swellings {
        let height = balls.elements[swelling.element].pose.translation.y;
        assert!(
            (swelling.gain.abs() - height.abs() / length).abs() < 0.2 * swelling.gain.abs() + 1e-9,
            "{swelling:?} at {height}"
        );
        assert!(swelling.gain * height <= 0.0);
    }
    assert_eq!(sgc::search::solver(&filled), sgc::simulate::SolverName::Balls);
    let settings = sgc::search::settings(&filled.tasks[0].model);
    let model = sgc::simulate::model("balls").unwrap();
    let mut simulation = model.prepare(balls, &settings).unwrap();
    // Half a radian, without weight: the tail's end looks up by so much, seen from the core.
    let bent = sgc::simulate::Targets { interval: 1.0, actuators: 1, angles: vec![0.0, 0.5] };
    let motion = simulation.run(&[bent]).remove(0).unwrap();
    let at_rest = |ball: usize| balls.elements[ball].pose.translation.vector;
    let on_axis = |ball: &usize| at_rest(*ball).y.abs() < 1e-9 && at_rest(*ball).z.abs() < 1e-9;
    let mut axis: Vec<usize> = (0..balls.elements.len()).filter(on_axis).collect();
    axis.sort_by(|a, b| at_rest(*a).x.total_cmp(&at_rest(*b).x));
    let [far, end, .., front, tip] = axis.as_slice() else { panic!("{axis:?}") };
    let direction = |from: usize, to: usize| {
        let at = |ball: usize| motion.pose(ball, 2.0).unwrap().translation.vector;
        let way = at(to) - at(from);
        libm::atan2(way.y, way.x)
    };
    // From the core backwards it rises: from its end forwards it falls.
    let turned = direction(*front, *tip) - direction(*far, *end);
    assert!((turned - 0.5).abs() < 0.1, "{turned} rad");
}

/// `check` refused these: it counted no cells, whatever the lattice.
#[test]
fn requirements_can_ask_for_cells_that_the_lattice_has_room_for() {
    let lump = |requirement: &str| {
        format!(
            "{HEAD}
            lattice 5 x 4 x 3 of gel
            begin {{ fill middle with gel }}
            rule cut {{ match c : cell  clear region(c, 1, 0, 0) }}
            require enough : {requirement}"
        )
    };
    for requirement in [
        "count(cell) >= 5",
        "count(gel) == 60",
        "connected and not count(cell) < 9",
        "exists c in cell: c.heavy",
        "(count over c in cell where c.heavy) >= 60",
    ] {
        rules_of(&lump(requirement));
    }
    let mut sources = SourceMap::default();
    let entry = sources.add("lump.sgr", lump("count(cell) >= 61"));
    let compiled = grammar_lang::compile(&sgc::loader::Files, &mut sources, entry, &[], None);
    let found: Vec<_> = compiled.diagnostics.iter().map(|d| d.code.name).collect();
    assert_eq!(found, ["requirement-never-holds"]);
}

/// Springs of some bodies are too stiff for the step of the model: these have no value, and the search goes on.
#[test]
fn a_body_that_cannot_be_simulated_does_not_end_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let stiff = folder.path().join("stiff.sgr");
    let base = root().join("grammars/study1.sgr");
    let own = "set silicone.stiffness = if material == Material.rigid then 1150 N/m else 250 N/m";
    std::fs::write(&stiff, format!("variant stiff of \"{}\" {{\n  {own}\n}}\n", base.display())).unwrap();
    let out = folder.path().join("run");
    let run = sgc(&["run", &stiff.to_string_lossy(), "--max-evals", "12", "--out", &out.to_string_lossy()]);
    assert_eq!(code(&run), 0, "{}", errors(&run));
    assert!(errors(&run).contains("bodies could not be simulated; the first: steps of"), "{}", errors(&run));
    let moves = std::fs::read_to_string(out.join("evals.csv")).unwrap();
    assert!(moves.contains("1 of bodies that the solver cannot simulate"), "{moves}");
    assert_eq!(code(&sgc(&["report", &out.to_string_lossy()])), 0);
    // Where the first cannot be simulated, there is nothing to begin with: `check` says so.
    let light = "set silicone.mass = 1e-9 g";
    std::fs::write(&stiff, format!("variant stiff of \"{}\" {{\n  {light}\n}}\n", base.display())).unwrap();
    let check = sgc(&["check", &stiff.to_string_lossy()]);
    assert_eq!(code(&check), 1, "{}", printed(&check));
    assert!(printed(&check).contains("E0318") && printed(&check).contains("too long for the springs"));
}

#[test]
fn a_body_of_cells_has_no_model_of_hinges() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run").to_string_lossy().into_owned();
    assert_eq!(code(&sgc(&["run", "grammars/study1.sgr", "--max-evals", "2", "--out", &out])), 0);
    let export = sgc(&["export", &out, "--to", "mjcf"]);
    assert_eq!(code(&export), 2, "{}", errors(&export));
    assert!(errors(&export).contains("--to motion"), "{}", errors(&export));
    assert_eq!(code(&sgc(&["export", &out, "--to", "motion"])), 0);
}

/// A cell keeps a tenth of its size, whatever its drive asks for.
#[test]
fn a_strain_that_would_leave_nothing_of_a_cell_is_cut_off() {
    let least = |drive: &str| {
        let text = HEAD.replace("20 % * sin(t / period * 360 deg)", drive);
        let begin = "begin { fill region(middle, -1 .. 1, 0, 0) with gel(beat = Beat.early, side = 1) }";
        let rules = rules_of(&format!("{text}\nlattice 3 x 1 x 1 of gel\n{begin}"));
        let candidate = Candidate::new(&rules, Arc::new(Derivation::begin(&rules)));
        let drive = Drive::new(&candidate, rules.first_task().unwrap()).unwrap();
        drive.targets(&[]).unwrap().angles.into_iter().fold(0.0, f64::min)
    };
    assert!((least("-85 % * sin(t / period * 180 deg)") + 0.85).abs() < 1e-12);
    assert_eq!(least("-150 % * sin(t / period * 180 deg)"), -0.9);
}
