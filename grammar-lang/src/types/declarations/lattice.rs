//! Checks lattices: their cells, the grid, and what rules do to places.

use indexmap::IndexMap;

use super::Declarations;
use super::fields::{Fields, Sign, Values};
use super::singles::Singles;
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::ir::{self, CellAttribute, Effect, Expr, ExprKind, Painting, Symmetry, Ty};
use crate::source::Span;
use crate::syntax::ast::{self, Block, ItemKind, Link, Name, RuleClause, RuleClauseKind};
use crate::syntax::declarations::BlockKind;
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

const CELL: Fields<'static> =
    Fields::values(&["spacing", "mass", "friction", "stiffness", "damping", "colour"]);

/// More places than this are a slip of the pen: the solver of balls numbers them in 16 bits, and keeps two numbers spare.
const MOST_PLACES: f64 = 65_534.0;

impl Declarations<'_> {
    pub(super) fn cell(&mut self, block: &Block, damaged: bool) -> Option<ir::Cell> {
        let cx = Context::new(Stage::Declaration, damaged);
        let from = self.values(block, "a cell", CELL);
        let spacing = self.number(&from, "spacing", Dimension::LENGTH, Sign::Positive, "1 cm", &cx);
        let is_taken = |name: &str| CellAttribute::named(name).is_some() || CELL.all.contains(&name);
        let params = self.instance_params_of(block, &is_taken, damaged);
        // What a cell is made of may depend on its parameters.
        let cx = self.context_of(block, &params, damaged);
        let mass = self.cell_field(&from, "mass", Dimension::MASS, Sign::Positive, "0.5 g", &cx);
        let friction = self.cell_field(&from, "friction", Dimension::NUMBER, Sign::NotNegative, "0.8", &cx);
        let stiffness =
            self.cell_field(&from, "stiffness", Dimension::STIFFNESS, Sign::Positive, "200 N/m", &cx);
        let damping =
            self.cell_field(&from, "damping", Dimension::DAMPING, Sign::NotNegative, "0.1 N*s/m", &cx);
        let colour = match from.values.get("colour") {
            Some((_, tree)) => self.expressions.expect(tree, &mut cx.clone(), &Ty::Text, "`colour`"),
            None => {
                let kind = ExprKind::Text("#9aa3ad".to_owned());
                Expr { kind, ty: Ty::Text, span: block.name.span }
            }
        };
        Some(ir::Cell {
            spacing: spacing?,
            mass: mass?,
            friction: friction?,
            stiffness: stiffness?,
            damping: damping?,
            colour,
            params,
            span: block.name.span,
        })
    }

    /// A field whose value may depend on the parameters of the cell.
    fn cell_field(
        &mut self,
        from: &Values<'_>,
        name: &str,
        dimension: Dimension,
        sign: Sign,
        example: &str,
        cx: &Context,
    ) -> Option<Expr> {
        let Some((_, tree)) = from.values.get(name) else {
            self.missing(from, name, example, cx.damaged);
            return None;
        };
        let ty = Ty::Quantity(dimension);
        let known = self.expressions.errors.len();
        let expr = self.expressions.expect(tree, &mut cx.clone(), &ty, &format!("`{name}`"));
        self.show_example(known, tree.span, name, example);
        if expr.ty == Ty::Unknown {
            return None;
        }
        let fixed = !expr.any(&mut |e| matches!(e.kind, ExprKind::Local(_)));
        if let Some(x) = self.expressions.quiet_number(&expr).filter(|_| fixed) {
            let fine = match sign {
                Sign::Positive => x > 0.0,
                Sign::NotNegative => x >= 0.0,
            };
            if !fine {
                let must =
                    if matches!(sign, Sign::Positive) { "must be above 0" } else { "must not be below 0" };
                self.report(
                    Diagnostic::new(Code::OUT_OF_DOMAIN, tree.span, format!("`{name}` {must}"))
                        .label(format!("this is {}", crate::types::expressions::shown(x, &ty)))
                        .help(format!("write for example `{name} = {example}`")),
                );
                return None;
            }
        }
        Some(expr)
    }

    /// The grid; what its cells are is looked at when all names have been touched.
    pub(super) fn lattice(
        &mut self,
        sides: &[ast::Expr; 3],
        kind: &Name,
        span: Span,
    ) -> Option<([usize; 3], ir::Cell, Span)> {
        let cell = match self.named(kind, "cell", |k| matches!(k, ItemKind::Block(BlockKind::Cell, _))) {
            Some(ItemKind::Block(BlockKind::Cell, block)) => self.cell(block, false),
            _ => None,
        };
        let mut counts = [0; 3];
        for (count, side) in counts.iter_mut().zip(sides) {
            let mut cx = Context::new(Stage::Declaration, false);
            let value = self.expressions.expect(side, &mut cx, &Ty::Count, "the side of a lattice");
            let n = self.expressions.constant_number(&value)?;
            if n < 1.0 {
                self.report(
                    Diagnostic::new(
                        Code::OUT_OF_DOMAIN,
                        side.span,
                        "a lattice must have at least one place along each side",
                    )
                    .label(format!("this is {n}"))
                    .help("write for example `lattice 15 x 15 x 15 of soft`"),
                );
                return None;
            }
            *count = n.min(MOST_PLACES + 1.0) as usize;
        }
        let places: f64 = counts.iter().map(|n| *n as f64).product();
        if places > MOST_PLACES {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    span,
                    format!("a lattice can have at most {MOST_PLACES} places"),
                )
                .label(format!("{places} places are more than can be simulated"))
                .help("write for example `lattice 15 x 15 x 15 of soft`, which has 3375"),
            );
            return None;
        }
        Some((counts, cell?, span))
    }

    /// A symmetry must map the grid onto itself.
    pub(in crate::types) fn check_lattice_symmetry(
        &mut self,
        sides: [usize; 3],
        symmetry: Symmetry,
        span: Span,
    ) {
        let Symmetry::Radial(count, axis) = symmetry else { return };
        let around: Vec<usize> =
            (0..3).filter(|i| *i != axis).filter_map(|i| sides.get(i).copied()).collect();
        let square = around.first() == around.last();
        if count == 2 || count == 4 && square {
            return;
        }
        let (message, help) = if count == 4 {
            ("a lattice with `symmetry radial 4` must be square around its axis", "give it two equal sides")
        } else {
            (
                "a lattice can have a mirror symmetry, or a radial symmetry of 2 or 4",
                "write `symmetry mirror xy`, or `symmetry radial 2 about y`",
            )
        };
        self.report(
            Diagnostic::new(Code::BAD_VALUE, span, message)
                .label("a lattice cannot have this symmetry")
                .help(help),
        );
    }

    /// What `begin` fills.
    pub(super) fn begin_cells(&mut self, fills: &[RuleClause], damaged: bool) -> Vec<Effect> {
        let mut cx = Context::new(Stage::Derivation, damaged);
        fills
            .iter()
            .filter_map(|clause| match &clause.kind {
                RuleClauseKind::Repeat { over, clauses } => self.repeat(over, clauses, &mut cx),
                kind => self.cells(kind, clause.span, &mut cx),
            })
            .collect()
    }

    /// `fill`, `paint` or `clear`.
    pub(super) fn cells(&mut self, clause: &RuleClauseKind, span: Span, cx: &mut Context) -> Option<Effect> {
        let RuleClauseKind::Cells { how, region, with } = clause else { return None };
        let places = Ty::List(Box::new(Ty::Cell));
        let region = self.expressions.infer(region, cx);
        let region = if region.ty == Ty::Cell {
            // One place is a region, too.
            Expr { ty: places.clone(), span: region.span, kind: ExprKind::List(vec![region]) }
        } else {
            self.expressions.fit(region, &places, &format!("what follows `{}`", how.word()))
        };
        let with = with.as_ref().map(|with| self.filling(*how, with, span, cx));
        Some(Effect::Cells(ir::Cells { how: *how, region, with }))
    }

    /// What cells become.
    fn filling(&mut self, how: Painting, with: &ast::Expr, clause: Span, cx: &mut Context) -> Expr {
        let with = self.expressions.expect(with, cx, &Ty::Kind, &format!("what is used to {}", how.word()));
        let ExprKind::Kind(kind, given) = &with.kind else { return with };
        if !self.expressions.is_cell(kind, with.span) {
            let cells: Vec<&str> = self
                .expressions
                .guessable(with.span)
                .filter(|(_, i)| matches!(i.kind, ItemKind::Block(BlockKind::Cell, _)))
                .map(|(n, _)| n)
                .collect();
            let help = did_you_mean(kind, cells.iter().copied()).unwrap_or_else(|| {
                format!("write for example `{} ... with {}`", how.word(), cells.first().unwrap_or(&"soft"))
            });
            let message = format!("`{kind}` is not a cell: a lattice can contain only cells");
            self.report(Diagnostic::new(Code::WRONG_TYPE, with.span, message).label("a part").help(help));
        } else if how == Painting::Paint && given.is_empty() {
            self.report(
                Diagnostic::new(Code::NO_EFFECT, clause, "this paints nothing")
                    .label("no parameter is given")
                    .help(format!(
                        "write for example `paint neighbours(c) with {kind}(PARAMETER = c.PARAMETER)`"
                    )),
            );
        }
        with
    }

    /// Reports what a rule does with parts where bodies are lattices, and with cells where they are not.
    pub(super) fn check_space(&mut self, clauses: &[RuleClause]) {
        let lattice = self.environment.has_lattice;
        // A module on its own does not know which bodies it will meet.
        if self.environment.program.name.is_none() {
            return;
        }
        for clause in clauses {
            if let RuleClauseKind::Repeat { clauses, .. } = &clause.kind {
                self.check_space(clauses);
                continue;
            }
            let of_parts = match &clause.kind {
                // What is set by its name alone belongs to the whole body.
                RuleClauseKind::Set { target, .. } => !matches!(target.kind, ast::ExprKind::Name(_)),
                RuleClauseKind::Attach { .. }
                | RuleClauseKind::Remove(_)
                | RuleClauseKind::Replace { .. } => true,
                RuleClauseKind::Match { links, .. } => links.len() > 1 || links.iter().any(asks_for_parts),
                _ => false,
            };
            let of_cells = match &clause.kind {
                RuleClauseKind::Cells { .. } => true,
                RuleClauseKind::Match { links, .. } => {
                    let cell = |link: &Link| {
                        link.kind
                            .as_ref()
                            .is_some_and(|k| k.text == "cell" || self.expressions.is_cell(&k.text, k.span))
                    };
                    links.iter().any(cell)
                }
                _ => false,
            };
            if lattice && of_parts || !lattice && of_cells {
                self.mixed(clause.span, lattice);
            }
        }
    }

    /// Reports parts in a lattice, or cells where there is none.
    pub(super) fn mixed(&mut self, span: Span, lattice: bool) {
        let (message, label, help) = if lattice {
            (
                "the bodies of this grammar are lattices: they are made of cells, not of parts",
                "about parts",
                "write `match c : cell`, and `fill`, `paint` or `clear` places",
            )
        } else {
            (
                "the bodies of this grammar are made of parts: there are no cells",
                "only for lattices",
                "declare a `lattice`, or write `match p : part` and `attach`",
            )
        };
        self.report(Diagnostic::new(Code::MIXED_SPACES, span, message).label(label).help(help));
    }

    /// The rules that alone are drawn while something holds.
    pub(in crate::types) fn fallbacks(&mut self, rules: &[ir::Rule]) -> Vec<ir::Fallback> {
        let program = self.environment.program;
        let mut fallbacks = Vec::new();
        for (_, item) in program.entries() {
            let ItemKind::Fallback { rule, condition, because } = &item.kind else { continue };
            let mut cx = Context::new(Stage::Derivation, item.damaged);
            let condition = self.expressions.expect(condition, &mut cx, &Ty::Bool, "what follows `when`");
            let Some(named) = self.named(rule, "rule", |k| matches!(k, ItemKind::Rule(..))) else { continue };
            if self.tell_of_always(rule, named) || self.tell_of_unused_rule(rule) {
                continue;
            }
            // A rule in which something is wrong has been reported.
            if rules.iter().any(|known| known.name == rule.text) {
                fallbacks.push(ir::Fallback {
                    rule: rule.text.clone(),
                    condition,
                    because: because.clone(),
                    span: item.span,
                });
            }
        }
        fallbacks
    }

    /// The models of all tasks must be able to simulate the bodies.
    pub(in crate::types) fn check_models(
        &mut self,
        tasks: &super::tasks::Tasks,
        singles: &Singles<'_>,
        parts: &IndexMap<String, ir::Part>,
        actuators: &IndexMap<String, ir::Actuator>,
    ) {
        // Balls are strained: that bends a row, or makes it longer.
        let strains = |joint: &ir::Joint| match joint.kind {
            ir::JointKind::Bend => true,
            ir::JointKind::Slide => joint.axis.fixed().is_some_and(|axis| axis[0].abs() == 1.0),
            ir::JointKind::Twist | ir::JointKind::Spin | ir::JointKind::Socket => false,
        };
        let jointed = parts.values().any(|part| part.joint.is_some());
        let bent = |joint: &ir::Joint| joint.rests_elsewhere();
        let odd = actuators.iter().find(|(_, actuator)| !strains(&actuator.joint) || bent(&actuator.joint));
        let lattice = self.environment.has_lattice;
        let first = tasks.values().next().map(|(task, _)| task.model.method);
        for (task, _) in tasks.values() {
            let place = singles.seen.get("simulate").copied().unwrap_or(task.objective.value.span);
            let (message, help) = match (lattice, task.model.method) {
                (true, ir::Method::Hinges) => (
                    "the bodies of this grammar are lattices: a model of hinges cannot simulate them",
                    "use a model whose `method` is `balls`, such as `ball_springs` of `std.models`",
                ),
                (false, ir::Method::Balls(None)) => (
                    "the bodies of this grammar are made of parts, but this model does not define how to fill them",
                    "add for example `filling { spacing = 1 cm  stiffness = 500 N/m  damping = 0.5 N*s/m }` to the model",
                ),
                (_, method) if Some(method) != first => (
                    "all tasks of a body must be simulated by the same method",
                    "simulate all of them with hinges, or all with the same balls",
                ),
                (false, ir::Method::Balls(Some(_))) if odd.is_some() => (
                    "a model of balls can only bend a row that rests straight, or lengthen it",
                    "simulate twists, spins, sockets, slides across the row and rows that rest bent (`neutral`) with a model of hinges, such as `hinge_model` of `std.models`",
                ),
                (false, ir::Method::Balls(Some(_))) if jointed => (
                    "balls hold parts together without joints",
                    "simulate a part that has a `joint` with a model of hinges, such as `hinge_model` of `std.models`",
                ),
                _ => continue,
            };
            self.report(
                Diagnostic::new(Code::MODEL_MISFIT, place, message)
                    .label(format!("the model `{}`", task.model.name))
                    .help(help),
            );
        }
    }

    /// Which balls parts are filled with.
    pub(super) fn filling_of_parts(&mut self, group: &Block, cx: &Context) -> Option<ir::Filling> {
        let from = self.values(group, "a filling", Fields::values(&["spacing", "stiffness", "damping"]));
        let spacing = self.number(&from, "spacing", Dimension::LENGTH, Sign::Positive, "1 cm", cx);
        let stiffness = self.number(&from, "stiffness", Dimension::STIFFNESS, Sign::Positive, "500 N/m", cx);
        let damping = self.number(&from, "damping", Dimension::DAMPING, Sign::NotNegative, "0.5 N*s/m", cx);
        let filling = ir::Filling { spacing: spacing?, stiffness: stiffness?, damping: damping? };
        if let Some((_, tree)) = from.values.get("stiffness") {
            self.soft_filling(&filling, tree);
        }
        Some(filling)
    }
}

/// Whether a match asks for something that only parts have.
fn asks_for_parts(link: &Link) -> bool {
    let kind = link.kind.as_ref().map_or("part", |kind| kind.text.as_str());
    link.port.is_some()
        || link.owner.is_some()
        || matches!(kind, "part" | "block" | "actuator" | "port" | "joint")
}
