//! From texts to findings and messages.

use std::fmt::Write;

use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;
use proptest::prelude::*;

use super::variant::Named;
use super::*;
use crate::loader::Files;

/// The file that a document of these tests names.
const CSV: &str = "more.csv";

fn rules(grammar: &str) -> RuleSet {
    let path = format!("{}/grammars/{grammar}.sgr", env!("CARGO_MANIFEST_DIR"));
    let mut sources = SourceMap::default();
    let entry = sources.add(path.clone(), std::fs::read_to_string(path).unwrap());
    grammar_lang::compile(&Files, &mut sources, entry, &[], None).ruleset.unwrap()
}

/// What comes of a document, and of a CSV file that it may name.
fn fitted_from(name: &str, text: &str, csv: &str) -> Result<Vec<Finding>, Vec<Problem>> {
    let load = |file: &str| {
        if file == CSV {
            Ok((file.to_owned(), csv.to_owned()))
        } else {
            Err(std::io::Error::other("there is no such file"))
        }
    };
    fit(&read(name, text, &load), &rules("tendon"))
}

fn fitted(text: &str) -> Vec<Finding> {
    fitted_from("bench.toml", text, "").unwrap_or_else(|problems| panic!("{problems:#?}"))
}

/// What is wrong with a document, a line for each problem with the exit code that it asks for.
fn wrong(name: &str, text: &str, csv: &str) -> String {
    match fitted_from(name, text, csv) {
        Ok(findings) => format!("nothing is wrong: {}", summary(&findings)),
        Err(problems) => {
            problems.iter().map(|p| format!("{} {p}\n", if p.is_contradiction { 1 } else { 2 })).collect()
        }
    }
}

fn change(text: &str) -> String {
    let findings = fitted(text);
    findings.iter().map(|f| format!("{} = {}\n", f.quantity, f.change.shown())).collect()
}

const THREAD: &str = "[t]\nkind = \"thread\"\nfor = \"bender\"\n";
const WHOLE: &str = r#"
[thread]
for = "bender"
"angle [deg]" = [-90, -45, 0, 45, 90, 90, -90]
"thread [mm]" = [-21.0, -10.8, 0, 11.2, 21.8, 22.2, -21.4]

[tip]
kind = "tip"
for = "bender"
"force [N]" = [0.95, 0.99, 0.93]
"arm [mm]" = 60

[weighed]
kind = "mass"
part = ["cube", "cube", "bender"]
"mass [g]" = [8.3, 8.4, 12.5]
segments = [1, 1, 4]

[mat]
kind = "friction"
part = ["cube", "cube", "ball"]
"tilt [deg]" = [32, 33, 28]

[built]
kind = "prototype"
name = ["ours_1", "ours_2"]
build = "tendon"
"simulated [m/h]" = [40, 100]
"measured [m/h]" = [12, 25]
"length [mm]" = [100, 240]
"#;

/// What the variants of the tests are called.
const NAMED: Named<'static> = Named { variant: "tendon_bench", worlds: "measured" };

#[test]
fn a_whole_bench_is_written_as_a_variant() {
    let findings = fitted(WHOLE);
    let text = variant::text(NAMED, "./tendon.sgr", "bench.toml", &findings);
    insta::assert_snapshot!(format!("{text}\n{}", summary(&findings)));
}

#[test]
fn a_written_variant_is_laid_out() {
    let text = variant::text(NAMED, "./tendon.sgr", "bench.toml", &fitted(WHOLE));
    let mut sources = SourceMap::default();
    let file = sources.add("tendon_bench.sgr", text.clone());
    assert_eq!(grammar_lang::format::format(&sources, file).as_deref(), Ok(text.as_str()));
}

#[test]
fn a_page_draws_every_measurement_and_loads_nothing() {
    let page = page::page("tendon_bench", "./tendon.sgr", "<bench>.toml", &fitted(WHOLE));
    assert_eq!(
        page.matches("<svg").count(),
        9,
        "thread, tip, cube and mat with residuals, and the prototypes"
    );
    assert!(page.contains("&lt;bench&gt;.toml") && !page.contains("<bench>"));
    for part in page.split("<svg").skip(1) {
        let picture = format!("<svg{}</svg>", part.split_once("</svg>").unwrap().0);
        assert!(roxmltree::Document::parse(&picture).is_ok(), "{picture}");
        assert!(!picture.contains("NaN") && !picture.contains("inf"), "{picture}");
    }
    assert!(!page.contains("src=") && !page.contains("<script") && !page.contains("url("));
}

