//! The tables and the words of the page, for a few rows that can be checked by hand.

use std::path::Path;

use super::gather::tests::{group, run, two};
use super::read::{Group, Standing};
use super::{Reload, TABLES, page, relative};
use crate::results::processes::Process;

/// The words of a page: what is not in the style or a tag, a line for each tag that ends one.
fn words(page: &str) -> String {
    let body = page.split_once("</style>").map_or(page, |(_, body)| body);
    let mut out = String::new();
    let mut rest = body;
    while let Some((before, after)) = rest.split_once('<') {
        out.push_str(before);
        let (tag, after) = after.split_once('>').unwrap_or((after, ""));
        if let Some(picture) = tag.strip_prefix("svg") {
            let told = picture.split_once("aria-label=\"").and_then(|(_, told)| told.split_once('"'));
            out.push_str(&format!("[picture: {}]", told.map_or("", |(told, _)| told)));
            rest = after.split_once("</svg>").map_or("", |(_, after)| after);
            continue;
        }
        match tag {
            "/td" | "/th" => out.push_str(" | "),
            "/dt" => out.push_str(": "),
            "/p" | "/div" | "/tr" | "/h1" | "/h2" | "/h3" | "/figure" | "/span" => out.push('\n'),
            _ => {}
        }
        rest = after;
    }
    let lines = out.lines().map(|line| line.replace(['\u{a0}', '\u{202f}'], " ").trim().to_owned());
    lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join("\n")
}

fn written(groups: &[Group]) -> String {
    page::page(groups, &|_| None, Reload::Never)
}

/// Two complete runs, and a group of one that was stopped.
fn both() -> Vec<Group> {
    let mut first = two();
    first.runs[0].processes = Some(vec![Process { begin: 0, end: 8, seconds: 2.0, threads: 2 }]);
    let mut other = group(vec![run(3, "0,0,,,1,0,1,true,1,0,1,0,0,\n1,0,add,,2,0,3,true,3,9,2,0,0,\n")]);
    other.name = "other <b>".to_owned();
    other.runs[0].standing = Standing::Stopped;
    vec![first, other]
}

#[test]
fn the_tables_of_a_few_rows() {
    let groups = both();
    let all: String = TABLES.iter().map(|(name, table)| format!("## {name}\n{}", table(&groups))).collect();
    insta::assert_snapshot!(all);
}

#[test]
fn the_words_of_a_few_rows() {
    let page = written(&both());
    insta::assert_snapshot!(words(&page));
    assert!(!page.contains("other <b>"), "no text becomes markup");
}

#[test]
fn any_run_has_a_page() {
    let first = "0,0,,,1,0,0,true,0,0,1,0,0,\n";
    let invalid = "0,0,,,1,0,,true,,0,1,1,0,1 not finite\n1,0,add,,2,0,,true,,9,2,1,0,1 not finite\n";
    let idle = format!("{first}1,0,,add: solid,1,0,,false,0,9,1,0,0,\n");
    for rows in ["", first, invalid, &idle] {
        for more in [false, true] {
            let runs = if more { vec![run(1, rows), run(2, first)] } else { vec![run(1, rows)] };
            let groups = vec![group(runs)];
            let page = written(&groups);
            assert!(!page.contains("NaN") && !page.contains("inf"), "{rows}: {page}");
            for (name, table) in TABLES {
                let text = table(&groups);
                let columns = text.lines().next().unwrap().split(',').count();
                assert!(text.lines().all(|line| line.split(',').count() == columns), "{name}: {text}");
                assert!(!text.contains("NaN") && !text.contains("inf"), "{name}: {text}");
            }
        }
    }
}

#[test]
fn a_page_reloads_itself_only_while_its_runs_go_on() {
    let groups = both();
    let going = page::page(&groups, &|_| None, Reload::WhileRunning);
    assert!(going.contains("http-equiv=\"refresh\""));
    let done = written(&groups);
    assert!(!done.contains("http-equiv=\"refresh\"") && done.contains("1 of 3 runs are not complete"));
    for page in [going, done] {
        assert!(!page.contains("<script") && !page.contains("src=") && !page.contains("http:"));
    }
}

#[test]
fn pages_of_runs_are_linked_from_where_the_report_is() {
    let way = |folder, file| relative(Path::new(folder), Path::new(file));
    assert_eq!(way("/runs/x/report", "/runs/x/seed-1/view.html"), "../seed-1/view.html");
    assert_eq!(way("/elsewhere", "/runs/a b#1/view.html"), "../runs/a%20b%231/view.html");
}
