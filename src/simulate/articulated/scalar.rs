//! The numbers the solver computes with: one run, or several runs side by side.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, MulAssign, Neg, Not, Sub, SubAssign};

/// A real number of each of several runs (its *lanes*) that go in lockstep:
/// `f32` and `f64` for one run, vectors of them for more.
///
/// All operations are lane by lane and give each lane the bits that it would
/// have alone. What depends on a comparison is therefore computed both ways and
/// [picked](Self::pick), unless all lanes agree.
pub(super) trait Scalar:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// Number of lanes.
    const LANES: usize;
    /// What it takes to make a number: the proof that the processor has the instructions.
    type Kit: Copy + Debug + Send + Sync + 'static;
    /// The outcome of a comparison in each lane.
    type Mask: Mask;

    /// The nearest such number, in every lane.
    fn of(kit: Self::Kit, value: f64) -> Self;
    /// What this number was made with.
    fn kit(self) -> Self::Kit;
    /// The number of one lane.
    fn lane(self, lane: usize) -> f64;
    /// Changes the number of one lane.
    fn set_lane(&mut self, lane: usize, value: f64);
    /// Takes over the number of one lane.
    fn copy_lane(&mut self, lane: usize, from: &Self);
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The larger of two.
    fn max(self, other: Self) -> Self;
    /// The smaller of two.
    fn min(self, other: Self) -> Self;
    /// Sine and cosine, the same on every platform.
    fn sin_cos(self) -> (Self, Self);
    /// Where this is less than another.
    fn less(self, other: Self) -> Self::Mask;
    /// Where this is at most another.
    fn at_most(self, other: Self) -> Self::Mask;
    /// The first number where the mask holds, the second elsewhere.
    fn pick(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The mask that holds in no lane or in all.
    fn mask(kit: Self::Kit, value: bool) -> Self::Mask;
    /// Calls with the processor's instructions switched on; what is to profit
    /// must be inlined into the call.
    fn call<R>(kit: Self::Kit, f: impl FnOnce() -> R) -> R;

    /// A constant for use beside this number.
    #[inline(always)]
    fn like(self, value: f64) -> Self {
        Self::of(self.kit(), value)
    }
    /// A number for each lane.
    fn each(kit: Self::Kit, value: impl Fn(usize) -> f64) -> Self {
        let mut own = Self::of(kit, value(0));
        (1..Self::LANES).for_each(|lane| own.set_lane(lane, value(lane)));
        own
    }
    /// Zero.
    #[inline(always)]
    fn zero(kit: Self::Kit) -> Self {
        Self::of(kit, 0.0)
    }
}

/// The outcome of a comparison in each lane.
pub(super) trait Mask:
    Copy + Debug + Send + Sync + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// A bit for each lane, the first lowest.
    fn bits(self) -> u32;
    /// Whether it holds in any lane.
    fn any(self) -> bool;
    /// Whether it holds in all lanes.
    fn all(self) -> bool;
}

impl Mask for bool {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
}

/// The lanes whose bits are set.
#[inline(always)]
pub(super) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        (bits != 0).then(|| {
            bits &= bits - 1;
            lane
        })
    })
}
