//! Lowers expressions to the syntax tree.

use std::iter::Peekable;

use pest::iterators::Pairs;

use super::super::ast::{Argument, Binder, Expr, ExprKind, Gather, Operator};
use super::super::levels::Level;
use super::super::parser::Rule;
use super::{Lowering, Node, children, parts, unquote};
use crate::diagnostics::{Code, Diagnostic};
use crate::source::Span;
use crate::units;

/// The longest chain of operators or suffixes, and the deepest expression: all
/// that walks the tree recurses as deep as it is.
const LONGEST_CHAIN: usize = 200;
const DEEPEST: usize = 300;

impl Lowering<'_> {
    fn too_deep(&mut self, span: Span) {
        self.errors.push(
            Diagnostic::new(Code::TOO_DEEP, span, "this expression is too long or too deeply nested")
                .label("the limit is exceeded here")
                .help("give parts of it a name with `let`"),
        );
    }

    /// Lowers any of the expression rules.
    pub(super) fn expr(&mut self, node: Node<'_>) -> Option<Expr> {
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
        let at = |kind| Some(Expr { kind, span });
        match rule {
            Rule::expr | Rule::range | Rule::sum => {
                let mut row = children(node).peekable();
                let value = self.level(Level::loosest(rule), &mut row)?;
                match row.find(|n| n.as_rule() == Rule::unit_text) {
                    Some(unit) => at(ExprKind::Convert(Box::new(value), self.name(&unit))),
                    None => Some(value),
                }
            }
            Rule::postfix => {
                let inner = node.into_inner();
                if inner.len() > 2 * LONGEST_CHAIN {
                    self.too_deep(span);
                    return None;
                }
                self.postfix(inner)
            }
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
            Rule::cases => {
                let mut inner = parts(node).filter(|n| n.as_rule() != Rule::kw_match);
                let value = self.expr(inner.next()?)?;
                let (mut arms, mut otherwise) = (Vec::new(), None);
                for arm in inner {
                    let is_else = children(arm.clone()).any(|n| n.as_rule() == Rule::kw_else);
                    let mut inside = parts(arm);
                    let first = self.expr(inside.next()?)?;
                    if is_else {
                        otherwise = Some(Box::new(first));
                    } else {
                        arms.push((first, self.expr(inside.next()?)?));
                    }
                }
                at(ExprKind::Cases(Box::new(value), arms, otherwise))
            }
            Rule::quantity => {
                let mut inner = parts(node);
                let number = inner.next()?;
                let value: f64 = number.as_str().parse().ok()?;
                // What is wrong with the number alone hides nothing else: the expression is read on.
                let unfit = |message| Diagnostic::new(Code::BAD_NUMBER, self.span(&number), message);
                if value > units::LARGEST {
                    self.errors.push(
                        unfit("this number is too large")
                            .label("larger than 1e100")
                            .help("no quantity of a robot is this large: remove a zero or the exponent"),
                    );
                } else if is_rounded(number.as_str(), value) {
                    self.errors.push(
                        unfit("this whole number has more digits than can be stored")
                            .label(format!("would be stored as {value}"))
                            .help("whole numbers up to 9007199254740992 are exact; write a larger one as `1e20`"),
                    );
                }
                let value = value.min(units::LARGEST);
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

    /// Lowers as much of a row of operators and operands as belongs to a level.
    fn level<'n>(
        &mut self,
        level: Option<Level>,
        row: &mut Peekable<impl Iterator<Item = Node<'n>>>,
    ) -> Option<Expr> {
        let Some(level) = level else { return self.expr(row.next()?) };
        let is_operator = |n: &Node<'_>| level.has(n.as_rule());
        if level.is_prefix() {
            let Some(operator) = row.next_if(is_operator) else { return self.level(level.tighter(), row) };
            let span = self.span(&operator);
            let value = Box::new(self.level(Some(level), row)?);
            let span = span.join(value.span);
            let kind = if level == Level::Negation { ExprKind::Not(value) } else { ExprKind::Negate(value) };
            return Some(Expr { kind, span });
        }
        let mut left = self.level(level.tighter(), row)?;
        let mut length = 0;
        while let Some(operator) = row.next_if(is_operator) {
            let right = self.level(level.tighter(), row)?;
            length += 1;
            left = if length < LONGEST_CHAIN {
                joined(level, left, &operator, right)?
            } else {
                Expr { span: left.span.join(right.span), ..left }
            };
        }
        if length >= LONGEST_CHAIN {
            self.too_deep(left.span);
            return None;
        }
        Some(left)
    }

    fn postfix(&mut self, inner: Pairs<'_, Rule>) -> Option<Expr> {
        let mut inner = inner.filter(|p| p.as_rule() != Rule::COMMENT);
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

    pub(super) fn argument(&mut self, node: Node<'_>) -> Option<Argument> {
        let mut inner = parts(node);
        let first = inner.next()?;
        if first.as_rule() == Rule::name {
            return Some(Argument { name: Some(self.name(&first)), value: self.expr(inner.next()?)? });
        }
        Some(Argument { name: None, value: self.expr(first)? })
    }

    /// `x in RANGE`
    pub(super) fn binder(&mut self, node: Node<'_>) -> Option<Binder> {
        let mut inner = parts(node);
        Some(Binder { name: self.name(&inner.next()?), over: self.expr(inner.next()?)? })
    }

    fn aggregate(&mut self, node: Node<'_>, span: Span) -> Option<Expr> {
        let quantifier = node.as_rule() == Rule::quantifier;
        let (mut how, mut share) = (Gather::Forall, None);
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
                        "deviation" => Gather::Deviation,
                        "clusters" => Gather::Clusters,
                        _ => Gather::Max,
                    };
                }
                Rule::quantile => {
                    how = Gather::Quantile;
                    share = Some(Box::new(self.expr(parts(part).next()?)?));
                }
                Rule::binders => {
                    for inner in parts(part) {
                        if inner.as_rule() == Rule::where_part {
                            condition = parts(inner).next().and_then(|e| self.expr(e)).map(Box::new);
                            continue;
                        }
                        binders.push(self.binder(inner)?);
                    }
                }
                Rule::sum if after_otherwise => otherwise = self.expr(part).map(Box::new),
                Rule::expr | Rule::sum => body = self.expr(part).map(Box::new),
                _ => {}
            }
        }
        if !quantifier && how != Gather::Clusters && (body.is_none() != (how == Gather::Count)) {
            let (message, help) = if how == Gather::Count {
                ("`count over` takes no `of`", "`count over x in xs where condition` counts the items")
            } else {
                (
                    "this aggregate lacks `of`",
                    "write `of` and the value to add up: `sum over p in part of p.mass`",
                )
            };
            self.errors.push(Diagnostic::new(Code::SYNTAX, span, message).help(help));
            return None;
        }
        Some(Expr { kind: ExprKind::Aggregate { how, share, binders, condition, body, otherwise }, span })
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
            ExprKind::Narrowed(a, b) | ExprKind::Exchanged(a, b) => [a, b].into_iter().for_each(|e| push(e)),
            ExprKind::Cases(value, arms, otherwise) => {
                push(value);
                arms.iter().flat_map(|(a, b)| [a, b]).for_each(&mut push);
                otherwise.iter().for_each(|e| push(e));
            }
            ExprKind::Call(f, arguments) => {
                push(f);
                arguments.iter().for_each(|a| push(&a.value));
            }
            ExprKind::Set(items) | ExprKind::List(items) => items.iter().for_each(push),
            ExprKind::Aggregate { share, binders, condition, body, otherwise, .. } => {
                binders.iter().for_each(|b| push(&b.over));
                [share, condition, body, otherwise].into_iter().flatten().for_each(|e| push(e));
            }
            ExprKind::Quantity(..) | ExprKind::Text(_) | ExprKind::Bool(_) | ExprKind::Name(_) => {}
        }
    }
    deepest
}

/// Two values with the operator of a level between them.
fn joined(level: Level, left: Expr, operator: &Node<'_>, right: Expr) -> Option<Expr> {
    let span = left.span.join(right.span);
    let (left, right) = (Box::new(left), Box::new(right));
    let kind = match level {
        Level::Range => ExprKind::Range(left, right),
        Level::AtTime => ExprKind::At(left, right),
        Level::Disjunction => ExprKind::Binary(left, Operator::Or, right),
        Level::Conjunction => ExprKind::Binary(left, Operator::And, right),
        _ => ExprKind::Binary(left, operator_of(operator.as_str())?, right),
    };
    Some(Expr { kind, span })
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

/// Whether a whole number was written of which the last digits are lost.
fn is_rounded(text: &str, value: f64) -> bool {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    let is_whole = text.bytes().all(|digit| digit.is_ascii_digit());
    is_whole && value >= EXACT && format!("{value}") != text.trim_start_matches('0')
}
