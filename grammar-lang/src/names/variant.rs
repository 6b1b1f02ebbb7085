//! Variants: a grammar as the difference from another.
//!
//! The edits change the trees of the declarations that they name, in place, so
//! that everything that uses those declarations sees the change. Names inside an
//! edit keep the meaning that they have in the text that it stands in.

mod change;
mod heads;
mod observe;
mod scenarios;
mod unchanged;
mod values;

use std::collections::{BTreeMap, BTreeSet};
use std::mem::discriminant;
use std::rc::Rc;

use self::change::Change;
use self::heads::Heads;
use super::{Declaration, LoadedModule, Loading, declared};
use crate::diagnostics::{Code, Diagnostic, did_you_mean};
use crate::source::Span;
use crate::syntax::ast::{Edit, EditKind, Item, ItemKind, Name, Variant};
use crate::syntax::declarations::BlockKind;

/// How many variants may build on each other.
const DEEPEST: usize = 100;

/// Finds what is compiled: a grammar of the first text, or a variant of it. Then
/// applies the edits of the variants, from the one nearest to the grammar outwards.
pub(super) fn resolve(loading: &mut Loading<'_>, wanted: Option<&str>) {
    two_of_a_name(loading);
    let mut chain: Vec<(usize, Variant)> = Vec::new();
    let Some(mut place) = first(loading, wanted) else { return };
    let grammar = loop {
        match loading.program.item(place).map(|i| i.kind.clone()) {
            Some(ItemKind::Grammar(name)) => break (place, name),
            Some(ItemKind::Variant(variant)) => {
                let base = base_of(loading, place, &variant);
                let circle = chain.iter().any(|(m, v)| *m == place.module && v.name == variant.name);
                if circle {
                    loading.errors.push(
                        Diagnostic::new(
                            Code::VARIANT_CYCLE,
                            variant.base.span,
                            format!("`{}` is a variant of itself", variant.name.text),
                        )
                        .label("this base leads back to it")
                        .help("let one of the variants start from a grammar"),
                    );
                    return;
                }
                if chain.len() == DEEPEST {
                    loading.errors.push(
                        Diagnostic::new(
                            Code::TOO_DEEP,
                            variant.base.span,
                            format!("more than {DEEPEST} variants build on each other"),
                        )
                        .label("one more")
                        .help("merge the edits of several variants into one"),
                    );
                    return;
                }
                chain.push((place.module, variant));
                match base {
                    Some(base) => place = base,
                    None => return,
                }
            }
            _ => return,
        }
    };
    let (place, name) = grammar;
    loading.program.base = Some(name.span);
    // Its text may still add declarations, such as `novelty`, or import them.
    let adds = |item: &Rc<Item>| !matches!(item.kind, ItemKind::Variant(_));
    let adds =
        |module: usize| loading.program.modules.get(module).is_some_and(|m| m.tree.items.iter().any(adds));
    if let Some((_, variant)) = chain.first().filter(|(module, v)| v.edits.is_empty() && !adds(*module)) {
        loading.errors.push(
            Diagnostic::new(
                Code::POINTLESS,
                variant.name.span,
                format!("the variant `{}` changes nothing", variant.name.text),
            )
            .label("has no edits")
            .help(
                "write what differs, as in `set hinge_model.ground_friction = 0.5`, or run the base itself",
            ),
        );
    }
    loading.program.name = Some(chain.first().map_or(name, |(_, v)| v.name.clone()));
    let module = place.module;
    loading.program.own = chain.iter().map(|(m, _)| *m).chain([module]).collect();
    take_part(loading, module);
    let mut base = module;
    for (module, variant) in chain.into_iter().rev() {
        inherit(loading, module, base);
        apply(loading, module, &variant);
        base = module;
    }
}

/// So many grammars and variants may stand in a file: each is a grammar of its own, which takes time and memory.
pub const MOST_VARIANTS: usize = 1000;

