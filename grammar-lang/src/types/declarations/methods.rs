//! Checks what the loops of a search search by: annealing, an archive of kinds, a population, a front, evolution of curves.

use indexmap::IndexMap;

use super::Declarations;
use super::fields::{Fields, Sign, Values};
use super::learners::{ACTOR_CRITIC, Q_LEARNING};
use super::loops::{Loop, Looped, whole};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{self, BodyMethod, CurveMethod, Expr, ExprKind, Limit, SearchWord, Selection, Ty, Word};
use crate::syntax::ast::{self, Block, Field, Name};
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

/// A method as texts name it.
pub(super) struct Known {
    pub(super) name: &'static str,
    /// The loops that it can search.
    pub(super) loops: &'static [Loop],
    /// The fields that only it has; the first must be there.
    pub(super) fields: &'static [&'static str],
    /// Those of them that are blocks.
    pub(super) blocks: &'static [&'static str],
}

/// All methods. A new one stands here, in the enumerations of `ir/search.rs` that say which loop has it, and in a
/// function below.
pub(super) const METHODS: &[Known] = &[
    Known {
        name: "annealing",
        loops: &[Loop::Bodies, Loop::Curves],
        fields: &["temperature", "walk", "chains", "exchange"],
        blocks: &[],
    },
    Known { name: "archive", loops: &[Loop::Bodies], fields: &["descriptors"], blocks: &["descriptors"] },
    Known {
        name: "population",
        loops: &[Loop::Bodies],
        fields: &["size", "tournament", "further", "side_by_side", "restart"],
        blocks: &[],
    },
    Known {
        name: "front",
        loops: &[Loop::Bodies],
        fields: &["size", "tournament", "further", "side_by_side"],
        blocks: &[],
    },
    Known { name: "cma_es", loops: &[Loop::Curves], fields: &["spread", "restart"], blocks: &[] },
    Known { name: "soft_actor_critic", loops: &[Loop::Curves], fields: ACTOR_CRITIC, blocks: &[] },
    Known { name: "double_dqn", loops: &[Loop::Curves], fields: Q_LEARNING, blocks: &[] },
];

const DESCRIPTOR: Fields<'static> = Fields::values(&["value", "from", "to", "cells"]);

/// A descriptor as it may stand in a text.
const EXAMPLE: &str = "size { value = count(part)  from = 0  to = 20  cells = 10 }";

/// More chains or moves of a walk than this are a slip of the keyboard.
const MOST: f64 = 10_000.0;
/// With more moves side by side a search would hardly select any more.
const MOST_SIDE_BY_SIDE: f64 = 64.0;
/// More cells than this never fill.
const MOST_CELLS: f64 = 100_000.0;

