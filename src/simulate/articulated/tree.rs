//! The kinematic tree: what stays the same over all runs of one body.
//!
//! Lengths are in cm, masses in g, times in s, so that single precision is
//! well scaled. Degrees of freedom: three turns and three shifts of the root
//! (world axes), then one hinge angle per further body. The degrees of freedom
//! from the root to body b are its *path*; a row of the mass matrix has an
//! entry for each degree of freedom on the path and no others (Featherstone,
//! Rigid Body Dynamics Algorithms, 2008, section 6.4, "branch-induced
//! sparsity"), stored root first, so that the path of an ancestor is a prefix.

use super::scalar::Scalar;
use super::vector::{Sym, V3};
use crate::design::assembly::Travel;
use crate::simulate::World;
use crate::simulate::lowering::{Body, Lowered};

/// cm per m.
pub(super) const LENGTH: f64 = 1e2;
/// g per kg.
pub(super) const MASS: f64 = 1e3;
/// g cm^2/s^2 per N m; also g cm^2 per kg m^2.
pub(super) const TORQUE: f64 = MASS * LENGTH * LENGTH;
/// Degrees of freedom of the root.
pub(super) const ROOT: usize = 6;

/// One body and the hinge that carries it.
#[derive(Clone, Debug)]
pub(super) struct Link<S> {
    /// Index of the parent; the root names itself.
    pub(super) parent: usize,
    /// Axis of the joint, the same in the frames of parent and child.
    pub(super) axis: V3<S>,
    /// From the parent's centre to the joint at rest, parent's frame.
    pub(super) to_joint: V3<S>,
    /// From the joint to the own centre, own frame.
    pub(super) to_centre: V3<S>,
    /// Mass.
    pub(super) mass: S,
    /// Inertia about the centre, own frame.
    pub(super) inertia: Sym<S>,
    /// One over the mean of its principal values.
    pub(super) lightness: S,
    /// Stiffness of the joint.
    pub(super) stiffness: S,
    /// Damping of the joint.
    pub(super) damping: S,
    /// Largest torque, or force, of the joint.
    pub(super) effort: S,
    /// Hard limits of its position.
    pub(super) limits: (S, S),
    /// Which servo moves it.
    pub(super) servo: usize,
}

/// The bodies and the layout of everything that follows their tree.
#[derive(Clone, Debug)]
pub(super) struct Tree<S: Scalar> {
    /// What numbers are made with.
    pub(super) kit: S::Kit,
    /// The bodies, parents before children.
    pub(super) links: Vec<Link<S>>,
    /// What the joint of each body lets it do. What is asked for each contact and each entry of H is kept by itself, not in
    /// the links, which are large.
    pub(super) travels: Vec<Travel>,
    /// Whether any of them slides.
    pub(super) slides: bool,
    /// Whether it is the speed of a body's joint that is driven.
    pub(super) spun: Vec<bool>,
    /// The bodies whose joints nothing drives.
    pub(super) passive: Vec<usize>,
    /// The bodies that may turn on and on.
    pub(super) endless: Vec<usize>,
    /// What the target of each servo is here in SI units.
    pub(super) servos: Vec<f64>,
    /// All paths of bodies, one after the other.
    paths: Vec<u32>,
    /// Where the path of each body begins and ends.
    spans: Vec<(usize, usize)>,
    /// Where the row of each degree of freedom begins in the mass matrix.
    pub(super) rows: Vec<usize>,
    /// Total length of the rows.
    pub(super) entries: usize,
}

impl<S: Scalar> Tree<S> {
    /// Mass of the whole, g.
    pub(super) fn mass(&self) -> S {
        let mass = |lane: usize| -> f64 { self.links.iter().map(|link| link.mass.lane(lane)).sum() };
        S::each(self.kit, mass)
    }

