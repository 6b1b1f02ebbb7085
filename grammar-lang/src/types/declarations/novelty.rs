//! Checks sets of known designs.

use std::collections::BTreeSet;

use indexmap::IndexMap;

use super::Declarations;
use crate::diagnostics::{Code, Diagnostic, did_you_mean, respell};
use crate::eval::Value;
use crate::ir::{self, Expr, ExprKind, Ty};
use crate::names::{Declaration, declared};
use crate::source::Span;
use crate::syntax::ast::{self, Block, Field, ItemKind, Name, NoveltyClause};
use crate::types::expressions::context::Context;
use crate::types::expressions::fit::article;
use crate::types::expressions::stage::Stage;

impl Declarations<'_> {
    /// The sets that take part in a grammar.
    pub(in crate::types) fn novelties(&mut self) -> Option<IndexMap<String, ir::Novelty>> {
        let program = self.environment.program;
        let mut novelties = IndexMap::new();
        let mut sound = true;
        // What a variant's text imports is known to it, as what its base has.
        let known = program.own.iter().filter_map(|m| program.modules.get(*m)).flat_map(|m| m.scope.values());
        let all: BTreeSet<Declaration> =
            known.copied().chain(program.entries().map(|(declaration, _)| declaration)).collect();
        for declaration in all.into_iter().filter(|d| !program.dropped.contains_key(d)) {
            let Some(item) = program.item(declaration) else { continue };
            let (ItemKind::Novelty(_, clauses), Some(name)) = (&item.kind, declared(item)) else { continue };
            self.expressions.touched.insert(declaration);
            match self.novelty(name, clauses, item.damaged) {
                Some(novelty) => drop(novelties.insert(name.text.clone(), novelty)),
                None => sound = false,
            }
        }
        sound.then_some(novelties)
    }

    pub(super) fn novelty(
        &mut self,
        name: &Name,
        clauses: &[NoveltyClause],
        damaged: bool,
    ) -> Option<ir::Novelty> {
        let mut features: IndexMap<String, (ir::Feature, Span)> = IndexMap::new();
        let mut sound = true;
        for clause in clauses {
            let NoveltyClause::Feature { name, value, weight } = clause else { continue };
            let feature = self.feature(value, weight.as_ref(), damaged);
            if let Some((_, first)) = features.get(&name.text) {
                self.twice(name, *first, "feature");
                sound = false;
                continue;
            }
            sound &= feature.is_some();
            let unknown = ir::Feature {
                ty: Ty::Unknown,
                value: crate::types::expressions::context::unknown(value.span),
                weight: 1.0,
            };
            features.insert(name.text.clone(), (feature.unwrap_or(unknown), name.span));
        }
        if features.is_empty() && !damaged {
            self.report(
                Diagnostic::new(
                    Code::MISSING_FIELD,
                    name.span,
                    format!("`{}` has no features: nothing can be compared", name.text),
                )
                .label("without a `feature`")
                .help("add for example `feature actuators = count(actuator)`"),
            );
            return None;
        }
        if sound && !damaged && features.values().all(|(feature, _)| feature.weight == 0.0) {
            self.report(
                Diagnostic::new(
                    Code::BAD_VALUE,
                    name.span,
                    format!("all features of `{}` have the weight 0: every design would score 0", name.text),
                )
                .label("nothing counts")
                .help("let one feature have a weight above 0; without `weight`, it is 1"),
            );
            return None;
        }
        let mut known: IndexMap<String, (Vec<f64>, Span)> = IndexMap::new();
        for clause in clauses {
            let NoveltyClause::Known(block) = clause else { continue };
            let values = self.known(block, &features, damaged);
            sound &= values.is_some();
            if let Some((_, first)) = known.get(&block.name.text) {
                self.twice(&block.name, *first, "known design");
                sound = false;
                continue;
            }
            known.insert(block.name.text.clone(), (values.unwrap_or_default(), block.name.span));
        }
        sound.then(|| ir::Novelty {
            features: features.into_iter().map(|(name, (feature, _))| (name, feature)).collect(),
            known: known.into_iter().map(|(name, (values, _))| (name, values)).collect(),
            span: name.span,
        })
    }

    fn feature(
        &mut self,
        value: &ast::Expr,
        weight: Option<&ast::Expr>,
        damaged: bool,
    ) -> Option<ir::Feature> {
        let mut cx = Context::new(Stage::Score, damaged);
        let value = self.expressions.infer(value, &mut cx);
        let weight = match weight {
            Some(weight) => self.feature_weight(weight, damaged),
            None => Some(1.0),
        };
        let ty = value.ty.clone();
        if ty.dimension().is_none() && !matches!(ty, Ty::Bool | Ty::Enum(_) | Ty::Unknown) {
            self.report(
                Diagnostic::new(
                    Code::WRONG_TYPE,
                    value.span,
                    "a feature must be a quantity, a Count, a Bool or a value of an enumeration",
                )
                .label(format!("this is {}", article(&ty)))
                .help("compare designs by a value that two designs can share, such as `count(actuator)`"),
            );
            return None;
        }
        (ty != Ty::Unknown).then_some(())?;
        Some(ir::Feature { ty, value, weight: weight? })
    }

    fn feature_weight(&mut self, weight: &ast::Expr, damaged: bool) -> Option<f64> {
        let mut cx = Context::new(Stage::Declaration, damaged);
        let weight = self.expressions.expect(weight, &mut cx, &Ty::NUMBER, "the weight of a feature");
        let number = self.expressions.constant_number(&weight)?;
        if number < 0.0 {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    weight.span,
                    "the weight of a feature must not be below 0",
                )
                .label("negative")
                .help("to ignore a feature, give it the weight 0"),
            );
            return None;
        }
        Some(number)
    }

    /// The values of a known design, in the order of the features.
    fn known(
        &mut self,
        block: &Block,
        features: &IndexMap<String, (ir::Feature, Span)>,
        damaged: bool,
    ) -> Option<Vec<f64>> {
        let mut values: IndexMap<&str, (Option<f64>, Span)> = IndexMap::new();
        for field in &block.fields {
            let (name, value) = match field {
                Field::Value(name, value) => (name, value),
                Field::Group(Block { name, .. }) | Field::Param(ast::Param { name, .. }) => {
                    self.no_feature(name, features);
                    return None;
                }
                Field::Port(port) => {
                    self.no_feature(&port.name, features);
                    return None;
                }
                Field::Joint(joint) => {
                    self.no_feature(&joint.named(), features);
                    return None;
                }
            };
            let Some((feature, _)) = features.get(&name.text) else {
                self.no_feature(name, features);
                values.insert(&name.text, (None, name.span));
                continue;
            };
            if let Some((_, first)) = values.get(name.text.as_str()) {
                self.twice(name, *first, "value of");
                continue;
            }
            let value = self.known_value(value, &feature.ty, &name.text);
            values.insert(&name.text, (value, name.span));
        }
        let missing: Vec<&str> =
            features.keys().map(String::as_str).filter(|name| !values.contains_key(name)).collect();
        // One that is misspelt is told already.
        let misspelt = values.keys().any(|name| !features.contains_key(*name));
        if !missing.is_empty() && !misspelt && !damaged {
            self.report(
                Diagnostic::new(
                    Code::MISSING_FIELD,
                    block.name.span,
                    format!("{:?} lacks a value for the feature `{}`", block.name.text, missing.join(", ")),
                )
                .label("incomplete")
                .help("a known design has a value for each feature"),
            );
        }
        features.keys().map(|name| values.get(name.as_str())?.0).collect()
    }

    fn known_value(&mut self, tree: &ast::Expr, ty: &Ty, name: &str) -> Option<f64> {
        // Its type is known: a value of an enumeration needs no more than its name.
        if let (Ty::Enum(of), ast::ExprKind::Name(word)) = (ty, &tree.kind) {
            let all = self.expressions.variants_of(of, tree.span);
            if let Some(index) = all.iter().position(|value| value == word) {
                return Some(index as f64);
            }
            let known = || all.iter().map(String::as_str);
            let help = did_you_mean(word, known()).unwrap_or_else(|| format!("it has: {}", all.join(", ")));
            self.report(
                Diagnostic::new(Code::UNKNOWN_NAME, tree.span, format!("`{of}` has no value `{word}`"))
                    .label("not one of its values")
                    .help(help)
                    .fix_if(respell(tree.span, word, known())),
            );
            return None;
        }
        if *ty == Ty::Unknown {
            return None;
        }
        let mut cx = Context::new(Stage::Declaration, false);
        let value: Expr = self.expressions.expect(tree, &mut cx, ty, &format!("`{name}`"));
        if let ExprKind::Bool(yes) = value.kind {
            return Some(f64::from(u8::from(yes)));
        }
        match self.expressions.constant(&value)? {
            Value::Number(x) => Some(x),
            Value::Bool(yes) => Some(f64::from(u8::from(yes))),
            _ => None,
        }
    }

    fn no_feature(&mut self, name: &Name, features: &IndexMap<String, (ir::Feature, Span)>) {
        let known = || features.keys().map(String::as_str);
        let help = did_you_mean(&name.text, known())
            .unwrap_or_else(|| format!("the features are: {}", known().collect::<Vec<_>>().join(", ")));
        self.report(
            Diagnostic::new(Code::UNKNOWN_FIELD, name.span, format!("there is no feature `{}`", name.text))
                .label("not declared with `feature`")
                .help(help)
                .fix_if(respell(name.span, &name.text, known())),
        );
    }

    fn twice(&mut self, name: &Name, first: Span, what: &str) {
        self.report(
            Diagnostic::new(
                Code::DUPLICATE,
                name.span,
                format!("the {what} `{}` is declared twice", name.text),
            )
            .label("again")
            .also(first, "the first one")
            .help("choose another name, or keep one of them"),
        );
    }
}
