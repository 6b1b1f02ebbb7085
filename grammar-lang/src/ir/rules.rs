//! Rules, where they begin, and what designs must and should be.

use serde::{Deserialize, Serialize};

use super::text::{Names, Writer, group};
use super::{Binder, Cells, Expr, Group, PartAttribute};
use crate::source::Span;

/// How rule applications are mirrored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Symmetry {
    /// Not at all.
    None,
    /// In the plane through the core's centre with this normal: 0, 1, 2 for x, y, z.
    Mirror(usize),
    /// Rotated so many times in all, about this axis through the core's centre.
    Radial(usize, usize),
}

/// A part of the initial design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    /// What rules call it.
    pub name: String,
    /// What it is: a kind with its parameters.
    pub what: Expr,
    /// What holds it; nothing holds the core.
    pub on: Option<Holding>,
    /// Where this is said.
    pub span: Span,
}

/// How a part is held.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Holding {
    /// The port that holds it.
    pub port: Expr,
    /// By how much it is turned about that port's normal.
    pub turned: Option<Expr>,
    /// The port of its own that it is held by; if none is named, `back`, `base`
    /// or the first one that it has.
    pub by: Option<String>,
    /// Whether it has no images, whatever the symmetry.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub alone: bool,
}

/// A rule of the grammar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rule {
    /// Its name.
    pub name: String,
    /// What it needs, in order; each takes the next local slots.
    pub matches: Vec<Match>,
    /// What it draws, in order; each takes the next local slot.
    pub choices: Vec<Choice>,
    /// Conditions, each with the number of local slots that it needs to be bound.
    pub guards: Vec<Guard>,
    /// What it does.
    pub effects: Vec<Effect>,
    /// How often it is drawn, relative to the others.
    pub weight: Expr,
    /// What its locals are called, by slot.
    pub locals: Vec<String>,
    /// Where it is declared.
    pub span: Span,
}

/// One thing that a rule matches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Match {
    /// What it is.
    pub what: Matched,
    /// A condition on it and on what was matched before it.
    pub condition: Option<Expr>,
}

/// What is matched. Two matches of a rule never bind the same part, port or step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Matched {
    /// A part of a kind, in the next slot.
    Part {
        /// Which parts.
        kind: Group,
        /// Whether one of its free ports takes the slot after it.
        port: bool,
        /// The slot of the part that it must be joined to.
        joined_to: Option<usize>,
    },
    /// A port, in the next slot.
    Port {
        /// The slot of the part whose port it is; any part's if none.
        of: Option<usize>,
    },
    /// A joint, in the next slot.
    Joint,
    /// A step of the derivation, in the next slot.
    Step,
}

impl Match {
    /// How many local slots it takes.
    #[must_use]
    pub fn slots(&self) -> usize {
        if matches!(self.what, Matched::Part { port: true, .. }) { 2 } else { 1 }
    }
}

/// A choice of a rule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// Its name.
    pub name: String,
    /// The values to draw from.
    pub domain: Expr,
    /// How they are distributed; evenly if nothing is said.
    pub spread: Spread,
}

/// How a choice is distributed over its domain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Spread {
    /// Evenly.
    Even,
    /// There is only one value: a `let` of the rule.
    Fixed,
    /// As a normal distribution that is cut at the ends: mean, standard deviation.
    Normal(Expr, Expr),
    /// Evenly within these ends, and within the domain.
    Uniform(Expr, Expr),
    /// By a list of weights, one for each value.
    Weights(Expr),
}

/// A condition of a rule.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Guard {
    /// How many locals must be bound before it can be asked.
    pub needs: usize,
    /// What must hold.
    pub condition: Expr,
}

