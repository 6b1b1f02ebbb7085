//! What quantities of robots usually lie within. What lies beyond is possible, but mostly a slip of the unit.

use super::Declarations;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::Filling;
use crate::source::Span;
use crate::syntax::ast::{self, ExprKind};
use crate::units::{self, Dimension, Unit};

/// The usual values of a field.
#[derive(Clone, Copy, Debug)]
pub struct Usual {
    /// What has the field: `a part`.
    pub of: &'static str,
    /// The field.
    pub field: &'static str,
    /// The least, in the unit.
    pub least: f64,
    /// The greatest, in the unit.
    pub most: f64,
    /// The unit; empty for a number.
    pub unit: &'static str,
    /// What lies at the ends, for people.
    pub ends: &'static str,
}

impl Usual {
    /// Whether a value outside the range is meant: some parts have no friction at all.
    pub(crate) fn is_meant(&self, value: f64) -> bool {
        value == 0.0 && self.field == "friction"
    }
}

const fn usual(
    of: &'static str,
    field: &'static str,
    (least, most): (f64, f64),
    unit: &'static str,
    ends: &'static str,
) -> Usual {
    Usual { of, field, least, most, unit, ends }
}

/// Rubber on dry concrete has 0.6 to 1 in most tables, 1 to 4 in one (M. Michaels, "Coefficients of friction for rubber",
/// hypertextbook.com/facts/2006/MatthewMichaels.shtml).
/// Nothing that robots are made of is softer, Pa: the softest gels have some kPa.
const SOFTEST: f64 = 4e3;
const FRICTION: (f64, f64) = (0.01, 3.0);
/// Most slabstock foams have 12 to 40 kg/m^3 ("Handbook of Polymer Foams", 5.6.1), osmium has 22.59 g/cm^3 (Guinness World Records,
/// "Densest naturally occurring element").
const DENSITY: (f64, f64) = (0.01, 23.0);

/// As a share of what it is in the grammar.
const OF_IT: (f64, f64) = (0.0, 300.0);
const OF_IT_ENDS: &str = "nothing and three times as much";
const TURNING: (f64, f64) = (1.0, 7200.0);
const TURNING_ENDS: &str = "a turn in six minutes and 20 turns a second";
const TORQUE: (f64, f64) = (1e-5, 100.0);
const TORQUE_ENDS: &str = "a watch spring and a car's wiper motor";
const TURNED: (f64, f64) = (1e-5, 1000.0);
const TURNED_ENDS: &str = "a thread and a steel beam";
const SLIDING: (f64, f64) = (0.1, 3000.0);
const SLIDING_ENDS: &str = "a slow spindle and a fast air cylinder";

