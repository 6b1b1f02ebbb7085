//! Checks actuators, and the parameters that each of them has for itself.

use indexmap::IndexMap;

use super::Declarations;
use super::fields::{Fields, Sign, Values};
use crate::diagnostics::{Code, Diagnostic, Fix, did_you_mean, respell};
use crate::eval::{Value, unit};
use crate::ir::{self, Field, JointKind, NAMED_AXES, PartAttribute, Speed, Ty};
use crate::syntax::ast::{self, Block, Name};
use crate::types::built_in::built_in;
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

/// What a joint can be.
const JOINTS: &str = "a joint is `bend about z`, `twist`, `slide along x` or `spin about x`, with `passive` if nothing drives it";

/// An axis of a bend has at least this share across the row, of what it has along it.
const ACROSS: f64 = 1e-3;

/// The joints of a row, as its field says.
#[derive(Clone, Copy)]
struct Row {
    joint: ir::Joint,
    /// Whether nothing drives them.
    passive: bool,
}

/// How fast a row moves: away from rest, and back.
type Speeds = (Speed, Speed);

/// The fields of every row.
const COMMON: [&str; 5] = ["segment", "density", "mass", "friction", "joint"];

/// The fields of a row with such joints, as they are listed to people.
fn fields(row: Row) -> Vec<&'static str> {
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
fn called(row: Row) -> &'static str {
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
struct Examples {
    range: &'static str,
    speed: &'static str,
    effort: &'static str,
    stiffness: &'static str,
    damping: &'static str,
}

