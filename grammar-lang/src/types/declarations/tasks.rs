//! Checks what a body is asked to do: tasks, objectives, the simulated time.

use indexmap::IndexMap;

use super::Declarations;
use super::observe::Observed;
use super::singles::{Actuated, OneTask, Singles, Wanted};
use crate::diagnostics::{Code, Diagnostic, Fix, did_you_mean, respell};
use crate::ir::{self, Attribute, Expr, ExprKind, JointKind, MotionWord, RuleSet, Ty};
use crate::names::declared;
use crate::source::Span;
use crate::syntax::ast::{self, Item, ItemKind, Name};
use crate::syntax::declarations::BlockKind;
use crate::types::expressions::context::Context;
use crate::types::expressions::fit::article;
use crate::types::expressions::stage::Stage;
use crate::types::expressions::task;
use crate::units::{self, Dimension};

/// Tasks by name, with the places of what they say about actuators.
pub(in crate::types) type Tasks = IndexMap<String, (ir::Task, Actuated)>;

/// What bodies are asked to do, and what is wanted of all that.
pub(in crate::types) struct Asked {
    pub(in crate::types) tasks: Tasks,
    pub(in crate::types) objective: ir::Objective,
    /// What is wanted beside that of several tasks.
    pub(in crate::types) beside: Vec<ir::Objective>,
}

impl<'a> Declarations<'a> {
    /// The tasks of a grammar and what is wanted of all together.
    pub(in crate::types) fn tasks(&mut self, singles: &Singles<'a>) -> Option<Asked> {
        let is_one = singles.tasks.is_empty();
        let stage = if is_one { Stage::Objective } else { Stage::Outcome };
        let known = self.expressions.errors.len();
        let objectives: Vec<Option<ir::Objective>> =
            singles.objectives.iter().map(|wanted| self.objective(*wanted, stage)).collect();
        for objective in objectives.iter().flatten().filter(|_| is_one) {
            self.own_worlds(objective, Simulated { scenarios: singles.scenarios, time: singles.duration });
        }
        self.same_twice(singles, &objectives);
        // What is wrong with one may hide which tasks it uses.
        let are_sound = self.expressions.errors.len() == known;
        if is_one {
            let mut objectives = objectives.into_iter();
            let mut objective = objectives.next()??;
            let actuated = singles.actuated.clone();
            let task = ir::Task {
                name: RuleSet::ONLY_TASK.to_owned(),
                actuated: names_only(&actuated),
                model: singles.model.clone()?,
                on: singles.on.iter().map(|on| on.text.clone()).collect(),
                scenarios: singles.scenarios.map(|(set, _)| within(set)),
                objective: objective.clone(),
                beside: objectives.collect::<Option<_>>()?,
            };
            let tasks = IndexMap::from([(RuleSet::ONLY_TASK.to_owned(), (task, actuated))]);
            objective.value.kind = ExprKind::Task(RuleSet::ONLY_TASK.to_owned());
            return Some(Asked { tasks, objective, beside: Vec::new() });
        }
        let mut tasks = IndexMap::new();
        let mut sound = true;
        for one in &singles.tasks {
            match self.task(*one, singles) {
                Some(task) => drop(tasks.insert(one.name.text.clone(), task)),
                None => sound = false,
            }
        }
        for OneTask { name, .. } in singles.tasks.iter().filter(|_| are_sound && !objectives.is_empty()) {
            let reads = |objective: &ir::Objective| {
                objective.value.any(&mut |e| matches!(&e.kind, ExprKind::Task(task) if *task == name.text))
            };
            if !objectives.iter().flatten().any(reads) {
                self.report(
                    Diagnostic::new(
                        Code::UNUSED,
                        name.span,
                        format!("the value of the task `{}` is not used", name.text),
                    )
                    .label("the search optimises it, but the objective does not read it")
                    .help(format!("use `{}.value` in the objective, or remove the task", name.text)),
                );
            }
        }
        let mut objectives = objectives.into_iter();
        let (objective, beside) = (objectives.next()??, objectives.collect::<Option<_>>()?);
        sound.then_some(Asked { tasks, objective, beside })
    }

