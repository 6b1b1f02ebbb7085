//! Lowers declarations to the syntax tree.

use super::super::Direction;
use super::super::ast::{Block, BodyState, Expr, Item, ItemKind, Name, Sense, State, Table, Variant};
use super::super::declarations::BlockKind;
use super::super::parser::Rule;
use super::{Lowering, Node, children, parts, unquote};

/// What `require` and `prefer` say.
struct Said {
    name: Option<Name>,
    values: Vec<Expr>,
    because: Option<String>,
}

/// A name, the part that has it and its kind, where each of a kind has one, and a type.
type Fitted = (Name, Option<(Name, Name)>, Name);

impl<'a> Lowering<'a> {
    pub(in super::super) fn item(&mut self, node: Node<'a>) -> Option<Item> {
        let span = self.span(&node);
        let doc = self.doc(node.as_span().start());
        let node = children(node).next().and_then(|node| self.unless_allow(node))?;
        let before = self.allows.len();
        let kind = self.item_kind(node)?;
        for allow in self.allows.iter_mut().skip(before) {
            allow.within.get_or_insert(span);
        }
        Some(Item { kind, span, doc, damaged: false })
    }

    fn item_kind(&mut self, node: Node<'a>) -> Option<ItemKind> {
        Some(match node.as_rule() {
            Rule::param_item => ItemKind::Param(self.param(node)?),
            Rule::block_item => {
                let kind = BlockKind::of(children(node.clone()).next()?.as_str())?;
                ItemKind::Block(kind, self.block(node)?)
            }
            Rule::search_item => self.search(node)?,
            Rule::symmetry_item => self.symmetry(node)?,
            Rule::begin_item => self.begin(node),
            Rule::objective_item => self.objective(node)?,
            Rule::require_item => {
                let Said { name, values, because } = self.said(node)?;
                ItemKind::Require { name, condition: values.into_iter().next()?, because }
            }
            Rule::prefer_item => {
                let Said { name, values, because } = self.said(node)?;
                let mut values = values.into_iter();
                ItemKind::Prefer { name, condition: values.next()?, weight: values.next()?, because }
            }
            Rule::target_item | Rule::prototype_item => self.hardware(node)?,
            Rule::let_item => self.definition(node)?,
            Rule::variant_item => ItemKind::Variant(self.variant(node)?),
            Rule::rule_item
            | Rule::actuation_item
            | Rule::table_item
            | Rule::novelty_item
            | Rule::enum_item
            | Rule::record_item
            | Rule::task_item
            | Rule::example_item => self.clauses(node)?,
            _ => self.line(node)?,
        })
    }

    /// A declaration without a block.
    fn line(&mut self, node: Node<'a>) -> Option<ItemKind> {
        let rule = node.as_rule();
        let mut inner = parts(node);
        Some(match rule {
            Rule::grammar_item => ItemKind::Grammar(self.name(&inner.next()?)),
            Rule::use_item => {
                let module = self.name_or_text(&inner.next()?);
                let names = inner.next().map(|list| parts(list).map(|n| self.name(&n)).collect());
                ItemKind::Use { module, names }
            }
            Rule::lattice_item => {
                let mut side = || inner.next().and_then(|n| self.side(n));
                let sides = [side()?, side()?, side()?];
                ItemKind::Lattice(sides, self.name(&inner.next()?))
            }
            Rule::fallback_item => ItemKind::Fallback {
                rule: self.name(&inner.next()?),
                condition: self.expr(inner.next()?)?,
                because: inner.next().map(|text| unquote(&text)),
            },
            Rule::shared_item => {
                let variable = inner.find(|part| part.as_rule() == Rule::variable)?;
                ItemKind::Shared(Box::new(self.variable(true, variable)?))
            }
            Rule::pattern_item => ItemKind::Pattern(self.name(&inner.next()?), self.expr(inner.next()?)?),
            Rule::actuate_item => ItemKind::Actuate(self.name(&inner.next()?), self.name(&inner.next()?)),
            Rule::simulate_item => {
                let model = self.name(&inner.next()?);
                let duration = self.expr(inner.next()?)?;
                let (mut on, mut scenarios) = (Vec::new(), None);
                for part in inner {
                    let is_on = part.as_rule() == Rule::on_part;
                    let mut names = parts(part).map(|name| self.name(&name));
                    if is_on { on.extend(names) } else { scenarios = names.next() }
                }
                ItemKind::Simulate { model, duration, on, scenarios }
            }
            Rule::observe_item => ItemKind::Observe(inner.map(|n| self.name(&n)).collect()),
            Rule::sense_item => ItemKind::Sense(Box::new(self.sense(inner)?)),
            Rule::state_item => ItemKind::State(Box::new(self.body_state(inner)?)),
            Rule::term_item => ItemKind::Term(
                self.name(&inner.next()?),
                self.name(&inner.next()?),
                self.expr(inner.next()?)?,
            ),
            _ => return None,
        })
    }

