//! The joints of an actuator's row: what a text says of them, and which fields belong to them.

use super::Declarations;
use crate::diagnostics::{Code, Diagnostic, Fix, did_you_mean, respell};
use crate::eval::{Value, unit};
use crate::ir::{self, JointKind, NAMED_AXES, Ty};
use crate::syntax::ast::{self, Block, Name};
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

/// What a joint can be.
const JOINTS: &str = "a joint is `bend about z`, `twist`, `slide along x` or `spin about x`, with `passive` if nothing drives it";

/// An axis of a bend has at least this share across the row, of what it has along it.
const ACROSS: f64 = 1e-3;

/// The joints of a row, as its field says.
#[derive(Clone, Copy)]
pub(super) struct Row {
    pub(super) joint: ir::Joint,
    /// Whether nothing drives them.
    pub(super) passive: bool,
}

/// The fields of every row.
const COMMON: [&str; 5] = ["segment", "density", "mass", "friction", "joint"];

/// The fields of a row with such joints, as they are listed to people.
pub(super) fn fields(row: Row) -> Vec<&'static str> {
    let kind = row.joint.kind;
    let mut fields = COMMON.to_vec();
    let turns_on = kind == JointKind::Spin;
    if !turns_on {
        fields.push(kind.range());
    }
    if !row.passive {
        fields.push(kind.speed_field());
        if !turns_on {
            fields.push("relaxing_speed");
        }
        fields.push(kind.effort_field());
    }
    if !turns_on {
        fields.push("stiffness");
    }
    fields.push("damping");
    if row.passive && !turns_on {
        fields.push("neutral");
    }
    fields.push("colour");
    fields
}

/// What a row is called in messages.
pub(super) fn called(row: Row) -> &'static str {
    match (row.joint.kind, row.passive) {
        (JointKind::Bend, false) => "an actuator",
        (JointKind::Twist, false) => "an actuator that twists",
        (JointKind::Slide, false) => "an actuator that slides",
        (JointKind::Spin, false) => "an actuator that spins",
        (JointKind::Bend, true) => "a passive actuator",
        (JointKind::Twist, true) => "a passive actuator that twists",
        (JointKind::Slide, true) => "a passive actuator that slides",
        (JointKind::Spin, true) => "a passive actuator that spins",
    }
}

/// Examples of what is written for a joint.
pub(super) struct Examples {
    pub(super) range: &'static str,
    pub(super) speed: &'static str,
    pub(super) effort: &'static str,
    pub(super) stiffness: &'static str,
    pub(super) damping: &'static str,
}

pub(super) fn examples(kind: JointKind) -> Examples {
    match kind {
        JointKind::Slide => Examples {
            range: "0 mm .. 20 mm",
            speed: "20 mm/s",
            effort: "5 N",
            stiffness: "500 N/m",
            damping: "10 N*s/m",
        },
        JointKind::Bend | JointKind::Twist | JointKind::Spin => Examples {
            range: "-90 deg .. 90 deg",
            speed: "180 deg/s",
            effort: "0.06 N*m/rad",
            stiffness: "0.3 N*m/rad^2",
            damping: "0.01 N*m*s/rad^2",
        },
    }
}

