//! Searches whose objective runs over worlds.

use grammar_lang::ir::RuleSet;
use sgc::results::elsewhere::{Tested, judge, tested};
use sgc::results::replay::{How, Precision, replay};
use sgc::results::robustness::final_check;
use sgc::results::saved::{CheckOfAll, Grammar, Measured, SavedDesign};
use sgc::results::verdict::{Verdict, kept, silent, verdict_of_all};
use sgc::results::{genuine, saving, summary};
use sgc::scenarios;
use sgc::search::{Best, State, Tune};
use sgc::simulate::Stop;

use crate::search::{same_end, search, search_from};
use crate::support::{compile_texts, texts};

const SET: &str = "scenarios workshop {
  friction = 75 % .. 125 %
  mass     = 90 % .. 110 %
  torque   = 60 % .. 115 %
  late     = 0 ms .. 50 ms
  drawn    = 3
  case ice { ground_friction = 0.2 }
}";

/// `codesign` with short motions in five worlds.
fn robust(objective: &str, search: &str) -> RuleSet {
    let mut texts = texts();
    let search = search.replace("  ", "\n");
    let text = texts["grammars/codesign.sgr"]
        .replace("use std.scenarios  { workshop }\n", "")
        .replace("simulate hinge_model for 20 s", &format!("{SET}\nsimulate hinge_model for 1 s in workshop"))
        .replace("maximize travel - fall in cm", objective)
        .replace("use std.search     { nested_annealing }", "use std.search { cauchy }")
        .replace(
            "search   nested_annealing",
            &format!("search quick\nsearch quick {{ keep = 80 %\n{search} }}"),
        );
    texts.insert("grammars/codesign.sgr".into(), text);
    compile_texts(&texts, "grammars/codesign.sgr").unwrap()
}

const WORST: &str = "maximize min over w in workshop of travel - fall in cm";

const BODIES: &str =
    "bodies annealing { iterations = 100  moves = 3  temperature = cauchy(9, 0.1, iteration)  stop = false }";

fn annealed(judge: &str) -> String {
    format!(
        "{BODIES}  curves annealing {{ iterations = 6  moves = 4  temperature = cauchy(1, 0.1, iteration)  \
         stop = false  judge = {judge} }}"
    )
}

fn evolved(judge: &str) -> String {
    format!(
        "{BODIES}  curves cma_es {{ iterations = 3  moves = 8  stop = false  spread = 30 %  judge = {judge} }}"
    )
}

/// What a saved design comes to in each world, the nominal one first, and over all of them.
fn in_each(rules: &RuleSet, design: &SavedDesign) -> (Vec<f64>, f64) {
    let (name, set) = rules.scenarios.get_index(0).unwrap();
    let how = How { solver: "articulated", precision: Precision::Model, stop: Stop::NEVER };
    let (judged, whole) = judge(rules, design, scenarios::worlds(name, set), how).unwrap();
    (judged.into_iter().map(|judged| judged.value.unwrap()).collect(), whole.unwrap())
}

fn saved(rules: &RuleSet, best: &Best) -> SavedDesign {
    let frozen = Grammar::freeze(rules, &grammar_lang::source::SourceMap::default(), &[]);
    saving::save(rules, frozen, 1, "articulated", best).unwrap()
}

/// A search that begins with a design ends with it or with a better one, however few evaluations it has.
#[test]
fn a_search_does_not_lose_the_design_that_it_begins_with() {
    let rules = robust(WORST, &evolved("best").replace("30 %", "3 %"));
    let given = search(&rules, 2, 2, 600).0.best.unwrap();
    assert!(given.value > 0.0);
    let curves = vec![given.tasks[0].parameters.clone()];
    for seed in 1..=12 {
        let state = State::begin_with((*given.derivation).clone(), curves.clone());
        let (outcome, _) = search_from(&rules, state, seed, 2, 40);
        let best = outcome.best.unwrap();
        assert!(best.value >= given.value, "seed {seed}: {} after {}", best.value, given.value);
        assert_eq!(in_each(&rules, &saved(&rules, &best)).1.to_bits(), best.value.to_bits());
    }
}

