//! Fields of a part that read other fields of the same part.

use std::collections::BTreeSet;
use std::rc::Rc;

use super::context::{Context, unknown};
use super::{Expressions, LARGEST_FIELD, nodes};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::Expr;
use crate::source::Span;

impl Expressions<'_> {
    /// Another field of the part around an expression.
    pub(super) fn own_field(&mut self, name: &str, span: Span, cx: &Context) -> Option<Expr> {
        let (field, value) = cx.fields.all.iter().find(|(field, _)| field.text == name)?;
        if cx.fields.circular.contains(name) {
            return Some(unknown(span));
        }
        if let Some(known) = self.own_fields.get(&value.span) {
            return Some(Expr { span, ..known.clone() });
        }
        let mut within = cx.clone();
        within.locals.truncate(cx.fields.params);
        let mut known = self.infer(value, &mut within);
        // It is put in the place of its name, as often as that is read.
        if nodes(&known) > LARGEST_FIELD {
            self.report(
                Diagnostic::new(
                    Code::TOO_DEEP,
                    span,
                    format!("the expression of `{name}` is too long to be read by another field"),
                )
                .label("it has too many operations")
                .also(field.span, "this field")
                .help("shorten its expression, or read its parameters instead"),
            );
            known = unknown(span);
        }
        self.own_fields.insert(value.span, known.clone());
        Some(Expr { span, ..known })
    }

    /// Finds the fields of a part that read themselves in the end, and tells each circle once.
    pub(in crate::types) fn find_circles(&mut self, cx: &mut Context) {
        let fields = Rc::clone(&cx.fields.all);
        let is_param = |name: &str| cx.locals.iter().any(|local| local.name == name);
        let reads: Vec<Vec<(usize, Span)>> = fields
            .iter()
            .map(|(_, value)| {
                let mut read = Vec::new();
                value.each_name(&mut |name, span| {
                    let place = fields.iter().position(|(field, _)| field.text == name);
                    let other = is_param(name) || self.environment.program.lookup(span, name).is_some();
                    read.extend(place.filter(|_| !other).map(|place| (place, span)));
                });
                read
            })
            .collect();
        let reached = |from: usize| {
            let (mut all, mut next) = (BTreeSet::new(), vec![from]);
            while let Some(place) = next.pop() {
                let read = reads.get(place).into_iter().flatten().map(|(read, _)| *read);
                next.extend(read.filter(|read| all.insert(*read)));
            }
            all
        };
        let all: Vec<BTreeSet<usize>> = (0..fields.len()).map(reached).collect();
        let mut circular = BTreeSet::new();
        for (place, (field, _)) in fields.iter().enumerate() {
            let leads = |from: usize, to: usize| all.get(from).is_some_and(|reached| reached.contains(&to));
            if !leads(place, place) || circular.contains(&field.text) {
                continue;
            }
            let circle = (0..fields.len()).filter(|other| leads(place, *other) && leads(*other, place));
            circular.extend(circle.filter_map(|other| Some(fields.get(other)?.0.text.clone())));
            let read = reads
                .get(place)
                .into_iter()
                .flatten()
                .find(|(read, _)| *read == place || leads(*read, place));
            let Some(&(read, span)) = read else { continue };
            let through = fields.get(read).map_or(field, |(through, _)| through);
            let message = format!("`{}` is defined in terms of itself", field.text);
            let mut error = Diagnostic::new(Code::BAD_VALUE, span, message)
                .label("its value depends on its own value")
                .help("a field can read others, but not itself, not even indirectly: give one of them a value of its own");
            if read != place {
                error = error.also(through.span, "through this field");
            }
            self.report(error);
        }
        cx.fields.circular = Rc::new(circular);
    }
}