/// What a rule does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Effect {
    /// Attaches a part to a port.
    Attach {
        /// What: a kind, or a kind with parameters. It takes the next local slot.
        what: Expr,
        /// Where and how.
        on: Holding,
    },
    /// Takes a part away, with all that hangs on it.
    Remove(Expr),
    /// Puts a part in the place of another.
    Replace {
        /// The part that goes.
        part: Expr,
        /// What comes: it takes the next local slot.
        with: Expr,
        /// The neighbours at its base or back, and at its tip or front.
        between: Option<(Expr, Expr)>,
    },
    /// Sets an attribute of a part.
    Set {
        /// The part.
        part: Expr,
        /// What of it.
        attribute: Settable,
        /// Its new value.
        value: Expr,
    },
    /// Sets what a parameter of the grammar is in this body.
    SetOfBody {
        /// The parameter.
        name: String,
        /// Its new value.
        value: Expr,
    },
    /// Takes back a step.
    Revert(Expr),
    /// Fills, paints or clears places of the lattice.
    Cells(Cells),
    /// Does the same for each of several things.
    Repeat {
        /// For what; each takes a local slot while it lasts.
        over: Vec<Binder>,
        /// What is done. The parts that it makes take slots until it is done again.
        effects: Vec<Effect>,
        /// The lists of what it has made, by name: each takes the next local slot afterwards.
        lists: Vec<MadeList>,
    },
    /// Works out a value, which takes the next local slot.
    Let(Expr),
    /// From here on effects read the design as those before have left it.
    Then,
}

/// The parts that a block has made under one name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MadeList {
    /// What it is called.
    pub name: String,
    /// Which effects of the block make them: their numbers among those that make parts.
    pub makers: Vec<usize>,
    /// The slot of the list that it goes on with: what blocks above have made under the same name.
    pub after: Option<usize>,
}

impl Effect {
    /// Effects with those that are repeated in the place of their repetition.
    pub fn single(effects: &[Self]) -> Box<dyn Iterator<Item = &Self> + '_> {
        Box::new(effects.iter().flat_map(|effect| match effect {
            Self::Repeat { effects, .. } => Self::single(effects),
            other => Box::new(std::iter::once(other)),
        }))
    }

    /// The effects that make a part each time that they are carried out, in the order of the text.
    #[must_use]
    pub fn makers(effects: &[Self]) -> Vec<&Self> {
        let makes = |effect: &&Self| matches!(effect, Self::Attach { .. } | Self::Replace { .. });
        Self::single(effects).filter(makes).collect()
    }

    /// Whether it is repeated: the effect with this number among those that make parts.
    #[must_use]
    pub fn is_repeated(effects: &[Self], maker: usize) -> bool {
        let mut before = 0;
        for effect in effects {
            let own = Self::makers(std::slice::from_ref(effect)).len();
            if (before..before + own).contains(&maker) {
                return matches!(effect, Self::Repeat { .. });
            }
            before += own;
        }
        false
    }

    /// The expressions that it reads, those of what it repeats among them.
    #[must_use]
    pub fn exprs(&self) -> Vec<&Expr> {
        match self {
            Self::Attach { what, on } => [what, &on.port].into_iter().chain(&on.turned).collect(),
            Self::Replace { part, with, between } => {
                let ends = between.iter().flat_map(|(a, b)| [a, b]);
                [part, with].into_iter().chain(ends).collect()
            }
            Self::Set { part, value, .. } => vec![part, value],
            Self::Remove(e) | Self::Revert(e) | Self::Let(e) | Self::SetOfBody { value: e, .. } => vec![e],
            Self::Cells(cells) => [&cells.region].into_iter().chain(&cells.with).collect(),
            Self::Repeat { over, effects, .. } => {
                let over = over.iter().map(|binder| &binder.over);
                over.chain(effects.iter().flat_map(Self::exprs)).collect()
            }
            Self::Then => Vec::new(),
        }
    }
}

/// What a rule can set of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Settable {
    /// Its rotation about the port that holds it.
    Turn,
    /// A parameter of the actuator, by its name.
    Param(String),
}

impl Settable {
    /// What a grammar calls it.
    #[must_use]
    pub fn text(&self) -> &str {
        match self {
            Self::Turn => PartAttribute::Turn.text(),
            Self::Param(name) => name,
        }
    }
}

