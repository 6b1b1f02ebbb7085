//! Values with a name that change in a motion, apart from those that do not.

use std::ops::Range;

use crate::ir::{self, Expr, ExprKind};
use crate::syntax::ast::Name;

/// The values that an actuation or a state of the robot names, as they are found.
pub(super) struct Lets {
    /// The slots of what is remembered or decided.
    remembered: Range<usize>,
    /// Lets without the time come first, so that they are found once for a motion.
    pub(super) lets: Vec<(String, Expr)>,
    pub(super) moving: Vec<(String, Expr)>,
}

impl Lets {
    pub(super) fn new(remembered: Range<usize>) -> Self {
        Self { remembered, lets: Vec::new(), moving: Vec::new() }
    }

    pub(super) fn add(&mut self, name: &Name, value: Expr) {
        let timed = value.any(&mut |e| match e.kind {
            ExprKind::Word(ir::Word::Time) | ExprKind::Sensor(..) => true,
            ExprKind::Local(slot) => self.remembered.contains(&slot),
            _ => false,
        });
        // Slots are in the order of the text: once one value moves, those after it do too.
        let of = if timed || !self.moving.is_empty() { &mut self.moving } else { &mut self.lets };
        of.push((name.text.clone(), value));
    }
}
