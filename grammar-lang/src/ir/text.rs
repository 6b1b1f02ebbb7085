//! Text for people: what the parts of a rule set have in common when they are written.

use std::fmt::Write;

use super::{Expr, ExprKind, Form, Gather, Group, RuleSet, Table, Ty};
use crate::units::{self, Dimension};

/// Writes a rule set much as a grammar is written, with every number in a unit that people use.
pub(super) struct Writer<'r> {
    pub(super) rules: &'r RuleSet,
    pub(super) text: String,
}

/// What the local slots of an expression are called.
pub(super) type Names = Vec<String>;

pub(super) fn quantity(value: f64, ty: &Ty) -> String {
    units::shown(value, ty.dimension().unwrap_or_default())
}

pub(super) fn range((low, high): (f64, f64), ty: &Ty) -> String {
    format!("{} .. {}", quantity(low, ty), quantity(high, ty))
}

pub(super) fn tabulated(table: &Table, from: Dimension, to: Dimension) -> String {
    let row = |[x, y]: &[f64; 2]| format!("{} -> {}", units::shown(*x, from), units::shown(*y, to));
    let rows: Vec<String> = table.rows.iter().map(row).collect();
    format!("table {{ {} }}", rows.join(", "))
}

pub(super) fn shape(form: Form) -> String {
    let (solid, lengths) = form.written();
    let lengths: Vec<String> = lengths.into_iter().map(|x| units::shown(x, Dimension::LENGTH)).collect();
    format!("{}({})", solid.text(), lengths.join(", "))
}

pub(super) fn group(group: &Group) -> &str {
    match group {
        Group::Part => "part",
        Group::Block => "block",
        Group::Actuator => "actuator",
        Group::Cell => "cell",
        Group::Kind(kind) => kind,
    }
}

