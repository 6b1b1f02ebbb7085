//! Bodies and drives to try the solvers on.

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, UnitVector3, Vector3};

use crate::design::assembly::{Assembly, Control, Dof, Element, Joint, JointKind, Shape, Travel};
use crate::simulate::Targets;

const DENSITY: f64 = 1000.0;
/// Half edge of a cube and radius of a ball.
const CUBE: f64 = 0.015;
const RADIUS: f64 = 0.01;
const HALF_LENGTH: f64 = 0.008;

pub(crate) fn element(shape: Shape, pose: Isometry3<f64>) -> Element {
    Element { shape, pose, mass: DENSITY * shape.volume(), friction: 0.8 }
}

pub(crate) fn cube(place: Vector3<f64>) -> Element {
    element(Shape::Box { half: Vector3::repeat(CUBE) }, Translation3::from(place).into())
}

pub(crate) fn hinge(anchor: Vector3<f64>, axis: Vector3<f64>, actuator: usize) -> Dof {
    Dof {
        anchor: Point3::from(anchor),
        axis: UnitVector3::new_normalize(axis),
        travel: Travel::Turn,
        control: servo(actuator, 3.0),
        share: 0.2,
        limits: (-0.8, 0.8),
        stiffness: 0.3,
        sideways: None,
        torsion: None,
        damping: 0.01,
        effort: 0.06,
    }
}

/// A servo whose target moves at a rate, rad/s.
pub(crate) fn servo(actuator: usize, rate: f64) -> Control {
    Control::Position { actuator, rate, relaxing_rate: rate, rest: 0.0 }
}

/// Adds to an assembly; keeps track of elements and actuators.
#[derive(Default)]
pub(crate) struct Builder(pub(crate) Assembly);

impl Builder {
    fn place(&self, element: usize) -> Vector3<f64> {
        self.0.elements[element].pose.translation.vector
    }

    pub(crate) fn add(&mut self, element: Element) -> usize {
        self.0.elements.push(element);
        self.0.elements.len() - 1
    }

    pub(crate) fn join(&mut self, parent: usize, child: usize, kind: JointKind) {
        self.0.joints.push(Joint { parent, child, kind });
    }

    /// A cube next to another element.
    pub(crate) fn block(&mut self, parent: usize, way: Vector3<f64>, reach: f64) -> usize {
        let child = self.add(cube(self.place(parent) + way * (reach + CUBE)));
        self.join(parent, child, JointKind::Rigid);
        child
    }

    /// A ball next to another element.
    fn ball(&mut self, parent: usize, way: Vector3<f64>, reach: f64) -> usize {
        let place = self.place(parent) + way * (reach + CUBE);
        let child = self.add(element(Shape::Ball { radius: CUBE }, Translation3::from(place).into()));
        self.join(parent, child, JointKind::Rigid);
        child
    }

    /// Five cylinders, the first hinged to the parent; returns the last.
    fn actuator(&mut self, parent: usize, way: Vector3<f64>, axis: Vector3<f64>) -> usize {
        let turn = UnitQuaternion::rotation_between(&Vector3::x(), &way)
            .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::PI));
        let actuator = self.0.actuators;
        self.0.actuators += 1;
        let (mut last, mut at) = (parent, self.place(parent) + way * CUBE);
        for _ in 0..5 {
            let shape = Shape::Cylinder { radius: RADIUS, half_length: HALF_LENGTH };
            let pose = Isometry3::from_parts((at + way * HALF_LENGTH).into(), turn);
            let child = self.add(element(shape, pose));
            self.join(last, child, JointKind::Dof(hinge(at, axis, actuator)));
            at += way * (2.0 * HALF_LENGTH);
            last = child;
        }
        last
    }

    /// An actuator and its mirror image (z to -z), each with a foot.
    fn limbs(
        &mut self,
        parents: [usize; 2],
        way: Vector3<f64>,
        axis: Vector3<f64>,
        ball: bool,
    ) -> [usize; 2] {
        let mirror = Vector3::new(1.0, 1.0, -1.0);
        let sides = [(way, axis), (way.component_mul(&mirror), -axis.component_mul(&mirror))];
        let mut feet = [0; 2];
        for ((foot, parent), (way, axis)) in feet.iter_mut().zip(parents).zip(sides) {
            let tip = self.actuator(parent, way, axis);
            *foot = if ball { self.ball(tip, way, HALF_LENGTH) } else { self.block(tip, way, HALF_LENGTH) };
        }
        feet
    }
}

