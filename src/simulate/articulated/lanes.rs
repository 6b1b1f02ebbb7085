//! Several runs side by side: vectors of the processor as numbers.

use fearless_simd::prelude::*;
use fearless_simd::{f32x4, f32x8, f32x16, mask32x4, mask32x8, mask32x16};

use super::scalar::{Mask, Scalar};

macro_rules! lanes {
    ($vector:ident, $mask:ident, $lanes:literal) => {
        impl<K: Simd> Scalar for $vector<K> {
            const LANES: usize = $lanes;
            type Kit = K;
            type Mask = $mask<K>;

            #[inline(always)]
            fn of(kit: K, value: f64) -> Self {
                Self::splat(kit, value as f32)
            }
            #[inline(always)]
            fn kit(self) -> K {
                self.simd
            }
            #[inline(always)]
            fn lane(self, lane: usize) -> f64 {
                f64::from(self[lane])
            }
            #[inline(always)]
            fn set_lane(&mut self, lane: usize, value: f64) {
                self[lane] = value as f32;
            }
            #[inline(always)]
            fn copy_lane(&mut self, lane: usize, from: &Self) {
                self[lane] = from[lane];
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                SimdFloat::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                SimdBase::abs(self)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                SimdBase::max(self, other)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                SimdBase::min(self, other)
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                super::angle::sin_cos(self)
            }
            #[inline(always)]
            fn less(self, other: Self) -> Self::Mask {
                self.simd_lt(other)
            }
            #[inline(always)]
            fn at_most(self, other: Self) -> Self::Mask {
                self.simd_le(other)
            }
            #[inline(always)]
            fn pick(mask: Self::Mask, yes: Self, no: Self) -> Self {
                mask.select(yes, no)
            }
            #[inline(always)]
            fn mask(kit: K, value: bool) -> Self::Mask {
                <$mask<K> as SimdMask<K>>::splat(kit, value)
            }
            #[inline(always)]
            fn call<R>(kit: K, f: impl FnOnce() -> R) -> R {
                kit.vectorize(
                    #[inline(always)]
                    || f(),
                )
            }
        }

        impl<K: Simd> Mask for $mask<K> {
            #[inline(always)]
            fn bits(self) -> u32 {
                self.to_bitmask() as u32
            }
            #[inline(always)]
            fn any(self) -> bool {
                self.any_true()
            }
            #[inline(always)]
            fn all(self) -> bool {
                self.all_true()
            }
        }
    };
}

lanes!(f32x4, mask32x4, 4);
lanes!(f32x8, mask32x8, 8);
lanes!(f32x16, mask32x16, 16);
