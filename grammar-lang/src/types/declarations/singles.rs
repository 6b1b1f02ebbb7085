//! What a grammar, or a task, says once: how it begins, its symmetry, its objective.

use indexmap::IndexMap;

use super::Declarations;
use crate::diagnostics::{Code, Diagnostic, respell};
use crate::ir::{self, Direction, Ty};
use crate::names::declared;
use crate::source::Span;
use crate::syntax::ast::{Expr as Tree, Item, ItemKind, Name, Place};
use crate::syntax::declarations::BlockKind;
use crate::types::built_in::{built_in, is_read_as_word};
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;

/// Which actuation drives which actuator, and where that is said.
pub(in crate::types) type Actuated = IndexMap<String, (String, Span)>;

/// An objective as the text has it.
#[derive(Clone, Copy)]
pub(in crate::types) struct Wanted<'t> {
    pub(in crate::types) direction: Direction,
    pub(in crate::types) value: &'t Tree,
    /// Where the whole declaration stands.
    pub(in crate::types) span: Span,
    /// Whether the declaration is damaged.
    pub(in crate::types) damaged: bool,
}

/// A task as it is written.
#[derive(Clone, Copy, Debug)]
pub(in crate::types) struct OneTask<'t> {
    pub(in crate::types) name: &'t Name,
    pub(in crate::types) items: &'t [Item],
    /// Whether a part of it could not be read.
    pub(in crate::types) damaged: bool,
}

/// Declarations of which a grammar, or a task, has one; and objectives, of which a grammar may have several.
#[derive(Default)]
pub(in crate::types) struct Singles<'t> {
    pub(in crate::types) begin: Option<Vec<ir::Placed>>,
    /// What the initial design fills.
    pub(in crate::types) filled: Vec<ir::Effect>,
    /// The sides of the lattice, its cell and its place.
    pub(in crate::types) lattice: Option<([usize; 3], ir::Cell, Span)>,
    /// The name of its cell.
    pub(in crate::types) cell: Option<&'t Name>,
    pub(in crate::types) symmetry: Option<ir::Symmetry>,
    pub(super) model: Option<ir::Model>,
    /// The targets that it is simulated on.
    pub(super) on: Vec<&'t Name>,
    /// The scenarios that it happens in, and whether there are such.
    pub(super) scenarios: Option<(&'t Name, bool)>,
    /// Where its time is said: what is added to it follows there.
    pub(super) duration: Option<Span>,
    /// What is wanted, in the order of the text.
    pub(in crate::types) objectives: Vec<Wanted<'t>>,
    pub(in crate::types) search: Option<ir::Search>,
    pub(in crate::types) from: Option<&'t Name>,
    pub(in crate::types) actuated: Actuated,
    pub(in crate::types) tasks: Vec<OneTask<'t>>,
    pub(in crate::types) seen: IndexMap<&'static str, Span>,
}

