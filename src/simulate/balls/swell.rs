//! What targets make of springs and balls.

use std::ops::Range;

use super::order::{Class, key};
use crate::simulate::lattice::{Gains, Lattice};

/// Springs that have their strain in common.
pub(super) struct Strained {
    gains: Gains,
    /// Their fours.
    pub(super) fours: Range<usize>,
}

/// Balls that have their strain in common.
struct Swollen {
    gains: Gains,
    /// Balls and their radii without strain, m.
    balls: Vec<(usize, f32)>,
}

/// Actuation: targets, and what they strain.
pub(super) struct Swell {
    /// What is asked for at the end of this step.
    pub(super) targets: Vec<f64>,
    /// What was asked for at the end of the last, and of the one before.
    before: Vec<f64>,
    earlier: Vec<f64>,
    springs: Vec<Strained>,
    balls: Vec<Swollen>,
    /// Positive work of each actuator, J.
    pub(super) work: Vec<f64>,
    /// Work of all, J; less where springs gave some back.
    pub(super) balance: f64,
}

impl Swell {
    /// At rest, with the fours of each class of springs.
    pub(super) fn new(lattice: &Lattice, classes: &[Class], fours: &[Range<usize>]) -> Self {
        let strained = |(class, fours): (&Class, &Range<usize>)| Strained {
            gains: class.gains.clone(),
            fours: fours.clone(),
        };
        let mut balls: Vec<Swollen> = Vec::new();
        for (index, ball) in lattice.balls.iter().enumerate().filter(|(_, ball)| !ball.gains.is_empty()) {
            let own = (index, ball.radius as f32);
            match balls.iter_mut().find(|class| key(&class.gains) == key(&ball.gains)) {
                Some(class) => class.balls.push(own),
                None => balls.push(Swollen { gains: ball.gains.clone(), balls: vec![own] }),
            }
        }
        let none = vec![0.0; lattice.actuators];
        let springs = classes.iter().zip(fours).map(strained).filter(|s| !s.gains.is_empty()).collect();
        let [targets, before, earlier] = [(); 3].map(|()| none.clone());
        Self { targets, before, earlier, springs, balls, work: none, balance: 0.0 }
    }

    /// Back to rest.
    pub(super) fn reset(&mut self) {
        for all in [&mut self.targets, &mut self.before, &mut self.earlier, &mut self.work] {
            all.fill(0.0);
        }
        self.balance = 0.0;
    }

    /// Whether anything changes, or its last change has not been booked.
    pub(super) fn changes(&self) -> bool {
        self.targets != self.before || self.before != self.earlier
    }

    /// Hands the springs whose strain has changed and their strain to a function that says what that takes, J for each unit
    /// of strain, by those that resist and those that help. A change costs the mean of the force before it and of
    /// that after it, in the next step: with undamped springs the books then balance exactly, even where a strain comes all at once.
    #[inline(always)]
    pub(super) fn strain(&mut self, mut apply: impl FnMut(Range<usize>, f32) -> [f64; 2]) {
        for class in &self.springs {
            let changes = |&(actuator, _): &(usize, f64)| {
                let [now, before] = [&self.targets, &self.before].map(|all| all[actuator]);
                now != before || before != self.earlier[actuator]
            };
            if !class.gains.iter().any(changes) {
                continue;
            }
            let pushes = apply(class.fours.clone(), strain(&class.gains, &self.targets));
            for &(actuator, gain) in &class.gains {
                let change = 0.5 * gain * (self.targets[actuator] - self.earlier[actuator]);
                self.work[actuator] += (change * pushes[0]).max(change * pushes[1]).max(0.0);
                self.balance += change * (pushes[0] + pushes[1]);
            }
        }
    }

    /// The work of the last change that is not booked yet, J, from a function that says what a unit of strain takes of springs.
    pub(super) fn pending(&self, push: impl Fn(Range<usize>) -> f64) -> f64 {
        let change =
            |&(actuator, gain): &(usize, f64)| gain * (self.before[actuator] - self.earlier[actuator]);
        let one = |class: &Strained| {
            let change: f64 = class.gains.iter().map(change).sum();
            if change == 0.0 { 0.0 } else { 0.5 * change * push(class.fours.clone()) }
        };
        self.springs.iter().map(one).sum()
    }

    /// Hands the balls that are strained and their new radii, m, to a function. Then the step is over.
    #[inline(always)]
    pub(super) fn swell(&mut self, mut apply: impl FnMut(usize, f32)) {
        for class in &self.balls {
            let grown = 1.0 + strain(&class.gains, &self.targets);
            class.balls.iter().for_each(|&(ball, radius)| apply(ball, radius * grown));
        }
        std::mem::swap(&mut self.earlier, &mut self.before);
        self.before.copy_from_slice(&self.targets);
    }
}

fn strain(gains: &Gains, targets: &[f64]) -> f32 {
    gains.iter().map(|&(actuator, gain)| gain * targets[actuator]).sum::<f64>() as f32
}