    /// Two objectives that are the same, or the opposite of each other, leave nothing to trade.
    fn same_twice(&mut self, singles: &Singles<'a>, objectives: &[Option<ir::Objective>]) {
        let known: Vec<(Span, &ir::Objective)> = singles
            .objectives
            .iter()
            .zip(objectives)
            .filter_map(|(wanted, objective)| Some((wanted.span, objective.as_ref()?)))
            .collect();
        for (place, (span, objective)) in known.iter().enumerate() {
            let text = |objective: &ir::Objective| ir::without_spans(objective.quantity()).ok();
            let is_same = |other: &&(Span, &ir::Objective)| text(other.1) == text(objective);
            if let Some((first, other)) = known[..place].iter().find(is_same) {
                let message = if other.direction == objective.direction {
                    "this objective is already declared"
                } else {
                    "this asks for the opposite of another objective"
                };
                self.report(
                    Diagnostic::new(Code::DUPLICATE, *span, message)
                        .label("of the same quantity")
                        .also(*first, "the other one")
                        .help(
                            "keep one of them; in a variant, `replace` replaces the objectives of the base",
                        ),
                );
            }
        }
    }

    /// One task; what it does not say, the grammar says for all.
    fn task(
        &mut self,
        OneTask { name, items, damaged }: OneTask<'a>,
        singles: &Singles<'a>,
    ) -> Option<(ir::Task, Actuated)> {
        let mut own = Singles::default();
        for item in items {
            self.single(item, &mut own);
        }
        let mut actuated = own.actuated;
        for (kind, with) in &singles.actuated {
            actuated.entry(kind.clone()).or_insert_with(|| with.clone());
        }
        if let [first, another, ..] = own.objectives.as_slice() {
            self.report(
                Diagnostic::new(Code::DUPLICATE, another.span, "a task can have only one objective")
                    .label("another one")
                    .also(first.span, "the first one")
                    .help("keep one of them; a grammar can have several, over the values of its tasks"),
            );
        }
        let objective = match own.objectives.first() {
            Some(wanted) => self.objective(*wanted, Stage::Objective),
            None if damaged => None,
            None => {
                self.report(
                    Diagnostic::new(
                        Code::MISSING_ITEM,
                        name.span,
                        format!("the task `{}` has no objective", name.text),
                    )
                    .label("without an objective")
                    .help("add for example `maximize travel in cm`"),
                );
                None
            }
        };
        let (on, simulated) = if own.model.is_some() || own.duration.is_some() {
            (own.on, Simulated { scenarios: own.scenarios, time: own.duration })
        } else {
            (singles.on.clone(), Simulated { scenarios: singles.scenarios, time: singles.duration })
        };
        if let Some(objective) = &objective {
            self.own_worlds(objective, simulated);
        }
        let model = own.model.or_else(|| singles.model.clone());
        if model.is_none()
            && !damaged
            && !own.seen.contains_key("simulate")
            && !singles.seen.contains_key("simulate")
        {
            self.report(
                Diagnostic::new(
                    Code::MISSING_ITEM,
                    name.span,
                    format!("the task `{}` is not simulated", name.text),
                )
                .label("without `simulate`")
                .help("add for example `simulate hinge_model for 20 s`"),
            );
        }
        let on = on.iter().map(|on| on.text.clone()).collect();
        let task = ir::Task {
            name: name.text.clone(),
            actuated: names_only(&actuated),
            model: model?,
            on,
            scenarios: simulated.scenarios.map(|(set, _)| within(set)),
            objective: objective?,
            beside: Vec::new(),
        };
        Some((task, actuated))
    }

