//! What goes into a simulation (targets) and what comes out (motion).

use std::sync::Arc;

use nalgebra::{Isometry3, UnitQuaternion};

use super::LAST_STRETCH;
use crate::design::assembly::Shape;

/// Target bend angles of every actuator, sampled at equal intervals and
/// interpolated linearly in between; the last sample holds on.
#[derive(Clone, Debug, PartialEq)]
pub struct Targets {
    /// Time between samples in s.
    pub interval: f64,
    /// Number of actuators.
    pub actuators: usize,
    /// Total bend angle in rad, `[sample * actuators + actuator]`.
    pub angles: Vec<f64>,
}

impl Targets {
    /// Number of samples.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.angles.len().checked_div(self.actuators).unwrap_or(0)
    }

    /// The target of one actuator at a sample, rad.
    pub fn cell(&mut self, sample: usize, actuator: usize) -> Option<&mut f64> {
        self.angles.get_mut(sample * self.actuators + actuator)
    }

    /// Where the targets of one actuator are furthest from others from a time in s on: when, and what both are.
    #[must_use]
    pub fn furthest(&self, other: &Self, actuator: usize, from: f64) -> Option<(f64, f64, f64)> {
        let times = (0..self.samples().max(other.samples())).map(|sample| sample as f64 * self.interval);
        let both = times.filter(|time| *time >= from);
        both.map(|time| (time, self.at(actuator, time), other.at(actuator, time)))
            .max_by(|(_, a, b), (_, c, d)| (a - b).abs().total_cmp(&(c - d).abs()))
    }

    /// The target of one actuator at time `t` in rad.
    #[must_use]
    pub fn at(&self, actuator: usize, t: f64) -> f64 {
        if self.actuators == 0 {
            return 0.0;
        }
        let last = (self.angles.len() / self.actuators).saturating_sub(1);
        let place = (t / self.interval).max(0.0);
        let low = (place as usize).min(last);
        let high = (low + 1).min(last);
        let part = (place - low as f64).clamp(0.0, 1.0);
        let of = |sample: usize| self.angles.get(sample * self.actuators + actuator).copied().unwrap_or(0.0);
        of(low) + (of(high) - of(low)) * part
    }

    /// Commands that hold from one moment to the next, as targets at the steps of a solver: each step has the command that holds where
    /// it begins.
    #[must_use]
    pub fn held(&self, step: f64, duration: f64) -> Self {
        let samples = libm::ceil(duration / step - 1e-9).max(0.0) as usize + 1;
        let last = self.samples().saturating_sub(1);
        let at = |sample: usize| {
            let begun = sample.saturating_sub(1) as f64 * step;
            let moment = (libm::floor(begun / self.interval + 1e-9) as usize).min(last);
            self.angles.iter().skip(moment * self.actuators).take(self.actuators).copied()
        };
        Self { interval: step, actuators: self.actuators, angles: (0..samples).flat_map(at).collect() }
    }

    /// The same, and 0 for an actuator that there is no target of.
    #[must_use]
    pub(super) fn asked(&self, actuator: usize, t: f64) -> f64 {
        if actuator < self.actuators { self.at(actuator, t) } else { 0.0 }
    }
}

/// Where an element sits, fixed to one body of the solver, and its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Index of the body.
    pub body: usize,
    /// Pose of the element in the body's frame.
    pub local: Isometry3<f64>,
    /// Geometry of the element at rest.
    pub shape: Shape,
    /// What strains it, if it is a ball that swells: actuators, and the strain for each unit of their position.
    pub swells: Vec<(usize, f64)>,
}

impl Placement {
    /// Of an element that does not swell.
    #[must_use]
    pub fn new(body: usize, local: Isometry3<f64>, shape: Shape) -> Self {
        Self { body, local, shape, swells: Vec::new() }
    }

    /// Its geometry where actuators stand so.
    pub(super) fn swollen(&self, position: impl Fn(usize) -> f64) -> Shape {
        let strain: f64 = self.swells.iter().map(|(actuator, gain)| gain * position(*actuator)).sum();
        match self.shape {
            Shape::Ball { radius } if strain != 0.0 => Shape::Ball { radius: radius * (1.0 + strain) },
            shape => shape,
        }
    }
}