/// All fields of which usual values are known. They are wide. `docs/usual.md` says which were looked up, and where: the others
/// stand from memory. What they are of, at both ends, is told to the user.
pub const USUAL: &[Usual] = &[
    usual("a part", "density", DENSITY, "g/cm^3", "foam and osmium"),
    usual("an actuator", "density", DENSITY, "g/cm^3", "foam and osmium"),
    usual("a part", "mass", (1e-6, 20.0), "kg", "a grain of sand and a bucket of water"),
    usual("an actuator", "mass", (1e-6, 20.0), "kg", "a grain of sand and a bucket of water"),
    usual("a part", "friction", FRICTION, "", "ice and soft rubber"),
    usual("an actuator", "friction", FRICTION, "", "ice and soft rubber"),
    usual("a cell", "friction", FRICTION, "", "ice and soft rubber"),
    usual("a cell", "spacing", (0.1, 200.0), "mm", "a hair and a hand"),
    usual("an actuator", "bend", (-360.0, 360.0), "deg", "a full turn in either direction"),
    usual("an actuator", "bending_speed", TURNING, "deg/s", TURNING_ENDS),
    usual("an actuator", "relaxing_speed", TURNING, "deg/s", TURNING_ENDS),
    usual("an actuator", "torque", TORQUE, "N*m/rad", TORQUE_ENDS),
    usual("an actuator", "stiffness", TURNED, "N*m/rad^2", TURNED_ENDS),
    usual("an actuator that twists", "range", (-1080.0, 1080.0), "deg", "three turns in either direction"),
    usual("an actuator that twists", "speed", TURNING, "deg/s", TURNING_ENDS),
    usual("an actuator that twists", "relaxing_speed", TURNING, "deg/s", TURNING_ENDS),
    usual("an actuator that twists", "effort", TORQUE, "N*m/rad", TORQUE_ENDS),
    usual("an actuator that twists", "stiffness", TURNED, "N*m/rad^2", TURNED_ENDS),
    usual("an actuator that slides", "range", (-1000.0, 1000.0), "mm", "a long cylinder in either direction"),
    usual("an actuator that slides", "speed", SLIDING, "mm/s", SLIDING_ENDS),
    usual("an actuator that slides", "relaxing_speed", SLIDING, "mm/s", SLIDING_ENDS),
    usual(
        "an actuator that slides",
        "effort",
        (1e-3, 1e4),
        "N",
        "the weight of a tenth of a gram and of a ton",
    ),
    usual("an actuator that slides", "stiffness", (0.1, 1e7), "N/m", "a thread of rubber and a steel rod"),
    usual(
        "an actuator that spins",
        "speed",
        (1.0, 60000.0),
        "deg/s",
        "a turn in six minutes and 10,000 turns a minute",
    ),
    usual("an actuator that spins", "effort", TORQUE, "N*m/rad", TORQUE_ENDS),
    usual("a model", "step", (1e-6, 1.0 / 60.0), "s", "a millionth of a second and a frame of film"),
    usual("a model", "control", (0.5, 200.0), "ms", "a servo drive and five samples a second"),
    usual("a model", "record", (0.5, 500.0), "ms", "a high-speed camera and two frames a second"),
    usual("a model", "gravity", (1.0, 30.0), "m/s^2", "the Moon at 1.6 and Jupiter at about 25"),
    usual("a model", "ground_friction", (0.01, 3.0), "", "ice and soft rubber"),
    usual("a model", "tolerance", (0.0, 0.1), "", "0 and a tenth of all impulses"),
    usual("a model", "speed_limit", (0.1, 100.0), "m/s", "a tortoise and an express train"),
    usual("a model", "pace_limit", (0.005, 10.0), "m/s", "a snail and a sprinter"),
    usual("a supply", "pressure", (0.02, 12.0), "bar", "a balloon and a workshop's compressor"),
    usual("a supply", "full", (0.01, 12.0), "bar", "a balloon and a workshop's compressor"),
    usual("a supply", "line", (0.1, 1e4), "cm^3/s/bar", "a hair-thin tube and a garden hose"),
    usual("a supply", "valve", (0.1, 1e4), "cm^3/s/bar", "a hair-thin tube and a garden hose"),
    usual("a target", "shortest", (1.0, 1000.0), "ms", "a piezo valve and a motor valve"),
    usual("a target", "wheel", (1.0, 60.0), "mm", "a servo's shaft and a saucer"),
    usual("a target", "servo_speed", (30.0, 3000.0), "deg/s", "a slow winch and a fast servo"),
    usual("a target", "turn", (-3600.0, 3600.0), "deg", "ten turns of a winch in either direction"),
    usual("a prototype", "simulated", (1e-6, 10.0), "m/s", "4 mm in an hour and a sprinter"),
    usual("a prototype", "measured", (1e-6, 10.0), "m/s", "4 mm in an hour and a sprinter"),
    usual("a search", "spread", (0.1, 200.0), "%", "a thousandth of each domain and twice the domain"),
    usual(
        "a search",
        "temperature",
        (1e-4, 1e5),
        "",
        "a ten-thousandth of the objective's unit and a hundred thousand of it",
    ),
    usual("a set of worlds", "friction", OF_IT, "%", OF_IT_ENDS),
    usual("a set of worlds", "ground_friction", (0.01, 3.0), "", "ice and soft rubber"),
    usual("a set of worlds", "mass", OF_IT, "%", OF_IT_ENDS),
    usual("a set of worlds", "torque", OF_IT, "%", OF_IT_ENDS),
    usual("a set of worlds", "speed", OF_IT, "%", OF_IT_ENDS),
    usual("a set of worlds", "late", (0.0, 500.0), "ms", "no delay and half a second"),
    usual("a motion", "duration", (0.5, 600.0), "s", "half a second and ten minutes"),
];

/// A finger of silicone that is let go is straight within about a second, s.
const LONGEST_LAG: f64 = 2.0;

