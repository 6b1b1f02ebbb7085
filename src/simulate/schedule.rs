//! When to step and when to record.

use super::Settings;

/// The steps and frames of a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schedule {
    /// Time step in s.
    pub(super) step: f64,
    /// How many steps.
    pub(super) steps: usize,
    /// Time between frames in s.
    pub(super) interval: f64,
    /// Simulated time in s.
    pub(super) duration: f64,
    /// How many frames, that of time zero included.
    pub(super) frames: usize,
}

impl Schedule {
    /// For settings that have been checked.
    pub(super) fn new(settings: &Settings) -> Self {
        let steps = (settings.duration / settings.step).round().max(1.0) as usize;
        // A duration that is a multiple of the interval but for rounding has
        // no short last interval.
        let whole = (settings.duration / settings.record + 1e-9).floor();
        let rest = settings.duration / settings.record - whole;
        Self {
            step: settings.step,
            steps,
            interval: settings.record,
            duration: settings.duration,
            frames: whole as usize + 1 + usize::from(rest > 1e-9),
        }
    }

    /// The step after which a frame is recorded: the nearest to its time.
    pub(super) fn step_of(&self, frame: usize) -> usize {
        if frame + 1 >= self.frames {
            return self.steps;
        }
        ((frame as f64 * self.interval / self.step).round() as usize).min(self.steps)
    }
}

#[cfg(test)]
mod tests {
    use super::Schedule;
    use crate::simulate::Settings;

    #[test]
    fn frames_fall_on_the_nearest_steps() {
        let settings =
            Settings { step: 0.01, duration: 1.0, record: 0.3, ..crate::simulate::tests::settings() };
        let schedule = Schedule::new(&settings);
        assert_eq!(schedule.frames, 5);
        let steps: Vec<_> = (0..5).map(|frame| schedule.step_of(frame)).collect();
        assert_eq!(steps, [0, 30, 60, 90, 100]);
        let even = Schedule::new(&Settings { record: 0.1, ..settings });
        assert_eq!((even.frames, even.step_of(10)), (11, 100));
    }
}