/// Variants are asked for by their names: no two in a text can share one. And there are not too many.
fn two_of_a_name(loading: &mut Loading<'_>) {
    let Some(module) = loading.program.modules.first() else { return };
    let mut seen: BTreeMap<&str, Span> = BTreeMap::new();
    let mut found = Vec::new();
    for item in &module.tree.items {
        let (name, variant) = match &item.kind {
            ItemKind::Grammar(name) => (name, false),
            ItemKind::Variant(variant) => (&variant.name, true),
            _ => continue,
        };
        if seen.len() == MOST_VARIANTS {
            found.push(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    name.span,
                    format!("a file declares at most {MOST_VARIANTS} grammars and variants"),
                )
                .label("the first one too many")
                .help("put the others into files of their own"),
            );
            break;
        }
        // That there are two grammars is told anyway.
        if let Some(first) = seen.insert(&name.text, name.span)
            && variant
        {
            found.push(
                Diagnostic::new(
                    Code::DUPLICATE,
                    name.span,
                    format!("there are two grammars or variants `{}`", name.text),
                )
                .label("again")
                .also(first, "the first one")
                .help("give one of them another name"),
            );
        }
    }
    loading.errors.extend(found);
}

/// What the first text offers to compile.
fn first(loading: &mut Loading<'_>, wanted: Option<&str>) -> Option<Declaration> {
    let tree = &loading.program.modules.first()?.tree;
    let find = |test: &dyn Fn(&ItemKind) -> bool| {
        tree.items.iter().rposition(|i| test(&i.kind)).map(|item| Declaration { module: 0, item })
    };
    match wanted {
        None => find(&|k| matches!(k, ItemKind::Grammar(_)))
            .or_else(|| find(&|k| matches!(k, ItemKind::Variant(_)))),
        Some(wanted) => {
            let found = find(&|k| match k {
                ItemKind::Grammar(name) => name.text == wanted,
                ItemKind::Variant(variant) => variant.name.text == wanted,
                _ => false,
            });
            if found.is_none() {
                let names = names_of(tree.items.iter());
                let file = loading.program.modules.first()?.file;
                let error = Diagnostic::new(
                    Code::UNKNOWN_NAME,
                    Span { file, start: 0, end: 0 },
                    format!("this file declares no grammar or variant `{wanted}`"),
                )
                .help_if(
                    did_you_mean(wanted, names.iter().map(String::as_str)).or_else(|| {
                        (!names.is_empty()).then(|| format!("it declares: {}", names.join(", ")))
                    }),
                );
                loading.errors.push(error);
            }
            found
        }
    }
}

/// The names of the grammars and variants among some items.
pub(super) fn names_of<'a>(items: impl Iterator<Item = &'a Rc<Item>>) -> Vec<String> {
    items
        .filter_map(|i| match &i.kind {
            ItemKind::Grammar(name) => Some(name.text.clone()),
            ItemKind::Variant(variant) => Some(variant.name.text.clone()),
            _ => None,
        })
        .collect()
}

fn base_of(loading: &mut Loading<'_>, place: Declaration, variant: &Variant) -> Option<Declaration> {
    let module = if variant.from_file {
        let from = loading.program.modules.get(place.module)?.name.clone();
        loading.open.push(place.module);
        let found = loading.module_of(&variant.base, &from);
        loading.open.pop();
        found?
    } else {
        place.module
    };
    let items = &loading.program.modules.get(module)?.tree.items;
    let item = if variant.from_file {
        let grammar = items.iter().rposition(|i| matches!(i.kind, ItemKind::Grammar(_)));
        grammar.or_else(|| items.iter().rposition(|i| matches!(i.kind, ItemKind::Variant(_))))
    } else {
        items.iter().position(|i| match &i.kind {
            ItemKind::Grammar(name) => name.text == variant.base.text,
            ItemKind::Variant(other) => other.name.text == variant.base.text,
            _ => false,
        })
    };
    if item.is_none() && !loading.program.is_lost(module, &variant.base.text) {
        let names = names_of(items.iter());
        let (message, help) = if variant.from_file {
            ("this file declares no grammar to start from".to_owned(), None)
        } else {
            (
                format!("there is no grammar `{}` to start from", variant.base.text),
                did_you_mean(&variant.base.text, names.iter().map(String::as_str)),
            )
        };
        loading.errors.push(
            Diagnostic::new(Code::NO_BASE, variant.base.span, message)
                .label("not a grammar or variant")
                .help(help.unwrap_or_else(|| {
                    "name a grammar or variant of this file, or a file: `of \"./codesign.sgr\"`".to_owned()
                })),
        );
    }
    item.map(|item| Declaration { module, item })
}