impl Declarations<'_> {
    /// Warns where a field, which comes to `value` (SI), lies beyond what is usual.
    pub(super) fn usual(&mut self, of: &str, field: &str, value: f64, tree: &ast::Expr) {
        let Some(usual) = usual_of(of, field) else { return };
        // What swings freely has no spring.
        if usual.is_meant(value) || value == 0.0 && of.starts_with("a passive row") {
            return;
        }
        let size = unit(usual.unit);
        let (least, most) = (usual.least * size.factor, usual.most * size.factor);
        // Rounding is no slip.
        let slack = 1e-9 * least.abs().max(most.abs());
        if value >= least - slack && value <= most + slack {
            return;
        }
        let written = written(tree).filter(|(_, unit)| unit.dimension == size.dimension);
        let (name, scale) = written.map_or((usual.unit, size.factor), |(name, unit)| (name, unit.factor));
        let shown = |x: f64| shown(x / scale, name);
        let range = format!("{} .. {}", shown(least), shown(most));
        // What is only just beyond must not be rounded to the end.
        let close = [least, most].iter().any(|end| shown(*end) == shown(value));
        let beyond =
            if close { format!("{} {name}", value / scale).trim_end().to_owned() } else { shown(value) };
        let slip = slip(tree, size.dimension, (least, most));
        let mend = slip.map_or("check the unit. ".to_owned(), |meant| format!("is `{meant}` meant? "));
        self.report(
            Diagnostic::new(
                Code::UNUSUAL,
                tree.span,
                format!("`{field} = {beyond}` is far outside the usual range for robots"),
            )
            .label(format!("usual: {range}, between {}", usual.ends))
            .help(mend + &allowed()),
        );
    }

    /// Warns where a mass makes a shape denser or lighter than any material; volume in m^3.
    pub(super) fn usual_density(&mut self, of: &str, mass: f64, volume: f64, tree: &ast::Expr) {
        let Some(usual) = usual_of(of, "density") else { return };
        let density = mass / volume / unit(usual.unit).factor;
        if !density.is_finite() || (usual.least..=usual.most).contains(&density) {
            return;
        }
        let range = format!("{} .. {}", shown(usual.least, usual.unit), shown(usual.most, usual.unit));
        let message = format!("this mass gives a density of {}", shown(density, usual.unit));
        self.report(
            Diagnostic::new(Code::UNUSUAL, tree.span, message)
                .label(format!("usual: {range}, between {}", usual.ends))
                .help(format!("check the unit of the mass and the sizes of the shape. {}", allowed())),
        );
    }

    /// Warns where a density gives a shape a mass that no part of a robot has, in kg.
    pub(super) fn usual_mass(&mut self, of: &str, mass: f64, tree: &ast::Expr) {
        let Some(usual) = usual_of(of, "mass").filter(|usual| !(usual.least..=usual.most).contains(&mass))
        else {
            return;
        };
        let range = format!("{} .. {}", shown(usual.least, usual.unit), shown(usual.most, usual.unit));
        self.report(
            Diagnostic::new(
                Code::UNUSUAL,
                tree.span,
                format!(
                    "this density gives a mass of {}, which is unusual for robots",
                    shown(mass, usual.unit)
                ),
            )
            .label(format!("usual: {range}, between {}", usual.ends))
            .help(format!("check the units of the sizes of the shape. {}", allowed())),
        );
    }

    /// Warns of a joint that follows its drive within `lag` s, damping over stiffness: late, or without any damping.
    pub(super) fn odd_lag(&mut self, lag: f64, tree: &ast::Expr) {
        let (message, label) = match lag {
            0.0 => (
                "without damping, a joint oscillates for ever about the position that is asked for"
                    .to_owned(),
                "real material loses energy in each oscillation".to_owned(),
            ),
            lag if lag > LONGEST_LAG => (
                format!("with this damping a joint needs {} to follow its drive", shown(lag, "s")),
                format!("usual: up to {LONGEST_LAG} s (damping divided by stiffness)"),
            ),
            _ => return,
        };
        self.report(
            Diagnostic::new(Code::UNUSUAL, tree.span, message)
                .label(label)
                .help(format!("check the units of `damping` and `stiffness`. {}", allowed())),
        );
    }

    /// Warns of a filling that is softer than any gel. A lattice of springs to the nearest and to the diagonal neighbours has a modulus of three times
    /// the stiffness by the spacing.
    pub(super) fn soft_filling(&mut self, filling: &Filling, tree: &ast::Expr) {
        let modulus = 3.0 * filling.stiffness / filling.spacing;
        if modulus < SOFTEST {
            self.report(
                Diagnostic::new(Code::UNUSUAL, tree.span, "this filling is softer than any gel")
                    .label(format!(
                        "springs of {} with a spacing of {} make a material of {}",
                        units::shown(filling.stiffness, Dimension::STIFFNESS),
                        units::shown(filling.spacing, Dimension::LENGTH),
                        units::shown(modulus, Dimension::PRESSURE)
                    ))
                    .help(format!(
                        "a spring has a third of the modulus of the material times the spacing: 2 kN/m for 1 MPa and 6 mm. {}",
                        allowed()
                    )),
            );
        }
    }

    /// Warns of a body that is mirrored up and down, though only one half of it can stand on the ground.
    pub(super) fn upside_down(&mut self, plane: &ast::Name) {
        self.report(
            Diagnostic::new(Code::UNUSUAL, plane.span, "this symmetry mirrors top and bottom")
                .label("parallel to the ground: rarely meant")
                .help("write `mirror xy` to mirror left and right, or `mirror yz` to mirror front and back"),
        );
    }

    /// Warns of a port that lies well outside of its part.
    pub(super) fn stray_port(&mut self, name: &str, place: Span, distance: f64, reach: f64) {
        self.report(
            Diagnostic::new(Code::STRAY_PORT, place, format!("the port `{name}` lies off its part"))
                .label(format!(
                    "{} from the middle; in this direction the part reaches {}",
                    length(distance),
                    length(reach)
                ))
                .help("a port must lie on the surface, or up to 5 % of the part's length and 1 mm off it: a part attached here would float in the air"),
        );
    }

    /// Warns of a port whose name says another side than the one that it faces.
    pub(super) fn misnamed_port(&mut self, name: &str, place: Span, facing: &[f64; 3]) {
        const SIDES: [(&str, usize, f64); 6] = [
            ("front", 0, 1.0),
            ("back", 0, -1.0),
            ("top", 1, 1.0),
            ("bottom", 1, -1.0),
            ("right", 2, 1.0),
            ("left", 2, -1.0),
        ];
        let own = name.split('[').next().unwrap_or(name);
        let along = |(_, axis, sign): &(&str, usize, f64)| facing[*axis] * sign;
        let named = SIDES.iter().find(|(side, ..)| *side == own);
        let faces = SIDES.iter().find(|side| along(side) > 0.9);
        let Some((_, (side, ..))) = named.filter(|side| along(side) < -0.9).zip(faces) else { return };
        self.report(
            Diagnostic::new(Code::UNUSUAL, place, format!("the port `{name}` faces to the {side}"))
                .label("the opposite side")
                .help("x points to the front, y to the top and z to the right of a part"),
        );
    }

    /// Warns of a port that lies deep within its part.
    pub(super) fn buried_port(
        &mut self,
        name: &str,
        place: Span,
        (depth, behind): (f64, f64),
        facing: &[f64; 3],
    ) {
        if behind < 1e-3 {
            let [x, y, z] = facing.map(|x| units::shown(0.0 - x, Dimension::NUMBER));
            self.report(
                Diagnostic::new(Code::STRAY_PORT, place, format!("the port `{name}` faces into its part"))
                    .label(format!("a part attached here reaches {} into this one", length(depth)))
                    .help(format!("a port faces outwards: write `facing vector({x}, {y}, {z})`")),
            );
            return;
        }
        self.report(
            Diagnostic::new(Code::STRAY_PORT, place, format!("the port `{name}` lies inside its part"))
                .label(format!("a part attached here reaches {} into this one", length(depth)))
                .help("a port must lie on the surface: solid parts cannot be in one place. For an axle that goes through, write `allow W0727 because \"...\"`"),
        );
    }

    /// Warns of a joint whose axis is far from its part.
    pub(super) fn stray_pivot(&mut self, place: Span, pivot: [f64; 3], reach: f64) {
        let [x, y, z] = pivot;
        let distance = (x * x + y * y + z * z).sqrt();
        self.report(
            Diagnostic::new(Code::STRAY_PORT, place, "the pivot of the part is far from it")
                .label(format!("{} from the middle; the part reaches {}", length(distance), length(reach)))
                .help("`pivot` is in the frame of the part: `vector(0 mm, 0 mm, 0 mm)` is its middle"),
        );
    }
}

