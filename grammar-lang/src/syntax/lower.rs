//! From pest's pairs to the syntax tree.

use pest::iterators::Pair;

use super::ast::{
    ActuationClause, Argument, Binder, Block, Expr, ExprKind, Field, Gather, Item, ItemKind, Name, Operator,
    Param, Place, RuleClause, RuleClauseKind, Variable,
};
use super::parse::Rule;
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
    errors: Vec<Diagnostic>,
}

/// The longest chain of operators or suffixes, and the deepest expression: all
/// that walks the tree recurses as deep as it is.
const LONGEST_CHAIN: usize = 200;
const DEEPEST: usize = 300;

/// The children of a node without comments.
fn children(node: Node<'_>) -> impl Iterator<Item = Node<'_>> {
    node.into_inner().filter(|p| p.as_rule() != Rule::COMMENT)
}

/// Whether a rule is punctuation or a reserved word: nothing to lower.
fn silent(rule: Rule) -> bool {
    use Rule as R;
    matches!(
        rule,
        R::brace_open
            | R::brace_close
            | R::bracket_open
            | R::bracket_close
            | R::paren_open
            | R::paren_close
            | R::comma
            | R::colon
            | R::equals
            | R::dots
            | R::dot
            | R::quote
            | R::kw_grammar
            | R::kw_use
            | R::kw_param
            | R::kw_part
            | R::kw_actuator
            | R::kw_symmetry
            | R::kw_begin
            | R::kw_rule
            | R::kw_require
            | R::kw_pattern
            | R::kw_actuation
            | R::kw_actuate
            | R::kw_model
            | R::kw_simulate
            | R::kw_term
            | R::kw_search
            | R::kw_let
            | R::kw_place
            | R::kw_match
            | R::kw_choose
            | R::kw_when
            | R::kw_unless
            | R::kw_attach
            | R::kw_to
            | R::kw_turned
            | R::kw_set
            | R::kw_revert
            | R::kw_weight
            | R::kw_shared
            | R::kw_vary
            | R::kw_drive
            | R::kw_mutate
            | R::kw_by
            | R::kw_flip
            | R::kw_bound
            | R::kw_because
            | R::kw_in
            | R::kw_for
            | R::kw_with
            | R::kw_free
            | R::kw_port
            | R::kw_where
            | R::kw_of
            | R::kw_over
            | R::kw_at
            | R::kw_and
            | R::kw_or
            | R::kw_not
            | R::kw_if
            | R::kw_then
            | R::kw_else
            | R::EOI
    )
}

/// The children that carry meaning.
fn parts(node: Node<'_>) -> impl Iterator<Item = Node<'_>> {
    children(node).filter(|p| !silent(p.as_rule()))
}

impl<'a> Lowering<'a> {
    pub(super) fn new(text: &'a str, file: FileId, offset: usize) -> Self {
        Self { text, file, offset, level: 0, errors: Vec::new() }
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
    fn doc(&self, start: usize) -> String {
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

    pub(super) fn item(&mut self, node: Node<'_>) -> Option<Item> {
        let span = self.span(&node);
        let doc = self.doc(node.as_span().start());
        let kind = self.item_kind(children(node).next()?)?;
        Some(Item { kind, span, doc, damaged: false })
    }

    fn item_kind(&mut self, node: Node<'_>) -> Option<ItemKind> {
        let rule = node.as_rule();
        if rule == Rule::objective_item {
            let mut inner = children(node);
            let maximize = inner.next()?.as_rule() == Rule::kw_maximize;
            return Some(ItemKind::Objective { maximize, value: self.expr(inner.next()?)? });
        }
        let mut inner = parts(node.clone());
        Some(match rule {
            Rule::grammar_item => ItemKind::Grammar(self.name(&inner.next()?)),
            Rule::use_item => {
                let module = inner.next()?;
                let module = match module.as_rule() {
                    Rule::text => Name { text: unquote(&module), span: self.span(&module) },
                    _ => self.name(&module),
                };
                let names = inner.next().map(|list| parts(list).map(|n| self.name(&n)).collect());
                ItemKind::Use { module, names }
            }
            Rule::param_item => ItemKind::Param(self.param(node)?),
            Rule::part_item => ItemKind::Part(self.block(node)?),
            Rule::actuator_item => ItemKind::Actuator(self.block(node)?),
            Rule::model_item => ItemKind::Model(self.block(node)?),
            Rule::search_item => {
                if children(node.clone()).any(|p| p.as_rule() == Rule::brace_open) {
                    ItemKind::Search(self.block(node)?)
                } else {
                    ItemKind::UseSearch(self.name(&inner.next()?))
                }
            }
            Rule::symmetry_item => {
                let what = self.name(&inner.next()?);
                ItemKind::Symmetry(what, inner.next().map(|n| self.name(&n)))
            }
            Rule::begin_item => ItemKind::Begin(inner.filter_map(|n| self.place(n)).collect()),
            Rule::rule_item => {
                let name = self.name(&inner.next()?);
                ItemKind::Rule(name, inner.filter_map(|n| self.rule_clause(n)).collect())
            }
            Rule::require_item => {
                let mut name = None;
                let mut condition = None;
                let mut because = None;
                for part in inner {
                    match part.as_rule() {
                        Rule::name => name = Some(self.name(&part)),
                        Rule::text => because = Some(unquote(&part)),
                        _ => condition = self.expr(part),
                    }
                }
                ItemKind::Require { name, condition: condition?, because }
            }
            Rule::pattern_item => ItemKind::Pattern(self.name(&inner.next()?), self.expr(inner.next()?)?),
            Rule::actuation_item => ItemKind::Actuation {
                name: self.name(&inner.next()?),
                binder: self.name(&inner.next()?),
                kind: self.name(&inner.next()?),
                clauses: inner.filter_map(|n| self.actuation_clause(n)).collect(),
            },
            Rule::actuate_item => ItemKind::Actuate(self.name(&inner.next()?), self.name(&inner.next()?)),
            Rule::simulate_item => ItemKind::Simulate(self.name(&inner.next()?), self.expr(inner.next()?)?),
            Rule::term_item => ItemKind::Term(
                self.name(&inner.next()?),
                self.name(&inner.next()?),
                self.expr(inner.next()?)?,
            ),
            Rule::let_item => ItemKind::Let(self.name(&inner.next()?), self.expr(inner.next()?)?),
            _ => return None,
        })
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
        let mut inner = parts(node);
        let name = self.name(&inner.next()?);
        Some(Block { name, fields: inner.filter_map(|n| self.field(n)).collect() })
    }

    pub(super) fn field(&mut self, node: Node<'_>) -> Option<Field> {
        let node = children(node).next()?;
        Some(match node.as_rule() {
            Rule::param_item => Field::Param(self.param(node)?),
            Rule::group => Field::Group(self.block(node)?),
            _ => {
                let mut inner = parts(node);
                Field::Value(self.name(&inner.next()?), self.expr(inner.next()?)?)
            }
        })
    }

    pub(super) fn place(&mut self, node: Node<'_>) -> Option<Place> {
        let mut inner = parts(node);
        Some(Place { name: self.name(&inner.next()?), kind: self.name(&inner.next()?) })
    }

    pub(super) fn rule_clause(&mut self, node: Node<'_>) -> Option<RuleClause> {
        let span = self.span(&node);
        let node = children(node).next()?;
        let rule = node.as_rule();
        let mut inner = parts(node.clone());
        let kind = match rule {
            Rule::match_clause => {
                let mut words = Vec::new();
                let (mut port, mut condition) = (None, None);
                for part in inner {
                    match part.as_rule() {
                        Rule::kw_nothing => {
                            return Some(RuleClause { kind: RuleClauseKind::MatchNothing, span });
                        }
                        Rule::free_port => port = parts(part).next().map(|n| self.name(&n)),
                        Rule::where_part => condition = parts(part).next().and_then(|e| self.expr(e)),
                        _ => words.push(self.name(&part)),
                    }
                }
                let mut words = words.into_iter();
                RuleClauseKind::Match { name: words.next()?, kind: words.next()?, port, condition }
            }
            Rule::choose_clause => {
                RuleClauseKind::Choose(self.name(&inner.next()?), self.expr(inner.next()?)?)
            }
            Rule::when_clause => RuleClauseKind::Guard(true, self.expr(inner.next()?)?),
            Rule::unless_clause => RuleClauseKind::Guard(false, self.expr(inner.next()?)?),
            Rule::attach_clause => RuleClauseKind::Attach {
                what: self.expr(inner.next()?)?,
                port: self.expr(inner.next()?)?,
                turned: inner.next().and_then(|e| self.expr(e)),
            },
            Rule::set_clause => RuleClauseKind::Set(self.expr(inner.next()?)?, self.expr(inner.next()?)?),
            Rule::revert_clause => RuleClauseKind::Revert(self.expr(inner.next()?)?),
            _ => RuleClauseKind::Weight(self.expr(inner.next()?)?),
        };
        Some(RuleClause { kind, span })
    }

    pub(super) fn actuation_clause(&mut self, node: Node<'_>) -> Option<ActuationClause> {
        let node = children(node).next()?;
        let rule = node.as_rule();
        let mut inner = parts(node);
        Some(match rule {
            Rule::shared_clause | Rule::vary_clause => ActuationClause::Variable(Box::new(
                self.variable(rule == Rule::shared_clause, inner.next()?)?,
            )),
            Rule::let_item => ActuationClause::Let(self.name(&inner.next()?), self.expr(inner.next()?)?),
            _ => ActuationClause::Drive(self.name(&inner.next()?), self.expr(inner.next()?)?),
        })
    }

    fn variable(&mut self, shared: bool, node: Node<'_>) -> Option<Variable> {
        let mut words = Vec::new();
        let (mut size, mut domain, mut mutate, mut flip, mut bound) = (None, None, None, None, None);
        for part in parts(node) {
            match part.as_rule() {
                Rule::array_size => size = parts(part).next().and_then(|e| self.expr(e)),
                Rule::expr => domain = self.expr(part),
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
        Some(Variable { shared, name, size, ty, domain, mutate, flip, bound })
    }

    fn too_deep(&mut self, span: Span) {
        self.errors.push(
            Diagnostic::new(Code::TOO_DEEP, span, "this expression is too long or too deeply nested")
                .label("more than can be followed")
                .help("give parts of it a name with `let`"),
        );
    }

    /// Lowers any of the expression rules.
    fn expr(&mut self, node: Node<'_>) -> Option<Expr> {
        self.level += 1;
        let whole = self.span(&node);
        let expr = self.expr_of(node);
        self.level -= 1;
        if self.level == 0 && expr.as_ref().is_some_and(|e| depth(e) > DEEPEST) {
            self.too_deep(whole);
            return None;
        }
        expr
    }

    fn expr_of(&mut self, node: Node<'_>) -> Option<Expr> {
        let span = self.span(&node);
        let rule = node.as_rule();
        if matches!(rule, Rule::disjunction | Rule::conjunction | Rule::sum | Rule::product | Rule::postfix)
            && node.clone().into_inner().nth(2 * LONGEST_CHAIN).is_some()
        {
            self.too_deep(span);
            return None;
        }
        let at = |kind| Some(Expr { kind, span });
        match rule {
            Rule::expr => {
                let mut inner = parts(node);
                let value = self.expr(inner.next()?)?;
                match inner.next() {
                    Some(unit) => {
                        let unit = self.name(&unit);
                        at(ExprKind::Convert(Box::new(value), unit))
                    }
                    None => Some(value),
                }
            }
            Rule::range => {
                let mut inner = parts(node);
                let low = self.expr(inner.next()?)?;
                match inner.next() {
                    Some(high) => at(ExprKind::Range(Box::new(low), Box::new(self.expr(high)?))),
                    None => Some(low),
                }
            }
            Rule::disjunction | Rule::conjunction => {
                let operator = if rule == Rule::disjunction { Operator::Or } else { Operator::And };
                let mut inner = parts(node);
                let mut left = self.expr(inner.next()?)?;
                for right in inner {
                    left = binary(left, operator, self.expr(right)?);
                }
                Some(left)
            }
            Rule::negation => {
                let mut inner = children(node);
                let first = inner.next()?;
                if first.as_rule() == Rule::kw_not {
                    let value = self.expr(inner.next()?)?;
                    return at(ExprKind::Not(Box::new(value)));
                }
                self.expr(first)
            }
            Rule::comparison | Rule::sum | Rule::product => {
                let mut inner = parts(node);
                let mut left = self.expr(inner.next()?)?;
                while let Some(operator) = inner.next() {
                    let operator = operator_of(operator.as_str())?;
                    left = binary(left, operator, self.expr(inner.next()?)?);
                }
                Some(left)
            }
            Rule::sign => {
                let mut inner = children(node);
                let first = inner.next()?;
                if first.as_rule() == Rule::minus {
                    let value = self.expr(inner.next()?)?;
                    return at(ExprKind::Negate(Box::new(value)));
                }
                self.expr(first)
            }
            Rule::at_time => {
                let mut inner = parts(node);
                let value = self.expr(inner.next()?)?;
                match inner.next() {
                    Some(time) => at(ExprKind::At(Box::new(value), Box::new(self.expr(time)?))),
                    None => Some(value),
                }
            }
            Rule::postfix => self.postfix(node),
            Rule::primary => {
                let inner = parts(node).next()?;
                // With its brackets, if it has some.
                self.expr(inner).map(|e| Expr { span, ..e })
            }
            Rule::condition => {
                let mut inner = parts(node);
                let mut next = || inner.next().and_then(|e| self.expr(e)).map(Box::new);
                at(ExprKind::If(next()?, next()?, next()?))
            }
            Rule::quantifier | Rule::aggregate => self.aggregate(node, span),
            Rule::quantity => {
                let mut inner = parts(node);
                let number = inner.next()?;
                let value: f64 = number.as_str().parse().ok()?;
                if !value.is_finite() {
                    self.errors.push(
                        Diagnostic::new(Code::BAD_NUMBER, self.span(&number), "this number is too large")
                            .label("larger than 1.8e308"),
                    );
                    return None;
                }
                let unit = inner.next().map(|u| self.name(&u));
                at(ExprKind::Quantity(value, unit))
            }
            Rule::text => at(ExprKind::Text(unquote(&node))),
            Rule::boolean => at(ExprKind::Bool(node.as_str() == "true")),
            Rule::set | Rule::list => {
                let items = parts(node).filter_map(|e| self.expr(e)).collect();
                at(if rule == Rule::set { ExprKind::Set(items) } else { ExprKind::List(items) })
            }
            Rule::name | Rule::kind_word => at(ExprKind::Name(node.as_str().to_owned())),
            _ => None,
        }
    }

    fn postfix(&mut self, node: Node<'_>) -> Option<Expr> {
        let mut inner = parts(node);
        let mut value = self.expr(inner.next()?)?;
        for suffix in inner {
            let span = value.span.join(self.span(&suffix));
            let kind = match suffix.as_rule() {
                Rule::member => {
                    let name = parts(suffix).next()?;
                    ExprKind::Member(Box::new(value), self.name(&name))
                }
                Rule::call => {
                    let arguments = parts(suffix).filter_map(|a| self.argument(a)).collect();
                    ExprKind::Call(Box::new(value), arguments)
                }
                _ => {
                    let index = parts(suffix).next()?;
                    ExprKind::Index(Box::new(value), Box::new(self.expr(index)?))
                }
            };
            value = Expr { kind, span };
        }
        Some(value)
    }

    fn argument(&mut self, node: Node<'_>) -> Option<Argument> {
        let mut inner = parts(node);
        let first = inner.next()?;
        if first.as_rule() == Rule::name {
            return Some(Argument { name: Some(self.name(&first)), value: self.expr(inner.next()?)? });
        }
        Some(Argument { name: None, value: self.expr(first)? })
    }

    fn aggregate(&mut self, node: Node<'_>, span: Span) -> Option<Expr> {
        let quantifier = node.as_rule() == Rule::quantifier;
        let mut how = Gather::Forall;
        let (mut binders, mut condition, mut body, mut otherwise) = (Vec::new(), None, None, None);
        let mut after_otherwise = false;
        for part in children(node) {
            match part.as_rule() {
                Rule::kw_exists => how = Gather::Exists,
                Rule::kw_otherwise => after_otherwise = true,
                Rule::aggregate_word => {
                    how = match part.as_str() {
                        "count" => Gather::Count,
                        "sum" => Gather::Sum,
                        "mean" => Gather::Mean,
                        "min" => Gather::Min,
                        _ => Gather::Max,
                    };
                }
                Rule::binders => {
                    for inner in parts(part) {
                        if inner.as_rule() == Rule::where_part {
                            condition = parts(inner).next().and_then(|e| self.expr(e)).map(Box::new);
                            continue;
                        }
                        let mut inner = parts(inner);
                        binders.push(Binder {
                            name: self.name(&inner.next()?),
                            over: self.expr(inner.next()?)?,
                        });
                    }
                }
                Rule::expr if after_otherwise => otherwise = self.expr(part).map(Box::new),
                Rule::expr => body = self.expr(part).map(Box::new),
                _ => {}
            }
        }
        if !quantifier && (body.is_none() != (how == Gather::Count)) {
            let (message, help) = if how == Gather::Count {
                ("`count over` takes no `of`", "`count over x in xs where condition` counts the items")
            } else {
                ("this aggregate lacks `of`", "say what is gathered: `min over e in elements of ...`")
            };
            self.errors.push(Diagnostic::new(Code::SYNTAX, span, message).help(help));
            return None;
        }
        Some(Expr { kind: ExprKind::Aggregate { how, binders, condition, body, otherwise }, span })
    }
}

/// How deep an expression is, found without recursion.
fn depth(expr: &Expr) -> usize {
    let mut deepest = 0;
    let mut open = vec![(expr, 1)];
    while let Some((e, depth)) = open.pop() {
        deepest = deepest.max(depth);
        let mut push = |e| open.push((e, depth + 1));
        match &e.kind {
            ExprKind::Member(a, _) | ExprKind::Negate(a) | ExprKind::Not(a) | ExprKind::Convert(a, _) => {
                push(a)
            }
            ExprKind::Index(a, b)
            | ExprKind::At(a, b)
            | ExprKind::Binary(a, _, b)
            | ExprKind::Range(a, b) => {
                push(a);
                push(b);
            }
            ExprKind::If(a, b, c) => [a, b, c].into_iter().for_each(|e| push(e)),
            ExprKind::Call(f, arguments) => {
                push(f);
                arguments.iter().for_each(|a| push(&a.value));
            }
            ExprKind::Set(items) | ExprKind::List(items) => items.iter().for_each(push),
            ExprKind::Aggregate { binders, condition, body, otherwise, .. } => {
                binders.iter().for_each(|b| push(&b.over));
                [condition, body, otherwise].into_iter().flatten().for_each(|e| push(e));
            }
            ExprKind::Quantity(..) | ExprKind::Text(_) | ExprKind::Bool(_) | ExprKind::Name(_) => {}
        }
    }
    deepest
}

fn binary(left: Expr, operator: Operator, right: Expr) -> Expr {
    let span = left.span.join(right.span);
    Expr { kind: ExprKind::Binary(Box::new(left), operator, Box::new(right)), span }
}

fn operator_of(text: &str) -> Option<Operator> {
    Some(match text {
        "+" => Operator::Add,
        "-" => Operator::Subtract,
        "*" => Operator::Multiply,
        "/" => Operator::Divide,
        "<" => Operator::Less,
        "<=" => Operator::LessEqual,
        ">" => Operator::Greater,
        ">=" => Operator::GreaterEqual,
        "==" => Operator::Equal,
        "!=" => Operator::NotEqual,
        "is" => Operator::Is,
        "adds" => Operator::Adds,
        text if text.starts_with("is") => Operator::IsNot,
        _ => return None,
    })
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
