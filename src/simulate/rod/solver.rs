//! The body as discs, blocks and links, and its steps.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};

use super::block::{Rows, zeros};
use super::contacts::{self, Contact, Drive, Law, Spot, WAYS};
use super::discs::{Beam, Discs, Link as From, Part};
use super::factor::{TreeFactor, TreeMatrix};
use super::ground::{Near, Sole};
use super::links::{Action, ActiveSet, EndState, Link, Place, Work};
use super::touches::Touches;
use super::turns;
use crate::simulate::lowering::{self, Lowered, Piece};
use crate::simulate::run::Stepper;
use crate::simulate::{Invalid, Settings, Unfit, World};

/// A gap in m below which a point is looked at even when all is still.
const MARGIN: f64 = 5e-4;
/// Energy that may come from nowhere, as a height in m to which it lifts the whole body.
const ALLOWED: f64 = 0.0025;
/// So many steps one after the other may turn a body too far.
const WHIRLS: usize = 12;

/// What a joint of the assembly reads.
#[derive(Clone, Copy, Debug)]
enum Reading {
    /// Its share of the bend of a beam: the beam, and of how many hinges one.
    OfBeam { beam: usize, hinges: usize },
    /// A link.
    OfLink { link: usize },
}

/// A part of a segment: its body, where its middle is in the frame of that, m, and its share of the segment.
type Lump = (usize, Vector3<f64>, f64);

/// How a body moves, as what stays without forces.
#[derive(Clone, Copy, Debug)]
struct Momentum {
    /// kg m/s.
    linear: Vector3<f64>,
    /// About the centre, kg m^2/s.
    angular: Vector3<f64>,
}

/// One body of the refined assembly.
#[derive(Clone, Debug)]
struct Body {
    mass: f64,
    /// In its own frame, kg m^2.
    inertia: Matrix3<f64>,
    /// Radius of a ball about its centre that holds it, m.
    reach: f64,
}

/// The solver.
#[derive(Clone, Debug)]
pub(super) struct Rods {
    settings: Settings,
    /// m/s^2.
    gravity: Vector3<f64>,
    bodies: Vec<Body>,
    rest: Vec<Place>,
    links: Vec<Link>,
    pieces: Vec<Piece>,
    soles: Vec<Sole>,
    touches: Option<Touches>,
    /// Whether there is a ground: tests take it away.
    is_grounded: bool,
    readings: Vec<Reading>,
    /// The links of each beam.
    beams: Vec<Vec<usize>>,
    /// The pieces that each element has a part of, and which share of them.
    parts: Vec<Vec<(usize, f64)>>,
    /// What each segment consists of, after the body in its middle: bodies, places in their frames, shares.
    segments: Vec<(usize, Vec<Lump>)>,

    places: Vec<Place>,
    momenta: Vec<Momentum>,
    /// How many steps came before.
    age: u32,
    targets: Vec<f64>,
    actions: Vec<Action>,
    /// The positive work that the drive of each link has done, J.
    work: Vec<f64>,
    /// What all drives may have added to the energy so far, J.
    added: f64,
    /// Of each link, whether its motor gave all it has in the last step, and which ends of its range it was at.
    known: Vec<ActiveSet>,
    /// Impulses of each link in the last step, N m s or N s: of its drive, and of the two ends of its range.
    pushes: Vec<[f64; 3]>,
    /// Impulses of contacts in the last step by number, N s.
    remembered: Vec<Vector3<f64>>,
    matrix: TreeMatrix,
    factor: TreeFactor,
    /// Where contacts and drives put their rows while they are made: zeros between.
    room: (Vec<Rows<WAYS>>, Vec<Rows<1>>),
    /// The vectors of this processor.
    level: Level,
    /// The lowest balance of energy and work so far, J.
    lowest: f64,
    /// How much energy may come from nowhere, J.
    allowed: f64,
    /// kg.
    mass: f64,
    whirled: usize,
    failure: Option<Invalid>,
}

