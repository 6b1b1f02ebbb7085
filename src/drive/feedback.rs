//! Actuations that react: what actuators are asked for as the body moves, from what sensors read and states remember.
//!
//! At each control moment all sensors are read first, then each actuator's values and what it is asked for are found from the readings
//! and from the states, its own and those of the robot; then all states move on. The readings of a moment are kept: a late sensor gives an earlier one.

use std::sync::atomic::AtomicU64;

use grammar_lang::eval::{EvalError, Reference, Scope, Value, evaluate, evaluate_number};
use grammar_lang::ir::{
    Attribute, ElementAttribute, Group, JointKind, MotionWord, Sensor, Track, Ty, Word, felt_by,
};

use super::conditions::Conditions;
use super::hardware::Limit;
use super::policies::Answer;
use super::remembered::Remembered;
use super::signals::Signal;
use super::{Drive, Parameters, passive};
use crate::derive::random::Stream;
use crate::derive::{Candidate, DesignScope};
use crate::design::PartId;
use crate::simulate::{Case, ControlLoop, Controller, Invalid, Measured, Snapshot, Targets, World};

/// What drives a body: targets as far as they are known ahead, and what commands the other actuators.
#[derive(Clone, Debug)]
pub struct ControlLaw<'r> {
    /// What the actuators are asked for; zero for those whose actuation reacts.
    pub targets: Targets,
    feedback: Option<Reaction<'r>>,
}

impl<'r> ControlLaw<'r> {
    /// What drives a body with these values under these conditions.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when an expression of the actuation has no value.
    pub(super) fn new(
        drive: &Drive<'r>,
        parameters: &[f64],
        conditions: &Conditions,
    ) -> Result<Self, EvalError> {
        let targets = drive.targets_under(parameters, conditions)?;
        let reacts = drive.actuators.iter().any(|driven| drive.reacts(driven));
        let feedback = reacts.then(|| Reaction::new(drive, parameters, conditions)).transpose()?;
        Ok(Self { targets, feedback })
    }

    /// What holds all actuators where they begin, and motors still.
    #[must_use]
    pub fn holding(drive: &Drive<'r>) -> Self {
        let place = |driven| {
            let made = drive.made(driven).filter(|made| made.joint.kind != JointKind::Spin);
            made.map_or(0.0, |made| made.joint.start())
        };
        let row: Vec<f64> = drive.actuators.iter().map(place).collect();
        let angles = [row.as_slice(), row.as_slice()].concat();
        let targets = Targets { interval: drive.task().model.control, actuators: row.len(), angles };
        Self { targets, feedback: None }
    }

    /// The motion that it makes in a world.
    #[must_use]
    pub fn case<'a>(&'a self, world: &'a World) -> Case<'a> {
        let controller = self.feedback.as_ref().map(|feedback| feedback as &dyn Controller);
        Case { controller, ..Case::new(&self.targets, world) }
    }

    /// Why what reacts has no value in the first control moments, if it has none: in so many where only states are read. What sensors
    /// read is known in the first one alone, in which the body is at rest.
    pub(super) fn fails_at_first(&self, moments: usize) -> Option<EvalError> {
        let feedback = self.feedback.as_ref()?;
        let moments = if feedback.sensors.is_empty() { moments } else { 1 };
        let rest = Snapshot::at_rest(&feedback.drive.candidate.body.assembly);
        let rest = rest.measured();
        let mut running = feedback.run();
        (0..moments).find_map(|_| running.moment(&rest).err())
    }

    /// Whether an actuation reacts, so that what actuators are asked for is not known before the motion is.
    #[must_use]
    pub fn is_closed_loop(&self) -> bool {
        self.feedback.is_some()
    }
}

/// A sensor of the robot, or of one of its parts.
#[derive(Clone, Debug)]
struct Fitted<'r> {
    name: &'r str,
    sensor: &'r Sensor,
    /// Whose it is.
    of: Option<PartId>,
}

