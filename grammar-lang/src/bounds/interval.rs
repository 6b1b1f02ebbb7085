//! Intervals of numbers, with ends that may be infinite.
//!
//! The operations round as the evaluation itself does, and rounding keeps the
//! order of numbers: so the ends need no widening, except where a function of
//! the library may be off by a bit.

/// All numbers from `low` to `high`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The least.
    pub low: f64,
    /// The greatest.
    pub high: f64,
}

impl Interval {
    /// Every number.
    pub const ALL: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };
    /// Zero and every positive number.
    pub const NOT_NEGATIVE: Self = Self { low: 0.0, high: f64::INFINITY };

    /// Between two ends.
    #[must_use]
    pub fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// One number alone.
    #[must_use]
    pub fn point(x: f64) -> Self {
        Self { low: x, high: x }
    }

    /// The number, if it is only one.
    #[must_use]
    pub fn single(self) -> Option<f64> {
        (self.low == self.high).then_some(self.low)
    }

    /// Whether both ends are numbers.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    /// The smallest interval that holds both.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The ends under a function that keeps the order of numbers.
    #[must_use]
    pub fn rising(self, f: impl Fn(f64) -> f64) -> Self {
        Self { low: f(self.low), high: f(self.high) }
    }

    /// A little more to each side, for what rounds in an order of its own.
    #[must_use]
    pub fn widened(self) -> Self {
        let more = |x: f64| x.abs() * 1e-9;
        Self { low: self.low - more(self.low), high: self.high + more(self.high) }.or_all()
    }

    /// Everything, where an end is no number: infinity less infinity.
    fn or_all(self) -> Self {
        Self {
            low: if self.low.is_nan() { f64::NEG_INFINITY } else { self.low },
            high: if self.high.is_nan() { f64::INFINITY } else { self.high },
        }
    }

    /// The sums.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self { low: self.low + other.low, high: self.high + other.high }.or_all()
    }

    /// The opposite numbers.
    #[must_use]
    pub fn negated(self) -> Self {
        Self { low: -self.high, high: -self.low }
    }

    /// The differences.
    #[must_use]
    pub fn minus(self, other: Self) -> Self {
        self.plus(other.negated())
    }

    /// The products. No number is infinite, so that zero times an open end is zero.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        let product = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
        let all = [
            product(self.low, other.low),
            product(self.low, other.high),
            product(self.high, other.low),
            product(self.high, other.high),
        ];
        Self {
            low: all.iter().copied().fold(f64::INFINITY, f64::min),
            high: all.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// The quotients; `None` if every one divides by zero.
    #[must_use]
    pub fn over(self, other: Self) -> Option<Self> {
        if other.low == 0.0 && other.high == 0.0 {
            return None;
        }
        if other.low < 0.0 && other.high > 0.0 {
            return Some(Self::ALL);
        }
        // An end that is zero is never divided by: near it, quotients have no bound.
        let quotient = |a: f64, b: f64, side: f64| {
            if a == 0.0 || b.is_infinite() {
                0.0
            } else if b == 0.0 {
                a * side * f64::INFINITY
            } else {
                a / b
            }
        };
        let side = if other.low >= 0.0 { 1.0 } else { -1.0 };
        let all = [
            quotient(self.low, other.low, side),
            quotient(self.low, other.high, side),
            quotient(self.high, other.low, side),
            quotient(self.high, other.high, side),
        ];
        Some(Self {
            low: all.iter().copied().fold(f64::INFINITY, f64::min),
            high: all.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        })
    }

    /// The sizes without the sign.
    #[must_use]
    pub fn abs(self) -> Self {
        let high = self.low.abs().max(self.high.abs());
        let low = if self.low <= 0.0 && self.high >= 0.0 { 0.0 } else { self.low.abs().min(self.high.abs()) };
        Self { low, high }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ordered(a: f64, b: f64) -> Interval {
        Interval::new(a.min(b), a.max(b))
    }

    proptest::proptest! {
        /// Whatever is computed with numbers of two intervals lies in what is computed with the intervals.
        #[test]
        fn operations_hold_every_result(
            a in -5.0f64..5.0, b in -5.0f64..5.0, c in -5.0f64..5.0, d in -5.0f64..5.0,
            s in 0.0f64..=1.0, t in 0.0f64..=1.0,
        ) {
            let (x, y) = (ordered(a, b), ordered(c, d));
            let within = |i: Interval, u: f64| (i.low + (i.high - i.low) * u).clamp(i.low, i.high);
            let (p, q) = (within(x, s), within(y, t));
            let holds = |i: Interval, v: f64| i.low <= v && v <= i.high;
            proptest::prop_assert!(holds(x.plus(y), p + q));
            proptest::prop_assert!(holds(x.minus(y), p - q));
            proptest::prop_assert!(holds(x.times(y), p * q));
            proptest::prop_assert!(holds(x.abs(), p.abs()));
            proptest::prop_assert!(holds(x.widened(), p));
            if q != 0.0 && let Some(quotients) = x.over(y) {
                proptest::prop_assert!(holds(quotients, p / q), "{p} / {q} in {quotients:?}");
            }
        }
    }

    #[test]
    fn open_ends_stay_sound() {
        let up = Interval::NOT_NEGATIVE;
        assert_eq!(up.times(up), up);
        assert_eq!(up.minus(up), Interval::ALL);
        assert_eq!(Interval::point(9.0).over(up.plus(Interval::point(1.0))), Some(Interval::new(0.0, 9.0)));
        assert_eq!(Interval::point(1.0).over(up), Some(Interval::NOT_NEGATIVE));
        assert_eq!(Interval::point(1.0).over(Interval::point(0.0)), None);
        assert_eq!(up.over(up), Some(Interval::NOT_NEGATIVE));
    }
}