impl Rods {
    /// A refined assembly on the ground of a world, as lowered before and after it was refined.
    pub(super) fn new(
        discs: &Discs,
        (whole, lowered): (&Lowered, &Lowered),
        stiffer: f64,
        settings: &Settings,
        world: &World,
    ) -> Result<Self, Unfit> {
        if whole.bodies.iter().any(lowering::Body::is_massless) {
            let reason =
                "a part is attached by a socket, which rods do not support; use the solver `articulated`";
            return Err(Unfit { reason: reason.to_owned() });
        }
        let mut bodies: Vec<Body> = lowered
            .bodies
            .iter()
            .map(|body| Body { mass: body.mass, inertia: body.inertia, reach: 0.0 })
            .collect();
        for piece in &lowered.pieces {
            let reach = piece.local.translation.vector.norm() + piece.shape.reach();
            let own = &mut bodies[piece.body].reach;
            *own = own.max(reach);
        }
        let still = |body: &lowering::Body| Place {
            centre: body.centre,
            turn: UnitQuaternion::identity(),
            velocity: Vector3::zeros(),
            spin: Vector3::zeros(),
        };
        let rest: Vec<Place> = lowered.bodies.iter().map(still).collect();
        let links = links(discs, whole, lowered, stiffer);
        let is_slice =
            |piece: usize| discs.beams.iter().any(|beam| beam.discs[1..beam.links()].contains(&piece));
        let (mut soles, mut slots) = (Vec::new(), 0);
        for (number, piece) in lowered.pieces.iter().enumerate() {
            let sole = Sole::new(piece, is_slice(number), slots);
            slots += sole.slots();
            soles.push(sole);
        }
        let mass: f64 = bodies.iter().map(|body| body.mass).sum();
        let touches = settings.self_collision.then(|| Touches::new(discs, lowered));
        let parents: Vec<usize> = lowered.bodies.iter().map(|body| body.parent).collect();
        let matrix = TreeMatrix::new(parents);
        let count = bodies.len();
        let mut parts: Vec<Vec<(usize, f64)>> =
            discs.of_element.iter().map(|piece| vec![(*piece, 1.0)]).collect();
        for beam in &discs.beams {
            for (number, segment) in beam.segments.iter().enumerate() {
                parts[*segment] = beam.parts(number).iter().map(|part| (part.disc, part.of_disc)).collect();
            }
        }
        let mut own = Self {
            settings: settings.clone(),
            gravity: world.gravity(settings),
            remembered: vec![Vector3::zeros(); slots + touches.as_ref().map_or(0, Touches::len)],
            readings: readings(discs, whole, lowered, &links),
            beams: (0..discs.beams.len())
                .map(|beam| {
                    let pieces = &discs.beams[beam].discs[1..];
                    let of_beam =
                        |link: &Link| pieces.iter().any(|disc| lowered.pieces[*disc].body == link.body);
                    (0..links.len())
                        .filter(|link| links[*link].is_elastic() && of_beam(&links[*link]))
                        .collect()
                })
                .collect(),
            parts,
            segments: segments(discs, lowered),
            bodies,
            places: rest.clone(),
            rest,
            work: vec![0.0; links.len()],
            added: 0.0,
            known: vec![ActiveSet::default(); links.len()],
            pushes: vec![[0.0; 3]; links.len()],
            links,
            pieces: lowered.pieces.clone(),
            soles,
            touches,
            is_grounded: true,
            momenta: Vec::with_capacity(count),
            age: 0,
            targets: vec![0.0; whole.servos.len()],
            actions: Vec::new(),
            factor: TreeFactor::new(&matrix),
            matrix,
            room: (vec![zeros(); count], vec![zeros(); count]),
            level: Level::new(),
            lowest: f64::MAX,
            // Without weight a body may still spin: as much as on earth.
            allowed: mass * settings.gravity.max(9.81) * ALLOWED,
            mass,
            whirled: 0,
            failure: None,
        };
        own.begin();
        Ok(own)
    }

