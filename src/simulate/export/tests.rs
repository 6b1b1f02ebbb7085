use nalgebra::{UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use super::{drive, mjcf, motion, read_motion};
use crate::design::assembly::{Assembly, Control, Dof, JointKind, Shape};
use crate::simulate::tests::{bodies, settings};
use crate::simulate::{Model, Settings, articulated::Articulated};

/// A cube, a hinge, a cylinder and a ball that is rigidly joined to it.
fn small() -> Assembly {
    let mut body = bodies::Builder::default();
    let core = body.add(bodies::cube(Vector3::new(0.0, 0.1, 0.0)));
    let shape = Shape::Cylinder { radius: 0.01, half_length: 0.02 };
    let arm = body.add(bodies::element(shape, nalgebra::Isometry3::translation(0.035, 0.1, 0.0)));
    let anchor = Vector3::new(0.015, 0.1, 0.0);
    body.join(core, arm, JointKind::Dof(bodies::hinge(anchor, Vector3::z(), 0)));
    let ball = Shape::Ball { radius: 0.015 };
    let tip = body.add(bodies::element(ball, nalgebra::Isometry3::translation(0.07, 0.1, 0.0)));
    body.join(arm, tip, JointKind::Rigid);
    body.0.actuators = 1;
    body.0
}

/// What the parts of the elements of `small` are called.
fn names() -> Vec<String> {
    ["core", "bender-1", "ball-1"].map(str::to_owned).into()
}

fn all<'a>(document: &'a Document<'a>, tag: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    document.descendants().filter(move |node| node.has_tag_name(tag))
}

fn numbers(node: Node<'_, '_>, attribute: &str) -> Vec<f64> {
    let text = node.attribute(attribute).unwrap_or_else(|| panic!("{node:?} has no {attribute}"));
    text.split(' ').map(|value| value.parse().unwrap()).collect()
}

#[test]
fn a_capsule_lies_along_its_own_x() {
    let shape = Shape::Capsule { radius: 0.01, half_straight: 0.02 };
    let body = Assembly {
        elements: vec![bodies::element(shape, nalgebra::Isometry3::identity())],
        ..Assembly::default()
    };
    let model = mjcf(&body, &settings(), "capsule", &names()).unwrap();
    let document = Document::parse(&model).unwrap();
    let geom = all(&document, "geom").find(|geom| geom.attribute("type") == Some("capsule")).unwrap();
    assert_eq!(numbers(geom, "size"), [0.01, 0.02]);
    let [w, x, y, z] = <[f64; 4]>::try_from(numbers(geom, "quat")).unwrap();
    let turn = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
    // Its z there is the x of the element, which is x there, too.
    assert!(((turn * Vector3::z()).x.abs() - 1.0).abs() < 1e-5, "{turn}");
}

#[test]
fn a_small_model() {
    insta::assert_snapshot!(mjcf(&small(), &settings(), "small", &names()).unwrap());
}

#[test]
fn a_title_may_be_any_text() {
    let title = "a<b> & \"c\" 'd' --> é\u{0}\n\u{7f}\u{ffff}]]>";
    let text = mjcf(&small(), &settings(), title, &names()).unwrap();
    let document = Document::parse(&text).unwrap();
    assert_eq!(document.root_element().attribute("model"), Some("a<b> & \"c\" 'd' --> é ]]>"));
}

/// Bodies, masses and places of a large body are those of the assembly, seen from y up to z up.
#[test]
fn a_model_has_the_mass_and_the_places_of_the_assembly() {
    let assembly = bodies::m8();
    let text = mjcf(&assembly, &settings(), "m8", &names()).unwrap();
    let document = Document::parse(&text).unwrap();
    assert_eq!(all(&document, "body").count(), 41);
    assert_eq!(all(&document, "position").count(), 40);
    let mass: f64 = all(&document, "inertial").map(|node| numbers(node, "mass")[0]).sum();
    let wanted: f64 = assembly.elements.iter().map(|element| element.mass).sum();
    assert!((mass - wanted).abs() < 1e-12);
    let lowest = assembly.elements.iter().map(|e| e.shape.lowest(&e.pose));
    let lift = -lowest.fold(f64::INFINITY, f64::min);
    for (index, element) in assembly.elements.iter().enumerate() {
        let name = format!("element{index}");
        let geom = all(&document, "geom").find(|node| node.attribute("name") == Some(&name)).unwrap();
        // No body is turned at rest, so places add up.
        let mut place = Vector3::from_vec(numbers(geom, "pos"));
        for body in geom.ancestors().filter(|node| node.has_tag_name("body")) {
            place += Vector3::from_vec(numbers(body, "pos"));
        }
        let p = element.pose.translation.vector;
        assert!((place - Vector3::new(p.x, -p.z, p.y + lift)).norm() < 1e-12, "{name}");
        // The long axis: x of a cylinder here, z there.
        let q = numbers(geom, "quat");
        let turn = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]));
        let round = geom.attribute("type") == Some("cylinder");
        let axis = turn * if round { Vector3::z() } else { Vector3::x() };
        let own = element.pose.rotation * Vector3::x();
        assert!((axis - Vector3::new(own.x, -own.z, own.y)).norm() < 1e-12, "{name}");
    }
}