/// The value of a best is what its objective says of the values in each world.
#[test]
fn a_value_is_that_of_all_worlds_together() {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let spread = |values: &[f64]| {
        let squares = values.iter().map(|x| (x - mean(values)) * (x - mean(values)));
        libm::sqrt(squares.sum::<f64>() / values.len() as f64)
    };
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let quartile = |values: &[f64]| {
        let mut values = values.to_vec();
        values.sort_by(f64::total_cmp);
        values[1]
    };
    type Expected<'a> = &'a dyn Fn(&[f64]) -> f64;
    let cases: [(&str, Expected); 4] = [
        (WORST, &least),
        ("maximize mean over w in workshop of travel - fall in cm", &mean),
        (
            "maximize (mean over w in workshop of travel - fall) - 2 * (deviation over w in workshop of travel - fall) in cm",
            &|values| mean(values) - 2.0 * spread(values),
        ),
        ("maximize quantile 25 % over w in workshop of travel - fall in cm", &quartile),
    ];
    for (objective, expected) in cases {
        let rules = robust(objective, &annealed("promising"));
        let best = search(&rules, 2, 2, 1500).0.best.expect("a best design");
        let design = saved(&rules, &best);
        let (values, whole) = in_each(&rules, &design);
        assert_eq!(values.len(), 5);
        assert_eq!(whole.to_bits(), best.value.to_bits(), "{objective}");
        assert!((best.value - expected(&values)).abs() < 1e-9, "{objective}: {} {values:?}", best.value);
        let Tune { nominal, half_step, .. } = &best.tasks[0];
        assert_eq!(nominal.unwrap().to_bits(), values[0].to_bits(), "{objective}");
        assert!(half_step.is_none_or(|half| half >= 0.8 * values[0]), "{objective}: {half_step:?}");
        // Simulated again it is the same to the bit, and says so itself.
        let again = replay(&rules, &design, "articulated", Precision::Model).unwrap();
        genuine::check_values(&rules, &design, &again).unwrap();
    }
}

#[test]
fn threads_and_pieces_change_nothing() {
    for search_by in
        [annealed("every"), annealed("promising"), annealed("best"), evolved("best"), evolved("every")]
    {
        let rules = robust(WORST, &search_by);
        let (one, log_one) = search(&rules, 2, 1, 400);
        let (three, log_three) = search(&rules, 2, 3, 400);
        assert_eq!(log_one, log_three, "{search_by}");
        assert_eq!(one.evaluations, three.evaluations, "{search_by}");
        assert!(one.best.is_some_and(|best| best.tasks[0].nominal.is_some()), "{search_by}");
        assert!(same_end(&rules, 3, 7, None) > 1, "{search_by}");
    }
}

/// A worst case is no better than the value in the nominal world: what that excludes need not be judged elsewhere.
#[test]
fn what_the_worst_case_excludes_changes_nothing() {
    let all = "maximize (min over w in workshop of travel - fall) + 0 cm in cm";
    let found = |objective: &str| {
        let rules = robust(objective, &annealed("every"));
        let (outcome, log) = search(&rules, 5, 2, 6_000);
        let value = |row: &String| {
            let value = row.split("value: ").nth(1).and_then(|rest| rest.split(", accepted").next());
            value.unwrap_or_default().to_owned()
        };
        let values: Vec<String> = log.iter().filter(|row| row.starts_with("Row")).map(value).collect();
        (outcome, values)
    };
    assert!(robust(WORST, &annealed("every")).tasks[0].is_worst_case());
    let ((one, some), (other, more)) = (found(WORST), found(all));
    assert_eq!(other.best.as_ref().map(|_| ()), one.best.as_ref().map(|_| ()));
    let shared = some.len().min(more.len()) - 1;
    assert!(shared > 3, "{shared}");
    assert_eq!(some[..shared], more[..shared]);
    // What it saves goes into more bodies.
    assert!(some.len() > more.len(), "{} and {}", some.len(), more.len());
}

