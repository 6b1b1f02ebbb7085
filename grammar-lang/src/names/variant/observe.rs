//! What a variant observes: terms are added and dropped by name, or all are replaced.

use super::super::{Declaration, Loading};
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::syntax::ast::{Item, ItemKind, Name};

fn observed<'l>(loading: &'l mut Loading<'_>, declaration: Declaration) -> Option<&'l mut Vec<Name>> {
    match &mut loading.program.item_mut(declaration)?.kind {
        ItemKind::Observe(names) => Some(names),
        _ => None,
    }
}

/// Observes some terms no more.
pub(super) fn drop(loading: &mut Loading<'_>, names: &[Name]) {
    let places = loading.program.observing();
    for name in names {
        let mut known = Vec::new();
        let mut is_there = false;
        for place in &places {
            let Some(observed) = observed(loading, *place) else { continue };
            known.extend(observed.iter().map(|n| n.text.clone()));
            let before = observed.len();
            observed.retain(|n| n.text != name.text);
            is_there |= observed.len() < before;
        }
        if !is_there {
            let help = did_you_mean(&name.text, known.iter().map(String::as_str));
            let message = format!("the base does not observe `{}`", name.text);
            loading.errors.push(
                Diagnostic::new(Code::NOTHING_TO_CHANGE, name.span, message).label("nothing to drop").help(
                    help.unwrap_or_else(|| match known.is_empty() {
                        true => "it observes nothing".to_owned(),
                        false => format!("it observes: {}", known.join(", ")),
                    }),
                ),
            );
        }
    }
}

/// Observes the terms of an item, and no others.
pub(super) fn replace(loading: &mut Loading<'_>, module: usize, item: &Item) {
    let places = loading.program.observing();
    if places.is_empty() {
        loading.errors.push(
            Diagnostic::new(Code::NOTHING_TO_CHANGE, item.span, "the base has no `observe` to replace")
                .label("nothing to replace")
                .help("write `add` instead of `replace`"),
        );
        return;
    }
    for place in places {
        if let Some(observed) = observed(loading, place) {
            observed.clear();
        }
    }
    super::add(loading, module, item);
}