/// What lasts for one frame in so many has lasted.
const SUNK: usize = 10;
/// So many frames tell for how long something lasts.
const SOME: usize = 200;

/// A recorded motion: the pose of every body at equal intervals, from which
/// the pose of any element at any time follows.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Time between frames in s; frame 0 is the state at rest, time zero.
    pub interval: f64,
    /// Simulated time in s: the time of the last frame, which may come less
    /// than an interval after the one before it.
    pub duration: f64,
    /// Number of bodies.
    pub bodies: usize,
    /// Body poses in the world, `[frame * bodies + body]`.
    pub poses: Vec<Isometry3<f64>>,
    /// Actual total bend angle of every actuator, `[frame * actuators + actuator]`, rad.
    pub bends: Vec<f64>,
    /// The mechanical work that the servos of every actuator did over the whole
    /// motion, J: torque times turn, hinge by hinge and step by step, where it is
    /// positive. A servo that is bent back gets nothing for it: an actuator that
    /// yields does not fill its battery again.
    pub work: Vec<f64>,
    /// What actuators were asked for where a controller commands some of them, at its moments; else none.
    pub commands: Option<Targets>,
    /// Where each element of the assembly sits.
    pub placements: Arc<[Placement]>,
}

/// The pose when a share of the way from one to another has passed: the position linearly, the rotation by normalised quaternions.
///
/// A quaternion and its negative are the same rotation, and solvers may give either: the nearer one is meant, or the pose would turn
/// the long way round.
pub(super) fn pose_between(from: &Isometry3<f64>, to: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    let position = from.translation.vector.lerp(&to.translation.vector, share);
    let near = if from.rotation.coords.dot(&to.rotation.coords) < 0.0 {
        UnitQuaternion::new_unchecked(-to.rotation.into_inner())
    } else {
        to.rotation
    };
    Isometry3::from_parts(position.into(), from.rotation.nlerp(&near, share))
}

