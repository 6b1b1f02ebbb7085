//! `sgc fit`: from a material to a variant that is checked.

use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::support::{said, sgc};

/// A grammar with one finger; `made` says how it is made.
fn write(folder: &Path, name: &str, segment: &str, made: &str) {
    let text = format!(
        "grammar {}
use std.blocks     {{ cube }}
use std.actuation  {{ bezier_pac }}
use std.objectives {{ travel, fall }}
use std.models     {{ hinge_model }}
use std.search     {{ nested_annealing }}
use std.materials  {{ ecoflex_30 }}
actuator finger {{
  param segments : Count in 2 .. 3 = 3
  segment        = {segment}
  density        = 1.1 g/cm^3
  friction       = 0.8
  bend           = -90 deg .. 90 deg
  bending_speed  = 95 deg/s
  relaxing_speed = 40 deg/s
  torque         = 0.2 N*m/rad
  stiffness      = 0.3 N*m/rad^2
  damping        = 0.01 N*m*s/rad^2
  {made}
}}
begin {{
  place core : cube
  place leg  : finger to core.right
}}
rule longer {{
  match  a : finger
  choose n in 2 .. 3
  set    a.segments = n
}}
actuate  finger with bezier_pac
simulate hinge_model for 1 s
search   nested_annealing
maximize travel - fall in cm
",
        name.trim_end_matches(".sgr")
    );
    std::fs::write(folder.join(name), text).unwrap();
}

#[test]
fn a_thread_bends_a_finger_of_a_material_and_the_variant_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(
        folder,
        "finger.sgr",
        "cylinder(9 mm, 2 cm)",
        "material = ecoflex_30  thread { offset = 6 mm  pull = 2 N }",
    );
    let output = sgc(folder, &["fit", "finger.sgr"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let text = std::fs::read_to_string(folder.join("finger_fitted.sgr")).unwrap();
    insta::assert_snapshot!("fitted_thread", text);
    insta::assert_snapshot!("fitted_thread_said", String::from_utf8_lossy(&output.stdout));
    let output = sgc(folder, &["check", "--format", "concise", "finger_fitted.sgr"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let output = sgc(folder, &["fmt", "--check", "finger_fitted.sgr"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    // A second time it says that the file is there.
    let output = sgc(folder, &["fit", "finger.sgr"]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert!(said(&output).contains("finger_fitted.sgr exists already"), "{}", said(&output));
    // What somebody writes there while it computes stays.
    let late = folder.join("late.sgr");
    let mut running = Command::new(env!("CARGO_BIN_EXE_sgc"))
        .args(["fit", "finger.sgr", "--out", "late.sgr"])
        .current_dir(folder)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(running.stderr.take().unwrap());
    let mut told = String::new();
    while !told.contains("computing a length of") {
        assert!(lines.read_line(&mut told).unwrap() > 0, "{told}");
    }
    std::fs::write(&late, "mine").unwrap();
    let mut rest = String::new();
    lines.read_to_string(&mut rest).unwrap();
    assert_eq!(running.wait().unwrap().code(), Some(2), "{rest}");
    assert_eq!(std::fs::read_to_string(&late).unwrap(), "mine");
    // What is fitted once more comes to the same.
    let output = sgc(folder, &["fit", "finger_fitted.sgr", "--out", "again.sgr", "--variant", "again"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let values =
        |text: &str| text.lines().filter(|l| l.contains("set ")).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(values(&std::fs::read_to_string(folder.join("again.sgr")).unwrap()), values(&text));
}

#[test]
fn what_cannot_be_fitted_says_why_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let chamber = "material = ecoflex_30  chamber { radius = 6 mm  offset = 2 mm  pressure = 2 bar }";
    for (name, segment, made, says) in [
        ("plain", "cylinder(9 mm, 2 cm)", "", "says what it is made of"),
        ("balloon", "cylinder(9 mm, 2 cm)", chamber, "it buckles or balloons at"),
        (
            "weak",
            "cylinder(9 mm, 2 cm)",
            "material = ecoflex_30  thread { offset = 6 mm  pull = 200 N }",
            "lower `pull`",
        ),
    ] {
        let file = format!("{name}.sgr");
        write(folder, &file, segment, made);
        let output = sgc(folder, &["fit", &file]);
        assert_eq!(output.status.code(), Some(1), "{name}: {}", said(&output));
        assert!(said(&output).contains(says), "{name}: {}", said(&output));
        assert!(!folder.join(format!("{name}_fitted.sgr")).exists());
    }
}

/// A bar that bends about y is the same bar as one that is turned by a quarter and bends about z.
#[test]
fn the_axis_of_the_hinges_says_which_side_is_the_height() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut values = Vec::new();
    for (name, segment, axis) in [("z", "box(2 cm, 16 mm, 4 mm)", "z"), ("y", "box(2 cm, 4 mm, 16 mm)", "y")]
    {
        let file = format!("about_{name}.sgr");
        write(folder, &file, segment, &format!("joint = bend about {axis}  material = ecoflex_30"));
        let output = sgc(folder, &["fit", &file]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        let text = std::fs::read_to_string(folder.join(format!("about_{name}_fitted.sgr"))).unwrap();
        let number = |field: &str| -> f64 {
            let line = text.split(&format!("set finger.{field}")).nth(1).unwrap().split(')').nth(1).unwrap();
            line.rsplit("segments * ").next().unwrap().split(' ').next().unwrap().parse().unwrap()
        };
        values.push([number("stiffness"), number("sideways"), number("torsion")]);
    }
    for (about_z, about_y) in values[0].iter().zip(&values[1]) {
        assert!((about_z / about_y - 1.0).abs() < 0.02, "{values:?}");
    }
    // The side of 16 mm against the side of 4 mm.
    assert!((values[0][1] / values[0][0] / 16.0 - 1.0).abs() < 0.1, "{values:?}");
}