    fn begin(&mut self) {
        let still = Momentum { linear: Vector3::zeros(), angular: Vector3::zeros() };
        self.places.clone_from(&self.rest);
        self.momenta.clear();
        self.momenta.resize(self.bodies.len(), still);
        self.age = 0;
        self.targets.fill(0.0);
        self.work.fill(0.0);
        self.added = 0.0;
        self.known.fill(ActiveSet::default());
        self.pushes.fill([0.0; 3]);
        self.remembered.fill(Vector3::zeros());
        self.actions.clear();
        for link in &self.links {
            let (parent, body) = (&self.places[link.parent], &self.places[link.body]);
            self.actions.push(link.act((parent, body), (0.0, 0.0), ActiveSet::default(), self.settings.step));
        }
        (self.lowest, self.whirled, self.failure) = (f64::MAX, 0, None);
    }

    /// What a link is asked for.
    fn target(&self, link: &Link) -> f64 {
        self.targets.get(link.servo).map_or(0.0, |target| target * link.share)
    }

    /// The inertia of a body in the axes of the world, kg m^2.
    #[inline(always)]
    fn inertia(&self, body: usize) -> Matrix3<f64> {
        let turn = self.places[body].turn.to_rotation_matrix();
        turn.matrix() * self.bodies[body].inertia * turn.matrix().transpose()
    }