impl Motion {
    /// Number of recorded frames.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.poses.len().checked_div(self.bodies).unwrap_or(0)
    }

    /// The time of a frame in s.
    #[must_use]
    pub fn time(&self, frame: usize) -> f64 {
        (frame as f64 * self.interval).min(self.duration)
    }

    /// The frames around time `t`, and which share of the way from the first to the second it is; `None` without frames.
    fn between(&self, t: f64) -> Option<(usize, usize, f64)> {
        let last = self.frames().checked_sub(1)?;
        let mut low = ((t / self.interval).max(0.0) as usize).min(last);
        if self.time(low) >= self.duration {
            low = last;
        }
        let high = (low + 1).min(last);
        let span = self.time(high) - self.time(low);
        let part = if span > 0.0 { ((t - self.time(low)) / span).clamp(0.0, 1.0) } else { 0.0 };
        Some((low, high, part))
    }

    /// Where an actuator stands in a frame, rad, m or as a strain; zero where that is not recorded.
    pub(super) fn position(&self, frame: usize, actuator: usize) -> f64 {
        let actuators = self.bends.len().checked_div(self.frames()).unwrap_or(0);
        if actuator < actuators {
            self.bends.get(frame * actuators + actuator).copied().unwrap_or(0.0)
        } else {
            0.0
        }
    }

    /// The pose of an element in the world at time `t`, between two frames
    /// interpolated (position linearly, rotation by normalised quaternions);
    /// `None` for an element that does not exist.
    #[must_use]
    pub fn pose(&self, element: usize, t: f64) -> Option<Isometry3<f64>> {
        let placement = self.placements.get(element)?;
        let (low, high, part) = self.between(t)?;
        let (from, to) = (
            self.poses.get(low * self.bodies + placement.body)?,
            self.poses.get(high * self.bodies + placement.body)?,
        );
        let body = if part <= 0.0 {
            *from
        } else if part >= 1.0 {
            *to
        } else {
            pose_between(from, to, part)
        };
        Some(body * placement.local)
    }

    /// How far the centre of an element is below the floor, m, in a tenth of the recorded frames or more; zero if none is so long. A hard
    /// landing is no sinking.
    #[must_use]
    pub fn depth(&self) -> f64 {
        let deepest = |frame: usize| {
            let poses = (0..self.placements.len()).filter_map(|element| self.pose(element, self.time(frame)));
            poses.map(|pose| -pose.translation.y).fold(0.0, f64::max)
        };
        for_long((0..self.frames()).map(deepest).collect())
    }

    /// How far the centre of an element is inside another one, m, in a tenth of the recorded frames or more; zero if none is so long. What
    /// overlaps so far at the beginning is meant.
    #[must_use]
    pub fn interlocked(&self) -> f64 {
        let placed = |frame: usize| -> Vec<(Isometry3<f64>, &Shape)> {
            let time = self.time(frame);
            let placements = self.placements.iter().enumerate();
            placements.filter_map(|(element, own)| Some((self.pose(element, time)?, &own.shape))).collect()
        };
        let inset = |(one, _): &(Isometry3<f64>, &Shape), (pose, shape): &(Isometry3<f64>, &Shape)| {
            shape.inset(&pose.inverse_transform_point(&one.translation.vector.into()))
        };
        let begun = placed(0);
        let mut apart: Vec<(usize, usize)> = Vec::new();
        for (one, a) in begun.iter().enumerate() {
            let others = begun.iter().enumerate().filter(|(other, b)| *other != one && inset(a, b) <= 0.0);
            apart.extend(others.map(|(other, _)| (one, other)));
        }
        let deepest = |frame: usize| {
            let now = placed(frame);
            let pairs = apart.iter().filter_map(|(one, other)| now.get(*one).zip(now.get(*other)));
            pairs.map(|(one, other)| inset(one, other)).fold(0.0, f64::max)
        };
        // All pairs take long: some frames tell enough.
        let some = self.frames().div_ceil(SOME).max(1);
        for_long((0..self.frames()).step_by(some).map(deepest).collect())
    }

    /// The height in m of the lowest point of an element at time `t`; `None`
    /// for an element that does not exist.
    #[must_use]
    pub fn lowest(&self, element: usize, t: f64) -> Option<f64> {
        let pose = self.pose(element, t)?;
        let placement = self.placements.get(element)?;
        if placement.swells.is_empty() {
            return Some(placement.shape.lowest(&pose));
        }
        let (low, high, part) = self.between(t)?;
        let position = |actuator| {
            let of = |frame| self.position(frame, actuator);
            of(low) + (of(high) - of(low)) * part
        };
        Some(placement.swollen(position).lowest(&pose))
    }

    /// Whether an element is faster than `limit` (m/s) on its way to where it ends: along the ground, in the mean from
    /// any whole second until the end.
    #[must_use]
    pub fn outpaces(&self, limit: f64) -> bool {
        let seconds = libm::floor(self.duration - LAST_STRETCH + 1e-9);
        (0..self.placements.len()).any(|element| {
            let Some(end) = self.pose(element, self.duration) else { return false };
            (0..=seconds.max(-1.0) as i64).any(|second| {
                let t = second as f64;
                let apart = self.pose(element, t).map(|p| end.translation.vector - p.translation.vector);
                apart.is_some_and(|d| libm::hypot(d.x, d.z) > limit * (self.duration - t))
            })
        })
    }

    /// The longest extent of an element in m: the longest edge of a box, the
    /// diameter of a ball, the larger of a cylinder's length and diameter;
    /// `None` for an element that does not exist.
    #[must_use]
    pub fn size(&self, element: usize) -> Option<f64> {
        self.placements.get(element).map(|placement| placement.shape.longest())
    }
}

