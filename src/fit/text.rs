//! What is written of fitted actuators: the variant, and a summary for the terminal.

use std::f64::consts::PI;
use std::fmt::Write;

use grammar_lang::units::{self, Dimension};

use super::Constructed;
use crate::calibrate::variant::{comment, laid_out};
use crate::solid::{Fitted, Law, UnderLoad};

/// Damping is fitted at so many cycles per second.
const CYCLES: f64 = 1.0;
/// Digits that are written.
const DIGITS: i32 = 4;

/// The text of a file with a variant `name` of the grammar in the file `base`.
#[must_use]
pub fn variant(name: &str, base: &str, fitted: &[(Constructed, Fitted)]) -> String {
    let mut out = String::new();
    comment(
        &mut out,
        "##",
        "",
        "Computed by `sgc fit` from the materials and drives that the actuators name, with static finite elements. To change a number, \
         change the actuator, and fit again.",
    );
    // Writing to a String never fails.
    let _ = writeln!(out, "\nvariant {name} of \"{base}\" {{");
    for (i, (kind, fitted)) in fitted.iter().enumerate() {
        if i > 0 {
            out.push('\n');
        }
        actuator(&mut out, kind, fitted);
    }
    out.push_str("}\n");
    laid_out(out)
}

fn actuator(out: &mut String, kind: &Constructed, fitted: &Fitted) {
    let Constructed { name, .. } = kind;
    let mut say = |text: &str| comment(out, "#", "  ", text);
    say(&about(kind, fitted));
    for case in cases(kind, fitted) {
        say(&format!("{case}."));
    }
    let mut set = |field: &str, value: &str| {
        let _ = writeln!(out, "  set {name}.{field} = {value}");
    };
    match &fitted.driven {
        Some(driven) => {
            let bend = line(kind, driven.bend, 180.0 / PI, "deg");
            let low = if kind.both { format!("-({bend})") } else { "0 deg".to_owned() };
            set("bend", &format!("{low} .. {bend}"));
            let torque = blocked(kind, driven);
            set("torque", &format!("{} N*m/rad", digits(torque)));
            let bend = line(kind, driven.bend, 1.0, "rad");
            set("stiffness", &format!("{} * {} N*m/rad / ({bend})", hinges(kind), digits(torque)));
        }
        None => {
            set("stiffness", &inverse(kind, fitted.compliance));
        }
    }
    for (field, law) in [("sideways", fitted.sideways), ("torsion", fitted.twist)] {
        set(field, &inverse(kind, law));
    }
    let lag = kind.construction.material.loss / (2.0 * PI * CYCLES);
    set("damping", &format!("stiffness * {} ms", digits(1000.0 * lag)));
    set("mass", &format!("{} g", digits(1000.0 * kind.mass)));
}

/// The moment that each hinge bears where the tip is held straight, N m.
fn blocked(kind: &Constructed, driven: &UnderLoad) -> f64 {
    let middle = kind.counts.get(kind.counts.len() / 2).copied().unwrap_or(2);
    driven.blocked.at(kind.length(middle))
}

/// What was computed of which actuator.
fn about(kind: &Constructed, fitted: &Fitted) -> String {
    let material = kind.construction.material;
    let counts: Vec<String> = kind.counts.iter().map(usize::to_string).collect();
    let mut out = format!(
        "`{}`: rubber with a Young's modulus of {} and a Poisson's ratio of {}, glued to rigid blocks at both ends; computed with {} segments.",
        kind.name,
        megapascal(material.young),
        material.poisson,
        counts.join(", "),
    );
    // Two points are always on a line.
    if kind.counts.len() > 2 {
        let _ = write!(
            out,
            " Values for other numbers of segments lie on the line through the first and the last; that in the middle differs from it by up to {} %.",
            digits(libm::ceil(1000.0 * fitted.off) / 10.0)
        );
    }
    out
}

/// The load cases in words, for the longest actuator that was computed.
fn cases(kind: &Constructed, fitted: &Fitted) -> Vec<String> {
    let Some(&segments) = kind.counts.last() else { return Vec::new() };
    let length = kind.length(segments);
    let degrees = |rad: f64| format!("{} deg", digits(rad.to_degrees()));
    let mut out = Vec::new();
    let whole = format!("with {segments} segments ({})", units::shown(length, Dimension::LENGTH));
    if let (Some(driven), Some(load)) = (&fitted.driven, kind.load()) {
        let shares: Vec<String> = driven
            .curve
            .iter()
            .map(|(share, bend)| format!("{} at {} %", degrees(*bend), digits(100.0 * share)))
            .collect();
        out.push(format!("Free, {whole}, under {load}: it bends by {}", shares.join(", ")));
        out.push(format!("Held straight under the same load: {} N m", digits(driven.blocked.at(length))));
    }
    let moment = |law: Law| format!("{} rad/(N m)", digits(law.at(length)));
    out.push(format!(
        "Without a load, {whole}: a moment on the tip bends it by {}",
        moment(fitted.compliance)
    ));
    out.push(format!(
        "Sideways by {}, and it twists by {} (only soft rods give way there)",
        moment(fitted.sideways),
        moment(fitted.twist)
    ));
    out.push(format!("Damping: a loss factor of {} at {} Hz", kind.construction.material.loss, CYCLES));
    out
}

/// The stiffness of each hinge as an expression, from the compliance of the whole.
fn inverse(kind: &Constructed, compliance: Law) -> String {
    format!("{} * 1 N*m/rad^2 / ({})", hinges(kind), line(kind, compliance, 1.0, ""))
}

/// A line over the length as an expression of the number of segments, in a unit of which `scale` make one SI unit.
fn line(kind: &Constructed, law: Law, scale: f64, unit: &str) -> String {
    let number = |x: f64| format!("{} {unit}", digits(x)).trim_end().to_owned();
    if !kind.varies {
        return number(scale * law.at(kind.length(2)));
    }
    let (slope, base) = (scale * law.slope * kind.segment, scale * law.base);
    let sign = if base < 0.0 { "-" } else { "+" };
    format!("segments * {} {sign} {}", number(slope), number(base.abs()))
}

/// A Young's modulus in words.
fn megapascal(young: f64) -> String {
    format!("{} MPa", digits(1e-6 * young))
}

/// How many hinges an actuator has.
fn hinges(kind: &Constructed) -> &'static str {
    if kind.varies { "(segments - 1)" } else { "1" }
}

/// A number with as many digits as are written.
fn digits(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if !(1e-6..1e9).contains(&x.abs()) {
        return format!("{x:.3e}");
    }
    let decimals = (DIGITS - 1 - libm::floor(libm::log10(x.abs())) as i32).max(0);
    let text = format!("{:.*}", decimals as usize, x);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// What the terminal says of all of them.
#[must_use]
pub fn summary(fitted: &[(Constructed, Fitted)]) -> String {
    let mut out = String::new();
    for (kind, fitted) in fitted {
        let _ = writeln!(out, "{}", about(kind, fitted));
        for case in cases(kind, fitted) {
            let _ = writeln!(out, "  {case}");
        }
    }
    out
}
