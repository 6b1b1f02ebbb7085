//! Contact and joint rows in the factorised space, and where they are kept.
//!
//! A contact has three rows: normal and two tangents. Its column for one
//! degree of freedom is the velocity that unit speed gives to the contact
//! point, in those three directions.

use super::factor::Factor;
use super::kinematics::Frame;
use super::places::Places;
use super::scalar::{Mask, Scalar};
use super::touches::{MOST_LANES, Pair, Touch, Touches};
use super::tree::{ROOT, Tree};
use super::vector::V3;
use crate::design::assembly::Travel;
use crate::simulate::contacts::{GROUND_SOFTNESS, PAIR_SOFTNESS};

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
    /// The speed at which the contact gives way for an impulse of one.
    pub(super) softness: S,
    /// One over what a unit impulse along the normal does, this included; zero in a lane without the contact.
    pub(super) yielding: S,
    /// One over the largest eigenvalue of the tangential part.
    pub(super) slowest: S,
    /// One over the determinant of the tangential part; zero where singular.
    pub(super) determinant: S,
}

impl<S: Scalar> Contact<S> {
    /// What an impulse does to y, squared.
    #[inline(always)]
    pub(super) fn energy(&self, V3([n, a, b]): V3<S>) -> S {
        let [nn, aa, bb, na, nb, ab] = self.response;
        n * (n * nn + (a * na + b * nb) * n.like(2.0)) + a * (a * aa + b * ab * n.like(2.0)) + b * b * bb
    }
}

/// All contacts of one step. Emptied, never freed.
#[derive(Clone, Debug)]
pub(super) struct Rows<S> {
    /// The contacts, those with the ground first.
    pub(super) contacts: Places<Contact<S>>,
    /// How many of them are with the ground.
    pub(super) grounded: usize,
    /// Their columns, W.
    pub(super) columns: Places<V3<S>>,
    /// The degree of freedom of each column.
    pub(super) dofs: Vec<u32>,
    /// The speed at which contacts with the ground give way for an impulse of one.
    ground_softness: S,
    /// The same of contacts between two bodies.
    pair_softness: S,
    /// Room for eliminating a row: by depth on its path, or by degree of freedom where there are two paths.
    scratch: Vec<V3<S>>,
    /// Where the rows of the degrees of freedom on a path begin in the factor.
    starts: Vec<usize>,
}

