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
    /// For settings that have been checked, in whole steps.
    pub(super) fn new(settings: &Settings) -> Self {
        let steps = libm::round(settings.duration / settings.step).max(1.0) as usize;
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

    /// The step at whose end, or within which, a frame is recorded, and which share of that step has passed by then.
    pub(super) fn moment(&self, frame: usize) -> (usize, f64) {
        let place = frame as f64 * self.interval / self.step;
        let nearest = libm::round(place);
        if frame + 1 >= self.frames || place >= self.steps as f64 {
            (self.steps, 1.0)
        } else if (place - nearest).abs() < 1e-6 {
            (nearest as usize, 1.0)
        } else {
            (libm::ceil(place) as usize, place - libm::floor(place))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Schedule;
    use crate::simulate::Settings;

    #[test]
    fn frames_fall_on_steps_or_within_them() {
        let settings =
            Settings { step: 0.01, duration: 1.0, record: 0.3, ..crate::simulate::tests::settings() };
        let schedule = Schedule::new(&settings);
        assert_eq!(schedule.frames, 5);
        let moments: Vec<_> = (0..5).map(|frame| schedule.moment(frame)).collect();
        assert_eq!(moments, [0, 30, 60, 90, 100].map(|step| (step, 1.0)));
        let even = Schedule::new(&Settings { record: 0.1, ..settings.clone() });
        assert_eq!((even.frames, even.moment(10)), (11, (100, 1.0)));
        let quarters = Schedule::new(&Settings { record: 0.0025, ..settings });
        assert_eq!([0, 1, 4].map(|frame| quarters.moment(frame)), [(0, 1.0), (1, 0.25), (1, 1.0)]);
    }
}