/// The feedback controller of a body: what its actuations make of what its sensors read.
#[derive(Clone, Debug)]
pub(super) struct Reaction<'r> {
    pub(super) drive: Drive<'r>,
    conditions: Conditions,
    sensors: Vec<Fitted<'r>>,
    /// The states of the robot and of its parts, as they begin.
    states: Vec<Remembered<'r>>,
    /// By actuator: its locals with the states as they begin, where its actuation reacts.
    begun: Vec<Option<Vec<Value>>>,
    /// The values of what the search varies, the weights of policies among them.
    parameters: Parameters,
}

impl<'r> Reaction<'r> {
    pub(super) fn new(
        drive: &Drive<'r>,
        parameters: &[f64],
        conditions: &Conditions,
    ) -> Result<Self, EvalError> {
        let begun = drive
            .actuators
            .iter()
            .map(|driven| drive.reacts(driven).then(|| drive.lets(driven, parameters)).transpose());
        let begun = begun.collect::<Result<_, _>>()?;
        let (sensors, states) = felt(drive, parameters)?;
        Ok(Self {
            begun,
            sensors,
            states,
            conditions: conditions.clone(),
            drive: drive.clone(),
            parameters: parameters.to_vec(),
        })
    }
}

/// The sensors and states that the actuations of a body read, in the order of the grammar and of the parts of the body.
fn felt<'r>(
    drive: &Drive<'r>,
    parameters: &[f64],
) -> Result<(Vec<Fitted<'r>>, Vec<Remembered<'r>>), EvalError> {
    let rules = drive.candidate.rules;
    let values = drive.actuations.iter().flat_map(|(_, actuation)| actuation.values_with(&rules.policies));
    let read = felt_by(values, &rules.states);
    // The robot has one, or each of its parts of a kind.
    let owners = |of: &Option<Group>| match of {
        None => vec![None],
        Some(group) => parts_of(drive, group).into_iter().map(Some).collect(),
    };
    let mut sensors = Vec::new();
    for (name, sensor) in rules.sensors.iter().filter(|(name, _)| read.contains_key(*name)) {
        sensors.extend(owners(&sensor.of).into_iter().map(|of| Fitted { name, sensor, of }));
    }
    let mut states = Vec::new();
    for (name, state) in rules.states.iter().filter(|(name, _)| read.contains_key(*name)) {
        for of in owners(&state.of) {
            states.push(Remembered::new(drive, (name, state), of, parameters)?);
        }
    }
    Ok((sensors, states))
}

/// The parts of a group, in the order of the body.
fn parts_of(drive: &Drive<'_>, group: &Group) -> Vec<PartId> {
    let Candidate { rules, derivation, body } = &drive.candidate;
    let scope = DesignScope::new(rules, derivation);
    let mut parts: Vec<PartId> = Vec::new();
    for part in &body.parts_of_elements {
        let is_one = scope.belongs(&Value::Reference(Reference::Part(*part)), group) == Some(true);
        if is_one && !parts.contains(part) {
            parts.push(*part);
        }
    }
    parts
}

impl Controller for Reaction<'_> {
    fn interval(&self) -> f64 {
        self.drive.task.model.control
    }

    fn commands(&self, actuator: usize) -> bool {
        self.begun.get(actuator).is_some_and(Option::is_some)
    }

    fn begin(&self) -> Box<dyn ControlLoop + '_> {
        Box::new(self.run())
    }
}

