//! The page as a whole, of a synthetic walker.

use std::f64::consts::TAU;
use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::{Check, Curve, Element, Look, Made, Making, Measure, Piece, Scene, page};
use crate::design::assembly::Shape;
use crate::simulate::Motion;
use crate::simulate::motion::Placement;

const PIECES: usize = 4;
const PIECE: f64 = 0.02;
const CUBE: Vector3<f64> = Vector3::new(0.015, 0.015, 0.015);

/// Elements at their bodies and places in them.
fn placed(elements: &[Element], places: Vec<(usize, Isometry3<f64>)>) -> Arc<[Placement]> {
    let placement = |(element, (body, local)): (&Element, _)| Placement::new(body, local, element.look.shape);
    elements.iter().zip(places).map(placement).collect()
}

/// The bend of one of the two legs at a time, rad.
fn bend(leg: usize, t: f64) -> f64 {
    0.75 + 0.6 * libm::sin(TAU * t / 3.5 + 1.4 * leg as f64)
}

/// The bodies of the walker about its core: the core, then the pieces of both legs.
fn bodies(t: f64, pitch: f64) -> Vec<Isometry3<f64>> {
    let turn = |angle: f64| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
    let core = Isometry3::from_parts(Translation3::identity(), turn(pitch));
    let mut bodies = vec![core];
    for leg in 0..2 {
        let away = if leg == 0 { 1.0 } else { -1.0 };
        let half = |length: f64| Translation3::new(away * length / 2.0, 0.0, 0.0);
        let mut end = core * half(2.0 * CUBE.x);
        for _ in 0..PIECES {
            end = end * turn(-away * bend(leg, t) / PIECES as f64) * half(PIECE);
            bodies.push(end);
            end *= half(PIECE);
        }
    }
    bodies
}

/// The lowest height of a foot: the cube at the end of a leg.
fn lowest(bodies: &[Isometry3<f64>], leg: usize) -> f64 {
    let foot = bodies[PIECES * (leg + 1)] * foot(leg);
    let rise = |axis: Vector3<f64>| (foot.rotation * axis).y.abs();
    foot.translation.y - CUBE.x * (rise(Vector3::x()) + rise(Vector3::y()) + rise(Vector3::z()))
}

/// A foot in the frame of its leg's last piece.
fn foot(leg: usize) -> Isometry3<f64> {
    let away = if leg == 0 { 1.0 } else { -1.0 };
    Isometry3::translation(away * (PIECE / 2.0 + CUBE.x), 0.0, 0.0)
}

/// The walker standing on both feet.
fn stand(t: f64) -> Vec<Isometry3<f64>> {
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..50 {
        let middle = (low + high) / 2.0;
        let bodies = bodies(t, middle);
        if lowest(&bodies, 0) > lowest(&bodies, 1) { high = middle } else { low = middle }
    }
    let bodies = bodies(t, low);
    let height = lowest(&bodies, 0).min(lowest(&bodies, 1));
    let way = 0.02 * t + 0.012 * libm::sin(TAU * t / 3.5);
    let heading = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.05 * t);
    let place = Isometry3::from_parts(Translation3::new(way, -height, -0.0005 * t * t), heading);
    bodies.into_iter().map(|body| place * body).collect()
}

/// How the walker might have been made: its core, a leg, which is then turned, and the other leg.
fn grown(elements: &[Element]) -> Making {
    let made = |rule: &str, choices: &[(&str, &str)], done: &str| Made {
        rule: rule.to_owned(),
        about: "What the comment above the rule says".to_owned(),
        choices: choices.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect(),
        done: done.to_owned(),
    };
    let steps = vec![
        made("begin", &[], "places core"),
        made("grow", &[("side", "east"), ("length", "8 cm")], "adds actuator 1 and cube 2"),
        made("turn", &[("p", "actuator 1"), ("angle", "90 deg")], "turns actuator 1; carries along cube 2"),
        made("mirror", &[("p", "actuator 1")], "adds actuator 3 and cube 4"),
    ];
    let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), TAU / 4.0);
    let piece = |(index, element): (usize, &Element)| {
        let leg = (index.max(1) - 1) / (PIECES + 1);
        let away = if leg == 0 { 1.0 } else { -1.0 };
        let along = CUBE.x + PIECE * (((index.max(1) - 1) % (PIECES + 1)) as f64 + 0.5);
        let at = Isometry3::translation(if index == 0 { 0.0 } else { away * along }, 0.0, 0.0);
        let from = [0, 1, 3][if index == 0 { 0 } else { leg + 1 }];
        let mut poses = vec![(from, at)];
        if from == 1 {
            poses.push((2, Isometry3::from_parts(at.translation, turn)));
        }
        let names = vec![(from, element.look.label.clone())];
        Piece { look: element.look.clone(), from, until: None, poses, names }
    };
    Making { steps, pieces: elements.iter().enumerate().map(piece).collect() }
}

