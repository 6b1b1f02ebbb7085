//! Motions of actuators as they were simulated and as they would be played: what is shown before anything else than the simulated moves.

use std::fmt::Write;

use grammar_lang::ir::JointKind;

use super::picture::{LEFT, RIGHT, STYLE, WIDTH, text};

const TOP: f64 = 92.0;
const ROW: f64 = 118.0;

/// What one actuator does, over the same time.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// What people call it.
    pub name: String,
    /// How it moves: what follows is in rad, of a slide in m, of a spin in rad/s.
    pub joint: JointKind,
    /// Time between samples, s; the first is at zero.
    pub interval: f64,
    /// As it was simulated.
    pub simulated: Vec<f64>,
    /// As it would be played.
    pub played: Vec<f64>,
    /// From which sample on they are compared: before it, actuators come from rest to their first period's end.
    pub from: usize,
}

impl Compared {
    /// When they are furthest apart, s, and what both are then.
    #[must_use]
    pub fn furthest(&self) -> (f64, f64, f64) {
        let pairs = self.simulated.iter().zip(&self.played).enumerate().skip(self.from);
        let apart = |(_, (a, b)): &(usize, (&f64, &f64))| (*a - *b).abs();
        let most = pairs.max_by(|a, b| apart(a).total_cmp(&apart(b)));
        most.map_or((0.0, 0.0, 0.0), |(i, (a, b))| (i as f64 * self.interval, *a, *b))
    }

    /// How far apart they are at most.
    #[must_use]
    pub fn apart(&self) -> f64 {
        let (_, simulated, played) = self.furthest();
        (simulated - played).abs()
    }

    /// Whether they are never further apart than what counts as the same.
    #[must_use]
    pub fn is_same(&self) -> bool {
        self.apart() <= same(self.joint)
    }

    /// In words.
    #[must_use]
    pub fn told(&self) -> String {
        let (time, simulated, played) = self.furthest();
        let verb = match self.joint {
            JointKind::Bend | JointKind::Socket => "bent by",
            JointKind::Twist => "twisted by",
            JointKind::Slide => "moved by",
            JointKind::Spin => "turning at",
        };
        let [played, simulated] = [played, simulated].map(|value| in_words(self.joint, value));
        format!("{}: {verb} {played} where {simulated} were simulated, at {time:.2} s", self.name)
    }
}

/// What an actuator does counts as the same if it differs by no more: half a degree, a quarter of a millimetre, 5 degrees a second.
#[must_use]
pub fn same(joint: JointKind) -> f64 {
    match joint {
        JointKind::Bend | JointKind::Twist | JointKind::Socket => 0.5_f64.to_radians(),
        JointKind::Slide => 0.25e-3,
        JointKind::Spin => 5.0_f64.to_radians(),
    }
}

/// How much of one's unit an actuator does, with the unit.
#[must_use]
pub fn in_words(joint: JointKind, value: f64) -> String {
    match joint {
        JointKind::Bend | JointKind::Twist | JointKind::Socket => {
            format!("{:.1} deg", value.to_degrees() + 0.0)
        }
        JointKind::Slide => format!("{:.1} mm", value * 1e3 + 0.0),
        JointKind::Spin => format!("{:.1} deg/s", value.to_degrees() + 0.0),
    }
}

