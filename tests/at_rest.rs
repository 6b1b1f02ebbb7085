//! Where parts and ports are as a motion begins: joints are then where their springs rest, and driven rows where they start.

use sgc::derive::{check_start, run_example};

use crate::joints::compiled;

const BODY: &str = "
use std.actuation  { bezier_pac }
use std.objectives { travel, fall }
use std.models     { hinge_model }
use std.search     { gait_annealing }

part bed {
  shape    = box(10 cm, 2 cm, 6 cm)
  mass     = 100 g
  friction = 0.5
  port front at vector(5 cm, 0 cm, 0 cm) facing vector(1, 0, 0)
  port left  at vector(0 cm, 0 cm, -3 cm) facing vector(0, 0, -1)
  port right at vector(0 cm, 0 cm, 3 cm)  facing vector(0, 0, 1)
}

part strut {
  shape     = box(1 cm, 1 cm, 1 cm)
  mass      = 5 g
  friction  = 0.5
  joint     = slide along y passive
  range     = -30 mm .. 30 mm
  neutral   = -7 mm
  stiffness = 100 N/m
  damping   = 1 N*s/m
  port back  at vector(-5 mm, 0 mm, 0 mm) facing vector(-1, 0, 0)
  port front at vector(5 mm, 0 mm, 0 mm)  facing vector(1, 0, 0)
}

part flap {
  shape     = box(4 cm, 5 mm, 2 cm)
  mass      = 5 g
  friction  = 0.5
  joint     = bend about z passive
  bend      = -90 deg .. 90 deg
  neutral   = 30 deg
  stiffness = 0.01 N*m/rad^2
  damping   = 0.001 N*m*s/rad^2
  port back  at vector(-2 cm, 0 mm, 0 mm) facing vector(-1, 0, 0)
  port front at vector(2 cm, 0 mm, 0 mm)  facing vector(1, 0, 0)
}

actuator finger {
  param segments : Count in 2 .. 6 = 4
  segment        = cylinder(8 mm, 15 mm)
  bend           = -90 deg .. 90 deg
  neutral        = 60 deg
  bending_speed  = 90 deg/s
  relaxing_speed = 90 deg/s
  density        = 1 g/cm^3
  friction       = 0.6
  torque         = 0.1 N*m/rad
  stiffness      = 0.5 N*m/rad^2
  damping        = 0.01 N*m*s/rad^2
}

symmetry mirror xy

begin {
  place core : bed
  place s    : strut to core.front
  place fin  : flap to s.front
  place arm  : finger to core.left
  place tip  : flap to arm.tip
}

actuate  finger with bezier_pac
simulate hinge_model for 2 s
search   gait_annealing
maximize travel - fall in cm
";

#[test]
fn places_and_directions_at_rest_follow_the_joints() {
    // The fin is bent by 30 deg at its back, which is the front of the strut; a finger by 60 deg in all.
    let held = [
        "s.place.y == 0 mm and s.place_at_rest.y == -7 mm and s.facing_at_rest == s.facing",
        "abs(fin.facing_at_rest.x - cos(30 deg)) < 1e-8 and abs(fin.facing_at_rest.y - sin(30 deg)) < 1e-8",
        "abs(fin.upward_at_rest.y - cos(30 deg)) < 1e-8 and fin.sideways_at_rest == fin.sideways",
        "abs(fin.place_at_rest.x - 6 cm - 2 cm * cos(30 deg)) < 1e-6 mm",
        "abs(fin.place_at_rest.y + 7 mm - 2 cm * sin(30 deg)) < 1e-6 mm",
        "fin.centre_at_rest == fin.place_at_rest",
        "abs(fin.front.place_at_rest.y + 7 mm - 4 cm * sin(30 deg)) < 1e-6 mm",
        "fin.front.facing_at_rest == fin.facing_at_rest",
        // The base stays, the tip goes up, and what hangs there with it.
        "arm.place_at_rest == arm.place and arm.facing_at_rest == arm.facing",
        "arm.base.place_at_rest == arm.base.place and arm.base.facing_at_rest.z == 1",
        "abs(arm.tip.facing_at_rest.y - sin(60 deg)) < 1e-8 and abs(arm.tip.facing_at_rest.z + cos(60 deg)) < 1e-8",
        "arm.tip.place_at_rest.y > 2 cm and arm.tip.place.y == 0 mm",
        "tip.back.place_at_rest == arm.tip.place_at_rest",
        "abs(tip.facing_at_rest.y - 1) < 1e-8 and abs(tip.facing_at_rest.z) < 1e-6",
        "arm.centre_at_rest.y > 5 mm and arm.centre.y == 0 mm",
        // The image is the mirror image.
        "arm.twin.tip.place_at_rest.z == -arm.tip.place_at_rest.z",
        "tip.twin.place_at_rest.y == tip.place_at_rest.y and tip.twin.facing_at_rest.y == tip.facing_at_rest.y",
    ];
    for held in held {
        let text = format!("grammar feature\n{BODY}\nexample one {{ expect {held} }}");
        let rules = compiled(&text);
        assert!(check_start(&rules).is_none(), "{:?}", check_start(&rules));
        let failed = run_example(&rules, "one", &rules.examples["one"]).err();
        assert!(failed.is_none(), "{held}: {failed:?}");
    }
}
