//! The declarations of a line: requirements, preferences, terms, patterns, enumerations, examples as a whole.

use std::collections::BTreeSet;

use indexmap::{IndexMap, IndexSet};

use super::Declarations;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{self, Expr, Ty};
use crate::names::Declaration;
use crate::source::Span;
use crate::syntax::ast::{Expr as Tree, Item, ItemKind, Name};
use crate::syntax::declarations::BlockKind;
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

impl Declarations<'_> {
    pub(in crate::types) fn requirement(&mut self, item: &Item) -> Option<ir::Requirement> {
        let ItemKind::Require { name, condition, because } = &item.kind else { return None };
        let name = self.name_or_text(name.as_ref(), condition);
        let mut cx = Context::new(Stage::Derivation, item.damaged);
        let condition = self.expressions.expect(condition, &mut cx, &Ty::Bool, "a requirement");
        Some(ir::Requirement { name, condition, because: because.clone(), span: item.span })
    }

    pub(in crate::types) fn preference(&mut self, item: &Item) -> Option<ir::Preference> {
        let ItemKind::Prefer { name, condition, weight, because } = &item.kind else { return None };
        let name = self.name_or_text(name.as_ref(), condition);
        let mut cx = Context::new(Stage::Derivation, item.damaged);
        let condition = self.expressions.expect(condition, &mut cx, &Ty::Bool, "a preference");
        let weight = self.expressions.expect(weight, &mut cx, &Ty::NUMBER, "the weight of a preference");
        if let Some(x) = self.expressions.quiet_number(&weight)
            && x < 0.0
        {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    weight.span,
                    "the weight of a preference must not be below 0",
                )
                .label("negative")
                .help("prefer the opposite: `prefer not (...)`"),
            );
        }
        Some(ir::Preference { name, condition, weight, because: because.clone(), span: item.span })
    }

    /// What has no name is known by what it says.
    fn name_or_text(&self, name: Option<&Name>, condition: &Tree) -> String {
        match name {
            Some(name) => name.text.clone(),
            None => self
                .environment
                .sources
                .slice(condition.span)
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" "),
        }
    }

    pub(in crate::types) fn examples(
        &mut self,
        items: &[(Declaration, &Item)],
        rules: &[ir::Rule],
        requirements: &[ir::Requirement],
    ) -> IndexMap<String, ir::Example> {
        let program = self.environment.program;
        let actuators = program.items().filter_map(|(_, i)| match &i.kind {
            ItemKind::Block(BlockKind::Actuator, block) => Some(block.name.text.as_str()),
            _ => None,
        });
        let actuators: BTreeSet<&str> = actuators.collect();
        let cells = program.items().filter_map(|(_, i)| match &i.kind {
            ItemKind::Block(BlockKind::Cell, block) => Some(block.name.text.as_str()),
            _ => None,
        });
        let cells: BTreeSet<&str> = cells.collect();
        let member_of = |group: &ir::Group| match group {
            ir::Group::Actuator => Ty::Actuator,
            ir::Group::Cell => Ty::Cell,
            ir::Group::Kind(kind) if actuators.contains(kind.as_str()) => Ty::Actuator,
            ir::Group::Kind(kind) if cells.contains(kind.as_str()) => Ty::Cell,
            _ => Ty::Part,
        };
        let rules = super::examples::applicable(rules, &member_of);
        let reasons: IndexSet<String> = requirements.iter().map(|r| r.name.clone()).collect();
        let mut examples = IndexMap::new();
        for (_, item) in items {
            let ItemKind::Example(name, clauses) = &item.kind else { continue };
            if let Some(example) = self.example(clauses, &rules, &reasons, name, item.damaged) {
                examples.insert(name.text.clone(), example);
            }
        }
        let products = std::mem::take(&mut self.products);
        for (first, other) in std::mem::take(&mut self.shared_names) {
            if self.expressions.read.contains(&first) {
                self.expressions.read.insert(other);
            }
        }
        self.unread(products.iter(), "use it in this rule or in an example, or take it out");
        examples
    }

    pub(super) fn enumeration(&mut self, name: &Name, values: &[Name]) {
        self.distinct(values.iter(), "value");
        if values.is_empty() {
            self.report(
                Diagnostic::new(Code::EMPTY_DOMAIN, name.span, format!("`{}` has no values", name.text))
                    .label("empty")
                    .help("name at least one value"),
            );
        }
    }

    pub(super) fn distinct<'n>(&mut self, names: impl Iterator<Item = &'n Name>, what: &str) {
        let mut seen: IndexMap<&str, Span> = IndexMap::new();
        for name in names {
            if let Some(first) = seen.insert(&name.text, name.span) {
                self.report(
                    Diagnostic::new(
                        Code::DUPLICATE,
                        name.span,
                        format!("there are two {what}s `{}`", name.text),
                    )
                    .label("again")
                    .also(first, "the first one")
                    .help("choose another name, or keep one of them"),
                );
            }
        }
    }

    pub(in crate::types) fn fixed_pattern(&mut self, value: &Tree, damaged: bool) -> Expr {
        let mut cx = Context::new(Stage::Pattern, damaged);
        self.expressions.expect(value, &mut cx, &Ty::Quantity(Dimension::ANGLE), "a pattern")
    }

    pub(in crate::types) fn term(&mut self, ty: &Name, value: &Tree, damaged: bool) -> (Ty, Expr) {
        let ty = self.expressions.type_named(ty);
        let mut cx = Context::new(Stage::Score, damaged);
        let (known, place) = (self.expressions.errors.len(), value.span);
        let value = self.expressions.expect(value, &mut cx, &ty, "this term");
        // Perhaps the value is right, and its type is not.
        for mut error in self.expressions.errors.split_off(known) {
            let is = error.labels.first().and_then(|label| label.text.rsplit(' ').next()).map(str::to_owned);
            if let (true, Some(is), Some(help)) = (error.span() == place, is, &error.help)
                && crate::types::expressions::is_type(&is)
                && !help.starts_with("declare it")
            {
                error.help = Some(format!("declare it as `{is}`. Or {help}"));
            }
            self.expressions.errors.add(error);
        }
        (ty, value)
    }
}
