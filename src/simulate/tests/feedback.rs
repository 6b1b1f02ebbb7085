//! What feedback must do, in every solver.

use std::sync::Mutex;

use nalgebra::Vector3;

use super::HINGED;
use super::bodies::{Builder, cube, fork, gait, hinge, m4};
use super::truth::{during, run};
use super::worlds::{bits, several};
use crate::design::assembly::{Assembly, Dof, JointKind, Travel};
use crate::simulate::{
    Case, ControlLoop, Controller, Invalid, Measured, Motion, Settings, Stop, Targets, World, model,
};

/// Plays targets as they will be a time after each moment, and keeps what it measured.
#[derive(Debug)]
struct Played<'a> {
    drive: &'a Targets,
    interval: f64,
    ahead: f64,
    /// The actuators that it leaves alone.
    but: Vec<usize>,
    seen: Mutex<Vec<(f64, Vec<f64>, f64)>>,
}

impl<'a> Played<'a> {
    fn new(drive: &'a Targets, interval: f64, ahead: f64) -> Self {
        Self { drive, interval, ahead, but: Vec::new(), seen: Mutex::default() }
    }
}

impl Controller for Played<'_> {
    fn interval(&self) -> f64 {
        self.interval
    }

    fn commands(&self, actuator: usize) -> bool {
        !self.but.contains(&actuator)
    }

    fn begin(&self) -> Box<dyn ControlLoop + '_> {
        Box::new(Playing(self))
    }
}

struct Playing<'a>(&'a Played<'a>);

impl ControlLoop for Playing<'_> {
    fn answer(&mut self, measured: &Measured<'_>, commands: &mut [f64]) -> Result<(), Invalid> {
        let Played { drive, ahead, ref seen, .. } = *self.0;
        for (actuator, command) in commands.iter_mut().enumerate() {
            *command = drive.at(actuator, measured.time + ahead);
        }
        let positions = (0..drive.actuators).map(|actuator| measured.position(actuator).unwrap()).collect();
        seen.lock().unwrap().push((measured.time, positions, measured.lowest(0).unwrap()));
        Ok(())
    }
}

fn nothing(actuators: usize) -> Targets {
    Targets { interval: 1.0, actuators, angles: vec![0.0; actuators] }
}

fn driven(
    name: &str,
    body: &Assembly,
    settings: &Settings,
    cases: &[Case<'_>],
) -> Vec<Result<Motion, Invalid>> {
    let mut simulation = model(name).unwrap().prepare(body, settings).unwrap();
    simulation.run_cases(Stop::NEVER, cases).unwrap()
}

/// A controller that asks in each step for what a drive asks for moves the body as the drive does, bit for bit; also where it commands
/// some of the actuators only.
#[test]
fn feedback_that_plays_a_drive_is_the_drive() {
    let (body, settings) = (m4(), during(2.0));
    let drive = gait(body.actuators, 5, false);
    let none = nothing(body.actuators);
    for name in HINGED {
        let want = bits(&run(name, &body, &settings, &drive));
        let all = Played::new(&drive, settings.step, settings.step);
        let some = Played { but: vec![1, 2], ..Played::new(&drive, settings.step, settings.step) };
        for (controller, ahead) in [(&all, &none), (&some, &drive)] {
            let case = Case { controller: Some(controller), ..Case::nominal(ahead) };
            let motion = driven(name, &body, &settings, &[case]).remove(0).unwrap();
            assert!(bits(&motion) == want, "{name}");
        }
    }
}

/// A controller is asked at its own interval from time zero on, whatever the step, and measures what the motion records then.
#[test]
fn control_moments_do_not_depend_on_the_step() {
    let body = fork();
    let drive = gait(body.actuators, 3, false);
    let none = nothing(body.actuators);
    for name in HINGED {
        for step in [1.0 / 240.0, 1.0 / 480.0, 1.0 / 250.0] {
            let settings = Settings { step, record: 0.05, ..during(1.0) };
            let controller = Played::new(&drive, 0.05, 0.0);
            let case = Case { controller: Some(&controller), ..Case::nominal(&none) };
            let motion = driven(name, &body, &settings, &[case]).remove(0).unwrap();
            let seen = controller.seen.into_inner().unwrap();
            assert_eq!(seen.len(), 20, "{name}");
            for (moment, (time, positions, lowest)) in seen.into_iter().enumerate() {
                let due = moment as f64 * 0.05;
                assert!((-1e-9..step).contains(&(time - due)), "{name}: {time} s");
                // Between steps the motion is interpolated.
                let close = if (time - due).abs() < 1e-9 { 1e-12 } else { 0.05 };
                let recorded = &motion.bends[moment * body.actuators..][..body.actuators];
                for (measured, recorded) in positions.iter().zip(recorded) {
                    assert!((measured - recorded).abs() < close, "{name}: {measured} and {recorded}");
                }
                assert!((lowest - motion.lowest(0, due).unwrap()).abs() < close, "{name}");
            }
        }
    }
}

/// A loop that asks for the opposite of where an actuator is: it depends on the body, and so differs from world to world.
#[derive(Debug)]
struct Contrary {
    gain: f64,
}

impl Controller for Contrary {
    fn interval(&self) -> f64 {
        1.0 / 60.0
    }

    fn commands(&self, _: usize) -> bool {
        true
    }

    fn begin(&self) -> Box<dyn ControlLoop + '_> {
        Box::new(Opposing { gain: self.gain, before: 0.0 })
    }
}