/// A length, rounded to hundredths of a millimetre.
fn length(x: f64) -> String {
    units::shown((x * 1e5).round() / 1e5, Dimension::LENGTH)
}

/// The usual values of a field of what is called so. A passive row has those of a driven one, and what all rows have is said
/// of those that bend.
fn usual_of(of: &str, field: &str) -> Option<&'static Usual> {
    let known = |of: &str| USUAL.iter().find(|usual| (usual.of, usual.field) == (of, field));
    let driven = of.replace("a passive row", "an actuator");
    let is_of_all = matches!(field, "density" | "mass" | "friction");
    match driven.starts_with("an actuator") && is_of_all {
        true => known("an actuator"),
        // What a socket does about each of its axes is a bend.
        false if driven == "an actuator with sockets" => known("an actuator"),
        false => known(&driven),
    }
}

/// How a warning is allowed.
fn allowed() -> String {
    format!("To keep the value, write `allow {} because \"...\"` in the declaration", Code::UNUSUAL.id)
}

/// A unit of the table: all of them can be read.
fn unit(name: &str) -> Unit {
    let number = Unit { dimension: Dimension::NUMBER, factor: 1.0 };
    if name.is_empty() { number } else { units::parse(name).unwrap_or(number) }
}

/// A number of a unit for people, to four digits.
fn shown(x: f64, unit: &str) -> String {
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    let number = if (1e-4..1e7).contains(&rounded.abs()) || rounded == 0.0 {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    };
    if unit.is_empty() { number } else { format!("{number} {unit}") }
}

