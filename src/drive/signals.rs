//! What can be kept of the control moments of a motion.

use grammar_lang::eval::Value;
use grammar_lang::ir::Ty;

use crate::design::PartId;

/// What is kept of a control moment, by signal; none where it has no value.
pub(super) type Row = Vec<Option<Value>>;

/// What a column of a trace is.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// What the grammar calls it; empty for what an actuator is asked for.
    pub name: String,
    /// The part that has it, where each part of a kind has one.
    pub of: Option<PartId>,
    /// Its type.
    pub ty: Ty,
}

/// What was so at each control moment of a motion.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Its columns: sensors, states of the robot and of parts, states of actuators, and what actuators are asked for.
    pub signals: Vec<Signal>,
    /// A row for each moment.
    pub rows: Vec<Row>,
    /// The time between two of them, s.
    pub interval: f64,
}
