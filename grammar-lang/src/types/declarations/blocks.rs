//! Checks what a rule makes and reads again: blocks that are repeated or done once, the lists of what they make, and values of it.

use super::Declarations;
use super::rules::{bound_by, makers_of};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{self, Expr, ExprKind, Ty};
use crate::source::Span;
use crate::syntax::ast::{self, Name, RuleClause, RuleClauseKind};
use crate::types::expressions::context::{Context, Local};

impl Declarations<'_> {
    /// What a rule does for each of several things.
    pub(super) fn repeat(
        &mut self,
        over: &[ast::Binder],
        clauses: &[RuleClause],
        cx: &mut Context,
    ) -> Option<ir::Effect> {
        let depth = cx.locals.len();
        let is_once = over.is_empty();
        if !is_once {
            self.set_each_time(clauses);
        }
        let over = self.expressions.binders(over, cx);
        let mut effects = self.within_block(clauses, 0, cx);
        let within = cx.locals.split_off(depth);
        let made = self.lists_of_made(clauses, &within, cx);
        if is_once {
            let mut once = effects.pop();
            if let Some(ir::Effect::Repeat { lists, .. }) = &mut once {
                *lists = made;
            }
            return once;
        }
        if clauses.is_empty()
            && let Some(first) = over.first()
        {
            self.report(
                Diagnostic::new(Code::NO_EFFECT, first.over.span, "nothing is repeated")
                    .label("an empty block follows")
                    .help("write effects in the block: `for i in 0 .. 3 { attach ... to core.side[i] }`"),
            );
        }
        Some(ir::Effect::Repeat { over, effects, lists: made })
    }

    /// Reports what sets a parameter of the grammar each time that a block is repeated: each time it reads the same, and only the last counts.
    fn set_each_time(&mut self, clauses: &[RuleClause]) {
        for clause in clauses {
            match &clause.kind {
                RuleClauseKind::Set { target, .. } => {
                    let ast::ExprKind::Name(name) = &target.kind else { continue };
                    let Some((_, item)) = self.environment.program.lookup(target.span, name) else {
                        continue;
                    };
                    if matches!(item.kind, ast::ItemKind::Param(_)) {
                        let message = format!(
                            "`{name}` has one value for the whole body, but this sets it in each repetition"
                        );
                        self.report(
                            Diagnostic::new(Code::BAD_VALUE, clause.span, message)
                                .label("only the last repetition would count")
                                .help("move it out of the block, and calculate its value there (`sum over i in 0 .. 2 of ...`), or give each part a parameter of its own"),
                        );
                    }
                }
                RuleClauseKind::Repeat { over, clauses } if over.is_empty() => self.set_each_time(clauses),
                _ => {}
            }
        }
    }

    /// The lists of what a block makes, by name. What stands below the block can read them.
    fn lists_of_made(
        &mut self,
        clauses: &[RuleClause],
        within: &[Local],
        cx: &mut Context,
    ) -> Vec<ir::MadeList> {
        let mut lists: Vec<ir::MadeList> = Vec::new();
        let mut spans: Vec<Span> = Vec::new();
        for (maker, name) in makers_of(clauses).into_iter().enumerate() {
            let Some(name) = name else { continue };
            if let Some(known) = lists.iter_mut().find(|list| list.name == name.text) {
                known.makers.push(maker);
                continue;
            }
            // What blocks above have made under this name comes first.
            let after = cx.locals.iter().rposition(|local| local.name == name.text && local.may_be_hidden);
            lists.push(ir::MadeList { name: name.text.clone(), makers: vec![maker], after });
            spans.push(name.span);
        }
        for (list, span) in lists.iter().zip(spans) {
            let before = list.after.and_then(|slot| cx.locals.get(slot));
            let same = within.iter().filter(|local| local.name == list.name).chain(before);
            let is_active = |local: &Local| match &local.ty {
                Ty::List(item) => **item == Ty::Actuator,
                ty => *ty == Ty::Actuator,
            };
            let item = if same.clone().all(is_active) { Ty::Actuator } else { Ty::Part };
            let list = Local::new(list.name.clone(), Ty::List(Box::new(item)), span);
            cx.locals.push(Local { may_be_hidden: true, ..list });
        }
        lists
    }

    /// A value that reads what earlier lines make: it is worked out where it stands.
    pub(super) fn late_value(&mut self, name: &Name, value: &ast::Expr, cx: &mut Context) -> ir::Effect {
        let value = self.expressions.infer(value, cx);
        self.expressions.bind(name, value.ty.clone(), cx);
        ir::Effect::Let(value)
    }

    /// What the clauses of a block do from one of them on. A condition holds for all that stands below it: that is done once, or not at
    /// all.
    fn within_block(&mut self, clauses: &[RuleClause], first: usize, cx: &mut Context) -> Vec<ir::Effect> {
        let mut effects = Vec::new();
        for (place, clause) in clauses.iter().enumerate().skip(first) {
            let known = self.expressions.errors.len();
            let once = match &clause.kind {
                RuleClauseKind::Let(name, value) => {
                    effects.push(self.late_value(name, value, cx));
                    self.tell_of_makers(known, clauses, place);
                    if clauses.len() == place + 1 {
                        self.tell_of_nothing_below(clause.span, cx);
                    }
                    continue;
                }
                RuleClauseKind::Guard(positive, condition) => {
                    let what =
                        if *positive { "the condition of this block" } else { "what follows `unless`" };
                    let condition = self.expressions.expect(condition, cx, &Ty::Bool, what);
                    let slot = cx.locals.len();
                    cx.locals.push(Local::new("", Ty::Count, condition.span));
                    ir::Binder { slot, over: once_if(*positive, condition) }
                }
                _ => {
                    self.check_repeatable(clause, cx);
                    effects.extend(self.effect(&clause.kind, cx));
                    self.tell_of_makers(known, clauses, place);
                    continue;
                }
            };
            let rest = self.within_block(clauses, place + 1, cx);
            if rest.is_empty() {
                self.tell_of_nothing_below(clause.span, cx);
            }
            effects.push(ir::Effect::Repeat { over: vec![once], effects: rest, lists: Vec::new() });
            break;
        }
        effects
    }

    fn tell_of_nothing_below(&mut self, span: Span, cx: &Context) {
        if !cx.damaged {
            self.report(
                Diagnostic::new(Code::NO_EFFECT, span, "nothing follows this condition in the block")
                    .label("has no effect")
                    .help("write an effect below it: `attach`, `set`, `remove` or `replace`"),
            );
        }
    }

    /// Reports clauses that say something of the whole rule and stand in a block that is repeated.
    fn check_repeatable(&mut self, clause: &RuleClause, cx: &mut Context) {
        let word = match &clause.kind {
            RuleClauseKind::Match { .. } | RuleClauseKind::MatchNothing => "match",
            RuleClauseKind::Choose(..) => "choose",
            RuleClauseKind::Weight(_) => "weight",
            RuleClauseKind::Revert(_) => "revert",
            RuleClauseKind::Then => "then",
            RuleClauseKind::Always => "always",
            _ => return,
        };
        // What reads its names is not wrong.
        let names: Vec<&Name> = match &clause.kind {
            RuleClauseKind::Match { links, .. } => {
                links.iter().flat_map(|l| [Some(&l.name), l.port.as_ref()]).flatten().collect()
            }
            kind => bound_by(kind).into_iter().collect(),
        };
        names.into_iter().for_each(|name| self.expressions.bind(name, Ty::Unknown, cx));
        let help = match word {
            "choose" => "move it above the block: a rule draws each choice only once",
            "let" => {
                "move it above the block, or write the value where it is used: a `let` of a rule cannot read the names of a block"
            }
            "then" => {
                "end the block before `then`, and begin another one after it: `then` cannot be inside a block"
            }
            _ => "move it out of the block",
        };
        self.report(
            Diagnostic::new(Code::BAD_VALUE, clause.span, format!("`{word}` cannot be inside a block"))
                .label("it is about the whole rule")
                .help(help),
        );
    }
}

/// A range of one number if a condition holds, else of none.
fn once_if(positive: bool, condition: Expr) -> Expr {
    let span = condition.span;
    let count = |kind| Expr { kind, ty: Ty::Count, span };
    let (one, none) = (|| count(ExprKind::Number(1.0)), || count(ExprKind::Number(0.0)));
    let (then, otherwise) = if positive { (one(), none()) } else { (none(), one()) };
    let last = count(ExprKind::If(Box::new(condition), Box::new(then), Box::new(otherwise)));
    let kind = ExprKind::Range(Box::new(one()), Box::new(last));
    Expr { kind, ty: Ty::Domain(Box::new(Ty::Count)), span }
}
