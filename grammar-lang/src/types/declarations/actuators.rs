//! Checks actuators, and the parameters that each of them has for itself.

use indexmap::IndexMap;

use super::Declarations;
use super::constructions::{BLOCKS, FIELDS};
use super::fields::{Fields, Sign, Values, reads_params};
use super::joints::{Owner, Row, belongs_elsewhere, called, called_here, examples, fields, says_joint};
use crate::diagnostics::{Code, Diagnostic, Fix, respell};
use crate::eval::{SHORTER, shortens};
use crate::ir::{self, ExprKind, Field, JointKind, PartAttribute, Speed, Ty};
use crate::syntax::ast::{self, Block};
use crate::types::built_in::built_in;
use crate::types::expressions::call::misspells_segments;
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

/// How fast a row moves: away from rest, and back.
type Speeds = (Field<Speed>, Field<Speed>);

impl Declarations<'_> {
    pub(in crate::types) fn actuator(&mut self, block: &Block, damaged: bool) -> Option<ir::Actuator> {
        // A joint that is wrong leaves open which fields belong to it.
        let row = self.joint(block, Owner::Row)?;
        // Where a joint cannot be read, its fields are not those of a row that bends.
        let of_others = |field: &ast::Field| matches!(field, ast::Field::Value(name, _) if ["range", "speed", "effort", "neutral", "begins"].contains(&name.text.as_str()));
        if damaged && !says_joint(block) && block.fields.iter().any(of_others) {
            return None;
        }
        let kind = row.kind;
        let mut all = fields(row);
        if kind == JointKind::Bend {
            all.extend(FIELDS);
        }
        let from = self.row_values(block, row, &all);
        let is_taken = |name: &str| PartAttribute::named(name).is_some() || all.contains(&name);
        let params = self.instance_params_of(block, &is_taken, damaged);
        let cx = self.context_of(block, &params, damaged);
        let axis = self.joint_axis(row, &cx)?;
        let segment = self.shape(&from, "segment", "cylinder(8 mm, 16 mm)", &cx);
        let mass = self.mass(&from, segment.as_ref(), &cx);
        let friction =
            self.varying_number(&from, "friction", Dimension::NUMBER, (Sign::NotNegative, "0.8"), &cx);
        let least = params.get("segments").and_then(|param| param.domain).map_or(2.0, |(low, _)| low);
        let construction = self.construction(&from, (segment.as_ref(), &axis), &cx);
        let joint = self.joint_of(&from, (row, axis), (least - 1.0).max(1.0), &cx);
        if let (Some(joint), Some(Field::Fixed(form))) = (&joint, &segment) {
            self.not_too_short(&from, joint, 2.0 * form.half_extents().x * least);
        }
        let speeds = if row.passive { Some(None) } else { self.speeds(&from, kind, &cx).map(Some) };
        let examples = examples(kind);
        let effort = if row.passive {
            Some(None)
        } else {
            let (name, sign) = (kind.effort_field(), (Sign::Positive, examples.effort));
            self.varying_number(&from, name, kind.effort(), sign, &cx).map(Some)
        };
        if let Some(ir::Joint { stiffness: Field::Fixed(stiffness), damping: Field::Fixed(damping), .. }) =
            &joint
            && let Some((_, tree)) = from.values.get("damping")
            && !row.passive
            && kind != JointKind::Spin
        {
            self.odd_lag(damping / stiffness, tree);
        }
        if let (Some((_, tree)), Some(Some((away, back)))) = (from.values.get("neutral"), &speeds)
            && [away, back].iter().any(|speed| matches!(speed, Field::Fixed(ir::Speed::ByBend(_))))
        {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    "an actuator whose speed is a table cannot have a `neutral`",
                )
                .label("the table begins at a bend of 0")
                .help("give it a speed that is one number, or leave `neutral` out"),
            );
        }
        let colour = self.colour(&from, &cx);
        self.check_segments(block, params.get("segments"), damaged);
        let motor = speeds?.zip(effort?);
        Some(ir::Actuator {
            segment: segment?,
            mass: mass?,
            friction: friction?,
            joint: joint?,
            motor: motor.map(|((speed, relaxing_speed), effort)| ir::Motor { speed, relaxing_speed, effort }),
            colour: colour?,
            construction,
            params,
            span: block.name.span,
        })
    }

    /// The values of a row's fields. What belongs to other joints is told as that.
    pub(super) fn row_values<'b>(
        &mut self,
        block: &'b Block,
        row: Row<'_>,
        all: &[&'static str],
    ) -> Values<'b> {
        let known = self.expressions.errors.len();
        let allowed = Fields { all, blocks: &BLOCKS };
        let what = match row.of {
            Owner::Row => called(row),
            Owner::Part => "a part",
        };
        let mut from = self.values(block, what, allowed);
        for mut error in self.expressions.errors.split_off(known) {
            let (name, place) = (self.environment.sources.slice(error.span()), error.span());
            if error.code == Code::UNKNOWN_FIELD
                && let Some(help) = belongs_elsewhere(name, row)
            {
                let meant = called_here(name, row.kind).filter(|meant| all.contains(meant));
                error.fix = meant.map(|meant| Fix::replace(place, meant, format!("write `{meant}`")));
                error.help = Some(help);
                // What is there under another name is not missing, too.
                from.misspelt.extend(meant.map(str::to_owned));
            }
            self.expressions.errors.add(error);
        }
        from
    }

    /// How fast a row moves.
    fn speeds(&mut self, from: &Values<'_>, kind: JointKind, cx: &Context) -> Option<Speeds> {
        if kind == JointKind::Bend {
            let speeds = (self.speed(from, "bending_speed", cx), self.speed(from, "relaxing_speed", cx));
            return Some((speeds.0?, speeds.1?));
        }
        let mut speed = |name| {
            let example = examples(kind).speed;
            self.varying_speed(from, name, kind.speed(), example, cx)
        };
        let away = speed("speed");
        let back =
            if from.values.contains_key("relaxing_speed") { speed("relaxing_speed") } else { away.clone() };
        Some((away?, back?))
    }

    /// How far the tip goes against the base, or a part against what holds it.
    pub(super) fn range(
        &mut self,
        from: &Values<'_>,
        row: Row<'_>,
        cx: &Context,
    ) -> Option<Field<(f64, f64)>> {
        let kind = row.kind;
        let (name, example) = (kind.range(), examples(kind).range);
        let Some((_, tree)) = from.values.get(name) else {
            self.missing(from, name, example, cx.damaged);
            return None;
        };
        let ty = Ty::Domain(Box::new(Ty::Quantity(kind.position())));
        let expr = self.expressions.expect(tree, &mut cx.clone(), &ty, &format!("`{name}`"));
        if reads_params(&expr, cx.locals.len()) && matches!(expr.kind, ExprKind::Range(..)) {
            self.hiding(&expr, cx);
            return Some(Field::Varies(expr));
        }
        let (low, high) = self.expressions.constant_range(&expr)?;
        // A joint begins where it rests.
        let rests_elsewhere = ["neutral", "begins"].iter().any(|field| from.values.contains_key(field));
        if low >= high || (low > 0.0 || high < 0.0) && !rests_elsewhere {
            let (zero, others) = if kind == JointKind::Slide {
                ("0 mm", "other distances")
            } else {
                ("0 deg", "other angles")
            };
            let label = match (kind, row.of) {
                (JointKind::Bend, Owner::Row) => "the actuator is straight at rest",
                _ => "the joint begins there",
            };
            let example = if kind == JointKind::Slide { example } else { "0 deg .. 90 deg" };
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    format!("`{name}` must contain {zero}, and {others}, too"),
                )
                .label(label)
                .help(match row.passive && kind != JointKind::Socket && low < high {
                    false if row.passive || low >= high => format!("write for example `{name} = {example}`"),
                    false => format!(
                        "write for example `{name} = {example}`; if the actuator is made bent, give the angle as `neutral`"
                    ),
                    true => {
                        let ty = Ty::Quantity(kind.position());
                        let middle = crate::types::expressions::shown(0.5 * (low + high), &ty);
                        format!("give the rest position of its spring, such as `neutral = {middle}`: the joint begins there")
                    }
                }),
            );
            return None;
        }
        let farthest = if high >= -low { high } else { low };
        self.usual(from.what, name, farthest, tree);
        Some(Field::Fixed((low, high)))
    }

    /// A row that slides along itself must not get so short that its segments go through each other.
    fn not_too_short(&mut self, from: &Values<'_>, joint: &ir::Joint, length: f64) {
        let (JointKind::Slide, Some(Field::Fixed(range)), Field::Fixed(axis)) =
            (joint.kind, &joint.range, &joint.axis)
        else {
            return;
        };
        let Some((_, tree)) = from.values.get("range") else { return };
        let shorter = shortens(*axis, *range);
        if shorter <= SHORTER * length * (1.0 + 1e-9) {
            return;
        }
        let shown = |x: f64| crate::units::shown(x, Dimension::LENGTH);
        self.report(
            Diagnostic::new(
                Code::OUT_OF_DOMAIN,
                tree.span,
                format!("the row cannot get shorter by {}", shown(shorter)),
            )
            .label(format!("the shortest row is {} long", shown(length)))
            .help(format!("let it get shorter by at most half of its length, {}", shown(SHORTER * length))),
        );
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
            let name = param.name.text.as_str();
            if is_taken(name) || ir::BLOCK_PORTS.contains(&name) || ir::ACTUATOR_PORTS.contains(&name) {
                self.report(built_in(&param.name));
            } else if self.environment.ports.contains(name) {
                self.report(
                    Diagnostic::new(
                        Code::DUPLICATE,
                        param.name.span,
                        format!("`{name}` is the name of a port of a part"),
                    )
                    .label(format!("`p.{name}` would be the port"))
                    .help("give the parameter another name"),
                );
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
                && !crate::eval::order::is_within(low, value, high)
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

    /// Every row that bends, and does not say so, has a number of segments; any number is one that the simulators take.
    fn check_segments(&mut self, block: &Block, checked: Option<&ir::InstanceParam>, damaged: bool) {
        let written = block.fields.iter().find_map(|f| match f {
            ast::Field::Param(param) if param.name.text == "segments" => Some(param),
            _ => None,
        });
        let declared = block.fields.iter().filter_map(|f| match f {
            ast::Field::Param(param) => Some(&param.name),
            _ => None,
        });
        let misspelt = declared.filter(|_| written.is_none()).find(|name| misspells_segments(&name.text));
        if let Some(name) = misspelt {
            let message =
                format!("`{}` has the parameter `{}`, but not `segments`", block.name.text, name.text);
            self.report(
                Diagnostic::new(Code::MISSING_FIELD, name.span, message)
                    .label("probably misspelt")
                    .help("did you mean `segments`?")
                    .fix_if(respell(name.span, &name.text, ["segments"])),
            );
            return;
        }
        let error = match (written, checked) {
            (None, _) if damaged || says_joint(block) => return,
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
                "`segments` must be a Count: it is the number of segments",
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
                        "goes beyond this range"
                    } else {
                        "no domain"
                    }),
                }
            }
        };
        self.report(error.help(match written {
            Some(_) => "write for example `param segments : Count in 2 .. 12 = 5`",
            None => {
                "write for example `param segments : Count in 2 .. 12 = 5`, or, for two segments and the hinge between them, `joint = bend about z`"
            }
        }));
    }
}