impl Reaction<'_> {
    /// What can be kept of a control moment: what sensors read, what the robot and its parts remember, what actuators remember, and
    /// what they are asked for.
    pub(super) fn signals(&self) -> Vec<Signal> {
        let drive = &self.drive;
        let signal = |name: &str, of, ty: &Ty| Signal { name: name.to_owned(), of, ty: ty.clone() };
        let sensors = self.sensors.iter().map(|fitted| signal(fitted.name, fitted.of, &fitted.sensor.ty));
        let states = self.states.iter().map(|state| signal(state.name, state.of, state.ty()));
        let reacting = drive.actuators.iter().zip(&self.begun).filter(|(_, begun)| begun.is_some());
        let reacting =
            reacting.filter_map(|(driven, _)| Some((driven.id, drive.actuations.get(driven.actuation)?.1)));
        let own = reacting.clone().flat_map(|(id, actuation)| {
            actuation.states.iter().map(move |state| signal(&state.name, Some(id), &state.ty))
        });
        let asked = reacting.map(|(id, actuation)| signal("", Some(id), &actuation.drive.ty));
        sensors.chain(states).chain(own).chain(asked).collect()
    }

    /// A run from rest.
    pub(super) fn run(&self) -> Running<'_> {
        // Named by what they are of, so that all candidates hear the same noise in a world.
        let world = &self.conditions.world;
        let noise = |(place, fitted): (usize, &Fitted<'_>)| {
            let before = self.sensors.iter().take(place).filter(|other| other.name == fitted.name).count();
            Stream::named(0, &format!("noise of {} {before} in {world}", fitted.name))
        };
        let limit = |driven| self.drive.limit(driven, self.conditions.speed, self.interval());
        Running {
            feedback: self,
            noise: self.sensors.iter().enumerate().map(noise).collect(),
            readings: vec![Vec::new(); self.sensors.len()],
            remembered: self.states.iter().map(|state| state.begun.clone()).collect(),
            locals: self.begun.clone(),
            limits: self.drive.actuators.iter().map(limit).collect(),
            commands: vec![Vec::new(); self.drive.actuators.len()],
            moment: 0,
        }
    }
}

/// The controller in one run.
pub(super) struct Running<'a> {
    feedback: &'a Reaction<'a>,
    /// By sensor.
    noise: Vec<Stream>,
    /// By sensor, what it measured at each control moment so far.
    readings: Vec<Vec<Option<Value>>>,
    /// What the robot and its parts remember.
    remembered: Vec<Value>,
    /// By actuator: the locals of the moment, up to the values that do not change.
    locals: Vec<Option<Vec<Value>>>,
    /// By actuator, what its hardware makes of what it is asked for.
    limits: Vec<Limit<'a>>,
    /// By actuator, what it was asked for at each control moment so far.
    commands: Vec<Vec<f64>>,
    /// How many control moments there were.
    moment: usize,
}