impl Declarations<'_> {
    /// The method of a loop over bodies, by its name.
    pub(super) fn body_method(&mut self, name: &str, from: &Values<'_>, damaged: bool) -> Option<BodyMethod> {
        match name {
            "annealing" => self.annealing(from, damaged).map(BodyMethod::Annealing),
            "archive" => self.archive(from, damaged).map(BodyMethod::Archive),
            "population" => self.population(from, damaged).map(BodyMethod::Population),
            "front" => self.front(from, damaged).map(BodyMethod::Front),
            _ => None,
        }
    }

    /// The method of a loop over curves, by its name.
    pub(super) fn curve_method(
        &mut self,
        name: &str,
        from: &Values<'_>,
        damaged: bool,
    ) -> Option<CurveMethod> {
        match name {
            "annealing" => self.annealing(from, damaged).map(CurveMethod::Annealing),
            "cma_es" => self.cma_es(from, damaged).map(CurveMethod::CmaEs),
            "soft_actor_critic" => self.actor_critic(from, damaged).map(CurveMethod::ActorCritic),
            "double_dqn" => self.q_learning(from, damaged).map(CurveMethod::QLearning),
            _ => None,
        }
    }

    fn annealing(&mut self, from: &Values<'_>, damaged: bool) -> Option<ir::Annealing> {
        let cx = Context::new(Stage::Declaration, damaged);
        let temperature =
            self.scheduled(from, "temperature", &Ty::NUMBER, "9 / (1 + 0.1 * iteration)", damaged);
        let given = |name: &str| from.values.contains_key(name);
        let walk = given("walk").then(|| self.counted(from, "walk", "50", 2.0..=MOST, &cx));
        let chains = given("chains").then(|| self.counted(from, "chains", "4", 1.0..=MOST, &cx));
        let exchange =
            given("exchange").then(|| self.scheduled(from, "exchange", &Ty::Bool, "true", damaged));
        Some(ir::Annealing {
            temperature: temperature?,
            walk: whole(walk)?,
            chains: whole(chains)?,
            exchange: whole(exchange)?.map(Box::new),
        })
    }

    fn cma_es(&mut self, from: &Values<'_>, damaged: bool) -> Option<ir::CmaEs> {
        let cx = Context::new(Stage::Declaration, damaged);
        let spread = self.number(from, "spread", Dimension::NUMBER, Sign::Positive, "30 %", &cx);
        if let (Some(spread), Some((_, tree))) = (spread, from.values.get("spread")) {
            self.usual("a search", "spread", spread, tree);
        }
        let restart = self.restart(from, "spread < 1 %", damaged);
        Some(ir::CmaEs { spread: spread?, restart: restart? })
    }

    /// When a method begins anew, if it says so.
    fn restart(&mut self, from: &Values<'_>, example: &str, damaged: bool) -> Option<Option<Expr>> {
        let given = from.values.contains_key("restart");
        whole(given.then(|| self.scheduled(from, "restart", &Ty::Bool, example, damaged)))
    }

    fn population(&mut self, from: &Values<'_>, damaged: bool) -> Option<ir::Population> {
        let selection = self.selection(from, Selection::limits(false), damaged);
        let restart = self.restart(from, "idle >= 50", damaged);
        Some(ir::Population { selection: selection?, restart: restart? })
    }

    fn front(&mut self, from: &Values<'_>, damaged: bool) -> Option<ir::Front> {
        Some(ir::Front { selection: self.selection(from, Selection::limits(true), damaged)? })
    }

    fn selection(&mut self, from: &Values<'_>, limits: [Limit; 3], damaged: bool) -> Option<Selection> {
        let [size, tournament, further] = limits.map(|limit| {
            let ty = if limit.name == "further" { Ty::NUMBER } else { Ty::Count };
            let value = self.scheduled(from, limit.name, &ty, limit.example, damaged)?;
            let plain = self.expressions.quiet_number(&value);
            let Some(why) = plain.and_then(|plain| limit.excludes(plain, plain)) else { return Some(value) };
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, value.span, why)
                    .label("outside this range")
                    .help(format!("write for example `{} = {}`", limit.name, limit.example)),
            );
            None
        });
        let cx = Context::new(Stage::Declaration, damaged);
        let given = from.values.contains_key("side_by_side");
        let side_by_side =
            given.then(|| self.counted(from, "side_by_side", "4", 1.0..=MOST_SIDE_BY_SIDE, &cx));
        Some(Selection {
            size: size?,
            tournament: tournament?,
            further: further?,
            side_by_side: whole(side_by_side)?,
        })
    }

    fn archive(&mut self, from: &Values<'_>, damaged: bool) -> Option<ir::Archive> {
        let Some(block) = from.groups.get("descriptors").copied() else {
            if !damaged && !from.misspelt.iter().any(|m| m == "descriptors") {
                self.report(
                    Diagnostic::new(
                        Code::MISSING_FIELD,
                        from.place(),
                        "this archive cannot distinguish kinds of designs",
                    )
                    .label("without descriptors")
                    .help(format!("add `descriptors {{ {EXAMPLE} }}`")),
                );
            }
            return None;
        };
        Some(ir::Archive { descriptors: self.descriptors(block, damaged)? })
    }

    /// What tells kinds of designs apart: a block of descriptors, by names of the grammar's own.
    fn descriptors(&mut self, block: &Block, damaged: bool) -> Option<IndexMap<String, ir::Descriptor>> {
        if let Some(word) = &block.method {
            self.no_method(&block.name, word);
        }
        let mut found = IndexMap::new();
        let mut is_fine = true;
        for field in &block.fields {
            let group = match field {
                Field::Group(group) => group,
                Field::Value(name, _) => {
                    is_fine = false;
                    self.not_a_descriptor(name);
                    continue;
                }
                Field::Param(param) => {
                    is_fine = false;
                    self.not_a_descriptor(&param.name);
                    continue;
                }
                Field::Port(port) => {
                    is_fine = false;
                    self.not_a_descriptor(&port.name);
                    continue;
                }
                Field::Joint(joint) => {
                    is_fine = false;
                    self.not_a_descriptor(&joint.named());
                    continue;
                }
            };
            let descriptor = self.descriptor(group, damaged);
            is_fine &= descriptor.is_some();
            if found.contains_key(&group.name.text) {
                self.report(
                    Diagnostic::new(
                        Code::DUPLICATE,
                        group.name.span,
                        format!("`{}` is given twice", group.name.text),
                    )
                    .label("again")
                    .help("keep one of them"),
                );
            }
            found.extend(descriptor.map(|descriptor| (group.name.text.clone(), descriptor)));
        }
        if block.fields.is_empty() && !damaged {
            self.report(
                Diagnostic::new(
                    Code::MISSING_FIELD,
                    block.name.span,
                    "this archive cannot distinguish kinds of designs",
                )
                .label("without descriptors")
                .help(format!("add a line such as `{EXAMPLE}`")),
            );
            return None;
        }
        let cells: f64 = found.values().map(|kind| kind.cells as f64).product();
        if cells > MOST_CELLS {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, block.name.span, "this archive has too many cells")
                    .label(format!("{cells} of them"))
                    .help(format!("at most {MOST_CELLS}: use fewer descriptors or cells")),
            );
            return None;
        }
        is_fine.then_some(found)
    }

    fn not_a_descriptor(&mut self, name: &Name) {
        self.report(
            Diagnostic::new(Code::UNKNOWN_FIELD, name.span, "a descriptor must be a block, not a value")
                .label("not a block")
                .help(format!("write for example `{EXAMPLE}`")),
        );
    }

    fn descriptor(&mut self, block: &Block, damaged: bool) -> Option<ir::Descriptor> {
        let cx = Context::new(Stage::Declaration, damaged);
        let from = self.values(block, "a descriptor", DESCRIPTOR);
        let value = match from.values.get("value") {
            Some((_, tree)) => Some(self.described(tree, damaged)?),
            None => {
                self.missing(&from, "value", "count(part)", damaged);
                None
            }
        };
        let ty = value.as_ref().map_or(Ty::NUMBER, |value| scale(&value.ty));
        let low = self.value(&from, "from", &ty, "0", &cx);
        let high = self.value(&from, "to", &ty, "20", &cx);
        let cells = self.number(&from, "cells", Ty::Count, Sign::Positive, "10", &cx);
        let ((low, _), (high, place)) = (low?, high?);
        let (low, high) = (low.as_number()?, high.as_number()?);
        if high <= low {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, place, "`to` must be above `from`")
                    .label(format!("this is {}", crate::types::expressions::shown(high, &ty)))
                    .help(format!("`from` is {}", crate::types::expressions::shown(low, &ty))),
            );
            return None;
        }
        Some(ir::Descriptor { value: value?, from: low, to: high, cells: cells? as usize })
    }

    /// What describes a design: any quantity of its motion or of itself.
    fn described(&mut self, tree: &ast::Expr, damaged: bool) -> Option<Expr> {
        let value = self.expressions.infer(tree, &mut Context::new(Stage::Score, damaged));
        match value.ty {
            Ty::Quantity(_) | Ty::Count | Ty::Bool => Some(value),
            Ty::Unknown => None,
            _ => {
                self.report(
                    Diagnostic::new(Code::WRONG_TYPE, tree.span, "a descriptor must be a quantity")
                        .label(format!("this is {}", value.ty))
                        .help("write for example `value = count(part)`"),
                );
                None
            }
        }
    }

    /// Words that have no value with the method of this loop.
    pub(super) fn words_of(&mut self, Looped { which, schedule, method }: &Looped<'_>) {
        let mut found = Vec::new();
        for expr in schedule.exprs().into_iter().chain(method.scheduled()) {
            expr.any(&mut |e| {
                let ExprKind::Word(Word::Search(word)) = e.kind else { return false };
                let lacks = match word {
                    SearchWord::Tuned if *which == Loop::Bodies => Some((
                        "`tuned` can be read only in a loop over curves",
                        "read `tuned` within `curves METHOD { ... }`",
                    )),
                    SearchWord::Parent if *which == Loop::Bodies => Some((
                        "only a loop over curves concerns a single body, which has a parent",
                        "read `parent` within `curves METHOD { ... }`",
                    )),
                    _ if method.has(word) => None,
                    SearchWord::Deviation => {
                        Some(("`deviation` needs a random walk, but this search has none", "add `walk = 50`"))
                    }
                    SearchWord::Spread => Some((
                        "`spread` can be read only in `cma_es`",
                        "write `temperature` here, or search by `cma_es` with `spread = 30 %`",
                    )),
                    _ => Some(("`temperature` and `chain` can be read only in annealing", "leave it out")),
                };
                found.extend(lacks.map(|lacks| (e.span, lacks)));
                false
            });
        }
        for (place, (message, help)) in found {
            self.report(Diagnostic::new(Code::BAD_SCHEDULE, place, message).label("has no value").help(help));
        }
    }
}

/// The type of the ends of a descriptor's range.
fn scale(value: &Ty) -> Ty {
    if let Ty::Quantity(_) = value { value.clone() } else { Ty::NUMBER }
}
