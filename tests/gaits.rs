//! Gait classes of made-up motions: each body moves as the class says, once made of cubes that turn with it and
//! once of balls that do not.

use std::sync::Arc;

use grammar_lang::ir::RuleSet;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use sgc::derive::{Candidate, Derivation};
use sgc::design::assembly::Shape;
use sgc::drive::Drive;
use sgc::score::{Observed, Recording, observe};
use sgc::simulate::Motion;
use sgc::simulate::motion::Placement;

use crate::support::compile_texts;
use crate::support::texts;

const DURATION: f64 = 20.0;
const FRAMES: usize = 601;
/// Half the size of an element, m.
const HALF: f64 = 0.01;

pub(crate) fn rules(edit: &str) -> RuleSet {
    let mut texts = texts();
    let text = "use std.gaits { airborne, alternation, bounce, gait, roll, still_below, progress, extent }
        variant seen of \"./morphology.sgr\" {
          drop observe slid, sliding add observe gait, airborne, bounce, roll, alternation, progress, extent EDIT }";
    texts.insert("grammars/seen.sgr".to_owned(), text.replace("EDIT", edit));
    compile_texts(&texts, "grammars/seen.sgr").unwrap()
}

/// A way to move: where an element is that stood at a place, and how it is turned, after some time.
type Way = fn(Vector3<f64>, f64) -> (Vector3<f64>, UnitQuaternion<f64>);

/// What is observed of a plate of elements that moves in a way.
fn seen(rules: &RuleSet, way: Way, (along, across): (usize, usize), is_ball: bool) -> Vec<Observed> {
    let place = |i: usize| {
        let at = |n: usize, of: usize| 2.0 * HALF * (n as f64 - (of - 1) as f64 / 2.0);
        Vector3::new(at(i / across, along), HALF, at(i % across, across))
    };
    let elements = along * across;
    let shape =
        if is_ball { Shape::Ball { radius: HALF } } else { Shape::Box { half: Vector3::repeat(HALF) } };
    let poses = (0..FRAMES * elements).map(|i| {
        let (frame, element) = (i / elements, i % elements);
        let (at, turned) = way(place(element), frame as f64 * DURATION / (FRAMES - 1) as f64);
        let turned = if is_ball { UnitQuaternion::identity() } else { turned };
        Isometry3::from_parts(Translation3::from(at), turned)
    });
    let placement = |body| Placement::new(body, Isometry3::identity(), shape);
    let motion = Motion {
        interval: DURATION / (FRAMES - 1) as f64,
        duration: DURATION,
        bodies: elements,
        poses: poses.collect(),
        bends: Vec::new(),
        work: Vec::new(),
        commands: None,
        placements: (0..elements).map(placement).collect(),
    };
    class_of(rules, &motion)
}

/// What is observed of a motion, of whatever body it is: the class first.
pub(crate) fn class_of(rules: &RuleSet, motion: &Motion) -> Vec<Observed> {
    let derivation = Arc::new(Derivation::start(rules, None).unwrap());
    let candidate = Candidate::new(rules, derivation);
    let drive = Drive::new(&candidate, rules.first_task().unwrap()).unwrap();
    observe(Recording::nominal(&drive, &[], motion)).into_iter().map(Option::unwrap).collect()
}

fn class(seen: &[Observed]) -> &str {
    match &seen[0] {
        Observed::Word(word) => word,
        other => panic!("{other:?}"),
    }
}

fn number(seen: &Observed) -> f64 {
    match seen {
        Observed::Number(x) => *x,
        other => panic!("{other:?}"),
    }
}

fn sine(t: f64) -> f64 {
    libm::sin(std::f64::consts::TAU * t)
}

fn rest(place: Vector3<f64>, _: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
    (place, UnitQuaternion::identity())
}

fn slide(place: Vector3<f64>, t: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
    (place + Vector3::new(0.03 * t, 0.0, 0.0), UnitQuaternion::identity())
}

/// Leaves the ground for a third of each period of 1.3 s.
fn hop(place: Vector3<f64>, t: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let up = 0.04 * (sine(t / 1.3) - 0.5).max(0.0);
    (place + Vector3::new(0.03 * t, up, 0.0), UnitQuaternion::identity())
}

/// Turns about a horizontal axis to the side, and comes as far as its edge rolls.
fn roll(place: Vector3<f64>, t: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let angle = -0.8 * t;
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
    let high = 0.05;
    let at = turned * (place - Vector3::new(0.0, HALF, 0.0)) + Vector3::new(0.8 * 0.05 * t, high, 0.0);
    (at, turned)
}

/// The front and the rear half carry it in turns, with a period of 1.7 s.
fn walk(place: Vector3<f64>, t: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let up = (0.01 * sine(t / 1.7) * place.x.signum()).max(0.0);
    (place + Vector3::new(0.03 * t, up, 0.0), UnitQuaternion::identity())
}

/// Rocks to and fro by 30 degrees about its middle and slides: what rocks does not roll.
fn rock(place: Vector3<f64>, t: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.5 * sine(t / 2.3));
    (turned * place + Vector3::new(0.03 * t, 0.0, 0.0), turned)
}

/// One half winds round the other, which slides.
fn wind(place: Vector3<f64>, t: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
    if place.x < 0.0 {
        return slide(place, t);
    }
    let arm = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -0.8 * t);
    let hub = Vector3::new(0.03 * t, 0.05, 0.0);
    (hub + arm * Vector3::new(place.x, 0.0, place.z), arm)
}

#[test]
fn each_motion_is_of_its_class() {
    let rules = rules("");
    let ways: [(&str, Way); 5] =
        [("still", rest), ("crawler", slide), ("hopper", hop), ("roller", roll), ("walker", walk)];
    for (name, way) in ways {
        for is_ball in [false, true] {
            for plate in [(4, 2), (2, 4), (6, 1)] {
                let seen = seen(&rules, way, plate, is_ball);
                assert_eq!(class(&seen), name, "{plate:?}, balls {is_ball}: {seen:?}");
            }
        }
    }
}

#[test]
fn features_are_what_they_say() {
    let rules = rules("");
    let hopper = seen(&rules, hop, (4, 2), true);
    // A sine is above a half for a third of the time; touching is 2 mm high.
    assert!((number(&hopper[1]) - 0.3).abs() < 0.06, "{hopper:?}");
    // 2 cm up in each period of 1.3 s.
    assert!((number(&hopper[2]) - 0.02 / 1.3).abs() < 0.004, "{hopper:?}");
    let roller = seen(&rules, roll, (4, 2), true);
    // 0.8 rad/s in the last 15 of 20 s.
    assert!((11.9..12.1).contains(&number(&roller[3])), "{roller:?}");
    let rocking = seen(&rules, rock, (4, 2), true);
    assert!(number(&rocking[3]) < 1.01 && class(&rocking) != "roller", "{rocking:?}");
    let winding = seen(&rules, wind, (6, 1), true);
    assert!(number(&winding[3]) < 1.0 && class(&winding) != "roller", "{winding:?}");
    let crawler = seen(&rules, slide, (4, 2), true);
    assert_eq!((number(&crawler[1]), number(&crawler[4])), (0.0, 0.0));
}

#[test]
fn thresholds_are_the_users() {
    let rules = rules("set still_below = 2000 %");
    assert_eq!(class(&seen(&rules, slide, (4, 2), false)), "still");
}

#[test]
fn a_body_of_many_elements_has_a_class() {
    assert_eq!(class(&seen(&rules(""), walk, (40, 20), true)), "walker");
}