struct Opposing {
    gain: f64,
    before: f64,
}

impl ControlLoop for Opposing {
    fn answer(&mut self, measured: &Measured<'_>, commands: &mut [f64]) -> Result<(), Invalid> {
        let tilt = measured.pose(0).ok_or(Invalid::NoCommand)?.translation.vector.y - self.before;
        self.before += tilt;
        for (actuator, command) in commands.iter_mut().enumerate() {
            let wave = 0.5 * libm::sin(3.0 * measured.time + actuator as f64);
            *command = wave - self.gain * measured.position(actuator).ok_or(Invalid::NoCommand)? + 5.0 * tilt;
        }
        Ok(())
    }
}

/// Each lane has a loop of its own: together they do what each does alone, bit for bit.
#[test]
fn loops_do_not_see_each_other() {
    let (body, settings) = (m4(), during(2.0));
    let none = nothing(body.actuators);
    let controllers: Vec<Contrary> = (0..7).map(|n| Contrary { gain: 0.1 * n as f64 }).collect();
    let worlds = several(7);
    let cases: Vec<Case<'_>> = controllers
        .iter()
        .zip(&worlds)
        .map(|(controller, world)| Case { controller: Some(controller), ..Case::new(&none, world) })
        .collect();
    for name in HINGED {
        let together = driven(name, &body, &settings, &cases);
        for (case, motion) in cases.iter().zip(&together) {
            let alone = driven(name, &body, &settings, &[*case]).remove(0).unwrap();
            assert!(bits(motion.as_ref().unwrap()) == bits(&alone), "{name}");
        }
        assert_ne!(bits(together[0].as_ref().unwrap()), bits(together[1].as_ref().unwrap()));
    }
}

/// A loop that has no answer from a time on, or none that is a number.
#[derive(Debug)]
struct Lost(f64);

impl Controller for Lost {
    fn interval(&self) -> f64 {
        0.1
    }

    fn commands(&self, _: usize) -> bool {
        true
    }

    fn begin(&self) -> Box<dyn ControlLoop + '_> {
        Box::new(Losing(self.0))
    }
}

struct Losing(f64);

impl ControlLoop for Losing {
    fn answer(&mut self, measured: &Measured<'_>, commands: &mut [f64]) -> Result<(), Invalid> {
        if measured.time > 0.45 && self.0.is_finite() {
            return Err(Invalid::NoCommand);
        }
        commands.fill(if measured.time > 0.45 { self.0 } else { 0.1 });
        Ok(())
    }
}

/// What has no answer ends its own run, and no other.
#[test]
fn feedback_without_an_answer_ends_its_run() {
    let (body, settings) = (fork(), during(1.0));
    let (none, drive) = (nothing(body.actuators), gait(body.actuators, 3, false));
    let (silent, wrong) = (Lost(0.0), Lost(f64::NAN));
    for name in HINGED {
        let want = bits(&run(name, &body, &settings, &drive));
        let lost = |controller| Case { controller: Some(controller), ..Case::nominal(&none) };
        let cases = [lost(&silent), Case::new(&drive, &World::NOMINAL), lost(&wrong)];
        let motions = driven(name, &body, &settings, &cases);
        assert_eq!(motions[0].as_ref().unwrap_err(), &Invalid::NoCommand, "{name}");
        assert!(bits(motions[1].as_ref().unwrap()) == want, "{name}");
        assert_eq!(motions[2].as_ref().unwrap_err(), &Invalid::NotFinite, "{name}");
    }
}

/// What is measured of a moment: the load of each element, the velocity of each, and the position and rate of each actuator.
type Felt = (f64, Vec<f64>, Vec<Vector3<f64>>, Vec<Vector3<f64>>, Vec<(f64, f64)>);

/// Plays targets, and keeps all that can be measured.
#[derive(Debug)]
struct Probe<'a> {
    drive: &'a Targets,
    interval: f64,
    elements: usize,
    felt: Mutex<Vec<Felt>>,
}

impl Controller for Probe<'_> {
    fn interval(&self) -> f64 {
        self.interval
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
    fn answer(&mut self, measured: &Measured<'_>, commands: &mut [f64]) -> Result<(), Invalid> {
        let Probe { drive, elements, ref felt, .. } = *self.0;
        for (actuator, command) in commands.iter_mut().enumerate() {
            *command = drive.at(actuator, measured.time);
        }
        let all = 0..elements;
        let actuators = 0..drive.actuators;
        felt.lock().unwrap().push((
            measured.time,
            all.clone().map(|element| measured.load(element).unwrap()).collect(),
            all.clone().map(|element| measured.velocity(element).unwrap().0).collect(),
            all.map(|element| measured.pose(element).unwrap().translation.vector).collect(),
            actuators.map(|a| (measured.position(a).unwrap(), measured.rate(a).unwrap())).collect(),
        ));
        Ok(())
    }
}

