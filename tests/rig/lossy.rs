//! A line that loses and breaks a part of what is said: the host says it again, and the board does it once.

use std::time::Duration;

use sgc::hardware::{Error, Link, Outcome, Plan, Safe, drive};

use super::trace::us;
use super::{Rig, at_most, valves};
use crate::fuzz::mutate::Random;

/// Loses or breaks one in so many pieces, both ways.
struct Lossy<'a> {
    rig: &'a mut Rig,
    random: Random,
    one_in: usize,
}

impl Lossy<'_> {
    fn spoil(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut out = bytes.to_vec();
        if out.is_empty() || self.random.below(self.one_in) > 0 {
            return out;
        }
        if self.random.below(2) == 0 {
            return Vec::new();
        }
        let at = self.random.below(out.len());
        out[at] ^= 1 << self.random.below(8);
        out
    }
}

impl Link for Lossy<'_> {
    fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let spoilt = self.spoil(bytes);
        if spoilt.is_empty() { Ok(()) } else { self.rig.send(&spoilt) }
    }

    fn receive(&mut self, wait: Duration) -> Result<Vec<u8>, Error> {
        let bytes = self.rig.receive(wait)?;
        Ok(self.spoil(&bytes))
    }

    fn now(&self) -> Duration {
        self.rig.now()
    }
}

#[test]
fn a_bad_line_is_slower_and_not_wrong() {
    for seed in 0..5 {
        let Some(mut rig) = Rig::new() else { return };
        let schedule = valves::eight(Safe::Hold);
        let line = Lossy { rig: &mut rig, random: Random(seed), one_in: 6 };
        let plan = Plan { cycles: 5, silence: Duration::from_secs(2), ..Plan::default() };
        assert_eq!(
            drive(line, &schedule, &plan, &mut at_most(1000)).unwrap(),
            Outcome::Completed { cycles: 5 }
        );
        let trace = rig.trace();
        // Started once: five cycles without a break.
        let first = trace.spans(schedule.channels[0].output.pins()[0]);
        assert_eq!(first.len(), 5, "seed {seed}");
        for pair in first.windows(2) {
            assert!((us(pair[1].from - pair[0].from) - f64::from(schedule.period)).abs() < 150.0);
        }
    }
}
