//! How closely motions are simulated.

/// What a motion is simulated with. Most motions of a search are cheap; what looks like a new best is looked at more closely.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fidelity {
    /// The solver of the search, in steps of the model.
    Model,
    /// The same at half the step, with finer contacts.
    HalfStep,
    /// Elastic rods in place of rows of hinges that bend, in steps of the model.
    Rods,
}

/// One of something for each [`Fidelity`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Each<T> {
    model: T,
    half_step: T,
    rods: T,
}

impl<T> Each<T> {
    /// What a function makes of each.
    pub(super) fn of(make: impl Fn(Fidelity) -> T) -> Self {
        Self { model: make(Fidelity::Model), half_step: make(Fidelity::HalfStep), rods: make(Fidelity::Rods) }
    }

    /// That of one.
    pub(super) fn get(&self, fidelity: Fidelity) -> &T {
        match fidelity {
            Fidelity::Model => &self.model,
            Fidelity::HalfStep => &self.half_step,
            Fidelity::Rods => &self.rods,
        }
    }
}
