//! What a kind of part is.

use indexmap::IndexMap;

use super::{Actuator, Expr, ExprKind, Field, InstanceParam, Joint, Lattice, Part, RuleSet, Target, Task};

/// What a name stands for that a part may have for its kind.
#[derive(Clone, Copy, Debug)]
pub enum Kind<'r> {
    /// A passive part.
    Block(&'r Part),
    /// An actuator.
    Actuator(&'r Actuator),
    /// A cell of the lattice.
    Cell(&'r Lattice),
}

impl<'r> Kind<'r> {
    /// The parameters that parts of this kind have.
    #[must_use]
    pub fn params(self) -> &'r IndexMap<String, InstanceParam> {
        match self {
            Self::Block(part) => &part.params,
            Self::Actuator(actuator) => &actuator.params,
            Self::Cell(lattice) => &lattice.cell.params,
        }
    }

    /// Whether a field reads a parameter.
    #[must_use]
    pub fn reads(self, param: &str) -> bool {
        let Some(slot) = self.params().get_index_of(param) else { return false };
        let reads = |expr: &Expr| expr.any(&mut |e| matches!(e.kind, ExprKind::Local(s) if s == slot));
        self.varying().any(|(_, expr)| reads(expr))
    }

    /// The fields that read the parameters, by name.
    pub fn varying(self) -> impl Iterator<Item = (&'static str, &'r Expr)> {
        let fields: Vec<(&'static str, Option<&'r Expr>)> = match self {
            Self::Block(part) => {
                let ports = part.ports.iter().flat_map(|port| [port.at.varies(), port.facing.varies()]);
                let own = [
                    ("shape", part.shape.varies()),
                    (part.mass.field(), part.mass.varies()),
                    ("friction", part.friction.varies()),
                    ("colour", part.colour.varies()),
                ];
                let joint = part.joint.iter().flat_map(of_joint);
                own.into_iter().chain(ports.map(|port| ("port", port))).chain(joint).collect()
            }
            Self::Actuator(actuator) => {
                let joint = actuator.joint.kind;
                let motor = actuator.motor.iter().flat_map(|motor| {
                    [
                        (joint.speed_field(), motor.speed.varies()),
                        ("relaxing_speed", motor.relaxing_speed.varies()),
                        (joint.effort_field(), motor.effort.varies()),
                    ]
                });
                let own = [
                    ("segment", actuator.segment.varies()),
                    (actuator.mass.field(), actuator.mass.varies()),
                    ("friction", actuator.friction.varies()),
                    ("colour", actuator.colour.varies()),
                ];
                own.into_iter().chain(motor).chain(of_joint(&actuator.joint)).collect()
            }
            Self::Cell(lattice) => {
                let cell = &lattice.cell;
                let varies = |value: &'r Expr| {
                    let own = |e: &Expr| matches!(e.kind, ExprKind::Local(_) | ExprKind::OfBody(_));
                    Some(value).filter(|value| value.any(&mut |e| own(e)))
                };
                vec![
                    ("mass", varies(&cell.mass)),
                    ("friction", varies(&cell.friction)),
                    ("stiffness", varies(&cell.stiffness)),
                    ("damping", varies(&cell.damping)),
                    ("colour", varies(&cell.colour)),
                ]
            }
        };
        fields.into_iter().filter_map(|(name, expr)| Some((name, expr?)))
    }
}

/// The fields of a joint that may read parameters.
fn of_joint(joint: &Joint) -> [(&'static str, Option<&Expr>); 7] {
    [
        ("joint", joint.axis.varies()),
        (joint.kind.range(), joint.range.as_ref().and_then(Field::varies)),
        ("stiffness", joint.stiffness.varies()),
        ("damping", joint.damping.varies()),
        ("neutral", joint.neutral.varies()),
        ("begins", joint.begins.as_ref().and_then(Field::varies)),
        ("pivot", joint.pivot.as_ref().and_then(Field::varies)),
    ]
}

impl RuleSet {
    /// What a kind is, if it is declared.
    #[must_use]
    pub fn kind(&self, name: &str) -> Option<Kind<'_>> {
        let cell = || self.lattice.as_ref().filter(|lattice| lattice.kind == name).map(Kind::Cell);
        let block = || self.parts.get(name).map(Kind::Block);
        let actuator = || self.actuators.get(name).map(Kind::Actuator);
        block().or_else(actuator).or_else(cell)
    }

    /// Whether `kind` names an actuator: a row of segments that something drives.
    #[must_use]
    pub fn is_actuator(&self, kind: &str) -> bool {
        self.actuators.get(kind).is_some_and(|row| row.motor.is_some())
    }

    /// Whether `kind` names the cells of the lattice.
    #[must_use]
    pub fn is_cell(&self, kind: &str) -> bool {
        matches!(self.kind(kind), Some(Kind::Cell(_)))
    }

    /// Whether something drives parts of a kind: an actuator, or cells that a task actuates.
    #[must_use]
    pub fn is_driven(&self, kind: &str) -> bool {
        self.is_actuator(kind) || self.tasks.values().any(|task| task.actuated.contains_key(kind))
    }

    /// The targets that a task is simulated on, by name.
    pub fn targets_of<'r>(&'r self, task: &'r Task) -> impl Iterator<Item = (&'r str, &'r Target)> {
        task.on.iter().filter_map(|name| Some((name.as_str(), self.targets.get(name)?)))
    }

    /// The parameters that parts of a kind have.
    #[must_use]
    pub fn params_of(&self, kind: &str) -> Option<&IndexMap<String, InstanceParam>> {
        Some(self.kind(kind)?.params())
    }
}
