//! How far contacts are solved, and how they give way: the same with hinges and with rods.

use super::Settings;

/// A contact with the ground gives way as if so many times the mass of the whole body were free to move there. What rests on it sinks to the
/// depth that is left, and with steps of 1/240 s by 17 um more where one point carries all.
///
/// The laws of rigid bodies leave open how feet share the weight of a body that is rigid vertically. The sweeps would leave it where they
/// begin, or carry it to and fro with each stroke, so that a row of blocks would crawl sideways. As the contacts give way alike, they share it. With a
/// thousandth of the mass they share it too slowly for a gait; with three hundredths, coarse steps move a walker by a millimetre in some seconds.
pub(super) const GROUND_SOFTNESS: f64 = 0.02;
/// The same of a contact between two bodies: actuators can press these together by a hundred times the weight.
///
/// Where no joint can move along the normal of such a contact, or only one that is held at its limit, the impulse would else be as large as
/// numbers allow: what rounding makes of it throws the body about.
pub(super) const PAIR_SOFTNESS: f64 = 1e-3;

/// Steps at the beginning whose contacts have no impulses to start from that are worth it: a body on a slope that is nearly too steep would
/// slide far with the speed that unsolved contacts leave it, and blocks in a row would not share their weight yet.
const COLD: u32 = 8;
/// For them, so many times as many sweeps at most, and the share of the tolerance that ends them.
const COLD_SWEEPS: (usize, f64) = (50, 0.01);

/// How far contacts are solved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sweeps {
    /// So many sweeps at most.
    pub(super) most: usize,
    /// See [`Settings::tolerance`].
    pub(super) tolerance: f64,
}

impl Settings {
    /// How far contacts are solved in a step that so many steps came before.
    #[inline]
    pub(super) fn sweeps_after(&self, steps: u32) -> Sweeps {
        let (times, share) = if steps < COLD { COLD_SWEEPS } else { (1, 1.0) };
        Sweeps { most: self.iterations.saturating_mul(times), tolerance: self.tolerance * share }
    }
}
