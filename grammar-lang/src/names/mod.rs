//! Modules and what their names mean: imports, scopes, cycles, duplicates, variants.

mod allowed;
mod blame;
mod sharing;
mod variant;

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

pub use allowed::Allowed;
pub use blame::{Change, with_changes};
pub(crate) use blame::{UNDECLARED, told_once, with_imports};
pub use sharing::Sharing;
pub use variant::MOST_VARIANTS;

use indexmap::IndexMap;

use crate::diagnostics::{Code, Diagnostic, did_you_mean, respell};
use crate::source::{FileId, Loader, NoModule, SourceMap, Span};
use crate::syntax::Trees;
use crate::syntax::ast::{Allow, Item, ItemKind, Module, Name};

/// A declaration: item `item` of module `module`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Declaration {
    /// Index into [`Program::modules`].
    pub module: usize,
    /// Index into the module's items.
    pub item: usize,
}

/// A text with the names that it can use.
#[derive(Debug)]
pub struct LoadedModule {
    /// What the loader calls it.
    pub name: String,
    /// Its text.
    pub file: FileId,
    /// Its tree.
    pub tree: Module,
    /// Every name that can be used in it.
    pub scope: IndexMap<String, Declaration>,
    /// Names that would be known if another error had not happened.
    pub lost: BTreeSet<String>,
    /// Whether any name might be lost.
    pub leaky: bool,
}

/// All modules of a compilation; the first is the grammar itself.
#[derive(Debug, Default)]
pub struct Program {
    /// The modules.
    pub modules: Vec<LoadedModule>,
    /// The name of the grammar or variant that is compiled; none in a module.
    pub name: Option<Name>,
    /// Where the grammar is named that a variant comes from in the end.
    pub base: Option<Span>,
    /// The modules that declare the grammar and its variants.
    pub own: Vec<usize>,
    /// The declarations that take part in it, imported ones first.
    pub taking_part: Vec<Declaration>,
    /// Declarations that a variant took out, and where it says so.
    pub dropped: BTreeMap<Declaration, Span>,
    /// What variants changed.
    pub changes: Vec<Change>,
    /// The warnings that its variants allow.
    pub allows: Vec<Allow>,
}

impl Program {
    /// The item of a declaration.
    #[must_use]
    pub fn item(&self, declaration: Declaration) -> Option<&Item> {
        self.modules.get(declaration.module)?.tree.items.get(declaration.item).map(Rc::as_ref)
    }

    fn item_mut(&mut self, declaration: Declaration) -> Option<&mut Item> {
        let items = &mut self.modules.get_mut(declaration.module)?.tree.items;
        items.get_mut(declaration.item).map(Rc::make_mut)
    }

    /// The module whose text a place belongs to: names mean there what they mean in
    /// that text, even where a variant has put them into a declaration of another.
    #[must_use]
    pub fn module_at(&self, place: Span) -> usize {
        let here = |m: &LoadedModule| m.file == place.file;
        // Texts are mostly numbered as modules are.
        let likely = place.file.0 as usize;
        if self.modules.get(likely).is_some_and(here) {
            return likely;
        }
        self.modules.iter().position(here).unwrap_or(0)
    }

    /// What a name means at a place.
    #[must_use]
    pub fn lookup(&self, place: Span, name: &str) -> Option<(Declaration, &Item)> {
        let declaration = *self.modules.get(self.module_at(place))?.scope.get(name)?;
        let there = !self.dropped.contains_key(&declaration);
        Some((declaration, self.item(declaration).filter(|_| there)?))
    }

    /// Where a variant drops what a name would mean at a place.
    #[must_use]
    pub fn dropped_at(&self, place: Span, name: &str) -> Option<Span> {
        let declaration = self.modules.get(self.module_at(place))?.scope.get(name)?;
        self.dropped.get(declaration).copied()
    }

    /// Every name that is known at a place.
    pub fn scope_at(&self, place: Span) -> impl Iterator<Item = (&str, &Item)> {
        let scope = self.modules.get(self.module_at(place)).map(|m| &m.scope);
        scope.into_iter().flatten().filter_map(|(name, d)| Some((name.as_str(), self.item(*d)?)))
    }

    /// How many names are known at a place.
    #[must_use]
    pub fn known_at(&self, place: Span) -> usize {
        self.modules.get(self.module_at(place)).map_or(0, |m| m.scope.len())
    }

    /// The declarations that take part in the grammar, with where they stand.
    pub fn entries(&self) -> impl Iterator<Item = (Declaration, &Item)> {
        self.taking_part.iter().filter_map(|d| Some((*d, self.item(*d)?)))
    }

