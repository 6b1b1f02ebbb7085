//! What a variant observes: terms are added and dropped by name, or all are replaced.

use super::super::{Declaration, Loader};
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::syntax::ast::{Item, ItemKind, Name};

fn observed<'l>(loader: &'l mut Loader<'_>, declaration: Declaration) -> Option<&'l mut Vec<Name>> {
    match &mut loader.program.item_mut(declaration)?.kind {
        ItemKind::Observe(names) => Some(names),
        _ => None,
    }
}

/// Observes some terms no more.
pub(super) fn drop(loader: &mut Loader<'_>, names: &[Name]) {
    let places = loader.program.observing();
    for name in names {
        let mut known = Vec::new();
        let mut is_there = false;
        for place in &places {
            let Some(observed) = observed(loader, *place) else { continue };
            known.extend(observed.iter().map(|n| n.text.clone()));
            let before = observed.len();
            observed.retain(|n| n.text != name.text);
            is_there |= observed.len() < before;
        }
        if !is_there {
            let help = did_you_mean(&name.text, known.iter().map(String::as_str));
            let message = format!("the base does not observe `{}`", name.text);
            loader.errors.push(
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
pub(super) fn replace(loader: &mut Loader<'_>, module: usize, item: &Item) {
    let places = loader.program.observing();
    if places.is_empty() {
        loader.errors.push(
            Diagnostic::new(Code::NOTHING_TO_CHANGE, item.span, "the base has no `observe` to replace")
                .label("nothing to replace")
                .help("write `add` instead of `replace`"),
        );
        return;
    }
    for place in places {
        if let Some(observed) = observed(loader, place) {
            observed.clear();
        }
    }
    super::add(loader, module, item);
}