#[test]
fn bad_measurements_are_told_all_at_once_with_their_places() {
    let mut told = String::new();
    let mut tell = |what: &str, name: &str, text: &str, csv: &str| {
        let _ = writeln!(told, "# {what}\n{}", wrong(name, text, csv));
    };
    bad_columns(&mut tell);
    bad_points(&mut tell);
    bad_subjects(&mut tell);
    insta::assert_snapshot!(told);
}

/// Takes what is wrong, the name of a file, its text, and that of the table beside it.
type Tell<'a> = &'a mut dyn FnMut(&str, &str, &str, &str);

/// Sections and columns that cannot be read.
fn bad_columns(tell: Tell<'_>) {
    let toml = "bench.toml";
    tell("nothing", toml, "", "");
    tell("no TOML", toml, "[a\n", "");
    tell("a section twice", toml, "[a]\nkind = \"tip\"\n[a]\n", "");
    tell("a list of sections", toml, "[[a]]\nkind = \"tip\"\n", "");
    tell("no section", toml, "kind = \"tip\"\n", "");
    tell("no such kind", toml, "[a]\nkind = \"tipp\"\n[b]\nkind = \"colour\"\n", "");
    tell("no kind", toml, "[a]\n\"length [mm]\" = [1]\n", "");
    tell("no file", toml, "[a]\nkind = \"tip\"\nfile = \"nowhere.csv\"\n", "");
    tell("missing columns", toml, "[a]\nkind = \"tip\"\n\"force [N]\" = [1]\n[b]\nkind = \"thread\"\n", "");
    tell(
        "units",
        toml,
        &format!(
            "{THREAD}\"angle [mm]\" = [1, 2]\n\"thread [milimeter]\" = [1, 2]\n[b]\nkind = \"tip\"\nforce = [1]\n\"arm [mms]\" = 1\n[c]\nkind=\"mass\"\nfor=\"bender\"\n\"mass [kN]\"=1\n\"segments [mm]\"=4\n[d]\nkind=\"prototype\"\nname=\"a\"\nbuild=\"tendon\"\n\"simulated [km]\"=1\n\"measured [m/h]\"=1\n"
        ),
        "",
    );
    tell(
        "a misspelt column",
        toml,
        "[a]\nkind = \"tip\"\n\"forces [N]\" = [1]\n\"arm [mm]\" = 1\ncolour = 3\n",
        "",
    );
    tell(
        "no numbers",
        toml,
        "[a]\nkind = \"tip\"\n\"force [N]\" = [1, \"x\", nan, inf, \"\"]\n\"arm [mm]\" = [true]\n",
        "",
    );
    tell(
        "no finite numbers",
        toml,
        "[a]\nkind = \"tip\"\n\"force [N]\" = [1,\n \"x\",\n nan, inf, \"\"]\n\"arm [mm]\" = 1\n",
        "",
    );
    tell(
        "columns of other lengths",
        toml,
        "[a]\nkind = \"tip\"\n\"force [N]\" = [1, 2]\n\"arm [mm]\" = [1, 2, 3]\n",
        "",
    );
}

/// Points that make no curve.
fn bad_points(tell: Tell<'_>) {
    let toml = "bench.toml";
    tell("no points", toml, &format!("{THREAD}\"angle [deg]\" = []\n\"thread [mm]\" = []\n"), "");
    tell(
        "one point",
        toml,
        &format!(
            "{THREAD}\"angle [deg]\" = [1, 1]\n\"thread [mm]\" = [1, 1]\n[b]\nkind = \"tip\"\nfor = \"bender\"\n\"force [N]\" = 1\n\"arm [mm]\" = 1\n[c]\nkind=\"inflate\"\nfor=\"bender\"\n\"time [s]\"=[0]\n\"angle [deg]\"=[0]"
        ),
        "",
    );
    tell(
        "contradictory points",
        toml,
        &format!("{THREAD}\"angle [deg]\" = [0, 45, 90, 45]\n\"thread [mm]\" = [0,\n 10,\n 20,\n 14]\n"),
        "",
    );
    tell(
        "a thread that turns back",
        toml,
        &format!("{THREAD}\"angle [deg]\" = [0, 30, 60, 90]\n\"thread [mm]\" = [0,\n 14,\n 9,\n 20]\n"),
        "",
    );
    tell(
        "a bad tolerance",
        toml,
        &format!("{THREAD}tolerance = \"2 deg\"\n\"angle [deg]\" = [0, 90]\n\"thread [mm]\" = [0, 20]\n"),
        "",
    );
}

