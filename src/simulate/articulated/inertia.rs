//! The mass matrix by composite rigid bodies (Featherstone 2008, section 6.2).
//!
//! In world axes, but each composite body is referred to its own joint: the
//! entries of a distant fingertip would drown in rounding if all referred to
//! the root.

use super::kinematics::Frame;
use super::scalar::Scalar;
use super::tree::{ROOT, Tree, dof_of};
use super::vector::{Sym, V3};
use crate::design::assembly::Travel;

/// A body and all that hangs on it, as one rigid body about its joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Composite<S> {
    /// Mass.
    mass: S,
    /// Mass times the way from the joint to the centre of mass.
    moment: V3<S>,
    /// Inertia about the joint.
    inertia: Sym<S>,
}

impl<S: Scalar> Composite<S> {
    /// Nothing.
    #[inline(always)]
    pub(super) fn null(kit: S::Kit) -> Self {
        Self { mass: S::zero(kit), moment: V3::null(kit), inertia: Sym::null(kit) }
    }

    /// Adds a composite that is referred to a point `way` from the own one.
    #[inline(always)]
    fn attach(&mut self, other: &Self, way: V3<S>) {
        let (half, two) = (self.mass.like(0.5), self.mass.like(2.0));
        self.mass += other.mass;
        self.moment += other.moment + way * other.mass;
        // I + 2 (h.d) 1 - h d^T - d h^T + m (d.d 1 - d d^T), with h' = 2 h + m d.
        let h = other.moment * two + way * other.mass;
        let trace = h.dot(way);
        for axis in 0..3 {
            self.inertia.0[axis] += other.inertia.0[axis] + trace - h[axis] * way[axis];
        }
        for (entry, (i, j)) in [(0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
            self.inertia.0[3 + entry] += other.inertia.0[3 + entry] - half * (h[i] * way[j] + h[j] * way[i]);
        }
    }
}

/// Computes the inertia of each body about its centre, in world axes.
#[inline(always)]
pub(super) fn turn_inertias<S: Scalar>(tree: &Tree<S>, frames: &[Frame<S>], inertias: &mut [Sym<S>]) {
    for ((link, frame), inertia) in tree.links.iter().zip(frames).zip(inertias) {
        *inertia = link.inertia.rotated(&frame.rotation);
    }
}

/// Fills the mass matrix H.
#[inline(always)]
pub(super) fn mass_matrix<S: Scalar>(
    tree: &Tree<S>,
    frames: &[Frame<S>],
    inertias: &[Sym<S>],
    composites: &mut [Composite<S>],
    h: &mut [S],
) {
    for (body, link) in tree.links.iter().enumerate() {
        let frame = &frames[body];
        let own = Composite { mass: link.mass, moment: V3::null(tree.kit), inertia: inertias[body] };
        composites[body] = Composite::null(tree.kit);
        composites[body].attach(&own, frame.centre - frame.anchor);
    }
    for body in (1..tree.links.len()).rev() {
        let parent = tree.links[body].parent;
        let (low, high) = composites.split_at_mut(body);
        low[parent].attach(&high[0], frames[body].anchor - frames[parent].anchor);
        if tree.slides {
            joint_row::<S, true>(tree, frames, body, &high[0], h);
        } else {
            joint_row::<S, false>(tree, frames, body, &high[0], h);
        }
    }
    root_rows(tree, &composites[0], h);
}

/// The row of one joint: the momentum that unit speed gives, seen by each
/// degree of freedom between it and the root.
#[inline(always)]
fn joint_row<S: Scalar, const SLIDES: bool>(
    tree: &Tree<S>,
    frames: &[Frame<S>],
    body: usize,
    composite: &Composite<S>,
    h: &mut [S],
) {
    let path = tree.path(body);
    let start = tree.rows[dof_of(body)];
    let row = &mut h[start..start + path.len()];
    let mut at = &frames[body];
    let mut linear = at.axis.cross(composite.moment);
    let mut angular = composite.inertia * at.axis;
    if SLIDES && tree.travels[body] == Travel::Slide {
        angular = V3::null(tree.kit) - linear;
        linear = at.axis * composite.mass;
    }
    let mut ancestor = body;
    for depth in (ROOT..path.len()).rev() {
        let slides = SLIDES && tree.travels[ancestor] == Travel::Slide;
        row[depth] = at.axis.dot(if slides { linear } else { angular });
        ancestor = tree.links[ancestor].parent;
        let next = &frames[ancestor];
        angular += (at.anchor - next.anchor).cross(linear);
        at = next;
    }
    row[..3].copy_from_slice(&angular.0);
    row[3..ROOT].copy_from_slice(&linear.0);
}

#[inline(always)]
fn root_rows<S: Scalar>(tree: &Tree<S>, composite: &Composite<S>, h: &mut [S]) {
    let Sym([xx, yy, zz, xy, xz, yz]) = composite.inertia;
    let c = composite.moment;
    let (zero, mass) = (S::zero(tree.kit), composite.mass);
    let rows: [&[S]; ROOT] = [
        &[xx],
        &[xy, yy],
        &[xz, yz, zz],
        &[zero, c[2], -c[1], mass],
        &[-c[2], zero, c[0], zero, mass],
        &[c[1], -c[0], zero, zero, zero, mass],
    ];
    for (dof, row) in rows.iter().enumerate() {
        h[tree.rows[dof]..tree.rows[dof] + row.len()].copy_from_slice(row);
    }
}
