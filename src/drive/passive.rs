//! What sensors measure of passive joints: how far they have turned or slid, and how fast. It follows from how the two elements of a
//! joint lie and move, so that every solver that knows these tells it.

use grammar_lang::eval::{Made, MadeJoint};
use grammar_lang::ir::Track;
use nalgebra::{Isometry3, Vector3};
use std::f64::consts::TAU;

use crate::derive::Candidate;
use crate::design::PartId;
use crate::design::assembly::{Dof, JointKind, Travel};
use crate::simulate::Measured;

/// What is measured of the joint of a part that hangs on one, or of the joints of a passive row together, from base to tip: rad, m, rad/s
/// or m/s. None of a part without such a joint, of a ball in its socket, and where the joint does something else.
pub(super) fn measured(
    candidate: &Candidate<'_>,
    part: PartId,
    track: Track,
    now: &Measured<'_>,
) -> Option<f64> {
    let own = joint_of(candidate, part).filter(|own| track.is_of(own.kind))?;
    // Positions are counted from where the joint begins.
    let start = if matches!(track, Track::Angle | Track::Distance) { own.start() } else { 0.0 };
    Some(start + moved(candidate, part, track, now)?)
}

/// How far the joints of a part have moved together since the motion began, or how fast they move.
fn moved(candidate: &Candidate<'_>, part: PartId, track: Track, now: &Measured<'_>) -> Option<f64> {
    let body = &candidate.body;
    let joints = body.assembly.joints.iter().filter(|joint| body.parts_of_elements[joint.child] == part);
    let mut sum = 0.0;
    for joint in joints {
        let JointKind::Dof(dof) = &joint.kind else { continue };
        let (parent, child) = (joint.parent, joint.child);
        let rest = |element: usize| body.assembly.elements[element].pose;
        let rest = (rest(parent), rest(child));
        let at = Pair { rest, now: (now.pose(parent)?, now.pose(child)?) };
        sum += match track {
            Track::Angle | Track::Distance => at.position(dof),
            _ => {
                let rate = at.rate(dof, now.velocity(parent)?, now.velocity(child)?);
                match now.passed().zip(now.pose_before(parent)).zip(now.pose_before(child)) {
                    Some(((passed, parent), child)) => {
                        let gone = at.position(dof) - Pair { rest, now: (parent, child) }.position(dof);
                        whole_turns(gone, rate * passed, dof.travel) / passed
                    }
                    None => rate,
                }
            }
        };
    }
    Some(sum)
}

/// How far a joint went, if its position is known within half a turn, and about how far.
fn whole_turns(gone: f64, about: f64, travel: Travel) -> f64 {
    match travel {
        Travel::Turn => gone + TAU * libm::round((about - gone) / TAU),
        Travel::Slide => gone,
    }
}

/// The passive joint of a part.
fn joint_of<'a>(candidate: &'a Candidate<'_>, part: PartId) -> Option<&'a MadeJoint> {
    match candidate.design().parts.get(&part)?.made.as_ref() {
        Made::Block(block) => block.joint.as_ref(),
        Made::Actuator(row) => Some(&row.joint).filter(|_| row.motor.is_none()),
        Made::Cell(_) => None,
    }
}

/// The position of a joint's degree of freedom, from the poses of its two elements in the world, the parent's first: rad, within half a
/// turn of where it was at rest, or m.
pub(crate) fn position_of(
    dof: &Dof,
    rest: (Isometry3<f64>, Isometry3<f64>),
    now: (Isometry3<f64>, Isometry3<f64>),
) -> f64 {
    Pair { rest, now }.position(dof)
}

/// The two elements of a joint, the parent first: their poses in the world at rest, and now.
struct Pair {
    rest: (Isometry3<f64>, Isometry3<f64>),
    now: (Isometry3<f64>, Isometry3<f64>),
}

impl Pair {
    /// The axis in the frame of the parent.
    fn axis(&self, dof: &Dof) -> Vector3<f64> {
        self.rest.0.rotation.inverse() * dof.axis.into_inner()
    }

