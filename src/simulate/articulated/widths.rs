//! Runs of one body with as many lanes as the processor has room for.

use fearless_simd::{Level, f32x4, f32x8};

use super::scalar::Scalar;
use super::solver::Solver;
use crate::simulate::lowering::Lowered;
use crate::simulate::run::Run;
use crate::simulate::{Invalid, Motion, Settings, Simulation, Stop, Targets, Watch};

/// One body, and a solver for each number of lanes that has been asked for.
pub(super) struct Widths {
    lowered: Lowered,
    settings: Settings,
    /// Numbers of lanes, narrowest first, and their solvers.
    solvers: Vec<(Width, Option<Box<dyn Simulation>>)>,
}

/// A number of lanes that this processor can do well.
#[derive(Clone, Copy, Debug)]
struct Width {
    lanes: usize,
    make: fn(&Lowered, &Settings) -> Option<Box<dyn Simulation>>,
}

impl Widths {
    /// Solvers are made when they are first used.
    pub(super) fn new(lowered: Lowered, settings: &Settings) -> Self {
        let solvers = widths().into_iter().map(|width| (width, None)).collect();
        Self { lowered, settings: settings.clone(), solvers }
    }
}

impl Simulation for Widths {
    fn lanes(&self) -> usize {
        self.solvers.last().map_or(1, |(width, _)| width.lanes)
    }

    fn run_watched(
        &mut self,
        stop: Stop<'_>,
        drives: &[Targets],
        watch: &dyn Watch,
    ) -> Option<Vec<Result<Motion, Invalid>>> {
        let widest = self.lanes();
        let mut outcomes = Vec::with_capacity(drives.len());
        for (number, chunk) in drives.chunks(widest).enumerate() {
            let fits = |(width, _): &&mut (Width, _)| width.lanes >= chunk.len();
            let Some((width, solver)) = self.solvers.iter_mut().find(fits) else { continue };
            if solver.is_none() {
                *solver = (width.make)(&self.lowered, &self.settings);
            }
            if let Some(solver) = solver {
                let watch = From { first: number * widest, watch };
                outcomes.extend(solver.run_watched(stop, chunk, &watch)?);
            }
        }
        Some(outcomes)
    }
}

/// The watch of some of the drives: those from the first on.
struct From<'a> {
    first: usize,
    watch: &'a dyn Watch,
}

impl Watch for From<'_> {
    fn gives_up(&self, drive: usize, motion: &Motion, now: f64) -> bool {
        self.watch.gives_up(self.first + drive, motion, now)
    }
}

/// The numbers of lanes that this processor can do well, narrowest first. One
/// lane always can.
fn widths() -> Vec<Width> {
    let mut widths =
        vec![Width { lanes: 1, make: |lowered, settings| make::<f32>(Some(()), lowered, settings) }];
    let level = Level::new();
    #[cfg(target_arch = "x86_64")]
    {
        if level.as_sse2().is_some() {
            widths.push(Width { lanes: 4, make: |l, s| make::<f32x4<_>>(Level::new().as_sse2(), l, s) });
        }
        if level.as_avx2().is_some() {
            widths.push(Width { lanes: 8, make: |l, s| make::<f32x8<_>>(Level::new().as_avx2(), l, s) });
        }
        if level.as_avx512().is_some() {
            widths.push(Width {
                lanes: 16,
                make: |l, s| make::<fearless_simd::f32x16<_>>(Level::new().as_avx512(), l, s),
            });
        }
    }
    #[cfg(target_arch = "aarch64")]
    if level.as_neon().is_some() {
        widths.push(Width { lanes: 4, make: |l, s| make::<f32x4<_>>(Level::new().as_neon(), l, s) });
        widths.push(Width { lanes: 8, make: |l, s| make::<f32x8<_>>(Level::new().as_neon(), l, s) });
    }
    widths
}

/// A solver, if the processor has what it takes.
fn make<S: Scalar>(
    kit: Option<S::Kit>,
    lowered: &Lowered,
    settings: &Settings,
) -> Option<Box<dyn Simulation>> {
    let solver = Solver::<S>::new(kit?, lowered, settings);
    Some(Box::new(Run::new(solver, lowered.driven(), settings)))
}
