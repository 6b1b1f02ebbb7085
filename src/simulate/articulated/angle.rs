//! Sine and cosine of several angles at once, the same bits on every platform.

use super::scalar::Scalar;

/// 1.5 times 2 to the 23rd: adding it leaves no room for a fraction.
const ROUNDER: f64 = 12_582_912.0;
/// Half of pi in three parts; the first two have few enough bits for exact products.
const QUARTER: [f64; 3] = [1.570_312_5, 4.837_512_969_970_703e-4, 7.549_789_948_768_648e-8];

/// Sine and cosine in single precision, to about its last bit for the angles
/// of hinges: Cody and Waite's reduction to an eighth of a turn either way and
/// the polynomials of Cephes (`sinf.c`, Moshier).
#[inline(always)]
pub(super) fn sin_cos<S: Scalar>(angle: S) -> (S, S) {
    let k = |value: f64| angle.like(value);
    let round = |value: S| (value + k(ROUNDER)) - k(ROUNDER);
    let turns = round(angle * k(std::f64::consts::FRAC_2_PI));
    let r = ((angle - turns * k(QUARTER[0])) - turns * k(QUARTER[1])) - turns * k(QUARTER[2]);
    let z = r * r;
    let sine = r + r * z * (k(-1.666_665_461_1e-1) + z * (k(8.332_160_873_6e-3) - z * k(1.951_529_589_1e-4)));
    let tail =
        k(4.166_664_568_298_827e-2) + z * (k(-1.388_731_625_493_765e-3) + z * k(2.443_315_711_809_948e-5));
    let cosine = k(1.0) - z * k(0.5) + z * z * tail;
    // Which quarter of the circle, 0 to 3, exactly.
    let quarter = turns - k(4.0) * round(turns * k(0.25) - k(0.375));
    let odd = (quarter - k(2.0)).abs();
    let swap = k(0.5).less(odd) & odd.less(k(1.5));
    let sine_down = k(1.5).less(quarter);
    let cosine_down = k(0.5).less(quarter) & quarter.less(k(2.5));
    let (s, c) = (S::pick(swap, cosine, sine), S::pick(swap, sine, cosine));
    (S::pick(sine_down, -s, s), S::pick(cosine_down, -c, c))
}

#[cfg(test)]
mod tests {
    use super::sin_cos;

    #[test]
    fn sines_and_cosines_are_right_to_the_last_bits() {
        for count in -40_000..=40_000 {
            let angle = count as f32 * 5e-4;
            let (s, c) = sin_cos(angle);
            let (sine, cosine) = libm::sincos(f64::from(angle));
            assert!((f64::from(s) - sine).abs() < 1.2e-7, "sine of {angle}: {s}, not {sine}");
            assert!((f64::from(c) - cosine).abs() < 1.2e-7, "cosine of {angle}: {c}, not {cosine}");
        }
    }
}
