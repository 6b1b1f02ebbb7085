//! What `sgc check` offers besides finding: fixes, explanations, and a format for other programs.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use grammar_lang::diagnostics::{CODES, apply};
use grammar_lang::source::SourceMap;
use sgc::loader::Files;

use crate::support::{codesign, root};

fn sgc(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sgc"));
    command.args(arguments).current_dir(folder).env("NO_COLOR", "1").output().unwrap()
}

fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A folder with files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn read(folder: &tempfile::TempDir, name: &str) -> String {
    std::fs::read_to_string(folder.path().join(name)).unwrap()
}

#[test]
fn files_and_what_they_import_by_path_are_mended() {
    let folder = folder(&[
        ("main.sgr", "use \"./legs.sgr\" { leg_lenght }\nparam n : Count in 8 .. 2 = 4\nlet a = 3;\n"),
        ("legs.sgr", "lett width = 3 mm\nlet leg_length = 2 * widht\n"),
    ]);
    let output = sgc(folder.path(), &["check", "--fix", "main.sgr"]);
    assert_eq!(output.status.code(), Some(0), "{}{}", out(&output), errors(&output));
    assert_eq!(
        read(&folder, "main.sgr"),
        "use \"./legs.sgr\" { leg_length }\nparam n : Count in 2 .. 8 = 4\nlet a = 3\n"
    );
    // What only the imported file finds wrong with itself is found when it is checked itself.
    assert!(read(&folder, "legs.sgr").starts_with("let width"), "{}", read(&folder, "legs.sgr"));
    assert!(errors(&output).contains("mended main.sgr:2:20: write `2 .. 8`"), "{}", errors(&output));
    assert!(errors(&output).contains("mended legs.sgr:1:1: write `let` instead of `lett`"));
    let output = sgc(folder.path(), &["check", "--fix", "main.sgr", "./legs.sgr"]);
    assert_eq!(output.status.code(), Some(0), "{}{}", out(&output), errors(&output));
    assert!(read(&folder, "legs.sgr").ends_with("2 * width\n"));
    let output = sgc(folder.path(), &["check", "--fix", "main.sgr"]);
    assert!(errors(&output).contains("nothing was mended"), "{}", errors(&output));
}

/// In other languages `//` divides, too.
#[test]
fn what_may_be_a_division_becomes_no_comment() {
    let text = "let a = 9 // 2\nlet b = 9 // as wide as it is high\n";
    let folder = folder(&[("a.sgr", text)]);
    let output = sgc(folder.path(), &["check", "--fix", "a.sgr"]);
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    assert_eq!(read(&folder, "a.sgr"), text.replace("9 // as", "9 # as"));
    assert!(out(&output).contains("one `/` divides"), "{}", out(&output));
}

/// What a variant changes may make its base look wrong: the base is sound, and stays as it is.
#[test]
fn a_base_is_not_mended_to_suit_a_variant() {
    let base = codesign();
    let variant = "variant other of \"./codesign.sgr\" {\n  replace begin { place coer : cube }\n}\n";
    let folder = folder(&[("codesign.sgr", base.as_str()), ("other.sgr", variant)]);
    let output = sgc(folder.path(), &["check", "--fix", "other.sgr"]);
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    assert!(out(&output).contains("unknown name `core`"), "{}", out(&output));
    assert!(errors(&output).contains("nothing was mended"), "{}", errors(&output));
    assert_eq!(read(&folder, "codesign.sgr"), base);
    assert_eq!(read(&folder, "other.sgr"), variant);
}