/// Everything that a grammar's text declares or imports takes part in it.
fn take_part(loading: &mut Loading<'_>, module: usize) {
    let Some(loaded) = loading.program.modules.get(module) else { return };
    let own = (0..loaded.tree.items.len()).map(|item| Declaration { module, item });
    let imported = loaded.scope.values().copied().filter(|d| d.module != module);
    let all: Vec<Declaration> = imported.chain(own).collect();
    let is_variant =
        |d: &Declaration| loading.program.item(*d).is_some_and(|i| matches!(i.kind, ItemKind::Variant(_)));
    loading.program.taking_part = all.into_iter().filter(|d| !is_variant(d)).collect();
}

/// A variant knows every name that its base knows.
fn inherit(loading: &mut Loading<'_>, module: usize, base: usize) {
    if module == base {
        return;
    }
    let Some(from) = loading.program.modules.get(base) else { return };
    let (scope, lost, leaky) = (from.scope.clone(), from.lost.clone(), from.leaky);
    for (name, declaration) in scope {
        let Some(into) = loading.program.modules.get(module) else { return };
        match into.scope.get(&name).copied() {
            None => {
                if let Some(into) = loading.program.modules.get_mut(module) {
                    into.scope.insert(name, declaration);
                }
            }
            Some(own) if own != declaration => {
                let span = |d| loading.program.item(d).and_then(declared).map(|n| n.span);
                if let (Some(here), Some(there)) = (span(own), span(declaration)) {
                    loading.errors.push(
                        Diagnostic::new(
                            Code::DUPLICATE,
                            here,
                            format!("`{name}` already means something else in the base"),
                        )
                        .label("another meaning")
                        .also(there, "the meaning in the base")
                        .help("choose another name"),
                    );
                }
            }
            Some(_) => {}
        }
    }
    if let Some(into) = loading.program.modules.get_mut(module) {
        into.lost.extend(lost);
        into.leaky |= leaky;
    }
}

/// Applies the edits of one variant: each to its base as it was, at most one for each target.
fn apply(loading: &mut Loading<'_>, module: usize, variant: &Variant) {
    let mut seen: BTreeMap<String, (Span, &EditKind)> = BTreeMap::new();
    let mut heads = Heads::default();
    let taking_part: BTreeSet<Declaration> = loading.program.taking_part.iter().copied().collect();
    let mut dropped: BTreeSet<Declaration> = BTreeSet::new();
    let mut unchanged = Vec::new();
    for edit in &variant.edits {
        let (key, span) = target_of(edit);
        if let Some((first, kind)) = seen.insert(key.clone(), (span, &edit.kind)) {
            let help = match (kind, &edit.kind) {
                (EditKind::Drop(_), EditKind::Add(_)) | (EditKind::Add(_), EditKind::Drop(_)) => {
                    "write `replace` instead of `add`, and take the `drop` out"
                }
                _ => "keep one of them",
            };
            loading.errors.push(
                Diagnostic::new(Code::DUPLICATE, span, format!("`{key}` is changed twice by this variant"))
                    .label("changed again")
                    .also(first, "first changed here")
                    .help(help),
            );
            continue;
        }
        if let Some(error) = heads.clash(edit, span) {
            loading.errors.push(error);
            continue;
        }
        note(loading, module, variant, edit, span);
        match &edit.kind {
            EditKind::Set(path, value) => {
                unchanged.extend(values::change(loading, module, path, Change::Set(value)));
            }
            EditKind::SetJoint(path, joint) => values::set_joint(loading, module, path, joint),
            EditKind::Narrow(path, value) => {
                unchanged.extend(values::change(loading, module, path, Change::Narrow(value)));
            }
            EditKind::Drop(path) => dropped.extend(drop_path(loading, module, path)),
            EditKind::DropObserved(names) => observe::drop(loading, names),
            EditKind::Replace(item) if matches!(item.kind, ItemKind::Observe(_)) => {
                observe::replace(loading, module, item);
            }
            EditKind::Replace(item) => replace(loading, module, item, &taking_part),
            EditKind::Allow(allow) => loading.program.allows.push(allow.clone()),
            EditKind::Add(item) => add(loading, module, item),
        }
    }
    // A variant that does nothing else is no variant.
    let is_nothing = unchanged.len() == variant.edits.len();
    let told = unchanged.into_iter().filter(|one| is_nothing || !one.is_library).map(|one| one.told);
    loading.errors.extend(told);
    // At once: each alone would walk over all that takes part.
    loading.program.taking_part.retain(|d| !dropped.contains(d));
}

