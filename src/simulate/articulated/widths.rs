//! Solvers with as many lanes as the processor has room for.

use std::sync::Arc;

use fearless_simd::{Level, f32x4, f32x8};

use super::scalar::Scalar;
use super::solver::Solver;
use crate::simulate::lowering::Lowered;
use crate::simulate::run::{Row, Run};
use crate::simulate::widths::Width;
use crate::simulate::{Settings, Unfit, World};

/// Makes a solver of a number of lanes, if the processor has what it takes.
type Maker = fn(&Lowered, &Settings, &[World]) -> Option<Box<dyn Row>>;

/// The numbers of lanes that this processor can do well, narrowest first. One
/// lane always can.
pub(super) fn widths(lowered: Lowered, settings: &Settings) -> Vec<Width> {
    let lowered = Arc::new(lowered);
    let width = |lanes: usize, make: Maker| {
        let (lowered, settings) = (Arc::clone(&lowered), settings.clone());
        let missing = || Unfit { reason: "this processor has no such vectors".to_owned() };
        Width { lanes, make: Box::new(move |worlds| make(&lowered, &settings, worlds).ok_or_else(missing)) }
    };
    let mut widths = vec![width(1, |l, s, w| make::<f32>(Some(()), l, s, w))];
    let level = Level::new();
    #[cfg(target_arch = "x86_64")]
    {
        // Four lanes fill the vectors of SSE2; with AVX2 an instruction need not overwrite what it reads.
        if level.as_avx2().is_some() {
            widths.push(width(4, |l, s, w| make::<f32x4<_>>(Level::new().as_avx2(), l, s, w)));
        } else if level.as_sse2().is_some() {
            widths.push(width(4, |l, s, w| make::<f32x4<_>>(Level::new().as_sse2(), l, s, w)));
        }
        if level.as_avx2().is_some() {
            widths.push(width(8, |l, s, w| make::<f32x8<_>>(Level::new().as_avx2(), l, s, w)));
        }
        if level.as_avx512().is_some() {
            let wide = |l: &Lowered, s: &Settings, w: &[World]| {
                make::<fearless_simd::f32x16<_>>(Level::new().as_avx512(), l, s, w)
            };
            widths.push(width(16, wide));
        }
    }
    #[cfg(target_arch = "aarch64")]
    if level.as_neon().is_some() {
        widths.push(width(4, |l, s, w| make::<f32x4<_>>(Level::new().as_neon(), l, s, w)));
        widths.push(width(8, |l, s, w| make::<f32x8<_>>(Level::new().as_neon(), l, s, w)));
    }
    widths
}

/// A solver, if the processor has what it takes.
fn make<S: Scalar>(
    kit: Option<S::Kit>,
    lowered: &Lowered,
    settings: &Settings,
    worlds: &[World],
) -> Option<Box<dyn Row>> {
    let solver = Solver::<S>::new(kit?, lowered, settings, worlds);
    Some(Box::new(Run::new(solver, lowered.driven(), settings, worlds)))
}