/// Two actuators: 16 elements, 10 hinges.
pub(crate) fn m2() -> Assembly {
    let mut body = Builder::default();
    let core = body.add(cube(Vector3::new(0.0, 0.1, 0.0)));
    let tail = body.block(core, -Vector3::x(), CUBE);
    body.block(tail, Vector3::y(), CUBE);
    body.block(core, Vector3::x(), CUBE);
    body.limbs([core, core], Vector3::z(), Vector3::new(0.6, 0.8, 0.0), false);
    body.0
}

/// Four actuators: 27 elements, 20 hinges.
pub(crate) fn m4() -> Assembly {
    let mut body = Builder::default();
    let core = body.add(cube(Vector3::new(0.0, 0.1, 0.0)));
    let tail = body.block(core, -Vector3::x(), CUBE);
    let head = body.block(core, Vector3::x(), CUBE);
    body.limbs([tail, tail], Vector3::z(), Vector3::new(0.6, 0.8, 0.0), false);
    body.limbs([head, head], Vector3::z(), Vector3::x(), true);
    body.0
}

/// Eight actuators: 51 elements, 40 hinges.
pub(crate) fn m8() -> Assembly {
    let mut body = Builder::default();
    let core = body.add(cube(Vector3::new(0.0, 0.1, 0.0)));
    let tail = body.block(core, -Vector3::x(), CUBE);
    let head = body.block(core, Vector3::x(), CUBE);
    let hind = body.limbs([tail, tail], Vector3::z(), Vector3::new(0.6, 0.8, 0.0), false);
    let fore = body.limbs([head, head], Vector3::z(), Vector3::x(), false);
    body.limbs(hind, -Vector3::x(), Vector3::z(), true);
    body.limbs(fore, Vector3::x(), Vector3::z(), false);
    body.0
}

/// An actuator that carries two others, which can reach it and each other: limbs that share a part of their
/// paths. 19 elements, 15 hinges.
pub(crate) fn fork() -> Assembly {
    let mut body = Builder::default();
    let core = body.add(cube(Vector3::new(0.0, 0.1, 0.0)));
    let trunk = body.actuator(core, Vector3::x(), Vector3::z());
    let end = body.block(trunk, Vector3::x(), HALF_LENGTH);
    body.limbs([end, end], Vector3::z(), Vector3::y(), false);
    body.0
}

/// A row of cubes with an actuator and a foot on either side of each: 13 elements
/// and 10 hinges a pair.
pub(crate) fn millipede(pairs: usize) -> Assembly {
    let mut body = Builder::default();
    let mut last = body.add(cube(Vector3::new(0.0, 0.1, 0.0)));
    for pair in 0..pairs {
        if pair > 0 {
            last = body.block(last, Vector3::x(), CUBE);
        }
        body.limbs([last, last], Vector3::z(), Vector3::x(), pair % 2 == 0);
    }
    body.0
}

/// A gait: a sum of two waves per actuator, chosen by a number. `mirrored`
/// gives actuators of a pair the same curve.
pub(crate) fn gait(actuators: usize, number: u64, mirrored: bool) -> Targets {
    let mut state = number.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let period = 3.5 + 1.5 * random();
    let mut waves = Vec::new();
    for actuator in 0..actuators {
        if mirrored && actuator % 2 == 1 {
            waves.push(waves[actuator - 1]);
        } else {
            waves.push([random() - 0.5, 0.6 + 0.8 * random(), random(), 0.6 * random(), random()]);
        }
    }
    let interval = 1.0 / 60.0;
    let mut angles = Vec::new();
    for sample in 0..=1200 {
        let turn = f64::from(sample) * interval / period;
        for wave in &waves {
            let wave_of = |size: f64, times: f64, phase: f64| {
                size * libm::sin(std::f64::consts::TAU * (times * turn + phase))
            };
            angles.push(wave[0] + wave_of(wave[1], 1.0, wave[2]) + wave_of(wave[3], 2.0, wave[4]));
        }
    }
    Targets { interval, actuators, angles }
}

/// No bend at all.
pub(crate) fn idle(actuators: usize) -> Targets {
    Targets { interval: 1.0, actuators, angles: vec![0.0; actuators] }
}