    /// A sensor.
    fn sense(&mut self, mut inner: impl Iterator<Item = Node<'a>>) -> Option<Sense> {
        let (name, of, ty) = self.fitted(&mut inner)?;
        let value = self.expr(inner.next()?)?;
        let (mut noise, mut delay) = (None, None);
        for part in inner {
            let is_noise = part.as_rule() == Rule::noise_part;
            let said = parts(part).next().and_then(|expr| self.expr(expr));
            if is_noise { noise = said } else { delay = said }
        }
        Some(Sense { name, of, ty, value, noise, delay })
    }

    /// A state of the robot or of its parts.
    fn body_state(&mut self, mut inner: impl Iterator<Item = Node<'a>>) -> Option<BodyState> {
        let (name, of, ty) = self.fitted(&mut inner)?;
        let (from, next) = (self.expr(inner.next()?)?, self.expr(inner.next()?)?);
        Some(BodyState { of, state: State { name, ty, from, next } })
    }

    /// What a sensor or a state begins with.
    fn fitted(&mut self, inner: &mut impl Iterator<Item = Node<'a>>) -> Option<Fitted> {
        let name = self.name(&inner.next()?);
        let mut next = inner.next()?;
        let mut of = None;
        if next.as_rule() == Rule::sensed_part {
            let mut part = parts(next);
            of = Some((self.name(&part.next()?), self.name(&part.next()?)));
            next = inner.next()?;
        }
        Some((name, of, self.name(&next)))
    }

    /// A declaration with a name and a block of clauses.
    fn clauses(&mut self, node: Node<'a>) -> Option<ItemKind> {
        let rule = node.as_rule();
        let mut inner = parts(node);
        let name = self.name(&inner.next()?);
        Some(match rule {
            Rule::rule_item => ItemKind::Rule(name, inner.filter_map(|n| self.rule_clause(n)).collect()),
            Rule::actuation_item => ItemKind::Actuation {
                name,
                binder: self.name(&inner.next()?),
                kind: self.name(&inner.next()?),
                clauses: inner.filter_map(|n| self.actuation_clause(n)).collect(),
            },
            Rule::table_item => ItemKind::Table(Table {
                name,
                from: self.name(&inner.next()?),
                to: self.name(&inner.next()?),
                rows: inner.filter_map(|row| self.row(row)).collect(),
            }),
            Rule::novelty_item => {
                ItemKind::Novelty(name, inner.filter_map(|n| self.novelty_clause(n)).collect())
            }
            Rule::enum_item => ItemKind::Enum(name, parts(inner.next()?).map(|n| self.name(&n)).collect()),
            Rule::record_item => ItemKind::Record(name, inner.filter_map(|n| self.record_field(n)).collect()),
            Rule::task_item => ItemKind::Task(name, inner.filter_map(|n| self.item(n)).collect()),
            Rule::example_item => {
                ItemKind::Example(name, inner.filter_map(|n| self.example_clause(n)).collect())
            }
            _ => return None,
        })
    }

    /// A name, or a path in quotes.
    fn name_or_text(&self, node: &Node<'_>) -> Name {
        match node.as_rule() {
            Rule::text => Name { text: unquote(node), span: self.span(node) },
            _ => self.name(node),
        }
    }