/// MuJoCo takes the greater coefficient of two; the mean needs a pair.
#[test]
fn other_frictions_are_paired() {
    let pairs = |assembly: &Assembly, settings: &Settings| {
        let text = mjcf(assembly, settings, "", &names()).unwrap();
        let document = Document::parse(&text).unwrap();
        let inside = |node: &Node<'_, '_>| node.parent().is_some_and(|parent| parent.has_tag_name("contact"));
        all(&document, "pair")
            .filter(inside)
            .map(|node| {
                let name = |which| node.attribute(which).unwrap().to_owned();
                (name("geom1"), name("geom2"), numbers(node, "friction")[0])
            })
            .collect::<Vec<_>>()
    };
    let mut assembly = bodies::m2();
    // MuJoCo lets no body touch its parent. Each joint may turn by 46 degrees: the cubes beside the core (1 to 3) can reach
    // the first segment of each actuator, and its foot can reach the last segment but one.
    let across = pairs(&assembly, &settings());
    let cubes = (1..=3).flat_map(|cube| [(cube, 4), (cube, 10)]);
    let due =
        cubes.chain([(7, 9), (13, 15)]).map(|(a, b)| (format!("element{a}"), format!("element{b}"), 0.8));
    let close = |(a, b): (&(String, String, f64), (String, String, f64))| {
        (&a.0, &a.1) == (&b.0, &b.1) && (a.2 - b.2).abs() < 1e-12
    };
    assert!(across.len() == 8 && across.iter().zip(due).all(close), "{across:?}");
    let slippery = Settings { ground_friction: 0.2, ..settings() };
    let mut found = pairs(&assembly, &slippery);
    found.retain(|(first, _, _)| first == "ground");
    assert_eq!(found.len(), assembly.elements.len());
    assert!(found.iter().all(|(_, _, friction)| (friction - 0.4).abs() < 1e-12));
    // A foot of another coefficient, at the end of the first actuator: 9 is its last element.
    assembly.elements[9].friction = 0.2;
    let mut found = pairs(&assembly, &settings());
    found.retain(|pair| !across.contains(pair));
    assert!(found.iter().all(|(a, b, _)| a == "element9" || b == "element9"), "{found:?}");
    assert!(found.contains(&("ground".to_owned(), "element9".to_owned(), 0.4)), "{found:?}");
    let alone = Settings { self_collision: false, ..settings() };
    assert_eq!(pairs(&assembly, &alone).len(), 1, "only the ground");
}

#[test]
fn what_has_no_bounds_has_no_ranges() {
    let mut assembly = small();
    let JointKind::Dof(hinge) = &mut assembly.joints[0].kind else { panic!("a hinge") };
    (hinge.effort, hinge.limits) = (f64::INFINITY, (f64::NEG_INFINITY, f64::INFINITY));
    let text = mjcf(&assembly, &settings(), "", &names()).unwrap();
    assert!(!text.contains("range") && !text.contains("inf"), "{text}");
    let bad = Settings { step: 0.0, ..settings() };
    assert!(mjcf(&assembly, &bad, "", &names()).is_err());
}