impl Running<'_> {
    /// So many control moments take at least so long, s.
    fn moments(&self, time: f64) -> usize {
        libm::ceil(time / self.feedback.interval() - 1e-9).max(0.0) as usize
    }

    /// Reads all sensors.
    fn measure(&mut self, measured: &Measured<'_>) {
        let drive = &self.feedback.drive;
        let scope = FeltScope::new(drive, measured);
        for ((fitted, noise), readings) in
            self.feedback.sensors.iter().zip(&mut self.noise).zip(&mut self.readings)
        {
            let part = fitted.of.map(|part| Value::Reference(Reference::Part(part)));
            // What has no value here matters only where it is read: the angle of a wheel.
            let exact = evaluate(&fitted.sensor.value, &scope, &mut part.into_iter().collect()).ok();
            let scatter = fitted.sensor.noise;
            readings.push(match exact {
                Some(Value::Bool(yes)) => Some(Value::Bool(yes != (noise.unit() < scatter))),
                Some(Value::Number(x)) if scatter > 0.0 => Some(Value::Number(noise.normal(x, scatter))),
                exact => exact,
            });
        }
    }

    /// What a sensor gives now, of what it has measured so far.
    fn reading(&self, fitted: &Fitted<'_>, readings: &[Option<Value>]) -> Option<Value> {
        let now = readings.len().checked_sub(1)?;
        let late = self.moments(fitted.sensor.delay);
        readings.get(now.saturating_sub(late))?.clone()
    }

    /// The same as [`Self::moment`]; what the signals of the moment are, as [`Reaction::signals`] names them.
    pub(super) fn traced(&mut self, measured: &Measured<'_>) -> Result<Vec<Option<Value>>, EvalError> {
        let feedback = self.feedback;
        let Reaction { drive, parameters, .. } = feedback;
        self.measure(measured);
        let sensors = feedback.sensors.iter().zip(&self.readings);
        let mut row: Vec<Option<Value>> =
            sensors.map(|(fitted, readings)| self.reading(fitted, readings)).collect();
        row.extend(self.remembered.iter().cloned().map(Some));
        for (driven, locals) in drive.actuators.iter().zip(&self.locals) {
            let Some((locals, (_, actuation))) = locals.as_ref().zip(drive.actuations.get(driven.actuation))
            else {
                continue;
            };
            let first = actuation.first_state();
            row.extend((first..first + actuation.states.len()).map(|slot| locals.get(slot).cloned()));
        }
        self.decide(&mut |query, known| drive.answer(parameters, query.policy, known))?;
        self.moment += 1;
        let asked = self.commands.iter().zip(&feedback.begun).filter(|(_, begun)| begun.is_some());
        row.extend(asked.map(|(commands, _)| commands.last().copied().map(Value::Number)));
        Ok(row)
    }

    /// Reads all sensors, and finds what each actuator is asked for.
    fn moment(&mut self, measured: &Measured<'_>) -> Result<(), EvalError> {
        let Reaction { drive, parameters, .. } = self.feedback;
        self.moment_by(measured, &mut |query, known| drive.answer(parameters, query.policy, known))
    }

    /// The same with what something else answers in the place of the networks.
    pub(super) fn moment_by(
        &mut self,
        measured: &Measured<'_>,
        answer: &mut Answer<'_>,
    ) -> Result<(), EvalError> {
        self.measure(measured);
        self.decide(answer)?;
        self.moment += 1;
        Ok(())
    }

    /// Finds what each actuator is asked for, and moves its states on.
    fn decide(&mut self, answer: &mut Answer<'_>) -> Result<(), EvalError> {
        let feedback = self.feedback;
        let drive = &feedback.drive;
        let sensors = feedback.sensors.iter().zip(&self.readings);
        let sensors = sensors.filter_map(|(fitted, readings)| {
            Some(((fitted.name, fitted.of), self.reading(fitted, readings)?))
        });
        let remembered = feedback.states.iter().zip(&self.remembered);
        let remembered = remembered.map(|(state, value)| ((state.name, state.of), value.clone()));
        let felt = sensors.chain(remembered).collect();
        let mut scope = drive.scope();
        scope.time = self.moment as f64 * feedback.interval();
        scope.felt = felt;
        drive.decide(self.moment, &scope, &mut self.locals, answer)?;
        for (place, driven) in drive.actuators.iter().enumerate() {
            let Some(locals) = self.locals.get_mut(place).and_then(Option::as_mut) else { continue };
            let Some((_, actuation)) = drive.actuations.get(driven.actuation) else { continue };
            let fixed = locals.len();
            for (_, value) in &actuation.moving {
                let value = evaluate(value, &scope, locals)?;
                locals.push(value);
            }
            let (low, high) = drive.driven_range(driven);
            let asked = evaluate_number(&actuation.drive, &scope, locals)?.max(low).min(high);
            let next: Result<Vec<Value>, _> =
                actuation.states.iter().map(|state| evaluate(&state.next, &scope, locals)).collect();
            locals.truncate(fixed);
            let first = actuation.first_state();
            for (slot, value) in locals.iter_mut().skip(first).zip(next?) {
                *slot = value;
            }
            if let (Some(limit), Some(commands)) = (self.limits.get_mut(place), self.commands.get_mut(place))
            {
                commands.push(limit.reach(asked));
            }
        }
        let next: Result<_, _> = feedback.states.iter().map(|state| state.next(&scope)).collect();
        self.remembered = next?;
        Ok(())
    }
}

impl Running<'_> {
    /// What each actuator is asked for now.
    pub(super) fn write(&self, commands: &mut [f64]) {
        for (actuator, (command, own)) in commands.iter_mut().zip(&self.commands).enumerate() {
            // A late actuator begins with what it is asked for first, and does the rest later.
            let late = self.moments(self.feedback.conditions.late(actuator));
            if let Some(now) = own.len().checked_sub(1) {
                *command = own.get(now.saturating_sub(late)).copied().unwrap_or(0.0);
            }
        }
    }
}

impl ControlLoop for Running<'_> {
    fn answer(&mut self, measured: &Measured<'_>, commands: &mut [f64]) -> Result<(), Invalid> {
        self.moment(measured).map_err(|_| Invalid::NoCommand)?;
        self.write(commands);
        Ok(())
    }
}

