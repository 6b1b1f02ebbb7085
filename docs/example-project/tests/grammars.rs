//! What our grammars are, in snapshots. After a change that you meant:
//! `cargo insta review`.

use sgc::testing;

/// Tests run in the folder of the project.
const CRAWLER: &str = "grammars/crawler.sgr";

/// Nothing is wrong with any file; a snapshot for each shows what is, if it is.
#[test]
fn findings() {
    insta::glob!("..", "grammars/*.sgr", |path| {
        insta::assert_snapshot!(testing::findings(path));
    });
}

/// The bodies that three seeds give. A rule or requirement that changed shows here.
#[test]
fn bodies() {
    for seed in 1..=3 {
        let name = format!("crawler_with_seed_{seed}");
        insta::assert_snapshot!(name, testing::derivation(CRAWLER, seed, 12));
    }
}

/// A promise that is no snapshot, and that no seed may break.
#[test]
fn no_crawler_needs_a_fifth_channel() {
    for seed in 1..=20 {
        let body = testing::derivation(CRAWLER, seed, 30);
        let fingers = body.lines().filter(|line| line.contains(". finger-")).count();
        assert!(fingers <= 4, "seed {seed} gives {fingers} fingers:\n{body}");
    }
}
