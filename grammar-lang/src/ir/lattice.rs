//! The other space of designs: a grid of places, each with a cell or without.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::text::{Names, Writer};
use super::{Binder, Effect, Expr, InstanceParam};
use crate::source::Span;
use crate::units::{self, Dimension};

/// Offsets of the neighbours that a cell is joined to: those that share a face or an edge with it.
pub const JOINED: [[i32; 3]; 18] = {
    let mut offsets = [[0; 3]; 18];
    let mut count = 0;
    let mut i = 0;
    while i < 27 {
        let offset = [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1];
        let far = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
        if far == 1 || far == 2 {
            offsets[count] = offset;
            count += 1;
        }
        i += 1;
    }
    offsets
};

/// A grid of places and what stands on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lattice {
    /// How many places there are along x, y and z.
    pub sides: [usize; 3],
    /// The name of the kind of its cells.
    pub kind: String,
    /// What its cells are.
    pub cell: Cell,
    /// The initial design: each of them fills.
    pub begin: Vec<Effect>,
    /// Where this is said.
    pub span: Span,
}

/// A cell: a ball of material that is joined to its neighbours by springs. What is an expression may read the
/// parameters of the cell: they are its first locals, in their order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    /// The distance between neighbours, and the diameter of a ball, m.
    pub spacing: f64,
    /// In kg.
    pub mass: Expr,
    /// Coulomb coefficient of its surface.
    pub friction: Expr,
    /// Of a spring between two such cells, N/m. Where cells differ, half of the spring is of each.
    pub stiffness: Expr,
    /// Of such a spring, N s/m.
    pub damping: Expr,
    /// `#rrggbb`
    pub colour: Expr,
    /// What tells cells apart.
    pub params: IndexMap<String, InstanceParam>,
    /// Where it is declared.
    pub span: Span,
}

/// Places that an effect of a rule fills, paints or clears.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cells {
    /// What is done.
    pub how: super::Painting,
    /// The places: a list of cells.
    pub region: Expr,
    /// What their cells are like: a kind with parameters.
    pub with: Option<Expr>,
}

/// While a condition holds, one rule alone is drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fallback {
    /// The rule.
    pub rule: String,
    /// When.
    pub condition: Expr,
    /// Why.
    pub because: Option<String>,
    /// Where it is said.
    pub span: Span,
}

impl Writer<'_> {
    pub(super) fn cell(&mut self) {
        let Some(lattice) = &self.rules.lattice else { return };
        let cell = &lattice.cell;
        self.gap();
        self.line(0, format!("cell {} {{", lattice.kind));
        self.instance_params(&cell.params);
        self.line(1, format!("spacing = {}", units::shown(cell.spacing, Dimension::LENGTH)));
        let names: Names = cell.params.keys().cloned().collect();
        for (field, value) in [
            ("mass", &cell.mass),
            ("friction", &cell.friction),
            ("stiffness", &cell.stiffness),
            ("damping", &cell.damping),
            ("colour", &cell.colour),
        ] {
            let value = self.expr(value, &names);
            self.line(1, format!("{field} = {value}"));
        }
        self.line(0, "}");
    }

    pub(super) fn cells(&self, cells: &Cells, names: &Names) -> String {
        let with = cells.with.as_ref().map_or(String::new(), |w| format!(" with {}", self.expr(w, names)));
        format!("{} {}{with}", cells.how.word(), self.expr(&cells.region, names))
    }

    /// What effects are repeated for, and the names of the locals inside.
    pub(super) fn repeated(&self, over: &[Binder], names: &Names) -> (Names, String) {
        let mut names = names.clone();
        let mut text = Vec::new();
        for binder in over {
            let what = self.expr(&binder.over, &names);
            names.resize(binder.slot, String::new());
            names.push(format!("x{}", binder.slot));
            text.push(format!("x{} in {what}", binder.slot));
        }
        (names, text.join(", "))
    }
}
