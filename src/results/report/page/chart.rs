//! Charts as SVG: scales with round ticks, and what is drawn upon them.

use std::fmt::Write;

use crate::markup::escape;

/// A scale from one round number to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    pub(crate) low: f64,
    pub(crate) high: f64,
    step: f64,
}

impl Scale {
    /// A scale that holds all the values, with about so many steps.
    pub(crate) fn of(values: impl IntoIterator<Item = f64>, steps: usize) -> Self {
        let finite = values.into_iter().filter(|x| x.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let (low, high) = match (low, high) {
            (l, h) if l > h => (0.0, 1.0),
            (l, h) if h - l <= 1e-9 * l.abs().max(h.abs()) => {
                (l.min(0.0), if h > 0.0 { h } else { l.min(0.0) + 1.0 })
            }
            range => range,
        };
        let step = round_step((high - low) / steps.max(1) as f64);
        Self { low: (low / step + 1e-6).floor() * step, high: (high / step - 1e-6).ceil() * step, step }
    }

    /// The same, but it ends where the values end.
    pub(crate) fn until(values: impl IntoIterator<Item = f64> + Clone, steps: usize) -> Self {
        let last = values.clone().into_iter().filter(|x| x.is_finite()).fold(f64::NEG_INFINITY, f64::max);
        let scale = Self::of(values, steps);
        if last > scale.low { Self { high: last, ..scale } } else { scale }
    }

    /// The same for counts: no step is smaller than one.
    pub(crate) fn counts(values: impl IntoIterator<Item = f64>, steps: usize) -> Self {
        let scale = Self::of(values, steps);
        if scale.step >= 1.0 {
            return scale;
        }
        Self { low: scale.low.floor(), high: scale.high.ceil(), step: 1.0 }
    }

    /// The round numbers on it.
    pub(crate) fn ticks(&self) -> Vec<f64> {
        let many = ((self.high - self.low) / self.step + 1e-6).floor() as usize;
        (0..=many.min(100)).map(|i| self.low + self.step * i as f64).collect()
    }

    /// A tick in words.
    pub(crate) fn label(&self, tick: f64) -> String {
        let decimals = (-libm::floor(libm::log10(self.step) + 1e-9)).clamp(0.0, 9.0) as usize;
        let text = format!("{tick:.decimals$}");
        let is_zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
        if is_zero { "0".to_owned() } else { text.replace('-', "−") }
    }

    /// Where a value is between the ends, as a share.
    fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }
}

/// 1, 2 or 5 times a power of ten, at least as large as asked for.
fn round_step(least: f64) -> f64 {
    let power = libm::pow(10.0, libm::floor(libm::log10(least)));
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|n| n * power)
        .find(|step| *step >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

/// A chart that is being drawn. All that is put into it is markup.
pub(crate) struct Chart {
    width: f64,
    height: f64,
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
    x: Scale,
    y: Scale,
    body: String,
}

impl Chart {
    /// The width of a chart that shares a line with another.
    pub(crate) const HALF: (f64, f64) = (480.0, 300.0);

    /// A chart with its axes; their labels name what they show with its unit.
    pub(crate) fn new(
        (width, height): (f64, f64),
        (x, x_label): (Scale, &str),
        (y, y_label): (Scale, &str),
    ) -> Self {
        let widest = y.ticks().iter().map(|tick| y.label(*tick).chars().count()).max().unwrap_or(1);
        let left = 14.0 + 7.0 * widest as f64;
        let mut chart = Self {
            width,
            height,
            left,
            top: 30.0,
            right: width - 20.0,
            bottom: height - 42.0,
            x,
            y,
            body: String::new(),
        };
        for tick in y.ticks() {
            let at = chart.y(tick);
            let class = if tick.abs() < 1e-9 * (y.high - y.low) { "zero" } else { "grid" };
            chart.rule((chart.left, at), (chart.right, at), class);
            chart.text((chart.left - 7.0, at + 4.0), "end", &y.label(tick));
        }
        chart.x_axis();
        chart.text((0.0, 14.0), "start", y_label);
        chart.text((chart.right, chart.height - 6.0), "end", x_label);
        chart
    }

    /// A chart with a row for each of some names, from top to bottom, under a title.
    pub(crate) fn rows(title: &str, names: &[String], row: f64, (x, x_label): (Scale, &str)) -> Self {
        let width = Self::HALF.0;
        let widest = names.iter().map(|name| name.chars().count()).max().unwrap_or(1);
        let (left, top) = (14.0 + 7.2 * widest as f64, 26.0);
        let height = top + row * names.len() as f64 + 42.0;
        // Rows are counted downwards.
        let y = Scale { low: names.len() as f64, high: 0.0, step: -1.0 };
        let mut chart = Self {
            width,
            height,
            left,
            top,
            right: width - 20.0,
            bottom: height - 42.0,
            x,
            y,
            body: String::new(),
        };
        chart.x_axis();
        chart.text((0.0, 14.0), "start", title);
        for tick in x.ticks() {
            let at = chart.x(tick);
            let class = if tick.abs() < 1e-9 * (x.high - x.low) { "zero" } else { "grid" };
            chart.rule((at, chart.top), (at, chart.bottom), class);
        }
        for (i, name) in names.iter().enumerate() {
            let at = chart.y(i as f64 + 0.5);
            chart.text((chart.left - 9.0, at + 4.0), "end", name);
        }
        chart.text((chart.right, chart.height - 6.0), "end", x_label);
        chart
    }

    fn x_axis(&mut self) {
        for tick in self.x.ticks() {
            let at = self.x(tick);
            self.rule((at, self.bottom), (at, self.bottom + 4.0), "tick");
            self.text((at, self.bottom + 18.0), "middle", &self.x.label(tick));
        }
        self.rule((self.left, self.bottom), (self.right, self.bottom), "axis");
    }

    /// Where a value is across.
    pub(crate) fn x(&self, value: f64) -> f64 {
        self.left + self.x.share(value) * (self.right - self.left)
    }

    /// Where a value is from the top.
    pub(crate) fn y(&self, value: f64) -> f64 {
        self.bottom - self.y.share(value) * (self.bottom - self.top)
    }

    /// Puts markup into it.
    pub(crate) fn add(&mut self, markup: &str) {
        self.body.push_str(markup);
        self.body.push('\n');
    }

    fn rule(&mut self, a: (f64, f64), b: (f64, f64), class: &str) {
        self.add(&line(a, b, class));
    }

    fn text(&mut self, (x, y): (f64, f64), anchor: &str, text: &str) {
        self.add(&format!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
            escape(text)
        ));
    }

    /// Straight lines from value to value.
    pub(crate) fn course(&self, points: &[(f64, f64)]) -> String {
        path(points.iter().map(|(x, y)| (self.x(*x), self.y(*y))))
    }

    /// The whole picture; `title` says what is to be seen to those who cannot see it.
    pub(crate) fn finish(self, title: &str) -> String {
        let Self { width, height, body, .. } = self;
        format!(
            "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">\n{body}</svg>",
            escape(title)
        )
    }
}

