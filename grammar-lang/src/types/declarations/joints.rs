//! Joints, of an actuator's row and of a part: what a text says of them, and which fields belong to them.

use super::Declarations;
use super::fields::{Sign, Values, reads_params};
use crate::diagnostics::{Code, Diagnostic, Fix, did_you_mean, respell};
use crate::eval::{SOCKET, Value, is_across, unit};
use crate::ir::{self, Field, JointKind, NAMED_AXES, Ty};
use crate::source::Span;
use crate::syntax::ast::{self, Block, Name};
use crate::types::expressions::context::Context;
use crate::units::Dimension;

/// What a joint can be.
const JOINTS: &str = "a joint is `bend about z`, `twist`, `slide along x` or `spin about x`, with `passive` if nothing drives it, \
                      or `socket passive`";

/// The joints of a row, or of a part, as the field says.
#[derive(Clone, Copy)]
pub(super) struct Row<'b> {
    pub(super) kind: JointKind,
    /// Whether nothing drives them.
    pub(super) passive: bool,
    /// The word before the axis, and the axis, where they are written.
    axis: Option<(&'b Name, &'b ast::Expr)>,
    /// Whose they are.
    pub(super) of: Owner,
}

/// What has joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    /// A row of segments: so many joints at least.
    Row,
    /// A part: one joint, with what holds it.
    Part,
}

/// The fields that the joint of a part can have.
pub(super) const OF_JOINTS: [&str; 7] =
    ["bend", "range", "stiffness", "damping", "neutral", "begins", "pivot"];

/// The fields of every row.
const COMMON: [&str; 5] = ["segment", "density", "mass", "friction", "joint"];

