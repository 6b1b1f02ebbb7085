//! What is otherwise with the hardware than a grammar says.

/// By how much the hardware of a drive differs from what the grammar says.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditions {
    /// Factor of the speeds at which actuators bend and relax, and of those of servos that wind threads.
    pub speed: f64,
    /// Factor of the pressure of a supply.
    pub pressure: f64,
    /// How much later than it should each actuator does what it is asked for, s, in the order of the body. Those
    /// after the last are not late.
    pub late: Vec<f64>,
    /// The world, by whose name the noise of sensors is drawn.
    pub world: String,
}

impl Conditions {
    /// What the grammar says.
    pub const NOMINAL: Self = Self { speed: 1.0, pressure: 1.0, late: Vec::new(), world: String::new() };

    /// The same in the nominal world.
    #[must_use]
    pub fn nominal() -> Self {
        Self { world: "nominal".to_owned(), ..Self::NOMINAL }
    }

    /// How late an actuator is, s.
    pub(super) fn late(&self, actuator: usize) -> f64 {
        self.late.get(actuator).copied().unwrap_or(0.0)
    }
}