/// Measurements of what is not there, or cannot have been measured.
fn bad_subjects(tell: Tell<'_>) {
    let toml = "bench.toml";
    tell(
        "unknown declarations",
        toml,
        "[a]\nkind = \"tip\"\nfor = \"bendre\"\n\"force [N]\" = [1, 2]\n\"arm [mm]\" = 1\n[b]\nkind = \"mass\"\npart = [\"cub\", \"wheel\"]\n\"mass [g]\" = 1\n[c]\nfor = \"bender\"\ntarget = \"thread\"\n\"angle [deg]\" = [0, 90]\n\"thread [mm]\" = [0, 20]\n",
        "",
    );
    tell("no part", toml, "[b]\nkind = \"mass\"\n\"mass [g]\" = 1\n", "");
    tell("a segment or all", toml, "[b]\nkind = \"mass\"\nfor = \"bender\"\n\"mass [g]\" = 12\n", "");
    tell(
        "half a segment",
        toml,
        "[b]\nkind = \"mass\"\nfor = \"bender\"\n\"mass [g]\" = 12\nsegments = 2.5\n",
        "",
    );
    tell(
        "measured twice",
        toml,
        "[b]\nkind = \"mass\"\nfor = \"cube\"\n\"mass [g]\" = 12\n[c]\nkind = \"mass\"\nfor = \"cube\"\n\"mass [g]\" = 13\n",
        "",
    );
    tell(
        "forces that pull",
        toml,
        "[b]\nkind = \"tip\"\nfor = \"bender\"\n\"force [N]\" = [1,\n-1]\n\"arm [mm]\" = 1\n",
        "",
    );
    tell(
        "friction by two measurements at once",
        toml,
        "[b]\nkind = \"friction\"\nfor = \"cube\"\n\"pull [N]\" = [0.05]\n\"mass [g]\" = [8.3]\n\"tilt [deg]\" = [20]\n",
        "",
    );
    tell(
        "friction of nothing",
        toml,
        "[b]\nkind = \"friction\"\nfor = \"cube\"\n\"pull [N]\" = 1\n[c]\nkind = \"friction\"\nfor = \"cube\"\n\"tilt [deg]\" = [30, 95]\n",
        "",
    );
    tell(
        "the wrong way",
        toml,
        "[a]\nkind = \"inflate\"\nfor = \"bender\"\n\"time [s]\" = [0, 1, 2, 3, 4, 5]\n\"angle [deg]\" = [90, 80, 60, 40, 20, 0]\n",
        "",
    );
    tell(
        "back and forth",
        toml,
        "[a]\nkind = \"inflate\"\nfor = \"bender\"\n\"time [s]\" = [0, 1, 2, 3, 4, 5, 6, 7, 8]\n\"angle [deg]\" = [0, 80, 0, 80, 0, 80, 0, 80, 80]\n",
        "",
    );
    tell(
        "pictures years apart",
        toml,
        "[a]\nkind = \"inflate\"\nfor = \"bender\"\n\"time [s]\" = [0, 1e8, 2e8, 3e8, 4e8, 5e8]\n\"angle [deg]\" = [0, 20, 40, 60, 80, 90]\n",
        "",
    );
    tell(
        "odd prototypes",
        toml,
        "[a]\nkind = \"prototype\"\nname = [\"ours\", \"ours\", \"2nd\", \"E\"]\nbuild = [\"tendon\", \"tendons\", \"legs\", \"tendon\"]\n\"simulated [m/h]\" = [10, 0, 1, 1]\n\"measured [m/h]\" = 1\n",
        "",
    );
    tell(
        "a CSV file with bad rows",
        toml,
        "[a]\nkind = \"thread\"\nfile = \"more.csv\"\n",
        "angle [deg], thread [mm]\n0, 0\n\n# 45 was forgotten\n90\n90, x\n90, 1, 2\n",
    );
    tell("a CSV file that lacks a column", "bench.csv", "angle [deg], thred [mm]\n0, 0\n", "");
    tell("an empty CSV file", "bench.csv", "", "");
    tell("a CSV file of masses without parts", "weighed.csv", "mass [g]\n8\n", "");
}

#[test]
fn a_lone_csv_file_is_known_by_its_columns() {
    let kind = |csv: &str| {
        let Reading { sections, problems } =
            read("any.csv", csv, &|_| Err(std::io::Error::other("there is no such file")));
        assert_eq!(problems, []);
        assert_eq!((sections.len(), sections[0].name.as_str()), (1, "any"));
        sections[0].kind
    };
    assert_eq!(kind("angle [deg], thread [mm]\n0, 0\n"), Kind::Thread);
    assert_eq!(kind("time [s], angle [deg]\n0, 0\n1, 90\n"), Kind::Inflate);
    assert_eq!(kind("time [s], angle [deg]\n0, -90\n1, 0\n"), Kind::Deflate);
    assert_eq!(kind("\u{feff}Force [N]; arm [mm]\r\n0,5; 60\r\n;\r\n"), Kind::Tip);
    assert_eq!(kind("part,mass [g],note\ncube,8.3,dry\n"), Kind::Mass);
    assert_eq!(kind("tilt [deg]\n30\n"), Kind::Friction);
    assert_eq!(kind("name,build,simulated [m/h],measured [m/h]\na,tendon,10,3\n"), Kind::Prototype);
}

