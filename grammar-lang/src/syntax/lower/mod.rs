//! From pest's pairs to the syntax tree.

mod expr;
mod item;

use std::iter::once;
use std::sync::LazyLock;

use pest::iterators::Pair;

use super::ast::{
    Action, ActuationClause, Allow, Application, Block, Edit, EditKind, ExampleClause, Expr, ExprKind, Field,
    ItemKind, Joint, Link, Name, NoveltyClause, Painting, Param, Place, Port, RecordField, RuleClause,
    RuleClauseKind, State, Typed, Variable,
};
use super::parser::Rule;
use crate::diagnostics::{Code, Diagnostic};
use crate::source::{FileId, Span};

type Node<'a> = Pair<'a, Rule>;

/// Lowers pairs of one text (or of a piece of it that starts at `offset`).
pub(super) struct Lowering<'a> {
    text: &'a str,
    file: FileId,
    offset: usize,
    /// How many expressions are open.
    level: usize,
    /// Where the last declaration began whose comment was searched, and that comment.
    last_doc: (usize, String),
    /// The warnings that are allowed.
    allows: Vec<Allow>,
    errors: Vec<Diagnostic>,
}

/// The children of a node without comments.
fn children(node: Node<'_>) -> impl Iterator<Item = Node<'_>> {
    node.into_inner().filter(|p| p.as_rule() != Rule::COMMENT)
}

/// Signs, which say nothing once the rule around them is known.
const SIGNS: &[Rule] = &[
    Rule::brace_open,
    Rule::brace_close,
    Rule::bracket_open,
    Rule::bracket_close,
    Rule::paren_open,
    Rule::paren_close,
    Rule::comma,
    Rule::colon,
    Rule::equals,
    Rule::quote,
    Rule::dot,
    Rule::dots,
    Rule::arrow,
    Rule::EOI,
];

/// Reserved words that say which of several things is meant; the others say nothing, either.
const TELLING: &[Rule] = &[
    Rule::kw_adds,
    Rule::kw_exists,
    Rule::kw_forall,
    Rule::kw_is,
    Rule::kw_maximize,
    Rule::kw_minimize,
    Rule::kw_nothing,
    Rule::kw_otherwise,
];

/// Of each rule, whether it is punctuation or a reserved word: nothing to lower.
static SILENT: LazyLock<Vec<bool>> = LazyLock::new(|| {
    let words = Rule::all_rules().iter().filter(|rule| format!("{rule:?}").starts_with("kw_"));
    let words = words.filter(|rule| !TELLING.contains(rule));
    let mut silent = Vec::new();
    for rule in words.chain(SIGNS) {
        let place = *rule as usize;
        silent.resize(silent.len().max(place + 1), false);
        silent[place] = true;
    }
    silent
});

/// The children that carry meaning.
fn parts(node: Node<'_>) -> impl Iterator<Item = Node<'_>> {
    children(node).filter(|p| !SILENT.get(p.as_rule() as usize).is_some_and(|silent| *silent))
}

impl<'a> Lowering<'a> {
    pub(super) fn new(text: &'a str, file: FileId, offset: usize) -> Self {
        let last_doc = (usize::MAX, String::new());
        Self { text, file, offset, level: 0, last_doc, allows: Vec::new(), errors: Vec::new() }
    }

    /// The warnings that the text allows.
    pub(super) fn allows(&mut self) -> Vec<Allow> {
        std::mem::take(&mut self.allows)
    }

    /// Reads what a warning is allowed with.
    fn allow(&self, node: Node<'_>) -> Option<Allow> {
        let span = self.span(&node);
        let mut inner = parts(node);
        let code = self.name(&inner.next()?);
        Some(Allow { code, because: inner.next().map(|text| unquote(&text)), span, within: None })
    }

    /// Sets aside what allows a warning, and gives back everything else.
    fn unless_allow<'n>(&mut self, node: Node<'n>) -> Option<Node<'n>> {
        if node.as_rule() != Rule::allow_item {
            return Some(node);
        }
        let allow = self.allow(node);
        self.allows.extend(allow);
        None
    }

    /// The errors found since the last call.
    pub(super) fn finish(&mut self) -> Vec<Diagnostic> {
        std::mem::take(&mut self.errors)
    }

    fn span(&self, node: &Node<'_>) -> Span {
        let span = node.as_span();
        let text = span.as_str();
        // A rule may end in white space or comments that its last optional part skipped.
        let end = span.start() + text.trim_end().len();
        Span::new(self.file, self.offset + span.start(), self.offset + end)
    }

    fn name(&self, node: &Node<'_>) -> Name {
        Name { text: node.as_str().to_owned(), span: self.span(node) }
    }

    /// The `##` lines right above a place.
    fn doc(&mut self, start: usize) -> String {
        let line = self.text.get(self.last_doc.0..start);
        if line.is_none_or(|between| between.contains('\n')) {
            self.last_doc = (start, self.doc_above(start));
        }
        // Declarations in one line have one comment, which is not searched for each of them.
        self.last_doc.1.clone()
    }

    fn doc_above(&self, start: usize) -> String {
        let before = self.text.get(..start).unwrap_or("");
        let mut lines: Vec<&str> = before
            .lines()
            .rev()
            .skip(usize::from(!before.ends_with('\n') && !before.is_empty()))
            .map(str::trim)
            .take_while(|l| l.starts_with("##"))
            .map(|l| l.trim_start_matches('#').trim())
            .collect();
        lines.reverse();
        lines.join("\n")
    }

    fn side(&mut self, node: Node<'_>) -> Option<Expr> {
        let span = self.span(&node);
        let inner = parts(node).next()?;
        if inner.as_rule() == Rule::number {
            let value = inner.as_str().parse().ok()?;
            return Some(Expr { kind: ExprKind::Quantity(value, None), span });
        }
        self.expr(inner)
    }

    fn row(&mut self, node: Node<'_>) -> Option<(Expr, Expr)> {
        let mut inner = parts(node);
        Some((self.expr(inner.next()?)?, self.expr(inner.next()?)?))
    }

    fn typed(&mut self, node: Node<'_>) -> Option<Typed> {
        let mut inner = parts(node);
        Some(Typed { name: self.name(&inner.next()?), ty: self.name(&inner.next()?) })
    }

    fn record_field(&mut self, node: Node<'a>) -> Option<RecordField> {
        let mut inner = parts(node);
        let typed = self.typed(inner.next()?)?;
        Some(RecordField { typed, default: inner.next().and_then(|n| self.expr(n)) })
    }

    pub(super) fn novelty_clause(&mut self, node: Node<'a>) -> Option<NoveltyClause> {
        let node = children(node).next().and_then(|node| self.unless_allow(node))?;
        let rule = node.as_rule();
        let mut inner = parts(node);
        let first = inner.next()?;
        if rule == Rule::known_clause {
            let name = Name { text: unquote(&first), span: self.span(&first) };
            let fields = inner.filter_map(|n| self.field(n)).collect();
            return Some(NoveltyClause::Known(Block { name, method: None, fields }));
        }
        let name = self.name(&first);
        let value = self.expr(inner.next()?)?;
        let weight = inner.next().and_then(|weight| self.expr(weight));
        Some(NoveltyClause::Feature { name, value, weight })
    }

    pub(super) fn example_clause(&mut self, node: Node<'_>) -> Option<ExampleClause> {
        let node = children(node).next().and_then(|node| self.unless_allow(node))?;
        let rule = node.as_rule();
        let mut inner = parts(node.clone());
        if rule == Rule::expect_clause {
            return Some(ExampleClause::Expect(self.expr(inner.next()?)?));
        }
        let first = self.name(&inner.next()?);
        let applied = if rule == Rule::step_clause { self.name(&inner.next()?) } else { first.clone() };
        let call = inner.next()?;
        let span = applied.span.join(self.span(&call));
        let arguments = parts(call).filter_map(|a| self.argument(a)).collect();
        let application = Application { rule: applied, arguments, span };
        Some(if rule == Rule::step_clause {
            ExampleClause::Step(first, application)
        } else {
            // `by` is no child that `parts` hides: the reason is the last name.
            let reason = inner.find(|n| n.as_rule() == Rule::name);
            ExampleClause::Refuse(application, reason.map(|n| self.name(&n)))
        })
    }

    fn path(&mut self, node: Node<'_>) -> Vec<Name> {
        parts(node).map(|n| self.name(&n)).collect()
    }

    pub(super) fn edit(&mut self, node: Node<'a>) -> Option<Edit> {
        let span = self.span(&node);
        let rule = node.as_rule();
        if rule == Rule::allow_item {
            return Some(Edit { kind: EditKind::Allow(self.allow(node)?), span });
        }
        let mut inner = parts(node);
        let first = inner.next()?;
        let kind = match rule {
            Rule::set_edit => EditKind::Set(self.path(first), self.expr(inner.next()?)?),
            Rule::set_joint_edit => {
                let part = self.name(&first);
                let joint = self.joint(inner.find(|node| node.as_rule() == Rule::joint_clause)?)?;
                EditKind::SetJoint(vec![part, joint.named()], Box::new(joint))
            }
            Rule::narrow_edit => EditKind::Narrow(self.path(first), self.expr(inner.next()?)?),
            Rule::drop_edit if first.as_rule() == Rule::observe_item => {
                EditKind::DropObserved(self.path(first))
            }
            Rule::drop_edit => EditKind::Drop(self.path(first)),
            Rule::replace_edit => EditKind::Replace(Box::new(self.item(first)?)),
            _ => EditKind::Add(Box::new(self.item(first)?)),
        };
        Some(Edit { kind, span })
    }

    fn port(&mut self, node: Node<'_>) -> Option<Port> {
        let mut inner = parts(node);
        let name = self.name(&inner.next()?);
        let mut next = inner.next()?;
        let mut index = None;
        if next.as_rule() == Rule::port_index {
            let mut inside = parts(next);
            index = Some((self.name(&inside.next()?), self.expr(inside.next()?)?));
            next = inner.next()?;
        }
        Some(Port { name, index, at: self.expr(next)?, facing: self.expr(inner.next()?)? })
    }

    fn joint(&mut self, node: Node<'_>) -> Option<Joint> {
        let mut words = children(node).filter(|part| part.as_rule() != Rule::equals);
        let word = self.span(&words.next()?);
        let kind = self.name(&words.next()?);
        let mut joint = Joint { word, kind, axis: None, passive: None };
        for part in words {
            if part.as_rule() == Rule::kw_passive {
                joint.passive = Some(self.span(&part));
                continue;
            }
            let mut inner = children(part);
            joint.axis = Some((self.name(&inner.next()?), self.expr(inner.next()?)?));
        }
        Some(joint)
    }

    /// Sorts the trailing parts of `attach` and `place`.
    fn attachment(&mut self, nodes: impl Iterator<Item = Node<'a>>) -> Attachment {
        let mut out = Attachment::default();
        for node in nodes {
            let rule = node.as_rule();
            out.alone |= rule == Rule::alone_part;
            if rule == Rule::for_part {
                out.over = self.repetition(node);
                continue;
            }
            let Some(inner) = parts(node).next().filter(|_| rule != Rule::alone_part) else { continue };
            match rule {
                Rule::to_part => out.to = self.expr(inner),
                Rule::turned_part => out.turned = self.expr(inner),
                Rule::by_part => out.by = Some(self.name(&inner)),
                _ => out.product = Some(self.name(&inner)),
            }
        }
        out
    }

    /// `for i in 0 .. 3, j in 0 .. 3 where i < j`
    fn repetition(&mut self, for_part: Node<'a>) -> Repetition {
        parts(for_part).next().map_or_else(Repetition::default, |binders| self.binders(binders))
    }

    /// `i in 0 .. 3, j in 0 .. 3 where i < j`
    fn binders(&mut self, binders: Node<'a>) -> Repetition {
        let mut out = Repetition::default();
        for node in parts(binders) {
            match node.as_rule() {
                Rule::where_part => out.condition = parts(node).next().and_then(|e| self.expr(e)),
                _ => out.over.extend(self.binder(node)),
            }
        }
        out
    }

    fn link(&mut self, node: Node<'_>) -> Option<Link> {
        let mut link: Option<Link> = None;
        for part in parts(node) {
            let rule = part.as_rule();
            match (&mut link, rule) {
                (None, _) => {
                    link = Some(Link { name: self.name(&part), kind: None, owner: None, port: None });
                }
                (Some(link), Rule::owner) => link.owner = parts(part).next().map(|n| self.name(&n)),
                (Some(link), Rule::free_port) => link.port = parts(part).next().map(|n| self.name(&n)),
                (Some(link), _) => link.kind = Some(self.name(&part)),
            }
        }
        link
    }

    fn param(&mut self, node: Node<'_>) -> Option<Param> {
        let (mut domain, mut default) = (None, None);
        let mut next_is_domain = false;
        let mut words = Vec::new();
        for part in children(node) {
            match part.as_rule() {
                Rule::name | Rule::type_name => words.push(self.name(&part)),
                Rule::kw_in => next_is_domain = true,
                Rule::equals => next_is_domain = false,
                Rule::expr if next_is_domain => domain = self.expr(part),
                Rule::expr => default = self.expr(part),
                _ => {}
            }
        }
        let mut words = words.into_iter();
        Some(Param { name: words.next()?, ty: words.next()?, domain, default })
    }

    fn block(&mut self, node: Node<'_>) -> Option<Block> {
        let mut inner = parts(node).peekable();
        let name = self.name(&inner.next()?);
        let method = inner.next_if(|n| n.as_rule() == Rule::method).map(|n| self.name(&n));
        Some(Block { name, method, fields: inner.filter_map(|n| self.field(n)).collect() })
    }

    pub(super) fn field(&mut self, node: Node<'_>) -> Option<Field> {
        let node = children(node).next().and_then(|node| self.unless_allow(node))?;
        Some(match node.as_rule() {
            Rule::param_item => Field::Param(self.param(node)?),
            Rule::port_clause => Field::Port(Box::new(self.port(node)?)),
            Rule::joint_clause => Field::Joint(Box::new(self.joint(node)?)),
            Rule::group => Field::Group(self.block(node)?),
            _ => {
                let mut inner = parts(node);
                Field::Value(self.name(&inner.next()?), self.expr(inner.next()?)?)
            }
        })
    }

    pub(super) fn place(&mut self, node: Node<'a>) -> Option<Place> {
        let mut inner = parts(node);
        let (name, what) = (self.name(&inner.next()?), self.expr(inner.next()?)?);
        let Attachment { to, turned, by, alone, .. } = self.attachment(inner);
        Some(Place { name, what, to, turned, by, alone })
    }

    /// `fill`, `paint` or `clear`.
    pub(super) fn cells(&mut self, node: Node<'a>) -> Option<RuleClause> {
        let span = self.span(&node);
        let how = match node.as_rule() {
            Rule::fill_clause => Painting::Fill,
            Rule::paint_clause => Painting::Paint,
            _ => Painting::Clear,
        };
        let mut inner = parts(node).peekable();
        let region = self.expr(inner.next()?)?;
        let with = inner.next_if(|n| n.as_rule() == Rule::expr).and_then(|n| self.expr(n));
        let over = inner.next().map_or_else(Repetition::default, |part| self.repetition(part));
        Some(repeated(RuleClauseKind::Cells { how, region, with }, over, span))
    }

    pub(super) fn rule_clause(&mut self, node: Node<'a>) -> Option<RuleClause> {
        let span = self.span(&node);
        let node = children(node).next().and_then(|node| self.unless_allow(node))?;
        let rule = node.as_rule();
        let mut inner = parts(node.clone());
        let kind = match rule {
            Rule::match_clause => {
                let (mut links, mut condition) = (Vec::new(), None);
                for part in inner {
                    match part.as_rule() {
                        Rule::kw_nothing => {
                            return Some(RuleClause { kind: RuleClauseKind::MatchNothing, span });
                        }
                        Rule::where_part => condition = parts(part).next().and_then(|e| self.expr(e)),
                        Rule::link => links.extend(self.link(part)),
                        _ => {}
                    }
                }
                RuleClauseKind::Match { links, condition }
            }
            Rule::choose_clause => RuleClauseKind::Choose(
                self.name(&inner.next()?),
                self.expr(inner.next()?)?,
                inner.find(|n| n.as_rule() == Rule::expr).and_then(|e| self.expr(e)),
            ),
            Rule::let_item => match self.definition(node)? {
                ItemKind::Let(name, None, value) => RuleClauseKind::Let(name, value),
                _ => return self.no_function_here(span),
            },
            Rule::when_clause => RuleClauseKind::Guard(true, self.expr(inner.next()?)?),
            Rule::unless_clause => RuleClauseKind::Guard(false, self.expr(inner.next()?)?),
            Rule::attach_clause => {
                let what = self.expr(inner.next()?)?;
                let Attachment { to, turned, by, alone, product, over } = self.attachment(inner);
                let attach = RuleClauseKind::Attach { what, port: to?, turned, by, alone, product };
                return Some(repeated(attach, over, span));
            }
            Rule::remove_clause => {
                let part = self.expr(inner.next()?)?;
                let over = inner.next().map_or_else(Repetition::default, |part| self.repetition(part));
                return Some(repeated(RuleClauseKind::Remove(part), over, span));
            }
            Rule::replace_clause => {
                let (part, with) = (self.expr(inner.next()?)?, self.expr(inner.next()?)?);
                let (mut between, mut product) = (None, None);
                for node in inner {
                    let rule = node.as_rule();
                    let mut inside = parts(node);
                    if rule == Rule::between_part {
                        between = Some((self.expr(inside.next()?)?, self.expr(inside.next()?)?));
                    } else if rule == Rule::as_part {
                        product = inside.next().map(|n| self.name(&n));
                    }
                }
                RuleClauseKind::Replace { part, with, between, product }
            }
            Rule::set_clause => {
                let (target, value) = (self.expr(inner.next()?)?, self.expr(inner.next()?)?);
                let over = inner.next().map_or_else(Repetition::default, |part| self.repetition(part));
                return Some(repeated(RuleClauseKind::Set { target, value }, over, span));
            }
            Rule::repeat_clause => {
                let Repetition { over, condition } = self.binders(inner.next()?);
                let clauses = inner.filter_map(|n| self.rule_clause(n));
                RuleClauseKind::Repeat {
                    over,
                    clauses: condition.map(guard).into_iter().chain(clauses).collect(),
                }
            }
            Rule::if_clause => {
                let condition = guard(self.expr(inner.next()?)?);
                let clauses = inner.filter_map(|n| self.rule_clause(n));
                // Done once, where the condition holds.
                RuleClauseKind::Repeat { over: Vec::new(), clauses: once(condition).chain(clauses).collect() }
            }
            Rule::then_clause => RuleClauseKind::Then,
            Rule::always_clause => RuleClauseKind::Always,
            Rule::revert_clause => RuleClauseKind::Revert(self.expr(inner.next()?)?),
            Rule::fill_clause | Rule::paint_clause | Rule::clear_clause => return self.cells(node),
            _ => RuleClauseKind::Weight(self.expr(inner.next()?)?),
        };
        Some(RuleClause { kind, span })
    }

    pub(super) fn actuation_clause(&mut self, node: Node<'a>) -> Option<ActuationClause> {
        let node = children(node).next().and_then(|node| self.unless_allow(node))?;
        let rule = node.as_rule();
        let mut inner = parts(node.clone());
        Some(match rule {
            Rule::shared_clause | Rule::vary_clause => ActuationClause::Variable(Box::new(
                self.variable(rule == Rule::shared_clause, inner.next()?)?,
            )),
            Rule::state_clause => ActuationClause::State(Box::new(State {
                name: self.name(&inner.next()?),
                ty: self.name(&inner.next()?),
                from: self.expr(inner.next()?)?,
                next: self.expr(inner.next()?)?,
            })),
            Rule::action_clause => ActuationClause::Action(Box::new(Action {
                name: self.name(&inner.next()?),
                ty: self.name(&inner.next()?),
                domain: self.expr(inner.next()?)?,
                policy: self.name(&inner.next()?),
                inputs: inner.next().and_then(|inputs| self.expr(inputs)),
            })),
            Rule::let_item => match self.definition(node)? {
                ItemKind::Let(name, None, value) => ActuationClause::Let(name, value),
                ItemKind::Let(name, ..) => {
                    self.no_function_here::<()>(name.span);
                    return None;
                }
                _ => return None,
            },
            _ => ActuationClause::Drive(self.name(&inner.next()?), self.expr(inner.next()?)?),
        })
    }

    /// Reports a function where only a value can be named.
    fn no_function_here<T>(&mut self, span: Span) -> Option<T> {
        self.errors.push(
            Diagnostic::new(Code::SYNTAX, span, "a function cannot be declared inside a block")
                .label("only a value can be named here")
                .help("declare it outside, at the start of a line"),
        );
        None
    }

    fn variable(&mut self, shared: bool, node: Node<'_>) -> Option<Variable> {
        let mut words = Vec::new();
        let (mut size, mut domain, mut from, mut per) = (None, None, None, None);
        let (mut mutate, mut flip, mut bound) = (None, None, None);
        for part in parts(node) {
            match part.as_rule() {
                Rule::array_size => size = parts(part).next().and_then(|e| self.expr(e)),
                Rule::expr => domain = self.expr(part),
                Rule::begin_value => from = parts(part).next().and_then(|e| self.expr(e)),
                Rule::per_part => per = parts(part).next().and_then(|e| self.expr(e)),
                Rule::mutate_part => {
                    let mut inner = parts(part);
                    mutate = Some((self.expr(inner.next()?)?, self.expr(inner.next()?)?));
                }
                Rule::flip_part => flip = parts(part).next().and_then(|e| self.expr(e)),
                Rule::bound_part => bound = parts(part).next().map(|n| self.name(&n)),
                _ => words.push(self.name(&part)),
            }
        }
        let mut words = words.into_iter();
        let (name, ty) = (words.next()?, words.next()?);
        Some(Variable { shared, name, size, ty, domain, from, per, mutate, flip, bound })
    }
}

