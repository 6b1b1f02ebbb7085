//! The factorisation H = L^T D L along the tree and what is solved with it
//! (Featherstone 2008, section 6.5).
//!
//! The contact solver works in y = D^(1/2) L v: there the kinetic energy is
//! |y|^2 / 2, an impulse p along a row J changes y by D^(-1/2) L^(-T) J^T p,
//! and that row has no entries off the path of its body.

use super::scalar::Scalar;
use super::tree::Tree;

/// The factors; L is unit lower triangular and has the rows of H.
#[derive(Clone, Debug)]
pub(super) struct Factor<S> {
    /// H before, L (and D on its diagonal) after the factorisation.
    pub(super) rows: Vec<S>,
    /// Square root of D.
    pub(super) root: Vec<S>,
    /// Its inverse.
    pub(super) inverse: Vec<S>,
}

impl<S: Scalar> Factor<S> {
    /// Room for the factors of a tree.
    pub(super) fn new(tree: &Tree<S>) -> Self {
        let zero = S::zero(tree.kit);
        let dofs = vec![zero; tree.dofs()];
        Self { rows: vec![zero; tree.entries], root: dofs.clone(), inverse: dofs }
    }

    /// Replaces H by its factors.
    #[inline(always)]
    pub(super) fn factorise(&mut self, tree: &Tree<S>) {
        let one = S::of(tree.kit, 1.0);
        for dof in (0..tree.dofs()).rev() {
            let path = tree.path_to(dof);
            let last = path.len() - 1;
            let (above, row) = self.rows.split_at_mut(tree.rows[dof]);
            let row = &mut row[..=last];
            let diagonal = row[last];
            let inverse = one / diagonal;
            for k in (0..last).rev() {
                let factor = row[k] * inverse;
                let start = tree.rows[path[k] as usize];
                for (entry, &own) in above[start..start + k + 1].iter_mut().zip(&row[..=k]) {
                    *entry -= factor * own;
                }
            }
            for entry in &mut row[..last] {
                *entry *= inverse;
            }
            let root = diagonal.sqrt();
            self.root[dof] = root;
            self.inverse[dof] = one / root;
        }
    }

    /// The entries of L left of the diagonal.
    #[inline(always)]
    pub(super) fn row(&self, tree: &Tree<S>, dof: usize, length: usize) -> &[S] {
        let start = tree.rows[dof];
        &self.rows[start..start + length]
    }

    /// y = D^(1/2) L v + D^(-1/2) L^(-T) p; destroys the impulses p.
    #[inline(always)]
    pub(super) fn transform(&self, tree: &Tree<S>, v: &[S], p: &mut [S], y: &mut [S]) {
        for dof in (0..tree.dofs()).rev() {
            let path = tree.path_to(dof);
            let last = path.len() - 1;
            let impulse = p[dof];
            let mut sum = v[dof];
            for (&entry, &other) in self.row(tree, dof, last).iter().zip(path) {
                p[other as usize] -= entry * impulse;
                sum += entry * v[other as usize];
            }
            y[dof] = self.root[dof] * sum + self.inverse[dof] * impulse;
        }
    }

    /// v = L^(-1) D^(-1/2) y.
    #[inline(always)]
    pub(super) fn restore(&self, tree: &Tree<S>, y: &[S], v: &mut [S]) {
        for dof in 0..tree.dofs() {
            let path = tree.path_to(dof);
            let mut sum = y[dof] * self.inverse[dof];
            for (&entry, &other) in self.row(tree, dof, path.len() - 1).iter().zip(path) {
                sum -= entry * v[other as usize];
            }
            v[dof] = sum;
        }
    }
}