    /// Fills the matrix of a step, and finds its right side: momenta with the impulses of weight and springs.
    #[inline(always)]
    fn gather(&mut self) -> Vec<[f64; 6]> {
        let step = self.settings.step;
        self.matrix.clear();
        let mut right = Vec::with_capacity(self.bodies.len());
        for (number, body) in self.bodies.iter().enumerate() {
            let inertia = self.inertia(number);
            let own = &mut self.matrix.own[number];
            own.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * body.mass));
            own.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
            let momentum = &self.momenta[number];
            let linear = momentum.linear + self.gravity * (body.mass * step);
            let angular = momentum.angular;
            right.push([linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]);
        }
        for number in 0..self.links.len() {
            let link = &self.links[number];
            let (parent, body) = (&self.places[link.parent], &self.places[link.body]);
            let before = self.actions[number].deformation[link.driven()];
            let asked = (self.target(link), before);
            let action = link.act((parent, body), asked, self.known[number], step);
            let [on_body, on_parent, between] = action.matrices(parent, body, step);
            self.matrix.own[link.body] += on_body;
            self.matrix.own[link.parent] += on_parent;
            self.matrix.coupling[link.body] += between;
            let [to_body, to_parent] = action.impulses(parent, body, step);
            for (number, impulses) in [(link.body, to_body), (link.parent, to_parent)] {
                right[number].iter_mut().zip(&impulses).for_each(|(value, impulse)| *value += impulse);
            }
            self.actions[number] = action;
        }
        right
    }

    /// Where bodies may touch the ground or each other in the step.
    fn spots(&self) -> Vec<Spot> {
        let step = self.settings.step;
        let fall = self.gravity.norm() * step * step;
        let margins: Vec<f64> = self
            .places
            .iter()
            .zip(&self.bodies)
            .map(|(place, body)| {
                MARGIN + fall + 2.0 * step * (place.velocity.norm() + place.spin.norm() * body.reach)
            })
            .collect();
        let mut spots = Vec::new();
        if self.is_grounded {
            for (sole, piece) in self.soles.iter().zip(&self.pieces) {
                sole.find(
                    &self.places[piece.body],
                    margins[piece.body],
                    &mut |Near { body, point, slot }| {
                        spots.push(Spot {
                            body,
                            other: None,
                            point,
                            normal: Vector3::y(),
                            gap: point.y,
                            friction: World::NOMINAL.grip(piece.friction, &self.settings),
                            slot,
                        });
                    },
                );
            }
        }
        if let Some(touches) = &self.touches {
            let of_piece: Vec<f64> = self.pieces.iter().map(|piece| margins[piece.body]).collect();
            let first = self.remembered.len() - touches.len();
            touches.find(&self.pieces, &self.places, &of_piece, &mut |meeting| {
                let (a, b) = meeting.pieces;
                spots.push(Spot {
                    body: meeting.bodies.0,
                    other: Some(meeting.bodies.1),
                    point: meeting.point,
                    normal: meeting.normal,
                    gap: meeting.gap,
                    friction: (self.pieces[a].friction * self.pieces[b].friction).sqrt(),
                    slot: first + meeting.pair,
                });
            });
        }
        spots
    }

    /// How the bodies move at the end of a step: their places where it begins, with new velocities.
    #[inline(always)]
    fn solve(&mut self) -> Result<Vec<Place>, Invalid> {
        let step = self.settings.step;
        let mut vectors = self.gather();
        if !self.factor.factorise(&mut self.matrix) {
            return Err(Invalid::NotFinite);
        }
        self.factor.forward(&mut vectors);
        let mut drives = Vec::new();
        let mut places = Vec::new();
        for (number, (link, action)) in self.links.iter().zip(&self.actions).enumerate() {
            let swept = |which: usize| {
                action.ends[which]
                    .filter(|_| self.known[number].stops[which] == EndState::Swept)
                    .map(Law::End)
            };
            let laws = [action.motor.filter(|_| action.is_swept).map(Law::Motor), swept(0), swept(1)];
            for (which, law) in laws.into_iter().enumerate() {
                let Some(law) = law else { continue };
                let along = link.along(action, &self.places[link.parent], &self.places[link.body]);
                let (pair, last) = ((link.body, link.parent), self.pushes[number][which]);
                drives.push(Drive::new((law, last), pair, along, &self.factor, &mut self.room.1));
                places.push((number, which));
            }
        }
        let spots = self.spots();
        let mut contacts = Vec::with_capacity(spots.len());
        for spot in &spots {
            let last = self.remembered[spot.slot];
            let how = (step, self.mass);
            contacts.push(Contact::new(spot, &self.places, &self.factor, last, how, &mut self.room.0));
        }
        let sweeps = self.settings.sweeps_after(self.age);
        contacts::solve(&mut drives, &mut contacts, &mut vectors, sweeps);
        for ((link, which), drive) in places.into_iter().zip(&drives) {
            self.pushes[link][which] = drive.impulse;
        }
        self.remembered.fill(Vector3::zeros());
        for contact in &contacts {
            self.remembered[contact.slot] = contact.impulse;
        }
        self.factor.backward(&mut vectors);
        let moving = |(place, found): (&Place, [f64; 6])| Place {
            velocity: Vector3::new(found[0], found[1], found[2]),
            spin: Vector3::new(found[3], found[4], found[5]),
            ..*place
        };
        Ok(self.places.iter().zip(vectors).map(moving).collect())
    }

    /// Revises which motors give all they have, and which ends of ranges push. Whether the step must be solved again.
    #[inline(always)]
    fn revise(&mut self, moving: &[Place]) -> bool {
        let step = self.settings.step;
        let mut again = false;
        for ((link, action), known) in self.links.iter().zip(&self.actions).zip(&mut self.known) {
            let rate = link.rate(action, &moving[link.parent], &moving[link.body]);
            again |= link.revise(action, rate, known, step);
        }
        again
    }

    #[inline(always)]
    fn advance(&mut self) -> Result<(), Invalid> {
        let step = self.settings.step;
        // Each time one more motor is spent, or an end of a range is held or swept: at some time, none is left.
        let moving = loop {
            let moving = self.solve()?;
            if !self.revise(&moving) {
                break moving;
            }
        };
        if self.gained() > self.allowed {
            return Err(Invalid::EnergyFromNowhere);
        }
        for (number, place) in moving.into_iter().enumerate() {
            let angular = self.inertia(number) * place.spin;
            self.momenta[number] = Momentum { linear: place.velocity * self.bodies[number].mass, angular };
            self.places[number] = place;
        }
        self.age += 1;
        let given = self.pushes.iter().map(|[motor, ..]| *motor);
        for ((action, [motor, low, high]), known) in
            self.actions.iter().zip(&self.pushes).zip(&mut self.known)
        {
            known.is_spent = action.motor.is_some_and(|own| action.is_swept && motor.abs() >= own.most);
            for (stop, push) in known.stops.iter_mut().zip([low, high]) {
                if *stop == EndState::Swept {
                    *stop = if *push != 0.0 { EndState::Held } else { EndState::Free };
                }
            }
        }
        for (((link, action), given), work) in
            self.links.iter().zip(&self.actions).zip(given).zip(&mut self.work)
        {
            if link.is_driven() {
                let (parent, body) = (&self.places[link.parent], &self.places[link.body]);
                let Work { positive, allowed } = link.work(action, given, parent, body, step);
                *work += positive;
                self.added += allowed;
            }
        }
        for place in &mut self.places {
            place.centre += place.velocity * step;
            place.turn = turns::by(&(place.spin * step)) * place.turn;
        }
        self.check()
    }

    /// How much more energy there is than there was at least, but for the work of drives, J: in truth it only falls.
    #[inline(always)]
    fn gained(&mut self) -> f64 {
        let balance = self.energy() - self.added;
        self.lowest = self.lowest.min(balance);
        balance - self.lowest
    }

    /// Kinetic energy, that of the height, and that of springs, where a step begins, J.
    pub(super) fn energy(&self) -> f64 {
        let mut sum = 0.0;
        for (number, place) in self.places.iter().enumerate() {
            let Momentum { linear, angular } = self.momenta[number];
            sum += 0.5 * (linear.dot(&place.velocity) + angular.dot(&place.spin));
            sum -= self.bodies[number].mass * self.gravity.dot(&place.centre);
        }
        for (link, action) in self.links.iter().zip(&self.actions) {
            sum += link.energy(action, self.target(link));
        }
        sum
    }

    fn check(&mut self) -> Result<(), Invalid> {
        let mut whirls = false;
        for place in &self.places {
            let finite = |v: &Vector3<f64>| v.iter().all(|x| x.is_finite());
            if !finite(&place.centre) || !finite(&place.velocity) || !finite(&place.spin) {
                return Err(Invalid::NotFinite);
            }
            if place.velocity.norm() > self.settings.speed_limit {
                return Err(Invalid::TooFast);
            }
            if self.is_grounded && place.centre.y <= 0.0 {
                return Err(Invalid::Sunk);
            }
            whirls |= place.spin.norm() > self.settings.turn_limit();
        }
        self.whirled = if whirls { self.whirled + 1 } else { 0 };
        if self.whirled >= WHIRLS { Err(Invalid::TurnsTooFast) } else { Ok(()) }
    }

    /// The mean over what a segment consists of.
    fn mean(&self, lumps: &[Lump], of: impl Fn(&Place, &Vector3<f64>) -> Vector3<f64>) -> Vector3<f64> {
        lumps.iter().map(|(body, local, share)| of(&self.places[*body], local) * *share).sum()
    }

    /// Where a point of the frame of a body is.
    fn at(place: &Place, local: &Vector3<f64>) -> Vector3<f64> {
        place.centre + place.turn * local
    }

    /// The velocity of a point of the frame of a body.
    fn moves(place: &Place, local: &Vector3<f64>) -> Vector3<f64> {
        place.velocity + place.spin.cross(&(place.turn * local))
    }

    /// The momentum and the angular momentum about the origin of the whole.
    #[cfg(test)]
    pub(super) fn momentum(&self) -> (Vector3<f64>, Vector3<f64>) {
        let mut sums = (Vector3::zeros(), Vector3::zeros());
        for (momentum, place) in self.momenta.iter().zip(&self.places) {
            sums.0 += momentum.linear;
            sums.1 += momentum.angular + place.centre.cross(&momentum.linear);
        }
        sums
    }

    /// Takes the ground away.
    #[cfg(test)]
    pub(super) fn float(&mut self) {
        self.is_grounded = false;
    }

    /// Gives a body a velocity and a spin.
    #[cfg(test)]
    pub(super) fn throw(&mut self, body: usize, velocity: Vector3<f64>, spin: Vector3<f64>) {
        let angular = self.inertia(body) * spin;
        self.momenta[body] = Momentum { linear: velocity * self.bodies[body].mass, angular };
        (self.places[body].velocity, self.places[body].spin) = (velocity, spin);
        self.lowest = f64::MAX;
    }
}

