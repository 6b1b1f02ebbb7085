//! The model file of MuJoCo (MJCF).
//!
//! Bodies have their frame at their centre of mass with the world's axes at
//! rest, as in [`Lowered`]. MuJoCo's z is up: x, y, z here are x, -z, y there.
//!
//! Of two geoms that touch, MuJoCo takes the greater friction; the assembly asks
//! for the geometric mean. Where the two differ, a `pair` says which it is.
//! MuJoCo lets no body collide with its own parent: a `pair` asks for those elements
//! with one joint between them that may. Other elements that overlap at rest are pushed apart there,
//! and not here: a grammar should require `no_overlap`. Contacts are springs there
//! and rigid here: with MuJoCo's default springs, which give way for 20 ms, robots
//! take other paths.

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use super::joint_names;
use super::xml::{Xml, numbers};
use crate::design::assembly::{Assembly, Control, Dof, Shape, Travel};
use crate::simulate::articulated::colliding;
use crate::simulate::lowering::{Body, Lowered, Piece};
use crate::simulate::{Settings, Unfit};

/// What the reader of the file should know.
const ABOUT: [&str; 4] = [
    "SI units and radians. The y of sgc is up and is z here: x, y, z there are x, -z, y here.",
    "Bodies are rigidly joined parts; element N is the N-th element of the design.",
    "Servos and motors: each follows the column of its name in the drive (sgc export, format drive), a row for each step.",
    "Contacts and limits are as stiff as the time step allows (solref); friction has a round cone (cone, impratio).",
];

/// An assembly as a model of MuJoCo; `title` may be any text, `names` are those of the parts that its elements belong to.
///
/// # Errors
///
/// [`Unfit`] when the assembly or its settings cannot be simulated.
pub fn mjcf(
    assembly: &Assembly,
    settings: &Settings,
    title: &str,
    names: &[String],
) -> Result<String, Unfit> {
    let settings = settings.in_whole_steps();
    let lowered = Lowered::new(assembly, &settings)?;
    let names = joint_names(&lowered, names);
    let mut xml = Xml::default();
    xml.open("mujoco", &[("model", title.to_owned())]);
    for line in ABOUT {
        xml.comment(line);
    }
    xml.leaf("compiler", &[("angle", "radian".into()), ("autolimits", "true".into())]);
    xml.leaf(
        "option",
        &[
            ("timestep", numbers(&[settings.step])),
            ("gravity", numbers(&[0.0, 0.0, -settings.gravity])),
            ("integrator", "implicitfast".into()),
            ("cone", "elliptic".into()),
            ("impratio", "10".into()),
        ],
    );
    xml.open("default", &[]);
    // Without self-collision, elements meet only what looks for them: the ground.
    let seeks = if settings.self_collision { "1" } else { "0" };
    let collides = |seeks: &str| [("contype", seeks.to_owned()), ("conaffinity", "1".to_owned())];
    // Twice the step, the shortest time constant that is stable, and no bounce.
    let stiff = numbers(&[2.0 * settings.step, 1.0]);
    let geom = [("condim", "3".to_owned()), ("solref", stiff.clone())];
    xml.leaf("geom", &[&geom[..], &collides(seeks)].concat());
    xml.leaf("pair", &[("condim", "3".into()), ("solref", stiff.clone())]);
    xml.leaf("joint", &[("solreflimit", stiff)]);
    xml.close();
    xml.open("worldbody", &[]);
    xml.leaf("light", &[("pos", "0 0 3".into()), ("directional", "true".into())]);
    let ground = [
        ("name", "ground".to_owned()),
        ("type", "plane".to_owned()),
        ("size", "0 0 0.1".to_owned()),
        ("friction", friction(settings.ground_friction)),
    ];
    xml.leaf("geom", &[&ground[..], &collides("1")].concat());
    bodies(&mut xml, &lowered, &names);
    xml.close();
    contacts(&mut xml, &lowered, &settings);
    xml.open("actuator", &[]);
    let dofs = lowered.bodies.iter().filter_map(|body| body.dof.as_ref());
    for (name, dof) in names.iter().zip(dofs) {
        servo(&mut xml, name, dof);
    }
    Ok(xml.finish())
}

/// From here to MuJoCo: a quarter turn about x.
fn turn() -> UnitQuaternion<f64> {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(half, half, 0.0, 0.0))
}

fn turned(v: &Vector3<f64>) -> [f64; 3] {
    [v.x, -v.z, v.y]
}

/// Sliding friction; the others do not act on contacts of three directions.
fn friction(coefficient: f64) -> String {
    numbers(&[coefficient, 0.005, 0.0001])
}

/// The tree, depth first as it is numbered.
fn bodies(xml: &mut Xml, lowered: &Lowered, joints: &[String]) {
    let mut joints = joints.iter();
    let mut open: Vec<usize> = Vec::new();
    for (index, body) in lowered.bodies.iter().enumerate().filter(|(_, body)| !body.is_massless()) {
        // The degrees of freedom of a socket are joints of one body there.
        let mut chain = vec![body];
        let mut parent = body.parent;
        while lowered.bodies[parent].is_massless() {
            chain.push(&lowered.bodies[parent]);
            parent = lowered.bodies[parent].parent;
        }
        while index > 0 && open.last().is_some_and(|&last| last != parent) {
            open.pop();
            xml.close();
        }
        open.push(index);
        let origin = if index == 0 { Vector3::zeros() } else { lowered.bodies[parent].centre };
        let place = ("pos", numbers(&turned(&(body.centre - origin))));
        xml.open("body", &[("name", format!("body{index}")), place]);
        for own in chain.into_iter().rev() {
            joint(xml, own, body.centre, &mut joints);
        }
        let inertia = [("pos", "0 0 0".to_owned()), ("mass", numbers(&[body.mass]))];
        let full = ("fullinertia", inertia_of(&body.inertia));
        xml.leaf("inertial", &[&inertia[..], &[full]].concat());
        for (element, piece) in lowered.pieces.iter().enumerate().filter(|(_, piece)| piece.body == index) {
            geom(xml, element, piece);
        }
    }
    for _ in open {
        xml.close();
    }
}