/// What every design must fulfil.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Requirement {
    /// Its name, or the text of its condition.
    pub name: String,
    /// What must hold.
    pub condition: Expr,
    /// Why.
    pub because: Option<String>,
    /// Where it is said.
    pub span: Span,
}

/// What a design should fulfil: a penalty if it does not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Preference {
    /// Its name, or the text of its condition.
    pub name: String,
    /// What should hold.
    pub condition: Expr,
    /// What the objective loses if it does not.
    pub weight: Expr,
    /// Why.
    pub because: Option<String>,
    /// Where it is said.
    pub span: Span,
}

impl Writer<'_> {
    pub(super) fn rule(&mut self, rule: &Rule, is_always: bool) {
        self.gap();
        self.line(0, format!("rule {} {{", rule.name));
        if is_always {
            self.line(1, "always");
        }
        let mut names = rule.locals.clone();
        let mut slot = 0;
        for matched in &rule.matches {
            let name = |i: usize| names.get(i).map_or("", String::as_str);
            let what = match &matched.what {
                Matched::Part { kind, port, joined_to } => {
                    let port =
                        if *port { format!(" with free port {}", name(slot + 1)) } else { String::new() };
                    let joined = joined_to.map_or(String::new(), |j| format!(" joined to {}", name(j)));
                    format!("{}{port}{joined}", group(kind))
                }
                Matched::Port { of } => {
                    format!("port{}", of.map_or(String::new(), |of| format!(" of {}", name(of))))
                }
                Matched::Joint => "joint".to_owned(),
                Matched::Step => "step".to_owned(),
            };
            let condition = matched
                .condition
                .as_ref()
                .map_or(String::new(), |c| format!(" where {}", self.expr(c, &names)));
            self.line(1, format!("match {} : {what}{condition}", name(slot)));
            slot += matched.slots();
        }
        for choice in &rule.choices {
            let spread = match &choice.spread {
                Spread::Even | Spread::Fixed => String::new(),
                Spread::Normal(a, b) => {
                    format!(" by normal({}, {})", self.expr(a, &names), self.expr(b, &names))
                }
                Spread::Uniform(a, b) => {
                    format!(" by uniform({}, {})", self.expr(a, &names), self.expr(b, &names))
                }
                Spread::Weights(list) => format!(" by {}", self.expr(list, &names)),
            };
            self.line(1, format!("choose {} in {}{spread}", choice.name, self.expr(&choice.domain, &names)));
        }
        for guard in &rule.guards {
            self.line(1, format!("when {}", self.expr(&guard.condition, &names)));
        }
        self.effects(1, &rule.effects, &mut names, rule.locals.len());
        let weight = self.expr(&rule.weight, &Names::new());
        if weight != "1" {
            self.line(1, format!("weight {weight}"));
        }
        self.line(0, "}");
    }

    /// Effects, a line each; the parts that they make are called by their number among what follows the `bound` locals of the rule.
    fn effects(&mut self, depth: usize, effects: &[Effect], names: &mut Names, bound: usize) {
        for effect in effects {
            let made = format!("made {}", names.len() - bound + 1);
            if let Some(text) = self.effect(effect, names) {
                self.line(depth, text);
            }
            match effect {
                Effect::Attach { .. } | Effect::Replace { .. } => names.push(made),
                Effect::Let(value) => {
                    let value = self.expr(value, names);
                    let name = format!("x{}", names.len());
                    self.line(depth, format!("let {name} = {value}"));
                    names.push(name);
                }
                Effect::Repeat { over, effects, lists } => {
                    let (mut inner, over) = self.repeated(over, names);
                    let alone = if let [one] = effects.as_slice() { self.effect(one, &inner) } else { None };
                    if let Some(text) = alone {
                        self.line(depth, format!("{text} for {over}"));
                    } else {
                        self.line(depth, format!("for {over} {{"));
                        self.effects(depth + 1, effects, &mut inner, bound);
                        self.line(depth, "}");
                    }
                    names.extend(lists.iter().map(|list| list.name.clone()));
                }
                _ => {}
            }
        }
    }

    /// An effect on a line, unless it repeats others.
    fn effect(&self, effect: &Effect, names: &Names) -> Option<String> {
        Some(match effect {
            Effect::Attach { what, on } => {
                format!("attach {}{}", self.expr(what, names), self.holding(on, names))
            }
            Effect::Replace { part, with, between } => {
                let between = between.as_ref().map_or(String::new(), |(a, b)| {
                    format!(" from {} to {}", self.expr(a, names), self.expr(b, names))
                });
                format!("replace {} with {}{between}", self.expr(part, names), self.expr(with, names))
            }
            Effect::Remove(part) => format!("remove {}", self.expr(part, names)),
            Effect::Set { part, attribute, value } => {
                let (part, value) = (self.expr(part, names), self.expr(value, names));
                format!("set {part}.{} = {value}", attribute.text())
            }
            Effect::SetOfBody { name, value } => format!("set {name} = {}", self.expr(value, names)),
            Effect::Revert(step) => format!("revert {}", self.expr(step, names)),
            Effect::Cells(cells) => self.cells(cells, names),
            Effect::Then => "then".to_owned(),
            Effect::Repeat { .. } | Effect::Let(_) => return None,
        })
    }

    pub(super) fn holding(&self, on: &Holding, names: &Names) -> String {
        let turned = on.turned.as_ref().map_or(String::new(), |t| format!(" turned {}", self.expr(t, names)));
        let by = on.by.as_ref().map_or(String::new(), |by| format!(" by {by}"));
        let alone = if on.alone { " alone" } else { "" };
        format!(" to {}{turned}{by}{alone}", self.expr(&on.port, names))
    }

    /// The initial design and its symmetry.
    pub(super) fn begun(&mut self) {
        let rules = self.rules;
        self.line(
            0,
            match rules.symmetry {
                Symmetry::None => "symmetry none".to_owned(),
                Symmetry::Mirror(normal) => {
                    format!("symmetry mirror {}", ["yz", "xz", "xy"].get(normal).unwrap_or(&""))
                }
                Symmetry::Radial(count, axis) => {
                    format!("symmetry radial {count} about {}", ["x", "y", "z"].get(axis).unwrap_or(&""))
                }
            },
        );
        if let Some(lattice) = &rules.lattice {
            let [x, y, z] = lattice.sides;
            self.line(0, format!("lattice {x} x {y} x {z} of {}", lattice.kind));
        }
        self.line(0, "begin {");
        let filled = rules.lattice.as_ref().map_or(&[][..], |lattice| &lattice.begin);
        self.effects(1, filled, &mut Names::new(), 0);
        for placed in &rules.begin {
            let what = self.expr(&placed.what, &Names::new());
            let on = placed.on.as_ref().map_or(String::new(), |on| self.holding(on, &Names::new()));
            self.line(1, format!("place {} : {what}{on}", placed.name));
        }
        self.line(0, "}");
    }

    /// What designs must and should be.
    pub(super) fn required(&mut self) {
        let rules = self.rules;
        for fallback in &rules.fallbacks {
            let condition = self.expr(&fallback.condition, &Names::new());
            self.line(0, format!("fallback {} when {condition}", fallback.rule));
        }
        for requirement in &rules.requirements {
            let because = requirement.because.as_ref().map_or(String::new(), |b| format!(" because {b:?}"));
            let condition = self.expr(&requirement.condition, &Names::new());
            let name = if requirement.name == condition {
                String::new()
            } else {
                format!("{} : ", requirement.name)
            };
            self.line(0, format!("require {name}{condition}{because}"));
        }
        for preference in &rules.preferences {
            let condition = self.expr(&preference.condition, &Names::new());
            let weight = self.expr(&preference.weight, &Names::new());
            self.line(0, format!("prefer {} : {condition} weight {weight}", preference.name));
        }
    }
}
