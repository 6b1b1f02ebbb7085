//! The fields of a block of named values: which there are, which are missing, and their values.

use std::collections::BTreeSet;

use indexmap::IndexMap;

use super::Declarations;
use crate::diagnostics::{Code, Diagnostic, did_you_mean, nearest, respell};
use crate::eval::Value;
use crate::ir::{self, Expr, ExprKind, Ty};
use crate::syntax::ast::{self, Block, Field, Name};
use crate::types::expressions::context::Context;
use crate::units::Dimension;

/// What a number must be.
#[derive(Clone, Copy)]
pub(super) enum Sign {
    Positive,
    NotNegative,
}

/// The fields that a block may have.
#[derive(Clone, Copy)]
pub(super) struct Fields<'f> {
    /// All of them, as they are listed to people.
    pub(super) all: &'f [&'static str],
    /// Those that are blocks of their own.
    pub(super) blocks: &'f [&'static str],
}

impl<'f> Fields<'f> {
    /// Fields that are all values.
    pub(super) const fn values(all: &'f [&'static str]) -> Self {
        Self { all, blocks: &[] }
    }
}

/// A block with its values by name.
pub(super) struct Values<'b> {
    block: &'b Block,
    pub(super) what: &'static str,
    pub(in crate::types) values: IndexMap<&'b str, (&'b Name, &'b ast::Expr)>,
    pub(super) groups: IndexMap<&'b str, &'b Block>,
    /// Names that are there, but misspelt, which has been reported.
    pub(super) misspelt: Vec<String>,
}

impl Values<'_> {
    /// Where the block is named.
    pub(super) fn place(&self) -> crate::source::Span {
        self.block.name.span
    }
}