/// The first unit that an expression is written in.
fn written(tree: &ast::Expr) -> Option<(&str, Unit)> {
    match &tree.kind {
        ExprKind::Quantity(_, Some(name)) => Some((&name.text, units::parse(&name.text).ok()?)),
        ExprKind::Negate(x) => written(x),
        ExprKind::Range(a, b) => written(a).or_else(|| written(b)),
        _ => None,
    }
}

/// The same number with another prefix, if that would be usual: `16 g` for `16 kg`.
fn slip(tree: &ast::Expr, dimension: Dimension, (least, most): (f64, f64)) -> Option<String> {
    let ExprKind::Quantity(number, Some(name)) = &tree.kind else { return None };
    const LIKELY: &[&str] = &[
        "mm", "cm", "m", "g", "kg", "ms", "s", "g/cm^3", "kg/m^3", "m/s^2", "cm/s", "m/s", "deg", "rad",
        "bar", "kPa",
    ];
    let mut likely = LIKELY.iter().filter(|unit| **unit != name.text);
    let meant = likely.find(|name| {
        let unit = unit(name);
        unit.dimension == dimension && (least..=most).contains(&(number * unit.factor))
    })?;
    Some(format!("{number} {meant}"))
}

#[cfg(test)]
mod tests {
    use super::{USUAL, shown, unit};

    #[test]
    fn every_row_has_a_unit_and_two_ends() {
        for usual in USUAL {
            assert!(usual.unit.is_empty() || crate::units::parse(usual.unit).is_ok(), "{}", usual.unit);
            assert!(usual.least < usual.most, "{} of {}", usual.field, usual.of);
            assert!(unit(usual.unit).factor > 0.0);
        }
        let fields: std::collections::BTreeSet<_> = USUAL.iter().map(|u| (u.of, u.field)).collect();
        assert_eq!(fields.len(), USUAL.len(), "a field is there twice");
    }

    #[test]
    fn numbers_have_four_digits() {
        let told = [932.066, 0.0, 0.000_012_34, 9.81, 1.0 / 3.0, 2e9].map(|x| shown(x, "g/cm^3"));
        assert_eq!(
            told,
            ["932.1 g/cm^3", "0 g/cm^3", "1.234e-5 g/cm^3", "9.81 g/cm^3", "0.3333 g/cm^3", "2e9 g/cm^3"]
        );
    }
}