/// The trailing parts of `attach` and `place`.
#[derive(Default)]
struct Attachment {
    to: Option<Expr>,
    turned: Option<Expr>,
    by: Option<Name>,
    alone: bool,
    product: Option<Name>,
    over: Repetition,
}

/// What a clause is repeated for.
#[derive(Default)]
struct Repetition {
    over: Vec<super::ast::Binder>,
    /// For which of them.
    condition: Option<Expr>,
}

/// A clause that may be repeated.
fn repeated(kind: RuleClauseKind, Repetition { over, condition }: Repetition, span: Span) -> RuleClause {
    let clause = RuleClause { kind, span };
    if over.is_empty() {
        return clause;
    }
    let clauses = condition.map(guard).into_iter().chain(once(clause)).collect();
    RuleClause { kind: RuleClauseKind::Repeat { over, clauses }, span }
}

/// The condition of a block, for all that stands in it.
fn guard(condition: Expr) -> RuleClause {
    RuleClause { span: condition.span, kind: RuleClauseKind::Guard(true, condition) }
}

fn unquote(node: &Node<'_>) -> String {
    let inner = node.as_str().trim_matches('"');
    let mut out = String::with_capacity(inner.len());
    let mut escaped = false;
    for c in inner.chars() {
        if escaped {
            out.push(c);
            escaped = false;
        } else if c == '\\' {
            escaped = true;
        } else if !c.is_control() {
            // A terminal would obey control characters.
            out.push(c);
        }
    }
    out
}