impl<'a> Declarations<'a> {
    /// Takes in a declaration of which there is one.
    pub(in crate::types) fn single(&mut self, item: &'a Item, singles: &mut Singles<'a>) {
        let what = match &item.kind {
            ItemKind::Grammar(_) => "grammar",
            ItemKind::Begin(..) => "begin",
            ItemKind::Lattice(..) => "lattice",
            ItemKind::Symmetry(..) => "symmetry",
            ItemKind::Simulate { .. } => "simulate",
            ItemKind::UseSearch(..) => "search",
            ItemKind::Actuate(..) => "actuate",
            ItemKind::Task(..) => "task",
            ItemKind::Objective { direction, value } => {
                let (direction, span, damaged) = (*direction, item.span, item.damaged);
                singles.objectives.push(Wanted { direction, value, span, damaged });
                return;
            }
            _ => return,
        };
        if !matches!(what, "actuate" | "task")
            && let Some(first) = singles.seen.insert(what, item.span)
        {
            self.report(
                Diagnostic::new(Code::DUPLICATE, item.span, format!("a grammar can have only one `{what}`"))
                    .label("another one")
                    .also(first, "the first one")
                    .help("keep one of them"),
            );
            return;
        }
        match &item.kind {
            ItemKind::Begin(places, fills) if self.environment.has_lattice => {
                for place in places {
                    self.mixed(place.name.span, true);
                }
                singles.filled = self.begin_cells(fills, item.damaged);
                singles.begin = Some(Vec::new());
                if fills.is_empty() && places.is_empty() && !item.damaged {
                    self.report(
                        Diagnostic::new(Code::MISSING_ITEM, item.span, "the initial design is empty")
                            .label("nothing to begin with")
                            .help(
                                "write for example `fill region(middle, -2 .. 2, 0 .. 1, -2 .. 2) with soft`",
                            ),
                    );
                }
            }
            ItemKind::Begin(places, fills) => {
                for fill in fills {
                    self.mixed(fill.span, false);
                }
                singles.begin = self.begin(places, item);
            }
            ItemKind::Lattice(sides, kind) => {
                singles.lattice = self.lattice(sides, kind, item.span);
                singles.cell = Some(kind);
            }
            ItemKind::Symmetry(kind, count, plane) => {
                singles.symmetry = self.symmetry(kind, count.as_ref(), plane.as_ref());
            }
            ItemKind::Simulate { model, duration, on, scenarios } => {
                singles.model = self.simulated(model, duration);
                let there = |on: &&'a Name| {
                    self.named(on, "target", |k| matches!(k, ItemKind::Target { .. })).is_some()
                };
                singles.on = on.iter().filter(there).collect();
                singles.duration = Some(duration.span);
                singles.scenarios = scenarios.as_ref().map(|set| (set, self.set_of_worlds(set)));
            }
            ItemKind::UseSearch(name, from) => {
                singles.from = from.as_ref();
                if let Some(ItemKind::Block(BlockKind::Search, block)) =
                    self.named(name, "search", |k| matches!(k, ItemKind::Block(BlockKind::Search, _)))
                {
                    singles.search = self.search(block, false);
                }
            }
            ItemKind::Task(name, items) => {
                singles.tasks.push(OneTask { name, items, damaged: item.damaged });
            }
            ItemKind::Actuate(kind, with) => self.actuate(kind, with, singles),
            _ => {}
        }
    }

    /// Takes in by which actuation a kind is driven.
    fn actuate(&mut self, kind: &Name, with: &Name, singles: &mut Singles<'a>) {
        let is_driven = |k: &ItemKind| matches!(k, ItemKind::Block(BlockKind::Actuator | BlockKind::Cell, _));
        let kind_ok = self.named(kind, "actuator", is_driven).is_some();
        let with_ok = self.named(with, "actuation", |k| matches!(k, ItemKind::Actuation { .. })).is_some();
        if !(kind_ok && with_ok) {
            return;
        }
        let entry = (with.text.clone(), with.span);
        if let Some((_, first)) = singles.actuated.insert(kind.text.clone(), entry) {
            self.report(
                Diagnostic::new(Code::DUPLICATE, kind.span, format!("`{}` is actuated twice", kind.text))
                    .label("again")
                    .also(first, "first actuated here")
                    .help("an actuator follows one actuation: keep one of the two lines"),
            );
        }
    }

    /// The parts of the initial design: the core, and what it holds.
    fn begin(&mut self, places: &[Place], item: &Item) -> Option<Vec<ir::Placed>> {
        self.distinct(places.iter().map(|p| &p.name), "part");
        let mut placed = Vec::new();
        let mut sound = true;
        for (i, place) in places.iter().enumerate() {
            if let Some((_, other)) = self.environment.program.lookup(place.name.span, &place.name.text) {
                let mut error = Diagnostic::new(
                    Code::DUPLICATE,
                    place.name.span,
                    format!("`{}` already means something else", place.name.text),
                )
                .label("hides another meaning")
                .help("choose another name");
                if let Some(other) = declared(other) {
                    error = error.also(other.span, "the other meaning");
                }
                self.report(error);
            } else if is_read_as_word(&place.name.text) {
                self.report(built_in(&place.name));
            }
            let mut cx = Context::new(Stage::Derivation, item.damaged);
            let what = self.expressions.expect(&place.what, &mut cx, &Ty::Kind, "what is placed");
            sound &= what.ty == Ty::Kind;
            let on = place
                .to
                .as_ref()
                .map(|port| self.holding(&what, port, place.turned.as_ref(), place.by.as_ref(), &mut cx))
                .map(|on| ir::Holding { alone: place.alone, ..on });
            let how = place.turned.as_ref().map(|t| t.span).or(place.by.as_ref().map(|b| b.span));
            match (i, &on) {
                (0, None) if how.is_some() => self.report(
                    Diagnostic::new(
                        Code::BAD_VALUE,
                        how.unwrap_or_default(),
                        "the first part is the core: nothing holds it, so it is not turned about a port",
                    )
                    .label("there is no port to turn about")
                    .help("write it without `turned` and `by`"),
                ),
                (0, Some(on)) => self.report(
                    Diagnostic::new(
                        Code::BAD_VALUE,
                        on.port.span,
                        "the first part is the core: nothing holds it",
                    )
                    .label("the core cannot be attached to this")
                    .help("write it without `to`"),
                ),
                (1.., None) => self.report(
                    Diagnostic::new(
                        Code::MISSING_FIELD,
                        place.name.span,
                        format!("nothing holds `{}`", place.name.text),
                    )
                    .label("a second part")
                    .help("write where it is attached, as in `to core.top`, or let rules attach it"),
                ),
                _ => {}
            }
            placed.push(ir::Placed { name: place.name.text.clone(), what, on, span: place.what.span });
        }
        if places.is_empty() && !item.damaged {
            self.report(
                Diagnostic::new(Code::MISSING_ITEM, item.span, "the initial design is empty")
                    .label("nothing to begin with")
                    .help("write for example `place core : cube`"),
            );
        }
        (sound && !placed.is_empty()).then_some(placed)
    }

    fn symmetry(&mut self, kind: &Name, count: Option<&Tree>, plane: Option<&Name>) -> Option<ir::Symmetry> {
        const HELP: &str = "write `symmetry none`, `symmetry mirror xy` or `symmetry radial 3 about y` \
                            (y is up, x is forward)";
        let (span, message) = match (kind.text.as_str(), count, plane) {
            ("none", None, None) => return Some(ir::Symmetry::None),
            ("mirror", None, Some(plane)) => {
                let normal = match plane.text.as_str() {
                    "xy" | "yx" => Some(2),
                    "yz" | "zy" => Some(0),
                    "xz" | "zx" => Some(1),
                    _ => None,
                };
                match normal {
                    Some(normal) => {
                        if normal == 1 {
                            self.upside_down(plane);
                        }
                        return Some(ir::Symmetry::Mirror(normal));
                    }
                    None => (plane.span, format!("there is no plane `{}`", plane.text)),
                }
            }
            ("radial", Some(count), Some(axis)) => {
                let place = count.span;
                let mut cx = Context::new(Stage::Declaration, false);
                let count = self.expressions.expect(count, &mut cx, &Ty::Count, "the number of repetitions");
                let count = self.expressions.constant_number(&count)?;
                let axis_index = ["x", "y", "z"].iter().position(|a| *a == axis.text);
                match axis_index {
                    Some(axis) if (2.0..=64.0).contains(&count) => {
                        return Some(ir::Symmetry::Radial(count as usize, axis));
                    }
                    Some(_) => {
                        self.report(
                            Diagnostic::new(
                                Code::OUT_OF_DOMAIN,
                                place,
                                "a radial symmetry must repeat the design 2 to 64 times",
                            )
                            .label(format!("this is {count}"))
                            .help("for no symmetry, write `symmetry none`"),
                        );
                        return None;
                    }
                    None => (axis.span, format!("there is no axis `{}`", axis.text)),
                }
            }
            ("mirror", ..) => (kind.span, "`mirror` needs a plane".to_owned()),
            ("radial", ..) => (kind.span, "`radial` needs a number and an axis".to_owned()),
            ("none", _, Some(plane)) => (plane.span, "`symmetry none` takes nothing more".to_owned()),
            (other, ..) => (kind.span, format!("there is no symmetry `{other}`")),
        };
        let label = if message.contains("needs") {
            "incomplete"
        } else if message.contains("nothing more") {
            "too much"
        } else {
            "not known"
        };
        self.report(
            Diagnostic::new(Code::BAD_VALUE, span, message).label(label).help(HELP).fix_if(
                respell(span, &kind.text, ["none", "mirror", "radial"]).filter(|_| span == kind.span),
            ),
        );
        None
    }
}
