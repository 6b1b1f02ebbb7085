//! Checks examples: rules applied by name, with a value for everything they bind.

use indexmap::{IndexMap, IndexSet};

use super::Declarations;
use super::rules::makers_of;
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::ir::{self, Effect, Expr, ExprKind, Matched, Spread, Ty};
use crate::source::Span;
use crate::syntax::ast::{self, Application, ExampleClause, ItemKind, Name};
use crate::types::expressions::context::{Context, Local};
use crate::types::expressions::stage::Stage;

/// A rule with the types of what it binds.
pub(super) struct Applicable<'r> {
    /// The rule.
    pub(in crate::types) rule: &'r ir::Rule,
    types: Vec<Ty>,
}

/// What example clauses can apply: the rules of the grammar by name.
pub(super) fn applicable<'r>(
    rules: &'r [ir::Rule],
    member_of: &dyn Fn(&ir::Group) -> Ty,
) -> IndexMap<&'r str, Applicable<'r>> {
    let mut known = IndexMap::new();
    for rule in rules {
        // Of two of one name, which is an error, the first one counts.
        known
            .entry(rule.name.as_str())
            .or_insert_with(|| Applicable { rule, types: types_of(rule, member_of) });
    }
    known
}

fn types_of(rule: &ir::Rule, member_of: &dyn Fn(&ir::Group) -> Ty) -> Vec<Ty> {
    let mut types = Vec::new();
    for matched in &rule.matches {
        match &matched.what {
            Matched::Part { kind, port, .. } => {
                types.push(member_of(kind));
                if *port {
                    types.push(Ty::Port);
                }
            }
            Matched::Port { .. } => types.push(Ty::Port),
            Matched::Joint => types.push(Ty::Joint),
            Matched::Step => types.push(Ty::Step),
        }
    }
    for choice in &rule.choices {
        types.push(match &choice.domain.ty {
            Ty::Domain(item) | Ty::List(item) => (**item).clone(),
            Ty::Group => Ty::Part,
            _ => Ty::Unknown,
        });
    }
    types
}

