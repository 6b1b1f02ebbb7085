//! Checks searches: their loops, and how long each goes on. What each searches by is in `methods.rs`.

use std::ops::RangeInclusive;

use super::Declarations;
use super::fields::{Fields, Sign, Values};
use super::loops::{Loop, Looped, whole};
use super::methods::{Known, METHODS};
use crate::diagnostics::{Code, Diagnostic, Fix, did_you_mean, respell};
use crate::eval::Value;
use crate::ir::{self, Expr, Judge, Ty};
use crate::source::Span;
use crate::syntax::ast::{self, Block, Field, Name};
use crate::syntax::earlier;
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

const SEARCH: Fields<'static> =
    Fields { all: &[KEEP, KEEP_WITH_RODS, "checks", "bodies", "curves"], blocks: &["bodies", "curves"] };
const KEEP: &str = "keep";
const KEEP_WITH_RODS: &str = "keep_with_rods";
const SCHEDULE: &[&str] = &["iterations", "moves", "stop"];

impl Loop {
    const ALL: [Self; 2] = [Self::Bodies, Self::Curves];

    fn word(self) -> &'static str {
        match self {
            Self::Bodies => "bodies",
            Self::Curves => "curves",
        }
    }

    fn methods(self) -> impl Iterator<Item = &'static Known> {
        METHODS.iter().filter(move |method| method.loops.contains(&self))
    }

    /// The fields that every method of this loop has.
    fn shared(self) -> Vec<&'static str> {
        let own: &[&str] = if self == Self::Curves { &["warm", "judge"] } else { &[] };
        [SCHEDULE, own].concat()
    }
}

/// A search that asks a best to keep less of its value than this selects errors of the simulation.
const LEAST_KEPT: f64 = 0.2;