/// A straight line.
pub(crate) fn line(a: (f64, f64), b: (f64, f64), class: &str) -> String {
    format!(
        "<line class=\"{class}\" x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\"/>",
        a.0, a.1, b.0, b.1
    )
}

/// The data of a path through points.
pub(crate) fn path(points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut out = String::new();
    for (i, (x, y)) in points.enumerate() {
        // Writing to a String never fails.
        let _ = write!(out, "{}{x:.1} {y:.1}", if i == 0 { 'M' } else { 'L' });
    }
    out
}

/// What a pointer that rests on a mark is told.
pub(crate) fn hint(text: &str) -> String {
    format!("<title>{}</title>", escape(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale) -> Vec<String> {
        scale.ticks().iter().map(|tick| scale.label(*tick)).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(labels(Scale::of([0.0, 83.0], 5)), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(labels(Scale::of([-0.3, 1.1], 4)), ["−0.5", "0", "0.5", "1.0", "1.5"]);
        assert_eq!(labels(Scale::of([0.0, 0.004], 4)), ["0", "0.001", "0.002", "0.003", "0.004"]);
        assert_eq!(labels(Scale::counts([1.0, 3.0], 8)), ["1", "2", "3"]);
        let until = Scale::until([0.0, 8001.0], 5);
        assert_eq!(labels(until), ["0", "2000", "4000", "6000", "8000"]);
        assert_eq!(until.high, 8001.0);
    }

    #[test]
    fn any_values_have_a_scale() {
        for values in [vec![], vec![0.0], vec![5.0], vec![-5.0], vec![f64::NAN, 1.0], vec![1e-12, 1e-12]] {
            let scale = Scale::of(values.clone(), 5);
            assert!(scale.low < scale.high && scale.ticks().len() > 1, "{values:?}: {scale:?}");
            assert!(
                values.iter().all(|x| x.is_nan() || (scale.low..=scale.high).contains(x)),
                "{values:?}: {scale:?}"
            );
        }
    }

    #[test]
    fn values_are_where_the_ticks_are() {
        let scale = || Scale::of([0.0, 10.0], 5);
        let chart = Chart::new(Chart::HALF, (scale(), "moves"), (scale(), "value (cm)"));
        assert_eq!((chart.y(0.0), chart.y(10.0)), (258.0, 30.0));
        assert_eq!((chart.x(0.0), chart.x(10.0)), (28.0, 460.0));
        assert_eq!(chart.course(&[(0.0, 0.0), (10.0, 10.0)]), "M28.0 258.0L460.0 30.0");
        assert!(chart.finish("a < b").contains("a &lt; b"));
    }
}
