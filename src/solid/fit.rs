//! The load cases of an actuator, for several lengths, and the lines through what they come to.

use rayon::prelude::*;

use super::statics::{ElasticBody, Lost, TipMotion};
use super::{Casting, Load};

/// Layers for each height of the cross-section, and the fewest of an actuator.
const LAYERS: f64 = 2.0;
const FEWEST_LAYERS: usize = 4;
/// Elements through a wall.
const FINENESS: usize = 1;
/// The share of the load at which the first slope is taken.
const LITTLE: f64 = 0.01;
/// The tip is held to so many rad.
const HELD: f64 = 1e-5;
/// rad
const TURN: f64 = 2.0 * std::f64::consts::PI;
/// So many corrections of the moment that holds the tip: three or four are enough.
const CORRECTIONS: usize = 30;
/// Shares of the load at which the bend is recorded.
const SHARES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// A quantity as a line over the length of the actuator: `base + slope * length`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Where the line begins; far ends hold an actuator, so that this is not zero.
    pub base: f64,
    /// For each metre.
    pub slope: f64,
}

impl Law {
    /// At a length in m.
    #[must_use]
    pub fn at(self, length: f64) -> f64 {
        self.base + self.slope * length
    }

    fn through(ends: [(f64, f64); 2]) -> Self {
        let [(from, low), (to, high)] = ends;
        let slope = if to > from { (high - low) / (to - from) } else { 0.0 };
        Self { base: low - slope * from, slope }
    }
}

/// What the load cases of an actuator come to.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// How far a moment bends it without a load, rad/(N m).
    pub compliance: Law,
    /// How far a moment bends it sideways, rad/(N m).
    pub sideways: Law,
    /// How far a moment twists it, rad/(N m).
    pub twist: Law,
    /// What the load does, if anything drives it.
    pub driven: Option<UnderLoad>,
    /// By which share a length between the two ends differs most from these lines.
    pub off: f64,
}

/// What the load of an actuator does.
#[derive(Clone, Debug, PartialEq)]
pub struct UnderLoad {
    /// How far it bends if nothing holds it, rad.
    pub bend: Law,
    /// The moment that holds its tip straight, N m: hardly any length matters.
    pub blocked: Law,
    /// Shares of the load with the bend (rad) of the longest actuator that was computed, free.
    pub curve: Vec<(f64, f64)>,
}

/// What one length comes to.
struct Cases {
    length: f64,
    compliance: f64,
    sideways: f64,
    twist: f64,
    bend: f64,
    blocked: f64,
    curve: Vec<(f64, f64)>,
}

/// Computes the load cases of an actuator at these lengths (m), in ascending order. `Err` has the length at which it failed.
/// `done` is told each length that is computed.
pub fn fit(
    casting: &Casting,
    load: Load,
    lengths: &[f64],
    done: &(dyn Fn(f64) + Sync),
) -> Result<Fitted, (f64, Lost)> {
    let cases: Result<Vec<Cases>, (f64, Lost)> = lengths
        .par_iter()
        .map(|&length| {
            let cases = one(&Casting { length, ..*casting }, load).map_err(|lost| (length, lost))?;
            done(length);
            Ok(cases)
        })
        .collect();
    let cases = cases?;
    let (Some(first), Some(last)) = (cases.first(), cases.last()) else {
        return Err((0.0, Lost::Diverges(0.0)));
    };
    let law = |of: fn(&Cases) -> f64| Law::through([(first.length, of(first)), (last.length, of(last))]);
    let is_driven = load != Load::default();
    let mut kinds: Vec<fn(&Cases) -> f64> = vec![|c| c.compliance, |c| c.sideways, |c| c.twist];
    if is_driven {
        kinds.extend([(|c| c.bend) as fn(&Cases) -> f64, |c| c.blocked]);
    }
    let off = |case: &Cases| {
        kinds.iter().map(|of| (of(case) / law(*of).at(case.length) - 1.0).abs()).fold(0.0, f64::max)
    };
    Ok(Fitted {
        compliance: law(|c| c.compliance),
        sideways: law(|c| c.sideways),
        twist: law(|c| c.twist),
        off: cases.iter().map(off).fold(0.0, f64::max),
        driven: is_driven.then(|| UnderLoad {
            bend: law(|c| c.bend),
            blocked: law(|c| c.blocked),
            curve: last.curve.clone(),
        }),
    })
}

fn one(casting: &Casting, load: Load) -> Result<Cases, Lost> {
    let layers = libm::round(LAYERS * casting.length / casting.outline.height()) as usize;
    let solid = ElasticBody::new(casting, layers.max(FEWEST_LAYERS), FINENESS);
    let rest = solid.rest();
    let unloaded = |motion| solid.compliance(&rest, Load::default(), motion);
    let compliance = unloaded(TipMotion::Bend)?;
    let (mut curve, mut blocked) = (Vec::new(), 0.0);
    if load != Load::default() {
        let mut bend = 0.0;
        solid.loaded(load, &mut |share, state| {
            // Beyond half a turn it goes on from what it was.
            let within = solid.bend(state);
            bend = within + TURN * libm::round((bend - within) / TURN);
            if SHARES.contains(&share) {
                curve.push((share, bend));
            }
        })?;
        blocked = held(&solid, load, compliance)?;
    }
    Ok(Cases {
        length: casting.length,
        compliance,
        sideways: unloaded(TipMotion::Sideways)?,
        twist: unloaded(TipMotion::Twist)?,
        bend: curve.last().map_or(0.0, |(_, bend)| *bend),
        blocked,
        curve,
    })
}

/// The moment with which the tip stays straight under a load, N m.
fn held(solid: &ElasticBody, load: Load, compliance: f64) -> Result<f64, Lost> {
    let little = Load { pressure: LITTLE * load.pressure, pull: LITTLE * load.pull, moment: 0.0 };
    let first = solid.bend(&solid.equilibrium(&solid.rest(), little)?) / LITTLE / compliance;
    let mut moment = first;
    let (mut state, mut known) = (solid.rest(), Load::default());
    for _ in 0..CORRECTIONS {
        let held = Load { moment: -moment, ..load };
        let found = solid.moved((&state, known), held, &mut |_, _| {})?;
        let bend = solid.bend(&found);
        if bend.abs() < HELD {
            return Ok(moment);
        }
        moment += bend / solid.compliance(&found, held, TipMotion::Bend)?;
        if moment.is_nan() || moment.abs() > 100.0 * first.abs() {
            return Err(Lost::Diverges(1.0));
        }
        (state, known) = (found, held);
    }
    Err(Lost::Diverges(1.0))
}