#[test]
fn the_unit_and_the_order_of_rows_do_not_matter() {
    let one = change(&format!(
        "{THREAD}\"angle [deg]\" = [-90, 0, 90, 90]\n\"thread [mm]\" = [-21, 0, 22, 22.2]\n"
    ));
    let other = change(&format!(
        "{THREAD}\"thread [cm]\" = [2.22, 0, 2.2, -2.1]\n\"angle [deg]\" = [90, 0, 90, -90]\n"
    ));
    assert_eq!(one, other);
    assert_eq!(one, "threads.thread = -21.0 .. 22.1 mm (3 rows)\n");
    let tip = |force: &str, arm: &str| change(&format!("[t]\nfor = \"bender\"\n{force}\n{arm}\n"));
    assert_eq!(
        tip("\"force [N]\" = [0.95, 0.99]", "\"arm [mm]\" = 60"),
        tip("\"force [mN]\" = [990, 950]", "\"arm [cm]\" = [6, 6]")
    );
}

#[test]
fn a_table_does_not_take_the_name_of_another() {
    let mut findings = fitted(WHOLE);
    rename(&mut findings, &|name| ["bender_thread", "threads"].contains(&name));
    let text = variant::text(NAMED, "./tendon.sgr", "bench.toml", &findings);
    assert!(text.contains("table bender_thread_measured :"), "{text}");
    assert!(text.contains("set threads.thread = bender_thread_measured"), "{text}");
}

#[test]
fn friction_makes_the_geometric_mean_right() {
    let findings = fitted(
        "[mat]\nkind = \"friction\"\npart = [\"cube\", \"cube\", \"ball\"]\n\"pull [N]\" = [0.05, 0.05, 0.03]\n\"mass [g]\" = [8.3, 8.3, 4.6]\n",
    );
    let numbers: Vec<(String, f64)> = findings
        .iter()
        .map(|f| match &f.change {
            Change::Number { path, value } => (path.clone(), value.value),
            other => panic!("{other:?}"),
        })
        .collect();
    let [(ground_path, ground), (ball_path, ball)] = numbers.as_slice() else { panic!("{numbers:?}") };
    assert_eq!((ground_path.as_str(), ball_path.as_str()), ("hinge_model.ground_friction", "ball.friction"));
    let cube = *rules("tendon").parts["cube"].friction.fixed().unwrap();
    assert!(((cube * ground).sqrt() - 0.05 / (0.0083 * 9.81)).abs() < 1e-9, "the cube slips when it did");
    assert!(((ball * ground).sqrt() - 0.03 / (0.0046 * 9.81)).abs() < 1e-9, "and so does the ball");
}

#[test]
fn a_torque_that_depends_on_the_angle_is_told() {
    let tip = |forces: &str| {
        fitted(&format!(
            "[t]\nfor = \"bender\"\n\"angle [deg]\" = [0, 30, 60, 90]\n\"force [N]\" = {forces}\n\"arm [mm]\" = 60\n"
        ))
    };
    let falls = tip("[1.0, 0.9, 0.8, 0.7]");
    assert!(falls[0].warnings.iter().any(|n| n.contains("falls by 35 %")), "{:?}", falls[0].warnings);
    assert_eq!(tip("[1.0, 0.98, 1.02, 0.99]")[0].notes.len(), 1);
}

#[test]
fn a_thread_that_turns_back_within_its_scatter_is_smoothed() {
    let findings = fitted(&format!(
        "{THREAD}\"angle [deg]\" = [-90, -45, 0, 2, 45, 90]\n\"thread [mm]\" = [-20, -10, 0.1, -0.1, 10, 20]\n"
    ));
    assert!(findings[0].notes.iter().any(|n| n.contains("smoothed")), "{:?}", findings[0].notes);
    let Change::Table { table, .. } = &findings[0].change else { panic!() };
    assert!(table.rows.windows(2).all(|w| w[0].0.value < w[1].0.value && w[0].1.value < w[1].1.value));
}