impl Declarations<'_> {
    pub(super) fn search(&mut self, block: &Block, damaged: bool) -> Option<ir::Search> {
        let cx = Context::new(Stage::Declaration, damaged);
        let block = self.renamed(block);
        let from = self.values(&block, "a search", SEARCH);
        let keep = self.number(&from, KEEP, Dimension::NUMBER, Sign::NotNegative, "80 %", &cx);
        self.check_share(&from, KEEP, "80 %", keep);
        self.check_usual_share(&from, keep);
        let with_rods = from.values.contains_key(KEEP_WITH_RODS).then(|| {
            let keep = self.number(&from, KEEP_WITH_RODS, Dimension::NUMBER, Sign::NotNegative, "50 %", &cx);
            self.check_share(&from, KEEP_WITH_RODS, "50 %", keep);
            self.check_usual_share_with_rods(&from, keep);
            keep
        });
        let checks = from.values.get("checks").map(|(_, tree)| self.checks(tree));
        let group = |which: Loop| from.groups.get(which.word()).copied();
        if Loop::ALL.iter().all(|which| group(*which).is_none()) {
            let known = |which: &Loop| from.misspelt.iter().any(|m| m == which.word());
            if !damaged && !Loop::ALL.iter().any(known) {
                self.report(
                    Diagnostic::new(
                        Code::MISSING_FIELD,
                        block.name.span,
                        format!("`{}` has neither `bodies` nor `curves`", block.name.text),
                    )
                    .label("without a loop")
                    .help("add `bodies annealing { iterations = ...  moves = ...  temperature = ...  stop = ... }`"),
                );
            }
            return None;
        }
        let bodies = group(Loop::Bodies).map(|block| self.body_loop(block, damaged));
        let curves = group(Loop::Curves).map(|block| self.curve_loop(block, damaged));
        let search = ir::Search {
            name: block.name.text.clone(),
            keep: keep?,
            keep_with_rods: whole(with_rods)?,
            checks: whole(checks)?,
            bodies: whole(bodies)?,
            curves: whole(curves)?,
        };
        if search.curves.is_none() && search.selection().is_some_and(|selection| !is_zero(&selection.further))
        {
            let place = group(Loop::Bodies).map_or(block.name.span, |bodies| bodies.name.span);
            self.report(
                Diagnostic::new(
                    Code::BAD_SCHEDULE,
                    place,
                    "`further` asks for moves that tune curves, but this search does not tune curves",
                )
                .label("this loop has `further`")
                .help("write `further = 0 %`, or add `curves METHOD { ... }`"),
            );
            return None;
        }
        Some(search)
    }

    /// A share of a value lies within 0 % and 100 %.
    fn check_share(&mut self, from: &Values<'_>, name: &str, example: &str, share: Option<f64>) {
        if let (Some(share), Some((_, tree))) = (share, from.values.get(name))
            && share > 1.0
        {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    format!("`{name}` is a share: it must lie within 0 % .. 100 %"),
                )
                .label("too much")
                .help(format!("write for example `{name} = {example}`")),
            );
        }
    }

    /// Warns of a share with which a check at half the step says nothing, or refuses nearly everything.
    fn check_usual_share(&mut self, from: &Values<'_>, keep: Option<f64>) {
        let (Some(keep), Some((_, tree))) = (keep, from.values.get(KEEP)) else { return };
        let (message, label, help) = if keep < LEAST_KEPT {
            (
                "with this `keep`, the best design may lose nearly all of its value at half the step",
                "so no check can fail",
                "write `keep = 80 %`: otherwise the search exploits the errors of the simulation",
            )
        } else if keep == 1.0 {
            (
                "with this `keep`, a best design must lose nothing at half the step",
                "hardly any design passes",
                "write `keep = 80 %`: a shorter step always changes a motion a little",
            )
        } else {
            return;
        };
        self.report(Diagnostic::new(Code::UNUSUAL, tree.span, message).label(label).help(help));
    }

    /// Warns of a share with which a check with elastic rods says nothing.
    fn check_usual_share_with_rods(&mut self, from: &Values<'_>, keep: Option<f64>) {
        let (Some(keep), Some((_, tree))) = (keep, from.values.get(KEEP_WITH_RODS)) else { return };
        if keep < LEAST_KEPT {
            self.report(
                Diagnostic::new(
                    Code::UNUSUAL,
                    tree.span,
                    "with this `keep_with_rods`, a best design may lose nearly all of its value with elastic rods",
                )
                .label("so no check can fail, but each costs a simulation")
                .help("write `keep_with_rods = 50 %`, or leave the line out"),
            );
        }
    }

    fn body_loop(&mut self, block: &Block, damaged: bool) -> Option<ir::BodyLoop> {
        let (name, from) = self.looped(block, Loop::Bodies, damaged)?;
        let schedule = self.schedule(&from, damaged);
        let method = self.body_method(name, &from, damaged);
        let looped = ir::BodyLoop { schedule: schedule?, method: method? };
        self.words_of(&Looped { which: Loop::Bodies, schedule: &looped.schedule, method: looped.method() });
        Some(looped)
    }

    fn curve_loop(&mut self, block: &Block, damaged: bool) -> Option<ir::CurveLoop> {
        let (name, from) = self.looped(block, Loop::Curves, damaged)?;
        let cx = Context::new(Stage::Declaration, damaged);
        let schedule = self.schedule(&from, damaged);
        let warm =
            from.values.contains_key("warm").then(|| self.value(&from, "warm", &Ty::Bool, "true", &cx));
        let method = self.curve_method(name, &from, damaged);
        let warm = whole(warm)?.is_some_and(|(warm, _)| warm == Value::Bool(true));
        let judge = whole(from.values.get("judge").map(|(_, tree)| self.judge(tree)))?;
        let looped = ir::CurveLoop { schedule: schedule?, warm, judge, method: method? };
        self.words_of(&Looped { which: Loop::Curves, schedule: &looped.schedule, method: looped.method() });
        Some(looped)
    }

    /// Which curves are judged in all worlds.
    fn judge(&mut self, tree: &ast::Expr) -> Option<Judge> {
        let word = if let ast::ExprKind::Name(word) = &tree.kind { word.as_str() } else { "" };
        let found = Judge::ALL.into_iter().find(|judge| judge.text() == word);
        if found.is_none() {
            let words = Judge::ALL.map(Judge::text);
            self.report(
                Diagnostic::new(Code::BAD_VALUE, tree.span, "`judge` must be `every`, `promising` or `best`")
                    .label("not one of these")
                    .help("write for example `judge = promising`")
                    .fix_if(respell(tree.span, word, words)),
            );
        }
        found
    }

    /// The worlds that a best is tried in, by the name of their set.
    fn checks(&mut self, tree: &ast::Expr) -> Option<ir::Within> {
        let ast::ExprKind::Name(name) = &tree.kind else {
            self.report(
                Diagnostic::new(Code::BAD_VALUE, tree.span, "`checks` is the name of a set of worlds")
                    .label("not a name")
                    .help("write for example `checks = cross_checks`, which `std.scenarios` has"),
            );
            return None;
        };
        let name = Name { text: name.clone(), span: tree.span };
        self.set_of_worlds(&name).then_some(ir::Within { name: name.text, span: name.span })
    }

    /// The method of a loop and its fields. Fields of other methods are told.
    fn looped<'b>(
        &mut self,
        block: &'b Block,
        which: Loop,
        damaged: bool,
    ) -> Option<(&'static str, Values<'b>)> {
        let method = self.method_of(block, which, damaged)?;
        let what = match which {
            Loop::Bodies => "the loop over bodies",
            Loop::Curves => "the loop over curves",
        };
        let all = [which.shared().as_slice(), method.fields].concat();
        let allowed = Fields { all: &all, blocks: method.blocks };
        let elsewhere = |name: &str| {
            let is_own = method.fields.contains(&name);
            METHODS.iter().find(|other| !is_own && other.fields.contains(&name))
        };
        for field in &block.fields {
            let (Field::Value(name, _) | Field::Group(Block { name, .. })) = field else { continue };
            let Some(other) = elsewhere(&name.text) else {
                continue;
            };
            self.foreign(name, block, method, other);
        }
        let fields = block.fields.iter().filter(|field| match field {
            Field::Value(name, _) | Field::Group(Block { name, .. }) => elsewhere(&name.text).is_none(),
            Field::Param(_) | Field::Port(_) | Field::Joint(_) => true,
        });
        let from = self.values_among(block, fields, what, allowed);
        Some((method.name, from))
    }

    /// A field of another method would not be read.
    fn foreign(&mut self, name: &Name, block: &Block, method: &Known, other: &Known) {
        let place = block.method.as_ref().map_or(block.name.span, |method| method.span);
        self.report(
            Diagnostic::new(
                Code::BAD_SCHEDULE,
                name.span,
                format!(
                    "`{}` belongs to `{}`, but this loop searches by `{}`",
                    name.text, other.name, method.name
                ),
            )
            .label("would not be read")
            .also(place, "this says how the loop searches")
            .help("keep one of the two"),
        );
    }

    /// The method that a loop names.
    fn method_of(&mut self, block: &Block, which: Loop, damaged: bool) -> Option<&'static Known> {
        let names: Vec<&str> = which.methods().map(|method| method.name).collect();
        let loops = which.word();
        let Some(name) = &block.method else {
            if !damaged {
                let told = Diagnostic::new(
                    Code::MISSING_FIELD,
                    block.name.span,
                    format!("`{loops}` does not name its search method"),
                )
                .label("a method must follow")
                .help(format!("write `{loops} METHOD {{`, where METHOD is one of: {}", names.join(", ")));
                let fix = meant(block, which).map(|method| {
                    Fix::insert_after(
                        block.name.span,
                        format!(" {method}"),
                        format!("write `{loops} {method}`"),
                    )
                });
                self.report(told.fix_if(fix));
            }
            return None;
        };
        let found = which.methods().find(|method| method.name == name.text);
        if found.is_none() {
            let message = format!("there is no method `{}` for the loop over {loops}", name.text);
            let help = did_you_mean(&name.text, names.iter().copied())
                .unwrap_or_else(|| format!("the methods are: {}", names.join(", ")));
            self.report(
                Diagnostic::new(Code::UNKNOWN_FIELD, name.span, message)
                    .label("not one of its methods")
                    .help(help)
                    .fix_if(respell(name.span, &name.text, names)),
            );
        }
        found
    }

    fn schedule(&mut self, from: &Values<'_>, damaged: bool) -> Option<ir::Schedule> {
        let iterations = self.scheduled(from, "iterations", &Ty::Count, "100", damaged);
        let moves = self.scheduled(from, "moves", &Ty::Count, "3", damaged);
        let stop = self.scheduled(from, "stop", &Ty::Bool, "idle >= 5", damaged);
        Some(ir::Schedule { iterations: iterations?, moves: moves?, stop: stop? })
    }

    /// An expression of the schedule's stage.
    pub(super) fn scheduled(
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
        let known = self.expressions.errors.len();
        let value = self.expressions.expect(tree, &mut cx, ty, &format!("`{name}`"));
        self.show_example(known, tree.span, name, example);
        Some(value)
    }

    /// A number of things that is known before the search begins.
    pub(super) fn counted(
        &mut self,
        from: &Values<'_>,
        name: &str,
        example: &str,
        within: RangeInclusive<f64>,
        cx: &Context,
    ) -> Option<usize> {
        let n = self.number(from, name, Ty::Count, Sign::NotNegative, example, cx)?;
        if within.contains(&n) {
            return Some(n as usize);
        }
        if let Some((_, tree)) = from.values.get(name) {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    format!("`{name}` must lie within {} .. {}", within.start(), within.end()),
                )
                .label(format!("this is {n}"))
                .help(format!("write for example `{name} = {example}`")),
            );
        }
        None
    }

    /// A search as it is written now: loops that are called as in earlier versions are told, with a fix, and read as
    /// they were meant.
    fn renamed(&mut self, block: &Block) -> Block {
        let mut block = block.clone();
        for field in &mut block.fields {
            let Field::Group(group) = field else { continue };
            let Some(which) =
                Loop::ALL.into_iter().find(|which| earlier::loop_now(&group.name.text) == Some(which.word()))
            else {
                continue;
            };
            self.renamed_loop(group, which);
        }
        block
    }

    fn renamed_loop(&mut self, group: &mut Block, which: Loop) {
        let method = meant(group, which).unwrap_or("annealing");
        let new = format!("{} {method}", which.word());
        let mut fix = Fix::replace(group.name.span, &new, format!("write `{new} {{ ... }}`"));
        let mut is_sure = true;
        let mut fields = Vec::with_capacity(group.fields.len());
        for field in group.fields.drain(..) {
            match field {
                Field::Group(mut archive) if archive.name.text == earlier::DESCRIPTORS => {
                    fix = fix.and(archive.name.span, "descriptors");
                    archive.name.text = "descriptors".to_owned();
                    fields.push(Field::Group(archive));
                }
                Field::Group(inner) if inner.name.text == earlier::EVOLUTION => {
                    match self.braces(&inner) {
                        Some([open, close]) => fix = fix.and(open, "").and(close, ""),
                        None => is_sure = false,
                    }
                    fields.extend(inner.fields);
                }
                other => fields.push(other),
            }
        }
        self.report(
            Diagnostic::new(
                Code::UNKNOWN_FIELD,
                group.name.span,
                format!("a search has no `{}`", group.name.text),
            )
            .label(format!("it is called `{}` now, and names its method", which.word()))
            .help(format!("write `{new} {{ ... }}`"))
            .fix_if(is_sure.then_some(fix)),
        );
        group.fields = fields;
        group.name.text = which.word().to_owned();
        group.method = Some(Name { text: method.to_owned(), span: group.name.span });
    }

    /// The name of a block with its opening bracket, and the closing one, where nothing but spaces is between
    /// those and the fields.
    fn braces(&self, block: &Block) -> Option<[Span; 2]> {
        let file = block.name.span.file;
        let text = &self.environment.sources.get(file)?.text;
        let [Field::Value(..), ..] = block.fields.as_slice() else { return None };
        let Some(Field::Value(_, last)) = block.fields.last() else { return None };
        let from = block.name.span.range();
        let open = text.get(from.end..)?.find(|c: char| !c.is_whitespace())? + from.end;
        let close =
            text.get(last.span.range().end..)?.find(|c: char| !c.is_whitespace())? + last.span.range().end;
        (text.get(open..=open)? == "{" && text.get(close..=close)? == "}")
            .then(|| [Span::new(file, from.start, open + 1), Span::new(file, close, close + 1)])
    }
}

/// Whether an expression is a plain zero.
fn is_zero(expr: &Expr) -> bool {
    matches!(expr.kind, ir::ExprKind::Number(0.0))
}

/// The method that a loop is meant to have, by a field that only this method has.
fn meant(block: &Block, which: Loop) -> Option<&'static str> {
    let given = |field: &str| {
        block.fields.iter().any(|known| match known {
            Field::Value(name, _) | Field::Group(Block { name, .. }) => name.text == field,
            Field::Param(_) | Field::Port(_) | Field::Joint(_) => false,
        })
    };
    // Earlier texts have a block that is called as the method.
    let mut meant = which
        .methods()
        .filter(|method| given(method.name) || method.fields.first().is_some_and(|field| given(field)));
    meant.next().filter(|_| meant.next().is_none()).map(|method| method.name)
}
