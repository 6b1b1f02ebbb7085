//! What feedback must do, in every solver.

use std::sync::Mutex;

use super::HINGED;
use super::bodies::{fork, gait, m4};
use super::truth::{during, run};
use super::worlds::{bits, several};
use crate::design::assembly::Assembly;
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