/// Keeps what an edit changes, so that findings about it can say so.
fn note(loading: &mut Loading<'_>, module: usize, variant: &Variant, edit: &Edit, place: Span) {
    let is_edit = matches!(edit.kind, EditKind::Set(..) | EditKind::SetJoint(..) | EditKind::Narrow(..));
    let path: Vec<String> = match &edit.kind {
        EditKind::Set(path, _) | EditKind::SetJoint(path, _) | EditKind::Narrow(path, _) => {
            path.iter().map(|n| n.text.clone()).collect()
        }
        EditKind::Replace(item) => declared(item).map(|n| n.text.clone()).into_iter().collect(),
        EditKind::Drop(_) | EditKind::DropObserved(_) | EditKind::Allow(_) | EditKind::Add(_) => return,
    };
    let Some(loaded) = loading.program.modules.get(module) else { return };
    let declaration = path.first().and_then(|head| loaded.scope.get(head));
    let Some(declaration) = declaration.copied() else { return };
    let Some(target) = loading.program.item(declaration).map(|i| i.span) else { return };
    // The edit as a whole: findings inside it stand where it is.
    let place = Span::join(place, edit.span);
    let variant = variant.name.text.clone();
    let edited = is_edit.then_some(declaration);
    loading.program.changes.push(super::Change { path, place, target, variant, edited });
}

/// What an edit is about, for messages, and where it says so.
fn target_of(edit: &Edit) -> (String, Span) {
    let path = |path: &[Name]| {
        let mut text: Vec<&str> = path.iter().map(|n| n.text.as_str()).collect();
        // The one replaces the other.
        if let [_, field] = text.as_mut_slice()
            && *field == "density"
        {
            *field = "mass";
        }
        let span = path.iter().map(|n| n.span).reduce(Span::join).unwrap_or(edit.span);
        (text.join("."), span)
    };
    match &edit.kind {
        EditKind::Set(p, _) | EditKind::SetJoint(p, _) | EditKind::Narrow(p, _) | EditKind::Drop(p) => {
            path(p)
        }
        EditKind::DropObserved(_) | EditKind::Allow(_) => (format!("at {}", edit.span.start), edit.span),
        EditKind::Replace(item) | EditKind::Add(item) => match (declared(item), &item.kind) {
            (Some(name), _) => (name.text.clone(), name.span),
            (None, ItemKind::Actuate(kind, _)) => (format!("actuate {}", kind.text), kind.span),
            // Two requirements without names are two targets, and so are two objectives that are added.
            (None, ItemKind::Require { .. } | ItemKind::Prefer { .. } | ItemKind::Observe(_)) => {
                (format!("at {}", item.span.start), item.span)
            }
            (None, ItemKind::Objective { .. }) if matches!(edit.kind, EditKind::Add(_)) => {
                (format!("at {}", item.span.start), item.span)
            }
            (None, kind) => (word_of(kind).to_owned(), item.span),
        },
    }
}

/// The word that opens a declaration of which a grammar has one.
fn word_of(kind: &ItemKind) -> &'static str {
    match kind {
        ItemKind::Symmetry(..) => "symmetry",
        ItemKind::Begin(..) => "begin",
        ItemKind::Lattice(..) => "lattice",
        ItemKind::Simulate { .. } => "simulate",
        ItemKind::Objective { .. } => "maximize",
        ItemKind::UseSearch(..) => "search",
        ItemKind::Actuate(..) => "actuate",
        ItemKind::Observe(_) => "observe",
        ItemKind::Use { .. } => "use",
        ItemKind::Grammar(_) => "grammar",
        _ => "declaration",
    }
}

