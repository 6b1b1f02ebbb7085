//! From an actuator of a grammar to load cases, and back to what a row of hinges needs.

use grammar_lang::ir::{self, BentBy, Construction, ExprKind, Field, RuleSet};
use grammar_lang::shape::Shape;
use grammar_lang::units::{self, Dimension};

use crate::solid::{Casting, Fitted, Hole, Load, Lost, Outline, UnderLoad, fit};

/// Actuators that are so many times as long as high are not computed: they need too many layers, and formulas are exact for them.
const SLIMMEST: f64 = 100.0;
/// The longest actuators that are computed have so many segments more than the shortest: beyond, lines are extended.
const FURTHER: usize = 4;

/// A kind of actuator that says how it is made.
#[derive(Clone, Debug)]
pub struct Constructed {
    /// Its name.
    pub name: String,
    /// What it is made of, and what bends it.
    pub construction: Construction,
    /// Length of a segment, m.
    pub segment: f64,
    /// Mass of a segment, kg.
    pub mass: f64,
    /// Numbers of segments that are computed, ascending.
    pub counts: Vec<usize>,
    /// Whether each actuator has its own number of segments.
    pub varies: bool,
    /// Whether it bends to both sides.
    pub both: bool,
    /// Whether it is made bent.
    rests_bent: bool,
    casting: Casting,
}

/// Why an actuator cannot be fitted.
#[derive(Clone, Debug, thiserror::Error)]
#[error("`{name}` with {segments} segments: {reason}")]
pub struct NotFitted {
    name: String,
    segments: usize,
    reason: String,
}

/// The kinds of actuators of a grammar that say how they are made.
#[must_use]
pub fn kinds(rules: &RuleSet) -> Vec<Constructed> {
    rules.actuators.iter().filter_map(|(name, actuator)| kind(name, actuator)).collect()
}

fn kind(name: &str, actuator: &ir::Actuator) -> Option<Constructed> {
    let construction = actuator.construction?;
    let (outline, segment) = match actuator.segment.fixed()?.shape {
        Shape::Cylinder { radius, half_length } => (Outline::Round { radius }, 2.0 * half_length),
        Shape::Box { half } => {
            let [width, height] = ir::across(&actuator.joint.axis, [half.x, half.y, half.z])?;
            (Outline::Box { width: 2.0 * width, height: 2.0 * height }, 2.0 * half.x)
        }
        Shape::Ball { .. } | Shape::Capsule { .. } => return None,
    };
    let material = construction.material;
    let mut casting = Casting {
        outline,
        hole: None,
        length: segment,
        young: material.young,
        poisson: material.poisson,
        winding: 0.0,
        sheet: 0.0,
        thread: 0.0,
    };
    match construction.bent_by {
        Some(BentBy::Chamber(chamber)) => {
            let edge = match chamber.hole {
                ir::Hole::Box { width, height } => Outline::Box { width, height },
                ir::Hole::Round { radius } => Outline::Round { radius },
            };
            casting.hole = Some(Hole { outline: edge, z: -chamber.offset });
            casting.winding = chamber.winding;
            casting.sheet = chamber.sheet;
        }
        Some(BentBy::Thread(thread)) => casting.thread = thread.offset,
        None => {}
    }
    let area = outline.area() - casting.hole.map_or(0.0, |hole| hole.outline.area());
    let param = actuator.params.get("segments");
    let (low, high) =
        param.and_then(|param| param.domain).map_or((2, 2), |(low, high)| (low as usize, high as usize));
    let high = high.min(low + FURTHER);
    let mut counts = vec![low, low.midpoint(high), high];
    counts.dedup();
    // A range that reads the number of segments begins at a plain 0, or below it.
    let both = match &actuator.joint.range {
        Some(Field::Fixed((low, _))) => *low < 0.0,
        Some(Field::Varies(range)) => match &range.kind {
            ExprKind::Range(low, _) => low.kind != ExprKind::Number(0.0),
            _ => false,
        },
        None => false,
    };
    Some(Constructed {
        name: name.to_owned(),
        construction,
        segment,
        mass: material.density * area * segment,
        counts,
        varies: param.is_some(),
        rests_bent: actuator.joint.neutral != Field::Fixed(0.0),
        both: both && matches!(construction.bent_by, Some(BentBy::Thread(_))),
        casting,
    })
}

