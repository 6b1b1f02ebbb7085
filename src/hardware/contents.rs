//! What a target and its actuators say, line by line: to see what is another in two of them.

use grammar_lang::eval::MadeActuator;
use grammar_lang::ir::{Backend, JointKind, Speed, Table, Target};
use grammar_lang::units;

/// A number in a unit, to six places.
fn in_unit(value: f64, unit: &str) -> String {
    let factor = units::parse(unit).map_or(1.0, |unit| unit.factor);
    format!("{} {unit}", (value / factor * 1e6).round() / 1e6 + 0.0)
}

fn range((low, high): (f64, f64), unit: &str) -> String {
    format!("{} .. {}", in_unit(low, unit), in_unit(high, unit))
}

fn table(table: &Table, (from, to): (&str, &str)) -> String {
    let rows = table.rows.iter().map(|[x, y]| format!("{}: {}", in_unit(*x, from), in_unit(*y, to)));
    rows.collect::<Vec<_>>().join(", ")
}

/// What a target says, by the names that a grammar has for it.
fn of_target(target: &Target) -> Vec<(&'static str, String)> {
    let safe = |first: bool, names: [&str; 2]| if first { names[0] } else { names[1] }.to_owned();
    match &target.backend {
        Backend::Pneumatic(air) => {
            let mut lines = vec![
                ("inflate", air.inflate.join(", ")),
                ("vent", air.vent.join(", ")),
                ("shortest", in_unit(air.shortest, "ms")),
                ("safe", safe(air.vents, ["vent", "hold"])),
            ];
            if let Some(supply) = &air.supply {
                lines.extend([
                    ("supply.pressure", in_unit(supply.pressure, "bar")),
                    ("supply.full", in_unit(supply.full, "bar")),
                    ("supply.line", in_unit(supply.line, "cm^3/s/bar")),
                    ("supply.valve", in_unit(supply.valve, "cm^3/s/bar")),
                ]);
            }
            lines
        }
        Backend::Tendon(threads) => vec![
            ("servo", threads.servo.join(", ")),
            ("opposite", threads.opposite.join(", ")),
            ("thread", table(&threads.thread, ("deg", "mm"))),
            ("wheel", in_unit(threads.wheel, "mm")),
            ("turn", range(threads.turn, "deg")),
            ("servo_speed", in_unit(threads.speed, "deg/s")),
            ("pulse", range(threads.pulse, "us")),
            ("safe", safe(threads.rests, ["rest", "release"])),
        ],
    }
}

/// An actuator that a target drives, as it was simulated and as it would be played.
#[derive(Clone, Copy, Debug)]
pub struct Driven<'a> {
    /// What people call it.
    pub name: &'a str,
    /// As it was simulated.
    pub before: &'a MadeActuator,
    /// As it would be played.
    pub now: &'a MadeActuator,
}

/// How far and how fast an actuator moves.
fn of_actuator(actuator: &MadeActuator) -> Vec<(&'static str, String)> {
    let kind = actuator.joint.kind;
    let (position, velocity) = if kind == JointKind::Slide { ("mm", "mm/s") } else { ("deg", "deg/s") };
    let speed = |speed: &Speed| match speed {
        Speed::Constant(speed) => in_unit(*speed, velocity),
        Speed::ByBend(by_bend) => table(by_bend, ("deg", "deg/s")),
    };
    let limits = actuator.joint.range.map(|limits| (kind.range(), range(limits, position)));
    let speeds = actuator.motor.iter().flat_map(|motor| {
        [(kind.speed_field(), speed(&motor.speed)), ("relaxing_speed", speed(&motor.relaxing_speed))]
    });
    limits.into_iter().chain(speeds).collect()
}