#[test]
fn a_slack_thread_is_as_it_was_measured() {
    let table = |angles: &str, lengths: &str| {
        let findings = fitted(&format!("{THREAD}\"angle [deg]\" = {angles}\n\"thread [mm]\" = {lengths}\n"));
        let Change::Table { table, .. } = &findings[0].change else { panic!() };
        let rows: Vec<(f64, f64)> = table.rows.iter().map(|(a, l)| (a.value, l.value)).collect();
        assert!(rows.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 < w[1].1), "{rows:?}");
        (rows, findings[0].warnings.clone(), findings[0].notes.clone())
    };
    let (rows, warnings, notes) = table("[-90, -45, 0, 45, 90]", "[-21, 0, 0, 0, 21]");
    for (angle, length) in [(-90.0, -21.0), (-45.0, 0.0), (0.0, 0.0), (45.0, 0.0), (90.0, 21.0)] {
        assert!((lines::at(&rows, angle) - length).abs() < 0.1, "{angle}: {rows:?}");
    }
    assert!(warnings.iter().any(|w| w.contains("slack")), "{warnings:?}");
    assert!(notes.iter().all(|n| !n.contains("ruler's zero")), "{notes:?}");

    let (rows, ..) = table(
        "[-90,-90,-60,-60,-30,-30,-30,0,0,0,30,30,30,60,60,90,90]",
        "[-15,-15.4,-7.5,-7.2,0.1,-0.2,0,0,0.1,-0.2,-0.1,0.1,-0.2,7.4,7.6,15,15.2]",
    );
    for angle in [-30.0, 0.0, 30.0] {
        assert!(lines::at(&rows, angle).abs() < 0.3, "{angle}: {rows:?}");
    }
    // At a stop the table goes as far as was measured.
    let (rows, ..) = table("[-90, -45, 0, 45, 70, 90]", "[-21, -10, 0, 10, 10, 10]");
    assert_eq!(rows.last().unwrap().0, 90.0, "{rows:?}");
}

#[test]
fn angles_in_another_unit_are_told() {
    let told = fitted(&format!("{THREAD}\"angle [rad]\" = [-90, 0, 90]\n\"thread [mm]\" = [-21, 0, 21]\n"));
    assert!(told[0].warnings.iter().any(|w| w.contains("are the units right?")), "{:?}", told[0].warnings);
}

#[test]
fn a_film_without_the_motion_has_no_speed() {
    let film = |bends: &[(f64, f64)]| {
        let mut csv = "time [s], angle [deg]\n".to_owned();
        bends.iter().for_each(|(t, b)| writeln!(csv, "{t}, {b}").unwrap());
        let toml = "[i]\nkind = \"inflate\"\nfor = \"bender\"\nfile = \"more.csv\"\n";
        fitted_from("bench.toml", toml, &csv)
    };
    // A picture every six seconds, and none of the motion.
    let jump: Vec<(f64, f64)> =
        (0..20).map(|i| (6.0 * f64::from(i), if i < 8 { 0.1 } else { 90.0 })).collect();
    let problems = film(&jump).unwrap_err();
    assert!(
        problems.iter().any(|p| p.to_string().contains("no picture of the motion itself")),
        "{problems:?}"
    );
    // Three pictures of it: a speed, but nobody knows how well.
    let frames = (0..90).filter(|i| !(24..48).contains(i));
    let gap: Vec<(f64, f64)> =
        frames.map(|i| (0.033 * f64::from(i), (f64::from(i - 20) * 3.0).clamp(0.0, 90.0))).collect();
    let found = film(&gap).map(|found| found[0].clone());
    if let Ok(found) = found {
        assert_eq!(found.interval, None, "{found:?}");
        assert!(found.warnings.iter().any(|w| w.contains("too few")), "{:?}", found.warnings);
    }
}

#[test]
fn intervals_hold_their_value_and_end_at_zero() {
    let friction = fitted("[a]\nkind = \"friction\"\nfor = \"cube\"\n\"tilt [deg]\" = [18, 36]\n");
    for finding in &friction {
        let Change::Number { value, .. } = &finding.change else { panic!("{finding:?}") };
        let (low, high) = finding.interval.as_ref().unwrap();
        assert!(0.0 <= low.value && low.value <= value.value && value.value <= high.value, "{finding:?}");
        assert!(
            finding.warnings.iter().any(|w| w.contains("too wide to be useful")),
            "{:?}",
            finding.warnings
        );
    }
    // What is known worst is not left out of the worlds.
    let block = worlds::block("lab", &friction).unwrap();
    assert!(block.contains("friction = 0 % .. "), "{block}");
}

