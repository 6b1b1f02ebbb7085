//! Contact and hinge rows in the factorised space, and where they are kept.
//!
//! A contact has three rows: normal and two tangents. Its column for one
//! degree of freedom is the velocity that unit speed gives to the contact
//! point, in those three directions.

use super::factor::Factor;
use super::kinematics::Frame;
use super::scalar::Scalar;
use super::tree::{ROOT, Tree, dof_of};
use super::vector::{V3, cross, dot, sub};

/// Three directions (normal, two tangents) and a spare that makes four.
pub(super) type Column<S> = [S; 4];

/// One contact, ready to be solved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact<S> {
    /// Where its columns begin.
    pub(super) start: usize,
    /// Number of columns.
    pub(super) count: usize,
    /// The slot that remembers its impulse from step to step.
    pub(super) slot: usize,
    /// Velocity along the normal at which the gap closes in this step is
    /// minus this; negative where the surfaces are to be pushed apart.
    pub(super) allowance: S,
    /// Friction coefficient.
    pub(super) friction: S,
    /// Impulses.
    pub(super) impulse: V3<S>,
    /// W W^T: what unit impulses do to the three velocities; nn, aa, bb, na, nb, ab.
    pub(super) response: [S; 6],
    /// One over the largest eigenvalue of the tangential part.
    pub(super) slowest: S,
    /// One over the determinant of the tangential part; zero where singular.
    pub(super) determinant: S,
}

/// All contacts of one step. Emptied, never freed.
#[derive(Clone, Debug)]
pub(super) struct Rows<S> {
    /// The contacts.
    pub(super) contacts: Vec<Contact<S>>,
    /// Their columns, W.
    pub(super) columns: Vec<Column<S>>,
    /// The degree of freedom of each column.
    pub(super) dofs: Vec<u32>,
    /// Full-length room for eliminating rows that have two paths.
    scratch: Vec<Column<S>>,
}

/// A contact before its rows are made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch<S> {
    /// Contact point relative to the root's centre.
    pub(super) point: V3<S>,
    /// See [`Contact::allowance`].
    pub(super) allowance: S,
    /// Friction coefficient.
    pub(super) friction: S,
    /// See [`Contact::slot`].
    pub(super) slot: usize,
    /// The body.
    pub(super) body: usize,
    /// The other body and the normal from it to the first; none is the ground.
    pub(super) other: Option<(usize, V3<S>)>,
}

impl<S: Scalar> Rows<S> {
    /// Room for as many contacts on a tree.
    pub(super) fn new(tree: &Tree<S>, contacts: usize) -> Self {
        let longest = (0..tree.links.len()).map(|body| tree.path(body).len()).max().unwrap_or(ROOT);
        Self {
            contacts: Vec::with_capacity(contacts),
            columns: Vec::with_capacity(contacts * longest),
            dofs: Vec::with_capacity(contacts * longest),
            scratch: vec![[S::ZERO; 4]; tree.dofs()],
        }
    }

    /// Forgets the contacts of the last step.
    pub(super) fn clear(&mut self) {
        self.contacts.clear();
        self.columns.clear();
        self.dofs.clear();
    }

    /// Adds a contact.
    pub(super) fn push(&mut self, tree: &Tree<S>, frames: &[Frame<S>], factor: &Factor<S>, touch: &Touch<S>) {
        match touch.other {
            None => self.push_ground(tree, frames, factor, touch),
            Some((other, normal)) => self.push_pair(tree, frames, factor, touch, other, normal),
        }
    }

    /// Adds a contact of a body with the ground: normal y, tangents x and z.
    fn push_ground(&mut self, tree: &Tree<S>, frames: &[Frame<S>], factor: &Factor<S>, touch: &Touch<S>) {
        let path = tree.path(touch.body);
        let start = self.columns.len();
        let [x, y, z] = touch.point;
        let (zero, one) = (S::ZERO, S::ONE);
        // Turns about x, y, z move the point by e cross p; shifts by e.
        self.columns.extend_from_slice(&[
            [-z, zero, y, zero],
            [zero, z, -x, zero],
            [x, -y, zero, zero],
            [zero, one, zero, zero],
            [one, zero, zero, zero],
            [zero, zero, one, zero],
        ]);
        for &dof in &path[ROOT..] {
            let frame = &frames[dof as usize + 1 - ROOT];
            let move_ = cross(frame.axis, sub(touch.point, frame.hinge));
            self.columns.push([move_[1], move_[0], move_[2], zero]);
        }
        self.dofs.extend_from_slice(path);
        let columns = &mut self.columns[start..];
        for depth in (0..path.len()).rev() {
            let dof = path[depth] as usize;
            let own = columns[depth];
            for (column, &entry) in columns[..depth].iter_mut().zip(factor.row(tree, dof, depth)) {
                subtract(column, own, entry);
            }
            columns[depth] = own.map(|value| value * factor.inverse[dof]);
        }
        self.finish(start, touch);
    }

