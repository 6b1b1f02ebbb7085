//! Checks actuators, and the parameters that each of them has for itself.

use indexmap::IndexMap;

use super::Declarations;
use super::fields::{Fields, Sign, Values};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{self, Field, PartAttribute, Ty};
use crate::syntax::ast::{self, Block};
use crate::types::built_in::built_in;
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

const ACTUATOR: Fields<'static> = Fields::values(&[
    "segment",
    "density",
    "mass",
    "friction",
    "bend",
    "bending_speed",
    "relaxing_speed",
    "torque",
    "stiffness",
    "damping",
    "colour",
]);

impl Declarations<'_> {
    pub(in crate::types) fn actuator(&mut self, block: &Block, damaged: bool) -> Option<ir::Actuator> {
        let from = self.values(block, "an actuator", ACTUATOR);
        let is_taken = |name: &str| PartAttribute::named(name).is_some() || ACTUATOR.all.contains(&name);
        let params = self.instance_params_of(block, &is_taken, damaged);
        let cx = self.context_of(block, &params, damaged);
        let segment = self.shape(&from, "segment", "cylinder(8 mm, 16 mm)", &cx);
        let mass = self.mass(&from, segment.as_ref(), &cx);
        let friction =
            self.varying_number(&from, "friction", Dimension::NUMBER, (Sign::NotNegative, "0.8"), &cx);
        // How far and how fast it bends is the same for all of a kind: drives and targets are made for it.
        let alike = Context::new(Stage::Declaration, damaged);
        let known = self.expressions.errors.len();
        let bend = self.bend(&from, &alike);
        let bending_speed = self.speed(&from, "bending_speed", &alike);
        let relaxing_speed = self.speed(&from, "relaxing_speed", &alike);
        for mut error in self.expressions.errors.split_off(known) {
            let name = self.environment.sources.slice(error.span());
            if error.code == Code::UNKNOWN_NAME && params.contains_key(name) {
                error.help = Some(
                    "how far and how fast it bends is the same for all of a kind, and reads no parameter: declare another kind"
                        .to_owned(),
                );
            }
            self.expressions.errors.add(error);
        }
        let mut positive = |name: &str, dimension: Dimension, example: &str| {
            self.varying_number(&from, name, dimension, (Sign::Positive, example), &cx)
        };
        let torque = positive("torque", Dimension::TORQUE, "0.06 N*m/rad");
        let stiffness = positive("stiffness", Dimension::ANGULAR_STIFFNESS, "0.3 N*m/rad^2");
        let damping = self.varying_number(
            &from,
            "damping",
            Dimension::ANGULAR_DAMPING,
            (Sign::NotNegative, "0.01 N*m*s/rad^2"),
            &cx,
        );
        if let (Some(Field::Fixed(stiffness)), Some(Field::Fixed(damping)), Some((_, tree))) =
            (&stiffness, &damping, from.values.get("damping"))
        {
            self.slow_hinge(damping / stiffness, tree);
        }
        let colour = self.colour(&from, &cx);
        self.check_segments(block, params.get("segments"), damaged);
        Some(ir::Actuator {
            segment: segment?,
            mass: mass?,
            friction: friction?,
            bend: bend?,
            bending_speed: bending_speed?,
            relaxing_speed: relaxing_speed?,
            torque: torque?,
            stiffness: stiffness?,
            damping: damping?,
            colour: colour?,
            params,
            span: block.name.span,
        })
    }

    fn bend(&mut self, from: &Values<'_>, cx: &Context) -> Option<(f64, f64)> {
        let Some((_, tree)) = from.values.get("bend") else {
            self.missing(from, "bend", "-90 deg .. 90 deg", cx.damaged);
            return None;
        };
        let ty = Ty::Domain(Box::new(Ty::Quantity(Dimension::ANGLE)));
        let expr = self.expressions.expect(tree, &mut cx.clone(), &ty, "`bend`");
        let (low, high) = self.expressions.constant_range(&expr)?;
        if low > 0.0 || high < 0.0 || low >= high {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    "the range of `bend` must contain 0 deg, and other angles, too",
                )
                .label("the actuator is straight at rest")
                .help("write for example `bend = 0 deg .. 90 deg`"),
            );
            return None;
        }
        let farthest = if high >= -low { high } else { low };
        self.usual(from.what, "bend", farthest, tree);
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