/// A drawing of all of them: a file of SVG that stands alone.
#[must_use]
pub fn svg(title: &str, all: &[Compared]) -> String {
    let bottom = TOP + ROW * all.len() as f64;
    let height = bottom + 50.0;
    let samples = all.iter().map(|one| one.simulated.len()).max().unwrap_or(0);
    let duration = samples.saturating_sub(1) as f64 * all.first().map_or(0.0, |one| one.interval);
    let mut out = String::new();
    // Writing to a String never fails.
    let _ = writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" \
         viewBox=\"0 0 {WIDTH} {height}\" role=\"img\">\n<style>\n{STYLE}</style>"
    );
    text(&mut out, (24.0, 36.0), "title", title);
    let legend = "dashed line: as simulated; solid line: as the board would play it";
    text(&mut out, (24.0, 58.0), "quiet", legend);
    let x = |time: f64| LEFT + (RIGHT - LEFT) * if duration > 0.0 { time / duration } else { 0.0 };
    for tick in 0..=5 {
        let time = duration * f64::from(tick) / 5.0;
        let _ = writeln!(out, "<path class=\"grid\" d=\"M{:.1} {TOP:.1}V{bottom:.1}\"/>", x(time));
        text(&mut out, (x(time), bottom + 20.0), "quiet middle", &format!("{time:.1}"));
    }
    text(&mut out, ((LEFT + RIGHT) / 2.0, bottom + 40.0), "quiet middle", "time in s");
    for (row, one) in all.iter().enumerate() {
        // What moves alike is drawn to one scale.
        let alike = || all.iter().filter(|other| other.joint == one.joint);
        let values = || alike().flat_map(|one| one.simulated.iter().chain(&one.played)).copied();
        let (low, high) = (values().fold(0.0, f64::min), values().fold(0.0, f64::max));
        let span = (high - low).max(4.0 * same(one.joint));
        let (top, end) = (TOP + ROW * row as f64 + 12.0, TOP + ROW * (row + 1) as f64 - 12.0);
        let y = |bend: f64| end - (end - top) * (bend - low) / span;
        text(&mut out, (LEFT - 52.0, f64::midpoint(top, end)), "name", &one.name);
        for bend in [low, 0.0, low + span] {
            let _ = writeln!(out, "<path class=\"grid\" d=\"M{LEFT} {:.1}H{RIGHT}\"/>", y(bend));
            let label = match one.joint {
                JointKind::Slide => format!("{:.1} mm", bend * 1e3 + 0.0),
                JointKind::Spin => format!("{:.0}°/s", bend.to_degrees() + 0.0),
                JointKind::Bend | JointKind::Twist | JointKind::Socket => {
                    format!("{:.0}°", bend.to_degrees() + 0.0)
                }
            };
            text(&mut out, (LEFT - 8.0, y(bend) + 4.0), "quiet end", &label.replace('-', "−"));
        }
        for (class, values) in [("curve", &one.played), ("curve simulated", &one.simulated)] {
            let mut path = String::new();
            for (i, bend) in values.iter().enumerate() {
                let letter = if i == 0 { 'M' } else { 'L' };
                let _ = write!(path, "{letter}{:.1} {:.1}", x(i as f64 * one.interval), y(*bend));
            }
            let _ = writeln!(out, "<path class=\"{class}\" d=\"{path}\"/>");
        }
    }
    out.push_str("</svg>\n");
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(played: [f64; 3]) -> Compared {
        Compared {
            name: "<left>".to_owned(),
            joint: JointKind::Bend,
            interval: 0.5,
            simulated: vec![0.0, 1.0, 0.5],
            played: played.to_vec(),
            from: 0,
        }
    }

    #[test]
    fn the_moment_when_they_are_furthest_apart_is_told() {
        let one = one([0.0, 0.8, 0.9]);
        assert_eq!(one.furthest(), (1.0, 0.5, 0.9));
        assert_eq!(one.told(), "<left>: bent by 51.6 deg where 28.6 deg were simulated, at 1.00 s");
        let begun = Compared { played: vec![0.7, 1.0, 0.5], from: 1, ..one };
        assert_eq!(begun.apart(), 0.0, "the beginning does not count");
        // Half a millimetre is much for what slides, though it is less than half a degree in rad.
        let slid = |by: f64| Compared {
            joint: JointKind::Slide,
            simulated: vec![0.0, 0.008, 0.0],
            played: vec![0.0, 0.008 - by, 0.0],
            from: 0,
            ..begun.clone()
        };
        assert!(slid(1e-4).is_same() && !slid(5e-4).is_same());
        assert_eq!(slid(0.008).told(), "<left>: moved by 0.0 mm where 8.0 mm were simulated, at 0.50 s");
    }

    #[test]
    fn both_curves_of_each_actuator_are_drawn() {
        for all in [vec![], vec![one([0.0; 3])], vec![one([0.0; 3]), one([-2.0, 1.0, 3.0])]] {
            let drawing = svg("Bends on `valves` & more", &all);
            let document = roxmltree::Document::parse(&drawing).unwrap();
            let count =
                |class: &str| document.descendants().filter(|n| n.attribute("class") == Some(class)).count();
            assert_eq!((count("curve"), count("curve simulated")), (all.len(), all.len()));
            assert!(!drawing.contains("NaN"));
        }
    }
}