impl Constructed {
    /// Computes its load cases. `done` is told when those of a length (m) are.
    pub fn fit(&self, done: &(dyn Fn(f64) + Sync)) -> Result<Fitted, NotFitted> {
        let load = match self.construction.bent_by {
            Some(BentBy::Chamber(chamber)) => Load { pressure: chamber.pressure, ..Load::default() },
            Some(BentBy::Thread(thread)) => Load { pull: thread.pull, ..Load::default() },
            None => Load::default(),
        };
        let unfit = |length: f64, reason: String| NotFitted {
            name: self.name.clone(),
            segments: (length / self.segment).round() as usize,
            reason,
        };
        let lengths: Vec<f64> = self.counts.iter().map(|count| self.length(*count)).collect();
        let longest = lengths.last().copied().unwrap_or(0.0);
        let height = self.casting.outline.height();
        if self.rests_bent {
            return Err(unfit(
                longest,
                "it is made bent (`neutral`), and only straight actuators can be computed".to_owned(),
            ));
        }
        if longest > SLIMMEST * height {
            return Err(unfit(
                longest,
                format!(
                    "it is more than {SLIMMEST} times as long as high: use the formulas of `std.materials`"
                ),
            ));
        }
        let fitted = fit(&self.casting, load, &lengths, done)
            .map_err(|(length, lost)| unfit(length, self.explained(lost)))?;
        let is_backward = |driven: &UnderLoad| {
            lengths.iter().any(|length| driven.bend.at(*length) <= 0.0 || driven.blocked.at(*length) <= 0.0)
        };
        match &fitted.driven {
            Some(driven) if is_backward(driven) => Err(unfit(
                longest,
                "its load bends it backwards; change the sign of the chamber's `offset`".to_owned(),
            )),
            _ => Ok(fitted),
        }
    }

    /// Why there is no equilibrium, and what to do.
    fn explained(&self, lost: Lost) -> String {
        let (what, share) = match lost {
            Lost::Buckles(share) => ("it buckles or balloons", share),
            Lost::Diverges(share) => ("no equilibrium was found", share),
        };
        match self.construction.bent_by {
            Some(BentBy::Chamber(chamber)) => {
                let at = units::shown(share * chamber.pressure, Dimension::PRESSURE);
                let mend = if chamber.winding == 0.0 {
                    "wind threads around it (`winding = 200 N/mm` in its `chamber`), or lower `pressure`"
                } else {
                    "lower `pressure`, or make its walls thicker"
                };
                format!("{what} at {at}; {mend}")
            }
            Some(BentBy::Thread(thread)) => {
                let at = units::shown(share * thread.pull, Dimension::FORCE);
                format!("{what} at {at}; lower `pull`, or make it thicker or of a firmer material")
            }
            None => format!("{what}; check the sizes of its segment"),
        }
    }

    /// What bends it, in words.
    #[must_use]
    pub fn load(&self) -> Option<String> {
        Some(match self.construction.bent_by? {
            BentBy::Chamber(chamber) => {
                format!("{} of air", units::shown(chamber.pressure, Dimension::PRESSURE))
            }
            BentBy::Thread(thread) => {
                format!("a thread pulled by {}", units::shown(thread.pull, Dimension::FORCE))
            }
        })
    }

    /// Its length with so many segments, m.
    #[must_use]
    pub fn length(&self, segments: usize) -> f64 {
        segments as f64 * self.segment
    }
}
