//! The page of a design: how it was made, how large it is, and what a browser shows of it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use grammar_lang::source::SourceMap;
use sgc::derive::{Derivation, Stream};
use sgc::design::Body;
use sgc::results::making::making;
use sgc::results::names::Names;
use sgc::results::view::Making;

use crate::browser::{chromium, elements, picture, told};
use crate::support::{GRAMMARS, grammar, root};

/// The elements that are there after a step, in an order of their own.
fn there(making: &Making, step: usize) -> Vec<String> {
    let pieces = making.pieces.iter();
    let pieces = pieces.filter(|p| p.from <= step && p.until.is_none_or(|until| until > step));
    let mut there: Vec<String> = pieces
        .map(|piece| {
            let pose = piece.poses.iter().rfind(|(from, _)| *from <= step).unwrap().1;
            format!("{:?} {pose:?}", piece.look.shape)
        })
        .collect();
    there.sort();
    there
}

#[test]
fn after_every_step_the_pieces_are_the_elements_of_the_design_then() {
    let mut steps_seen = 0;
    for path in GRAMMARS {
        let rules = grammar(path);
        for seed in 0..3 {
            let mut now = Derivation::begin(&rules);
            let mut random = Stream::named(seed, "view");
            for _ in 0..25 {
                now = now.advance(&rules, &mut random, 0.0).result.unwrap_or(now);
            }
            let names = Names::through(&rules, &now);
            let making = making(&rules, &SourceMap::default(), &now, &names);
            assert_eq!(making.steps.len(), now.steps.len() + 1);
            let mut designs = vec![Derivation::begin(&rules).design];
            now.retrace(&rules, |_, _, after| designs.push(after.clone()));
            assert_eq!(designs.last(), Some(&now.design), "{path}: the steps lead to the design");
            for (step, design) in designs.iter().enumerate() {
                let body = Body::new(design, &rules);
                let elements = body.assembly.elements.iter();
                let mut want: Vec<String> = elements.map(|e| format!("{:?} {:?}", e.shape, e.pose)).collect();
                want.sort();
                assert_eq!(there(&making, step), want, "{path}, seed {seed}, step {step}");
                assert!(!making.steps[step].done.is_empty());
                steps_seen += 1;
            }
            // What never changes is there once.
            if now.steps.len() < 4 {
                continue;
            }
            let all = now.steps.len() * making.pieces.len();
            let poses: usize = making.pieces.iter().map(|piece| piece.poses.len()).sum();
            assert!(poses < all.max(40) / 2, "{path}: {poses} poses, {all} elements in all steps");
        }
    }
    assert!(steps_seen > 200, "{steps_seen}");
}

fn sgc(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sgc"));
    command.args(arguments).current_dir(root()).env("NO_COLOR", "1").output().unwrap()
}

/// Searches a little and gives the page of what was found.
fn page(folder: &Path, arguments: &[&str]) -> PathBuf {
    let run = folder.join("run");
    let run = run.to_str().unwrap();
    let arguments = [&["run"], arguments, &["--quiet", "--out", run]].concat();
    for arguments in [arguments.as_slice(), &["view", run]] {
        let output = sgc(arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    folder.join("run/view.html")
}

#[test]
fn the_page_of_a_long_motion_of_many_elements_is_small() {
    let folder = tempfile::tempdir().unwrap();
    // 58 elements, 40 hinges, 20 s.
    let page = page(folder.path(), &["benches/bodies/bodies.sgr", "--from", "eight", "--max-evals", "8"]);
    let size = std::fs::metadata(page).unwrap().len();
    assert!(size < 1_500_000, "{size} bytes");
}

/// A body of 31 elements that was made in six steps.
const FOUR: [&str; 5] = ["benches/bodies/bodies.sgr", "--from", "four", "--max-evals", "40"];

#[test]
fn a_browser_plays_the_motion() {
    let Some(browser) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path(), &FOUR);
    let dom = elements(&browser, &page, "", true);
    assert_eq!((told(&dom, "state"), told(&dom, "errors"), told(&dom, "webgl")), ("playing", "0", "yes"));
    assert!(told(&dom, "frames").parse::<usize>().unwrap() > 300);
    // A machine with much else to do may draw no second picture.
    let plays = |dom: &str| told(dom, "time").parse::<f64>().unwrap() > 0.1;
    let again = || elements(&browser, &page, "", true);
    assert!(plays(&dom) || plays(&again()) || plays(&again()), "time stands still");

    let [early, late, again] = ["#t=1", "#t=7", "#t=7"].map(|moment| picture(&browser, &page, moment));
    assert!(
        early.colours() > 500 && late.colours() > 500,
        "{} and {} colours",
        early.colours(),
        late.colours()
    );
    assert!(early.unlike(&late) > 0.01, "{}", early.unlike(&late));
    assert!(late.unlike(&again) < 0.001, "{}", late.unlike(&again));
}

#[test]
fn a_browser_shows_how_it_was_made() {
    let Some(browser) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path(), &FOUR);
    let dom = elements(&browser, &page, "#step=3", true);
    assert_eq!((told(&dom, "state"), told(&dom, "errors"), told(&dom, "step")), ("paused", "0", "3"));
    assert!(dom.contains("step 3 of 6"), "the clock tells the step");
    assert_eq!(dom.matches("aria-current=\"step\"").count(), 1);
    let caption = dom.split_once("id=\"caption\"").and_then(|(_, rest)| rest.split_once("</p>")).unwrap().0;
    for words in ["add_actuator", "Adds a bending actuator", "cube-1", "left", "180 deg", "adds bender"] {
        assert!(caption.contains(words), "{words}: {caption}");
    }

    let [third, last] = ["#step=3", "#step=6"].map(|step| picture(&browser, &page, step));
    assert!(
        third.colours() > 500 && last.colours() > 500,
        "{} and {} colours",
        third.colours(),
        last.colours()
    );
    assert!(third.unlike(&last) > 0.01, "{}", third.unlike(&last));
}

#[test]
fn a_browser_without_3d_shows_the_rest() {
    let Some(browser) = chromium() else { return };
    let folder = tempfile::tempdir().unwrap();
    let page = page(folder.path(), &FOUR);
    let dom = elements(&browser, &page, "", false);
    assert_eq!((told(&dom, "webgl"), told(&dom, "state"), told(&dom, "errors")), ("no", "playing", "0"));
    assert!(dom.contains("WebGL is missing"));
    assert!(told(&dom, "time").parse::<f64>().unwrap() > 0.1, "time stands still without WebGL");
    let dom = elements(&browser, &page, "#step=9", false);
    assert_eq!((told(&dom, "step"), told(&dom, "errors")), ("6", "0"));
}