fn examples(kind: JointKind) -> Examples {
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
    pub(in crate::types) fn actuator(&mut self, block: &Block, damaged: bool) -> Option<ir::Actuator> {
        // A joint that is wrong leaves open which fields belong to it.
        let row = self.joint(block, damaged)?;
        let kind = row.joint.kind;
        let all = fields(row);
        let from = self.row_values(block, row, &all);
        let is_taken = |name: &str| PartAttribute::named(name).is_some() || all.contains(&name);
        let params = self.instance_params_of(block, &is_taken, damaged);
        let cx = self.context_of(block, &params, damaged);
        let segment = self.shape(&from, "segment", "cylinder(8 mm, 16 mm)", &cx);
        let mass = self.mass(&from, segment.as_ref(), &cx);
        let friction =
            self.varying_number(&from, "friction", Dimension::NUMBER, (Sign::NotNegative, "0.8"), &cx);
        // How far and how fast it moves is the same for all of a kind: drives and targets are made for it.
        let alike = Context::new(Stage::Declaration, damaged);
        let known = self.expressions.errors.len();
        let range =
            if kind == JointKind::Spin { Some(None) } else { self.range(&from, kind, &alike).map(Some) };
        let speeds = if row.passive { Some(None) } else { self.speeds(&from, kind, &alike).map(Some) };
        let neutral = self.neutral(&from, kind, range.flatten(), &alike);
        for mut error in self.expressions.errors.split_off(known) {
            let name = self.environment.sources.slice(error.span());
            if error.code == Code::UNKNOWN_NAME && params.contains_key(name) {
                error.help = Some(format!(
                    "how far and how fast it {} is the same for all of a kind, and reads no parameter: declare another kind",
                    kind.does()
                ));
            }
            self.expressions.errors.add(error);
        }
        let examples = examples(kind);
        let effort = if row.passive {
            Some(None)
        } else {
            let (name, sign) = (kind.effort_field(), (Sign::Positive, examples.effort));
            self.varying_number(&from, name, kind.effort(), sign, &cx).map(Some)
        };
        let stiffness = if kind == JointKind::Spin {
            Some(Field::Fixed(0.0))
        } else {
            // What swings freely has no spring.
            let sign = if row.passive { Sign::NotNegative } else { Sign::Positive };
            self.varying_number(&from, "stiffness", kind.stiffness(), (sign, examples.stiffness), &cx)
        };
        // Damping is all that makes a driven spin turn.
        let sign = if kind == JointKind::Spin && !row.passive { Sign::Positive } else { Sign::NotNegative };
        let damping = self.varying_number(&from, "damping", kind.damping(), (sign, examples.damping), &cx);
        if let (Some(Field::Fixed(stiffness)), Some(Field::Fixed(damping)), Some((_, tree))) =
            (&stiffness, &damping, from.values.get("damping"))
            && !row.passive
            && kind != JointKind::Spin
        {
            self.slow_hinge(damping / stiffness, tree);
        }
        let colour = self.colour(&from, &cx);
        self.check_segments(block, params.get("segments"), damaged);
        let motor = speeds?.zip(effort?);
        Some(ir::Actuator {
            segment: segment?,
            mass: mass?,
            friction: friction?,
            joint: row.joint,
            range: range?,
            motor: motor.map(|((speed, relaxing_speed), effort)| ir::Motor { speed, relaxing_speed, effort }),
            stiffness: stiffness?,
            damping: damping?,
            neutral: neutral?,
            colour: colour?,
            params,
            span: block.name.span,
        })
    }

    /// The values of a row's fields. What belongs to other joints is told as that.
    fn row_values<'b>(&mut self, block: &'b Block, row: Row, all: &[&'static str]) -> Values<'b> {
        let known = self.expressions.errors.len();
        let allowed = Fields { all, blocks: &[] };
        let from = self.values(block, called(row), allowed);
        for mut error in self.expressions.errors.split_off(known) {
            let name = self.environment.sources.slice(error.span());
            if error.code == Code::UNKNOWN_FIELD
                && let Some(help) = belongs_elsewhere(name, row)
            {
                error.help = Some(help);
                error.fix = None;
            }
            self.expressions.errors.add(error);
        }
        from
    }

    /// The joint of a row.
    fn joint(&mut self, block: &Block, damaged: bool) -> Option<Row> {
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

    /// How fast a row moves.
    fn speeds(&mut self, from: &Values<'_>, kind: JointKind, cx: &Context) -> Option<Speeds> {
        if kind == JointKind::Bend {
            let speeds = (self.speed(from, "bending_speed", cx), self.speed(from, "relaxing_speed", cx));
            return Some((speeds.0?, speeds.1?));
        }
        let mut speed = |name| {
            let example = examples(kind).speed;
            self.number(from, name, kind.speed(), Sign::Positive, example, cx).map(Speed::Constant)
        };
        let away = speed("speed");
        let back =
            if from.values.contains_key("relaxing_speed") { speed("relaxing_speed") } else { away.clone() };
        Some((away?, back?))
    }

    /// Where springs pull a row: to where it is at rest, if it does not say.
    fn neutral(
        &mut self,
        from: &Values<'_>,
        kind: JointKind,
        range: Option<(f64, f64)>,
        cx: &Context,
    ) -> Option<f64> {
        let Some((_, tree)) = from.values.get("neutral") else { return Some(0.0) };
        let place = tree.span;
        let ty = Ty::Quantity(kind.position());
        let (value, _) = self.value(from, "neutral", &ty, "0 deg", cx)?;
        let neutral = value.as_number()?;
        let (low, high) = range?;
        if neutral < low || neutral > high {
            let shown = |x: f64| crate::types::expressions::shown(x, &ty);
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    place,
                    format!("`neutral` is outside the {}", in_words(kind)),
                )
                .label(format!("`{}` is {} .. {}", kind.range(), shown(low), shown(high)))
                .help("choose a value within it, or widen it"),
            );
            return None;
        }
        Some(neutral)
    }

    /// How far the tip goes against the base.
    fn range(&mut self, from: &Values<'_>, kind: JointKind, cx: &Context) -> Option<(f64, f64)> {
        let (name, example) = (kind.range(), examples(kind).range);
        let Some((_, tree)) = from.values.get(name) else {
            self.missing(from, name, example, cx.damaged);
            return None;
        };
        let ty = Ty::Domain(Box::new(Ty::Quantity(kind.position())));
        let expr = self.expressions.expect(tree, &mut cx.clone(), &ty, &format!("`{name}`"));
        let (low, high) = self.expressions.constant_range(&expr)?;
        if low > 0.0 || high < 0.0 || low >= high {
            let (zero, others) = if kind == JointKind::Slide {
                ("0 mm", "other distances")
            } else {
                ("0 deg", "other angles")
            };
            let label = match kind {
                JointKind::Bend => "the actuator is straight at rest",
                _ => "it begins there",
            };
            let example = if kind == JointKind::Slide { example } else { "0 deg .. 90 deg" };
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    format!("the range of `{name}` must contain {zero}, and {others}, too"),
                )
                .label(label)
                .help(format!("write for example `{name} = {example}`")),
            );
            return None;
        }
        let farthest = if high >= -low { high } else { low };
        self.usual(from.what, name, farthest, tree);
        Some((low, high))
    }

    /// The parameters that each instance of a kind has for itself. `is_taken` says which names are those of fields, or of what
    /// all instances have.
    pub(super) fn instance_params_of(
        &mut self,
        block: &Block,
        is_taken: &dyn Fn(&str) -> bool,
        damaged: bool,
    ) -> IndexMap<String, ir::InstanceParam> {
        let mut params = IndexMap::new();
        for field in &block.fields {
            let ast::Field::Param(param) = field else { continue };
            if is_taken(&param.name.text) {
                self.report(built_in(&param.name));
            }
            let mut cx = Context::new(Stage::Declaration, damaged);
            let ty = self.expressions.type_named(&param.ty);
            let domain = param.domain.as_ref().and_then(|d| {
                let domain = self.expressions.expect(
                    d,
                    &mut cx,
                    &Ty::Domain(Box::new(ty.clone())),
                    "the domain of a parameter",
                );
                self.expressions.constant_range(&domain)
            });
            let default = param
                .default
                .as_ref()
                .map(|d| self.expressions.expect(d, &mut cx, &ty, &format!("`{}`", param.name.text)));
            // A default without a value would refuse each part that is not given one.
            if let Some(default) = default.as_ref().filter(|d| d.ty.dimension().is_some()) {
                self.expressions.constant(default);
            }
            if let (Some((low, high)), Some(value)) =
                (domain, default.as_ref().and_then(|d| self.expressions.quiet_number(d)))
                && (value < low || value > high)
            {
                self.report(
                    Diagnostic::new(
                        Code::OUT_OF_DOMAIN,
                        param.name.span,
                        format!("`{}` is outside its domain", param.name.text),
                    )
                    .label("the default value"),
                );
            }
            if params.contains_key(&param.name.text) {
                let first = block.fields.iter().find_map(|f| match f {
                    ast::Field::Param(p) if p.name.text == param.name.text => Some(p.name.span),
                    _ => None,
                });
                let first = first.unwrap_or(param.name.span);
                self.report(
                    Diagnostic::new(
                        Code::DUPLICATE,
                        param.name.span,
                        format!("`{}` is declared twice", param.name.text),
                    )
                    .label("again")
                    .also(first, "first declared here")
                    .help("keep one of them"),
                );
            }
            params.insert(param.name.text.clone(), ir::InstanceParam { ty, domain, default });
        }
        params
    }

    /// Every actuator has a number of segments, as many as the simulators take.
    fn check_segments(&mut self, block: &Block, checked: Option<&ir::InstanceParam>, damaged: bool) {
        let written = block.fields.iter().find_map(|f| match f {
            ast::Field::Param(param) if param.name.text == "segments" => Some(param),
            _ => None,
        });
        let error = match (written, checked) {
            (None, _) if damaged => return,
            (None, _) | (_, None) => Diagnostic::new(
                Code::MISSING_FIELD,
                block.name.span,
                format!("`{}` has no parameter `segments`", block.name.text),
            )
            .label("an actuator is a row of segments"),
            (_, Some(ir::InstanceParam { ty: Ty::Unknown, .. })) => return,
            (Some(param), Some(ir::InstanceParam { ty, .. })) if *ty != Ty::Count => Diagnostic::new(
                Code::WRONG_TYPE,
                param.ty.span,
                "`segments` says how many there are: it is a Count",
            )
            .label(format!("this is {}", crate::types::expressions::fit::article(ty))),
            (Some(param), Some(ir::InstanceParam { domain, .. })) => {
                let place = param.domain.as_ref().map_or(param.name.span, |d| d.span);
                match domain {
                    Some((low, high)) if *low >= 2.0 && *high <= 64.0 => return,
                    // What is wrong with the domain has been told.
                    None if param.domain.is_some() => return,
                    _ => Diagnostic::new(
                        Code::OUT_OF_DOMAIN,
                        place,
                        "the number of `segments` must lie within 2 .. 64",
                    )
                    .label(if domain.is_some() {
                        "reaches further"
                    } else {
                        "no domain"
                    }),
                }
            }
        };
        self.report(error.help("write for example `param segments : Count in 2 .. 12 = 5`"));
    }
}

/// How far a row goes, in words.
fn in_words(kind: JointKind) -> &'static str {
    if kind == JointKind::Bend { "bend" } else { "range" }
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
fn belongs_elsewhere(field: &str, row: Row) -> Option<String> {
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
        "torque" | "effort" => format!("how strong it is says `{}`", kind.effort_field()),
        _ => return None,
    })
}
