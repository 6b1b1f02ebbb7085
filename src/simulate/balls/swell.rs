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
    /// What was asked for at the end of the last.
    before: Vec<f64>,
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
        Self { targets: none.clone(), before: none.clone(), springs, balls, work: none, balance: 0.0 }
    }

    /// Back to rest.
    pub(super) fn reset(&mut self) {
        for all in [&mut self.targets, &mut self.before, &mut self.work] {
            all.fill(0.0);
        }
        self.balance = 0.0;
    }

    /// Whether anything has changed since the last step.
    pub(super) fn changes(&self) -> bool {
        self.targets != self.before
    }

    /// Hands the springs whose strain has changed and their strain to a function that says what that takes, J for each unit
    /// of strain, by those that resist and those that help.
    #[inline(always)]
    pub(super) fn strain(&mut self, mut apply: impl FnMut(Range<usize>, f32) -> [f64; 2]) {
        for class in &self.springs {
            let changes = |gain: &(usize, f64)| self.targets[gain.0] != self.before[gain.0];
            if !class.gains.iter().any(changes) {
                continue;
            }
            let pushes = apply(class.fours.clone(), strain(&class.gains, &self.targets));
            for &(actuator, gain) in &class.gains {
                let change = gain * (self.targets[actuator] - self.before[actuator]);
                self.work[actuator] += (change * pushes[0]).max(change * pushes[1]).max(0.0);
                self.balance += change * (pushes[0] + pushes[1]);
            }
        }
    }

    /// Hands the balls that are strained and their new radii, m, to a function. Then the step is over.
    #[inline(always)]
    pub(super) fn swell(&mut self, mut apply: impl FnMut(usize, f32)) {
        for class in &self.balls {
            let grown = 1.0 + strain(&class.gains, &self.targets);
            class.balls.iter().for_each(|&(ball, radius)| apply(ball, radius * grown));
        }
        self.before.copy_from_slice(&self.targets);
    }
}

fn strain(gains: &Gains, targets: &[f64]) -> f32 {
    gains.iter().map(|&(actuator, gain)| gain * targets[actuator]).sum::<f64>() as f32
}
