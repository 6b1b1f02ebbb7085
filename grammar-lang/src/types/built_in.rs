//! Names that the language has a meaning for already: what a grammar declares by one of them would be read in some
//! places and not in others.

use super::found::Found;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Function, Word};
use crate::names::{Program, Sharing, declared};
use crate::syntax::ast::{ItemKind, Name};
use crate::syntax::declarations::BlockKind;
use crate::types::expressions::is_type;

/// The first part of the body, wherever no declaration says otherwise.
const CORE: &str = "core";
/// Groups of parts that are no reserved words.
const GROUPS: [&str; 1] = ["block"];

/// What a rule can match or a term read, which no kind of part can be called.
const MATCHED: [&str; 4] = ["joint", "step", "element", "nothing"];

/// Reports declarations whose names are built in.
pub(super) fn check(program: &Program, found: &mut Found) {
    let sharing = Sharing::of(program);
    for (declaration, item) in program.entries() {
        // What requirements and preferences are called is read nowhere.
        // A shared variable is read in actuations only, where a motion has no period yet.
        if matches!(item.kind, ItemKind::Require { .. } | ItemKind::Prefer { .. } | ItemKind::Shared(_)) {
            continue;
        }
        // So is what comes from one.
        let of_all = |name: &Name| name.text == "period" && sharing.reads(declaration);
        if matches!(&item.kind, ItemKind::Let(name, None, _) if of_all(name)) {
            continue;
        }
        let is_built_in = |name: &&Name| match &item.kind {
            ItemKind::Enum(..) => is_built_in(&name.text) || is_type(&name.text),
            ItemKind::Block(BlockKind::Part | BlockKind::Actuator | BlockKind::Cell, _) => {
                is_built_in(&name.text) || MATCHED.contains(&name.text.as_str())
            }
            _ => is_built_in(&name.text),
        };
        if let Some(name) = declared(item).filter(is_built_in) {
            found.add(built_in(name));
        }
    }
}

/// Whether a name that is read without brackets means something where parts can be read: `end`, `pi`. A search reads no parts.
pub(super) fn is_read_as_word(name: &str) -> bool {
    Word::named(name).is_some_and(|word| !matches!(word, Word::Search(_)))
}

fn is_built_in(name: &str) -> bool {
    Word::named(name).is_some() || Function::named(name).is_some() || name == CORE || GROUPS.contains(&name)
}

/// The error of a name that the language has a meaning for already.
pub(super) fn built_in(name: &Name) -> Diagnostic {
    let text = &name.text;
    let meaning = Word::named(text).map(Word::doc).or_else(|| Function::named(text).map(Function::doc));
    let label = match meaning.map(|meaning| meaning.trim_end_matches('.')) {
        Some(meaning) => format!("built in: {}{}", meaning[..1].to_lowercase(), &meaning[1..]),
        None => "this name is built in".to_owned(),
    };
    Diagnostic::new(Code::BUILT_IN, name.span, format!("`{text}` is already the name of a built-in word"))
        .label(label)
        .help(format!("choose another name, such as `own_{text}`"))
}
