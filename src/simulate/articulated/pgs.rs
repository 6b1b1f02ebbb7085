//! Projected Gauss-Seidel in the factorised space.
//!
//! Contacts obey, at the end of the step: the normal velocity does not close
//! more than the gap, the normal impulse does not pull, and friction is the
//! impulse in the disc of radius mu times normal impulse that leaves the
//! least sliding (maximum dissipation: a cone, not a pyramid).

use super::rows::{Contact, Rows};
use super::scalar::{Mask, Scalar};
use super::vector::V3;

/// A contact sticks if its friction is less than this share, squared, of the most that it can be.
const STICKS: f64 = 0.96;

/// Velocities of a contact point along its three directions.
#[inline(always)]
fn velocities<S: Scalar>(columns: &[V3<S>], dofs: &[u32], y: &[S]) -> V3<S> {
    let mut sum = V3::null(y[0].kit());
    for (&column, &dof) in columns.iter().zip(dofs) {
        sum += column * y[dof as usize];
    }
    sum
}

#[inline(always)]
fn push<S: Scalar>(columns: &[V3<S>], dofs: &[u32], y: &mut [S], by: V3<S>) {
    for (column, &dof) in columns.iter().zip(dofs) {
        y[dof as usize] += column.dot(by);
    }
}

/// Applies the impulses that the contacts start with.
#[inline(always)]
pub(super) fn warm_start<S: Scalar>(rows: &Rows<S>, y: &mut [S]) {
    for contact in rows.contacts.iter() {
        let normal = contact.impulse[0];
        if normal.like(0.0).less(normal).any() {
            let span = contact.start..contact.start + contact.count;
            push(&rows.columns[span.clone()], &rows.dofs[span], y, contact.impulse);
        }
    }
}

/// How much a sweep has changed, as energies: what an impulse does to y, squared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unrest<S> {
    /// The largest change of any row.
    change: S,
    /// The sum of what the rows give.
    whole: S,
}

impl<S: Scalar> Unrest<S> {
    #[inline(always)]
    pub(super) fn new(kit: S::Kit) -> Self {
        Self { change: S::zero(kit), whole: S::zero(kit) }
    }

    /// Adds a row by the energies of its change and of itself.
    #[inline(always)]
    pub(super) fn add(&mut self, change: S, whole: S) {
        self.change = self.change.max(change);
        self.whole += whole;
    }

    /// A share, squared, of what all rows give, but of no more than `most`.
    #[inline(always)]
    pub(super) fn share(&self, share: S, most: S) -> S {
        self.whole.min(most) * share
    }

    /// Where a row has changed by more than that.
    #[inline(always)]
    pub(super) fn exceeds(&self, share: S, most: S) -> S::Mask {
        self.share(share, most).less(self.change)
    }
}

/// One sweep over all contacts, in the lanes that are not at rest yet.
#[inline(always)]
pub(super) fn sweep<S: Scalar>(rows: &mut Rows<S>, y: &mut [S], open: S::Mask, unrest: &mut Unrest<S>) {
    let Rows { contacts, columns, dofs, .. } = rows;
    for contact in contacts.iter_mut() {
        let span = contact.start..contact.start + contact.count;
        let (columns, dofs) = (&columns[span.clone()], &dofs[span]);
        let V3([n, a, b]) = velocities(columns, dofs, y);
        let before = contact.impulse;
        let zero = n.like(0.0);
        let [slip, aside] = contact.slip;
        let sliding = [a + slip, b + aside];
        let speed = n + contact.allowance + contact.softness * before[0];
        let yielding = contact.yielding / (n.like(1.0) + braced(contact, sliding) * contact.yielding);
        let normal = (before[0] - speed * yielding).max(zero);
        let touching = zero.less(normal);
        if !(open & (touching | zero.less(before[0]))).any() {
            continue;
        }
        let change = normal - before[0];
        let sliding = [sliding[0] + contact.response[3] * change, sliding[1] + contact.response[4] * change];
        let friction = rub(contact, sliding, contact.friction * normal, touching);
        let after = V3::pick(touching, V3([normal, friction[0], friction[1]]), V3([zero; 3]));
        let after = V3::pick(open, after, before);
        contact.impulse = after;
        let change = after - before;
        unrest.add(contact.energy(change), after[0] * after[0] * contact.response[0]);
        push(columns, dofs, y, change);
    }
}

/// What friction adds to the normal velocity for each unit of normal impulse, where it does and the contact slides.
///
/// Friction grows with the normal impulse, and where it pushes the surfaces apart, too (a limb that drags its tip towards
/// it), an impulse that reckons without it is too great: the next sweep takes it back, and so on for ever. The foot then
/// floats, or carries and does not, and the body glides.
#[inline(always)]
fn braced<S: Scalar>(contact: &Contact<S>, sliding: [S; 2]) -> S {
    let k = |value: f64| sliding[0].like(value);
    let V3([normal, p, q]) = contact.impulse;
    let [_, _, _, na, nb, _] = contact.response;
    let most = contact.friction * normal;
    let sticks = (p * p + q * q).less(most * most * k(STICKS));
    let speed = (sliding[0] * sliding[0] + sliding[1] * sliding[1]).sqrt().max(k(1e-20));
    let by_speed = -(na * sliding[0] + nb * sliding[1]) * contact.friction / speed;
    let by_impulse = (na * p + nb * q) / normal.max(k(1e-20));
    S::pick(sticks, k(0.0), by_speed.max(by_impulse).max(k(0.0)))
}

/// The friction impulse in a disc of a radius, in the lanes that touch.
///
/// If the impulse that stops all sliding fits, that is it. Else one step down
/// the gradient, projected onto the disc: its rest point is the impulse
/// opposite to the sliding velocity, also where the two tangents differ in
/// inertia (scaling the stopping impulse down would not be).
#[inline(always)]
fn rub<S: Scalar>(contact: &Contact<S>, sliding: [S; 2], radius: S, touching: S::Mask) -> [S; 2] {
    let V3([_, p, q]) = contact.impulse;
    let [_, aa, bb, _, _, ab] = contact.response;
    let d = contact.determinant;
    let (zero, square) = (d.like(0.0), radius * radius);
    let stop = [p - d * (bb * sliding[0] - ab * sliding[1]), q - d * (aa * sliding[1] - ab * sliding[0])];
    let sticks = zero.less(d) & (stop[0] * stop[0] + stop[1] * stop[1]).at_most(square);
    if (sticks | !touching).all() {
        return stop;
    }
    let k = contact.slowest;
    let step = [p - k * sliding[0], q - k * sliding[1]];
    let length = step[0] * step[0] + step[1] * step[1];
    let shrink = S::pick(length.at_most(square), d.like(1.0), radius / length.sqrt());
    [S::pick(sticks, stop[0], step[0] * shrink), S::pick(sticks, stop[1], step[1] * shrink)]
}