/// Finds the declaration that the first word of a path names.
fn find(loading: &mut Loading<'_>, module: usize, name: &Name) -> Option<Declaration> {
    let loaded = loading.program.modules.get(module)?;
    if let Some(found) = loaded.scope.get(&name.text).copied() {
        let Some(place) = loading.program.dropped.get(&found).copied() else { return Some(found) };
        loading.errors.push(
            Diagnostic::new(
                Code::NOTHING_TO_CHANGE,
                name.span,
                format!("the base has no `{}` any more", name.text),
            )
            .label("nothing to change")
            .also(place, "dropped here")
            .help("`add` a new version of it, or remove the `drop` there"),
        );
        return None;
    }
    if !loading.program.is_lost(module, &name.text) {
        let modules = loading.program.modules.iter();
        let is_base = modules.flat_map(|m| names_of(m.tree.items.iter())).any(|base| base == name.text);
        let help = is_base
            .then(|| format!("`{}` is the base itself: write the path without it", name.text))
            .or_else(|| did_you_mean(&name.text, loaded.scope.keys().map(String::as_str)));
        loading.errors.push(
            Diagnostic::new(
                Code::NOTHING_TO_CHANGE,
                name.span,
                format!("the base has no `{}` to change", name.text),
            )
            .label("not declared there")
            .help(help.unwrap_or_else(|| declares(loaded))),
        );
    }
    None
}

/// What a base declares, where that is not too much to be listed.
fn declares(base: &LoadedModule) -> String {
    const MOST: usize = 24;
    let own = base.tree.items.iter().filter_map(|item| declared(item)).map(|name| name.text.as_str());
    let own: Vec<&str> = own.take(MOST + 1).collect();
    match own.len() {
        1..=MOST => {
            format!("a variant changes what its base declares or imports; it declares: {}", own.join(", "))
        }
        _ => "a variant changes what its base declares or imports".to_owned(),
    }
}

/// Drops a declaration; gives which one that is.
fn drop_path(loading: &mut Loading<'_>, module: usize, path: &[Name]) -> Option<Declaration> {
    let (head, rest) = path.split_first()?;
    let declaration = find(loading, module, head)?;
    if let [name] = rest
        && let Some(ItemKind::Block(BlockKind::Scenarios, set)) =
            loading.program.item_mut(declaration).map(|item| &mut item.kind)
    {
        let outcome = scenarios::drop(set, name);
        if let Err(offers) = outcome {
            let help = did_you_mean(&name.text, offers.iter().map(String::as_str))
                .unwrap_or_else(|| format!("it has: {}", offers.join(", ")));
            loading.errors.push(
                Diagnostic::new(
                    Code::NOTHING_TO_CHANGE,
                    name.span,
                    format!("`{}` has no `{}` to drop", head.text, name.text),
                )
                .label("not there")
                .help(help),
            );
        }
        return None;
    }
    if let Some(field) = rest.first() {
        loading.errors.push(
            Diagnostic::new(Code::NOTHING_TO_CHANGE, field.span, "only a whole declaration can be dropped")
                .label("a part of one")
                .help(format!("set it, or write `replace` and the whole of `{}` as it should be", head.text)),
        );
        return None;
    }
    loading.program.dropped.insert(declaration, head.span);
    Some(declaration)
}

/// The declaration of the grammar that has the same role as an item.
fn same_role(loading: &Loading<'_>, item: &Item) -> Option<Declaration> {
    loading.program.taking_part.iter().copied().find(|d| {
        loading.program.item(*d).is_some_and(|other| match (&other.kind, &item.kind) {
            (ItemKind::Actuate(a, _), ItemKind::Actuate(b, _)) => a.text == b.text,
            (
                ItemKind::Require { .. }
                | ItemKind::Prefer { .. }
                | ItemKind::Observe(_)
                | ItemKind::Use { .. },
                _,
            ) => false,
            (a, b) => discriminant(a) == discriminant(b) && declared(other).is_none(),
        })
    })
}