    fn objective(&mut self, node: Node<'a>) -> Option<ItemKind> {
        let mut inner = children(node);
        let direction = match inner.next()?.as_rule() {
            Rule::kw_maximize => Direction::Maximize,
            _ => Direction::Minimize,
        };
        Some(ItemKind::Objective { direction, value: self.expr(inner.next()?)? })
    }

    /// A search with its block, or the name of one.
    fn search(&mut self, node: Node<'a>) -> Option<ItemKind> {
        if children(node.clone()).any(|p| p.as_rule() == Rule::brace_open) {
            return Some(ItemKind::Block(BlockKind::Search, self.block(node)?));
        }
        let mut inner = parts(node);
        let name = self.name(&inner.next()?);
        let from = inner.next().and_then(|from| parts(from).next());
        Some(ItemKind::UseSearch(name, from.map(|n| self.name(&n))))
    }

    fn symmetry(&mut self, node: Node<'a>) -> Option<ItemKind> {
        let mut inner = parts(node);
        let what = self.name(&inner.next()?);
        Some(match inner.next() {
            Some(radial) if radial.as_rule() == Rule::radial_part => {
                let mut inner = parts(radial);
                let count = self.expr(inner.next()?)?;
                ItemKind::Symmetry(what, Some(count), inner.next().map(|n| self.name(&n)))
            }
            plane => ItemKind::Symmetry(what, None, plane.map(|n| self.name(&n))),
        })
    }

    fn begin(&mut self, node: Node<'a>) -> ItemKind {
        let clauses: Vec<Node<'_>> = parts(node).filter_map(|node| self.unless_allow(node)).collect();
        let (places, fills): (Vec<Node<'_>>, Vec<Node<'_>>) =
            clauses.into_iter().partition(|n| n.as_rule() == Rule::place_clause);
        ItemKind::Begin(
            places.into_iter().filter_map(|n| self.place(n)).collect(),
            fills.into_iter().filter_map(|n| self.cells(n)).collect(),
        )
    }

    fn said(&mut self, node: Node<'a>) -> Option<Said> {
        let mut said = Said { name: None, values: Vec::new(), because: None };
        for part in parts(node) {
            match part.as_rule() {
                Rule::name => said.name = Some(self.name(&part)),
                Rule::text => said.because = Some(unquote(&part)),
                _ => said.values.push(self.expr(part)?),
            }
        }
        Some(said)
    }

    fn hardware(&mut self, node: Node<'a>) -> Option<ItemKind> {
        let is_target = node.as_rule() == Rule::target_item;
        let mut inner = parts(node);
        let (name, backend) = (self.name(&inner.next()?), self.name(&inner.next()?));
        let kind = if is_target { Some(self.name(&inner.next()?)) } else { None };
        let block = Block { name, method: None, fields: inner.filter_map(|n| self.field(n)).collect() };
        Some(match kind {
            Some(kind) => ItemKind::Target { block, backend, kind },
            None => ItemKind::Prototype(block, backend),
        })
    }

    /// `let`, of a value or a function.
    pub(super) fn definition(&mut self, node: Node<'a>) -> Option<ItemKind> {
        let mut inner = parts(node);
        let name = self.name(&inner.next()?);
        let mut value = inner.next()?;
        let mut parameters = None;
        if value.as_rule() == Rule::parameters {
            parameters = Some(parts(value).filter_map(|n| self.typed(n)).collect());
            value = inner.next()?;
        }
        Some(ItemKind::Let(name, parameters, self.expr(value)?))
    }

    fn variant(&mut self, node: Node<'a>) -> Option<Variant> {
        let mut inner = parts(node);
        let name = self.name(&inner.next()?);
        let base = inner.next()?;
        let from_file = base.as_rule() == Rule::text;
        let base = self.name_or_text(&base);
        Some(Variant { name, base, from_file, edits: inner.filter_map(|n| self.edit(n)).collect() })
    }
}
