//! Three-vectors, rotations and symmetric matrices of the numbers of lanes.

use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Sub, SubAssign};

use nalgebra::UnitQuaternion;

use super::scalar::Scalar;

/// A vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct V3<S>(pub(super) [S; 3]);

/// A matrix, by rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct M3<S>(pub(super) [V3<S>; 3]);

/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sym<S>(pub(super) [S; 6]);

/// A unit quaternion: w, x, y, z.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quat<S>(pub(super) [S; 4]);

impl<S: Scalar> Quat<S> {
    /// No turn.
    pub(super) fn still(kit: S::Kit) -> Self {
        Self([1.0, 0.0, 0.0, 0.0].map(|part| S::of(kit, part)))
    }

    /// The turn of each lane.
    pub(super) fn each(kit: S::Kit, turns: &[UnitQuaternion<f64>]) -> Self {
        let part = |of: fn(&UnitQuaternion<f64>) -> f64| S::each(kit, |lane| of(&turns[lane]));
        Self([part(|q| q.w), part(|q| q.i), part(|q| q.j), part(|q| q.k)])
    }
}

impl<S: Scalar> V3<S> {
    /// The null vector.
    #[inline(always)]
    pub(super) fn null(kit: S::Kit) -> Self {
        Self([S::zero(kit); 3])
    }

    /// The same vector in every lane.
    #[inline(always)]
    pub(super) fn constant(kit: S::Kit, v: [f64; 3]) -> Self {
        Self(v.map(|value| S::of(kit, value)))
    }

    /// One of two vectors, lane by lane.
    #[inline(always)]
    pub(super) fn pick(mask: S::Mask, yes: Self, no: Self) -> Self {
        let [Self([a, b, c]), Self([x, y, z])] = [yes, no];
        Self([S::pick(mask, a, x), S::pick(mask, b, y), S::pick(mask, c, z)])
    }

    /// Takes over one lane of another vector.
    #[inline(always)]
    pub(super) fn copy_lane(&mut self, lane: usize, from: &Self) {
        self.0.iter_mut().zip(&from.0).for_each(|(part, from)| part.copy_lane(lane, from));
    }

    /// One lane.
    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> V3<f64> {
        V3(self.0.map(|part| part.lane(lane)))
    }

    /// What stands for the instructions that these numbers use.
    #[inline(always)]
    pub(super) fn kit(&self) -> S::Kit {
        self.0[0].kit()
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> S {
        let [Self([a, b, c]), Self([x, y, z])] = [self, other];
        a * x + b * y + c * z
    }

    #[inline(always)]
    pub(super) fn cross(self, other: Self) -> Self {
        let [Self([a, b, c]), Self([x, y, z])] = [self, other];
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    #[inline(always)]
    pub(super) fn square(self) -> S {
        self.dot(self)
    }

    #[inline(always)]
    pub(super) fn length(self) -> S {
        self.square().sqrt()
    }
}

impl<S> Index<usize> for V3<S> {
    type Output = S;

    #[inline(always)]
    fn index(&self, axis: usize) -> &S {
        &self.0[axis]
    }
}

impl<S> IndexMut<usize> for V3<S> {
    #[inline(always)]
    fn index_mut(&mut self, axis: usize) -> &mut S {
        &mut self.0[axis]
    }
}

impl<S: Scalar> Add for V3<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let [Self([a, b, c]), Self([x, y, z])] = [self, other];
        Self([a + x, b + y, c + z])
    }
}

impl<S: Scalar> AddAssign for V3<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Scalar> Sub for V3<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let [Self([a, b, c]), Self([x, y, z])] = [self, other];
        Self([a - x, b - y, c - z])
    }
}

impl<S: Scalar> SubAssign for V3<S> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<S: Scalar> Mul<S> for V3<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: S) -> Self {
        let Self([a, b, c]) = self;
        Self([a * factor, b * factor, c * factor])
    }
}