/// What a sensor reads: the design, and what is so now.
pub(super) struct FeltScope<'a> {
    design: DesignScope<'a>,
    drive: &'a Drive<'a>,
    measured: &'a Measured<'a>,
}

impl<'a> FeltScope<'a> {
    pub(super) fn new(drive: &'a Drive<'a>, measured: &'a Measured<'a>) -> Self {
        let design = DesignScope::new(drive.candidate.rules, &drive.candidate.derivation);
        Self { design, drive, measured }
    }

    /// The element that stands for a thing: itself, or the first one of a part.
    fn element(&self, of: Reference) -> Option<usize> {
        match of {
            Reference::Element(element) => Some(element as usize),
            Reference::Part(part) => self.drive.candidate.body.elements_of(part).next(),
            _ => None,
        }
    }

    /// What is measured of the joints of an actuator, or of the passive joints of a part.
    fn of_joints(&self, of: Reference, track: Track) -> Option<f64> {
        let Reference::Part(part) = of else { return None };
        let Some(place) = self.drive.actuators.iter().position(|driven| driven.id == part) else {
            return passive::measured(&self.drive.candidate, part, track, self.measured);
        };
        let joint = self.drive.made(self.drive.actuators.get(place)?)?.joint.kind;
        match track {
            _ if !track.is_of(joint) => None,
            Track::AngleRate | Track::DistanceRate => self.measured.rate(place),
            _ => self.measured.position(place),
        }
    }
}

impl Scope for FeltScope<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(&self.design)
    }

    fn left(&self) -> Option<&AtomicU64> {
        self.drive.left.as_deref()
    }

    fn word(&self, word: Word) -> Option<Value> {
        match word {
            Word::Now => Some(Value::Number(self.measured.time)),
            Word::Motion(MotionWord::Elements) => {
                let count = self.drive.candidate.body.assembly.elements.len() as u32;
                Some(Value::List((0..count).map(|i| Value::Reference(Reference::Element(i))).collect()))
            }
            _ => self.design.word(word),
        }
    }

    fn attribute(&self, of: Reference, attribute: &Attribute) -> Option<Value> {
        match (attribute, of) {
            (Attribute::Element(ElementAttribute::Part), Reference::Element(element)) => {
                let part = self.drive.candidate.body.parts_of_elements.get(element as usize)?;
                Some(Value::Reference(Reference::Part(*part)))
            }
            (Attribute::Element(ElementAttribute::Size), Reference::Element(element)) => {
                self.measured.size(element as usize).map(Value::Number)
            }
            _ => self.design.attribute(of, attribute),
        }
    }

    fn track(&self, of: Reference, track: Track, _: f64) -> Option<Value> {
        let measured = self.measured;
        let vector = |v: nalgebra::Vector3<f64>| Value::Vector([v.x, v.y, v.z]);
        let number = |x: f64| Value::Number(x);
        match track {
            Track::Position => Some(vector(measured.pose(self.element(of)?)?.translation.vector)),
            Track::Rotation => {
                let element = self.element(of)?;
                let rest = self.drive.candidate.lies(element)?;
                let r = (measured.pose(element)?.rotation * rest.inverse()).into_inner();
                Some(Value::Rotation([r.w, r.i, r.j, r.k]))
            }
            Track::Lowest => measured.lowest(self.element(of)?).map(number),
            Track::Velocity => measured.velocity(self.element(of)?).map(|(velocity, _)| vector(velocity)),
            Track::AngularVelocity => measured.velocity(self.element(of)?).map(|(_, spin)| vector(spin)),
            Track::Load => match of {
                Reference::Part(part) => {
                    let elements = self.drive.candidate.body.elements_of(part);
                    let loads: Option<Vec<f64>> = elements.map(|element| measured.load(element)).collect();
                    loads.map(|loads| Value::Number(loads.iter().sum()))
                }
                of => measured.load(self.element(of)?).map(number),
            },
            Track::Angle | Track::Distance | Track::Speed | Track::AngleRate | Track::DistanceRate => {
                self.of_joints(of, track).map(number)
            }
        }
    }
}
