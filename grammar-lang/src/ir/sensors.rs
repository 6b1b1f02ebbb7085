//! What a robot measures of itself.

use serde::{Deserialize, Serialize};

use super::text::{Names, Writer, group, quantity};
use super::{Expr, ExprKind, Function, Group, RuleSet, Ty};
use crate::source::Span;

/// A sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sensor {
    /// The parts that have one each; none where the robot has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub of: Option<Group>,
    /// The type of what it reads: a quantity or a Bool.
    pub ty: Ty,
    /// What it reads. The part that has it is local 0, where parts have one each.
    pub value: Expr,
    /// Standard deviation of its noise, in SI units; of a Bool how likely a reading is wrong.
    pub noise: f64,
    /// How old what it reads is at least, s.
    pub delay: f64,
    /// Where it is declared.
    pub span: Span,
}

impl RuleSet {
    /// Whether an expression reads a heading, directly or by a sensor, so that its sign counts: in a mirror it is the opposite.
    #[must_use]
    pub fn knows_a_side(&self, value: &Expr) -> bool {
        let turns = |e: &Expr| matches!(e.kind, ExprKind::Call(Function::Heading, _));
        let reads = value.any(&mut |e| match &e.kind {
            ExprKind::Sensor(name, _) => {
                self.sensors.get(name).is_some_and(|sensor| sensor.value.any(&mut |e| turns(e)))
            }
            _ => turns(e),
        });
        // What is even has lost the sign.
        reads && !value.any(&mut |e| matches!(e.kind, ExprKind::Call(Function::Cos | Function::Abs, _)))
    }
}

impl Writer<'_> {
    pub(super) fn sensor(&mut self, name: &str, sensor: &Sensor) {
        let mut names = Names::new();
        let of = sensor.of.as_ref().map_or(String::new(), |of| {
            names.push("a".to_owned());
            format!("(a : {})", group(of))
        });
        let noise = match &sensor.ty {
            _ if sensor.noise == 0.0 => String::new(),
            Ty::Bool => format!(" noise {}", sensor.noise),
            ty => format!(" noise {}", quantity(sensor.noise, ty)),
        };
        let delay = match sensor.delay {
            0.0 => String::new(),
            delay => format!(" delay {}", crate::units::shown(delay, crate::units::Dimension::TIME)),
        };
        let value = self.expr(&sensor.value, &names);
        self.line(0, format!("sense {name}{of} : {} = {value}{noise}{delay}", sensor.ty));
    }
}