/// What hangs in a socket is one body with three joints, and a drive has a column for each of the model's actuators.
#[test]
fn a_socket_is_three_joints_of_one_body() {
    let mut assembly = small();
    let anchor = Vector3::new(0.055, 0.1, 0.0);
    let about = |axis: Vector3<f64>| Dof {
        control: Control::Passive { neutral: 0.0 },
        effort: f64::INFINITY,
        ..bodies::hinge(anchor, axis, 0)
    };
    let axes = [Vector3::y(), Vector3::z(), Vector3::x()].map(about);
    assembly.joints[1].kind = JointKind::Socket(Box::new(axes));
    let text = mjcf(&assembly, &settings(), "socket", &names()).unwrap();
    let document = Document::parse(&text).unwrap();
    // Each is called after the part that hangs on it.
    for number in 0..3 {
        assert!(text.contains(&format!("ball-1.hinge{number}")), "{text}");
    }
    let of_body = |name: &str| {
        let body = all(&document, "body").find(|body| body.attribute("name") == Some(name)).unwrap();
        let joints = body.children().filter(|node| node.has_tag_name("joint"));
        joints.map(|joint| numbers(joint, "axis")).collect::<Vec<_>>()
    };
    assert_eq!(all(&document, "body").count(), 3, "{text}");
    // Their y is minus our z, their z our y.
    assert_eq!(of_body("body4"), [vec![0.0, 0.0, 1.0], vec![0.0, -1.0, 0.0], vec![1.0, 0.0, 0.0]]);
    let actuators: Vec<_> = all(&document, "position").filter_map(|node| node.attribute("name")).collect();
    let targets = crate::simulate::Targets { interval: 10.0, actuators: 1, angles: vec![0.1] };
    let short = Settings { duration: 0.1, ..settings() };
    let drive = drive(&assembly, &short, &targets, &names()).unwrap();
    assert_eq!(drive.lines().next().unwrap(), format!("time,{}", actuators.join(",")));
    assert_eq!(actuators, ["bender-1.hinge0"]);
}

/// The targets are those that the servos of the solvers get: rate-limited, whatever the step.
#[test]
fn the_drive_is_rate_limited() {
    let targets = crate::simulate::Targets { interval: 1.0, actuators: 1, angles: vec![4.0] };
    for (step, rows) in [(0.125, 8), (0.0625, 16)] {
        let settings = Settings { step, duration: 1.0, ..settings() };
        let text = drive(&small(), &settings, &targets, &names()).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!((lines[0], lines.len()), ("time,bender-1.hinge0", rows + 1));
        // A fifth of 4 rad, at 3 rad/s.
        assert!(lines.contains(&"0.125,0.375") && lines.contains(&"0.25,0.75"), "{text}");
        assert_eq!(lines[rows], "1,0.8");
    }
    let mad = crate::simulate::Targets { angles: vec![f64::NAN], ..targets };
    assert!(drive(&small(), &Settings { duration: 1.0, ..settings() }, &mad, &names()).is_err());
}

/// A motion that was written and read again has every element where it was, to the last bit.
#[test]
fn a_motion_comes_back() {
    let assembly = bodies::m2();
    let settings = Settings { duration: 1.05, ..settings() };
    let mut simulation = Articulated.prepare(&assembly, &settings).unwrap();
    let own = simulation.run(&[bodies::gait(2, 3, false)]).remove(0).unwrap();
    let text = motion(&own);
    let other = read_motion(&text, &assembly, &settings).unwrap();
    assert_eq!((other.frames(), other.duration), (own.frames(), own.duration));
    for frame in 0..own.frames() {
        for element in 0..assembly.elements.len() {
            let [a, b] = [&own, &other].map(|m| m.pose(element, own.time(frame)).unwrap());
            assert!((a.translation.vector - b.translation.vector).norm() < 1e-15);
            assert!(a.rotation.angle_to(&b.rotation) < 1e-7);
        }
    }
    for (from, to, says) in [
        ("time,element0.x", "t,element0.x", "does not name the columns"),
        ("\n0.1,", "\n0.11,", "equal intervals"),
        ("\n0.1,", "\n0.1,7,", "values instead of"),
        ("\n0.1,", "\nten,", "not every value is a number"),
        ("\n1.05,", "\n1.02,", "equal intervals"),
    ] {
        assert!(text.contains(from), "{from}");
        let error = read_motion(&text.replacen(from, to, 1), &assembly, &settings).unwrap_err().to_string();
        assert!(error.contains(says), "{from}: {error}");
    }
    let strict = Settings { speed_limit: 1e-6, ..settings.clone() };
    let error = read_motion(&text, &assembly, &strict).unwrap_err().to_string();
    assert!(error.contains("line ") && error.contains("has no value"), "{error}");
    let error = read_motion(&text, &small(), &settings).unwrap_err().to_string();
    assert!(error.contains("motion of 3 elements"), "{error}");
    assert!(read_motion(&text, &assembly, &Settings { duration: 20.0, ..settings.clone() }).is_err());
    assert!(read_motion("", &assembly, &Settings { duration: 20.0, ..settings.clone() }).is_err());
    let head = text.lines().next().unwrap();
    assert!(
        read_motion(head, &assembly, &Settings { duration: 20.0, ..settings.clone() })
            .unwrap_err()
            .to_string()
            .contains("two rows")
    );
    let zeros = format!("{head}\n0{}\n", ",0".repeat(7 * assembly.elements.len()));
    assert!(
        read_motion(&zeros, &assembly, &Settings { duration: 20.0, ..settings.clone() })
            .unwrap_err()
            .to_string()
            .contains("quaternion")
    );
}