#[test]
fn what_is_not_certain_is_left_and_told() {
    let text = "let width = 3 mm\nlet a = width + 4\nlet b = box(2, 2 cm, 2 cm)\nlet c = nothing_known\n";
    let folder = folder(&[("a.sgr", text)]);
    let output = sgc(folder.path(), &["check", "--fix", "--format", "concise", "a.sgr"]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(read(&folder, "a.sgr"), text, "a length without a unit could be anything");
    assert_eq!(out(&output).lines().count(), 3, "{}", out(&output));
    assert!(errors(&output).contains("3 errors"), "{}", errors(&output));
}

#[test]
fn a_fix_that_leads_to_more_errors_is_taken_back_and_the_others_are_kept() {
    // `cueb` is used under its wrong name all over: with the import mended, each use is unknown.
    let uses: String = ["a", "b", "c", "d"]
        .map(|name| format!("rule {name} {{ match p : cueb  set p.turn = 0 deg }}\n"))
        .concat();
    let text = format!("use std.blocks {{ cueb }}\nlet a_1 = 4 degrees\n{uses}");
    let folder = folder(&[("a.sgr", text.as_str())]);
    let output = sgc(folder.path(), &["check", "--fix", "a.sgr"]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(read(&folder, "a.sgr"), text.replace("4 degrees", "4 deg"), "{}", errors(&output));
    assert!(errors(&output).contains("not mended a.sgr:1:18"), "{}", errors(&output));
    assert!(errors(&output).contains("mended a.sgr:2:13"), "{}", errors(&output));
}

#[test]
fn standard_input_is_printed_mended() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_sgc"))
        .args(["check", "--fix", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all("let a\u{A0}= 4 degrees\nlet b = 3 brick\n".as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(out(&output), "let a = 4 deg\nlet b = 3 brick\n");
    assert!(errors(&output).contains("unknown unit `brick`"), "findings go elsewhere: {}", errors(&output));
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn the_standard_library_is_never_mended() {
    use grammar_lang::source::Loader;
    let before = Files.load("std.blocks", "x.sgr").unwrap();
    let folder = folder(&[("a.sgr", "use std.blocks { cuube }\n"), ("std.blocks", "lett a = 3\n")]);
    let output = sgc(folder.path(), &["check", "--fix", "a.sgr"]);
    assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
    assert_eq!(read(&folder, "a.sgr"), "use std.blocks { cube }\n");
    assert_eq!(read(&folder, "std.blocks"), "lett a = 3\n");
    assert_eq!(Files.load("std.blocks", "x.sgr").unwrap(), before);
}

#[cfg(unix)]
#[test]
fn a_mended_file_keeps_its_permissions_and_a_read_only_one_its_content() {
    use std::os::unix::fs::PermissionsExt;
    let text = "let a = 4 degrees\n";
    let folder = folder(&[("a.sgr", text), ("b.sgr", text)]);
    let mode = |name: &str| folder.path().join(name).metadata().unwrap().permissions().mode() & 0o777;
    let set = |name: &str, mode| {
        std::fs::set_permissions(folder.path().join(name), PermissionsExt::from_mode(mode)).unwrap();
    };
    set("a.sgr", 0o600);
    set("b.sgr", 0o444);
    assert_eq!(sgc(folder.path(), &["check", "--fix", "a.sgr"]).status.code(), Some(0));
    assert_eq!(mode("a.sgr"), 0o600);
    let output = sgc(folder.path(), &["check", "--fix", "b.sgr"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(errors(&output).contains("cannot mend") && errors(&output).contains("read-only"));
    assert_eq!(read(&folder, "b.sgr"), text);
}

#[test]
fn every_fix_of_the_cases_can_be_applied_and_does_no_harm() {
    let mut tried = 0;
    for entry in std::fs::read_dir(root().join("tests/cases")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            continue;
        }
        let check = |text: &str| {
            let mut sources = SourceMap::default();
            let entry = sources.add(path.to_string_lossy(), text);
            (grammar_lang::compile(&Files, &mut sources, entry, &[], None).diagnostics, entry)
        };
        let text = std::fs::read_to_string(&path).unwrap();
        let (found, entry) = check(&text);
        for fix in found.iter().filter_map(|d| d.fix.as_ref()) {
            if fix.edits.iter().any(|e| e.span.file != entry) {
                continue;
            }
            let mended = apply(&text, &fix.edits).unwrap_or_else(|| panic!("{}: {fix:?}", path.display()));
            let left = check(&mended).0;
            assert!(!left.iter().any(|d| found.len() == 1 && d.fix.as_ref() == Some(fix)), "{fix:?}");
            tried += 1;
        }
    }
    assert!(tried >= 25, "only {tried} fixes");
}

#[test]
fn explain_prints_a_page_by_code_or_name() {
    let here = root();
    for word in ["E0301", "e0301", "wrong-dimension", "Wrong-Dimension"] {
        let output = sgc(&here, &["explain", word]);
        assert_eq!(output.status.code(), Some(0));
        assert!(out(&output).starts_with("# E0301 wrong-dimension\n"), "{word}");
    }
    for (word, says) in [("wrong-dimensoin", "did you mean `wrong-dimension`?"), ("E9", "no finding `E9`")] {
        let output = sgc(&here, &["explain", word]);
        assert_eq!(output.status.code(), Some(2));
        assert!(errors(&output).contains(says), "{}", errors(&output));
    }
    assert_eq!(out(&sgc(&here, &["explain"])), out(&sgc(&here, &["explain", "--list"])));
    let list = out(&sgc(&here, &["explain", "--list"]));
    assert_eq!(list.lines().count(), CODES.len());
    for code in CODES {
        assert!(list.contains(code.id) && list.contains(code.name) && list.contains(code.title()));
    }
}

#[test]
fn a_check_ends_with_one_hint_at_the_pages() {
    let folder = folder(&[("a.sgr", "let a = 3 gg\n"), ("b.sgr", "let a = sin(3 mm)\nlet b = 3 gg\n")]);
    let full = out(&sgc(folder.path(), &["check", "a.sgr", "b.sgr"]));
    assert!(full.ends_with("for more about E0301, E0303: sgc explain E0301\n"), "{full}");
    assert_eq!(full.matches("sgc explain").count(), 1);
    let full = out(&sgc(folder.path(), &["check", "a.sgr"]));
    assert!(full.ends_with("for more: sgc explain E0303\n"), "{full}");
    for format in ["concise", "json", "sarif"] {
        assert!(!out(&sgc(folder.path(), &["check", "--format", format, "a.sgr"])).contains("for more"));
    }
}

#[test]
fn json_holds_the_edits_of_a_fix() {
    let folder = folder(&[("a.sgr", "# é\nlet a = 4 degrees\n")]);
    let text = out(&sgc(folder.path(), &["check", "--format", "json", "a.sgr"]));
    let finding: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(finding["name"], "unknown-unit");
    let edit = &finding["fix"]["edits"][0];
    assert_eq!((&edit["start"], &edit["end"], &edit["line"]), (&15.into(), &22.into(), &2.into()));
    assert_eq!(edit["replacement"], "deg");
}

#[test]
fn sarif_has_the_shape_that_its_readers_expect() {
    let text = "let a = 3 mm\nlet a = 4 degrees\nuse std.blocks { cuube }\n";
    let folder = folder(&[("a b.sgr", text), ("c.sgr", "use \"./a b.sgr\" { a }\n")]);
    let output = sgc(folder.path(), &["check", "--format", "sarif", "a b.sgr", "c.sgr"]);
    assert_eq!(output.status.code(), Some(1));
    let log: serde_json::Value = serde_json::from_str(&out(&output)).expect("one document");
    assert_eq!(log["version"], "2.1.0");
    assert!(log["$schema"].as_str().unwrap().contains("sarif-2.1.0"));
    let run = &log["runs"][0];
    let driver = &run["tool"]["driver"];
    assert_eq!(driver["name"], "sgc");
    let rules = driver["rules"].as_array().unwrap();
    assert_eq!(rules.len(), CODES.len());
    for (rule, code) in rules.iter().zip(CODES) {
        assert_eq!(rule["id"], code.id);
        for (member, text) in
            [("shortDescription", "text"), ("fullDescription", "text"), ("help", "markdown")]
        {
            assert!(!rule[member][text].as_str().unwrap().is_empty(), "{} {member}", code.id);
        }
        // A help with Markdown must have plain text, too.
        assert!(rule["help"]["text"].is_string());
        assert_eq!(rule["defaultConfiguration"]["level"], code.severity.name());
    }
    let results = run["results"].as_array().unwrap();
    assert!(results.len() >= 3, "{results:#?}");
    for result in results {
        let rule = result["ruleIndex"].as_u64().unwrap() as usize;
        assert_eq!(rules[rule]["id"], result["ruleId"]);
        assert!(["error", "warning"].contains(&result["level"].as_str().unwrap()));
        assert!(!result["message"]["text"].as_str().unwrap().is_empty());
        assert_eq!(result["locations"].as_array().unwrap().len(), 1);
        region_is_sound(&result["locations"][0]["physicalLocation"]);
        for location in result["relatedLocations"].as_array().into_iter().flatten() {
            region_is_sound(&location["physicalLocation"]);
            assert!(location["id"].is_u64() && location["message"]["text"].is_string());
        }
    }
    let twice = results.iter().find(|r| r["ruleId"] == "E0202").unwrap();
    assert_eq!(twice["relatedLocations"][0]["physicalLocation"]["region"]["startLine"], 1);
    let unit = results.iter().find(|r| r["ruleId"] == "E0303").unwrap();
    assert_eq!(unit["locations"][0]["physicalLocation"]["artifactLocation"]["uri"], "a%20b.sgr");
    let change = &unit["fixes"][0]["artifactChanges"][0];
    assert_eq!(change["artifactLocation"]["uri"], "a%20b.sgr");
    let replacement = &change["replacements"][0];
    assert_eq!(replacement["insertedContent"]["text"], "deg");
    assert_eq!(replacement["deletedRegion"]["startColumn"], 11);
    assert_eq!(replacement["deletedRegion"]["endColumn"], 18);
    // Without a finding it is still a whole document.
    let clean = out(&sgc(&root(), &["check", "--format", "sarif", "grammars/codesign.sgr"]));
    let log: serde_json::Value = serde_json::from_str(&clean).unwrap();
    assert_eq!(log["runs"][0]["results"].as_array().map(Vec::len), Some(0));
}

fn region_is_sound(place: &serde_json::Value) {
    assert!(place["artifactLocation"]["uri"].is_string());
    let number = |name: &str| place["region"][name].as_u64().unwrap();
    assert!(number("startLine") >= 1 && number("startColumn") >= 1);
    let (start, end) =
        ((number("startLine"), number("startColumn")), (number("endLine"), number("endColumn")));
    assert!(start <= end);
}

#[test]
fn an_import_that_is_there_but_cannot_be_read_says_so() {
    let folder = folder(&[("a.sgr", "use \"./legs.sgr\" { leg }\nuse \"./no.sgr\" { arm }\n")]);
    std::fs::create_dir(folder.path().join("legs.sgr")).unwrap();
    let text = out(&sgc(folder.path(), &["check", "a.sgr"]));
    assert!(text.contains("cannot read the file `./legs.sgr`") && text.contains("a folder"), "{text}");
    assert!(text.contains("there is no such file"), "{text}");
    assert!(!text.contains("there is no module"), "{text}");
}

/// Where it is not certain what was meant, or the line could still not be read, nothing is written.
#[test]
fn nothing_is_guessed() {
    let rule = "rule grow {\n  match p : part\n  attach cube to p.top\n}\n";
    for text in [
        // An arrow or a comparison?
        "let a = 3 => 2\n".to_owned(),
        // A length or a logarithm?
        "let a = len(3)\n".to_owned(),
        rule.replace("attach cube to p.top", "repeat cube"),
        // Two braces are missing, or one of an inner block: where they belong is the author's to say.
        "target valves on pneumatic for bender {\n  shortest = 40 ms\n  supply = {\n    pressure = 1 bar\n".to_owned(),
        "target valves on pneumatic for bender {\n  supply = {\n    pressure = 1 bar\n  shortest = 40 ms\n}\n"
            .to_owned(),
        rule.replace("\n}", "").replace("  attach", "attach"),
        // Minutes, milliseconds? Centimetres, or centimetres per second?
        "let a : Time = 40\n".to_owned(),
        "let a : Length = 40 cms\n".to_owned(),
        // The brace too many may be one that was not opened.
        rule.replace("{\n  match", "\n  match") + "}\n",
        // Mended by its first slip, the line could still not be read.
        "lett a = = = 3\n".to_owned(),
    ] {
        let folder = folder(&[("a.sgr", &text)]);
        let output = sgc(folder.path(), &["check", "--fix", "a.sgr"]);
        assert_eq!(read(&folder, "a.sgr"), text, "{}{}", out(&output), errors(&output));
        assert_eq!(output.status.code(), Some(1), "{text}");
    }
}

#[test]
fn a_block_without_its_end_is_closed_where_its_lines_end() {
    let text = "rule grow {\n  match p : part\n  attach cube to p.top\n\nlet a = 4\n";
    let folder = folder(&[("a.sgr", text)]);
    sgc(folder.path(), &["check", "--fix", "a.sgr"]);
    assert_eq!(read(&folder, "a.sgr"), text.replace("top\n", "top\n}\n"));
}

#[test]
fn what_would_be_mended_is_shown_as_a_difference() {
    let text = "let a = 3\nlet b = 4 degrees\nlet c = nothing_known\n";
    let folder = folder(&[("a.sgr", text), ("b.sgr", "let a = 3\n")]);
    let output = sgc(folder.path(), &["check", "--diff", "a.sgr", "b.sgr"]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(
        out(&output),
        "--- a.sgr\n+++ a.sgr\n@@ -1,3 +1,3 @@\n let a = 3\n-let b = 4 degrees\n+let b = 4 deg\n let c = nothing_known\n"
    );
    assert!(errors(&output).contains("unknown unit `degrees`"), "{}", errors(&output));
    assert_eq!(read(&folder, "a.sgr"), text, "nothing is written");
    let output = sgc(folder.path(), &["check", "--diff", "b.sgr"]);
    assert_eq!((output.status.code(), out(&output).as_str()), (Some(0), ""));
    assert!(errors(&output).contains("nothing would be mended"));
    assert_eq!(sgc(folder.path(), &["check", "--diff", "--fix", "b.sgr"]).status.code(), Some(2));
}

#[test]
fn searches_and_variants_of_an_earlier_version_are_mended_to_what_they_meant() {
    let case = |name: &str| std::fs::read_to_string(root().join("tests/cases").join(name)).unwrap();
    let base = case("bases/worm.sgr").replace("search   plain_annealing", "search   kinds");
    let folder = folder(&[
        ("kinds.sgr", &case("search-of-earlier-version.sgr")),
        (
            "worm.sgr",
            &base.replace("use std.search     { plain_annealing }", "use \"./kinds.sgr\" { kinds }"),
        ),
        (
            "odd.sgr",
            "variant odd of \"./worm.sgr\" {\n  set kinds.outer.archive.size.cells = 5\n  \
             set kinds.inner.cma_es.spread = 20 %\n}\n",
        ),
    ]);
    let output = sgc(folder.path(), &["check", "--fix", "kinds.sgr", "worm.sgr", "odd.sgr"]);
    assert_eq!(output.status.code(), Some(0), "{}{}", out(&output), errors(&output));
    let output = sgc(folder.path(), &["compile", "odd.sgr", "--emit", "resolved"]);
    let resolved = out(&output);
    let search = resolved.split("search kinds {").nth(1).unwrap_or_else(|| panic!("{resolved}"));
    for said in ["bodies archive {", "cells = 5 }", "curves cma_es {", "spread = 0.2"] {
        assert!(search.contains(said), "{said}: {search}");
    }
}

/// What its author could have meant otherwise is told, and stays as it is.
#[test]
fn what_could_be_meant_otherwise_is_left() {
    for text in [
        // Thousands, or a decimal comma.
        "part brick { shape = sphere(8 mm)  density = 1,000 kg/m^3  friction = 0.8 }",
        "param limit : Mass in 1 g .. 1,500 g = 1 g",
        "let angles = [0 deg, 22,5 deg]",
        // Radians, or degrees.
        "let angles = [-1 rad, 45]",
        "param turn : Angle in -45 .. 1 rad = 0 deg",
        "let angles = [0 deg, 90 deg, 3.14]",
        "let angle = if 1 < 2 then 1 rad else 60",
        // Milliseconds, or seconds.
        "param pause : Time in 500 .. 6 s = 6 s",
        "param reach : Length in 5 cm .. 0.4 = 20 cm",
        // A factor, or a percentage.
        "param share : Number in 9 .. 110 % = 3",
        "scenarios heavy { mass = 9 .. 110 %  drawn = 3 }",
        // A name that is told apart from another on purpose.
        "let max_gain = 1.5\nlet range = max_gain - min_gain",
        "let increase = 1.5\nlet k = increase - decrease",
        "let inflation = 1.5\nlet k = inflation * deflation",
        "let balanced = 1.5\nlet k = balanced - unbalanced",
        "let symmetric = 1.5\nlet k = symmetric * asymmetric",
        "let gainA = 1.5\nlet k = gainA - gainB",
        "let foot_left = 1 cm\nlet k = foot_left - foot_lift",
        "let leg = 1 cm\nlet k = legs",
        // A range, or a minus.
        "rule turn { match p : part  choose a in { 0 deg – 90 deg }  set p.turn = a }",
        "rule turn { match p : part  choose n in 3–5  set p.turn = n * 1 deg }",
        // A product, or a decimal point.
        "let weight = 2·5 g",
    ] {
        let folder = folder(&[("a.sgr", text)]);
        let output = sgc(folder.path(), &["check", "--fix", "a.sgr"]);
        assert_eq!(output.status.code(), Some(1), "{text}: {}{}", out(&output), errors(&output));
        assert_eq!(read(&folder, "a.sgr"), text, "{}", errors(&output));
    }
}

/// Many mistakes in a text cost as much time and memory as they are many: each fix does not keep the text once more, and those
/// that do harm are not tried one by one for ever.
#[test]
fn many_fixes_are_made_in_a_while() {
    let rules = "rule a {\n".repeat(3000);
    let names: String = (0..1500).map(|n| format!("let abcdefgh{n:05} = abcdefhg{n:05}\n")).collect();
    for text in [rules, names] {
        let folder = folder(&[("a.sgr", text.as_str())]);
        let begun = std::time::Instant::now();
        let output = sgc(folder.path(), &["check", "--diff", "a.sgr"]);
        assert!(output.status.code().is_some(), "{}", errors(&output));
        // Not a measurement: without the bounds it takes many times as long.
        assert!(begun.elapsed().as_secs() < 120, "{:?}", begun.elapsed());
    }
}

/// What is redirected to be read may not be written: nobody has named it.
#[cfg(unix)]
#[test]
fn what_is_only_redirected_is_not_written() {
    let text = "let a   =  3;\n";
    let folder = folder(&[("a.sgr", text), ("b.sgr", "let a   =  3\n")]);
    for (file, arguments) in [
        ("b.sgr", &["fmt", "/dev/stdin"][..]),
        ("b.sgr", &["fmt", "/proc/self/fd/0"]),
        ("a.sgr", &["check", "--fix", "/dev/stdin"]),
    ] {
        let before = read(&folder, file);
        let input = std::fs::File::open(folder.path().join(file)).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_sgc"));
        let output = command.args(arguments).stdin(input).env("NO_COLOR", "1").output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", errors(&output));
        assert!(errors(&output).contains("write `-`"), "{arguments:?}: {}", errors(&output));
        assert_eq!(read(&folder, file), before, "{arguments:?}");
    }
}

/// What people write who know another language is told in words of this one.
#[test]
fn habits_of_other_languages_are_told() {
    let codesign = codesign();
    for (here, habit, help) in [
        ("count(part) <= max_parts ", "count(part) % 2 == 0 ", "there is no remainder operator"),
        ("count(part) <= max_parts ", "count(part) ** 2 <= 9 ", "there is no power operator"),
        ("count(part) <= max_parts ", "connected && no_overlap ", "write `and`"),
        ("count(part) <= max_parts ", "!connected ", "write `not`"),
        ("count(part) <= max_parts ", "connected == True ", "write `true`"),
        ("count(part) <= max_parts ", "len(part) <= 9 ", "write `count(part)`"),
        ("count(part) <= max_parts ", "sum(part) <= 9 ", "sum over p in part"),
        ("count(part) <= max_parts ", "(connected ? true : false) ", "if CONDITION then"),
        ("count(part) <= max_parts ", "count(part) <= .5 ", "write `0.5`"),
        ("count(part) <= max_parts ", "count(part) <= +5 ", "a number has no `+`"),
        ("count(part) <= max_parts ", "count(part) <= 10_000 ", "without `_`"),
        ("choose  n    in 3 .. 6", "choose  n    in range(3, 6)", "write `3 .. 6`"),
        ("where p is not core", "where p != null", "there is no empty value"),
        ("90 deg, 180 deg, 270 deg }\n  set", "90 deg, 180 deg, 270 rpm }\n  set", "`6 deg/s`"),
        ("rule undo {", "def undo {", "write `let name"),
        ("symmetry mirror xy", "import std.blocks", "write `use std.blocks"),
        ("set     p.turn = p.turn + angle", "p.turn += angle", "set p.turn"),
        ("set     p.turn", "repeat 3\n  set     p.turn", "there are no loops"),
        ("max_parts         because", "max_parts         becuase", "did you mean `because`?"),
        ("with free port q", "with fre port q", "did you mean `free`?"),
        ("where p is not core", "where p is not core // all", "a comment begins with `#`"),
    ] {
        let text = codesign.replacen(here, habit, 1);
        assert_ne!(text, codesign, "{here}");
        let folder = folder(&[("x.sgr", &text)]);
        let told = out(&sgc(folder.path(), &["check", "--format", "concise", "x.sgr"]));
        assert!(told.contains(help), "`{habit}` should say `{help}`: {told}");
    }
}
