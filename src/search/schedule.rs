//! What the expressions of a schedule can read, and their values.

use grammar_lang::eval::{EvalError, Scope, Value, evaluate};
use grammar_lang::ir::{Expr, Function, RuleSet, Schedule, Word};

use serde::{Deserialize, Serialize};

use crate::derive::{Derivation, DesignScope};

/// The course of an annealing loop.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Course {
    /// Iterations that are complete.
    pub(super) iteration: usize,
    /// The best value after each iteration; the first is the value at the start.
    pub(super) bests: Vec<f64>,
    /// Whether the objective is maximised.
    pub(super) maximize: bool,
}

impl Course {
    /// A course that begins with a value; `None` if there is no valid one yet.
    pub(super) fn new(maximize: bool, first: Option<f64>) -> Self {
        Self { iteration: 0, bests: vec![first.unwrap_or(0.0)], maximize }
    }

    /// Notes the end of an iteration.
    pub(super) fn complete(&mut self, best: Option<f64>) {
        self.iteration += 1;
        let last = self.bests.last().copied().unwrap_or(0.0);
        self.bests.push(best.unwrap_or(last));
    }

    fn best(&self) -> f64 {
        self.bests.last().copied().unwrap_or(0.0)
    }

    /// What the best gained over the last `n` iterations.
    fn gain(&self, n: usize) -> f64 {
        let before = self.bests.get(self.bests.len().saturating_sub(n + 1)).copied().unwrap_or(0.0);
        if self.maximize { self.best() - before } else { before - self.best() }
    }

    /// Iterations since the best improved.
    fn idle(&self) -> usize {
        let best = self.best();
        self.bests.iter().rev().take_while(|b| **b == best).count().saturating_sub(1)
    }
}

/// An iteration under way. What the schedule says is asked once, where it begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Iteration {
    pub(super) temperature: f64,
    /// How many moves it has, and how many of them are made.
    pub(super) moves: usize,
    pub(super) made: usize,
}

struct ScheduleScope<'a> {
    design: DesignScope<'a>,
    course: &'a Course,
}

impl Scope for ScheduleScope<'_> {
    fn outer(&self) -> Option<&dyn Scope> {
        Some(&self.design)
    }

    fn word(&self, word: Word) -> Option<Value> {
        match word {
            Word::Iteration => Some(Value::Number(self.course.iteration as f64)),
            Word::Best => Some(Value::Number(self.course.best())),
            Word::Idle => Some(Value::Number(self.course.idle() as f64)),
            _ => self.design.word(word),
        }
    }

    fn call(&self, function: Function, arguments: &[Value]) -> Option<Value> {
        match (function, arguments) {
            (Function::Gain, [Value::Number(n)]) => {
                Some(Value::Number(self.course.gain(n.max(0.0) as usize)))
            }
            _ => self.design.call(function, arguments),
        }
    }
}

/// A schedule with the design that it may read.
pub(super) struct Plan<'a> {
    pub(super) rules: &'a RuleSet,
    pub(super) derivation: &'a Derivation,
    pub(super) schedule: &'a Schedule,
}

impl Plan<'_> {
    fn value(&self, expr: &Expr, course: &Course) -> Result<Value, EvalError> {
        let scope = ScheduleScope { design: DesignScope::new(self.rules, self.derivation), course };
        evaluate(expr, &scope, &mut Vec::new())
    }

    fn number(&self, expr: &Expr, course: &Course) -> Result<f64, EvalError> {
        Ok(self.value(expr, course)?.as_number().unwrap_or(0.0).max(0.0))
    }

    /// The next iteration; none if the schedule has no more.
    pub(super) fn begin(&self, course: &Course) -> Result<Option<Iteration>, EvalError> {
        if course.iteration >= self.number(&self.schedule.iterations, course)? as usize {
            return Ok(None);
        }
        let temperature = self.number(&self.schedule.temperature, course)?;
        let moves = self.number(&self.schedule.moves, course)? as usize;
        Ok(Some(Iteration { temperature, moves, made: 0 }))
    }

    /// Whether the stopping rule applies, after an iteration.
    pub(super) fn stops(&self, course: &Course) -> Result<bool, EvalError> {
        Ok(self.value(&self.schedule.stop, course)? == Value::Bool(true))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gain_and_idle_follow_the_best() {
        let mut course = Course::new(true, Some(-2.0));
        for best in [1.0, 1.0, 4.0, 4.0, 4.0] {
            course.complete(Some(best));
        }
        assert_eq!(course.iteration, 5);
        assert_eq!(course.gain(2), 0.0);
        assert_eq!(course.gain(3), 3.0);
        assert_eq!(course.gain(99), 6.0);
        assert_eq!(course.idle(), 2);
    }

    #[test]
    fn without_any_valid_value_nothing_is_gained() {
        let mut course = Course::new(true, None);
        for _ in 0..150 {
            course.complete(None);
        }
        assert_eq!(course.gain(150), 0.0);
        assert_eq!(course.idle(), 150);
    }
}