/// The fields of a row with such joints, as they are listed to people.
pub(super) fn fields(row: Row<'_>) -> Vec<&'static str> {
    let mut fields = COMMON.to_vec();
    fields.extend(own_fields(row));
    fields.push("colour");
    fields
}

/// The fields of the joints themselves.
pub(super) fn own_fields(row: Row<'_>) -> Vec<&'static str> {
    let kind = row.kind;
    let mut fields = Vec::new();
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
    if kind == JointKind::Bend && row.of == Owner::Row {
        fields.extend(["sideways", "torsion"]);
    }
    fields.push("damping");
    if !turns_on && kind != JointKind::Socket {
        fields.push("neutral");
        if row.passive {
            fields.push("begins");
        }
    }
    if row.of == Owner::Part && kind != JointKind::Slide {
        fields.push("pivot");
    }
    fields
}

/// What a row is called in messages.
pub(super) fn called(row: Row<'_>) -> &'static str {
    match (row.kind, row.passive) {
        (JointKind::Bend, false) => "an actuator",
        (JointKind::Twist, false) => "an actuator that twists",
        (JointKind::Slide, false) => "an actuator that slides",
        (JointKind::Spin, false) => "an actuator that spins",
        (JointKind::Bend, true) => "a passive row",
        (JointKind::Twist, true) => "a passive row that twists",
        (JointKind::Slide, true) => "a passive row that slides",
        (JointKind::Spin, true) => "a passive row that spins",
        (JointKind::Socket, _) => "a passive row with sockets",
    }
}

/// Examples of what is written for a joint.
pub(super) struct Examples {
    pub(super) range: &'static str,
    pub(super) neutral: &'static str,
    pub(super) begins: &'static str,
    pub(super) speed: &'static str,
    pub(super) effort: &'static str,
    pub(super) stiffness: &'static str,
    pub(super) damping: &'static str,
}

pub(super) fn examples(kind: JointKind) -> Examples {
    match kind {
        JointKind::Slide => Examples {
            range: "0 mm .. 20 mm",
            neutral: "10 mm",
            begins: "0 mm",
            speed: "20 mm/s",
            effort: "5 N",
            stiffness: "500 N/m",
            damping: "10 N*s/m",
        },
        JointKind::Socket => Examples {
            range: "-40 deg .. 40 deg",
            neutral: "20 deg",
            begins: "0 deg",
            speed: "180 deg/s",
            effort: "0.06 N*m/rad",
            stiffness: "0.02 N*m/rad^2",
            damping: "0.0005 N*m*s/rad^2",
        },
        JointKind::Bend | JointKind::Twist | JointKind::Spin => Examples {
            range: "-90 deg .. 90 deg",
            neutral: "20 deg",
            begins: "0 deg",
            speed: "180 deg/s",
            effort: "0.06 N*m/rad",
            stiffness: "0.3 N*m/rad^2",
            damping: "0.01 N*m*s/rad^2",
        },
    }
}

impl Declarations<'_> {
    /// What a row or a part says of its joints: of a row, that it bends, if it says nothing.
    pub(super) fn joint<'b>(&mut self, block: &'b Block, of: Owner) -> Option<Row<'b>> {
        let mut joints = block.fields.iter().filter_map(|field| match field {
            ast::Field::Joint(joint) => Some((ast::Joint::named(joint), Some(&**joint), None)),
            // One that is misspelt is told as an unknown field: what follows from it should not be told, too.
            ast::Field::Value(name, value) if name.text == "joint" || is_misspelt(name) => {
                Some((name.clone(), None, Some(value)))
            }
            _ => None,
        });
        let Some((word, joint, value)) = joints.next() else {
            return Some(Row { kind: JointKind::Bend, passive: false, axis: None, of });
        };
        if let Some((again, ..)) = joints.next() {
            self.report(
                Diagnostic::new(Code::DUPLICATE, again.span, "`joint` is given twice")
                    .label("again")
                    .also(word.span, "first given here")
                    .help(match of {
                        Owner::Row => "keep one of them: all joints of a row are alike",
                        Owner::Part => "keep one of them: `socket passive` turns about all axes",
                    }),
            );
        }
        match (joint, value.map(|value| (&value.kind, value.span))) {
            (Some(joint), _) => {
                let axis = joint.axis.as_ref().map(|(word, axis)| (word, axis));
                let kind = self.joint_kind(&joint.kind, of)?;
                self.written_joint(Row { kind, passive: joint.passive.is_some(), axis, of }, &joint.kind)
            }
            (None, Some((ast::ExprKind::Name(text), span))) => {
                let name = Name { text: text.clone(), span };
                let kind = self.joint_kind(&name, of)?;
                self.written_joint(Row { kind, passive: false, axis: None, of }, &name)
            }
            (None, place) => {
                let span = place.map_or(word.span, |(_, span)| span);
                self.report(
                    Diagnostic::new(Code::WRONG_TYPE, span, "this is not a joint")
                        .label("not the name of a joint")
                        .help(JOINTS),
                );
                None
            }
        }
    }

    fn joint_kind(&mut self, name: &Name, of: Owner) -> Option<JointKind> {
        let Some(kind) = JointKind::named(&name.text) else {
            let names = || JointKind::ALL.into_iter().map(JointKind::text);
            self.report(
                Diagnostic::new(Code::UNKNOWN_NAME, name.span, format!("there is no joint `{}`", name.text))
                    .label("not known")
                    .help(
                        meant_joint(&name.text)
                            .map(|meant| self.about_its_axis(meant, name.span))
                            .map_or_else(
                                || did_you_mean(&name.text, names()).unwrap_or_else(|| JOINTS.to_owned()),
                                |meant| match of {
                                    Owner::Part if !meant.contains("passive") => {
                                        format!("write `joint = {meant} passive`")
                                    }
                                    _ => format!("write `joint = {meant}`"),
                                },
                            ),
                    )
                    .fix_if(respell(name.span, &name.text, names())),
            );
            return None;
        };
        Some(kind)
    }

    /// A joint with the axis that follows its name in the text, as in `revolute about y`.
    fn about_its_axis(&self, joint: &str, name: Span) -> String {
        let text =
            self.environment.sources.get(name.file).and_then(|source| source.text.get(name.end as usize..));
        let after = text.and_then(|text| text.lines().next()).unwrap_or("").trim();
        let axis = after.strip_prefix("about ").or(after.strip_prefix("along ")).map(str::trim);
        match (joint.split_once(' '), axis) {
            (Some((kind, rest)), Some(axis)) if ["x", "y", "z"].contains(&axis) => {
                let way = rest.split(' ').next().unwrap_or("about");
                format!("{kind} {way} {axis}")
            }
            _ => joint.to_owned(),
        }
    }

    /// Joints that fit what has them.
    fn written_joint<'b>(&mut self, row: Row<'b>, name: &Name) -> Option<Row<'b>> {
        let Row { kind, passive, of, axis } = row;
        if of == Owner::Part && kind == JointKind::Twist {
            self.report(
                Diagnostic::new(
                    Code::UNKNOWN_FIELD,
                    name.span,
                    "a part cannot twist: only a row of segments can",
                )
                .label("a part has no row to twist about")
                .help("name the axis in the frame of the part: `joint = bend about x passive`"),
            );
            return None;
        }
        if !passive && (of == Owner::Part || kind == JointKind::Socket) {
            let (message, help) = match of {
                Owner::Part => {
                    ("nothing can drive the joint of a part", "only an `actuator` can be driven; for a part")
                }
                Owner::Row => {
                    ("nothing can drive a socket", "a row that bends or twists can be driven; of a socket")
                }
            };
            let written = axis.map_or(name.span, |(_, axis)| name.span.join(axis.span));
            let text = self.environment.sources.slice(written);
            self.report(
                Diagnostic::new(Code::MISSING_FIELD, name.span, message)
                    .label("`passive` is missing")
                    .help(format!("{help}, write `joint = {text} passive`"))
                    .fix(Fix::insert_after(written, " passive", "write `passive`")),
            );
            return None;
        }
        Some(row)
    }

    /// The axis of a joint: `x`, `y`, `z`, or a vector, which may read parameters.
    pub(super) fn joint_axis(&mut self, row: Row<'_>, cx: &Context) -> Option<Field<[f64; 3]>> {
        let kind = row.kind;
        let Some((word, tree)) = row.axis else { return Some(Field::Fixed(kind.usual_axis())) };
        let Some(wanted) = kind.axis_word() else {
            let (message, help) = match kind {
                JointKind::Socket => (
                    "a socket cannot have an axis: it turns about every axis",
                    "write `joint = socket passive`, or `joint = bend about y passive` for one axis",
                ),
                _ => (
                    "a twist cannot have an axis: it is always about the row itself",
                    "write `joint = twist`, or `joint = bend about y` for another axis",
                ),
            };
            self.report(
                Diagnostic::new(Code::UNKNOWN_FIELD, word.span, message)
                    .label("not possible here")
                    .help(help),
            );
            return None;
        };
        if word.text != wanted {
            self.report(
                Diagnostic::new(
                    Code::UNKNOWN_FIELD,
                    word.span,
                    match row.of {
                        Owner::Row => format!("a row {} {wanted} an axis", kind.does()),
                        Owner::Part => format!("a part {} {wanted} an axis", kind.does()),
                    },
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
                let mut own = cx.clone();
                let ty = Ty::Vector(Dimension::NUMBER);
                let before = self.expressions.errors.len();
                let value = self.expressions.expect(tree, &mut own, &ty, "an axis");
                for mut error in self.expressions.errors.split_off(before) {
                    // A parameter that is misspelt is told as such.
                    let is_param = error.fix.as_ref().is_some_and(|fix| {
                        cx.locals
                            .iter()
                            .any(|param| fix.edits.iter().any(|edit| edit.replacement == param.name))
                    });
                    if is_param {
                        self.expressions.errors.add(error);
                        continue;
                    }
                    error.help = Some("write `x`, `y` or `z`, or for example `vector(0, 1, 1)`".to_owned());
                    error.fix = None;
                    self.expressions.errors.add(error);
                }
                if value.any(&mut |e| e.ty == Ty::Unknown) {
                    return None;
                }
                if reads_params(&value, cx.locals.len()) {
                    self.hiding(&value, cx);
                    return Some(Field::Varies(value));
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
        if row.of == Owner::Row && kind == JointKind::Bend && !is_across(axis) {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    "a row can bend only about an axis across it",
                )
                .label("this axis lies along the row")
                .help("to turn about the row, write `joint = twist`"),
            );
            return None;
        }
        Some(Field::Fixed(axis))
    }

    /// Everything that a text says of joints, but for what drives them. `cx` is where fields read parameters.
    pub(super) fn joint_of(
        &mut self,
        from: &Values<'_>,
        (row, axis): (Row<'_>, Field<[f64; 3]>),
        joints: f64,
        cx: &Context,
    ) -> Option<ir::Joint> {
        let kind = row.kind;
        let range = if kind == JointKind::Spin { Some(None) } else { self.range(from, row, cx).map(Some) };
        if let (JointKind::Socket, Some(Some(Field::Fixed(ends)))) = (kind, &range) {
            self.socket_range(from, *ends, joints);
        }
        let ty = Ty::Quantity(kind.position());
        let neutral = match from.values.contains_key("neutral") {
            true => self.varying(from, "neutral", (&ty, examples(kind).neutral), cx, |_, x, _| x.as_number()),
            false => Some(Field::Fixed(0.0)),
        };
        if let (Some(Field::Fixed(neutral)), Some(Some(Field::Fixed((low, high))))) = (&neutral, &range)
            && !row.passive
            && (neutral < low || neutral > high)
            && let Some((_, tree)) = from.values.get("neutral")
        {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    "the `neutral` of a driven joint must lie within its range",
                )
                .label(format!("outside `{}`", kind.range()))
                .help("only a passive joint can have its `neutral` outside its range: its spring then presses the joint against an end"),
            );
        }
        let begins = match from.values.contains_key("begins") {
            true => self
                .varying(from, "begins", (&ty, examples(kind).begins), cx, |_, x, _| x.as_number())
                .map(Some),
            false => Some(None),
        };
        if let (Some(Some(Field::Fixed(begins))), Some(Some(Field::Fixed((low, high))))) = (&begins, &range)
            && !(low..=high).contains(&begins)
            && let Some((_, tree)) = from.values.get("begins")
        {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, tree.span, "a joint must begin within its range")
                    .label(format!("outside `{}`", kind.range()))
                    .help("choose a value inside the range, or widen the range"),
            );
        }
        let pivot = match from.values.contains_key("pivot") {
            true => {
                let place = (&Ty::Vector(Dimension::LENGTH), "vector(0 mm, 0 mm, 0 mm)");
                let read = |_: &mut Self, value, _| match value {
                    Value::Vector(vector) => Some(vector),
                    _ => None,
                };
                self.varying(from, "pivot", place, cx, read).map(Some)
            }
            false => Some(None),
        };
        let examples = examples(kind);
        let stiffness = if kind == JointKind::Spin {
            Some(Field::Fixed(0.0))
        } else {
            // What swings freely has no spring.
            let sign = if row.passive { Sign::NotNegative } else { Sign::Positive };
            self.varying_number(from, "stiffness", kind.stiffness(), (sign, examples.stiffness), cx)
        };
        // Damping is all that makes a driven spin turn.
        let sign = if kind == JointKind::Spin && !row.passive { Sign::Positive } else { Sign::NotNegative };
        let damping = self.varying_number(from, "damping", kind.damping(), (sign, examples.damping), cx);
        let mut across = |name: &str| match from.values.contains_key(name) {
            true => {
                let sign = (Sign::Positive, examples.stiffness);
                self.varying_number(from, name, kind.stiffness(), sign, cx).map(Some)
            }
            false => Some(None),
        };
        let (sideways, torsion) = (across("sideways"), across("torsion"));
        Some(ir::Joint {
            kind,
            axis,
            range: range?,
            stiffness: stiffness?,
            damping: damping?,
            sideways: sideways?,
            torsion: torsion?,
            neutral: neutral?,
            begins: begins?,
            pivot: pivot?,
        })
    }

    /// A socket must not come to where two of its axes are one.
    fn socket_range(&mut self, from: &Values<'_>, (low, high): (f64, f64), joints: f64) {
        let Some((_, tree)) = from.values.get("range") else { return };
        if high.max(-low) <= SOCKET * joints * (1.0 + 1e-9) {
            return;
        }
        let most = (SOCKET * joints).to_degrees().round();
        self.report(
            Diagnostic::new(
                Code::OUT_OF_DOMAIN,
                tree.span,
                "a socket can turn by at most 80 deg about each axis",
            )
            .label(if joints > 1.0 {
                format!("that is {most} deg for the {joints} joints of the shortest row")
            } else {
                "goes beyond this range".to_owned()
            })
            .help("narrow the range, for example to `-60 deg .. 60 deg`"),
        );
    }
}