/// What is another in a target and the actuators that it drives than in some before, in words: `` `shortest` is 2200 ms
/// (before: 40 ms)``. What is not the same for all actuators has the name of each.
#[must_use]
pub fn changes(before: Option<&Target>, now: &Target, driven: &[Driven<'_>]) -> Vec<String> {
    let target = differences(&before.map(of_target).unwrap_or_default(), &of_target(now));
    let mut told: Vec<String> =
        target.into_iter().map(|(name, change)| format!("`{name}` {change}")).collect();
    let each: Vec<Vec<(&str, String)>> =
        driven.iter().map(|one| differences(&of_actuator(one.before), &of_actuator(one.now))).collect();
    if each.windows(2).all(|pair| pair[0] == pair[1]) {
        let all = each.into_iter().next().unwrap_or_default();
        told.extend(all.into_iter().map(|(name, change)| format!("`{name}` {change}")));
    } else {
        for (one, own) in driven.iter().zip(each) {
            told.extend(own.into_iter().map(|(name, change)| format!("`{name}` of {} {change}", one.name)));
        }
    }
    told
}

/// The lines that are another in one of two lists, or only in one: the name, and what became of it.
fn differences(
    before: &[(&'static str, String)],
    now: &[(&'static str, String)],
) -> Vec<(&'static str, String)> {
    let was = |name: &str| before.iter().find(|(other, _)| *other == name).map(|(_, text)| text.as_str());
    let changed = now.iter().filter(|(name, text)| was(name) != Some(text));
    let gone = before.iter().filter(|(name, _)| now.iter().all(|(other, _)| other != name));
    let told = changed.map(|(name, text)| {
        (*name, format!("is {} (before: {})", or_none(text), was(name).map_or("none", or_none)))
    });
    told.chain(gone.map(|(name, was)| (*name, format!("is none (before: {})", or_none(was))))).collect()
}

fn or_none(text: &str) -> &str {
    if text.is_empty() { "none" } else { text }
}

#[cfg(test)]
mod tests {
    use grammar_lang::eval::{MadeJoint, MadeMotor};
    use grammar_lang::ir::{Form, Pneumatic, Supply};
    use grammar_lang::shape::Shape;
    use grammar_lang::source::Span;

    use super::*;

    fn valves(shortest: f64, supply: Option<Supply>) -> Target {
        let pins = |name: &str| vec![name.to_owned()];
        let (inflate, vent) = (pins("D3"), pins("D4"));
        let backend = Backend::Pneumatic(Pneumatic { inflate, vent, shortest, vents: true, supply });
        Target { backend, kind: "finger".to_owned(), speed: None, sensors: Vec::new(), span: Span::default() }
    }

    #[test]
    fn what_is_another_is_told_with_what_it_was() {
        let supply = Supply { pressure: 1.5e5, full: 1e5, line: 6e-10, valve: 2e-10 };
        let (one, other) = (valves(0.04, Some(supply)), valves(2.2, None));
        assert!(changes(Some(&one), &one, &[]).is_empty());
        let told = changes(Some(&one), &other, &[]);
        assert_eq!(told[0], "`shortest` is 2200 ms (before: 40 ms)");
        assert!(told.contains(&"`supply.pressure` is none (before: 1.5 bar)".to_owned()), "{told:?}");
        assert_eq!(told.len(), 5, "{told:?}");
        assert_eq!(changes(None, &one, &[]).len(), 8);
    }

    #[test]
    fn what_actuators_do_is_told_once_if_it_is_the_same_for_all() {
        let row = |speed: f64| MadeActuator {
            segment: Form { shape: Shape::Ball { radius: 0.01 }, stands: false },
            mass: 0.01,
            friction: 0.5,
            motor: Some(MadeMotor {
                speed: Speed::Constant(speed.to_radians()),
                relaxing_speed: Speed::Constant(1.0),
                effort: 0.1,
            }),
            joint: MadeJoint {
                kind: JointKind::Bend,
                axis: [0.0, 0.0, 1.0],
                pivot: None,
                stiffness: 0.3,
                sideways: None,
                torsion: None,
                damping: 0.01,
                range: Some((-1.0, 1.0)),
                neutral: 0.0,
                begins: None,
                mirrored: false,
            },
            colour: "#112233".to_owned(),
        };
        let [fast, slow, slower] = [90.0, 60.0, 30.0].map(row);
        let target = valves(0.04, None);
        let told = |nows: [&MadeActuator; 2]| {
            let driven = ["bender-1", "bender-2"].into_iter().zip(nows);
            let driven: Vec<Driven<'_>> =
                driven.map(|(name, now)| Driven { name, before: &fast, now }).collect();
            changes(Some(&target), &target, &driven)
        };
        assert!(told([&fast, &fast]).is_empty());
        assert_eq!(told([&slow, &slow]), ["`bending_speed` is 60 deg/s (before: 90 deg/s)"]);
        assert_eq!(
            told([&slow, &slower]),
            [
                "`bending_speed` of bender-1 is 60 deg/s (before: 90 deg/s)",
                "`bending_speed` of bender-2 is 30 deg/s (before: 90 deg/s)"
            ]
        );
    }
}