/// An objective that runs over no worlds is that of the nominal one, whatever the scenarios; they serve for the test at the end.
#[test]
fn scenarios_that_an_objective_does_not_run_over_change_nothing_but_the_test() {
    let plain = robust("maximize travel - fall in cm", &annealed("promising"));
    let mut without = plain.clone();
    without.tasks[0].scenarios = None;
    let ((one, log), (other, same)) = (search(&plain, 2, 2, 300), search(&without, 2, 2, 300));
    assert_eq!((log, one.evaluations), (same, other.evaluations));
    let (design, bare) = (saved(&plain, &one.best.unwrap()), saved(&without, &other.best.unwrap()));
    let design = final_check(&plain, &design, Stop::NEVER).unwrap();
    let bare = final_check(&without, &bare, Stop::NEVER).unwrap();
    assert_eq!((design.tasks[0].tests.len(), bare.tasks[0].tests.len()), (64, 0));
    assert_eq!(design.tasks[0].checks, bare.tasks[0].checks);
    // None of them is one that a search could see.
    let (name, set) = plain.scenarios.get_index(0).unwrap();
    let (seen, tests) = (scenarios::worlds(name, set), scenarios::tests(name, set));
    assert!(tests.iter().all(|test| seen.iter().all(|seen| seen.differences != test.differences)));
}

/// A motion without a value in one world is an evaluation without a value, counted by the world.
#[test]
fn what_has_no_value_in_a_world_is_counted_by_it() {
    let mut texts = texts();
    texts.insert("grammars/own.sgr".into(), {
        let text = texts["grammars/codesign.sgr"].replace(
            "simulate hinge_model for 20 s",
            "scenarios lab { case steep { slope = 45 deg } }\nsimulate hinge_model for 2 s in lab",
        );
        text.replace("maximize travel - fall in cm", "maximize min over w in lab of travel - fall in cm")
    });
    let text = texts["std.models"].replace("speed_limit     = 10 m/s", "speed_limit     = 0.6 m/s");
    texts.insert("std.models".into(), text);
    let rules = compile_texts(&texts, "grammars/own.sgr").unwrap();
    let outcome = search(&rules, 2, 2, 120).0;
    let lost = outcome.tally.elsewhere.get("`steep`: too fast").copied().unwrap_or(0);
    assert!(lost > 10, "whatever slides down is too fast: {:?}", outcome.tally);
    assert!(outcome.tally.reasons().contains("in another world"), "{}", outcome.tally.reasons());
    let told = outcome.tally.reasons_in_worlds();
    assert!(told.contains(&format!("in another world ({lost} in `steep`: too fast)")), "{told}");
}

/// What no world alone can show is told of all that a best is tested in, together.
#[test]
fn a_deviation_is_told_over_all_worlds_of_the_test() {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let steady = "(mean over w in workshop of travel) - (deviation over w in workshop of travel)";
    for (objective, is_told_by_each) in
        [(format!("maximize {steady} in cm"), false), (WORST.to_owned(), true)]
    {
        let rules = robust(&objective, &annealed("promising"));
        assert_eq!(rules.tasks[0].objective.is_told_by_each_world(), is_told_by_each, "{objective}");
        let design = saved(&rules, &search(&rules, 2, 2, 300).0.best.expect("a best design"));
        let design = final_check(&rules, &design, Stop::NEVER).unwrap();
        let task = &design.tasks[0];
        let each: Vec<f64> = task.tests.iter().map(|world| world.value.unwrap()).collect();
        assert_eq!(each.len(), 64);
        let said = summary::tests(&rules, &design, task).unwrap();
        if is_told_by_each {
            assert_eq!(task.tested, None);
            assert!(matches!(tested(&rules, &design), Some(Tested::Each(_))));
            assert!(!said.contains("over all"), "{said}");
            continue;
        }
        let all: Vec<f64> = each.into_iter().chain([task.in_nominal()]).collect();
        let squares: Vec<f64> = all.iter().map(|x| (x - mean(&all)) * (x - mean(&all))).collect();
        let (whole, expected) = (task.tested.unwrap(), mean(&all) - libm::sqrt(mean(&squares)));
        assert!((whole - expected).abs() < 1e-9 && whole < mean(&all), "{whole} {expected}");
        assert_eq!(tested(&rules, &design), Some(Tested::Whole(Some(whole))));
        assert!(said.contains(" over all of them and the nominal world; in each world alone: "), "{said}");
    }
}

