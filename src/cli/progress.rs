//! Progress of a run, for people: on a terminal a bar, elsewhere a line now and then.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::output;

/// How often a line is written where there is no terminal.
const EVERY: Duration = Duration::from_secs(20);

/// Shows the progress of a search.
pub(super) struct Progress {
    bar: ProgressBar,
    terminal: bool,
    started: Instant,
    last: Instant,
    /// Evaluations spent before it started.
    before: u64,
    limit: Option<u64>,
    deadline: Option<Instant>,
    unit: String,
    best: Option<f64>,
    moves: usize,
    temperature: f64,
}

impl Progress {
    /// For a search that has spent so many evaluations before.
    pub(super) fn new(
        before: u64,
        limit: Option<u64>,
        deadline: Option<Instant>,
        unit: &str,
        quiet: bool,
    ) -> Self {
        let terminal = std::io::stderr().is_terminal() && !quiet;
        let bar = match limit {
            Some(limit) => ProgressBar::new(limit),
            None => ProgressBar::no_length(),
        };
        bar.set_draw_target(if terminal {
            ProgressDrawTarget::stderr_with_hz(5)
        } else {
            ProgressDrawTarget::hidden()
        });
        let template = if limit.is_some() { "{bar:28} {pos}/{len} {msg}" } else { "{spinner} {pos} {msg}" };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        let now = Instant::now();
        let last = if quiet { now + Duration::from_secs(1 << 30) } else { now };
        Self {
            bar,
            terminal,
            started: now,
            last,
            before,
            limit,
            deadline,
            unit: unit.to_owned(),
            best: None,
            moves: 0,
            temperature: 0.0,
        }
    }

    fn left(&self, spent: u64, now: Instant) -> String {
        let now_spent = spent.saturating_sub(self.before);
        let by_count = self.limit.filter(|_| now_spent > 0).map(|limit| {
            let share = limit.saturating_sub(spent) as f64 / now_spent as f64;
            Duration::from_secs_f64((now - self.started).as_secs_f64() * share)
        });
        let by_time = self.deadline.map(|d| d.saturating_duration_since(now));
        match by_count.into_iter().chain(by_time).min() {
            Some(left) => format!(", {} left", span(left)),
            None => String::new(),
        }
    }

    fn best(&self) -> String {
        self.best.map_or("none yet".to_owned(), |b| format!("{b:.1} {}", self.unit).trim_end().to_owned())
    }

    /// Shows how far the search is.
    pub(super) fn evaluated(&mut self, spent: u64, body: Option<f64>) {
        let now = Instant::now();
        if !self.terminal && now.saturating_duration_since(self.last) < EVERY {
            return;
        }
        let rate = spent.saturating_sub(self.before) as f64 / (now - self.started).as_secs_f64().max(1e-3);
        let body = body.map_or(String::new(), |b| format!(", this body {b:.1}"));
        let message = format!(
            "evaluations at {rate:.0}/s, move {} at T {:.1}: best {}{body}{}",
            self.moves + 1,
            self.temperature,
            self.best(),
            self.left(spent, now)
        );
        if self.terminal {
            self.bar.set_position(spent);
            self.bar.set_message(message);
        } else {
            self.last = now;
            output::note(&format!("{spent} {message}"));
        }
    }

    /// Notes a completed move of a body.
    pub(super) fn moved(&mut self, number: usize, best: Option<f64>, temperature: f64) {
        (self.moves, self.best, self.temperature) = (number, best, temperature);
    }

    /// Takes the bar away.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// A time span as people say it.
pub(super) fn span(time: Duration) -> String {
    let s = time.as_secs();
    match s {
        0..60 => format!("{s} s"),
        60..3600 => format!("{} min {} s", s / 60, s % 60),
        _ => format!("{} h {} min", s / 3600, s % 3600 / 60),
    }
}