/// The depth that is reached in a tenth of the frames or more.
fn for_long(mut depths: Vec<f64>) -> f64 {
    depths.sort_by(|a, b| b.total_cmp(a));
    depths.get(depths.len().saturating_sub(1) / SUNK).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball whose centre is so far below the floor in each of ten frames.
    fn sinking(depths: [f64; 10]) -> Motion {
        let poses = depths.map(|depth| Isometry3::translation(0.0, -depth, 0.0));
        Motion {
            interval: 0.1,
            duration: 0.9,
            bodies: 1,
            poses: poses.to_vec(),
            bends: Vec::new(),
            work: Vec::new(),
            commands: None,
            placements: [Placement::new(0, Isometry3::identity(), Shape::Ball { radius: 0.01 })].into(),
        }
    }

    /// A quaternion and its negative are one rotation: solvers give either, and what lies between two frames must not turn the long way.
    #[test]
    fn between_two_frames_the_shorter_way_is_taken() {
        let turned = |degrees: f64| {
            let turn = UnitQuaternion::from_axis_angle(&nalgebra::Vector3::y_axis(), degrees.to_radians());
            Isometry3::from_parts([0.0; 3].into(), turn)
        };
        let (from, to) = (turned(115.0), turned(125.0));
        let negative =
            Isometry3::from_parts(to.translation, UnitQuaternion::new_unchecked(-to.rotation.into_inner()));
        for end in [to, negative] {
            for share in [0.0, 0.3, 0.5, 1.0] {
                let due = turned(115.0 + 10.0 * share);
                assert!(pose_between(&from, &end, share).rotation.angle_to(&due.rotation) < 1e-4);
            }
        }
    }

    #[test]
    fn what_sinks_for_a_while_is_deep_and_what_lands_hard_is_not() {
        assert_eq!(sinking([-0.01; 10]).depth(), 0.0);
        let mut landing = [-0.01; 10];
        landing[4] = 0.02;
        // One frame in ten is long enough, one in a hundred is not.
        assert_eq!(sinking(landing).depth(), 0.02);
        assert_eq!(sinking([0.005; 10]).depth(), 0.005);
        let mut long = sinking(landing);
        long.poses.extend((0..90).map(|_| Isometry3::translation(0.0, 0.01, 0.0)));
        long.duration = 9.9;
        assert_eq!(long.depth(), 0.0);
    }

    #[test]
    fn parts_that_flow_through_each_other_are_found() {
        let ball = || Placement::new(0, Isometry3::identity(), Shape::Ball { radius: 0.01 });
        let block = |at: f64| {
            let half = nalgebra::Vector3::new(0.03, 0.02, 0.02);
            Placement::new(1, Isometry3::translation(at, 0.0, 0.0), Shape::Box { half })
        };
        let pressed = |at: f64, way: f64| {
            let poses = (0..10).flat_map(|frame| {
                [Isometry3::identity(), Isometry3::translation(-way * f64::from(frame) / 9.0, 0.0, 0.0)]
            });
            Motion {
                bodies: 2,
                poses: poses.collect(),
                placements: [ball(), block(at)].into(),
                ..sinking([0.0; 10])
            }
        };
        // They touch, then the middle of the ball is 8 mm inside the block.
        assert_eq!(pressed(0.04, 0.009).interlocked(), 0.0);
        assert!((pressed(0.04, 0.018).interlocked() - 0.008).abs() < 1e-12);
        // What begins so is meant.
        assert_eq!(pressed(0.02, 0.01).interlocked(), 0.0);
    }

    #[test]
    fn a_ball_that_swells_on_the_ground_touches_it() {
        let mut swelling = sinking([-0.01; 10]);
        // It grows by 20 % and keeps its lowest point where it is.
        for (frame, pose) in swelling.poses.iter_mut().enumerate() {
            pose.translation.y = 0.01 * (1.0 + 0.02 * frame as f64);
        }
        swelling.bends = (0..10).map(|frame| 0.02 * f64::from(frame)).collect();
        assert!(swelling.sliding()[0].touching < 0.3, "without its strain it rises");
        let mut placements = swelling.placements.to_vec();
        placements[0].swells = vec![(0, 1.0)];
        swelling.placements = placements.into();
        assert!((swelling.sliding()[0].touching - 0.9).abs() < 1e-9);
        for t in [0.0, 0.25, 0.9] {
            assert!(swelling.lowest(0, t).unwrap().abs() < 1e-12, "{t}");
        }
    }
}