/// A world's factor is one of the number that is written, which has few digits: together they reach the ends of the interval.
#[test]
fn worlds_reach_the_interval_from_the_number_that_is_written() {
    let found = fitted("[a]\nkind = \"mass\"\nfor = \"cube\"\n\"mass [g]\" = [8, 9]\n");
    let interval = found[0].interval.clone().unwrap();
    assert_eq!(found[0].change.shown(), "8 g", "of 8.5 g");
    assert_eq!((interval.0.to_string(), interval.1.to_string()), ("5.4 g".into(), "11.6 g".into()));
    let block = worlds::block("lab", &found).unwrap();
    assert!(block.contains("mass = 67 % .. 145 %"), "5.4 and 11.6 of 8: {block}");
}

#[test]
fn what_has_no_segments_is_not_weighed_by_them() {
    let text = "[a]\nkind = \"mass\"\nfor = \"cube\"\n\"mass [g]\" = [8, 16]\nsegments = [1, 2]\n";
    let problems = fitted_from("bench.toml", text, "").unwrap_err();
    assert!(
        problems[0].to_string().contains("`cube` is not an actuator, so it cannot have 2 segments"),
        "{problems:?}"
    );
}

/// A logger may count seconds from 1970, and another one from its start.
#[test]
fn a_film_may_begin_at_any_time() {
    let film = |begin: f64| {
        let mut csv = "time [s], angle [deg]\n".to_owned();
        for i in 0..60 {
            let t = f64::from(i) * 0.03125;
            let bend = 90.0 * (1.0 - libm::exp(-2.0 * (t - 0.25).max(0.0)));
            let _ = writeln!(csv, "{}, {bend:.1}", begin + t);
        }
        let text = "[i]\nkind = \"inflate\"\nfor = \"bender\"\nfile = \"more.csv\"\n";
        fitted_from("bench.toml", text, &csv).unwrap().remove(0).change.shown()
    };
    let zero = film(0.0);
    assert!(zero.contains("rows"), "{zero}");
    assert_eq!([1e4, 1.764e9].map(film), [zero.clone(), zero]);
}

#[test]
fn a_thread_that_gets_shorter_is_told() {
    let told = fitted(&format!("{THREAD}\"angle [deg]\" = [-90, 0, 90]\n\"thread [mm]\" = [21, 0, -21]\n"));
    assert!(told[0].warnings.iter().any(|w| w.contains("gets shorter")), "{:?}", told[0].warnings);
}

#[test]
fn a_film_to_the_other_side_has_negative_bends() {
    let film = |sign: f64| {
        let mut csv = "time [ms], angle [deg]\n".to_owned();
        for i in 0..60 {
            let bend = (f64::from(i - 10) * 2.0).clamp(0.0, 80.0);
            let _ = writeln!(csv, "{}, {}", i * 20, sign * bend);
        }
        let findings = fitted_from(
            "bench.toml",
            "[i]\nkind = \"inflate\"\nfor = \"bender\"\nfile = \"more.csv\"\n",
            &csv,
        );
        findings.unwrap().remove(0)
    };
    let [one, other] = [film(1.0), film(-1.0)];
    assert_eq!(one.change.shown(), "100.0 deg/s");
    assert_eq!(one.change, other.change);
    assert_eq!(other.plots[0].points.last().unwrap().1, -80.0);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// A thread that is read off a ruler is found again as far as the ruler can tell.
    #[test]
    fn a_true_thread_is_found_again(
        at_90 in 5.0f64..60.0, curved in -0.3f64..0.3, falls in any::<bool>(), wobble in proptest::collection::vec(-0.3f64..0.3, 37)
    ) {
        let sign = if falls { -1.0 } else { 1.0 };
        let truth = |a: f64| sign * at_90 * (a / 90.0) * (1.0 + curved * (a / 90.0));
        let mut csv = "angle [deg],thread [mm]\n".to_owned();
        for (i, wobble) in wobble.iter().enumerate() {
            let angle = i as f64 * 5.0 - 90.0;
            let _ = writeln!(csv, "{angle},{}", truth(angle) + wobble);
        }
        let findings = fitted_from("bench.toml", "[t]\nkind = \"thread\"\nfor = \"bender\"\nfile = \"more.csv\"\n", &csv);
        prop_assert!(findings.is_ok(), "{:?}", findings);
        let findings = findings.unwrap();
        let Change::Table { table, path } = &findings[0].change else { panic!() };
        prop_assert_eq!(path.as_deref(), Some("threads.thread"));
        prop_assert!(table.rows.len() <= 16);
        let rows: Vec<(f64, f64)> = table.rows.iter().map(|(a, l)| (a.value, l.value)).collect();
        prop_assert!(rows.windows(2).all(|w| w[0].0 < w[1].0 && (w[1].1 - w[0].1) * sign > 0.0), "{:?}", rows);
        for angle in -80..=80 {
            let angle = f64::from(angle);
            let far = (lines::at(&rows, angle) - truth(angle)).abs();
            prop_assert!(far < 1.2, "{far} mm at {angle} deg: {:?}", rows);
        }
    }

    /// Whatever a file holds, reading and fitting it does no harm.
    #[test]
    fn arbitrary_files_do_no_harm(csv in "(time|angle|thread|force|arm|mass|run|part| |\\[deg\\]|\\[mm\\]|\\[s\\]|,|;|\n|[0-9]{1,3}|-|\\.|\"){0,60}") {
        let _ = wrong("bench.csv", &csv, "");
        let _ = wrong("bench.toml", &csv, "");
    }

    /// Nor do numbers that nobody measured.
    #[test]
    fn arbitrary_numbers_do_no_harm(
        kind in 0usize..4,
        rows in proptest::collection::vec((-1e3f64..1e3, -1e3f64..1e3), 1..20),
        scale in prop::sample::select(vec![1.0, 1e-12, 1e12, 0.0])
    ) {
        let header = ["angle [deg],thread [mm]", "time [s],angle [deg]", "force [N],arm [mm]", "mass [g],segments"][kind];
        let mut csv = format!("{header}\n");
        for (a, b) in rows {
            let _ = writeln!(csv, "{},{}", a * scale, b * scale);
        }
        let kind = ["thread", "inflate", "tip", "mass"][kind];
        let text = format!("[t]\nkind = \"{kind}\"\nfor = \"bender\"\nfile = \"more.csv\"\n");
        if let Ok(findings) = fitted_from("bench.toml", &text, &csv) {
            let _ = page::page("a", "b", "c", &findings);
            let _ = variant::text(Named { variant: "a", worlds: "measured" }, "./b.sgr", "c", &findings);
        }
    }
}