    /// The position of the joint's degree of freedom: within half a turn of where it was at rest, rad, or m.
    fn position(&self, dof: &Dof) -> f64 {
        let rest = self.rest.0.inv_mul(&self.rest.1);
        let now = self.now.0.inv_mul(&self.now.1);
        match dof.travel {
            Travel::Turn => {
                let turn = now.rotation * rest.rotation.inverse();
                let angle = 2.0 * libm::atan2(turn.imag().dot(&self.axis(dof)), turn.w);
                angle - TAU * libm::round(angle / TAU)
            }
            Travel::Slide => (now.translation.vector - rest.translation.vector).dot(&self.axis(dof)),
        }
    }

    /// How fast that changes, rad/s or m/s, with the velocities and angular velocities of the two elements.
    fn rate(
        &self,
        dof: &Dof,
        (velocity, spin): (Vector3<f64>, Vector3<f64>),
        (velocity_of_child, spin_of_child): (Vector3<f64>, Vector3<f64>),
    ) -> f64 {
        let axis = self.now.0.rotation * self.axis(dof);
        match dof.travel {
            Travel::Turn => (spin_of_child - spin).dot(&axis),
            Travel::Slide => {
                let arm = self.now.1.translation.vector - self.now.0.translation.vector;
                (velocity_of_child - velocity - spin.cross(&arm)).dot(&axis)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use grammar_lang::source::SourceMap;

    use super::*;
    use crate::derive::Derivation;
    use crate::loader::Files;
    use crate::simulate::tests::settings;
    use crate::simulate::{Case, ControlLoop, Controller, Invalid, Settings, Stop, Targets, World, model};

    /// Swings all actuators, and keeps how far what the solver says of each is from what its elements say, at most.
    #[derive(Debug)]
    struct Probe<'a> {
        candidate: &'a Candidate<'a>,
        /// Each actuator, and what is measured of it.
        actuators: Vec<(PartId, [Track; 2])>,
        /// How far it swings, and how far what is measured may be off, rad or m.
        reach: f64,
        /// The greatest position and the greatest error of a position and of a rate.
        found: Mutex<[f64; 3]>,
    }

    impl Controller for Probe<'_> {
        fn interval(&self) -> f64 {
            1.0 / 60.0
        }

        fn commands(&self, _: usize) -> bool {
            true
        }

        fn begin(&self) -> Box<dyn ControlLoop + '_> {
            Box::new(Probing(self))
        }
    }

    struct Probing<'a>(&'a Probe<'a>);

