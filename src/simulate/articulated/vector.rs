//! Three-vectors, rotations and symmetric matrices as plain arrays.

use super::scalar::Scalar;

/// A vector.
pub(super) type V3<S> = [S; 3];
/// A matrix, by rows.
pub(super) type M3<S> = [[S; 3]; 3];
/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
pub(super) type Sym<S> = [S; 6];
/// A quaternion: w, x, y, z.
pub(super) type Quat<S> = [S; 4];

/// The same vector in every lane.
#[inline(always)]
pub(super) fn constant<S: Scalar>(kit: S::Kit, v: [f64; 3]) -> V3<S> {
    v.map(|value| S::of(kit, value))
}

/// The null vector.
#[inline(always)]
pub(super) fn null<S: Scalar>(kit: S::Kit) -> V3<S> {
    [S::zero(kit); 3]
}

/// Takes over one lane of another vector.
#[inline(always)]
pub(super) fn copy_lane<S: Scalar>(to: &mut V3<S>, lane: usize, from: &V3<S>) {
    to.iter_mut().zip(from).for_each(|(part, from)| part.copy_lane(lane, from));
}

/// One of two vectors, lane by lane.
#[inline(always)]
pub(super) fn pick<S: Scalar>(mask: S::Mask, yes: V3<S>, no: V3<S>) -> V3<S> {
    [S::pick(mask, yes[0], no[0]), S::pick(mask, yes[1], no[1]), S::pick(mask, yes[2], no[2])]
}

#[inline(always)]
pub(super) fn add<S: Scalar>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(super) fn sub<S: Scalar>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(super) fn scale<S: Scalar>(a: V3<S>, k: S) -> V3<S> {
    [a[0] * k, a[1] * k, a[2] * k]
}

#[inline(always)]
pub(super) fn dot<S: Scalar>(a: V3<S>, b: V3<S>) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn cross<S: Scalar>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
pub(super) fn length<S: Scalar>(a: V3<S>) -> S {
    dot(a, a).sqrt()
}

/// `m v`.
#[inline(always)]
pub(super) fn apply<S: Scalar>(m: &M3<S>, v: V3<S>) -> V3<S> {
    [dot(m[0], v), dot(m[1], v), dot(m[2], v)]
}

/// `m^T v`.
#[inline(always)]
pub(super) fn apply_transposed<S: Scalar>(m: &M3<S>, v: V3<S>) -> V3<S> {
    add(add(scale(m[0], v[0]), scale(m[1], v[1])), scale(m[2], v[2]))
}

/// `a b`.
#[inline(always)]
pub(super) fn product<S: Scalar>(a: &M3<S>, b: &M3<S>) -> M3<S> {
    [apply_transposed(b, a[0]), apply_transposed(b, a[1]), apply_transposed(b, a[2])]
}

/// Rotation by an angle about a unit axis.
#[inline(always)]
pub(super) fn rotation<S: Scalar>(axis: V3<S>, angle: S) -> M3<S> {
    let (s, c) = angle.sin_cos();
    let t = scale(axis, c.like(1.0) - c);
    let u = scale(axis, s);
    [
        [t[0] * axis[0] + c, t[0] * axis[1] - u[2], t[0] * axis[2] + u[1]],
        [t[1] * axis[0] + u[2], t[1] * axis[1] + c, t[1] * axis[2] - u[0]],
        [t[2] * axis[0] - u[1], t[2] * axis[1] + u[0], t[2] * axis[2] + c],
    ]
}

/// The rotation of a unit quaternion.
#[inline(always)]
pub(super) fn matrix<S: Scalar>(q: Quat<S>) -> M3<S> {
    let [w, x, y, z] = q;
    let (one, two) = (w.like(1.0), w.like(2.0));
    let pair = |a: S, b: S| two * a * b;
    [
        [one - pair(y, y) - pair(z, z), pair(x, y) - pair(w, z), pair(x, z) + pair(w, y)],
        [pair(x, y) + pair(w, z), one - pair(x, x) - pair(z, z), pair(y, z) - pair(w, x)],
        [pair(x, z) - pair(w, y), pair(y, z) + pair(w, x), one - pair(x, x) - pair(y, y)],
    ]
}

/// Turns a unit quaternion by a small rotation vector (world axes).
///
/// Uses the series of sine and cosine to the fourth order of the half angle
/// and normalises, exact to rounding for the angles of one time step.
#[inline(always)]
pub(super) fn turned<S: Scalar>(q: Quat<S>, turn: V3<S>) -> Quat<S> {
    let k = |value: f64| q[0].like(value);
    let half = scale(turn, k(0.5));
    let square = dot(half, half);
    let sinc = k(1.0) - square * (k(1.0 / 6.0) - square * k(1.0 / 120.0));
    let c = k(1.0) - square * (k(0.5) - square * k(1.0 / 24.0));
    let d = scale(half, sinc);
    let [w, x, y, z] = q;
    let v = add(add(scale(d, w), scale([x, y, z], c)), cross(d, [x, y, z]));
    let w = c * w - dot(d, [x, y, z]);
    let shrink = k(1.0) / (w * w + dot(v, v)).sqrt();
    [w * shrink, v[0] * shrink, v[1] * shrink, v[2] * shrink]
}

/// `m v` for a symmetric matrix.
#[inline(always)]
pub(super) fn apply_sym<S: Scalar>(m: &Sym<S>, v: V3<S>) -> V3<S> {
    [
        m[0] * v[0] + m[3] * v[1] + m[4] * v[2],
        m[3] * v[0] + m[1] * v[1] + m[5] * v[2],
        m[4] * v[0] + m[5] * v[1] + m[2] * v[2],
    ]
}

/// `r m r^T`.
#[inline(always)]
pub(super) fn rotated<S: Scalar>(m: &Sym<S>, r: &M3<S>) -> Sym<S> {
    let rows = [apply_sym(m, r[0]), apply_sym(m, r[1]), apply_sym(m, r[2])];
    [
        dot(rows[0], r[0]),
        dot(rows[1], r[1]),
        dot(rows[2], r[2]),
        dot(rows[0], r[1]),
        dot(rows[0], r[2]),
        dot(rows[1], r[2]),
    ]
}
