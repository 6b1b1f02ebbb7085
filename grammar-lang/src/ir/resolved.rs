//! A typed rule set as text for people: what a grammar comes to once variants,
//! imports, functions and parameters are resolved.

use std::fmt::Write;

use indexmap::IndexMap;

use super::{
    Actuation, Actuator, Archive, Backend, Cells, Descriptor, Effect, Expr, ExprKind, Feature, Form, Gather,
    Group, Holding, InstanceParam, Kernel, Matched, Method, Model, Novelty, Objective, Owner, Part,
    Pneumatic, Rule, RuleSet, Schedule, SearchMethod, Speed, Spread, Symmetry, Table, Target, Tendon, Ty,
};
use crate::units::{self, Dimension};

/// Writes a rule set much as a grammar is written, with every number in a unit that people use.
#[must_use]
pub fn resolved(rules: &RuleSet) -> String {
    let mut out = Writer { rules, text: String::new() };
    out.rule_set();
    out.text
}

struct Writer<'r> {
    rules: &'r RuleSet,
    text: String,
}

/// What the local slots of an expression are called.
type Names = Vec<String>;

fn quantity(value: f64, ty: &Ty) -> String {
    units::shown(value, ty.dimension().unwrap_or_default())
}

fn range((low, high): (f64, f64), ty: &Ty) -> String {
    format!("{} .. {}", quantity(low, ty), quantity(high, ty))
}

fn tabulated(table: &Table, from: Dimension, to: Dimension) -> String {
    let row = |[x, y]: &[f64; 2]| format!("{} -> {}", units::shown(*x, from), units::shown(*y, to));
    let rows: Vec<String> = table.rows.iter().map(row).collect();
    format!("table {{ {} }}", rows.join(", "))
}

fn shape(form: Form) -> String {
    let (solid, lengths) = form.written();
    let lengths: Vec<String> = lengths.into_iter().map(|x| units::shown(x, Dimension::LENGTH)).collect();
    format!("{}({})", solid.text(), lengths.join(", "))
}

fn group(group: &Group) -> &str {
    match group {
        Group::Part => "part",
        Group::Block => "block",
        Group::Actuator => "actuator",
        Group::Cell => "cell",
        Group::Kind(kind) => kind,
    }
}