    /// Whether a declaration takes part in the grammar by itself: what stands beside a variant does not.
    #[must_use]
    pub fn takes_part(&self, declaration: Declaration) -> bool {
        self.taking_part.contains(&declaration)
    }

    /// Whether this is a variant in a text without a grammar: what else the text declares is there for the variant to name.
    #[must_use]
    pub fn is_only_variant(&self) -> bool {
        let is_grammar = |item: &Rc<Item>| matches!(item.kind, ItemKind::Grammar(_));
        self.base.is_some() && !self.modules.first().is_some_and(|m| m.tree.items.iter().any(is_grammar))
    }

    /// The declarations that say what is observed: the grammar's own, then those of the modules that it uses.
    #[must_use]
    pub fn observing(&self) -> Vec<Declaration> {
        let observes = |(_, item): &(Declaration, &Item)| matches!(item.kind, ItemKind::Observe(_));
        let own = self.entries().filter(observes).map(|(declaration, _)| declaration);
        let used = self.items().filter(|(d, _)| !self.own.contains(&d.module)).filter(observes);
        own.chain(used.map(|(declaration, _)| declaration)).collect()
    }

    /// Whether an unknown name in a module is the echo of another error.
    #[must_use]
    pub fn is_lost(&self, module: usize, name: &str) -> bool {
        self.modules.get(module).is_none_or(|m| m.leaky || m.lost.contains(name))
    }

    /// Whether a declaration that begins with a word could not be read.
    #[must_use]
    pub fn has_unread(&self, word: &str) -> bool {
        self.modules.iter().any(|m| m.tree.unread.iter().any(|unread| unread == word))
    }

    /// All items of all modules.
    pub fn items(&self) -> impl Iterator<Item = (Declaration, &Item)> {
        self.modules.iter().enumerate().flat_map(|(module, m)| {
            m.tree.items.iter().enumerate().map(move |(item, i)| (Declaration { module, item }, i.as_ref()))
        })
    }
}

/// The name that an item declares for others to use.
#[must_use]
pub fn declared(item: &Item) -> Option<&Name> {
    match &item.kind {
        ItemKind::Param(p) => Some(&p.name),
        ItemKind::Table(t) => Some(&t.name),
        ItemKind::Sense(sense) => Some(&sense.name),
        ItemKind::State(of_body) => Some(&of_body.state.name),
        ItemKind::Shared(variable) => Some(&variable.name),
        ItemKind::Rule(n, _)
        | ItemKind::Pattern(n, _)
        | ItemKind::Term(n, ..)
        | ItemKind::Let(n, ..)
        | ItemKind::Enum(n, _)
        | ItemKind::Record(n, _)
        | ItemKind::Novelty(n, _)
        | ItemKind::Task(n, _)
        | ItemKind::Example(n, _) => Some(n),
        ItemKind::Require { name, .. } | ItemKind::Prefer { name, .. } => name.as_ref(),
        ItemKind::Actuation { name, .. } => Some(name),
        kind => kind.block().map(|block| &block.name),
    }
}

/// The names of the grammar and the variants that a module declares.
#[must_use]
pub fn offers(module: &Module) -> Vec<String> {
    variant::names_of(module.items.iter())
}

/// Reads a grammar and all that it imports; of several that a text declares, the wanted one.
pub fn load(
    loader: &dyn Loader,
    sources: &mut SourceMap,
    entry: FileId,
    wanted: Option<&str>,
) -> (Program, Vec<Diagnostic>) {
    load_with(&mut Trees::default(), loader, sources, entry, wanted)
}

/// The same with the trees of texts that were read before.
pub(crate) fn load_with(
    trees: &mut Trees,
    loader: &dyn Loader,
    sources: &mut SourceMap,
    entry: FileId,
    wanted: Option<&str>,
) -> (Program, Vec<Diagnostic>) {
    let (program, open, errors) = (Program::default(), Vec::new(), Vec::new());
    let mut loader = Loading { trees, loader, sources, program, open, errors };
    let name = loader.sources.get(entry).map_or_else(String::new, |s| s.name.clone());
    loader.module(name, entry);
    variant::resolve(&mut loader, wanted);
    if loader.program.taking_part.is_empty() {
        // A module is checked for its own sake.
        let count = loader.program.modules.first().map_or(0, |m| m.tree.items.len());
        loader.program.own = vec![0];
        loader.program.taking_part = (0..count).map(|item| Declaration { module: 0, item }).collect();
    }
    (loader.program, loader.errors)
}

/// How many files may import each other in a chain: each that is open takes a piece of the stack.
const DEEPEST: usize = 100;