    pub(super) fn simulated(&mut self, name: &Name, duration: &ast::Expr) -> Option<ir::Model> {
        let mut cx = Context::new(Stage::Declaration, false);
        let span = duration.span;
        let time = Ty::Quantity(crate::units::Dimension::TIME);
        let seconds = self.expressions.expect(duration, &mut cx, &time, "the simulated time");
        let seconds = self.expressions.constant_number(&seconds);
        if let Some(d) = seconds
            && !(d > 0.0 && d <= 3600.0)
        {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    span,
                    "the simulated time must be above 0 s, and at most 1 h",
                )
                .label(crate::types::expressions::shown(d, &time))
                .help("write for example `20 s`"),
            );
            return None;
        }
        if let Some(time) = seconds {
            self.usual("a motion", "duration", time, duration);
        }
        let duration = seconds;
        match self.named(name, "model", |k| matches!(k, ItemKind::Block(BlockKind::Model, _))) {
            Some(ItemKind::Block(BlockKind::Model, block)) => self.model(block, Some(duration?), false),
            _ => None,
        }
    }

    /// An objective runs over the worlds of its own task, and over each of them once.
    fn own_worlds(&mut self, objective: &ir::Objective, simulated: Simulated<'_>) {
        let named = |e: &Expr| if let ExprKind::Scenarios(set) = &e.kind { Some(set.clone()) } else { None };
        let (mut others, mut inner) = (Vec::new(), Vec::new());
        objective.value.any(&mut |e| {
            others.extend(named(e).map(|set| (set, e.span)));
            if let ExprKind::Aggregate { binders, condition, body, .. } = &e.kind
                && let Some(first) = binders.iter().position(|binder| named(&binder.over).is_some())
            {
                let rest = binders[first + 1..].iter().map(|binder| &binder.over);
                for expr in rest.chain([condition, body].into_iter().flatten().map(|e| &**e)) {
                    expr.any(&mut |e| {
                        inner.extend(named(e).map(|set| (set, e.span)));
                        false
                    });
                }
            }
            false
        });
        // Where the `simulate` could not be read, the worlds are not known.
        if self.environment.program.has_unread("simulate") {
            return;
        }
        // What is wrong with their name is told there.
        if simulated.scenarios.is_some_and(|(_, is_known)| !is_known) {
            return;
        }
        let own = simulated.scenarios.map(|(own, _)| own.text.as_str());
        if let Some((set, place)) = others.into_iter().find(|(set, _)| Some(set.as_str()) != own) {
            let error = Diagnostic::new(
                Code::OTHER_WORLDS,
                place,
                format!("this runs over the worlds of `{set}`, in which the task is not simulated"),
            )
            .label("these are not the worlds of the task");
            let help = format!("add `in {set}` to its `simulate`");
            self.report(match (simulated.scenarios, simulated.time) {
                (Some((own, _)), _) => error
                    .also(own.span, "the task is simulated in these worlds")
                    .help(format!("run over `{}`, or simulate it in `{set}`", own.text)),
                (None, Some(time)) => {
                    error.help(&help).fix(Fix::insert_after(time, format!(" in {set}"), help))
                }
                (None, None) => error.help(help),
            });
        } else if let Some((_, place)) = inner.first() {
            self.report(
                Diagnostic::new(Code::OTHER_WORLDS, *place, "an `over` that runs over worlds cannot be inside another one")
                    .label("inside another `over`")
                    .help("write the two side by side, in brackets: `(mean over ... of X) - 2 * (deviation over ... of X)`"),
            );
        }
    }

    fn objective(&mut self, wanted: Wanted<'_>, stage: Stage) -> Option<ir::Objective> {
        let Wanted { direction, value: tree, damaged, .. } = wanted;
        let mut cx = Context::new(stage, damaged);
        let value = self.expressions.infer(tree, &mut cx);
        let unit = match &tree.kind {
            ast::ExprKind::Convert(_, unit) => unit.text.clone(),
            _ => String::new(),
        };
        match value.ty.dimension() {
            Some(d) if d.is_number() => Some(ir::Objective { direction, value, unit }),
            Some(d) => {
                self.report(
                    Diagnostic::new(
                        Code::OBJECTIVE_UNIT,
                        value.span,
                        format!("the objective has the dimension {d}, so it needs a unit"),
                    )
                    .label(format!("of the dimension {d}"))
                    .help(format!(
                        "write for example `in {}` after it: the value of a design and the temperature of a search are numbers in this unit",
                        self.told_in(d)
                    )),
                );
                None
            }
            None if value.ty == Ty::Unknown => None,
            None => {
                self.report(
                    Diagnostic::new(
                        Code::WRONG_TYPE,
                        value.span,
                        format!("the objective must be a number, but this is {}", article(&value.ty)),
                    )
                    .label("not a number"),
                );
                None
            }
        }
    }

    /// A unit for an objective: that of the tasks, where it fits.
    fn told_in(&self, dimension: Dimension) -> String {
        let units = self.environment.program.entries().filter_map(|(_, item)| match &item.kind {
            ItemKind::Task(_, items) => task::unit_of(items),
            _ => None,
        });
        let fits = |unit: &&Name| units::parse(&unit.text).is_ok_and(|unit| unit.dimension == dimension);
        let named = units.filter(fits).map(|unit| unit.text.clone()).next();
        // The searches of the library are made for it.
        let usual = (dimension == Dimension::LENGTH).then(|| "cm".to_owned());
        named.or(usual).unwrap_or_else(|| units::suggest(dimension))
    }

    fn says_what_drives(&self, kind: &str) -> bool {
        let drives = |item: &Item| matches!(&item.kind, ItemKind::Actuate(what, _) if what.text == *kind);
        self.environment.program.entries().any(|(_, item)| drives(item))
    }

    /// Checks that every actuator is driven by an actuation that fits it.
    pub(in crate::types) fn check_actuated(
        &mut self,
        actuated: &Actuated,
        actuators: &IndexMap<String, ir::Actuator>,
        actuations: &IndexMap<String, ir::Actuation>,
    ) {
        for (kind, actuator) in actuators {
            match actuated.get(kind) {
                None if actuator.motor.is_none() => {}
                Some((_, span)) if actuator.motor.is_none() => self.report(
                    Diagnostic::new(
                        Code::NOT_ACTUATED,
                        *span,
                        format!("`{kind}` is passive: nothing can drive it"),
                    )
                    .label("driven here")
                    .also(actuator.span, "its `joint` says `passive`")
                    .help(match actuator.joint.kind {
                        ir::JointKind::Socket => "take this line out: nothing can drive a socket",
                        _ => "take this line out, or take `passive` out of its `joint`",
                    }),
                ),
                // It says what drives it: that is what is wrong.
                None if self.says_what_drives(kind) || self.environment.program.has_unread("actuate") => {}
                None => {
                    // Where the grammar imports it: the library is not what is to be changed.
                    let imports = self
                        .environment
                        .program
                        .own
                        .iter()
                        .filter_map(|m| self.environment.program.modules.get(*m));
                    let imports = imports.flat_map(|m| &m.tree.items).filter_map(|i| match &i.kind {
                        ItemKind::Use { names: Some(names), .. } => Some(names),
                        _ => None,
                    });
                    let imports: Vec<&Name> = imports.flatten().collect();
                    let import = imports.iter().find(|n| n.text == *kind).map(|n| n.span);
                    let usual = usual_actuation(actuator.joint.kind);
                    let is_there = imports.iter().any(|n| n.text == usual);
                    let get = if is_there {
                        String::new()
                    } else {
                        format!(" and `use std.actuation {{ {usual} }}`")
                    };
                    let place = import.unwrap_or(actuator.span);
                    let mut error =
                        Diagnostic::new(Code::NOT_ACTUATED, place, format!("nothing drives `{kind}`"))
                            .label("an actuator without an actuation")
                            .help(format!("write for example `actuate {kind} with {usual}`{get}"));
                    if import.is_some() {
                        error = error.also(actuator.span, "declared here");
                    }
                    self.report(error);
                }
                Some((with, span)) => {
                    if let Some(actuation) = actuations.get(with) {
                        self.check_drive(kind, actuator, (with, actuation), *span);
                        self.check_attributes(kind, &actuator.params, actuation, *span);
                    }
                }
            }
        }
    }

    /// An actuator that slides is driven by a distance, one that spins by a speed, any other by an angle.
    fn check_drive(
        &mut self,
        kind: &str,
        actuator: &ir::Actuator,
        (with, actuation): (&str, &ir::Actuation),
        span: Span,
    ) {
        let joint = actuator.joint.kind;
        let drive = &actuation.drive;
        if matches!(drive.ty, Ty::Valves | Ty::Unknown) || drive.ty == Ty::Quantity(joint.driven()) {
            return;
        }
        let drives = ir::DRIVEN.iter().find(|(_, ty)| *ty == drive.ty).map_or("strain", |(word, _)| word);
        self.report(
            Diagnostic::new(
                Code::WRONG_DIMENSION,
                span,
                format!("`{with}` drives a {drives}, but `{kind}` {}", joint.does())
                    .replace("a angle", "an angle"),
            )
            .label("does not fit")
            .also(drive.span, "its drive")
            .also(actuator.span, "this actuator")
            .help(format!(
                "actuate `{kind}` with an actuation that says `drive {} = ...`",
                joint.driven_word()
            )),
        );
    }

    /// Checks that a task whose objective reads the period has one.
    pub(in crate::types) fn check_periods(
        &mut self,
        tasks: &Tasks,
        actuations: &IndexMap<String, ir::Actuation>,
        terms: &IndexMap<String, ir::Term>,
        observed: &[Observed],
    ) {
        for (number, (task, actuated)) in tasks.values().enumerate() {
            let periods = Periods::of(actuated.values().map(|(with, _)| with.as_str()), actuations);
            let Some((wrong, help)) = periods.fault() else { continue };
            // What is observed is observed of the first task.
            for Observed { name, .. } in observed.iter().filter(|_| number == 0) {
                if terms.get(&name.text).is_some_and(|term| period_in(&term.value, terms).is_some()) {
                    self.report(
                        Diagnostic::new(
                            Code::NO_PERIOD,
                            name.span,
                            format!("`{}` reads `period`, but {wrong}", name.text),
                        )
                        .label("no `period` to read")
                        .help(help.clone()),
                    );
                }
            }
            let reads = |objective: &'_ ir::Objective| {
                period_in(&objective.value, terms).map(|place| (place, objective.value.span))
            };
            if let Some((place, objective)) = task.objectives().find_map(reads) {
                self.report(
                    Diagnostic::new(Code::NO_PERIOD, place, format!("this reads `period`, but {wrong}"))
                        .label("no `period` to read")
                        .also(objective, "needed by this objective")
                        .help(help),
                );
            }
        }
    }

    /// An actuation may read only what the actuator that it drives has.
    pub(in crate::types) fn check_attributes(
        &mut self,
        kind: &str,
        params: &IndexMap<String, ir::InstanceParam>,
        actuation: &ir::Actuation,
        span: Span,
    ) {
        let groups = actuation.variables.iter().filter_map(|v| match &v.owner {
            ir::Owner::Group(expr) => Some(expr),
            _ => None,
        });
        for expr in actuation.values().chain(groups) {
            expr.any(&mut |e| {
                if let ExprKind::Attribute(of, Attribute::Param(name)) = &e.kind {
                    let own = matches!(of.kind, ExprKind::Local(0));
                    if own && !params.contains_key(name) {
                        self.report(
                            Diagnostic::new(
                                Code::UNKNOWN_FIELD,
                                span,
                                format!("this actuation reads `{name}`, which `{kind}` does not have"),
                            )
                            .label("does not fit")
                            .also(e.span, "read here")
                            .help(format!("add `param {name} : ...` to `{kind}`")),
                        );
                    }
                }
                false
            });
        }
    }

    /// The declaration of a certain kind that a name means.
    pub(super) fn named(
        &mut self,
        name: &Name,
        what: &str,
        fits: impl Fn(&ItemKind) -> bool,
    ) -> Option<&'a ItemKind> {
        let program = self.environment.program;
        match program.lookup(name.span, &name.text) {
            Some((declaration, item)) if fits(&item.kind) => {
                self.expressions.touched.insert(declaration);
                return Some(&item.kind);
            }
            None if self.expressions.is_lost(name.span, &name.text)
                || self.expressions.report_dropped(name.span, &name.text) =>
            {
                return None;
            }
            _ => {}
        }
        let others: Vec<&str> =
            self.expressions.guessable(name.span).filter(|(_, i)| fits(&i.kind)).map(|(n, _)| n).collect();
        let other = program.lookup(name.span, &name.text).and_then(|(_, i)| declared(i));
        let help = did_you_mean(&name.text, others.iter().copied()).unwrap_or_else(|| match others.first() {
            Some(one) if other.is_some() => format!("name {}, such as `{one}`", an(what)),
            _ => format!("declare it with `{what}`, or import it with `use`"),
        });
        let are = if what.ends_with('s') { "are" } else { "is" };
        let (message, label) = match other {
            Some(_) => (format!("`{}` is no {what}", name.text), "another kind of declaration"),
            None => (format!("there {are} no {what} `{}`", name.text), "not declared"),
        };
        let mut error = Diagnostic::new(Code::UNKNOWN_NAME, name.span, message)
            .label(label)
            .help(help)
            .fix_if(respell(name.span, &name.text, others));
        if let Some(other) = other {
            error = error.also(other.span, "declared here");
        }
        self.report(error);
        None
    }
}