impl Writer<'_> {
    fn line(&mut self, indent: usize, text: impl AsRef<str>) {
        // Writing to a String never fails.
        let _ = writeln!(self.text, "{:width$}{}", "", text.as_ref(), width = 2 * indent);
    }

    fn gap(&mut self) {
        self.text.push('\n');
    }

    /// A number, or the value of an enumeration that it stands for.
    fn constant(&self, value: f64, ty: &Ty) -> String {
        match ty {
            Ty::Enum(name) => match self.rules.value_of(name, value) {
                Some(word) => format!("{name}.{word}"),
                None => value.to_string(),
            },
            ty => quantity(value, ty),
        }
    }

    fn rule_set(&mut self) {
        let rules = self.rules;
        self.declared();
        self.begun();
        rules.rules.iter().for_each(|rule| self.rule(rule));
        self.gap();
        self.required();
        rules.actuations.iter().for_each(|(name, actuation)| self.actuation(name, actuation));
        self.gap();
        self.scored();
        self.asked();
        let from = rules.from.as_ref().map_or(String::new(), |from| format!(" from {from}"));
        self.line(0, format!("search {}{from} {{", rules.search.name));
        self.line(1, format!("keep = {}", rules.search.keep));
        if let Some(bodies) = &rules.search.bodies {
            self.searched("bodies", &bodies.schedule, bodies.method(), false);
        }
        if let Some(curves) = &rules.search.curves {
            self.searched("curves", &curves.schedule, curves.method(), curves.warm);
        }
        self.line(0, "}");
    }

    /// Parameters, parts and patterns.
    fn declared(&mut self) {
        let rules = self.rules;
        self.line(0, format!("grammar {}", rules.name));
        self.gap();
        for (name, param) in &rules.params {
            let domain = param.domain.map_or(String::new(), |d| format!(" in {}", range(d, &param.ty)));
            let value = self.constant(param.value, &param.ty);
            self.line(0, format!("param {name} : {}{domain} = {value}", param.ty));
        }
        rules.parts.iter().for_each(|(name, part)| self.part(name, part));
        rules.actuators.iter().for_each(|(name, actuator)| self.actuator(name, actuator));
        self.cell();
        for (name, value) in &rules.patterns {
            let value = self.expr(value, &Names::new());
            self.line(0, format!("pattern {name} = {value}"));
        }
        self.gap();
    }

    /// The initial design and its symmetry.
    fn begun(&mut self) {
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
        for effect in rules.lattice.iter().flat_map(|lattice| &lattice.begin) {
            if let Effect::Cells(cells) = effect {
                let text = self.cells(cells, &Names::new());
                self.line(1, text);
            }
        }
        for placed in &rules.begin {
            let what = self.expr(&placed.what, &Names::new());
            let on = placed.on.as_ref().map_or(String::new(), |on| self.holding(on, &Names::new()));
            self.line(1, format!("place {} : {what}{on}", placed.name));
        }
        self.line(0, "}");
    }

    /// What designs must and should be.
    fn required(&mut self) {
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

    /// Terms, hardware, and what is observed.
    fn scored(&mut self) {
        let rules = self.rules;
        for (name, term) in &rules.terms {
            let value = self.expr(&term.value, &Names::new());
            self.line(0, format!("term {name} : {} = {value}", term.ty));
        }
        rules.targets.iter().for_each(|(name, target)| self.target(name, target));
        for (name, prototype) in &rules.prototypes {
            let speed = |x: f64| units::shown(x, Dimension::VELOCITY);
            let length = prototype
                .length
                .map_or(String::new(), |x| format!(", length = {}", units::shown(x, Dimension::LENGTH)));
            let (simulated, measured) = (speed(prototype.simulated), speed(prototype.measured));
            self.line(
                0,
                format!(
                    "prototype {name} on {} {{ simulated = {simulated}, measured = {measured}{length} }}",
                    prototype.backend
                ),
            );
        }
        if !rules.observed.is_empty() {
            self.line(0, format!("observe {}", rules.observed.join(", ")));
        }
        rules.novelties.iter().for_each(|(name, novelty)| self.novelty(name, novelty));
    }

    fn novelty(&mut self, name: &str, novelty: &Novelty) {
        let rules = self.rules;
        self.line(0, format!("novelty {name} {{"));
        for (name, Feature { value, weight, .. }) in &novelty.features {
            let value = self.expr(value, &Names::new());
            self.line(1, format!("feature {name} = {value} weight {weight}"));
        }
        for (name, values) in &novelty.known {
            let fields = novelty.features.iter().zip(values);
            let fields: Vec<String> = fields
                .map(|((name, feature), value)| match &feature.ty {
                    Ty::Enum(of) => format!("{name} = {}", rules.value_of(of, *value).unwrap_or("?")),
                    Ty::Bool => format!("{name} = {}", *value != 0.0),
                    ty => {
                        format!("{name} = {}", units::shown(*value, ty.dimension().unwrap_or_default()))
                    }
                })
                .collect();
            self.line(1, format!("known {name:?} {{ {} }}", fields.join("  ")));
        }
        self.line(0, "}");
    }

    /// The tasks, and what is wanted of all together.
    fn asked(&mut self) {
        let rules = self.rules;
        for (name, task) in &rules.tasks {
            let indent = usize::from(*name != RuleSet::ONLY_TASK);
            self.gap();
            if indent > 0 {
                self.line(0, format!("task {name} {{"));
            }
            for (kind, with) in &task.actuated {
                self.line(indent, format!("actuate {kind} with {with}"));
            }
            self.objective(indent, &task.objective);
            self.model(indent, &task.model, task.on.as_deref());
            if indent > 0 {
                self.line(0, "}");
            }
        }
        self.gap();
        if !rules.tasks.contains_key(RuleSet::ONLY_TASK) {
            self.objective(0, &rules.objective);
        }
    }

    fn part(&mut self, name: &str, part: &Part) {
        self.gap();
        self.line(0, format!("part {name} {{"));
        self.line(1, format!("shape = {}", shape(part.shape)));
        self.line(1, format!("mass = {}", units::shown(part.mass, Dimension::MASS)));
        self.line(1, format!("friction = {}", part.friction));
        for port in &part.ports {
            let at = port.at.map(|x| units::shown(x, Dimension::LENGTH)).join(", ");
            let facing = port.facing.map(|x| x.to_string()).join(", ");
            self.line(
                1,
                format!("port {}[{}] at vector({at}) facing vector({facing})", port.name, port.index),
            );
        }
        self.line(0, "}");
    }

    fn actuator(&mut self, name: &str, actuator: &Actuator) {
        self.gap();
        self.line(0, format!("actuator {name} {{"));
        self.instance_params(&actuator.params);
        self.line(1, format!("segment = {}", shape(actuator.segment)));
        let angle = Ty::Quantity(Dimension::ANGLE);
        self.line(1, format!("bend = {}", range(actuator.bend, &angle)));
        for (field, speed) in
            [("bending_speed", &actuator.bending_speed), ("relaxing_speed", &actuator.relaxing_speed)]
        {
            let speed = match speed {
                Speed::Constant(speed) => units::shown(*speed, Dimension::ANGULAR_VELOCITY),
                Speed::ByBend(table) => tabulated(table, Dimension::ANGLE, Dimension::ANGULAR_VELOCITY),
            };
            self.line(1, format!("{field} = {speed}"));
        }
        for (field, value, dimension) in [
            ("mass", actuator.mass, Dimension::MASS),
            ("friction", actuator.friction, Dimension::NUMBER),
            ("torque", actuator.torque, Dimension::TORQUE),
            ("stiffness", actuator.stiffness, Dimension::ANGULAR_STIFFNESS),
            ("damping", actuator.damping, Dimension::ANGULAR_DAMPING),
        ] {
            self.line(1, format!("{field} = {}", units::shown(value, dimension)));
        }
        self.line(0, "}");
    }

    fn instance_params(&mut self, params: &IndexMap<String, InstanceParam>) {
        for (name, param) in params {
            let domain = param.domain.map_or(String::new(), |d| format!(" in {}", range(d, &param.ty)));
            let default = param
                .default
                .as_ref()
                .map_or(String::new(), |d| format!(" = {}", self.expr(d, &Names::new())));
            self.line(1, format!("param {name} : {}{domain}{default}", param.ty));
        }
    }

    fn cell(&mut self) {
        let Some(lattice) = &self.rules.lattice else { return };
        let cell = &lattice.cell;
        self.gap();
        self.line(0, format!("cell {} {{", lattice.kind));
        self.instance_params(&cell.params);
        self.line(1, format!("spacing = {}", units::shown(cell.spacing, Dimension::LENGTH)));
        let names: Names = cell.params.keys().cloned().collect();
        for (field, value) in [
            ("mass", &cell.mass),
            ("friction", &cell.friction),
            ("stiffness", &cell.stiffness),
            ("damping", &cell.damping),
            ("colour", &cell.colour),
        ] {
            let value = self.expr(value, &names);
            self.line(1, format!("{field} = {value}"));
        }
        self.line(0, "}");
    }

    fn cells(&self, cells: &Cells, names: &Names) -> String {
        let mut names = names.clone();
        let mut over = Vec::new();
        for binder in &cells.over {
            let what = self.expr(&binder.over, &names);
            names.resize(binder.slot, String::new());
            names.push(format!("x{}", binder.slot));
            over.push(format!("x{} in {what}", binder.slot));
        }
        let with = cells.with.as_ref().map_or(String::new(), |w| format!(" with {}", self.expr(w, &names)));
        let over = if over.is_empty() { String::new() } else { format!(" for {}", over.join(", ")) };
        format!("{} {}{with}{over}", cells.how.word(), self.expr(&cells.region, &names))
    }

    fn rule(&mut self, rule: &Rule) {
        self.gap();
        self.line(0, format!("rule {} {{", rule.name));
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
        for effect in &rule.effects {
            let made = format!("made {}", names.len() - rule.locals.len() + 1);
            let text = match effect {
                Effect::Attach { what, on } => {
                    let text = format!("attach {}{}", self.expr(what, &names), self.holding(on, &names));
                    names.push(made);
                    text
                }
                Effect::Replace { part, with, between } => {
                    let between = between.as_ref().map_or(String::new(), |(a, b)| {
                        format!(" from {} to {}", self.expr(a, &names), self.expr(b, &names))
                    });
                    let text = format!(
                        "replace {} with {}{between}",
                        self.expr(part, &names),
                        self.expr(with, &names)
                    );
                    names.push(made);
                    text
                }
                Effect::Remove(part) => format!("remove {}", self.expr(part, &names)),
                Effect::Set { part, attribute, value } => {
                    format!(
                        "set {}.{} = {}",
                        self.expr(part, &names),
                        attribute.text(),
                        self.expr(value, &names)
                    )
                }
                Effect::Revert(step) => format!("revert {}", self.expr(step, &names)),
                Effect::Cells(cells) => self.cells(cells, &names),
            };
            self.line(1, text);
        }
        let weight = self.expr(&rule.weight, &Names::new());
        if weight != "1" {
            self.line(1, format!("weight {weight}"));
        }
        self.line(0, "}");
    }

    fn holding(&self, on: &Holding, names: &Names) -> String {
        let turned = on.turned.as_ref().map_or(String::new(), |t| format!(" turned {}", self.expr(t, names)));
        let by = on.by.as_ref().map_or(String::new(), |by| format!(" by {by}"));
        format!(" to {}{turned}{by}", self.expr(&on.port, names))
    }

    fn actuation(&mut self, name: &str, actuation: &Actuation) {
        self.gap();
        self.line(0, format!("actuation {name} for a : actuator {{"));
        let mut names: Names = vec!["a".to_owned()];
        for variable in &actuation.variables {
            let (word, per) = match &variable.owner {
                Owner::Body => ("shared", String::new()),
                Owner::Actuator => ("vary", String::new()),
                Owner::Group(number) => ("vary", format!(" per {}", self.expr(number, &names))),
            };
            let size = variable.size.map_or(String::new(), |n| format!("[{n}]"));
            let domain = if variable.ty == Ty::Bool {
                String::new()
            } else {
                format!(" in {}", range(variable.domain, &variable.ty))
            };
            let chance = self.expr(&variable.mutation.probability, &Names::new());
            let kernel = match &variable.mutation.kernel {
                Kernel::Flip => format!(" flip {chance}"),
                Kernel::Normal(a, b) => {
                    format!(
                        " mutate {chance} by normal({}, {})",
                        self.expr(a, &Names::new()),
                        self.expr(b, &Names::new())
                    )
                }
                Kernel::Uniform(a, b) => {
                    format!(
                        " mutate {chance} by uniform({}, {})",
                        self.expr(a, &Names::new()),
                        self.expr(b, &Names::new())
                    )
                }
            };
            let bound = format!("{:?}", variable.mutation.bound).to_lowercase();
            self.line(
                1,
                format!(
                    "{word} {}{size} : {}{domain}{per}{kernel} bound {bound}",
                    variable.name, variable.ty
                ),
            );
        }
        names.extend(actuation.variables.iter().map(|v| v.name.clone()));
        for (name, value) in actuation.lets.iter().chain(&actuation.moving) {
            self.line(1, format!("let {name} = {}", self.expr(value, &names)));
            names.push(name.clone());
        }
        let driven = match &actuation.drive.ty {
            Ty::Valves => "valves",
            Ty::Quantity(Dimension::ANGLE) => "angle",
            _ => "strain",
        };
        self.line(1, format!("drive {driven} = {}", self.expr(&actuation.drive, &names)));
        self.line(0, "}");
    }

    fn objective(&mut self, indent: usize, objective: &Objective) {
        let value = self.expr(&objective.value, &Names::new());
        self.line(indent, format!("{} {value}", objective.direction));
    }

    fn target(&mut self, name: &str, target: &Target) {
        self.gap();
        self.line(0, format!("target {name} on {} for {} {{", target.backend.name(), target.kind));
        let time = |x: f64| units::shown(x, Dimension::TIME);
        let mut fields = match &target.backend {
            Backend::Pneumatic(air) => vec![
                format!("inflate = [{}]", air.inflate.join(", ")),
                format!("vent = [{}]", air.vent.join(", ")),
                format!("shortest = {}", time(air.shortest)),
                format!("safe = {}", if air.vents { "vent" } else { "hold" }),
            ],
            Backend::Tendon(threads) => vec![
                format!("servo = [{}]", threads.servo.join(", ")),
                format!("thread = {}", tabulated(&threads.thread, Dimension::ANGLE, Dimension::LENGTH)),
                format!("wheel = {}", units::shown(threads.wheel, Dimension::LENGTH)),
                format!("turn = {}", range(threads.turn, &Ty::Quantity(Dimension::ANGLE))),
                format!("servo_speed = {}", units::shown(threads.speed, Dimension::ANGULAR_VELOCITY)),
                format!("pulse = {}", range(threads.pulse, &Ty::Quantity(Dimension::TIME))),
                format!("safe = {}", if threads.rests { "rest" } else { "release" }),
            ],
        };
        if let Backend::Pneumatic(Pneumatic { supply: Some(supply), .. }) = &target.backend {
            let (pressure, full) = (
                units::shown(supply.pressure, Dimension::PRESSURE),
                units::shown(supply.full, Dimension::PRESSURE),
            );
            let flow = |x: f64| units::shown(x, Dimension::FLOW_CONDUCTANCE);
            fields.push(format!(
                "supply {{ pressure = {pressure}, full = {full}, line = {}, valve = {} }}",
                flow(supply.line),
                flow(supply.valve)
            ));
        }
        if let Backend::Tendon(Tendon { opposite, .. }) = &target.backend
            && !opposite.is_empty()
        {
            fields.insert(1, format!("opposite = [{}]", opposite.join(", ")));
        }
        fields.extend(target.speed.as_ref().map(|s| format!("speed = {}", self.expr(s, &Names::new()))));
        for field in fields {
            self.line(1, field);
        }
        self.line(0, "}");
    }

    fn model(&mut self, indent: usize, model: &Model, on: Option<&str>) {
        let on = on.map_or(String::new(), |on| format!(" on {on}"));
        self.line(
            indent,
            format!("simulate {} for {}{on} {{", model.name, units::shown(model.duration, Dimension::TIME)),
        );
        if let Method::Balls(filling) = &model.method {
            self.line(indent + 1, "method = balls");
            if let Some(filling) = filling {
                let spacing = units::shown(filling.spacing, Dimension::LENGTH);
                let (stiffness, damping) = (
                    units::shown(filling.stiffness, Dimension::STIFFNESS),
                    units::shown(filling.damping, Dimension::DAMPING),
                );
                self.line(
                    indent + 1,
                    format!(
                        "filling {{ spacing = {spacing}, stiffness = {stiffness}, damping = {damping} }}"
                    ),
                );
            }
        }
        for (field, value, dimension) in [
            ("step", model.step, Dimension::TIME),
            ("control", model.control, Dimension::TIME),
            ("record", model.record, Dimension::TIME),
            ("gravity", model.gravity, Dimension::ACCELERATION),
            ("ground_friction", model.ground_friction, Dimension::NUMBER),
            ("speed_limit", model.speed_limit, Dimension::VELOCITY),
        ] {
            self.line(indent + 1, format!("{field} = {}", units::shown(value, dimension)));
        }
        if let Some(limit) = model.pace_limit {
            self.line(indent + 1, format!("pace_limit = {}", units::shown(limit, Dimension::VELOCITY)));
        }
        self.line(indent + 1, format!("iterations = {}", model.iterations));
        self.line(indent + 1, format!("tolerance = {}", units::shown(model.tolerance, Dimension::NUMBER)));
        self.line(indent + 1, format!("self_collision = {}", model.self_collision));
        self.line(indent, "}");
    }

    /// A loop of a search.
    fn searched(&mut self, name: &str, schedule: &Schedule, method: SearchMethod<'_>, warm: bool) {
        self.line(1, format!("{name} {} {{", method.name()));
        let show = |value: &Expr| self.expr(value, &Names::new());
        let own = match method {
            SearchMethod::Annealing(annealing) => vec![
                ("walk", annealing.walk.map(|n| n.to_string())),
                ("chains", annealing.chains.map(|n| n.to_string())),
                ("exchange", annealing.exchange.as_ref().map(show)),
            ],
            SearchMethod::CmaEs(cma_es) => vec![
                ("spread", Some(cma_es.spread.to_string())),
                ("restart", cma_es.restart.as_ref().map(show)),
            ],
            SearchMethod::Archive(_) => Vec::new(),
        };
        let temperature = match method {
            SearchMethod::Annealing(annealing) => Some(show(&annealing.temperature)),
            SearchMethod::CmaEs(_) | SearchMethod::Archive(_) => None,
        };
        let shared = [
            ("warm", warm.then(|| "true".to_owned())),
            ("iterations", Some(show(&schedule.iterations))),
            ("moves", Some(show(&schedule.moves))),
            ("temperature", temperature),
            ("stop", Some(show(&schedule.stop))),
        ];
        let given = own.into_iter().chain(shared);
        let mut lines: Vec<String> =
            given.filter_map(|(field, value)| Some(format!("{field} = {}", value?))).collect();
        if let SearchMethod::Archive(Archive { descriptors }) = method {
            lines.extend(descriptors.iter().map(|(name, kind)| self.descriptor(name, kind)));
        }
        for line in lines {
            self.line(2, line);
        }
        self.line(1, "}");
    }

    fn descriptor(&self, name: &str, kind: &Descriptor) -> String {
        let scale = |x: f64| self.constant(x, &kind.value.ty);
        let (value, from, to) = (self.expr(&kind.value, &Names::new()), scale(kind.from), scale(kind.to));
        let cells = kind.cells;
        format!("descriptor {name} {{ value = {value}, from = {from}, to = {to}, cells = {cells} }}")
    }

    /// An expression, with brackets around everything that could be read in two ways.
    fn expr(&self, expr: &Expr, names: &Names) -> String {
        let show = |e: &Expr| self.expr(e, names);
        let all = |items: &[Expr]| items.iter().map(show).collect::<Vec<_>>().join(", ");
        match &expr.kind {
            ExprKind::Number(x) => self.constant(*x, &expr.ty),
            ExprKind::Bool(x) => x.to_string(),
            ExprKind::Text(x) => format!("{x:?}"),
            ExprKind::Param(name)
            | ExprKind::Placed(name)
            | ExprKind::Pattern(name)
            | ExprKind::Term(name) => name.clone(),
            ExprKind::Table(table) => match &expr.ty {
                Ty::Table(from, to) => tabulated(table, *from, *to),
                _ => tabulated(table, Dimension::NUMBER, Dimension::NUMBER),
            },
            ExprKind::PortName(name) => name.clone(),
            ExprKind::Task(name) if *name == RuleSet::ONLY_TASK => "the value of the task".to_owned(),
            ExprKind::Task(name) => format!("{name}.value"),
            ExprKind::Shared(actuation, variable) => format!("{actuation}.{variable}"),
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
            ExprKind::Binary(a, operator, b) => format!("({} {} {})", show(a), operator.symbol(), show(b)),
            ExprKind::If(a, b, c) => format!("(if {} then {} else {})", show(a), show(b), show(c)),
            ExprKind::Call(function, arguments) => format!("{}({})", function.text(), all(arguments)),
            ExprKind::Apply(curve, place) => format!("{}({})", show(curve), show(place)),
            ExprKind::Index(list, index) => format!("{}[{}]", show(list), show(index)),
            ExprKind::Range(low, high) => format!("{} .. {}", show(low), show(high)),
            ExprKind::Set(items) => format!("{{ {} }}", all(items)),
            ExprKind::List(items) => format!("[{}]", all(items)),
            ExprKind::Convert(x, factor) => format!("({} in units of {factor})", show(x)),
            ExprKind::Aggregate { how, binders, condition, body, otherwise } => {
                let mut names = names.clone();
                let mut over = Vec::new();
                for binder in binders {
                    let what = self.expr(&binder.over, &names);
                    names.resize(binder.slot, String::new());
                    names.push(format!("x{}", binder.slot));
                    over.push(format!("x{} in {what}", binder.slot));
                }
                let part = |word: &str, e: &Option<Box<Expr>>| {
                    e.as_ref().map_or(String::new(), |e| format!(" {word} {}", self.expr(e, &names)))
                };
                let condition = part("where", condition);
                let over = over.join(", ");
                match how {
                    Gather::Forall | Gather::Exists => {
                        let word = if *how == Gather::Forall { "forall" } else { "exists" };
                        let body = body.as_ref().map_or(String::new(), |b| self.expr(b, &names));
                        format!("({word} {over}{condition}: {body})")
                    }
                    _ => {
                        let word = match how {
                            Gather::Count => "count",
                            Gather::Sum => "sum",
                            Gather::Mean => "mean",
                            Gather::Min => "min",
                            Gather::Clusters => "clusters",
                            _ => "max",
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