/// A core with two legs that bend up and down and a cube at the end of each:
/// 20 s at 50 frames a second.
pub(super) fn walker() -> Scene {
    let (interval, frames) = (0.02, 1001);
    let times = (0..frames).map(|frame| frame as f64 * interval);
    let element = |shape, colour: &str, actuator, label: &str| Element {
        look: Look { shape, colour: colour.to_owned(), label: label.to_owned() },
        actuator,
    };
    let cube = || element(Shape::Box { half: CUBE }, "#4d7ea8", None, "cube");
    let mut elements = vec![element(Shape::Box { half: CUBE }, "#e0a83c", None, "core")];
    let mut places = vec![(0, Isometry3::identity())];
    for leg in 0..2 {
        for piece in 0..PIECES {
            let shape = Shape::Cylinder { radius: 0.011, half_length: PIECE / 2.0 };
            let colour = ["#c65d4b", "#5b9a68"][leg];
            elements.push(element(shape, colour, Some(leg), "actuator"));
            places.push((1 + PIECES * leg + piece, Isometry3::identity()));
        }
        elements.push(cube());
        places.push((PIECES * (leg + 1), foot(leg)));
    }
    let motion = Motion {
        interval,
        duration: 20.0,
        bodies: 1 + 2 * PIECES,
        poses: times.clone().flat_map(stand).collect(),
        bends: times.flat_map(|t| [bend(0, t - 0.12), bend(1, t - 0.12)]).collect(),
        work: Vec::new(),
        commands: None,
        placements: placed(&elements, places),
    };
    let elements_of_making = elements.clone();
    let curve = |leg: usize| Curve {
        measure: Measure::Angle,
        name: ["front leg", "hind leg"][leg].to_owned(),
        interval: 0.05,
        targets: (0..=400).map(|i| bend(leg, 0.05 * f64::from(i))).collect(),
    };
    let pair = |name: &str, text: &str| (name.to_owned(), text.to_owned());
    Scene {
        title: "inchworm".to_owned(),
        subtitle: vec!["example walker, seed 7".to_owned(), "articulated, 20 s at 1/480 s".to_owned()],
        value: "38.2 cm".to_owned(),
        terms: vec![
            pair("travel", "40.3 cm"),
            pair("fall", "2.1 cm"),
            pair("noncyclic", "0.8 rad"),
            pair("nonlasting", "0.0"),
        ],
        elements,
        motion,
        curves: (0..2).map(curve).collect(),
        making: grown(&elements_of_making),
        checks: vec![
            Check {
                name: "half the time step".to_owned(),
                text: "38.0 cm (−0.5 %)".to_owned(),
                agrees: Some(true),
            },
            Check { name: "rapier".to_owned(), text: "29.4 cm (−23 %)".to_owned(), agrees: Some(false) },
        ],
        worlds: None,
        elsewhere: None,
    }
}

/// A design as large as the thesis's: 50 bodies, 8 actuators, 30 s, with the
/// shaking that contacts give.
fn large() -> Scene {
    let mut scene = walker();
    let (bodies, frames) = (50, 601);
    let wave = |i: usize, rate: f64, t: f64| libm::sin(rate * (1.0 + 0.01 * i as f64) * t + i as f64);
    let pose = |frame: usize, body: usize| {
        let t = frame as f64 / 20.0;
        let at = |axis: usize| 0.04 * wave(body + axis, 2.0, t) + 0.0004 * wave(body, 60.0 + axis as f64, t);
        let turn = UnitQuaternion::from_euler_angles(at(0) * 9.0, at(1) * 9.0, at(2) * 9.0);
        let column = (body as f64 - 25.0) * 0.03 + 0.03 * t + at(0);
        Isometry3::from_parts(Translation3::new(column, 0.05 + at(1), at(2)), turn)
    };
    scene.motion.poses = (0..frames)
        .flat_map(|frame| (0..bodies).map(move |body| (frame, body)))
        .map(|(f, b)| pose(f, b))
        .collect();
    (scene.motion.bodies, scene.motion.interval, scene.motion.duration) = (bodies, 0.05, 30.0);
    scene.motion.bends = (0..frames * 8).map(|i| wave(i % 8, 1.5, (i / 8) as f64 / 20.0)).collect();
    scene.elements = (0..bodies)
        .map(|body| Element {
            look: Look {
                shape: if body % 5 == 0 { Shape::Box { half: CUBE } } else { Shape::Ball { radius: 0.012 } },
                colour: "#7d8fb3".to_owned(),
                label: "part".to_owned(),
            },
            actuator: (body % 5 != 0).then_some(body % 8),
        })
        .collect();
    let places = (0..bodies).map(|body| (body, Isometry3::identity())).collect();
    scene.motion.placements = placed(&scene.elements, places);
    let targets = scene.curves[0].targets.clone();
    scene.curves = (1..=8)
        .map(|i| Curve {
            name: format!("actuator {i}"),
            measure: Measure::Angle,
            interval: 0.05,
            targets: targets.clone(),
        })
        .collect();
    scene
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    assert_eq!(page(&walker()), page(&walker()));
}

#[test]
fn a_large_scene_stays_about_a_megabyte() {
    let size = page(&large()).len();
    assert!(size < 1_100_000, "{size} bytes");
}

#[test]
fn the_bundle_is_the_recorded_one() {
    use sha2::{Digest as _, Sha256};
    let digest = Sha256::digest(include_bytes!("three/three.min.js"));
    let hex: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    assert!(include_str!("three/README.md").contains(&hex), "three.min.js is not what README.md records");
    assert!(include_str!("three/three.min.js").contains(include_str!("three/LICENSE").trim_end()));
}

#[test]
fn scenes_that_do_not_fit_together_still_give_a_page() {
    let mut scene = walker();
    scene.elements.truncate(3);
    scene.curves.clear();
    assert!(page(&scene).contains("inchworm"));
    scene.motion.poses.clear();
    scene.motion.placements = Arc::from([]);
    scene.motion.interval = 0.0;
    assert!(page(&scene).contains("inchworm"));
}

/// Writes pages to look at into the folder that `SGC_VIEW_PAGES` names.
#[test]
fn pages_to_look_at() {
    if let Some(folder) = std::env::var_os("SGC_VIEW_PAGES").map(PathBuf::from) {
        std::fs::write(folder.join("walker.html"), page(&walker())).unwrap();
        std::fs::write(folder.join("large.html"), page(&large())).unwrap();
    }
}