impl Declarations<'_> {
    /// The joint of a row.
    pub(super) fn joint(&mut self, block: &Block, damaged: bool) -> Option<Row> {
        let mut joints = block.fields.iter().filter_map(|field| match field {
            ast::Field::Joint(joint) => Some((ast::Joint::named(joint), Some(&**joint), None)),
            ast::Field::Value(name, value) if name.text == "joint" => Some((name.clone(), None, Some(value))),
            _ => None,
        });
        let Some((word, joint, value)) = joints.next() else {
            return Some(Row { joint: ir::Joint::BEND, passive: false });
        };
        if let Some((again, ..)) = joints.next() {
            self.report(
                Diagnostic::new(Code::DUPLICATE, again.span, "`joint` is given twice")
                    .label("again")
                    .also(word.span, "first given here")
                    .help("keep one of them: all joints of a row are alike"),
            );
        }
        match (joint, value.map(|value| (&value.kind, value.span))) {
            (Some(joint), _) => self.written_joint(joint, damaged),
            (None, Some((ast::ExprKind::Name(text), span))) => {
                let kind = Name { text: text.clone(), span };
                self.written_joint(&ast::Joint { word: word.span, kind, axis: None, passive: None }, damaged)
            }
            (None, place) => {
                let span = place.map_or(word.span, |(_, span)| span);
                self.report(
                    Diagnostic::new(Code::WRONG_TYPE, span, "this is no joint")
                        .label("not the name of a joint")
                        .help(JOINTS),
                );
                None
            }
        }
    }

    fn written_joint(&mut self, joint: &ast::Joint, damaged: bool) -> Option<Row> {
        let name = &joint.kind;
        let Some(kind) = JointKind::named(&name.text) else {
            let names = || JointKind::ALL.into_iter().map(JointKind::text);
            self.report(
                Diagnostic::new(Code::UNKNOWN_NAME, name.span, format!("there is no joint `{}`", name.text))
                    .label("not known")
                    .help(meant_joint(&name.text).map_or_else(
                        || did_you_mean(&name.text, names()).unwrap_or_else(|| JOINTS.to_owned()),
                        |meant| format!("write `joint = {meant}`"),
                    ))
                    .fix_if(respell(name.span, &name.text, names())),
            );
            return None;
        };
        let axis = match &joint.axis {
            None => kind.usual_axis(),
            Some((word, axis)) => self.joint_axis(kind, word, axis, damaged)?,
        };
        Some(Row { joint: ir::Joint { kind, axis }, passive: joint.passive.is_some() })
    }

    /// The axis of a joint: `x`, `y`, `z`, or a vector.
    fn joint_axis(
        &mut self,
        kind: JointKind,
        word: &Name,
        tree: &ast::Expr,
        damaged: bool,
    ) -> Option<[f64; 3]> {
        let Some(wanted) = kind.axis_word() else {
            self.report(
                Diagnostic::new(Code::UNKNOWN_FIELD, word.span, "a twist is always about the row itself")
                    .label("it has no other axis")
                    .help("write `joint = twist`, or `joint = bend about y` for another axis"),
            );
            return None;
        };
        if word.text != wanted {
            self.report(
                Diagnostic::new(
                    Code::UNKNOWN_FIELD,
                    word.span,
                    format!("a row {} {wanted} an axis", kind.does()),
                )
                .label(format!("not `{}`", word.text))
                .help(format!("write `joint = {} {wanted} ...`", kind.text()))
                .fix(Fix::replace(word.span, wanted.to_owned(), format!("write `{wanted}`"))),
            );
            return None;
        }
        let (negative, inner) = match &tree.kind {
            ast::ExprKind::Negate(inner) => (true, &**inner),
            _ => (false, tree),
        };
        let named = match &inner.kind {
            ast::ExprKind::Name(name) => NAMED_AXES.iter().find(|(axis, _)| axis == name),
            _ => None,
        };
        let axis = match named {
            Some((_, axis)) => axis.map(|x| if negative { 0.0 - x } else { x }),
            None => {
                let mut cx = Context::new(Stage::Declaration, damaged);
                let ty = Ty::Vector(Dimension::NUMBER);
                let before = self.expressions.errors.len();
                let value = self.expressions.expect(tree, &mut cx, &ty, "an axis");
                for mut error in self.expressions.errors.split_off(before) {
                    error.help = Some("write `x`, `y` or `z`, or for example `vector(0, 1, 1)`".to_owned());
                    error.fix = None;
                    self.expressions.errors.add(error);
                }
                let Value::Vector(vector) = self.expressions.constant(&value)? else { return None };
                let Some(axis) = unit(vector) else {
                    self.report(
                        Diagnostic::new(Code::OUT_OF_DOMAIN, tree.span, "an axis needs a direction")
                            .label("this vector has no length")
                            .help("write for example `about vector(0, 1, 1)`"),
                    );
                    return None;
                };
                axis
            }
        };
        let [along, across, aside] = axis;
        if kind == JointKind::Bend && (across * across + aside * aside).sqrt() < ACROSS * along.abs() {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, tree.span, "a row bends about an axis across it")
                    .label("this axis lies along the row")
                    .help("a turn about the row is `joint = twist`"),
            );
            return None;
        }
        Some(axis)
    }
}

/// Whether a row says what its joints are. Without a number of segments it then has two, and one joint.
pub(super) fn says_joint(block: &Block) -> bool {
    block.fields.iter().any(|field| match field {
        ast::Field::Joint(_) => true,
        ast::Field::Value(name, _) => name.text == "joint",
        ast::Field::Group(_) | ast::Field::Param(_) | ast::Field::Port(_) => false,
    })
}

/// The joint that a word of other programs means.
fn meant_joint(word: &str) -> Option<&'static str> {
    Some(match word {
        "hinge" | "revolute" | "pin" => "bend about z",
        "prismatic" | "linear" | "telescope" | "extend" | "slider" => "slide along x",
        "continuous" | "wheel" | "motor" | "rotate" | "axle" => "spin about x",
        "torsion" | "roll" => "twist",
        "passive" | "spring" | "elastic" => "bend about z passive",
        _ => return None,
    })
}

/// What is said of a field that other rows have.
pub(super) fn belongs_elsewhere(field: &str, row: Row) -> Option<String> {
    let Row { joint, .. } = row;
    let kind = joint.kind;
    let spin = kind == JointKind::Spin;
    Some(match field {
        "bend" | "range" if spin => "a spin goes on and on: it has no end".to_owned(),
        "neutral" if !row.passive => {
            format!(
                "it goes where its drive says; only a passive row has `neutral`: `joint = {joint} passive`"
            )
        }
        "stiffness" | "relaxing_speed" | "neutral" if spin => {
            "a spin is driven by its speed: `damping` says how hard it holds that".to_owned()
        }
        "torque" | "effort" | "bending_speed" | "speed" | "relaxing_speed" if row.passive => {
            "nothing drives a passive row: `stiffness` and `damping` are all that it has".to_owned()
        }
        "bend" | "range" => format!("how far it {} is `{}`", kind.does(), kind.range()),
        "bending_speed" | "speed" => format!("how fast it {} is `{}`", kind.does(), kind.speed_field()),
        "torque" | "effort" => format!("its strength is `{}`", kind.effort_field()),
        _ => return None,
    })
}

/// What a field of other rows is called in a row with such joints.
pub(super) fn called_here(field: &str, kind: JointKind) -> Option<&'static str> {
    match field {
        "bend" | "range" => Some(kind.range()),
        "bending_speed" | "speed" => Some(kind.speed_field()),
        "torque" | "effort" => Some(kind.effort_field()),
        _ => None,
    }
}