impl Writer<'_> {
    pub(super) fn line(&mut self, indent: usize, text: impl AsRef<str>) {
        // Writing to a String never fails.
        let _ = writeln!(self.text, "{:width$}{}", "", text.as_ref(), width = 2 * indent);
    }

    pub(super) fn gap(&mut self) {
        self.text.push('\n');
    }

    /// A number, or the value of an enumeration that it stands for.
    pub(super) fn constant(&self, value: f64, ty: &Ty) -> String {
        match ty {
            Ty::Enum(name) => match self.rules.value_of(name, value) {
                Some(word) => format!("{name}.{word}"),
                None => value.to_string(),
            },
            Ty::Bool => (value != 0.0).to_string(),
            ty => quantity(value, ty),
        }
    }

    /// An expression, with brackets around everything that could be read in two ways.
    pub(super) fn expr(&self, expr: &Expr, names: &Names) -> String {
        let show = |e: &Expr| self.expr(e, names);
        let all = |items: &[Expr]| items.iter().map(show).collect::<Vec<_>>().join(", ");
        match &expr.kind {
            ExprKind::Number(x) => self.constant(*x, &expr.ty),
            ExprKind::Bool(x) => x.to_string(),
            ExprKind::Text(x) => format!("{x:?}"),
            ExprKind::Param(name)
            | ExprKind::OfBody(name)
            | ExprKind::Placed(name)
            | ExprKind::Pattern(name)
            | ExprKind::Term(name)
            | ExprKind::Scenarios(name) => name.clone(),
            ExprKind::Table(table) => match &expr.ty {
                Ty::Table(from, to) => tabulated(table, *from, *to),
                _ => tabulated(table, Dimension::NUMBER, Dimension::NUMBER),
            },
            ExprKind::PortName(name) => name.clone(),
            ExprKind::Task(name) if *name == RuleSet::ONLY_TASK => "the value of the task".to_owned(),
            ExprKind::Task(name) => format!("{name}.value"),
            ExprKind::Shared(actuation, variable) => format!("{actuation}.{variable}"),
            ExprKind::Sensor(name, of) => match of {
                Some(of) => format!("{name}({})", show(of)),
                None => name.clone(),
            },
            ExprKind::Local(slot) => match names.get(*slot) {
                Some(name) if !name.is_empty() => name.clone(),
                _ => format!("x{slot}"),
            },
            ExprKind::Word(word) => word.text().to_owned(),
            ExprKind::Group(g) => group(g).to_owned(),
            ExprKind::Kind(name, params) if params.is_empty() => name.clone(),
            ExprKind::Kind(name, params) => {
                let params: Vec<String> = params.iter().map(|(n, e)| format!("{n} = {}", show(e))).collect();
                format!("{name}({})", params.join(", "))
            }
            ExprKind::With(kind, params) => {
                let params: Vec<String> = params.iter().map(|(n, e)| format!("{n} = {}", show(e))).collect();
                format!("{}({})", show(kind), params.join(", "))
            }
            ExprKind::Port(of, name, number) => {
                let number = number.as_ref().map_or(String::new(), |n| format!("[{}]", show(n)));
                format!("{}.{name}{number}", show(of))
            }
            // What a function was called with, if it is short, stands where the function reads it.
            ExprKind::Bind { slot, value, body } if is_short(value) => {
                let mut names = names.clone();
                names.resize(names.len().max(slot + 1), String::new());
                names[*slot] = show(value);
                self.expr(body, &names)
            }
            ExprKind::Bind { slot, value, body } => {
                format!("(let x{slot} = {} in {})", show(value), show(body))
            }
            ExprKind::Attribute(of, attribute) => format!("{}.{}", show(of), attribute.text()),
            ExprKind::At(track, time) => format!("({} at {})", show(track), show(time)),
            ExprKind::Negate(x) => format!("-{}", show(x)),
            ExprKind::Not(x) => format!("not {}", show(x)),
            // The value of a task is a number, and stands for so many of its unit, which nobody wrote.
            ExprKind::Binary(a, _, unit) if matches!(a.kind, ExprKind::Task(_)) && a.span == unit.span => {
                show(a)
            }
            ExprKind::Binary(a, operator, b) => format!("({} {} {})", show(a), operator.symbol(), show(b)),
            ExprKind::If(a, b, c) => format!("(if {} then {} else {})", show(a), show(b), show(c)),
            ExprKind::Call(function, arguments) => format!("{}({})", function.text(), all(arguments)),
            ExprKind::Apply(curve, place) => format!("{}({})", show(curve), show(place)),
            ExprKind::Index(list, index) => format!("{}[{}]", show(list), show(index)),
            ExprKind::Range(low, high) => {
                // Between whole numbers without a point, only whole ones are meant.
                let any = expr.ty == Ty::Domain(Box::new(Ty::NUMBER));
                let low = show(low);
                let point = if any && low.parse::<i64>().is_ok() { ".0" } else { "" };
                format!("{low}{point} .. {}", show(high))
            }
            ExprKind::Set(items) => format!("{{ {} }}", all(items)),
            ExprKind::List(items) => format!("[{}]", all(items)),
            ExprKind::Convert(x, factor) => format!("({} in units of {factor})", show(x)),
            ExprKind::Aggregate { how, share, binders, condition, body, otherwise } => {
                let mut names = names.clone();
                let mut over = Vec::new();
                for binder in binders {
                    let what = self.expr(&binder.over, &names);
                    names.resize(binder.slot, String::new());
                    // The name that the text gave it is not kept; worlds are called as in the documentation.
                    let is_world = matches!(binder.over.kind, ExprKind::Scenarios(_));
                    let free = is_world && names.iter().all(|name| name != "w");
                    let name = if free { "w".to_owned() } else { format!("x{}", binder.slot) };
                    over.push(format!("{name} in {what}"));
                    names.push(name);
                }
                let part = |word: &str, e: &Option<Box<Expr>>| {
                    e.as_ref().map_or(String::new(), |e| format!(" {word} {}", self.expr(e, &names)))
                };
                let condition = part("where", condition);
                let over = over.join(", ");
                match how {
                    Gather::Forall | Gather::Exists => {
                        let word = how.text();
                        let body = body.as_ref().map_or(String::new(), |b| self.expr(b, &names));
                        format!("({word} {over}{condition}: {body})")
                    }
                    _ => {
                        let word = match share {
                            Some(share) => format!("{} {}", how.text(), show(share)),
                            None => how.text().to_owned(),
                        };
                        let (body, otherwise) = (part("of", body), part("otherwise", otherwise));
                        format!("({word} over {over}{condition}{body}{otherwise})")
                    }
                }
            }
        }
    }
}

/// Whether a value can stand in several places without making them longer.
fn is_short(value: &Expr) -> bool {
    use ExprKind as K;
    matches!(value.kind, K::Number(_) | K::Bool(_) | K::Param(_) | K::Word(_) | K::Local(_) | K::Placed(_))
}