/// What each segment consists of, in the order in which segments follow the bodies.
fn segments(discs: &Discs, lowered: &Lowered) -> Vec<(usize, Vec<Lump>)> {
    let lump = |part: Part| {
        let piece = &lowered.pieces[part.disc];
        (piece.body, piece.local.translation.vector + part.off, part.of_segment)
    };
    let of_beam = |beam: &Beam| -> Vec<_> {
        let segments = 0..beam.segments.len();
        let one = |segment| {
            let middle = lowered.pieces[beam.middle(segment)].body;
            (middle, beam.parts(segment).into_iter().map(lump).collect())
        };
        segments.map(one).collect()
    };
    discs.beams.iter().flat_map(of_beam).collect()
}

/// The links of a refined assembly, by the body that hangs on each.
fn links(discs: &Discs, whole: &Lowered, lowered: &Lowered, stiffer: f64) -> Vec<Link> {
    let mass: f64 = lowered.bodies.iter().map(|body| body.mass).sum();
    let mut links = Vec::new();
    for &(element, from) in &discs.links {
        let number = lowered.pieces[element].body;
        let own = &lowered.bodies[number];
        let Some(dof) = &own.dof else { continue };
        let arms = [own.parent, number].map(|body| dof.anchor.coords - lowered.bodies[body].centre);
        let pair = (own.parent, number);
        let servo_of = |child: usize| whole.bodies[whole.pieces[child].body].servo;
        let mut link = match from {
            From::Elastic { beam } => {
                let beam = &discs.beams[beam];
                let (links, hinges) = (beam.links(), beam.hinges.len());
                let length = beam.length() / links as f64;
                let way = beam.way().into_inner();
                Link::elastic(pair, arms, (&beam.hinge, &way), &beam.section, (hinges, links, length))
                    .stiffened(stiffer)
            }
            From::Joint => Link::joint(pair, arms, dof, mass),
        };
        link.servo = match from {
            // The last segment hangs on a hinge of the row.
            From::Elastic { beam } => {
                let segments = &discs.beams[beam].segments;
                servo_of(segments[segments.len() - 1])
            }
            From::Joint => {
                let child = discs.of_element.iter().position(|piece| *piece == element);
                child.map_or(0, servo_of)
            }
        };
        links.push(link);
    }
    links
}

