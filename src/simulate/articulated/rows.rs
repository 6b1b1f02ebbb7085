//! Contact and hinge rows in the factorised space, and where they are kept.
//!
//! A contact has three rows: normal and two tangents. Its column for one
//! degree of freedom is the velocity that unit speed gives to the contact
//! point, in those three directions.

use super::factor::Factor;
use super::kinematics::Frame;
use super::scalar::{Mask, Scalar};
use super::touches::{MOST_LANES, Pair, Touch, Touches, hinges_on};
use super::tree::{ROOT, Tree};
use super::vector::{V3, cross, dot, null, pick, sub};

/// One contact, ready to be solved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact<S> {
    /// Where its columns begin.
    pub(super) start: usize,
    /// Number of columns.
    pub(super) count: usize,
    /// The slots that remember its impulse from step to step, by lane.
    pub(super) slots: [u32; MOST_LANES],
    /// Where it is, relative to the root's centre.
    pub(super) point: V3<S>,
    /// See [`Touch::allowance`].
    pub(super) allowance: S,
    /// See [`Touch::slip`].
    pub(super) slip: [S; 2],
    /// Friction coefficient.
    pub(super) friction: S,
    /// Impulses.
    pub(super) impulse: V3<S>,
    /// W W^T: what unit impulses do to the three velocities; nn, aa, bb, na, nb, ab.
    pub(super) response: [S; 6],
    /// One over the first of these; zero in a lane without the contact.
    pub(super) yielding: S,
    /// One over the largest eigenvalue of the tangential part.
    pub(super) slowest: S,
    /// One over the determinant of the tangential part; zero where singular.
    pub(super) determinant: S,
}

impl<S: Scalar> Contact<S> {
    /// What an impulse does to y, squared.
    #[inline(always)]
    pub(super) fn energy(&self, [n, a, b]: V3<S>) -> S {
        let [nn, aa, bb, na, nb, ab] = self.response;
        n * (n * nn + (a * na + b * nb) * n.like(2.0)) + a * (a * aa + b * ab * n.like(2.0)) + b * b * bb
    }
}

/// All contacts of one step. Emptied, never freed.
#[derive(Clone, Debug)]
pub(super) struct Rows<S> {
    /// The contacts, those with the ground first.
    pub(super) contacts: Vec<Contact<S>>,
    /// How many of them are with the ground.
    pub(super) grounded: usize,
    /// Their columns, W.
    pub(super) columns: Vec<V3<S>>,
    /// The degree of freedom of each column.
    pub(super) dofs: Vec<u32>,
    /// Full-length room for eliminating rows that have two paths.
    scratch: Vec<V3<S>>,
}

impl<S: Scalar> Rows<S> {
    /// Room for as many contacts on a tree.
    pub(super) fn new(tree: &Tree<S>, contacts: usize) -> Self {
        let longest = (0..tree.links.len()).map(|body| tree.path(body).len()).max().unwrap_or(ROOT);
        Self {
            contacts: Vec::with_capacity(contacts),
            grounded: 0,
            columns: Vec::with_capacity(contacts * longest),
            dofs: Vec::with_capacity(contacts * longest),
            scratch: vec![null(tree.kit); tree.dofs()],
        }
    }

    /// Makes the rows of all contacts.
    #[inline(always)]
    pub(super) fn fill(
        &mut self,
        tree: &Tree<S>,
        frames: &[Frame<S>],
        factor: &Factor<S>,
        touches: &Touches<S>,
    ) {
        self.contacts.clear();
        self.columns.clear();
        self.dofs.clear();
        for limb in &touches.limbs {
            for touch in &limb.touches {
                self.push_ground(tree, frames, factor, limb.tip, touch);
            }
        }
        self.grounded = self.contacts.len();
        for pair in &touches.pairs {
            self.push_pair(tree, frames, factor, pair);
        }
    }

    /// Adds a contact with the ground of a body on the path to a tip: normal y,
    /// tangents x and z.
    #[inline(always)]
    fn push_ground(
        &mut self,
        tree: &Tree<S>,
        frames: &[Frame<S>],
        factor: &Factor<S>,
        tip: usize,
        touch: &Touch<S>,
    ) {
        let path = &tree.path(tip)[..touch.deepest];
        let start = self.columns.len();
        let [x, y, z] = touch.point;
        let zero = S::zero(tree.kit);
        let one = S::pick(zero.less(touch.depth), zero.like(1.0), zero);
        // Turns about x, y, z move the point by e cross p; shifts by e.
        self.columns.extend_from_slice(&[
            [-z, zero, y],
            [zero, z, -x],
            [x, -y, zero],
            [zero, one, zero],
            [one, zero, zero],
            [zero, zero, one],
        ]);
        for (place, frame) in hinges_on(path, frames).enumerate() {
            // Only hinges before the body move its point.
            let moves = zero.like((place + ROOT) as f64).less(touch.depth);
            let way = cross(frame.axis, sub(touch.point, frame.hinge));
            self.columns.push([
                S::pick(moves, way[1], zero),
                S::pick(moves, way[0], zero),
                S::pick(moves, way[2], zero),
            ]);
        }
        self.dofs.extend_from_slice(path);
        let columns = &mut self.columns[start..];
        for depth in (0..path.len()).rev() {
            let dof = path[depth] as usize;
            let own = columns[depth];
            for (column, &entry) in columns[..depth].iter_mut().zip(factor.row(tree, dof, depth)) {
                subtract(column, own, entry);
            }
            columns[depth] = scaled(own, factor.inverse[dof]);
        }
        self.finish(start, touch);
    }