fn warnings(text: &str) -> Vec<String> {
    fitted(text).into_iter().flat_map(|finding| finding.warnings).collect()
}

#[test]
fn what_is_to_be_looked_at_first_is_told() {
    let tip = "[tip]\nkind = \"tip\"\nfor = \"bender\"\n\"arm [mm]\" = 60\n\"force [N]\" = ";
    let friction = "[mat]\nkind = \"friction\"\nfor = \"cube\"\n\"tilt [deg]\" = ";
    let mass = "[weighed]\nkind = \"mass\"\nfor = \"cube\"\n";
    let cases: [(String, &[&str]); 8] = [
        (format!("{tip}[0.95, 0.99, 0.93]"), &[]),
        // Three of nine were hooked elsewhere.
        (
            format!("{tip}[0.95, 0.96, 0.94, 0.95, 0.955, 0.945, 1.4, 1.41, 1.39]"),
            &[
                "point 7 (0.084 N*m/rad), point 8 (0.0846 N*m/rad), point 9 (0.0834 N*m/rad) are far from the others",
            ],
        ),
        (
            format!("{friction}[31, 32, 80]"),
            &["measurement 3 (a coefficient of 5.67) is far from the others"],
        ),
        // Grams in a column of kilograms, newtons for millinewtons.
        (
            format!("{mass}\"mass [kg]\" = [8.3, 8.4, 8.3]"),
            &["`cube.mass` is 1000 times the value in the grammar (8.3 g): are the units right?"],
        ),
        (format!("{tip}[0.0095, 0.0099, 0.0093]"), &["times less than the value in the grammar"]),
        (
            format!("{THREAD}\"angle [deg]\" = [-60, 0, 90]\n\"thread [mm]\" = [-15, 0, 21]"),
            &[
                "the measurements go from -60 deg to 90 deg, but the actuator bends from -90 deg to 90 deg in the grammar",
            ],
        ),
        (format!("{THREAD}\"angle [deg]\" = [-90, 0, 90]\n\"thread [mm]\" = [-21, 0, 21]"), &[]),
        (
            format!("{THREAD}\"angle [deg]\" = [-90, 0, 90]\n\"thread [m]\" = [-21, 0, 21]"),
            &["`threads.thread` is 1000 times"],
        ),
    ];
    for (text, told) in cases {
        let found = warnings(&text);
        assert_eq!(found.len(), told.len(), "{text}: {found:?}");
        for (found, told) in found.iter().zip(told) {
            assert!(found.contains(told), "{text}: {found}");
        }
    }
}

