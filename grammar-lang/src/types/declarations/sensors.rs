//! Checks sensors: what they read, how noisily, and how late.

use indexmap::IndexMap;

use super::fields::Values;
use super::tasks::Tasks;
use super::{Declarations, Named};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{self, Ty};
use crate::source::Span;
use crate::syntax::ast::{self, Sense};
use crate::types::expressions::context::Context;
use crate::types::expressions::fit::article;
use crate::types::expressions::stage::Stage;
use crate::units::{self, Dimension};

/// The longest delay of a sensor, s: what is felt so late steers nothing.
const LATEST: f64 = 10.0;

impl Declarations<'_> {
    pub(super) fn sensor(&mut self, sense: &Sense, damaged: bool) -> Option<ir::Sensor> {
        let mut cx = Context::new(Stage::Sense, damaged);
        let of = match &sense.of {
            None => None,
            Some((binder, kind)) => Some(self.of_parts(
                binder,
                kind,
                &mut cx,
                "cells of a lattice cannot have sensors",
                "sensors are of parts and actuators, as in `sense load(a : actuator) : Force = a.load at now`",
            )?),
        };
        let ty = self.expressions.type_named(&sense.ty);
        let value = self.expressions.expect(&sense.value, &mut cx, &ty, &format!("`{}`", sense.name.text));
        let noise = self.noise(sense, &ty, damaged);
        let delay = self.delay(sense, damaged);
        if !matches!(ty, Ty::Quantity(_) | Ty::Bool | Ty::Unknown) {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, sense.ty.span, "a sensor must be a quantity or a Bool")
                    .label(format!("this is {}", article(&ty)))
                    .help("declare a sensor for each component, as in `sense ahead : Velocity = (core.velocity at now).x`"),
            );
            return None;
        }
        if ty == Ty::Unknown || value.ty == Ty::Unknown {
            return None;
        }
        Some(ir::Sensor { of, ty, value, noise: noise?, delay: delay?, span: sense.name.span })
    }

    /// The parts that have a sensor or a state each; the part is bound.
    pub(super) fn of_parts(
        &mut self,
        binder: &ast::Name,
        kind: &ast::Name,
        cx: &mut Context,
        no_cells: &str,
        help: &str,
    ) -> Option<ir::Group> {
        // A kind is a collection of parts where there is a design.
        let group = self.group_named(kind, &mut Context::new(Stage::Derivation, cx.damaged))?;
        let member = self.expressions.member_of(&group, kind.span);
        if member == Ty::Cell {
            let error = Diagnostic::new(Code::WRONG_TYPE, kind.span, no_cells);
            self.report(error.label("a cell").help(help));
            return None;
        }
        self.expressions.note_group(binder, &group);
        self.expressions.bind(binder, member, cx);
        Some(group)
    }

    /// The standard deviation of the noise, or how likely a Bool is wrong.
    fn noise(&mut self, sense: &Sense, ty: &Ty, damaged: bool) -> Option<f64> {
        let Some(noise) = &sense.noise else { return Some(0.0) };
        let (wanted, what, most) = match ty {
            Ty::Bool => (Ty::NUMBER, "the probability of a wrong reading", 0.5),
            ty => (ty.clone(), "the standard deviation of the noise", f64::MAX),
        };
        let value = self.constant_of(noise, &wanted, what, damaged)?;
        if (0.0..=most).contains(&value) {
            return Some(value);
        }
        let (label, help) = match ty {
            Ty::Bool => (
                format!("this is {value}"),
                "write a share from 0 to 0.5, such as `noise 2 %`: a sensor that is wrong half of the time gives no information",
            ),
            _ => ("negative".to_owned(), "write how far readings scatter, such as `noise 1 deg`"),
        };
        self.report(
            Diagnostic::new(Code::OUT_OF_DOMAIN, noise.span, format!("{what} lies outside its range"))
                .label(label)
                .help(help),
        );
        None
    }

    /// How old what is read is at least, s.
    fn delay(&mut self, sense: &Sense, damaged: bool) -> Option<f64> {
        let Some(delay) = &sense.delay else { return Some(0.0) };
        let time = Ty::Quantity(Dimension::TIME);
        let value = self.constant_of(delay, &time, "the delay of a sensor", damaged)?;
        if (0.0..=LATEST).contains(&value) {
            return Some(value);
        }
        self.report(
            Diagnostic::new(
                Code::OUT_OF_DOMAIN,
                delay.span,
                "the delay of a sensor must lie within 0 s .. 10 s",
            )
            .label(format!("this is {}", units::shown(value, Dimension::TIME)))
            .help("write for example `delay 20 ms`"),
        );
        None
    }

    /// The sensors that a target has.
    pub(super) fn measured_by(&mut self, from: &Values<'_>) -> Option<Vec<String>> {
        let Some((_, tree)) = from.values.get("sensors") else { return Some(Vec::new()) };
        let ast::ExprKind::List(items) = &tree.kind else {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, tree.span, "`sensors` is a list of sensors")
                    .label("not a list")
                    .help("write the names of what the hardware measures, as in `sensors = [carried, lean]`"),
            );
            return None;
        };
        let mut sensors = Vec::new();
        for item in items {
            let ast::ExprKind::Name(name) = &item.kind else {
                self.report(
                    Diagnostic::new(Code::WRONG_TYPE, item.span, "`sensors` names sensors")
                        .label("not a name")
                        .help("declare the sensor with `sense`, and write its name here"),
                );
                return None;
            };
            let name = ast::Name { text: name.clone(), span: item.span };
            self.named(&name, "sensor", |kind| matches!(kind, ast::ItemKind::Sense(_)))?;
            sensors.push(name.text);
        }
        Some(sensors)
    }

    /// Whether a target measures what the actuation reads that is simulated on it.
    pub(super) fn check_measured(
        &mut self,
        (name, target): (&str, &ir::Target),
        (with, actuation): (&str, &ir::Actuation),
        Named { policies, states, .. }: &Named,
        place: Span,
    ) {
        let felt = ir::felt_by(actuation.values_with(policies), states);
        let is_missing = |name: &String| !states.contains_key(name) && !target.sensors.contains(name);
        if let Some((sensor, read)) = felt.into_iter().find(|(name, _)| is_missing(name)) {
            self.report(
                Diagnostic::new(
                    Code::TARGET_MISFIT,
                    place,
                    format!("`{with}` reads `{sensor}`, which the target `{name}` does not measure"),
                )
                .label("does not fit")
                .also(read, "read here")
                .also(target.span, "this target")
                .help(format!("add `sensors = [{sensor}]` to the target, if its hardware has this sensor")),
            );
        }
    }

    /// Balls have neither joints nor one velocity for a part: nothing there reacts.
    pub(in crate::types) fn check_closed_loops(
        &mut self,
        tasks: &Tasks,
        actuations: &IndexMap<String, ir::Actuation>,
    ) {
        for (task, actuated) in tasks.values() {
            if task.model.method == ir::Method::Hinges {
                continue;
            }
            let closed = actuated
                .values()
                .find(|(with, _)| actuations.get(with).is_some_and(ir::Actuation::is_closed_loop));
            if let Some((with, place)) = closed {
                self.report(
                    Diagnostic::new(
                        Code::MODEL_MISFIT,
                        *place,
                        format!("`{with}` reads sensors, or has a `state` or an `action`, and a model of balls supports none of these"),
                    )
                    .label("reacts")
                    .help("simulate it with a model of hinges, such as `hinge_model` of `std.models`, or drive by `t` alone"),
                );
                return;
            }
        }
    }

    fn constant_of(&mut self, tree: &ast::Expr, ty: &Ty, what: &str, damaged: bool) -> Option<f64> {
        let mut cx = Context::new(Stage::Declaration, damaged);
        let value = self.expressions.expect(tree, &mut cx, ty, what);
        self.expressions.constant_number(&value)
    }
}