    /// Adds a contact between two bodies.
    #[inline(always)]
    fn push_pair(&mut self, tree: &Tree<S>, frames: &[Frame<S>], factor: &Factor<S>, pair: &Pair<S>) {
        let start = self.columns.len();
        let (touch, normal) = (&pair.touch, pair.normal);
        let (first, second) = tangents(normal);
        let zero = S::zero(tree.kit);
        let none = S::mask(tree.kit, false);
        // The union of the two paths, tips first.
        let mut one = &tree.path(pair.tips.0)[..touch.deepest];
        let mut two = &tree.path(pair.tips.1)[..pair.deepest];
        while let Some(dof) = one.last().max(two.last()).copied() {
            let mut moves = [none; 2];
            for ((path, depth), moves) in
                [(&mut one, touch.depth), (&mut two, pair.depth)].into_iter().zip(&mut moves)
            {
                if let Some((_, rest)) = path.split_last().filter(|(last, _)| **last == dof) {
                    *path = rest;
                    *moves = zero.like(rest.len() as f64).less(depth);
                }
            }
            let dof = dof as usize;
            let [with_one, with_two] = [moves[0] & !moves[1], moves[1] & !moves[0]];
            self.dofs.push(dof as u32);
            // Where both move alike the row is zero until the elimination reaches it.
            self.scratch[dof] = null(tree.kit);
            if dof >= ROOT && (with_one | with_two).any() {
                let frame = &frames[dof + 1 - ROOT];
                let way = cross(frame.axis, sub(touch.point, frame.hinge));
                let sign = S::pick(with_one, pair.side, -pair.side);
                let row = scaled([dot(way, normal), dot(way, first), dot(way, second)], sign);
                self.scratch[dof] = pick::<S>(with_one | with_two, row, null(tree.kit));
            }
        }
        for place in start..self.dofs.len() {
            let dof = self.dofs[place] as usize;
            let own = self.scratch[dof];
            let path = tree.path_to(dof);
            let last = path.len() - 1;
            for (&other, &entry) in path[..last].iter().zip(factor.row(tree, dof, last)) {
                subtract(&mut self.scratch[other as usize], own, entry);
            }
            self.columns.push(scaled(own, factor.inverse[dof]));
        }
        self.finish(start, touch);
    }

    #[inline(always)]
    fn finish(&mut self, start: usize, touch: &Touch<S>) {
        let zero = touch.depth.like(0.0);
        let mut sum = [zero; 6];
        for w in &self.columns[start..] {
            for (entry, (i, j)) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
                sum[entry] += w[i] * w[j];
            }
        }
        let k = |value: f64| zero.like(value);
        let [nn, aa, bb, _, _, ab] = sum;
        let spread = ((aa - bb) * (aa - bb) * k(0.25) + ab * ab).sqrt();
        let largest = (aa + bb) * k(0.5) + spread;
        let determinant = aa * bb - ab * ab;
        let here = zero.less(touch.depth);
        // Below this share the weak tangent is rounding noise.
        let regular = here & (largest * largest * k(1e-5)).less(determinant);
        self.contacts.push(Contact {
            start,
            count: self.columns.len() - start,
            slots: touch.slots,
            point: touch.point,
            allowance: touch.allowance,
            slip: touch.slip,
            friction: touch.friction,
            impulse: null(zero.kit()),
            response: sum,
            yielding: S::pick(here, k(1.0) / nn, zero),
            slowest: S::pick(here, k(1.0) / largest, zero),
            determinant: S::pick(regular, k(1.0) / determinant, zero),
        });
    }
}

#[inline(always)]
fn subtract<S: Scalar>(column: &mut V3<S>, own: V3<S>, factor: S) {
    for (entry, value) in column.iter_mut().zip(own) {
        *entry -= factor * value;
    }
}

#[inline(always)]
fn scaled<S: Scalar>(column: V3<S>, factor: S) -> V3<S> {
    [column[0] * factor, column[1] * factor, column[2] * factor]
}

/// Two unit vectors across a unit normal, without a jump except where the
/// normal points down (Duff et al., Journal of Computer Graphics Techniques
/// 6(1), 2017, with y in the place of z).
#[inline(always)]
fn tangents<S: Scalar>(n: V3<S>) -> (V3<S>, V3<S>) {
    let one = n[0].like(1.0);
    let sign = S::pick(n[1].less(n[1].like(0.0)), -one, one);
    let a = -(one / (sign + n[1]));
    let b = n[2] * n[0] * a;
    let first = [sign + n[0] * n[0] * a, -n[0], b];
    let second = [sign * b, -sign * n[2], one + sign * n[2] * n[2] * a];
    (first, second)
}