/// A film whose times are milliseconds that say they are seconds, and one that stops half way.
#[test]
fn films_that_cannot_be_are_told() {
    let film = |unit: &str, factor: f64, most: f64| {
        let bend = |i: u32| (f64::from(i) * 5.0 - 10.0).clamp(0.0, most);
        let list =
            |of: &dyn Fn(u32) -> f64| (0..30).map(|i| format!("{:.4}", of(i))).collect::<Vec<_>>().join(", ");
        format!(
            "[film]\nkind = \"inflate\"\nfor = \"bender\"\n\"time [{unit}]\" = [{}]\n\"angle [deg]\" = [{}]\n",
            list(&|i| f64::from(i) * 0.02 * factor),
            list(&bend)
        )
    };
    assert_eq!(warnings(&film("s", 1.0, 90.0)), Vec::<String>::new());
    let slip = warnings(&film("ms", 1.0, 90.0));
    assert!(slip.iter().any(|told| told.contains("are the units right?")), "{slip:?}");
    let far = warnings(&film("s", 1.0, 200.0));
    assert!(far.iter().any(|told| told.contains("goes up to a bend of 135 deg")), "{far:?}");
    let short = warnings(&film("s", 1.0, 40.0));
    assert!(short.iter().any(|told| told.contains("the film ends at a bend of 40 deg")), "{short:?}");
}

/// A film that begins bent, and one that crosses the straight position, leave out or mix what a speed is of.
#[test]
fn films_that_do_not_begin_at_rest_are_told() {
    let film = |kind: &str, from: f64, to: f64| {
        let list = |of: &dyn Fn(f64) -> f64| {
            (0..30).map(|i| format!("{:.4}", of(f64::from(i)))).collect::<Vec<_>>().join(", ")
        };
        format!(
            "[film]\nkind = \"{kind}\"\nfor = \"bender\"\n\"time [s]\" = [{}]\n\"angle [deg]\" = [{}]\n",
            list(&|i| i * 0.04),
            list(&|i| from + (to - from) * (i / 29.0))
        )
    };
    let tells = |text: &str, part: &str| warnings(text).iter().any(|told| told.contains(part));
    assert!(tells(&film("inflate", 30.0, 90.0), "the film shows no bend below 30 deg"));
    assert!(tells(&film("inflate", -40.0, 90.0), "crosses the straight position"));
    for part in ["shows no bend", "crosses"] {
        assert!(!tells(&film("inflate", 2.0, 90.0), part), "{part}");
    }
    let refused = |kind: &str, from: f64, to: f64| wrong("bench.toml", &film(kind, from, to), "");
    assert!(refused("deflate", 60.0, -60.0).contains("as far to one side as to the other"));
    assert!(refused("inflate", 10.0, 10.4).contains("changes by less than 1 deg"));
}

/// One wrong picture at an end of a film moves the whole table: it is told. A motion that begins or ends fast is not.
#[test]
fn a_wrong_picture_at_an_end_of_a_film_is_told() {
    let film = |wrong: Option<(usize, f64)>| {
        let bend = |i: usize| (90.0 * (1.0 - libm::exp(-0.12 * (i as f64 - 6.0)))).max(0.0);
        let angles = (0..50).map(|i| match wrong {
            Some((place, by)) if place == i => format!("{:.2}", bend(i) + by),
            _ => format!("{:.2}", bend(i)),
        });
        let times = (0..50).map(|i| format!("{:.2}", f64::from(i) * 0.04));
        format!(
            "[film]\nkind = \"inflate\"\nfor = \"bender\"\n\"time [s]\" = [{}]\n\"angle [deg]\" = [{}]\n",
            times.collect::<Vec<_>>().join(", "),
            angles.collect::<Vec<_>>().join(", ")
        )
    };
    let told = |wrong| warnings(&film(wrong)).iter().any(|told| told.contains("at an end of the film"));
    assert!(!told(None));
    for wrong in [(0, -25.0), (0, 30.0), (49, -30.0), (49, 40.0)] {
        assert!(told(Some(wrong)), "{wrong:?}");
    }
    // In the middle it is an outlier among others, which hardly counts.
    assert!(!told(Some((25, 30.0))));
}

#[test]
fn a_prototype_that_repeats_another_counts_once() {
    let built = |names: &str, simulated: &str, measured: &str| {
        format!(
            "[built]\nkind = \"prototype\"\nbuild = \"tendon\"\nname = [{names}]\n\"simulated [m/h]\" = [{simulated}]\n\
             \"measured [m/h]\" = [{measured}]\n"
        )
    };
    let notes = |text: &str| fitted(text).into_iter().flat_map(|f| f.notes).collect::<Vec<_>>().join(" ");
    let once = notes(&built("\"a\", \"b\"", "40, 100", "12, 25"));
    let twice = notes(&built("\"a\", \"b\", \"c\"", "40, 100, 40", "12, 25, 12"));
    assert!(twice.starts_with(&once) && twice.ends_with("has the same numbers: c."), "{twice}");
}
