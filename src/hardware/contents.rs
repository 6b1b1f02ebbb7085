//! What a target and its actuators say, line by line: to see what is another in two of them.

use grammar_lang::ir::{Actuator, Backend, Field, JointKind, Speed, Table, Target};
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

/// What a field is whose value each actuator has for itself.
const VARIES: &str = "by its parameters";

fn of_actuator(actuator: &Actuator) -> Vec<(&'static str, String)> {
    let kind = actuator.joint.kind;
    let (position, velocity) = if kind == JointKind::Slide { ("mm", "mm/s") } else { ("deg", "deg/s") };
    let speed = |speed: &Speed| match speed {
        Speed::Constant(speed) => in_unit(*speed, velocity),
        Speed::ByBend(by_bend) => table(by_bend, ("deg", "deg/s")),
    };
    let speed = |field: &Field<Speed>| field.fixed().map_or_else(|| VARIES.to_owned(), speed);
    let mut fields = Vec::new();
    match &actuator.joint.range {
        Some(Field::Fixed(limits)) => fields.push((kind.range(), range(*limits, position))),
        Some(Field::Varies(_)) => fields.push((kind.range(), VARIES.to_owned())),
        None => {}
    }
    if let Some(motor) = &actuator.motor {
        fields.push((kind.speed_field(), speed(&motor.speed)));
        fields.push(("relaxing_speed", speed(&motor.relaxing_speed)));
    }
    fields
}

/// What is another in a target and the actuators that it drives than in some before, in words: `` `shortest` is 2200 ms
/// (before: 40 ms)``.
#[must_use]
pub fn changes(
    before: (Option<&Target>, Option<&Actuator>),
    now: (&Target, Option<&Actuator>),
) -> Vec<String> {
    let lines = |target: Option<&Target>, actuator: Option<&Actuator>| {
        let own = target.map(of_target).unwrap_or_default();
        own.into_iter().chain(actuator.map(of_actuator).unwrap_or_default()).collect::<Vec<_>>()
    };
    let before = lines(before.0, before.1);
    let now = lines(Some(now.0), now.1);
    let was = |name: &str| before.iter().find(|(other, _)| *other == name).map(|(_, text)| text.as_str());
    let changed = now.iter().filter(|(name, text)| was(name) != Some(text));
    let gone = before.iter().filter(|(name, _)| now.iter().all(|(other, _)| other != name));
    let told = changed.map(|(name, text)| match was(name) {
        Some(was) => format!("`{name}` is {} (before: {})", or_none(text), or_none(was)),
        None => format!("`{name}` is {} (before: none)", or_none(text)),
    });
    told.chain(gone.map(|(name, was)| format!("`{name}` is none (before: {})", or_none(was)))).collect()
}

fn or_none(text: &str) -> &str {
    if text.is_empty() { "none" } else { text }
}

#[cfg(test)]
mod tests {
    use grammar_lang::ir::{Pneumatic, Supply};
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
        assert!(changes((Some(&one), None), (&one, None)).is_empty());
        let told = changes((Some(&one), None), (&other, None));
        assert_eq!(told[0], "`shortest` is 2200 ms (before: 40 ms)");
        assert!(told.contains(&"`supply.pressure` is none (before: 1.5 bar)".to_owned()), "{told:?}");
        assert_eq!(told.len(), 5, "{told:?}");
        assert_eq!(changes((None, None), (&one, None)).len(), 8);
    }
}
