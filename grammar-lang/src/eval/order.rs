//! How numbers are compared. The same quantity in two units, or the same sum in another order, differs in its last
//! bits: `7 mm` and `0.7 cm`, `0.1 + 0.2` and `0.3`. Numbers that are as near as that count as equal.

/// Two numbers are the same if they differ by no more than this share of the larger.
const ROUNDING: f64 = 1e-12;

/// Whether two numbers differ by rounding only.
#[must_use]
pub fn is_same(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() <= ROUNDING * a.abs().max(b.abs()) && a.is_finite() && b.is_finite()
}

/// Whether one number is less than another, by more than rounding.
#[must_use]
pub fn is_less(a: f64, b: f64) -> bool {
    a < b && !is_same(a, b)
}

/// Whether a number lies between two others or is one of them.
#[must_use]
pub fn is_within(low: f64, x: f64, high: f64) -> bool {
    !x.is_nan() && !is_less(x, low) && !is_less(high, x)
}

/// The next whole number below; the nearest one, if only rounding is between.
#[must_use]
pub fn floor(x: f64) -> f64 {
    let nearest = libm::round(x);
    if is_same(x, nearest) { nearest } else { libm::floor(x) }
}

/// What is above the next whole number below: at least zero and less than one, and zero where only rounding lies
/// between the number and a whole one.
#[must_use]
pub fn fraction(x: f64) -> f64 {
    let part = x - floor(x);
    // What lies below zero by less than a number near one can tell is zero, too.
    if (0.0..1.0).contains(&part) || part.is_nan() { part } else { 0.0 }
}

/// The next whole number above; the nearest one, if only rounding is between.
#[must_use]
pub fn ceil(x: f64) -> f64 {
    -floor(-x)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_same_quantity_in_two_units_is_the_same() {
        let (mm, cm) = (0.001, 0.01);
        assert_ne!(7.0 * mm, 0.7 * cm, "their bits differ");
        assert!(is_same(7.0 * mm, 0.7 * cm) && !is_less(0.7 * cm, 7.0 * mm));
        assert_eq!((floor(0.7 * cm / mm), ceil(0.7 * cm / mm)), (7.0, 7.0));
        assert_eq!((floor(0.3 / 0.1), ceil(-0.3 / 0.1)), (3.0, -3.0));
        assert_eq!((fraction(0.7 * cm / mm), fraction(-0.25), fraction(3.0)), (0.0, 0.75, 0.0));
        assert_eq!((floor(6.99), ceil(6.01), floor(-0.5), ceil(-0.5)), (6.0, 7.0, -1.0, 0.0));
        assert!(is_less(1.0, 1.0 + 1e-9) && is_less(0.0, f64::MIN_POSITIVE));
        assert!(!is_same(f64::INFINITY, 1.0) && is_same(f64::INFINITY, f64::INFINITY));
        assert!(!is_same(f64::NAN, f64::NAN) && !is_within(0.0, f64::NAN, 1.0));
    }

    proptest! {
        /// What interval reasoning rests on.
        #[test]
        fn less_stays_less_where_the_ends_go_apart(a: f64, b: f64, down in 0.0..1e3_f64, up in 0.0..1e3_f64) {
            prop_assume!(is_less(a, b));
            prop_assert!(is_less(a - down, b + up));
            prop_assert!(!is_less(b, a));
        }
    }
}
