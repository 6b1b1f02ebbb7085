//! A ball on the ground: Coulomb's law, exactly.

/// What a ball and the ground know of each other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footing {
    /// Radius at the end of the step, m.
    pub(super) radius: f32,
    /// By how much the radius grows in this step, m.
    pub(super) growth: f32,
    /// Coulomb coefficient of ball and ground together.
    pub(super) friction: f32,
}

/// The velocity of a ball after the ground has had its say, and the speed that its push gave, m/s.
///
/// A push brings the ball no deeper than to the surface at the end of the step. Friction takes what
/// sideways velocity there is, or as much as the coefficient times the push.
#[inline(always)]
pub(super) fn stand(footing: &Footing, height: f32, rate: f32, velocity: [f32; 4]) -> ([f32; 4], f32) {
    let [x, y, z, w] = velocity;
    let wanted = (footing.radius - height) * rate;
    let push = wanted - y;
    if push > 0.0 {
        let speed = (x * x + z * z).sqrt();
        let hold = footing.friction * push;
        let left = if speed > hold { 1.0 - hold / speed } else { 0.0 };
        ([x * left, wanted, z * left, w], push)
    } else {
        (velocity, 0.0)
    }
}
