//! From an actuator of a grammar to load cases, and back to what a row of hinges needs.

use grammar_lang::ir::{self, BentBy, Construction, ExprKind, Field, RuleSet};
use grammar_lang::shape::Shape;
use grammar_lang::units::{self, Dimension};

use crate::solid::{Casting, Fitted, Hole, Load, Lost, Outline, fit};

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
        Shape::Box { half } => (Outline::Box { width: 2.0 * half.z, height: 2.0 * half.y }, 2.0 * half.x),
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
        both: both && matches!(construction.bent_by, Some(BentBy::Thread(_))),
        casting,
    })
}

impl Constructed {
    /// Computes its load cases.
    pub fn fit(&self) -> Result<Fitted, NotFitted> {
        let load = match self.construction.bent_by {
            Some(BentBy::Chamber(chamber)) => Load { pressure: chamber.pressure, ..Load::default() },
            Some(BentBy::Thread(thread)) => Load { pull: thread.pull, ..Load::default() },
            None => Load::default(),
        };
        let lengths: Vec<f64> = self.counts.iter().map(|count| *count as f64 * self.segment).collect();
        fit(&self.casting, load, &lengths).map_err(|(length, lost)| NotFitted {
            name: self.name.clone(),
            segments: (length / self.segment).round() as usize,
            reason: self.explained(lost),
        })
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
