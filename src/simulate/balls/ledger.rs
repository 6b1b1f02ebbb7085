//! Energy bookkeeping: what actuation has not put in must not be there.

use crate::simulate::Settings;
use crate::simulate::lattice::Lattice;

/// Energy that may come from nowhere, as a height in m to which it lifts the whole body.
const ALLOWED: f64 = 0.0025;
/// Steps between two looks at the books.
pub(super) const LOOK: usize = 32;

/// Kinetic, elastic and potential energy less the work of strains. In truth it only falls, as
/// damping, friction and impacts take from it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ledger {
    /// The lowest balance so far, J.
    lowest: f64,
    /// The most that has come from nowhere since the balance was lowest, J.
    pub(super) gained: f64,
    allowed: f64,
}

impl Ledger {
    /// Before the first step.
    pub(super) fn new(lattice: &Lattice, settings: &Settings) -> Self {
        let mass: f64 = lattice.balls.iter().map(|ball| ball.mass).filter(|mass| mass.is_finite()).sum();
        // Without weight a body may still swing: as much as on earth.
        let allowed = mass * settings.gravity.max(9.81) * ALLOWED;
        Self { lowest: f64::INFINITY, gained: 0.0, allowed }
    }

    /// Back to before the first step.
    pub(super) fn reset(&mut self) {
        (self.lowest, self.gained) = (f64::INFINITY, 0.0);
    }

    /// Takes in a balance, J. False if there is more than there may be.
    pub(super) fn take(&mut self, balance: f64) -> bool {
        self.lowest = self.lowest.min(balance);
        self.gained = self.gained.max(balance - self.lowest);
        self.gained <= self.allowed
    }
}