fn joint<'a>(xml: &mut Xml, own: &Body, centre: Vector3<f64>, names: &mut impl Iterator<Item = &'a String>) {
    let Some(dof) = &own.dof else {
        xml.leaf("freejoint", &[("name", "root".into())]);
        return;
    };
    let mut attributes = vec![
        ("name", names.next().cloned().unwrap_or_default()),
        (
            "type",
            match dof.travel {
                Travel::Turn => "hinge".to_owned(),
                Travel::Slide => "slide".to_owned(),
            },
        ),
        ("pos", numbers(&turned(&(dof.anchor.coords - centre)))),
        ("axis", numbers(&turned(&dof.axis))),
    ];
    if let Control::Passive { neutral } = dof.control {
        attributes.extend([
            ("stiffness", numbers(&[dof.stiffness])),
            ("damping", numbers(&[dof.damping])),
            ("springref", numbers(&[neutral])),
        ]);
    }
    let (low, high) = dof.limits;
    if low.is_finite() || high.is_finite() {
        // Far beyond any turn is as good as no limit on that side.
        attributes.push(("range", numbers(&[low.max(-1e3), high.min(1e3)])));
    }
    xml.leaf("joint", &attributes);
}

/// The inertia in MuJoCo's axes and order: xx, yy, zz, xy, xz, yz.
fn inertia_of(inertia: &Matrix3<f64>) -> String {
    let turn = turn().to_rotation_matrix();
    let m = turn.matrix() * inertia * turn.matrix().transpose();
    numbers(&[m.m11, m.m22, m.m33, m.m12, m.m13, m.m23])
}

fn geom(xml: &mut Xml, element: usize, piece: &Piece) {
    let Isometry3 { rotation, translation } = piece.local;
    // What is round about x lies along z in MuJoCo: a quarter turn about y brings z to x.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let lay = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(half, 0.0, half, 0.0));
    let (kind, size, rotation) = match piece.shape {
        Shape::Box { half } => ("box", vec![half.x, half.y, half.z], rotation),
        Shape::Ball { radius } => ("sphere", vec![radius], rotation),
        Shape::Cylinder { radius, half_length } => ("cylinder", vec![radius, half_length], rotation * lay),
        Shape::Capsule { radius, half_straight } => ("capsule", vec![radius, half_straight], rotation * lay),
    };
    let q = (turn() * rotation).into_inner();
    xml.leaf(
        "geom",
        &[
            ("name", format!("element{element}")),
            ("type", kind.to_owned()),
            ("size", numbers(&size)),
            ("pos", numbers(&turned(&translation.vector))),
            ("quat", numbers(&[q.w, q.i, q.j, q.k])),
            ("friction", friction(piece.friction)),
        ],
    );
}

/// Contacts that MuJoCo's own rules would not give as they should be.
fn contacts(xml: &mut Xml, lowered: &Lowered, settings: &Settings) {
    let mut pairs = Vec::new();
    let ground = settings.ground_friction;
    for (index, piece) in lowered.pieces.iter().enumerate() {
        if ground != piece.friction {
            pairs.push(("ground".to_owned(), index, (ground * piece.friction).sqrt()));
        }
    }
    let mut colliding = if settings.self_collision { colliding(lowered) } else { Vec::new() };
    colliding.sort_unstable_by_key(|&(second, first)| (first, second));
    for (second, first) in colliding {
        let (a, b) = (&lowered.pieces[first], &lowered.pieces[second]);
        let mean = (a.friction * b.friction).sqrt();
        if lowered.distance(a.body, b.body) == 1 || a.friction != b.friction {
            pairs.push((format!("element{first}"), second, mean));
        }
    }
    if pairs.is_empty() {
        return;
    }
    xml.open("contact", &[]);
    for (first, second, mean) in pairs {
        xml.leaf(
            "pair",
            &[
                ("geom1", first),
                ("geom2", format!("element{second}")),
                ("friction", numbers(&[mean, mean, 0.005, 0.0001, 0.0001])),
            ],
        );
    }
    xml.close();
}

/// What drives a joint; what nothing drives has its springs from the joint itself.
fn servo(xml: &mut Xml, name: &str, dof: &Dof) {
    let mut attributes = vec![("name", name.to_owned()), ("joint", name.to_owned())];
    let element = match dof.control {
        Control::Position { .. } => {
            attributes.extend([("kp", numbers(&[dof.stiffness])), ("kv", numbers(&[dof.damping]))]);
            "position"
        }
        Control::Speed { .. } => {
            attributes.push(("kv", numbers(&[dof.damping])));
            "velocity"
        }
        Control::Passive { .. } => return,
    };
    if dof.effort.is_finite() {
        attributes.push(("forcerange", numbers(&[-dof.effort, dof.effort])));
    }
    xml.leaf(element, &attributes);
}
