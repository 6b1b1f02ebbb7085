//! One number at a time: a lane of its own.

use super::angle;
use super::scalar::Scalar;

macro_rules! single {
    ($type:ty, $sin_cos:expr) => {
        impl Scalar for $type {
            const LANES: usize = 1;
            type Kit = ();
            type Mask = bool;

            #[inline(always)]
            fn of((): (), value: f64) -> Self {
                value as $type
            }
            #[inline(always)]
            fn kit(self) {}
            #[inline(always)]
            fn lane(self, _: usize) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn set_lane(&mut self, _: usize, value: f64) {
                *self = value as $type;
            }
            #[inline(always)]
            fn copy_lane(&mut self, _: usize, from: &Self) {
                *self = *from;
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            // Comparisons instead of `max` and `min`: one instruction each.
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                $sin_cos(self)
            }
            #[inline(always)]
            fn less(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn at_most(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn pick(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
            #[inline(always)]
            fn mask((): (), value: bool) -> bool {
                value
            }
            #[inline(always)]
            fn call<R>((): (), f: impl FnOnce() -> R) -> R {
                f()
            }
        }
    };
}

single!(f32, angle::sin_cos);
single!(f64, libm::sincos);
