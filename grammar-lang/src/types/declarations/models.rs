//! Checks models: how a motion is simulated.

use super::Declarations;
use super::fields::{Fields, Sign, Values};
use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Value;
use crate::ir::{self, Ty, UnfitStep};
use crate::syntax::ast::Block;
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

const MODEL: Fields<'static> = Fields {
    all: &[
        "method",
        "filling",
        "step",
        "control",
        "record",
        "gravity",
        "ground_friction",
        "iterations",
        "tolerance",
        "self_collision",
        "speed_limit",
        "pace_limit",
    ],
    blocks: &["filling"],
};

impl Declarations<'_> {
    /// How a model works; with hinges if it does not say.
    fn method(&mut self, from: &Values<'_>, cx: &Context) -> Option<ir::Method> {
        let hinges =
            !from.values.contains_key("method") || self.either(from, "method", ["hinges", "balls"], cx)?;
        let filling = match from.groups.get("filling") {
            Some(group) => Some(self.filling_of_parts(group, cx)?),
            None => None,
        };
        match (hinges, from.groups.get("filling")) {
            (true, Some(group)) => {
                self.report(
                    Diagnostic::new(
                        Code::UNKNOWN_FIELD,
                        group.name.span,
                        "a model with hinges cannot fill parts with balls",
                    )
                    .label("not possible here")
                    .help("write `method = balls`, or take the block out"),
                );
                None
            }
            (true, None) => Some(ir::Method::Hinges),
            (false, _) => Some(ir::Method::Balls(filling)),
        }
    }

    /// Refuses steps that no value can come of.
    fn check_step(
        &mut self,
        from: &Values<'_>,
        step: Option<f64>,
        control: Option<f64>,
        duration: Option<f64>,
        balls: bool,
    ) -> Option<()> {
        let (Some(step), Some((_, tree))) = (step, from.values.get("step")) else { return Some(()) };
        // What is missing, or wrong by itself, is told elsewhere.
        let [control, duration] = [control, duration].map(|time| time.unwrap_or(f64::INFINITY));
        let Err(coarse) = ir::is_fine_enough(!balls, step, control, duration) else { return Some(()) };
        let (label, help) = match coarse {
            UnfitStep::OfHinges => ("too long".to_owned(), "write for example `step = 1 s / 240`"),
            UnfitStep::AboveControl => (
                format!("longer than {control} s"),
                "write for example `step = 1 s / 240` and `control = 1 s / 60`",
            ),
            UnfitStep::TooFew => (
                format!("{:.0} steps", duration / step),
                "write a shorter `step`, or simulate for a longer time",
            ),
            UnfitStep::TooMany => (
                format!("{:.0} steps", duration / step),
                "write a longer `step`, or simulate for a shorter time",
            ),
        };
        let what = coarse.to_string();
        self.report(Diagnostic::new(Code::OUT_OF_DOMAIN, tree.span, what).label(label).help(help));
        None
    }

    pub(super) fn model(&mut self, block: &Block, duration: Option<f64>, damaged: bool) -> Option<ir::Model> {
        let cx = Context::new(Stage::Declaration, damaged);
        let from = self.values(block, "a model", MODEL);
        let method = self.method(&from, &cx);
        let balls = matches!(method, Some(ir::Method::Balls(_)));
        let mut get =
            |name: &str, ty: Ty, sign: Sign, example: &str| self.number(&from, name, ty, sign, example, &cx);
        let step = get("step", Dimension::TIME.into(), Sign::Positive, "1 s / 240");
        let control = get("control", Dimension::TIME.into(), Sign::Positive, "1 s / 60");
        let record = get("record", Dimension::TIME.into(), Sign::Positive, "1 s / 30");
        let gravity = get("gravity", Dimension::ACCELERATION.into(), Sign::NotNegative, "9.81 m/s^2");
        let ground_friction = get("ground_friction", Dimension::NUMBER.into(), Sign::NotNegative, "0.8");
        // Springs are not swept over.
        let swept = |name: &str| !balls || from.values.contains_key(name);
        let (sweeps, rest) = (swept("iterations"), swept("tolerance"));
        let iterations = if sweeps { get("iterations", Ty::Count, Sign::Positive, "10") } else { Some(1.0) };
        let tolerance = if rest {
            get("tolerance", Dimension::NUMBER.into(), Sign::NotNegative, "0.2 %")
        } else {
            Some(0.0)
        };
        let speed_limit = get("speed_limit", Dimension::VELOCITY.into(), Sign::Positive, "10 m/s");
        let self_collision = self.value(&from, "self_collision", &Ty::Bool, "true", &cx);
        let pace_limit = if from.values.contains_key("pace_limit") {
            Some(self.number(&from, "pace_limit", Dimension::VELOCITY, Sign::Positive, "20 cm/s", &cx)?)
        } else {
            None
        };
        if let (Some(n), Some((_, tree))) = (iterations, from.values.get("iterations"))
            && n > 1000.0
        {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    "more than 1000 sweeps in a step are never worthwhile",
                )
                .label("too many")
                .help("write for example `iterations = 10`"),
            );
        }
        for (name, value) in [("control", control), ("record", record)] {
            let (Some(value), Some(duration), Some((_, tree))) = (value, duration, from.values.get(name))
            else {
                continue;
            };
            if duration / value > 1e6 * (1.0 + 1e-9) || value > duration * (1.0 + 1e-9) {
                self.report(
                    Diagnostic::new(
                        Code::OUT_OF_DOMAIN,
                        tree.span,
                        format!(
                            "`{name}` must not be longer than the motion, or shorter than a millionth of it"
                        ),
                    )
                    .label(format!("{} s of a motion of {duration} s", value)),
                );
                return None;
            }
        }
        self.check_step(&from, step, control, duration, balls)?;
        Some(ir::Model {
            name: block.name.text.clone(),
            method: method?,
            duration: duration?,
            step: step?,
            control: control?,
            record: record?,
            gravity: gravity?,
            ground_friction: ground_friction?,
            iterations: iterations? as usize,
            tolerance: tolerance?,
            self_collision: self_collision?.0 == Value::Bool(true),
            speed_limit: speed_limit?,
            pace_limit,
        })
    }
}