/// What a task says of where it happens.
#[derive(Clone, Copy)]
struct Simulated<'a> {
    /// The scenarios, and whether there are such.
    scenarios: Option<(&'a Name, bool)>,
    /// Where its time stands.
    time: Option<Span>,
}

fn within(name: &Name) -> ir::Within {
    ir::Within { name: name.text.clone(), span: name.span }
}

/// An actuation of the standard library that fits joints of a kind.
fn usual_actuation(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Bend | JointKind::Twist | JointKind::Socket => "bezier_pac",
        JointKind::Slide => "extending_pac",
        JointKind::Spin => "steady_spin",
    }
}

/// A word of the language with its article.
fn an(what: &str) -> String {
    format!("{} {what}", if what.starts_with(['a', 'e']) { "an" } else { "a" })
}

fn names_only(actuated: &Actuated) -> IndexMap<String, String> {
    actuated.iter().map(|(kind, (with, _))| (kind.clone(), with.clone())).collect()
}

/// The period of one actuation.
enum Own<'e> {
    /// A variable that all actuations share.
    Everyone,
    /// A variable of this actuation.
    Shared,
    /// Another name of such a variable of all.
    Alias(&'e str),
    /// A value.
    Value(&'e Expr),
}

/// What the actuations of a task say of their period.
enum Periods<'a> {
    /// None has one.
    None,
    /// All that have one have the same.
    One,
    /// Each of these has its own.
    Several(Vec<&'a str>),
    /// Each actuator of this one has its own.
    Each(&'a str),
    /// That of this one is no time.
    NoTime(&'a str),
    /// That of this one changes during a motion, or stands below a value that does.
    Moving(&'a str),
}

impl<'a> Periods<'a> {
    fn of(names: impl Iterator<Item = &'a str>, actuations: &IndexMap<String, ir::Actuation>) -> Self {
        let mut found: Vec<(&str, Own)> = Vec::new();
        for name in names {
            let Some(actuation) = actuations.get(name) else { continue };
            let variable = actuation.variables.iter().find(|v| v.name == "period" && v.is_shared());
            let everyone = variable.is_some_and(|v| v.owner == ir::Owner::Everyone);
            let shared = variable.is_some();
            let place = actuation.lets.iter().position(|(n, _)| n == "period");
            let own = place.and_then(|place| actuation.lets.get(place)).map(|(_, value)| value);
            let everyone = everyone || place.is_some_and(|place| place < actuation.shared_lets);
            if variable.is_none() && actuation.moving.iter().any(|(n, _)| n == "period") {
                return Self::Moving(name);
            }
            if found.iter().any(|(other, _)| *other == name) || !(shared || own.is_some()) {
                continue;
            }
            let is_time = |ty: &Ty| ty.dimension() == Some(Dimension::TIME);
            let fits = match (variable, own) {
                (Some(variable), _) => variable.size.is_none() && is_time(&variable.ty),
                (None, Some(value)) => is_time(&value.ty),
                (None, None) => true,
            };
            if !fits {
                return Self::NoTime(name);
            }
            if let Some(value) = own.filter(|_| !shared)
                && differs(value, actuation)
            {
                return Self::Each(name);
            }
            found.push((
                name,
                match own.filter(|_| !shared) {
                    Some(_) if everyone => Own::Everyone,
                    Some(value) => alias(value, actuation).map_or(Own::Value(value), Own::Alias),
                    None if everyone => Own::Everyone,
                    None => Own::Shared,
                },
            ));
        }
        let value = |own: &Own| match own {
            Own::Value(value) if is_constant(value) => ir::without_spans(value).ok(),
            _ => None,
        };
        match found.as_slice() {
            [] => Self::None,
            [(_, first), rest @ ..] => {
                let everyone = |own: &Own| matches!(own, Own::Everyone);
                let constant = value(first);
                let named = |own: &Own| match own {
                    Own::Alias(name) => Some((*name).to_owned()),
                    _ => None,
                };
                let same = rest.iter().all(|(_, own)| {
                    everyone(first) && everyone(own)
                        || constant.is_some() && value(own) == constant
                        || named(first).is_some() && named(first) == named(own)
                });
                if same { Self::One } else { Self::Several(found.iter().map(|(name, _)| *name).collect()) }
            }
        }
    }

    /// What is wrong with them for what reads the period, and what helps.
    fn fault(&self) -> Option<(String, String)> {
        match self {
            Self::One => None,
            Self::None => Some((
                "no actuation of this grammar has one".to_owned(),
                "declare `shared period : Time in ...` outside the actuations or in one of them, or `let period = ...` in an actuation: terms read the value that has the name `period`"
                    .to_owned(),
            )),
            Self::Several(names) => Some((
                format!("each of {} has a period of its own", one_by_one(names)),
                "declare `shared period : Time in ...` once, outside the actuations: then all of them read the same period"
                    .to_owned(),
            )),
            Self::NoTime(name) => Some((
                format!("the `period` of `{name}` is not a single time"),
                "declare `shared period : Time in ...`, or give it another name".to_owned(),
            )),
            Self::Moving(name) => Some((
                format!("the `period` of `{name}` changes during the motion, or is declared below a value that does"),
                "declare it above everything that reads `t`, a sensor or a state, or declare `shared period : Time in ...`"
                    .to_owned(),
            )),
            Self::Each(name) => Some((
                format!("each actuator that `{name}` drives has a period of its own"),
                "compute it from a shared variable: `shared period : Time in ...`".to_owned(),
            )),
        }
    }
}

fn one_by_one(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.as_slice() {
        [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        _ => quoted.concat(),
    }
}

/// Whether a value of an actuation may be another for each actuator: it reads the actuator itself, what is not shared, or a
/// value that does.
fn differs(value: &Expr, actuation: &ir::Actuation) -> bool {
    let (shared, first) = (actuation.variables.len(), actuation.first_let());
    value.any(&mut |e| match e.kind {
        ExprKind::Local(0) => true,
        ExprKind::Local(slot) if slot <= shared => {
            actuation.variables.get(slot - 1).is_some_and(|v| !v.is_shared())
        }
        // What is remembered, each actuator remembers.
        ExprKind::Local(slot) if slot < first => true,
        ExprKind::Local(slot) => actuation
            .lets
            .get(slot - first)
            .is_some_and(|(_, earlier)| !std::ptr::eq(earlier, value) && differs(earlier, actuation)),
        _ => false,
    })
}

/// The variable of all actuations that a value is another name of.
fn alias<'a>(value: &Expr, actuation: &'a ir::Actuation) -> Option<&'a str> {
    let ExprKind::Local(slot) = value.kind else { return None };
    let variable = actuation.variables.get(slot.checked_sub(1)?)?;
    (variable.owner == ir::Owner::Everyone).then_some(variable.name.as_str())
}

fn is_constant(value: &Expr) -> bool {
    !value.any(&mut |e| matches!(e.kind, ExprKind::Local(_)))
}

/// Where an expression, or a term that it uses, reads the period.
fn period_in(expr: &Expr, terms: &IndexMap<String, ir::Term>) -> Option<Span> {
    let mut found = None;
    for (_, expr) in ir::builds_on(expr, terms) {
        expr.any(&mut |e| {
            if matches!(e.kind, ExprKind::Word(ir::Word::Motion(MotionWord::Period))) {
                found = Some(e.span);
            }
            false
        });
    }
    found
}