impl<S: Scalar> Rows<S> {
    /// Room for as many contacts on a tree.
    pub(super) fn new(tree: &Tree<S>, contacts: usize) -> Self {
        let longest = (0..tree.links.len()).map(|body| tree.path(body).len()).max().unwrap_or(ROOT);
        Self {
            contacts: Places::new(contacts),
            grounded: 0,
            columns: Places::new(contacts * longest),
            dofs: Vec::with_capacity(contacts * longest),
            ground_softness: S::of(tree.kit, GROUND_SOFTNESS) / tree.mass(),
            pair_softness: S::of(tree.kit, PAIR_SOFTNESS) / tree.mass(),
            scratch: vec![V3::null(tree.kit); tree.dofs()],
            starts: Vec::with_capacity(longest),
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
        for limb in touches.limbs.iter().filter(|limb| !limb.touches.is_empty()) {
            self.starts.clear();
            self.starts.extend(tree.path(limb.tip).iter().map(|&dof| tree.rows[dof as usize]));
            for touch in limb.touches.iter() {
                if tree.slides {
                    self.push_ground::<true>(tree, frames, factor, limb.tip, touch);
                } else {
                    self.push_ground::<false>(tree, frames, factor, limb.tip, touch);
                }
            }
        }
        self.grounded = self.contacts.len();
        for pair in touches.pairs.iter() {
            self.push_pair(tree, frames, factor, pair);
        }
    }

    /// Adds a contact with the ground of a body on the path to a tip: normal y,
    /// tangents x and z.
    #[inline(always)]
    fn push_ground<const SLIDES: bool>(
        &mut self,
        tree: &Tree<S>,
        frames: &[Frame<S>],
        factor: &Factor<S>,
        tip: usize,
        touch: &Touch<S>,
    ) {
        let path = &tree.path(tip)[..touch.deepest];
        let (start, length) = (self.columns.len(), path.len());
        let V3([x, y, z]) = touch.point;
        let zero = S::zero(tree.kit);
        let one = S::pick(zero.less(touch.depth), zero.like(1.0), zero);
        let columns = self.columns.more(length, V3::null(tree.kit));
        self.dofs.extend_from_slice(path);
        let mut response = [zero; 6];
        // From the tip to the root, each entry gathers what those after it take from it: one store for each.
        for depth in (0..length).rev() {
            let mut own = V3(match depth {
                // Turns about x, y, z move the point by e cross p; shifts by e.
                0 => [-z, zero, y],
                1 => [zero, z, -x],
                2 => [x, -y, zero],
                3 => [zero, one, zero],
                4 => [one, zero, zero],
                5 => [zero, zero, one],
                _ => {
                    let body = path[depth] as usize + 1 - ROOT;
                    // Only joints before the body move its point.
                    let moves = zero.like(depth as f64).less(touch.depth);
                    let travel = if SLIDES { tree.travels[body] } else { Travel::Turn };
                    let V3([x, y, z]) = frames[body].moves(travel, touch.point);
                    [y, x, z].map(|entry| S::pick(moves, entry, zero))
                }
            });
            let later = self.starts[..length].iter().zip(&self.scratch);
            for (&row, &column) in later.skip(depth + 1).rev() {
                own -= column * factor.rows[row + depth];
            }
            self.scratch[depth] = own;
            columns[depth] = own * factor.inverse[path[depth] as usize];
            add_products(&mut response, columns[depth]);
        }
        self.finish(start, touch, response, self.ground_softness);
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
            self.scratch[dof] = V3::null(tree.kit);
            if dof >= ROOT && (with_one | with_two).any() {
                let body = dof + 1 - ROOT;
                let way = frames[body].moves(tree.travels[body], touch.point);
                let sign = S::pick(with_one, pair.side, -pair.side);
                let row = V3([way.dot(normal), way.dot(first), way.dot(second)]) * sign;
                self.scratch[dof] = V3::pick(with_one | with_two, row, V3::null(tree.kit));
            }
        }
        let dofs = &self.dofs[start..];
        let columns = self.columns.more(dofs.len(), V3::null(tree.kit));
        let mut response = [zero; 6];
        for (place, &dof) in dofs.iter().enumerate() {
            let dof = dof as usize;
            let own = self.scratch[dof];
            let path = tree.path_to(dof);
            let last = path.len() - 1;
            for (&other, &entry) in path[..last].iter().zip(factor.row(tree, dof, last)) {
                self.scratch[other as usize] -= own * entry;
            }
            columns[place] = own * factor.inverse[dof];
            add_products(&mut response, columns[place]);
        }
        self.finish(start, touch, response, self.pair_softness);
    }

    /// Adds the contact of the columns from `start` on, which has this response.
    #[inline(always)]
    fn finish(&mut self, start: usize, touch: &Touch<S>, response: [S; 6], softness: S) {
        let zero = touch.depth.like(0.0);
        let k = |value: f64| zero.like(value);
        let [nn, aa, bb, _, _, ab] = response;
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
            impulse: V3::null(zero.kit()),
            response,
            softness,
            yielding: S::pick(here, k(1.0) / (nn + softness), zero),
            slowest: S::pick(here, k(1.0) / (largest + softness), zero),
            determinant: S::pick(regular, k(1.0) / determinant, zero),
        });
    }
}

/// Adds the products of a column's entries, in the order of [`Contact::response`].
#[inline(always)]
fn add_products<S: Scalar>(sum: &mut [S; 6], V3([n, a, b]): V3<S>) {
    let products = [n * n, a * a, b * b, n * a, n * b, a * b];
    sum.iter_mut().zip(products).for_each(|(sum, product)| *sum += product);
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
    let first = V3([sign + n[0] * n[0] * a, -n[0], b]);
    let second = V3([sign * b, -sign * n[2], one + sign * n[2] * n[2] * a]);
    (first, second)
}
