//! A schedule as a drawing: a file of SVG that stands alone, for bright and dark backgrounds.

use std::fmt::Write;

use super::dry_run::{angle, safe_words, word};
use super::schedule::{Channel, Micros, Output, Schedule, ValveState, seconds};
use crate::markup::escape;

pub(super) const WIDTH: f64 = 1000.0;
pub(super) const LEFT: f64 = 190.0;
pub(super) const RIGHT: f64 = WIDTH - 66.0;
const TOP: f64 = 104.0;
const BAND: f64 = 26.0;
const VALVE_ROW: f64 = 42.0;
const SERVO_ROW: f64 = 118.0;

pub(super) const STYLE: &str = "\
svg { --page: #ffffff; --ink: #1d2126; --quiet: #5f6670; --faint: #e3e4e2; --track: #f0f1ef; \
--inflate: #1f6fd1; --vent: #e08a2e; --curve: #1f6fd1; background: var(--page); }
@media (prefers-color-scheme: dark) { svg { --page: #16181b; --ink: #e4e6e9; --quiet: #9aa2ac; --faint: #2f343a; \
--track: #202429; --inflate: #6aa9f5; --vent: #f2a35e; --curve: #6aa9f5; } }
text { font: 13px system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif; fill: var(--ink); \
font-variant-numeric: tabular-nums; }
.title { font-size: 19px; font-weight: 650; }
.name { font-weight: 600; text-anchor: end; }
.quiet { fill: var(--quiet); font-size: 12px; }
.end { text-anchor: end; }
.middle { text-anchor: middle; }
.grid { stroke: var(--faint); }
.edge { stroke: var(--quiet); stroke-dasharray: 2 3; }
.track, .closed { fill: var(--track); }
.swatch { stroke: var(--faint); }
.inflate { fill: var(--inflate); }
.vent { fill: var(--vent); }
.curve { fill: none; stroke: var(--curve); stroke-width: 2; stroke-linejoin: round; }
.simulated { stroke: var(--ink); stroke-width: 1.3; stroke-dasharray: 5 4; }
.area { fill: var(--curve); opacity: 0.12; }
.on { fill: var(--page); font-size: 11px; text-anchor: middle; }
";

/// Time from left to right.
struct Axis {
    period: Micros,
}

impl Axis {
    fn x(&self, time: f64) -> f64 {
        LEFT + (RIGHT - LEFT) * time / f64::from(self.period.max(1))
    }

    /// Round times, at most ten apart from 0.
    fn ticks(&self) -> Vec<Micros> {
        let decades = (0..9).map(|power| 10_u32.pow(power));
        let mut steps = decades.flat_map(|decade| [decade, decade * 2, decade.saturating_mul(5)]);
        let step = steps.find(|step| self.period / step <= 10).unwrap_or(self.period.max(1));
        (0..=self.period / step).map(|i| i * step).collect()
    }
}

/// The drawing of a schedule.
#[must_use]
pub fn svg(schedule: &Schedule) -> String {
    let row = if schedule.has_valves() { VALVE_ROW } else { SERVO_ROW };
    let bottom = TOP + row * schedule.channels.len() as f64;
    let height = bottom + 50.0;
    let axis = Axis { period: schedule.period };
    let mut out = String::new();
    let _ = writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" \
         viewBox=\"0 0 {WIDTH} {height}\" role=\"img\">\n<style>\n{STYLE}</style>"
    );
    let kind = if schedule.has_valves() { "Valves" } else { "Servos" };
    text(&mut out, (24.0, 36.0), "title", &format!("{kind} over one period of {}", seconds(schedule.period)));
    text(&mut out, (24.0, 58.0), "quiet", &format!("When it stops: {}", safe_words(schedule.safe)));
    if schedule.has_valves() {
        legend(&mut out);
    }
    for tick in axis.ticks() {
        let x = axis.x(f64::from(tick));
        let _ = writeln!(out, "<path class=\"grid\" d=\"M{x:.1} {:.1}V{:.1}\"/>", TOP - 6.0, bottom + 4.0);
        let label = seconds(tick);
        text(&mut out, (x, bottom + 20.0), "quiet middle", label.trim_end_matches(" s"));
    }
    text(&mut out, ((LEFT + RIGHT) / 2.0, bottom + 40.0), "quiet middle", "time in s");
    for (i, channel) in schedule.channels.iter().enumerate() {
        let top = TOP + row * i as f64;
        head(&mut out, channel, top + row / 2.0);
        match &channel.output {
            Output::Valves { changes, .. } => bands(&mut out, &axis, changes, top + (row - BAND) / 2.0),
            Output::Servo { pulses, range, degrees, .. } => {
                curve(&mut out, &axis, pulses, (*range, *degrees), (top + 19.0, top + row - 19.0));
            }
        }
    }
    out.push_str("</svg>\n");
    out
}

pub(super) fn text(out: &mut String, (x, y): (f64, f64), class: &str, words: &str) {
    let _ = writeln!(out, "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>", escape(words));
}

fn head(out: &mut String, channel: &Channel, middle: f64) {
    let pins = match &channel.output {
        Output::Valves { inflate, vent, .. } => format!("in {inflate}, out {vent}"),
        Output::Servo { pin, .. } => pin.to_string(),
    };
    // Servos have the numbers of their axis between the name and the curve.
    let x = if matches!(channel.output, Output::Servo { .. }) { LEFT - 52.0 } else { LEFT - 16.0 };
    let mut name: String = channel.name.chars().take(20).collect();
    if name.len() < channel.name.len() {
        name.push('…');
    }
    text(out, (x, middle - 1.0), "name", &name);
    text(out, (x, middle + 14.0), "quiet end", &pins);
}

fn legend(out: &mut String) {
    let mut x = RIGHT - 216.0;
    for (state, wide) in [(ValveState::Inflate, 82.0), (ValveState::Closed, 84.0), (ValveState::Vent, 60.0)] {
        let class = word(state);
        let _ = writeln!(
            out,
            "<rect class=\"swatch {class}\" x=\"{x:.1}\" y=\"74\" width=\"16\" height=\"12\" rx=\"3\"/>"
        );
        text(out, (x + 22.0, 84.5), "quiet", class);
        x += wide;
    }
}

fn bands(out: &mut String, axis: &Axis, changes: &[(Micros, ValveState)], top: f64) {
    let wide = RIGHT - LEFT;
    let _ = writeln!(
        out,
        "<rect class=\"track\" x=\"{LEFT}\" y=\"{top:.1}\" width=\"{wide}\" height=\"{BAND}\" rx=\"4\"/>"
    );
    for (i, (at, state)) in changes.iter().enumerate() {
        let until = changes.get(i + 1).map_or(axis.period, |(next, _)| *next);
        if *state == ValveState::Closed || until <= *at {
            continue;
        }
        let (x, end) = (axis.x(f64::from(*at)), axis.x(f64::from(until)));
        let class = word(*state);
        let _ = writeln!(
            out,
            "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{BAND}\" rx=\"4\">\
             <title>{class} {} to {}</title></rect>",
            (end - x).max(1.0),
            seconds(*at),
            seconds(until)
        );
        // How long, where there is room for it.
        let length = format!("{:.2} s", f64::from(until - at) / 1e6);
        if end - x > 9.0 * length.len() as f64 {
            text(out, ((x + end) / 2.0, top + BAND / 2.0 + 4.0), "on", &length);
        }
    }
}

fn curve(
    out: &mut String,
    axis: &Axis,
    pulses: &[u16],
    (range, degrees): ([u16; 2], [f64; 2]),
    (top, bottom): (f64, f64),
) {
    let share = |pulse: f64| angle(pulse, range, [0.0, 1.0]);
    let y = |pulse: f64| bottom - (bottom - top) * share(pulse);
    let middle = f64::midpoint(f64::from(range[0]), f64::from(range[1]));
    for (pulse, class) in [(f64::from(range[1]), "edge"), (middle, "grid"), (f64::from(range[0]), "edge")] {
        let at = y(pulse);
        let _ = writeln!(out, "<path class=\"{class}\" d=\"M{LEFT} {at:.1}H{RIGHT}\"/>");
        let degrees = format!("{:.0}°", angle(pulse, range, degrees)).replace('-', "−");
        text(out, (LEFT - 8.0, at + 4.0), "quiet end", &degrees);
        text(out, (RIGHT + 8.0, at + 4.0), "quiet", &format!("{pulse:.0} µs"));
    }
    let Some(first) = pulses.first() else { return };
    let mut path = String::new();
    let many = pulses.len() as f64;
    for (i, pulse) in pulses.iter().chain([first]).enumerate() {
        let x = axis.x(f64::from(axis.period) * i as f64 / many);
        let letter = if i == 0 { 'M' } else { 'L' };
        let _ = write!(path, "{letter}{x:.1} {:.1}", y(f64::from(*pulse)));
    }
    let _ = writeln!(
        out,
        "<path class=\"area\" d=\"{path}L{RIGHT} {:.1}L{LEFT} {:.1}Z\"/>",
        y(middle),
        y(middle)
    );
    let _ = writeln!(out, "<path class=\"curve\" d=\"{path}\"/>");
}

#[cfg(test)]
mod tests {
    use super::super::schedule::tests::{servos, valves};
    use super::*;

    /// A drawing as its elements; it must be well-formed.
    fn count(drawing: &str, class: &str) -> usize {
        let document = roxmltree::Document::parse(drawing).unwrap();
        document.descendants().filter(|node| node.attribute("class") == Some(class)).count()
    }

    #[test]
    fn every_phase_and_every_curve_is_drawn() {
        let drawing = svg(&valves(&["front", "<hind> & \"left\""]));
        assert_eq!((count(&drawing, "inflate"), count(&drawing, "vent"), count(&drawing, "name")), (2, 2, 2));
        let drawing = svg(&servos(&["wrist", "elbow", "knee"]));
        assert_eq!((count(&drawing, "curve"), count(&drawing, "edge")), (3, 6));
    }

    #[test]
    fn whatever_a_schedule_holds_can_be_drawn() {
        let mut odd = valves(&["a"]);
        odd.period = 0;
        assert_eq!(count(&svg(&odd), "name"), 1);
        odd.period = u32::MAX;
        assert!(Axis { period: u32::MAX }.ticks().len() <= 11);
        assert_eq!(count(&svg(&odd), "name"), 1);
        odd.channels.clear();
        assert_eq!(count(&svg(&odd), "name"), 0);
    }

    #[test]
    fn ticks_are_round_and_not_many() {
        let ticks = |period| Axis { period }.ticks();
        assert_eq!(ticks(1_000_000).len(), 11);
        assert_eq!(ticks(1_700_003)[1], 200_000);
        assert_eq!(ticks(100_000)[1], 10_000);
    }
}