fn replace(loading: &mut Loading<'_>, module: usize, item: &Item, taking_part: &BTreeSet<Declaration>) {
    if misplaced(loading, item) {
        return;
    }
    let declaration = match declared(item) {
        Some(name) => {
            let Some(found) = find(loading, module, name) else { return };
            let (span, text) = (name.span, name.text.clone());
            if let Some(old) = loading.program.item(found)
                && old.kind.word() != item.kind.word()
            {
                let place = declared(old).map(|n| n.span);
                let mut error = Diagnostic::new(
                    Code::WRONG_TYPE,
                    span,
                    format!("`{text}` is another kind of declaration in the base"),
                )
                .label("not the same kind")
                .help("give it another name and `add` it");
                if let Some(place) = place {
                    error = error.also(place, "the one in the base");
                }
                loading.errors.push(error);
                return;
            }
            found
        }
        None => match same_role(loading, item) {
            Some(found) => found,
            None => {
                loading.errors.push(
                    Diagnostic::new(
                        Code::NOTHING_TO_CHANGE,
                        item.span,
                        format!("the base has no `{}` to replace", word_of(&item.kind)),
                    )
                    .label("nothing to replace")
                    .help("write `add` instead of `replace`"),
                );
                return;
            }
        },
    };
    if let ItemKind::Objective { .. } = item.kind {
        drop_other_objectives(loading, declaration, taking_part, item.span);
    }
    if let Some(old) = loading.program.item_mut(declaration) {
        *old = item.clone();
    }
    if !taking_part.contains(&declaration) {
        loading.program.taking_part.push(declaration);
    }
}

/// An objective that replaces takes the place of all objectives of the base.
fn drop_other_objectives(
    loading: &mut Loading<'_>,
    first: Declaration,
    base: &BTreeSet<Declaration>,
    place: Span,
) {
    let is_other = |d: &Declaration| {
        let item = loading.program.item(*d);
        *d != first && item.is_some_and(|item| matches!(item.kind, ItemKind::Objective { .. }))
    };
    let others: Vec<Declaration> = base.iter().copied().filter(is_other).collect();
    loading.program.taking_part.retain(|d| !others.contains(d));
    loading.program.dropped.extend(others.into_iter().map(|other| (other, place)));
}

fn add(loading: &mut Loading<'_>, module: usize, item: &Item) {
    if misplaced(loading, item) {
        return;
    }
    // Of objectives there may be several.
    if declared(item).is_none()
        && !matches!(item.kind, ItemKind::Objective { .. })
        && let Some(old) = same_role(loading, item)
    {
        let place = loading.program.item(old).map(|i| i.span);
        let mut error = Diagnostic::new(
            Code::DUPLICATE,
            item.span,
            format!("the base already has {} `{}`", article(word_of(&item.kind)), word_of(&item.kind)),
        )
        .label("another one")
        .help(format!("to change what the base says, write `replace {} ...`", item.kind.word()));
        if let Some(place) = place {
            error = error.also(place, "the one in the base");
        }
        loading.errors.push(error);
        return;
    }
    let Some(loaded) = loading.program.modules.get_mut(module) else { return };
    let declaration = Declaration { module, item: loaded.tree.items.len() };
    loaded.tree.items.push(Rc::new(item.clone()));
    if let Some(name) = declared(item).cloned() {
        let first = loaded.scope.get(&name.text).copied();
        if let Some(first) = first.filter(|first| !loading.program.dropped.contains_key(first)) {
            let place = loading.program.item(first).and_then(declared).map(|n| n.span);
            let mut error = Diagnostic::new(
                Code::DUPLICATE,
                name.span,
                format!("the base already declares `{}`", name.text),
            )
            .label("declared again here")
            .help(format!(
                "to change what the base says, write `replace {} {} ...`; or choose another name",
                item.kind.word(),
                name.text
            ));
            if let Some(place) = place {
                error = error.also(place, "declared in the base here");
            }
            loading.errors.push(error);
            return;
        }
        loaded.scope.insert(name.text, declaration);
    }
    loading.program.taking_part.push(declaration);
}

/// Declarations that belong outside a variant.
fn misplaced(loading: &mut Loading<'_>, item: &Item) -> bool {
    let help = match &item.kind {
        ItemKind::Use { .. } => "write the `use` above the variant",
        ItemKind::Grammar(_) => "a variant is named by its own first line",
        ItemKind::Variant(_) => "declare it beside this one, and start it from this one",
        _ => return false,
    };
    loading.errors.push(
        Diagnostic::new(Code::BAD_VALUE, item.span, "this cannot be inside a variant")
            .label("not a part of a grammar")
            .help(help),
    );
    true
}

/// The article of a word.
fn article(word: &str) -> &'static str {
    if word.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" }
}