    /// From bodies in SI units, in the world of each lane.
    pub(super) fn new(kit: S::Kit, lowered: &Lowered, worlds: &[World]) -> Self {
        let bodies = &lowered.bodies;
        let mut tree = Self {
            kit,
            links: bodies.iter().map(|body| link(kit, body, &bodies[body.parent], worlds)).collect(),
            slides: false,
            travels: vec![Travel::Turn; bodies.len()],
            spun: vec![false; bodies.len()],
            passive: Vec::new(),
            endless: Vec::new(),
            servos: vec![1.0; lowered.servos.len()],
            paths: Vec::new(),
            spans: Vec::new(),
            rows: Vec::new(),
            entries: 0,
        };
        for (number, body) in bodies.iter().enumerate() {
            let Some(dof) = &body.dof else { continue };
            tree.servos[body.servo] = scales(dof.travel).0;
            tree.travels[number] = dof.travel;
            tree.slides |= dof.travel == Travel::Slide;
            tree.spun[number] = dof.is_spun();
            if dof.actuator().is_none() {
                tree.passive.push(number);
            }
            let has_ends = dof.limits.0.is_finite() || dof.limits.1.is_finite();
            if dof.travel == Travel::Turn && !has_ends && (dof.is_spun() || dof.stiffness == 0.0) {
                tree.endless.push(number);
            }
        }
        for body in 0..bodies.len() {
            tree.lay_out(body);
        }
        tree
    }

    fn lay_out(&mut self, body: usize) {
        let start = self.paths.len();
        if body == 0 {
            for dof in 0..ROOT {
                self.paths.push(dof as u32);
                self.add_row(dof + 1);
            }
        } else {
            let (from, to) = self.spans[self.links[body].parent];
            self.paths.extend_from_within(from..to);
            self.paths.push(dof_of(body) as u32);
            self.add_row(to - from + 1);
        }
        self.spans.push((start, self.paths.len()));
    }

    fn add_row(&mut self, entries: usize) {
        self.rows.push(self.entries);
        self.entries += entries;
    }

    /// Number of degrees of freedom.
    #[inline(always)]
    pub(super) fn dofs(&self) -> usize {
        self.rows.len()
    }

    /// Degrees of freedom from the root to a body.
    #[inline(always)]
    pub(super) fn path(&self, body: usize) -> &[u32] {
        let (from, to) = self.spans[body];
        &self.paths[from..to]
    }

    /// Degrees of freedom from the root to one of them, itself included.
    #[inline(always)]
    pub(super) fn path_to(&self, dof: usize) -> &[u32] {
        if dof < ROOT { &self.paths[..=dof] } else { self.path(dof + 1 - ROOT) }
    }
}

/// What a position and an effort of a joint are here in SI units: rad and N m, or m and N.
pub(super) fn scales(travel: Travel) -> (f64, f64) {
    match travel {
        Travel::Turn => (1.0, TORQUE),
        Travel::Slide => (LENGTH, MASS * LENGTH),
    }
}

/// The degree of freedom of the joint that carries a body other than the root.
#[inline(always)]
pub(super) fn dof_of(body: usize) -> usize {
    body + ROOT - 1
}

fn link<S: Scalar>(kit: S::Kit, body: &Body, parent: &Body, worlds: &[World]) -> Link<S> {
    let of = |value: f64| S::of(kit, value);
    let massive = |value: f64| S::each(kit, |lane| value * worlds[lane].mass);
    let vector = |v: nalgebra::Vector3<f64>| V3::constant(kit, v.into());
    let m = body.inertia * TORQUE;
    let mut link = Link {
        parent: 0,
        axis: V3::null(kit),
        to_joint: V3::null(kit),
        to_centre: V3::null(kit),
        mass: massive(body.mass * MASS),
        lightness: S::each(
            kit,
            |lane| if m.trace() > 0.0 { 3.0 / (m.trace() * worlds[lane].mass) } else { 0.0 },
        ),
        inertia: Sym([m.m11, m.m22, m.m33, m.m12, m.m13, m.m23].map(massive)),
        stiffness: of(0.0),
        damping: of(0.0),
        effort: of(0.0),
        limits: (of(0.0), of(0.0)),
        servo: body.servo,
    };
    if let Some(dof) = &body.dof {
        let (position, effort) = scales(dof.travel);
        link.parent = body.parent;
        link.axis = vector(dof.axis.into_inner());
        link.to_joint = vector((dof.anchor.coords - parent.centre) * LENGTH);
        link.to_centre = vector((body.centre - dof.anchor.coords) * LENGTH);
        // What only its speed drives has no spring.
        link.stiffness = of(if dof.is_spun() { 0.0 } else { dof.stiffness * (effort / position) });
        link.damping = of(dof.damping * (effort / position));
        link.effort = S::each(kit, |lane| dof.effort * effort * worlds[lane].torque);
        link.limits = (of(dof.limits.0 * position), of(dof.limits.1 * position));
    }
    link
}
