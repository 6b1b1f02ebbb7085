//! Checks searches: their loops, and how each draws and keeps candidates.

use indexmap::IndexMap;

use super::Checker;
use super::expr::Context;
use super::fields::{Sign, Values};
use super::stage::Stage;
use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Value;
use crate::ir::{self, Expr, ExprKind, Ty, Word};
use crate::syntax::ast::{self, Block, Field, Name};

const SEARCH: &[&str] = &["keep", "outer", "inner"];
const SCHEDULE: &[&str] = &["iterations", "moves", "temperature", "stop", "walk", "chains", "exchange"];
const CMA_ES: &[&str] = &["spread", "restart"];
const DESCRIPTOR: &[&str] = &["value", "from", "to", "cells"];

/// More chains or moves of a walk than this are a slip of the keyboard.
const MOST: f64 = 10_000.0;
/// More cells than this never fill.
const MOST_CELLS: f64 = 100_000.0;

/// Which loop of a search a schedule belongs to.
#[derive(Clone, Copy, PartialEq)]
enum Loop {
    Outer,
    Inner,
}

impl Checker<'_> {
    pub(super) fn search(&mut self, block: &Block, damaged: bool) -> Option<ir::Search> {
        let cx = Context::new(Stage::Declaration, damaged);
        let from = self.values(block, "a search", SEARCH);
        let keep = self.number(&from, "keep", "Number", Sign::NotNegative, "80 %", &cx);
        if let (Some(keep), Some((_, tree))) = (keep, from.values.get("keep"))
            && keep > 1.0
        {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    "`keep` is a share: it must lie within 0 % .. 100 %",
                )
                .label("too much")
                .help("write for example `keep = 80 %`"),
            );
        }
        let Some(outer) = from.groups.get("outer").copied() else {
            if !damaged && !from.misspelt.iter().any(|m| m == "outer") {
                self.report(
                    Diagnostic::new(
                        Code::MISSING_FIELD,
                        block.name.span,
                        format!("`{}` has no `outer` schedule", block.name.text),
                    )
                    .label("a search needs it")
                    .help("add `outer { iterations = ...  moves = ...  temperature = ...  stop = ... }`"),
                );
            }
            return None;
        };
        let outer = self.schedule(outer, Loop::Outer, damaged);
        let inner = from.groups.get("inner").map(|inner| self.schedule(inner, Loop::Inner, damaged));
        let inner = match inner {
            Some(inner) => Some(inner?),
            None => None,
        };
        Some(ir::Search { name: block.name.text.clone(), keep: keep?, outer: outer?, inner })
    }

    fn schedule(&mut self, block: &Block, which: Loop, damaged: bool) -> Option<ir::Schedule> {
        let own = if which == Loop::Outer { "archive" } else { "cma_es" };
        let mut allowed = SCHEDULE.to_vec();
        allowed.push(own);
        if which == Loop::Inner {
            allowed.push("warm");
        }
        let what = if which == Loop::Outer { "the outer loop" } else { "the inner loop" };
        let from = self.values(block, what, &allowed);
        let other = from.groups.get(own).copied();
        let iterations = self.scheduled(&from, "iterations", &Ty::Count, "100", damaged);
        let moves = self.scheduled(&from, "moves", &Ty::Count, "3", damaged);
        let stop = self.scheduled(&from, "stop", &Ty::Bool, "idle >= 5", damaged);
        let cx = Context::new(Stage::Declaration, damaged);
        let is_fine = match other {
            Some(other) => self.only_annealing(&from, other),
            None => true,
        };
        let temperature = match other {
            Some(_) => None,
            None => Some(self.scheduled(
                &from,
                "temperature",
                &Ty::NUMBER,
                "9 / (1 + 0.1 * iteration)",
                damaged,
            )?),
        };
        let given = |name: &str| from.values.contains_key(name);
        let walk = given("walk").then(|| self.counted(&from, "walk", "50", 2.0, &cx));
        let chains = given("chains").then(|| self.counted(&from, "chains", "4", 1.0, &cx));
        let exchange =
            given("exchange").then(|| self.scheduled(&from, "exchange", &Ty::Bool, "true", damaged));
        let warm = given("warm").then(|| self.value(&from, "warm", &Ty::Bool, "true", &cx));
        let cma_es = match (which, other) {
            (Loop::Inner, Some(other)) => Some(self.cma_es(other, damaged)?),
            _ => None,
        };
        let archive = match (which, other) {
            (Loop::Outer, Some(other)) => Some(self.archive(other, damaged)?),
            _ => None,
        };
        let schedule = ir::Schedule {
            iterations: iterations?,
            moves: moves?,
            temperature,
            stop: stop?,
            walk: whole(walk)?,
            chains: whole(chains)?,
            exchange: whole(exchange)?,
            warm: whole(warm)?.is_some_and(|(warm, _)| warm == Value::Bool(true)),
            cma_es,
            archive,
        };
        self.words_of(&schedule);
        is_fine.then_some(schedule)
    }

    /// An expression of the schedule's stage.
    fn scheduled(
        &mut self,
        from: &Values<'_>,
        name: &str,
        ty: &Ty,
        example: &str,
        damaged: bool,
    ) -> Option<Expr> {
        let Some((_, tree)) = from.values.get(name) else {
            self.missing(from, name, example, damaged);
            return None;
        };
        let mut cx = Context::new(Stage::Schedule, damaged);
        let known = self.errors.len();
        let value = self.expect(tree, &mut cx, ty, &format!("`{name}`"));
        self.show_example(known, tree.span, name, example);
        Some(value)
    }

    /// A number of things that is known before the search begins.
    fn counted(
        &mut self,
        from: &Values<'_>,
        name: &str,
        example: &str,
        least: f64,
        cx: &Context,
    ) -> Option<usize> {
        let n = self.number(from, name, "Count", Sign::NotNegative, example, cx)?;
        if (least..=MOST).contains(&n) {
            return Some(n as usize);
        }
        if let Some((_, tree)) = from.values.get(name) {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    format!("`{name}` must lie within {least} .. {MOST}"),
                )
                .label(format!("this is {n}"))
                .help(format!("write for example `{name} = {example}`")),
            );
        }
        None
    }

    /// What belongs to annealing has no meaning beside another method.
    fn only_annealing(&mut self, from: &Values<'_>, other: &Block) -> bool {
        let known = self.errors.len();
        for name in ["temperature", "walk", "chains", "exchange"] {
            let Some((field, _)) = from.values.get(name) else { continue };
            self.report(
                Diagnostic::new(
                    Code::BAD_SCHEDULE,
                    field.span,
                    format!("`{name}` belongs to annealing, but `{}` stands in its place", other.name.text),
                )
                .label("would not be read")
                .also(other.name.span, "this says how the loop searches")
                .help("keep one of the two"),
            );
        }
        self.errors.len() == known
    }

    fn cma_es(&mut self, block: &Block, damaged: bool) -> Option<ir::CmaEs> {
        let cx = Context::new(Stage::Declaration, damaged);
        let from = self.values(block, "`cma_es`", CMA_ES);
        let spread = self.number(&from, "spread", "Number", Sign::Positive, "30 %", &cx);
        let restart = from
            .values
            .contains_key("restart")
            .then(|| self.scheduled(&from, "restart", &Ty::Bool, "spread < 1 %", damaged));
        Some(ir::CmaEs { spread: spread?, restart: whole(restart)? })
    }

    /// The kinds of designs of which the best is kept: a block of descriptors, by names of the grammar's own.
    fn archive(&mut self, block: &Block, damaged: bool) -> Option<IndexMap<String, ir::Descriptor>> {
        let mut found = IndexMap::new();
        let mut is_fine = true;
        let example = "size { value = count(part)  from = 0  to = 20  cells = 10 }";
        for field in &block.fields {
            let group = match field {
                Field::Group(group) => group,
                Field::Value(name, _) => {
                    is_fine = false;
                    self.not_a_descriptor(name, example);
                    continue;
                }
                Field::Param(param) => {
                    is_fine = false;
                    self.not_a_descriptor(&param.name, example);
                    continue;
                }
                Field::Port(port) => {
                    is_fine = false;
                    self.not_a_descriptor(&port.name, example);
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
                Diagnostic::new(Code::MISSING_FIELD, block.name.span, "this archive tells no kinds apart")
                    .label("nothing describes a design")
                    .help(format!("add a line such as `{example}`")),
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

    fn not_a_descriptor(&mut self, name: &Name, example: &str) {
        self.report(
            Diagnostic::new(Code::UNKNOWN_FIELD, name.span, "an archive has descriptors: blocks, no values")
                .label("not a block")
                .help(format!("write for example `{example}`")),
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
        let cells = self.number(&from, "cells", "Count", Sign::Positive, "10", &cx);
        let ((low, _), (high, place)) = (low?, high?);
        let (low, high) = (low.as_number()?, high.as_number()?);
        if high <= low {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, place, "`to` must be above `from`")
                    .label(format!("this is {}", super::shown(high, &ty)))
                    .help(format!("`from` is {}", super::shown(low, &ty))),
            );
            return None;
        }
        Some(ir::Descriptor { value: value?, from: low, to: high, cells: cells? as usize })
    }

    /// What describes a design: any quantity of its motion or of itself.
    fn described(&mut self, tree: &ast::Expr, damaged: bool) -> Option<Expr> {
        let value = self.infer(tree, &mut Context::new(Stage::Score, damaged));
        match value.ty {
            Ty::Quantity(_) | Ty::Count | Ty::Bool => Some(value),
            Ty::Unknown => None,
            _ => {
                self.report(
                    Diagnostic::new(Code::WRONG_TYPE, tree.span, "a descriptor is a quantity")
                        .label(format!("this is {}", value.ty))
                        .help("write for example `value = count(part)`"),
                );
                None
            }
        }
    }

    /// Words that have no value with this schedule.
    fn words_of(&mut self, schedule: &ir::Schedule) {
        let restart = schedule.cma_es.as_ref().and_then(|cma_es| cma_es.restart.as_ref());
        let all = [Some(&schedule.iterations), Some(&schedule.moves), Some(&schedule.stop)]
            .into_iter()
            .chain([schedule.temperature.as_ref(), schedule.exchange.as_ref(), restart]);
        let mut found = Vec::new();
        for expr in all.flatten() {
            expr.any(&mut |e| {
                let ExprKind::Word(word) = e.kind else { return false };
                let lacks = match word {
                    Word::Deviation if schedule.walk.is_none() => {
                        Some(("there is no random walk whose deviation this could be", "add `walk = 50`"))
                    }
                    Word::Spread if schedule.cma_es.is_none() => Some((
                        "only `cma_es` has a spread",
                        "write `temperature` here, or add `cma_es { spread = 30 % }`",
                    )),
                    Word::Temperature | Word::Chain if schedule.temperature.is_none() => {
                        Some(("only annealing has temperatures and chains", "leave it out"))
                    }
                    _ => None,
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

/// What is there must be right; what is not there may be missing.
fn whole<T>(given: Option<Option<T>>) -> Option<Option<T>> {
    match given {
        Some(value) => Some(Some(value?)),
        None => Some(None),
    }
}

/// The type of the ends of a descriptor's range.
fn scale(value: &Ty) -> Ty {
    if let Ty::Quantity(_) = value { value.clone() } else { Ty::NUMBER }
}