/// What each moving joint of the assembly as it was lowered reads, in the order of its bodies.
fn readings(discs: &Discs, whole: &Lowered, lowered: &Lowered, links: &[Link]) -> Vec<Reading> {
    let element_of = |body: usize| whole.pieces.iter().position(|piece| piece.body == body);
    (1..whole.bodies.len())
        .map(|body| {
            // The element whose joint it is stands first among those of its body.
            let element = element_of(body).unwrap_or(0);
            let beam = discs.beams.iter().position(|beam| {
                let hinged = beam.segments.iter().skip(beam.segments.len() - beam.hinges.len());
                hinged.into_iter().any(|segment| whole.pieces[*segment].body == body)
            });
            match beam {
                Some(beam) => Reading::OfBeam { beam, hinges: discs.beams[beam].hinges.len() },
                None => {
                    let own = lowered.pieces[discs.of_element[element]].body;
                    let link = links.iter().position(|link| link.body == own).unwrap_or(0);
                    Reading::OfLink { link }
                }
            }
        })
        .collect()
}

impl Stepper for Rods {
    const LANES: usize = 1;

    fn reset(&mut self) {
        self.begin();
    }

    fn aim(&mut self, _: usize, servo: usize, target: f64) {
        if let Some(own) = self.targets.get_mut(servo) {
            *own = target;
        }
    }

