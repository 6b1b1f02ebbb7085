//! Balls that touch each other: impulses along the line of their centres by projected Gauss-Seidel.
//!
//! There is no friction between balls. They do not rotate, so that forces across that line would be a couple, and the body would
//! gain angular momentum from nowhere: searches found robots that spun on ice for ever.

use super::vector::{dot, sub};

/// How much of an overlap is mended in a step, at most.
const MEND: f32 = 0.2;
/// How fast an overlap is mended at most, m/s.
const MEND_SPEED: f32 = 0.1;

/// Two balls that may touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    /// The balls, the lower number first.
    pub(super) balls: (usize, usize),
    /// Impulse with which the second is pushed along the normal, N s.
    push: f32,
    /// From the first to the second.
    normal: [f32; 3],
    /// The speed at which they must part, m/s.
    wanted: f32,
    /// By how much the two radii grow in a second, m/s.
    growth: f32,
    /// The mass that moves, kg.
    mass: f32,
    active: bool,
}

/// What touching needs to know of the balls.
pub(super) trait Balls {
    /// Where a ball is, m.
    fn place(&self, ball: usize) -> [f32; 3];
    /// Its radius at the end of the step and by how much it grows in it, m.
    fn radius(&self, ball: usize) -> (f32, f32);
    /// One over its mass, 1/kg.
    fn lightness(&self, ball: usize) -> f32;
    /// Its velocity, after the ground has had its say, m/s.
    fn velocity(&self, ball: usize) -> [f32; 3];
    /// Changes its velocity from before the ground, m/s.
    fn kick(&mut self, ball: usize, by: [f32; 3]);
}

impl Touch {
    /// Of two balls that have not touched yet.
    pub(super) fn between(first: usize, second: usize) -> Self {
        Self {
            balls: (first, second),
            push: 0.0,
            normal: [0.0; 3],
            wanted: 0.0,
            growth: 0.0,
            mass: 0.0,
            active: false,
        }
    }

    /// Sees whether they can touch within a step of 1/`rate` s, and begins with the impulse of the last.
    fn begin(&mut self, balls: &mut impl Balls, rate: f32) {
        let (a, b) = self.balls;
        let ((here, more), (there, yet_more)) = (balls.radius(a), balls.radius(b));
        let (way, reach) = (sub(balls.place(b), balls.place(a)), here + there);
        let square = dot(way, way);
        self.active = square < 1.2 * reach * reach && square > 0.0;
        if !self.active {
            self.push = 0.0;
            return;
        }
        let distance = square.sqrt();
        self.normal = way.map(|w| w / distance);
        let gap = distance - reach;
        self.growth = (more + yet_more) * rate;
        let mend = (-gap * MEND * rate).min(MEND_SPEED) + self.growth.max(0.0);
        self.wanted = if gap > 0.0 { -gap * rate } else { mend };
        self.mass = 1.0 / (balls.lightness(a) + balls.lightness(b));
        apply(balls, self.balls, self.normal.map(|n| n * self.push));
    }

    /// Solves for this pair alone. Returns the square of the change and of the whole, (N s)^2.
    fn relax(&mut self, balls: &mut impl Balls) -> (f32, f32) {
        let (a, b) = self.balls;
        let speed = sub(balls.velocity(b), balls.velocity(a));
        let along = dot(speed, self.normal);
        let push = (self.push + (self.wanted - along) * self.mass).max(0.0);
        let change = push - self.push;
        self.push = push;
        apply(balls, self.balls, self.normal.map(|n| n * change));
        (change * change, push * push)
    }
}

fn apply(balls: &mut impl Balls, (a, b): (usize, usize), impulse: [f32; 3]) {
    let (here, there) = (-balls.lightness(a), balls.lightness(b));
    balls.kick(a, impulse.map(|i| i * here));
    balls.kick(b, impulse.map(|i| i * there));
}

/// Solves for all pairs together, by sweeps until none changes more than the share `tolerance` of all
/// impulses. Returns the work of balls that grew against each other, J.
pub(super) fn solve(
    touches: &mut [Touch],
    balls: &mut impl Balls,
    rate: f32,
    iterations: usize,
    tolerance: f32,
) -> f64 {
    touches.iter_mut().for_each(|touch| touch.begin(balls, rate));
    if touches.iter().all(|touch| !touch.active) {
        return 0.0;
    }
    for _ in 0..iterations {
        let (mut most, mut all) = (0.0f32, 0.0);
        for touch in touches.iter_mut().filter(|touch| touch.active) {
            let (change, whole) = touch.relax(balls);
            most = most.max(change);
            all += whole;
        }
        if most <= tolerance * tolerance * all {
            break;
        }
    }
    let work = |touch: &Touch| f64::from(touch.push * touch.growth.max(0.0));
    touches.iter().filter(|touch| touch.active).map(work).sum()
}