    impl ControlLoop for Probing<'_> {
        fn answer(&mut self, now: &Measured<'_>, commands: &mut [f64]) -> Result<(), Invalid> {
            let mut found = self.0.found.lock().unwrap();
            for (i, (part, [position, rate])) in self.0.actuators.iter().enumerate() {
                commands[i] = self.0.reach * libm::sin(5.0 * now.time + i as f64);
                let by_elements = |track| moved(self.0.candidate, *part, track, now).unwrap();
                let (said, fast) = (now.position(i).unwrap(), now.rate(i).unwrap());
                found[0] = found[0].max(said.abs());
                found[1] = found[1].max((by_elements(*position) - said).abs());
                found[2] = found[2].max((by_elements(*rate) - fast).abs());
            }
            Ok(())
        }
    }

    /// Where something drives a joint, a solver says how far it has moved: its elements say the same, whatever the joint does, also
    /// of rows that are held by their tips, and of images in a mirror.
    #[test]
    fn elements_say_how_far_their_joints_have_moved() {
        let turn = [Track::Angle, Track::AngleRate];
        let slide = [Track::Distance, Track::DistanceRate];
        for (joint, range, tracks, reach) in [
            (
                "bend about z",
                "bend = -90 deg .. 90 deg bending_speed = 360 deg/s relaxing_speed = 360 deg/s torque = 1 N*m/rad stiffness = 1 N*m/rad^2 damping = 0.01 N*m*s/rad^2",
                turn,
                0.7,
            ),
            (
                "bend about vector(0, 1, 2)",
                "bend = -90 deg .. 90 deg bending_speed = 360 deg/s relaxing_speed = 360 deg/s torque = 1 N*m/rad stiffness = 1 N*m/rad^2 damping = 0.01 N*m*s/rad^2",
                turn,
                0.7,
            ),
            (
                "twist",
                "range = -90 deg .. 90 deg speed = 360 deg/s effort = 1 N*m/rad stiffness = 1 N*m/rad^2 damping = 0.01 N*m*s/rad^2",
                turn,
                0.7,
            ),
            (
                "slide along x",
                "range = -1 cm .. 2 cm speed = 100 mm/s effort = 5 N stiffness = 500 N/m damping = 10 N*s/m",
                slide,
                0.008,
            ),
            (
                "slide along y",
                "range = -2 cm .. 2 cm speed = 100 mm/s effort = 5 N stiffness = 500 N/m damping = 10 N*s/m",
                slide,
                0.008,
            ),
        ] {
            let drive = if tracks == slide { "distance = x * 1 mm" } else { "angle = x * 1 deg" };
            let text = format!(
                "grammar rows
                use std.blocks     {{ cube }}
                use std.models     {{ hinge_model }}
                use std.objectives {{ travel }}
                use std.search     {{ plain_annealing }}
                symmetry mirror xy
                actuator row {{
                  param segments : Count in 2 .. 4 = 3
                  segment = cylinder(6 mm, 15 mm)  density = 1 g/cm^3  friction = 0.8
                  joint = {joint}  {range}
                }}
                begin {{
                  place core : cube
                  place a    : row to core.left
                  place b    : cube to a.tip
                  place c    : row(segments = 2) to b.top by tip
                  place d    : cube to c.base
                }}
                rule turn {{ match x : row  set x.turn = 90 deg }}
                actuation swing for r : row {{
                  shared x : Number in 0 .. 1 mutate 0.3 by normal(0, 0.3)
                  drive {drive}
                }}
                actuate row with swing
                simulate hinge_model for 2 s
                maximize travel in cm
                search plain_annealing"
            );
            let mut sources = SourceMap::default();
            let entry = sources.add("own.sgr", text);
            let compiled = grammar_lang::compile(&Files, &mut sources, entry, &[], None);
            let rules = compiled.ruleset.unwrap_or_else(|| panic!("{:#?}", compiled.diagnostics));
            let candidate = Candidate::new(&rules, Arc::new(Derivation::begin(&rules)));
            let actuators = candidate.body.actuators.iter().map(|part| (*part, tracks)).collect::<Vec<_>>();
            assert_eq!(actuators.len(), 4, "each has its image");
            let settings = Settings { duration: 1.5, ..settings() };
            // Rapier counts in 32 bits.
            for (name, off, off_rate) in [("articulated", 1e-6, 3e-5), ("rapier", 2e-3, 0.2)] {
                let probe = Probe {
                    candidate: &candidate,
                    actuators: actuators.clone(),
                    reach,
                    found: Mutex::default(),
                };
                let none = Targets { interval: 1.0, actuators: 4, angles: vec![0.0; 16] };
                let case = Case { controller: Some(&probe), ..Case::new(&none, &World::NOMINAL) };
                let mut simulation =
                    model(name).unwrap().prepare(&candidate.body.assembly, &settings).unwrap();
                simulation.run_cases(Stop::NEVER, &[case]).unwrap().remove(0).unwrap();
                let [most, error, of_rate] = probe.found.into_inner().unwrap();
                assert!(most > 0.5 * reach, "{name}, {joint}: {most} is no swing");
                assert!(
                    error < off && of_rate < off_rate,
                    "{name}, {joint}: off by {error}, rates by {of_rate}"
                );
            }
        }
    }
}