    /// Adds a contact between two bodies.
    fn push_pair(
        &mut self,
        tree: &Tree<S>,
        frames: &[Frame<S>],
        factor: &Factor<S>,
        touch: &Touch<S>,
        other: usize,
        normal: V3<S>,
    ) {
        let start = self.columns.len();
        let (first, second) = tangents(normal);
        let (mut a, mut b) = (touch.body, other);
        // Above the body where the two paths meet both move alike: the row is
        // zero there until the elimination reaches it.
        while a != b {
            let positive = a > b;
            let body = if positive { a } else { b };
            let frame = &frames[body];
            let move_ = cross(frame.axis, sub(touch.point, frame.hinge));
            let sign = if positive { S::ONE } else { -S::ONE };
            let dof = dof_of(body);
            self.dofs.push(dof as u32);
            self.scratch[dof] =
                [dot(move_, normal) * sign, dot(move_, first) * sign, dot(move_, second) * sign, S::ZERO];
            if positive { a = tree.links[a].parent } else { b = tree.links[b].parent }
        }
        for &dof in tree.path(a).iter().rev() {
            self.dofs.push(dof);
            self.scratch[dof as usize] = [S::ZERO; 4];
        }
        for place in start..self.dofs.len() {
            let dof = self.dofs[place] as usize;
            let own = self.scratch[dof];
            let path = tree.path_to(dof);
            let last = path.len() - 1;
            for (&other, &entry) in path[..last].iter().zip(factor.row(tree, dof, last)) {
                subtract(&mut self.scratch[other as usize], own, entry);
            }
            self.columns.push(own.map(|value| value * factor.inverse[dof]));
        }
        self.finish(start, touch);
    }

    fn finish(&mut self, start: usize, touch: &Touch<S>) {
        let mut sum = [S::ZERO; 6];
        for w in &self.columns[start..] {
            for (entry, (i, j)) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
                sum[entry] += w[i] * w[j];
            }
        }
        let half = S::of(0.5);
        let [_, aa, bb, _, _, ab] = sum;
        let spread = ((aa - bb) * (aa - bb) * S::of(0.25) + ab * ab).sqrt();
        let largest = (aa + bb) * half + spread;
        let determinant = aa * bb - ab * ab;
        // Below this share the weak tangent is rounding noise.
        let singular = determinant <= largest * largest * S::of(1e-5);
        self.contacts.push(Contact {
            start,
            count: self.columns.len() - start,
            slot: touch.slot,
            allowance: touch.allowance,
            friction: touch.friction,
            impulse: [S::ZERO; 3],
            response: sum,
            slowest: S::ONE / largest,
            determinant: if singular { S::ZERO } else { S::ONE / determinant },
        });
    }
}

#[inline(always)]
fn subtract<S: Scalar>(column: &mut Column<S>, own: Column<S>, factor: S) {
    for (entry, value) in column.iter_mut().zip(own) {
        *entry -= factor * value;
    }
}

/// Two unit vectors across a unit normal, without a jump except where the
/// normal points down (Duff et al., Journal of Computer Graphics Techniques
/// 6(1), 2017, with y in the place of z).
fn tangents<S: Scalar>(n: V3<S>) -> (V3<S>, V3<S>) {
    let sign = if n[1] >= S::ZERO { S::ONE } else { -S::ONE };
    let a = -(S::ONE / (sign + n[1]));
    let b = n[2] * n[0] * a;
    let first = [sign + n[0] * n[0] * a, -n[0], b];
    let second = [sign * b, -sign * n[2], S::ONE + sign * n[2] * n[2] * a];
    (first, second)
}
