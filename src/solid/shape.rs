//! Shape functions of second order, and the points at which integrals are taken.

/// The three functions of a line at a point from -1 to 1: their values, and their slopes.
pub(super) fn line(s: f64) -> ([f64; 3], [f64; 3]) {
    ([0.5 * s * (s - 1.0), 1.0 - s * s, 0.5 * s * (s + 1.0)], [s - 0.5, -2.0 * s, s + 0.5])
}

/// Places and weights of Gauss's rule with three points: exact to the fifth order.
pub(super) const THREE: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// The same with two points: exact to the third order.
pub(super) const TWO: [(f64, f64); 2] = [(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)];

/// Values and slopes of the nine functions of a face: the first direction is that of the first three nodes.
pub(super) fn face(s: f64, t: f64) -> ([f64; 9], [f64; 9], [f64; 9]) {
    let ((a, da), (b, db)) = (line(s), line(t));
    (
        std::array::from_fn(|n| a[n % 3] * b[n / 3]),
        std::array::from_fn(|n| da[n % 3] * b[n / 3]),
        std::array::from_fn(|n| a[n % 3] * db[n / 3]),
    )
}

/// The slopes of the 27 functions of a hexahedron along its three directions.
pub(super) fn solid(s: f64, t: f64, u: f64) -> [[f64; 3]; 27] {
    let ((a, da), (b, db), (c, dc)) = (line(s), line(t), line(u));
    std::array::from_fn(|n| {
        let (i, j, k) = (n % 3, n / 3 % 3, n / 9);
        [da[i] * b[j] * c[k], a[i] * db[j] * c[k], a[i] * b[j] * dc[k]]
    })
}