    fn step(&mut self) {
        if self.failure.is_none() {
            let level = self.level;
            self.failure = dispatch!(level, kit => kit.vectorize(
                #[inline(always)]
                || self.advance(),
            ))
            .err();
        }
    }

    fn failure(&self, _: usize) -> Option<Invalid> {
        self.failure
    }

    fn pose(&self, _: usize, body: usize) -> Isometry3<f64> {
        let place = match self.segments.get(body.wrapping_sub(self.places.len())) {
            Some((middle, lumps)) => Place { centre: self.mean(lumps, Self::at), ..self.places[*middle] },
            None => self.places[body],
        };
        Isometry3::from_parts(place.centre.into(), place.turn)
    }

    fn position(&self, _: usize, joint: usize) -> f64 {
        let bend = |link: &usize| {
            let own = &self.links[*link];
            own.position(
                &self.places[own.parent],
                &self.places[own.body],
                self.actions[*link].deformation[own.driven()],
            )
        };
        match self.readings[joint] {
            Reading::OfBeam { beam, hinges } => {
                self.beams[beam].iter().map(bend).sum::<f64>() / hinges as f64
            }
            Reading::OfLink { link } if self.links[link].is_spun() => self.rate(0, joint).unwrap_or(0.0),
            Reading::OfLink { link } => bend(&link),
        }
    }

    fn work(&self, _: usize, joint: usize) -> f64 {
        match self.readings[joint] {
            Reading::OfBeam { beam, hinges } => {
                self.beams[beam].iter().map(|link| self.work[*link]).sum::<f64>() / hinges as f64
            }
            Reading::OfLink { link } => self.work[link],
        }
    }

    fn rate(&self, _: usize, joint: usize) -> Option<f64> {
        let rate = |link: &usize| {
            let own = &self.links[*link];
            let rates = self.actions[*link].rates(&self.places[own.parent], &self.places[own.body]);
            rates[own.driven()]
        };
        Some(match self.readings[joint] {
            Reading::OfBeam { beam, hinges } => {
                self.beams[beam].iter().map(rate).sum::<f64>() / hinges as f64
            }
            Reading::OfLink { link } => rate(&link),
        })
    }

    fn velocity(&self, _: usize, body: usize) -> Option<(Vector3<f64>, Vector3<f64>)> {
        Some(match self.segments.get(body.wrapping_sub(self.places.len())) {
            Some((middle, lumps)) => (self.mean(lumps, Self::moves), self.places[*middle].spin),
            None => (self.places[body].velocity, self.places[body].spin),
        })
    }

    fn load(&self, _: usize, element: usize) -> Option<f64> {
        let of_piece = |(piece, share): &(usize, f64)| {
            let sole = &self.soles[*piece];
            let slots = sole.first()..sole.first() + sole.slots();
            share * self.remembered[slots].iter().map(|impulse| impulse.x).sum::<f64>()
        };
        let impulses: f64 = self.parts.get(element)?.iter().map(of_piece).sum();
        Some(impulses / self.settings.step)
    }
}