struct Loading<'a> {
    trees: &'a mut Trees,
    loader: &'a dyn Loader,
    sources: &'a mut SourceMap,
    program: Program,
    /// Modules that are being read, outermost first.
    open: Vec<usize>,
    errors: Vec<Diagnostic>,
}

impl Loading<'_> {
    fn module(&mut self, name: String, file: FileId) -> usize {
        let (tree, errors) = self.trees.parse(self.sources, file);
        self.errors.extend(errors);
        let index = self.program.modules.len();
        let lost = tree.broken.iter().cloned().collect();
        let leaky = tree.headless;
        let items: Vec<(usize, Name)> = tree
            .items
            .iter()
            .enumerate()
            .filter_map(|(i, item)| Some((i, declared(item)?.clone())))
            .collect();
        let uses: Vec<(Name, Option<Vec<Name>>)> = tree
            .items
            .iter()
            .filter_map(|item| match &item.kind {
                ItemKind::Use { module, names } => Some((module.clone(), names.clone())),
                _ => None,
            })
            .collect();
        self.program.modules.push(LoadedModule {
            name: name.clone(),
            file,
            tree,
            scope: IndexMap::new(),
            lost,
            leaky,
        });
        self.open.push(index);
        for (item, declared) in items {
            self.declare(index, &declared, Declaration { module: index, item });
        }
        for (module, names) in uses {
            self.import(index, &name, &module, names.as_deref());
        }
        self.open.pop();
        index
    }

    fn declare(&mut self, module: usize, name: &Name, declaration: Declaration) {
        let Some(loaded) = self.program.modules.get_mut(module) else { return };
        match loaded.scope.get(&name.text).copied() {
            Some(first) if first != declaration => {
                let place = self.program.item(first).and_then(declared).map(|n| n.span);
                let (message, here, there, help) = if declaration.module == module {
                    (
                        "declared twice",
                        "declared again here",
                        "first declared here",
                        "give one of them another name",
                    )
                } else if first.module == module {
                    (
                        "imported and declared, too",
                        "imported here",
                        "declared here",
                        "give the one that is declared here another name, or do not import the other",
                    )
                } else {
                    (
                        "imported from two modules",
                        "imported again here",
                        "the first one",
                        "import one of them",
                    )
                };
                let mut error =
                    Diagnostic::new(Code::DUPLICATE, name.span, format!("`{}` is {message}", name.text))
                        .label(here)
                        .help(help);
                if let Some(place) = place {
                    error = error.also(place, there);
                }
                self.errors.push(error);
            }
            _ => {
                loaded.scope.insert(name.text.clone(), declaration);
            }
        }
    }

    fn lose(&mut self, module: usize, names: Option<&[Name]>) {
        let Some(loaded) = self.program.modules.get_mut(module) else { return };
        match names {
            Some(names) => loaded.lost.extend(names.iter().map(|n| n.text.clone())),
            None => loaded.leaky = true,
        }
    }

    /// The module that a `use` or a variant names, read if it has not been yet;
    /// none, with a report, if it cannot be had.
    fn module_of(&mut self, module: &Name, from: &str) -> Option<usize> {
        let source = match self.loader.load(&module.text, from) {
            Ok(source) => source,
            Err(reason) => {
                let beside = self.loader.beside(&module.text, from);
                self.errors.push(no_module(module, &reason, (&self.loader.library(), &beside)));
                return None;
            }
        };
        let known = self.program.modules.iter().position(|m| m.name == source.name);
        let is_open = |module: usize| {
            let open = self.program.modules.get(module).map_or("", |open| open.name.as_str());
            Some(module) == known || known.is_none() && self.loader.leads_to_one(open, &source.name)
        };
        if let Some(place) = self.open.iter().position(|module| is_open(*module)) {
            let ring: Vec<&str> = self.open[place..]
                .iter()
                .filter_map(|m| self.program.modules.get(*m).map(|m| m.name.as_str()))
                .chain([source.name.as_str()])
                .collect();
            self.errors.push(
                Diagnostic::new(
                    Code::IMPORT_CYCLE,
                    module.span,
                    format!("circular import: {}", ring.join(" -> ")),
                )
                .label("this import closes the circle")
                .help("move what both need into a third file"),
            );
            return None;
        }
        if known.is_none() && self.open.len() > DEEPEST {
            self.errors.push(
                Diagnostic::new(
                    Code::TOO_DEEP,
                    module.span,
                    format!("a chain of imports is more than {DEEPEST} files long"),
                )
                .label("too deep")
                .help("import what is needed from the file that declares it"),
            );
            return None;
        }
        Some(match known {
            Some(known) => known,
            None => {
                let file = self.sources.add(source.name.clone(), source.text);
                self.module(source.name, file)
            }
        })
    }

    fn import(&mut self, into: usize, from: &str, module: &Name, names: Option<&[Name]>) {
        let Some(target) = self.module_of(module, from) else { return self.lose(into, names) };
        let Some(loaded) = self.program.modules.get(target) else { return };
        let own: IndexMap<String, Declaration> =
            loaded.scope.iter().filter(|(_, d)| d.module == target).map(|(n, d)| (n.clone(), *d)).collect();
        match names {
            None => {
                let (lost, leaky) = (loaded.lost.clone(), loaded.leaky);
                for (name, declaration) in own {
                    self.declare(into, &Name { text: name, span: module.span }, declaration);
                }
                if let Some(loaded) = self.program.modules.get_mut(into) {
                    loaded.lost.extend(lost);
                    loaded.leaky |= leaky;
                }
            }
            Some(names) => {
                for name in names {
                    match own.get(&name.text) {
                        Some(declaration) => {
                            self.imported_twice(into, name, *declaration);
                            self.declare(into, name, *declaration);
                        }
                        None => self.not_exported(into, target, module.span, name, &own),
                    }
                }
            }
        }
    }

    /// Warns of a name that an earlier import has brought already.
    fn imported_twice(&mut self, into: usize, name: &Name, declaration: Declaration) {
        let Some(loaded) = self.program.modules.get(into) else { return };
        if loaded.scope.get(&name.text) == Some(&declaration) {
            let imports = loaded.tree.items.iter().filter_map(|i| match &i.kind {
                ItemKind::Use { names: Some(names), .. } => Some(names),
                _ => None,
            });
            let first = imports.flatten().find(|n| n.text == name.text).map_or(name.span, |n| n.span);
            let mut error =
                Diagnostic::new(Code::UNUSED, name.span, format!("`{}` is imported twice", name.text));
            if first != name.span {
                error = error.also(first, "first imported here");
            }
            self.errors.push(error.label("again").help("remove one of the two imports"));
        }
    }

    fn not_exported(
        &mut self,
        into: usize,
        target: usize,
        place: Span,
        name: &Name,
        own: &IndexMap<String, Declaration>,
    ) {
        if !self.program.is_lost(target, &name.text) {
            let target = self.program.modules.get(target).map_or("", |m| m.name.as_str());
            let help = did_you_mean(&name.text, own.keys().map(String::as_str)).unwrap_or_else(|| {
                let names: Vec<&str> = own.keys().map(String::as_str).collect();
                format!("it declares: {}", names.join(", "))
            });
            self.errors.push(
                Diagnostic::new(
                    Code::NOT_EXPORTED,
                    name.span,
                    format!("`{target}` declares no `{}`", name.text),
                )
                .label("not declared there")
                .also(place, "imported from here")
                .help(help)
                .fix_if(respell(name.span, &name.text, own.keys().map(String::as_str))),
            );
        }
        self.lose(into, Some(std::slice::from_ref(name)));
        // The name that is meant is probably read further down.
        let meant = own.keys().find(|other| did_you_mean(&name.text, [other.as_str()]).is_some());
        if let Some(meant) = meant {
            let meant = Name { text: meant.clone(), ..name.clone() };
            self.lose(into, Some(std::slice::from_ref(&meant)));
        }
    }
}

/// Says that a module cannot be read: a file may be there all the same, a part of the library not.
fn no_module(module: &Name, reason: &NoModule, (library, beside): (&[String], &[String])) -> Diagnostic {
    let name = &module.text;
    let modules = || library.iter().map(String::as_str);
    if name.ends_with(".sgr") {
        return Diagnostic::new(Code::NO_MODULE, module.span, format!("cannot read the file `{name}`"))
            .label(reason.to_string())
            .help(did_you_mean(name, beside.iter().map(String::as_str)).unwrap_or_else(|| {
                "the path starts from the folder of this file; separate folders with `/`".to_owned()
            }));
    }
    let help = did_you_mean(name, modules()).unwrap_or_else(|| {
        if name.contains(['/', '\\']) {
            return "the name of a file ends in `.sgr`, as in \"./legs.sgr\"".to_owned();
        }
        let files = "other files are written as \"./file.sgr\"";
        format!("the standard library has: {}; {files}", library.join(", "))
    });
    Diagnostic::new(Code::NO_MODULE, module.span, format!("there is no module `{name}`"))
        .label(reason.to_string())
        .help(help)
        .fix_if(respell(module.span, name, modules()))
}