/// Of several tasks it is told what the objective of all of them comes to, not what the first one does.
#[test]
fn several_tasks_are_told_together_over_the_worlds_of_the_test() {
    let rules = robust(
        "task ahead { maximize min over w in workshop of travel in cm }\n\
         task near { maximize min over w in workshop of travel in mm }\n\
         maximize ahead.value + 2 * near.value in cm",
        &annealed("every"),
    );
    let design = saved(&rules, &search(&rules, 3, 2, 300).0.best.expect("a best design"));
    let design = final_check(&rules, &design, Stop::NEVER).unwrap();
    let mean = |task: usize| {
        let values: Vec<f64> = design.tasks[task].tests.iter().map(|world| world.value.unwrap()).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let lost: f64 = design.penalties.iter().map(|(_, weight)| weight).sum();
    let Some(Tested::Each(together)) = tested(&rules, &design) else {
        panic!("{:?}", tested(&rules, &design))
    };
    let expected = mean(0) + 0.2 * mean(1) - lost;
    assert!(mean(1) > 0.01 && (together.mean.unwrap() - expected).abs() < 1e-9, "{together:?} {expected}");
}

/// Each task may keep its share of a value, and their difference next to nothing.
#[test]
fn what_tasks_come_to_together_is_checked_beside_each_of_them() {
    let rules = robust(
        "task ahead { maximize min over w in workshop of travel in cm }\n\
         task near { maximize min over w in workshop of travel in mm }\n\
         maximize 10 * ahead.value - 9 * near.value + 3 cm in cm",
        &annealed("every"),
    );
    let design = saved(&rules, &search(&rules, 3, 2, 300).0.best.expect("a best design"));
    assert_eq!(design.of_all, None);
    let design = final_check(&rules, &design, Stop::NEVER).unwrap();
    let of_all = design.of_all.as_ref().expect("of two tasks");
    let lost: f64 = design.penalties.iter().map(|(_, weight)| weight).sum();
    assert!((of_all.at_rest[0] - (3.0 - lost)).abs() < 1e-6, "{:?} {lost}", of_all.at_rest);
    let eighth = of_all.checks.iter().find(|check| check.name.starts_with("an eighth")).unwrap();
    let of_task = |task: usize| {
        let all = design.tasks[task].checks.iter().find(|check| check.measured == Measured::InWorlds);
        all.unwrap().value.unwrap()
    };
    let expected = 10.0 * of_task(0) - 0.9 * of_task(1) + 3.0 - lost;
    assert!((eighth.values[0] - expected).abs() < 1e-9, "{eighth:?} {expected}");
    // Of the value, 3 cm less preferences are no part of what the motion is worth.
    let verdict = |share: f64| {
        let values = vec![of_all.at_rest[0] + share * (design.value - of_all.at_rest[0])];
        verdict_of_all(&rules, &design, of_all, &CheckOfAll { values, ..eighth.clone() })
    };
    assert_eq!(verdict(0.85), Verdict::Confirmed);
    assert_eq!(verdict(0.75), Verdict::Worse);
    assert_eq!(verdict(1.3), Verdict::Better);
    let none = CheckOfAll { values: Vec::new(), ..eighth.clone() };
    assert_eq!(verdict_of_all(&rules, &design, of_all, &none), Verdict::Refuted);
    let told = summary::report(&rules, &design);
    assert!(told.contains("all tasks together, checked over all worlds:\n  with half the step"), "{told}");
    let of_one: usize = design.tasks.iter().map(|task| task.checks.len()).sum();
    assert!(kept(&rules, &design).1 + silent(&rules, &design).count() == of_one + of_all.checks.len());
    // What the file says of the body at rest is found if it is not so.
    let replayed = replay(&rules, &design, "articulated", Precision::Model).unwrap();
    genuine::check_values(&rules, &design, &replayed).unwrap();
    let mut forged = design.clone();
    forged.of_all.as_mut().unwrap().at_rest[0] = -1e9;
    assert!(genuine::check_values(&rules, &forged, &replayed).is_err());
}

/// The nominal motion alone has a value, though a condition asks for other worlds.
#[test]
fn a_condition_that_the_nominal_world_does_not_meet_can_be_searched_for() {
    let objective = "maximize mean over w in workshop where w.ground_friction < 0.5 of travel - fall in cm";
    let rules = robust(objective, &annealed("promising"));
    let best = search(&rules, 2, 2, 400).0.best.expect("a best design");
    let design = saved(&rules, &best);
    let (values, whole) = in_each(&rules, &design);
    assert_eq!(
        (values[1].to_bits(), best.value.to_bits()),
        (whole.to_bits(), whole.to_bits()),
        "on ice alone"
    );
    assert_eq!(best.tasks[0].nominal.unwrap().to_bits(), values[0].to_bits());
}

/// Judged alone, a motion stands for all worlds: it has the same value whatever is gathered. But a condition on the motion holds or not.
#[test]
fn a_motion_that_is_judged_alone_stands_for_the_worlds_that_are_picked() {
    let rules = robust(WORST, &annealed("every"));
    let design = saved(&rules, &search(&rules, 2, 2, 60).0.best.expect("a best design"));
    let alone = in_each(&rules, &design).0[0];
    let on_ice = "over w in workshop where w.ground_friction < 0.5";
    let count = "(count over w in workshop where w.ground_friction < 0.5)";
    for (objective, expected) in [
        (format!("min {on_ice} of (travel - fall) / 1 cm"), alone),
        (format!("sum {on_ice} of (travel - fall) / 1 cm"), alone),
        (format!("max {on_ice} of (travel - fall) / 1 cm otherwise 700"), alone),
        (format!("({count}) * 3"), 3.0),
        ("count over w in workshop where travel > 90 m".to_owned(), 0.0),
    ] {
        let judged = robust(&format!("maximize {objective}"), &annealed("every"));
        let value = in_each(&judged, &design).0[0];
        assert!((value - expected).abs() < 1e-9, "{objective}: {value}, not {expected}");
    }
}

/// Terms are those of the world that is run over, and so are its own numbers.
#[test]
fn a_world_tells_what_differs_in_it() {
    for (objective, expected) in [
        ("maximize min over w in workshop of w.ground_friction", 0.2),
        ("maximize sum over w in workshop where w.ground_friction < 0.5 of w.mass", 1.0),
        ("maximize max over w in workshop of w.late / 1 ms", 50.0),
        ("maximize first(workshop).mass + count(workshop)", 6.0),
    ] {
        let rules = robust(objective, &annealed("every"));
        let best = search(&rules, 1, 1, 40).0.best.expect("a design");
        assert!((best.value - expected).abs() < 1e-9, "{objective}: {}", best.value);
    }
}

/// A population needs no worst case of a body that is not the best of the run: a few worlds say what it is at most.
#[test]
fn a_population_knows_worst_cases_as_far_as_it_needs_them() {
    let rules = robust(
        WORST,
        "bodies population { iterations = 500  moves = 3  stop = false  size = 5  tournament = 2  further = 40 % }  \
         curves cma_es { iterations = if tuned == 0 then 1 else 2  moves = 4  stop = false  warm = true  spread = 15 % }",
    );
    let (one, log) = search(&rules, 2, 1, 600);
    let (three, same) = search(&rules, 2, 3, 600);
    assert_eq!((&log, one.evaluations), (&same, three.evaluations));
    assert!(same_end(&rules, 3, 7, None) > 1);

    let of = |row: &str, field: &str| -> Option<f64> {
        let text = row.split(&format!(" {field}: ")).nth(1)?.split(", ").next()?;
        text.trim_start_matches("Some(").trim_end_matches(')').parse().ok()
    };
    let rows: Vec<&String> = log.iter().filter(|row| row.starts_with("Row")).collect();
    let mut at_most = 0;
    for row in &rows {
        let Some(worlds) = of(row, "at_most_in") else { continue };
        at_most += 1;
        assert!((1.0..=5.0).contains(&worlds), "{row}");
        assert!(of(row, "value") <= of(row, "best"), "it is not the best of the run: {row}");
        assert!(of(row, "value") <= of(row, "nominal"), "{row}");
    }
    assert!(at_most > 5, "{log:#?}");
    // The best is known in all.
    let best = one.best.unwrap();
    assert_eq!(best.tasks[0].at_most_in, None);
    assert_eq!(in_each(&rules, &saved(&rules, &best)).1.to_bits(), best.value.to_bits());
    // What is kept already is not simulated again.
    let spent = |row: &str| of(row, "evaluations").unwrap();
    let known: Vec<_> = rows.windows(2).filter(|pair| pair[1].contains("the body is kept already")).collect();
    assert!(!known.is_empty(), "{log:#?}");
    assert!(
        known
            .iter()
            .filter(|pair| pair[1].contains("rule: None"))
            .all(|pair| spent(pair[0]) == spent(pair[1]))
    );
}