/// Whether a row says what its joints are. Without a number of segments it then has two, and one joint.
pub(super) fn says_joint(block: &Block) -> bool {
    block.fields.iter().any(|field| match field {
        ast::Field::Joint(_) => true,
        ast::Field::Value(name, _) => name.text == "joint" || is_misspelt(name),
        ast::Field::Group(_) | ast::Field::Param(_) | ast::Field::Port(_) => false,
    })
}

/// Whether a field is `joint`, but for a slip.
fn is_misspelt(name: &Name) -> bool {
    respell(name.span, &name.text, ["joint"]).is_some()
}

/// The joint that a word of other programs means.
fn meant_joint(word: &str) -> Option<&'static str> {
    Some(match word {
        "hinge" | "revolute" | "pin" => "bend about z",
        "prismatic" | "linear" | "telescope" | "extend" | "slider" => "slide along x",
        "continuous" | "wheel" | "motor" | "rotate" | "axle" => "spin about x",
        "torsion" | "roll" => "twist",
        "ball" | "spherical" | "ball_joint" | "universal" => "socket passive",
        "passive" | "spring" | "elastic" => "bend about z passive",
        _ => return None,
    })
}

/// What is said of a field that other rows have.
pub(super) fn belongs_elsewhere(field: &str, row: Row<'_>) -> Option<String> {
    let kind = row.kind;
    let spin = kind == JointKind::Spin;
    Some(match field {
        "bend" | "range" if spin => "remove this: a spin has no limits".to_owned(),
        "pivot" if row.of == Owner::Row => {
            "the joints of a row are in the middle between its segments: only a part with a joint can have a `pivot`".to_owned()
        }
        "pivot" => "remove `pivot`: a joint that slides has a direction, but no pivot".to_owned(),
        "neutral" | "begins" if kind == JointKind::Socket => {
            "a socket rests, and begins, where its part is attached: tilt the port (`facing`), or turn the part".to_owned()
        }
        "begins" if !row.passive => {
            "remove `begins`: a driven joint begins at its `neutral`; only a passive joint can begin elsewhere".to_owned()
        }
        "stiffness" | "relaxing_speed" | "neutral" | "begins" if spin => match row.passive {
            true => "remove this: a free axle has no spring, and only `damping` slows it".to_owned(),
            false => "remove this: a spin is driven by its speed, and `damping` determines how firmly it holds this speed".to_owned(),
        },
        "torque" | "effort" | "bending_speed" | "speed" | "relaxing_speed" if row.passive => {
            let what = if row.of == Owner::Part { "the joint of a part" } else { "a passive row" };
            format!(
                "nothing drives {what}: its fields are {}",
                own_fields(row).iter().map(|field| format!("`{field}`")).collect::<Vec<_>>().join(", ")
            )
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