impl<S: Scalar> M3<S> {
    /// The rotation by an angle about a unit axis.
    #[inline(always)]
    pub(super) fn rotation(axis: V3<S>, angle: S) -> Self {
        let (s, c) = angle.sin_cos();
        let t = axis * (c.like(1.0) - c);
        let u = axis * s;
        Self([
            V3([t[0] * axis[0] + c, t[0] * axis[1] - u[2], t[0] * axis[2] + u[1]]),
            V3([t[1] * axis[0] + u[2], t[1] * axis[1] + c, t[1] * axis[2] - u[0]]),
            V3([t[2] * axis[0] - u[1], t[2] * axis[1] + u[0], t[2] * axis[2] + c]),
        ])
    }

    /// One lane.
    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> M3<f64> {
        M3([self[0].lane(lane), self[1].lane(lane), self[2].lane(lane)])
    }

    /// `m^T v`.
    #[inline(always)]
    pub(super) fn transposed(&self, v: V3<S>) -> V3<S> {
        self[0] * v[0] + self[1] * v[1] + self[2] * v[2]
    }
}

impl<S> Index<usize> for M3<S> {
    type Output = V3<S>;

    #[inline(always)]
    fn index(&self, row: usize) -> &V3<S> {
        &self.0[row]
    }
}

impl<S: Scalar> Mul<V3<S>> for M3<S> {
    type Output = V3<S>;

    #[inline(always)]
    fn mul(self, v: V3<S>) -> V3<S> {
        V3([self[0].dot(v), self[1].dot(v), self[2].dot(v)])
    }
}

impl<S: Scalar> Mul for M3<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let Self([x, y, z]) = self;
        Self([other.transposed(x), other.transposed(y), other.transposed(z)])
    }
}

impl<S: Scalar> Quat<S> {
    /// The rotation matrix.
    #[inline(always)]
    pub(super) fn matrix(self) -> M3<S> {
        let Self([w, x, y, z]) = self;
        let (one, two) = (w.like(1.0), w.like(2.0));
        let pair = |a: S, b: S| two * a * b;
        M3([
            V3([one - pair(y, y) - pair(z, z), pair(x, y) - pair(w, z), pair(x, z) + pair(w, y)]),
            V3([pair(x, y) + pair(w, z), one - pair(x, x) - pair(z, z), pair(y, z) - pair(w, x)]),
            V3([pair(x, z) - pair(w, y), pair(y, z) + pair(w, x), one - pair(x, x) - pair(y, y)]),
        ])
    }

    /// Turned by a small rotation vector (world axes).
    ///
    /// Uses the series of sine and cosine to the fourth order of the half angle
    /// and normalises, exact to rounding for the angles of one time step.
    #[inline(always)]
    pub(super) fn turned(self, turn: V3<S>) -> Self {
        let Self([w, x, y, z]) = self;
        let k = |value: f64| w.like(value);
        let own = V3([x, y, z]);
        let half = turn * k(0.5);
        let square = half.square();
        let sinc = k(1.0) - square * (k(1.0 / 6.0) - square * k(1.0 / 120.0));
        let c = k(1.0) - square * (k(0.5) - square * k(1.0 / 24.0));
        let d = half * sinc;
        let v = d * w + own * c + d.cross(own);
        let w = c * w - d.dot(own);
        let shrink = k(1.0) / (w * w + v.square()).sqrt();
        let V3([x, y, z]) = v * shrink;
        Self([w * shrink, x, y, z])
    }
}

impl<S: Scalar> Sym<S> {
    /// The null matrix.
    #[inline(always)]
    pub(super) fn null(kit: S::Kit) -> Self {
        Self([S::zero(kit); 6])
    }

    /// `r m r^T`.
    #[inline(always)]
    pub(super) fn rotated(&self, M3(r): &M3<S>) -> Self {
        let rows = [*self * r[0], *self * r[1], *self * r[2]];
        Self([
            rows[0].dot(r[0]),
            rows[1].dot(r[1]),
            rows[2].dot(r[2]),
            rows[0].dot(r[1]),
            rows[0].dot(r[2]),
            rows[1].dot(r[2]),
        ])
    }
}

impl<S: Scalar> Mul<V3<S>> for Sym<S> {
    type Output = V3<S>;

    #[inline(always)]
    fn mul(self, v: V3<S>) -> V3<S> {
        let Self([xx, yy, zz, xy, xz, yz]) = self;
        let V3([x, y, z]) = v;
        V3([xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z])
    }
}
