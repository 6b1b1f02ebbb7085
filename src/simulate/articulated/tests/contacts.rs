//! Where parts of a body touch each other.

use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::design::assembly::{JointKind, Shape};
use crate::simulate::World;
use crate::simulate::articulated::collide::Collisions;
use crate::simulate::articulated::kinematics::{Frame, State, Velocity, place};
use crate::simulate::articulated::tree::Tree;
use crate::simulate::articulated::vector::{Quat, V3};
use crate::simulate::lowering::Lowered;
use crate::simulate::tests::bodies::{Builder, cube, element, hinge};
use crate::simulate::tests::settings;

/// The contacts, relative to the middle of the lower one's upper face in m, of two elements of which one lies on the other:
/// both hang on hinges of a core far away.
fn contacts(
    lower: Vector3<f64>,
    upper: Shape,
    height: f64,
    turned: UnitQuaternion<f64>,
) -> Vec<Vector3<f64>> {
    let mut body = Builder::default();
    body.0.actuators = 2;
    let core = body.add(cube(Vector3::new(0.2, 0.0, 0.0)));
    let slab = element(Shape::Box { half: lower }, Translation3::from(-Vector3::y() * lower.y).into());
    let slab = body.add(slab);
    body.join(core, slab, JointKind::Dof(hinge(Vector3::new(0.1, 0.0, 0.0), Vector3::z(), 0)));
    let pose = Translation3::from(Vector3::y() * (height + 1e-4)) * turned;
    let upper = body.add(element(upper, pose));
    body.join(core, upper, JointKind::Dof(hinge(Vector3::new(0.1, 0.01, 0.0), Vector3::z(), 1)));
    let lowered = Lowered::new(&body.0, &settings()).unwrap();
    let tree = Tree::<f32>::new((), &lowered, &[World::NOMINAL]);
    let mut frames = vec![Frame::null(()); lowered.bodies.len()];
    place(&tree, &State::new(&tree, V3::null(()), Quat::still(())), &mut frames);
    let still = vec![Velocity::of(&Frame::null(())); frames.len()];
    let mut found = Vec::new();
    Collisions::<f32>::new((), &lowered, &[World::NOMINAL]).find(&frames, &still, 1.0 / 240.0, |contact| {
        assert!((contact.gap - 0.01).abs() < 1e-3, "a gap of {} cm", contact.gap);
        assert!(contact.normal[1].abs() > 0.999, "{:?}", contact.normal);
        found.push(contact.point.0.map(f64::from));
    });
    let origin = Vector3::from(frames[0].centre.0.map(f64::from)) - Vector3::new(20.0, 0.0, 0.0);
    found.into_iter().map(|point| (Vector3::from(point) - origin) / 100.0).collect()
}

/// On one contact, which jumps from one end of the faces to the other, what lies flat would rock.
#[test]
fn faces_touch_at_their_corners() {
    let slab = Vector3::new(0.03, 0.005, 0.03);
    let long = Vector3::new(0.03, 0.005, 0.005);
    let upright = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::FRAC_PI_2);
    let across = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
    let flat = UnitQuaternion::identity();
    let boxed = Shape::Box { half: Vector3::new(0.02, 0.005, 0.01) };
    let beam = Shape::Box { half: long };
    let cylinder = Shape::Cylinder { radius: 0.005, half_length: 0.02 };
    let capsule = Shape::Capsule { radius: 0.005, half_straight: 0.02 };
    // The edges are rounded by a fifth of the smallest half size. Of a round face it is a square that carries.
    let square = 0.004 * std::f64::consts::FRAC_1_SQRT_2;
    for (lower, upper, height, turned, [x, z]) in [
        (slab, boxed, 0.005, flat, [0.019, 0.009]),
        (slab, cylinder, 0.005, flat, [0.019, 0.0]),
        (slab, cylinder, 0.02, upright, [square, square]),
        (slab, capsule, 0.005, flat, [0.02, 0.0]),
        (slab, Shape::Ball { radius: 0.01 }, 0.01, flat, [0.0, 0.0]),
        (long, beam, 0.005, across, [0.004, 0.004]),
    ] {
        let points = contacts(lower, upper, height, turned);
        let most = |axis: usize, sign: f64| points.iter().map(|p| p[axis] * sign).fold(f64::MIN, f64::max);
        for (axis, half) in [(0, x), (2, z)] {
            for sign in [1.0, -1.0] {
                let (reached, wanted) = (most(axis, sign), half);
                assert!((reached - wanted).abs() < 3e-4, "{upper:?}: {reached} m along {axis}, not {wanted}");
            }
        }
        assert!(points.len() <= 5, "{upper:?}: {points:?}");
    }
}
