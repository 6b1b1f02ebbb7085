//! What a kind of part is.

use indexmap::IndexMap;

use super::{Actuator, InstanceParam, Lattice, Part, RuleSet};

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
    pub fn params(self) -> Option<&'r IndexMap<String, InstanceParam>> {
        match self {
            Self::Block(_) => None,
            Self::Actuator(actuator) => Some(&actuator.params),
            Self::Cell(lattice) => Some(&lattice.cell.params),
        }
    }
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

    /// Whether `kind` names an actuator.
    #[must_use]
    pub fn is_actuator(&self, kind: &str) -> bool {
        self.actuators.contains_key(kind)
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

    /// The parameters that parts of a kind have.
    #[must_use]
    pub fn params_of(&self, kind: &str) -> Option<&IndexMap<String, InstanceParam>> {
        self.kind(kind)?.params()
    }
}