impl Declarations<'_> {
    /// Whether a requirement of this name is there, or may be, in which something is wrong: that is told there.
    fn is_unsound(&self, requirement: &Name) -> bool {
        let program = self.environment.program;
        let named = |item: &ast::Item| matches!(&item.kind, ItemKind::Require { name: Some(name), .. } if name.text == requirement.text);
        self.expressions.is_lost(requirement.span, &requirement.text)
            || program.items().any(|(_, item)| named(item))
    }

    pub(super) fn example(
        &mut self,
        clauses: &[ExampleClause],
        rules: &IndexMap<&str, Applicable<'_>>,
        reasons: &IndexSet<String>,
        name: &Name,
        damaged: bool,
    ) -> Option<ir::Example> {
        let (example, span) = (name.text.as_str(), name.span);
        let mut cx = Context::new(Stage::Derivation, damaged);
        let mut out = Vec::new();
        let found = self.expressions.errors.len();
        for clause in clauses {
            match clause {
                ExampleClause::Expect(condition) => {
                    let condition =
                        self.expressions.expect(condition, &mut cx, &Ty::Bool, "what follows `expect`");
                    out.push(ir::ExampleClause::Expect(condition));
                }
                ExampleClause::Refuse(application, by) => {
                    if let Some(by) = by
                        && !reasons.contains(&by.text)
                        && !self.is_unsound(by)
                        && !self.expressions.report_dropped_with(
                            by.span,
                            &by.text,
                            "drop or replace this example, too",
                        )
                    {
                        let help = did_you_mean(&by.text, reasons.iter().map(String::as_str));
                        self.report(
                            Diagnostic::new(
                                Code::UNKNOWN_NAME,
                                by.span,
                                format!("there is no requirement `{}`", by.text),
                            )
                            .label("not declared")
                            .help(help.unwrap_or_else(|| "name a `require` of this grammar".to_owned())),
                        );
                    }
                    if let Some((application, _)) = self.application(example, application, rules, &mut cx) {
                        let by = by.as_ref().map(|b| b.text.clone());
                        out.push(ir::ExampleClause::Refuse { application, by });
                    }
                }
                ExampleClause::Step(name, application) => {
                    let checked = self.application(example, application, rules, &mut cx);
                    let ty = checked.as_ref().map_or(Ty::Unknown, |(_, ty)| ty.clone());
                    cx.locals.push(Local::new("", Ty::Step, name.span));
                    self.expressions.bind(name, ty, &mut cx);
                    let named = self.products(&application.rule);
                    for (_, product, ty) in &named {
                        let local = format!("{}.{}", name.text, product.text);
                        cx.locals.push(Local::new(local, ty.clone(), product.span));
                    }
                    if let Some((application, _)) = checked {
                        let products = named.into_iter().map(|(makers, ..)| makers).collect();
                        out.push(ir::ExampleClause::Step { name: name.text.clone(), application, products });
                    }
                }
            }
        }
        (self.expressions.errors.len() == found).then_some(ir::Example { clauses: out, span })
    }

    /// The parts that a rule makes and names: the numbers of the lines that make parts, their names and types; of what is made again and
    /// again a list.
    fn products(&mut self, rule: &Name) -> Vec<(Vec<usize>, Name, Ty)> {
        let declared = self.environment.program.lookup(rule.span, &rule.text);
        let Some((_, ast::Item { kind: ItemKind::Rule(_, clauses), .. })) = declared else {
            return Vec::new();
        };
        let mut named: Vec<(Vec<usize>, Name, Ty)> = Vec::new();
        for (number, (product, is_repeated)) in makers(clauses).into_iter().enumerate() {
            let Some(product) = product else { continue };
            let active = self.expressions.actuators_made.contains(&product.span);
            let one = if active { Ty::Actuator } else { Ty::Part };
            let ty = if is_repeated { Ty::List(Box::new(one)) } else { one };
            // Of blocks that exclude each other, each may give the name.
            match named.iter_mut().find(|(_, name, _)| is_repeated && name.text == product.text) {
                Some((numbers, first, _)) => {
                    numbers.push(number);
                    self.shared_names.push((first.span, product.span));
                }
                None => named.push((vec![number], product.clone(), ty)),
            }
        }
        named
    }

    /// A rule with a value for each of its locals, and the type of what it makes first.
    fn application(
        &mut self,
        example: &str,
        application: &Application,
        rules: &IndexMap<&str, Applicable<'_>>,
        cx: &mut Context,
    ) -> Option<(ir::Application, Ty)> {
        let name = &application.rule;
        let Some(known) = rules.get(name.text.as_str()) else {
            // A rule that has an error of its own is declared all the same.
            let program = self.environment.program;
            let declared = program.lookup(name.span, &name.text);
            if declared.is_some_and(|(_, item)| self.tell_of_always(name, &item.kind))
                || self.tell_of_unused_rule(name)
            {
                return None;
            }
            let broken = declared.is_some_and(|(_, i)| matches!(i.kind, ItemKind::Rule(..)));
            let dropped = format!(
                "drop or replace this, too: `drop {example}` or `replace example {example} {{ ... }}`"
            );
            if !broken
                && !self.expressions.is_lost(name.span, &name.text)
                && !self.expressions.report_dropped_with(name.span, &name.text, &dropped)
            {
                let help = did_you_mean(&name.text, rules.keys().copied());
                self.report(
                    Diagnostic::new(
                        Code::UNKNOWN_NAME,
                        name.span,
                        format!("there is no rule `{}`", name.text),
                    )
                    .label("not declared")
                    .help(help.unwrap_or_else(|| crate::names::UNDECLARED.to_owned())),
                );
            }
            return None;
        };
        let rule = known.rule;
        // What a broken clause of the rule would bind is not known.
        let damaged = self.faulty.contains(&rule.span);
        let fixed = |slot: usize| {
            let first = rule.locals.len() - rule.choices.len();
            slot.checked_sub(first)
                .and_then(|i| rule.choices.get(i))
                .is_some_and(|c| c.spread == Spread::Fixed)
        };
        let settable: Vec<&str> =
            rule.locals.iter().enumerate().filter(|(i, _)| !fixed(*i)).map(|(_, n)| n.as_str()).collect();
        if let Some(first) = application.arguments.iter().find(|a| a.name.is_none()) {
            self.unnamed(application, first.value.span, &settable);
            return None;
        }
        let mut values: IndexMap<usize, Expr> = IndexMap::new();
        for argument in &application.arguments {
            let Some(key) = &argument.name else { continue };
            let slot = rule.locals.iter().position(|l| *l == key.text).filter(|s| !fixed(*s));
            let Some(slot) = slot else {
                if damaged {
                    continue;
                }
                let what = format!("`{}` has no match or choice called `{}`", name.text, key.text);
                let help = did_you_mean(&key.text, settable.iter().copied())
                    .unwrap_or_else(|| format!("it takes: {}", settable.join(", ")));
                self.report(
                    Diagnostic::new(Code::WRONG_ARGUMENTS, key.span, what)
                        .label("no such name in the rule")
                        .help(help),
                );
                continue;
            };
            let wanted = known.types.get(slot).cloned().unwrap_or(Ty::Unknown);
            let value = self.argument(&argument.value, &wanted, &key.text, cx);
            if values.insert(slot, value).is_some() {
                self.expressions.given_twice(&application.arguments, key);
            }
        }
        let missing: Vec<&str> = (0..rule.locals.len())
            .filter(|slot| !fixed(*slot) && !values.contains_key(slot))
            .filter_map(|slot| rule.locals.get(slot).map(String::as_str))
            .collect();
        if !missing.is_empty() && damaged {
            return None;
        }
        if !missing.is_empty() && !cx.damaged {
            self.report(
                Diagnostic::new(
                    Code::WRONG_ARGUMENTS,
                    application.span,
                    format!("`{}` needs a value for `{}`", name.text, missing.join("`, `")),
                )
                .label("incomplete")
                .help("in an example, give a value for everything that the rule matches and chooses"),
            );
            return None;
        }
        let by_slot: Vec<Option<Expr>> =
            (0..rule.locals.len()).map(|slot| values.swap_remove(&slot)).collect();
        let made = self.made(rule, &by_slot);
        Some((ir::Application { rule: name.text.clone(), values: by_slot, span: application.span }, made))
    }

    /// Reports, once for an application, that its values have no names; writes them where it can.
    fn unnamed(&mut self, application: &Application, place: Span, settable: &[&str]) {
        let arguments = &application.arguments;
        let all = arguments.len() == settable.len() && arguments.iter().all(|a| a.name.is_none());
        let help = if all {
            let values = arguments.iter().map(|a| self.environment.sources.slice(a.value.span));
            let named: Vec<String> = settable.iter().zip(values).map(|(n, v)| format!("{n} = {v}")).collect();
            format!("write `{}({})`", application.rule.text, named.join(", "))
        } else {
            format!("it takes: {}", settable.join(", "))
        };
        self.report(
            Diagnostic::new(Code::WRONG_ARGUMENTS, place, "the values of a step must be given by name")
                .label("without a name")
                .help(help),
        );
    }

    /// A value of an application. The name of a step stands for the step or for what it made.
    fn argument(&mut self, tree: &ast::Expr, wanted: &Ty, name: &str, cx: &mut Context) -> Expr {
        if let (Ty::Step, ast::ExprKind::Name(word)) = (wanted, &tree.kind)
            && let Some(slot) = cx.locals.iter().position(|l| l.name == *word)
        {
            return Expr { kind: ExprKind::Local(slot.saturating_sub(1)), ty: Ty::Step, span: tree.span };
        }
        if *wanted == Ty::Port
            && let Some(port) = self.expressions.port_name(tree)
        {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, port.span, "this port is given without its part")
                    .label("a port belongs to a part")
                    .help("write for example `core.left`"),
            );
            return crate::types::expressions::context::unknown(tree.span);
        }
        let value = self.expressions.infer(tree, cx);
        if value.ty == Ty::Part && *wanted == Ty::Actuator {
            // Which kind of part a step makes may depend on its values.
            return value;
        }
        self.expressions.fit(value, wanted, &format!("`{name}`"))
    }

    /// The type of the first part that a rule makes with these values.
    fn made(&self, rule: &ir::Rule, values: &[Option<Expr>]) -> Ty {
        let what = Effect::single(&rule.effects).find_map(|e| match e {
            Effect::Attach { what, .. } => Some(what),
            Effect::Replace { with, .. } => Some(with),
            _ => None,
        });
        let chosen = |slot: usize| {
            let kind = values.get(slot).and_then(Option::as_ref);
            kind.is_some_and(|kind| self.expressions.is_always_actuator(kind, &|_| false))
        };
        let is_active = what.is_some_and(|what| self.expressions.is_always_actuator(what, &chosen));
        if is_active { Ty::Actuator } else { Ty::Part }
    }
}

/// What clauses make: of each line that makes parts the name, and whether it is repeated.
fn makers(clauses: &[ast::RuleClause]) -> Vec<(Option<&Name>, bool)> {
    let made = clauses.iter().flat_map(|clause| {
        let is_repeated = matches!(clause.kind, ast::RuleClauseKind::Repeat { .. });
        makers_of(std::slice::from_ref(clause)).into_iter().map(move |name| (name, is_repeated))
    });
    made.collect()
}
