//! Runs that are killed and gone on with. In the profile `long` a hundred are killed, else five,
//! or as many as `SGC_KILLS` says.

use std::path::Path;
use std::time::{Duration, Instant};

use sgc::derive::Stream;
use sgc::results::saved::SavedDesign;

use crate::runs::{assert_code, assert_same, grammar, grammar_in_worlds, path, short, start, whole};
use crate::support::is_long;

#[test]
fn a_run_that_is_killed_and_resumed_ends_as_if_nothing_had_been() {
    let folder = tempfile::tempdir().unwrap();
    kill_and_resume(folder.path(), &grammar(folder.path(), "1"));
}

#[test]
fn a_run_in_many_worlds_that_is_killed_and_resumed_ends_as_if_nothing_had_been() {
    let folder = tempfile::tempdir().unwrap();
    kill_and_resume(folder.path(), &grammar_in_worlds(folder.path(), "shortly_many_kinds"));
    assert!(folder.path().join("whole/archive.csv").exists(), "kinds are compared, too");
    let best = SavedDesign::read(&folder.path().join("whole/best.design.json")).unwrap();
    assert_eq!(best.tasks[0].tests.len(), 64, "it was tried in worlds that the search has not seen");
}

#[test]
fn a_population_that_is_killed_and_resumed_ends_as_if_nothing_had_been() {
    let folder = tempfile::tempdir().unwrap();
    kill_and_resume(folder.path(), &grammar_in_worlds(folder.path(), "recommended"));
    let moves = std::fs::read_to_string(folder.path().join("whole/evals.csv")).unwrap();
    let place = moves.lines().next().unwrap().split(',').position(|name| name == "tuned").unwrap();
    let further =
        moves.lines().skip(1).filter(|row| row.split(',').nth(place).is_some_and(|times| times != "0"));
    assert!(further.count() > 2, "{moves}");
}

#[test]
fn a_population_that_begins_anew_is_resumed_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = grammar_in_worlds(folder.path(), "recommended");
    let text = std::fs::read_to_string(&grammar).unwrap();
    let own = "search own {
  keep = 80 %
  bodies population {
    iterations = 100  moves = 3  stop = false  size = 3  tournament = 2  further = 30 %  restart = idle >= 2
  }
  curves cma_es { iterations = 1  moves = 4  stop = false  warm = true  spread = 15 % }
}
search own";
    let text = text.replace("use std.search     { recommended }\n", "").replace("search   recommended", own);
    assert!(text.contains(own), "{text}");
    std::fs::write(&grammar, text).unwrap();
    kill_and_resume(folder.path(), &grammar);
}

#[test]
fn a_front_that_is_killed_and_resumed_ends_as_if_nothing_had_been() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = grammar_in_worlds(folder.path(), "trade_offs");
    let text = std::fs::read_to_string(&grammar).unwrap();
    let text = text.replace("travel, fall }", "travel, fall, energy }");
    let two = text.replace("search   trade_offs", "minimize energy in J\nsearch trade_offs");
    assert!(two.contains("energy }") && two.contains("minimize energy"), "{two}");
    std::fs::write(&grammar, two).unwrap();
    kill_and_resume(folder.path(), &grammar);
    let front = std::fs::read_to_string(folder.path().join("whole/front.csv")).unwrap();
    assert!(front.lines().count() > 3, "{front}");
}

#[test]
fn a_search_for_weights_that_is_killed_and_resumed_ends_as_if_nothing_had_been() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = folder.path().join("learner.sgr");
    std::fs::write(&grammar, crate::policies::learner().replace("for 2 s", "for 1 s")).unwrap();
    kill_and_resume(folder.path(), &grammar);
}

#[test]
fn a_learner_that_is_killed_and_resumed_ends_as_if_nothing_had_been() {
    for method in ["soft_actor_critic", "double_dqn"] {
        let folder = tempfile::tempdir().unwrap();
        let grammar = folder.path().join("learner.sgr");
        std::fs::write(&grammar, crate::policies::learner_by(method).replace("for 2 s", "for 1 s")).unwrap();
        kill_and_resume(folder.path(), &grammar);
    }
}

/// Kills runs at any time, resumes them with any number of threads, and compares what they leave.
fn kill_and_resume(folder: &Path, grammar: &Path) {
    let usual = if is_long() { 100 } else { 5 };
    let kills: usize = std::env::var("SGC_KILLS").map_or(usual, |kills| kills.parse().expect("a number"));
    let begun = Instant::now();
    let whole = whole(folder, grammar);
    let takes = begun.elapsed().as_secs_f64();
    let mut random = Stream::named(u64::from(std::process::id()), "kills");
    let (mut killed, mut runs, mut resumed) = (0, 0, 0);
    // On a busy machine the first kills may come before there is anything to go on with.
    let goes_on = |killed: usize, resumed: usize| killed < kills || resumed == 0 && killed < 20 * kills;
    while goes_on(killed, resumed) {
        runs += 1;
        let out = folder.join(format!("run-{runs}"));
        loop {
            let jobs = ["1", "2"][random.below(2)];
            let mut arguments = if out.exists() {
                resumed += 1;
                vec!["resume", path(&out), "--quiet", "--checkpoint", "0.001s"]
            } else {
                short(grammar, &out)
            };
            arguments.extend(["--jobs", jobs]);
            let mut child = start(&arguments);
            if goes_on(killed, resumed) {
                std::thread::sleep(Duration::from_secs_f64(takes * 0.35 * random.unit()));
                child.kill().unwrap();
            }
            let output = child.wait_with_output().unwrap();
            if output.status.code().is_some() {
                assert_code(&output, 0);
                break;
            }
            killed += 1;
            // Somebody tidies up: what the search still knows is written again.
            let _ = std::fs::remove_dir_all(out.join("archive"));
            let _ = std::fs::remove_dir_all(out.join("front"));
        }
        assert_same(&out, &whole);
    }
    assert!(resumed > 0, "{killed} kills, none of them after the run had begun");
}
