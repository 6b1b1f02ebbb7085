//! One body in any worlds: solvers with as many lanes as are needed, made when they are first used.

use super::run::Row;
use super::{Case, Invalid, Motion, Settings, Simulation, Stop, Unfit, Watch, World};
use crate::design::assembly::Assembly;

/// More rows of worlds than this are not kept.
const KEPT: usize = 8;

/// A number of lanes that this processor does well.
pub(super) struct Width {
    /// How many.
    pub(super) lanes: usize,
    /// Makes a solver of a body, one world for each lane.
    pub(super) make: Make,
}

/// Makes a solver of a body for a row of worlds, if the processor has what it takes.
pub(super) type Make = Box<dyn Fn(&[World]) -> Result<Box<dyn Row>, Unfit> + Send>;

/// A solver for a row of worlds.
struct Ready {
    worlds: Vec<World>,
    row: Box<dyn Row>,
}

/// One body with solvers of several widths.
pub(super) struct Widths {
    /// Narrowest first.
    widths: Vec<Width>,
    /// The rows that were used last, the very last first.
    ready: Vec<Ready>,
}

/// A body for a solver that runs one case at a time: it is made anew for each world, as if it had been made so.
/// What cannot be simulated in the nominal world is refused at once.
pub(super) fn alone(
    assembly: &Assembly,
    settings: &Settings,
    make: impl Fn(&Assembly, &Settings, &World) -> Result<Box<dyn Row>, Unfit> + Send + 'static,
) -> Result<Box<dyn Simulation>, Unfit> {
    let nominal = Ready { worlds: vec![World::NOMINAL], row: make(assembly, settings, &World::NOMINAL)? };
    let (assembly, settings) = (assembly.clone(), settings.clone());
    let in_world = move |worlds: &[World]| {
        let world = worlds.first().unwrap_or(&World::NOMINAL);
        let (body, settings) = world.made(&assembly, &settings);
        make(&body, &settings, world)
    };
    let width = Width { lanes: 1, make: Box::new(in_world) };
    Ok(Box::new(Widths { widths: vec![width], ready: vec![nominal] }))
}

impl Widths {
    /// A body; the narrowest width comes first.
    pub(super) fn new(widths: Vec<Width>) -> Self {
        Self { widths, ready: Vec::new() }
    }

    /// The solver for a row of cases: those that are missing do what the last one does.
    fn row(&mut self, cases: &[Case<'_>]) -> Result<Option<&mut Ready>, Unfit> {
        let fits = |width: &&Width| width.lanes >= cases.len();
        let (Some(width), Some(last)) = (self.widths.iter().find(fits), cases.last()) else {
            return Ok(None);
        };
        let worlds = || cases.iter().chain(std::iter::repeat(last)).take(width.lanes).map(|case| case.world);
        let is_it = |ready: &Ready| ready.worlds.len() == width.lanes && ready.worlds.iter().eq(worlds());
        let ready = match self.ready.iter().position(is_it) {
            Some(place) => self.ready.remove(place),
            None => {
                let worlds: Vec<World> = worlds().cloned().collect();
                let row = (width.make)(&worlds)?;
                Ready { worlds, row }
            }
        };
        self.ready.truncate(KEPT - 1);
        self.ready.insert(0, ready);
        Ok(self.ready.first_mut())
    }
}

impl Simulation for Widths {
    fn lanes(&self) -> usize {
        self.widths.last().map_or(1, |width| width.lanes)
    }

    fn run_watched(
        &mut self,
        stop: Stop<'_>,
        cases: &[Case<'_>],
        watch: &dyn Watch,
    ) -> Option<Vec<Result<Motion, Invalid>>> {
        let widest = self.lanes();
        let mut outcomes = Vec::with_capacity(cases.len());
        for (number, chunk) in cases.chunks(widest).enumerate() {
            match self.row(chunk) {
                Ok(Some(ready)) => {
                    outcomes.extend(ready.row.together(stop, number * widest, chunk, watch)?)
                }
                Ok(None) | Err(_) => outcomes.extend(chunk.iter().map(|_| Err(Invalid::Unfit))),
            }
        }
        Some(outcomes)
    }
}