impl Declarations<'_> {
    pub(super) fn values<'b>(
        &mut self,
        block: &'b Block,
        what: &'static str,
        allowed: Fields<'_>,
    ) -> Values<'b> {
        if let Some(method) = &block.method {
            self.no_method(&block.name, method);
        }
        self.values_among(block, block.fields.iter(), what, allowed)
    }

    /// The values of some fields of a block.
    pub(super) fn values_among<'b>(
        &mut self,
        block: &'b Block,
        fields: impl Iterator<Item = &'b Field>,
        what: &'static str,
        allowed: Fields<'_>,
    ) -> Values<'b> {
        let mut values: IndexMap<&str, (&Name, &ast::Expr)> = IndexMap::new();
        let mut groups: IndexMap<&str, &Block> = IndexMap::new();
        let mut misspelt = Vec::new();
        let given = block.fields.iter().filter_map(|f| match f {
            Field::Value(name, _) => Some(name.text.as_str()),
            Field::Group(group) => Some(group.name.text.as_str()),
            Field::Param(_) | Field::Port(_) | Field::Joint(_) => None,
        });
        let given: BTreeSet<&str> = given.collect();
        for field in fields {
            let name = match field {
                Field::Value(name, _) => name,
                Field::Group(group) => &group.name,
                Field::Param(_) | Field::Port(_) | Field::Joint(_) => {
                    self.check_declares(field, what);
                    continue;
                }
            };
            let text = name.text.as_str();
            let is_group = allowed.blocks.contains(&text);
            if !allowed.all.contains(&text) || matches!(field, Field::Group(_)) != is_group {
                let open: Vec<&str> = allowed.all.iter().copied().filter(|a| !given.contains(a)).collect();
                let is_block = matches!(field, Field::Group(_));
                self.not_a_field(name, what, (allowed, is_block), &open);
                misspelt.extend(nearest(text, open).map(str::to_owned));
                // What is there in the wrong form is not missing, too.
                misspelt.push(name.text.clone());
                continue;
            }
            let first = values.get(text).map(|(n, _)| n.span);
            if let Some(first) = first.or_else(|| groups.get(text).map(|g| g.name.span)) {
                self.report(
                    Diagnostic::new(Code::DUPLICATE, name.span, format!("`{text}` is given twice"))
                        .label("again")
                        .also(first, "first given here")
                        .help("keep one of them"),
                );
            }
            match field {
                Field::Value(_, value) => drop(values.insert(text, (name, value))),
                Field::Group(group) => drop(groups.insert(text, group)),
                Field::Param(_) | Field::Port(_) | Field::Joint(_) => {}
            }
        }
        Values { block, what, values, groups, misspelt }
    }

    /// Parameters and ports are declared where something has them.
    fn check_declares(&mut self, field: &Field, what: &str) {
        let (name, message, help) = match field {
            Field::Param(param) if !matches!(what, "a part" | "a cell") && !is_row(what) => {
                (&param.name, "parameters", "declare it outside, for the whole grammar")
            }
            Field::Port(port) if what != "a part" => (
                &port.name,
                "ports of its own",
                "only a passive part declares ports; an actuator has `base` and `tip`",
            ),
            Field::Joint(joint) if what != "a part" && !is_row(what) => {
                (&joint.named(), "joint", "for a row of segments that move, declare an `actuator`")
            }
            _ => return,
        };
        let error = Diagnostic::new(Code::UNKNOWN_FIELD, name.span, format!("{what} has no {message}"));
        self.report(error.label("not possible here").help(help));
    }

    /// A name that is no field, or not in this form; `open` are the fields that are not given yet.
    fn not_a_field(
        &mut self,
        name: &Name,
        what: &str,
        (allowed, is_block): (Fields<'_>, bool),
        open: &[&str],
    ) {
        let text = name.text.as_str();
        let (message, label, help) = match (allowed.all.contains(&text), allowed.blocks.contains(&text)) {
            (true, true) => (
                format!("`{text}` is a block, not a value"),
                "not in this form",
                format!("write `{text} {{ ... }}`"),
            ),
            (true, false) => (
                format!("`{text}` is a value, not a block"),
                "not in this form",
                format!("write `{text} = ...`"),
            ),
            (false, _) if what == "a set of worlds" && is_block => (
                format!("{what} has no `{text}`"),
                "not known",
                format!("a world with a name is a case: write `case {text} {{ ... }}`"),
            ),
            (false, _) => (
                format!("{what} has no `{text}`"),
                "not known",
                did_you_mean(text, allowed.all.iter().copied())
                    .unwrap_or_else(|| format!("{what} has: {}", allowed.all.join(", "))),
            ),
        };
        self.report(
            Diagnostic::new(Code::UNKNOWN_FIELD, name.span, message).label(label).help(help).fix_if(respell(
                name.span,
                text,
                open.iter().copied(),
            )),
        );
    }

    /// A word behind the name of a block that has none there.
    pub(super) fn no_method(&mut self, name: &Name, word: &Name) {
        self.report(
            Diagnostic::new(
                Code::UNKNOWN_FIELD,
                word.span,
                format!("`{}` takes no word before its bracket", name.text),
            )
            .label("not expected here")
            .help(format!("write `{} {{ ... }}`", name.text)),
        );
    }

    pub(super) fn missing(&mut self, from: &Values<'_>, name: &str, example: &str, damaged: bool) {
        if damaged || from.misspelt.iter().any(|m| m == name) {
            return;
        }
        let lacks = format!("`{}` has no ", from.block.name.text);
        // All that one block lacks is one finding.
        let place = from.block.name.span;
        let more = self.expressions.errors.amend(place, Code::MISSING_FIELD, &lacks, |known| {
            // A declaration may be looked at twice.
            if known.message.contains(&format!("`{name}`")) {
                return;
            }
            known.message = format!("{}, `{name}`", known.message.replace(" or `", ", `"));
            if let Some(last) = known.message.rfind(", ") {
                known.message.replace_range(last..last + 2, " or ");
            }
            if let Some(label) = known.labels.first_mut() {
                label.text = format!("{} needs them", from.what);
            }
            let help = known.help.take().unwrap_or_default().replace("a line such", "lines such");
            known.help = Some(format!("{help}, `{name} = {example}`"));
        });
        if more {
            return;
        }
        self.report(
            Diagnostic::new(Code::MISSING_FIELD, place, format!("{lacks}`{name}`"))
                .label(format!("{} needs it", from.what))
                .help(format!("add a line such as `{name} = {example}`")),
        );
    }

    pub(super) fn value(
        &mut self,
        from: &Values<'_>,
        name: &str,
        ty: &Ty,
        example: &str,
        cx: &Context,
    ) -> Option<(Value, crate::source::Span)> {
        let (expr, span) = self.field_expr(from, name, ty, example, cx)?;
        Some((self.expressions.constant(&expr)?, span))
    }

    /// What a field says, of the type that it has.
    fn field_expr(
        &mut self,
        from: &Values<'_>,
        name: &str,
        ty: &Ty,
        example: &str,
        cx: &Context,
    ) -> Option<(Expr, crate::source::Span)> {
        let Some((_, tree)) = from.values.get(name) else {
            self.missing(from, name, example, cx.damaged);
            return None;
        };
        let known = self.expressions.errors.len();
        let expr = self.expressions.expect(tree, &mut cx.clone(), ty, &format!("`{name}`"));
        self.show_example(known, tree.span, name, example);
        Some((expr, tree.span))
    }

    /// The same where it may read the parameters, which are the locals of `cx`: `read` makes a value of what does not.
    pub(super) fn varying<T>(
        &mut self,
        from: &Values<'_>,
        name: &str,
        (ty, example): (&Ty, &str),
        cx: &Context,
        read: impl FnOnce(&mut Self, Value, crate::source::Span) -> Option<T>,
    ) -> Option<ir::Field<T>> {
        let (expr, span) = self.field_expr(from, name, ty, example, cx)?;
        if expr.ty == Ty::Unknown {
            return None;
        }
        if reads_params(&expr, cx.locals.len()) {
            self.hiding(&expr, cx);
            return Some(ir::Field::Varies(expr));
        }
        let value = self.expressions.constant(&expr)?;
        read(self, value, span).map(ir::Field::Fixed)
    }

    /// Reports parameters that a field reads, and that have the name of something else: no name hides another.
    pub(super) fn hiding(&mut self, expr: &Expr, cx: &Context) {
        for (slot, local) in cx.locals.iter().enumerate() {
            let reads = expr.any(&mut |e| matches!(e.kind, ExprKind::Local(s) if s == slot));
            let Some((_, item)) = self.environment.program.lookup(local.span, &local.name).filter(|_| reads)
            else {
                continue;
            };
            let mut error = Diagnostic::new(
                Code::DUPLICATE,
                local.span,
                format!("`{}` already means something else here", local.name),
            )
            .label("a second meaning")
            .help("choose another name: no name hides another");
            if let Some(other) = crate::names::declared(item) {
                error = error.also(other.span, "the other meaning");
            }
            self.report(error);
        }
    }

    /// A number that may read the parameters.
    pub(super) fn varying_number(
        &mut self,
        from: &Values<'_>,
        name: &str,
        dimension: Dimension,
        (sign, example): (Sign, &str),
        cx: &Context,
    ) -> Option<ir::Field<f64>> {
        let ty = Ty::Quantity(dimension);
        self.varying(from, name, (&ty, example), cx, |own, value, span| {
            own.sound_number(from, name, &ty, (sign, example), value.as_number()?, span)
        })
    }

    /// What does not fit a field is mended as the field is usually written.
    pub(super) fn show_example(
        &mut self,
        known: usize,
        place: crate::source::Span,
        name: &str,
        example: &str,
    ) {
        for mut error in self.expressions.errors.split_off(known) {
            let unit =
                example.split_once(' ').map(|(_, unit)| unit).filter(|u| crate::units::parse(u).is_ok());
            if error.span() == place && error.code == Code::MISSING_UNIT {
                if let Some(unit) = unit {
                    error.help = Some(format!("write `{} {unit}`", self.environment.sources.slice(place)));
                }
            } else if error.span() == place && error.code == Code::WRONG_TYPE && error.fix.is_none() {
                error.help = Some(format!("write for example `{name} = {example}`"));
            }
            self.expressions.errors.add(error);
        }
    }

    pub(super) fn number(
        &mut self,
        from: &Values<'_>,
        name: &str,
        ty: impl Into<Ty>,
        sign: Sign,
        example: &str,
        cx: &Context,
    ) -> Option<f64> {
        let ty = ty.into();
        let (value, span) = self.value(from, name, &ty, example, cx)?;
        self.sound_number(from, name, &ty, (sign, example), value.as_number()?, span)
    }

    /// A number, if it has the sign that it must have.
    fn sound_number(
        &mut self,
        from: &Values<'_>,
        name: &str,
        ty: &Ty,
        (sign, example): (Sign, &str),
        x: f64,
        span: crate::source::Span,
    ) -> Option<f64> {
        let fine = match sign {
            Sign::Positive => x > 0.0,
            Sign::NotNegative => x >= 0.0,
        };
        if !fine {
            let must = if matches!(sign, Sign::Positive) { "must be above 0" } else { "must not be below 0" };
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, span, format!("`{name}` {must}"))
                    .label(format!("this is {}", crate::types::expressions::shown(x, ty)))
                    .help(format!("write for example `{name} = {example}`")),
            );
            return None;
        }
        if let Some((_, tree)) = from.values.get(name) {
            self.usual(from.what, name, x, tree);
        }
        Some(x)
    }
}

/// Whether an expression reads one of the parameters, which are the first `many` locals.
pub(super) fn reads_params(expr: &Expr, many: usize) -> bool {
    expr.any(&mut |e| match e.kind {
        ExprKind::Local(slot) => slot < many,
        ExprKind::OfBody(_) => true,
        _ => false,
    })
}

/// Whether something is called a row of segments.
fn is_row(what: &str) -> bool {
    what.contains("actuator") || what.contains("a passive row")
}