fn felt(name: &str, body: &Assembly, settings: &Settings, drive: &Targets, world: &World) -> Vec<Felt> {
    felt_each(settings.step, name, body, settings, (drive, world))
}

/// The same at moments that are so many seconds apart.
fn felt_each(
    interval: f64,
    name: &str,
    body: &Assembly,
    settings: &Settings,
    (drive, world): (&Targets, &World),
) -> Vec<Felt> {
    let probe = Probe { drive, interval, elements: body.elements.len(), felt: Mutex::default() };
    let none = nothing(body.actuators);
    let case = Case { controller: Some(&probe), ..Case::new(&none, world) };
    driven(name, body, settings, &[case]).remove(0).unwrap();
    probe.felt.into_inner().unwrap()
}

/// The ground carries what a resting body weighs, on a slope the part of it that presses on the ground; in free fall nothing.
#[test]
fn the_ground_carries_the_weight() {
    let (body, settings) = (m4(), during(1.5));
    let mass: f64 = body.elements.iter().map(|element| element.mass).sum();
    for name in HINGED {
        for slope in [0.0, 0.3] {
            let world = World { slope, ..World::NOMINAL };
            let moments = felt(name, &body, &settings, &nothing(body.actuators), &world);
            // Also before anything moves.
            let first: f64 = moments[0].1.iter().sum();
            let whole = mass * settings.gravity * libm::cos(slope);
            assert!((first / whole - 1.0).abs() < 0.05, "{name}, {slope}: {first} of {whole}");
            let last = &moments[moments.len() - 60..];
            let carried: f64 =
                last.iter().map(|(_, loads, ..)| loads.iter().sum::<f64>()).sum::<f64>() / last.len() as f64;
            let weight = mass * settings.gravity * libm::cos(slope);
            assert!((carried / weight - 1.0).abs() < 0.01, "{name}, {slope}: {carried} of {weight}");
        }
        let weightless = Settings { gravity: 0.0, ..settings.clone() };
        let moments = felt(name, &body, &weightless, &nothing(body.actuators), &World::NOMINAL);
        let most = moments.iter().flat_map(|(_, loads, ..)| loads).fold(0.0, |a: f64, b| a.max(*b));
        assert!(most < 1e-3 * mass * 9.81, "{name}: {most}");
    }
}

/// Three blocks in a row, whose joints do not give way vertically, share their weight: which of them is the root is of no account. Otherwise
/// a worm of blocks that push each other forward, one after the other, stays where it is.
#[test]
fn a_rigid_row_shares_its_weight() {
    let mut body = Builder::default();
    body.0.actuators = 2;
    let blocks: Vec<usize> = (0..3).map(|i| body.add(cube(Vector3::x() * (0.1 * f64::from(i))))).collect();
    for (number, pair) in blocks.windows(2).enumerate() {
        let at = Vector3::x() * (0.1 * number as f64 + 0.05);
        let slide =
            Dof { travel: Travel::Slide, stiffness: 500.0, damping: 10.0, ..hinge(at, Vector3::x(), number) };
        body.join(pair[0], pair[1], JointKind::Dof(slide));
    }
    let (body, settings) = (body.0, during(1.5));
    let weight = body.elements[0].mass * settings.gravity;
    for name in ["articulated", "rapier", "rod"] {
        let moments = felt(name, &body, &settings, &nothing(2), &World::NOMINAL);
        let loads = &moments.last().unwrap().1;
        assert!(
            loads.iter().all(|load| (load / weight - 1.0).abs() < 0.1),
            "{name}: {loads:?}, not {weight}"
        );
    }
}

/// Velocities and rates are those with which places and positions changed since the moment before: also of commands that change now and then,
/// after which all that moves is soon slower again.
#[test]
fn velocities_are_those_of_the_motion() {
    let (body, settings) = (m4(), during(1.0));
    let drive = gait(body.actuators, 4, false);
    for (name, interval) in HINGED.into_iter().flat_map(|name| [(name, 1.0 / 60.0), (name, 1.0 / 20.0)]) {
        let moments = felt_each(interval, name, &body, &settings, (&drive, &World::NOMINAL));
        let (mut off, mut rate_off, mut fastest) = (0.0_f64, 0.0_f64, 0.0_f64);
        for pair in moments.windows(2) {
            let [before, now] = pair else { unreachable!() };
            let took = now.0 - before.0;
            for element in 0..body.elements.len() {
                let moved = (now.3[element] - before.3[element]) / took;
                off = off.max((moved - now.2[element]).norm());
                fastest = fastest.max(moved.norm());
            }
            for actuator in 0..body.actuators {
                let moved = (now.4[actuator].0 - before.4[actuator].0) / took;
                rate_off = rate_off.max((moved - now.4[actuator].1).abs());
            }
        }
        assert!(fastest > 0.1, "{name}: {fastest}");
        assert!(off < 1e-9 && rate_off < 1e-9, "{name}, {interval}: {off}, {rate_off}");
    }
}
