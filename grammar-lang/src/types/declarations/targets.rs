//! Checks what a grammar says of its hardware: tables, targets, prototypes.

use indexmap::IndexMap;

use super::fields::{Fields, Sign, Values};
use super::tasks::Tasks;
use super::{Declarations, Named};
use crate::diagnostics::{Code, Diagnostic, did_you_mean, respell};
use crate::eval::Value;
use crate::ir::{self, Backend, Expr, ExprKind, Field, PINS, Ty};
use crate::names::declared;
use crate::source::Span;
use crate::syntax::ast::{self, Block, ItemKind, Name};
use crate::syntax::declarations::BlockKind;
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;
use crate::units::{self, Dimension};

const PNEUMATIC: Fields<'static> = Fields {
    all: &["inflate", "vent", "shortest", "safe", "supply", "speed", "sensors"],
    blocks: &["supply"],
};
const SUPPLY: Fields<'static> = Fields::values(&["pressure", "full", "line", "valve"]);
const TENDON: Fields<'static> = Fields::values(&[
    "servo",
    "opposite",
    "thread",
    "wheel",
    "turn",
    "servo_speed",
    "pulse",
    "safe",
    "speed",
    "sensors",
]);
const PROTOTYPE: Fields<'static> = Fields::values(&["simulated", "measured", "length"]);

/// Reads the fields of a back end.
type Reader<C> = fn(&mut C, &Values<'_>, &Context) -> Option<Backend>;

/// The pulses at the ends of a servo's turn are at least so far apart, s.
const SHORTEST_WAY: f64 = 200e-6;

/// What a target does when something goes wrong.
const SAFE_AIR: [&str; 2] = ["vent", "hold"];
const SAFE_THREADS: [&str; 2] = ["rest", "release"];

impl Declarations<'_> {
    /// A field that holds a table, whose answers must be ordered.
    fn monotonic(&mut self, from: &Values<'_>, name: &str, ty: &Ty, cx: &Context) -> Option<ir::Table> {
        let (value, span) = self.value(from, name, ty, "thread_lengths", cx)?;
        let Value::Table(table) = value else { return None };
        if !table.is_monotonic() {
            let turn = table.rows.windows(3).find(|w| (w[1][1] - w[0][1]) * (w[2][1] - w[1][1]) <= 0.0);
            let at = turn.map_or(0.0, |w| w[1][0]);
            self.report(
                Diagnostic::new(
                    Code::TABLE_ORDER,
                    span,
                    format!("the values of `{name}` must only increase, or only decrease"),
                )
                .label(format!("changes direction at {}", units::shown(at, Dimension::ANGLE)))
                .help("each length of thread must belong to one bend: measure again, or leave rows out"),
            );
            return None;
        }
        Some((*table).clone())
    }

    /// A speed: a number, or a table from the bend.
    pub(super) fn speed(&mut self, from: &Values<'_>, name: &str, cx: &Context) -> Option<Field<ir::Speed>> {
        let velocity = Dimension::ANGULAR_VELOCITY;
        let by_bend = from.values.get(name).is_some_and(|(_, tree)| match &tree.kind {
            ast::ExprKind::Name(word) => {
                matches!(self.environment.program.lookup(tree.span, word), Some((_, i)) if matches!(i.kind, ItemKind::Table(_)))
            }
            _ => false,
        });
        if !by_bend {
            return self.varying_speed(from, name, velocity, "180 deg/s", cx);
        }
        let (value, span) =
            self.value(from, name, &Ty::Table(Dimension::ANGLE, velocity), "180 deg/s", cx)?;
        let Value::Table(table) = value else { return None };
        if table.range().0 <= 0.0 {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, span, format!("`{name}` must be above 0 at every bend"))
                    .label(format!("its smallest value is {}", units::shown(table.range().0, velocity)))
                    .help("leave out the rows in which the actuator no longer moves, and narrow `bend` to the bends that it reaches"),
            );
            return None;
        }
        Some(Field::Fixed(ir::Speed::ByBend((*table).clone())))
    }

    /// A speed that is the same at every bend.
    pub(super) fn varying_speed(
        &mut self,
        from: &Values<'_>,
        name: &str,
        dimension: Dimension,
        example: &str,
        cx: &Context,
    ) -> Option<Field<ir::Speed>> {
        Some(match self.varying_number(from, name, dimension, (Sign::Positive, example), cx)? {
            Field::Fixed(speed) => Field::Fixed(ir::Speed::Constant(speed)),
            Field::Varies(speed) => Field::Varies(speed),
        })
    }

    /// The pins of all channels.
    fn pins(&mut self, from: &Values<'_>, name: &str, cx: &Context) -> Option<Vec<(String, Span)>> {
        let second = matches!(name, "vent" | "opposite");
        let example = if second { "[D4, D6, D8, D10]" } else { "[D3, D5, D7, D9]" };
        let Some((_, tree)) = from.values.get(name) else {
            self.missing(from, name, example, cx.damaged);
            return None;
        };
        let ast::ExprKind::List(items) = &tree.kind else {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, tree.span, format!("`{name}` must be a list of pins"))
                    .label("not a list")
                    .help(format!("write a pin for each channel, in their order: `{example}`")),
            );
            return None;
        };
        // Numbers alone are pins without their letters: one mistake, however many there are.
        let text = |item: &ast::Expr| self.environment.sources.slice(item.span).to_owned();
        let pin = |item: &ast::Expr| {
            let number = text(item);
            let pin = analogue(&number).unwrap_or_else(|| format!("D{number}"));
            PINS.contains(&pin.as_str()).then_some(pin)
        };
        let meant: Option<Vec<String>> = items.iter().map(pin).collect();
        if let Some(meant) = meant.filter(|meant| meant.len() > 1) {
            self.report(
                Diagnostic::new(
                    Code::UNKNOWN_NAME,
                    tree.span,
                    "a pin must be given by its name, such as `D3`",
                )
                .label("numbers")
                .help(format!("write `[{}]`", meant.join(", "))),
            );
            return None;
        }
        let mut pins = Vec::new();
        let mut sound = true;
        for item in items {
            match &item.kind {
                ast::ExprKind::Name(pin) if PINS.contains(&pin.as_str()) => {
                    pins.push((pin.clone(), item.span))
                }
                kind => {
                    sound = false;
                    let text = self.environment.sources.slice(item.span).to_owned();
                    let help = match (kind, text.as_str()) {
                        (_, "D0" | "D1") => "the serial line needs D0 and D1".to_owned(),
                        (_, "D2") => "the stop circuit is connected to D2".to_owned(),
                        (_, "D13") => "the lamp of the board is on D13".to_owned(),
                        (_, number) if analogue(number).is_some() => {
                            format!("write `{}`", analogue(number).unwrap_or_default())
                        }
                        _ if PINS.contains(&format!("D{text}").as_str()) => format!("write `D{text}`"),
                        _ => did_you_mean(&text, PINS.iter().copied())
                            .unwrap_or_else(|| "pins are D3 to D12 and A0 to A5".to_owned()),
                    };
                    self.report(
                        Diagnostic::new(Code::UNKNOWN_NAME, item.span, format!("there is no pin `{text}`"))
                            .label("not an output of the board")
                            .help(help),
                    );
                }
            }
        }
        if items.is_empty() {
            self.report(
                Diagnostic::new(Code::MISSING_FIELD, tree.span, format!("`{name}` names no pin"))
                    .label("no channel")
                    .help(format!("write a pin for each channel, in their order: `{example}`")),
            );
            sound = false;
        }
        sound.then_some(pins)
    }

    /// The pins of two outputs for each channel, without their places.
    fn pairs(
        &mut self,
        (first, one): (&str, Option<Vec<(String, Span)>>),
        (second, two): (&str, Option<Vec<(String, Span)>>),
        place: Span,
    ) -> Option<(Vec<String>, Vec<String>)> {
        let (one, two) = (one?, two?);
        if !two.is_empty() && one.len() != two.len() {
            let ends = |pins: &[(String, Span)]| Some(pins.first()?.1.join(pins.last()?.1));
            let (fewer, more) = if one.len() < two.len() { (&one, &two) } else { (&two, &one) };
            self.report(
                Diagnostic::new(
                    Code::BAD_VALUE,
                    ends(fewer).unwrap_or(place),
                    format!("`{first}` has {} pins, `{second}` has {}", one.len(), two.len()),
                )
                .label(format!("{} here: each channel needs one of each", fewer.len()))
                .also(ends(more).unwrap_or(place), format!("{} here", more.len()))
                .help("name the same number of pins for both"),
            );
            return None;
        }
        let mut used: IndexMap<&str, Span> = IndexMap::new();
        let mut sound = true;
        for (pin, span) in one.iter().chain(&two) {
            if let Some(first) = used.insert(pin, *span) {
                sound = false;
                self.report(
                    Diagnostic::new(Code::DUPLICATE, *span, format!("the pin `{pin}` is used twice"))
                        .label("again")
                        .also(first, "used here already")
                        .help("give each output a pin of its own"),
                );
            }
        }
        let names = |pins: Vec<(String, Span)>| pins.into_iter().map(|(pin, _)| pin).collect();
        sound.then(|| (names(one), names(two)))
    }

    /// One of two words.
    pub(super) fn either(
        &mut self,
        from: &Values<'_>,
        name: &str,
        words: [&str; 2],
        cx: &Context,
    ) -> Option<bool> {
        let Some((_, tree)) = from.values.get(name) else {
            self.missing(from, name, words[0], cx.damaged);
            return None;
        };
        let word = match &tree.kind {
            ast::ExprKind::Name(word) => word.as_str(),
            _ => "",
        };
        if let Some(place) = words.iter().position(|w| *w == word) {
            return Some(place == 0);
        }
        self.report(
            Diagnostic::new(
                Code::BAD_VALUE,
                tree.span,
                format!("`{name}` must be `{}` or `{}`", words[0], words[1]),
            )
            .label("neither of them")
            .help(format!("write `{name} = {}` or `{name} = {}`", words[0], words[1]))
            .fix_if(respell(tree.span, word, words)),
        );
        None
    }

    /// A range of a quantity with two different ends.
    fn ends(
        &mut self,
        from: &Values<'_>,
        name: &str,
        dimension: Dimension,
        example: &str,
        cx: &Context,
    ) -> Option<(f64, f64)> {
        let Some((_, tree)) = from.values.get(name) else {
            self.missing(from, name, example, cx.damaged);
            return None;
        };
        let ty = Ty::Domain(Box::new(Ty::Quantity(dimension)));
        let expr = self.expressions.expect(tree, &mut cx.clone(), &ty, &format!("`{name}`"));
        let (low, high) = self.expressions.constant_range(&expr)?;
        if low >= high {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    format!("`{name}` must be a range, not a single value"),
                )
                .label("its ends are equal")
                .help(format!("write for example `{name} = {example}`")),
            );
            return None;
        }
        let farthest = if high >= -low { high } else { low };
        self.usual(from.what, name, farthest, tree);
        Some((low, high))
    }

    pub(super) fn target(
        &mut self,
        block: &Block,
        backend: &Name,
        kind: &Name,
        damaged: bool,
    ) -> Option<ir::Target> {
        let cx = Context::new(Stage::Declaration, damaged);
        let known =
            self.named(kind, "actuator", |k| matches!(k, ItemKind::Block(BlockKind::Actuator, _))).is_some();
        let (fields, read): (_, Reader<Self>) = match backend.text.as_str() {
            "pneumatic" => (PNEUMATIC, Self::pneumatic),
            "tendon" => (TENDON, Self::tendon),
            other => {
                let names = Backend::NAMES.iter().copied();
                self.report(
                    Diagnostic::new(
                        Code::UNKNOWN_NAME,
                        backend.span,
                        format!("there is no back end `{other}`"),
                    )
                    .label("not known")
                    .help(
                        did_you_mean(other, names.clone())
                            .unwrap_or_else(|| format!("write one of: {}", Backend::NAMES.join(", "))),
                    )
                    .fix_if(respell(backend.span, other, names)),
                );
                return None;
            }
        };
        let from = self.values(block, "a target", fields);
        let speed = from.values.get("speed").map(|(_, tree)| {
            let mut cx = Context::new(Stage::Score, damaged);
            let velocity = Ty::Quantity(Dimension::VELOCITY);
            self.expressions.expect(tree, &mut cx, &velocity, "`speed`")
        });
        let sensors = self.measured_by(&from);
        let backend = read(self, &from, &cx)?;
        let kind = known.then(|| kind.text.clone())?;
        Some(ir::Target { backend, kind, speed, sensors: sensors?, span: block.name.span })
    }

    fn pneumatic(&mut self, from: &Values<'_>, cx: &Context) -> Option<Backend> {
        let (inflate, vent) = (self.pins(from, "inflate", cx), self.pins(from, "vent", cx));
        let pins = self.pairs(("inflate", inflate), ("vent", vent), from.place());
        let shortest = self.number(from, "shortest", Dimension::TIME, Sign::Positive, "40 ms", cx);
        let vents = self.either(from, "safe", SAFE_AIR, cx);
        let supply = match from.groups.get("supply") {
            Some(group) => Some(self.supply(group, cx)?),
            None => None,
        };
        let (inflate, vent) = pins?;
        Some(Backend::Pneumatic(ir::Pneumatic { inflate, vent, shortest: shortest?, vents: vents?, supply }))
    }

    fn supply(&mut self, group: &Block, cx: &Context) -> Option<ir::Supply> {
        let from = self.values(group, "a supply", SUPPLY);
        let mut get = |name: &str, dimension: Dimension, example: &str| {
            self.number(&from, name, dimension, Sign::Positive, example, cx)
        };
        let pressure = get("pressure", Dimension::PRESSURE, "1.5 bar");
        let full = get("full", Dimension::PRESSURE, "1 bar");
        let line = get("line", Dimension::FLOW_CONDUCTANCE, "60 cm^3/s/bar");
        let valve = get("valve", Dimension::FLOW_CONDUCTANCE, "20 cm^3/s/bar");
        let (pressure, full) = (pressure?, full?);
        if full >= pressure
            && let Some((_, tree)) = from.values.get("full")
        {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    "the pressure that bends an actuator fully must be below that of the reservoir",
                )
                .label("never reached")
                .help("raise `pressure`, or measure the pressure in a fully bent actuator again"),
            );
            return None;
        }
        Some(ir::Supply { pressure, full, line: line?, valve: valve? })
    }

    fn tendon(&mut self, from: &Values<'_>, cx: &Context) -> Option<Backend> {
        let servo = self.pins(from, "servo", cx);
        let opposite = if from.values.contains_key("opposite") {
            self.pins(from, "opposite", cx)
        } else {
            Some(Vec::new())
        };
        let pins = self.pairs(("servo", servo), ("opposite", opposite), from.place());
        let thread = Ty::Table(Dimension::ANGLE, Dimension::LENGTH);
        let thread = self.monotonic(from, "thread", &thread, cx);
        let wheel = self.number(from, "wheel", Dimension::LENGTH, Sign::Positive, "12 mm", cx);
        let turn = self.ends(from, "turn", Dimension::ANGLE, "-90 deg .. 90 deg", cx);
        let speed =
            self.number(from, "servo_speed", Dimension::ANGULAR_VELOCITY, Sign::Positive, "300 deg/s", cx);
        let pulse = self.ends(from, "pulse", Dimension::TIME, "1000 us .. 2000 us", cx);
        let rests = self.either(from, "safe", SAFE_THREADS, cx);
        if let (Some((low, high)), Some((_, tree))) = (pulse, from.values.get("pulse"))
            && (low < 300e-6 || high > 3000e-6)
        {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    "the pulses of a servo must last 300 us to 3000 us",
                )
                .label("outside this range")
                .help("write for example `pulse = 1000 us .. 2000 us`"),
            );
            return None;
        }
        if let (Some((low, high)), Some((_, tree))) = (pulse, from.values.get("pulse"))
            && high - low < SHORTEST_WAY
        {
            self.report(
                Diagnostic::new(Code::UNUSUAL, tree.span, "between the ends of `pulse` a servo hardly turns")
                    .label("less than 200 us apart")
                    .help("write for example `pulse = 1000 us .. 2000 us`"),
            );
        }
        let (servo, opposite) = pins?;
        let (wheel, thread, speed) = (wheel?, thread?, speed?);
        let (turn, pulse, rests) = (turn?, pulse?, rests?);
        Some(Backend::Tendon(ir::Tendon { servo, opposite, thread, wheel, turn, speed, pulse, rests }))
    }

    pub(super) fn prototype(
        &mut self,
        block: &Block,
        backend: &Name,
        damaged: bool,
    ) -> Option<ir::Prototype> {
        let cx = Context::new(Stage::Declaration, damaged);
        if !Backend::NAMES.contains(&backend.text.as_str()) {
            self.report(
                Diagnostic::new(
                    Code::UNKNOWN_NAME,
                    backend.span,
                    format!("there is no back end `{}`", backend.text),
                )
                .label("not known")
                .help(format!("write one of: {}", Backend::NAMES.join(", ")))
                .fix_if(respell(backend.span, &backend.text, Backend::NAMES.iter().copied())),
            );
            return None;
        }
        let from = self.values(block, "a prototype", PROTOTYPE);
        let simulated = self.number(&from, "simulated", Dimension::VELOCITY, Sign::Positive, "35.6 m/h", &cx);
        let measured = self.number(&from, "measured", Dimension::VELOCITY, Sign::Positive, "5 m/h", &cx);
        let length = if from.values.contains_key("length") {
            Some(self.number(&from, "length", Dimension::LENGTH, Sign::Positive, "132 mm", &cx)?)
        } else {
            None
        };
        let (simulated, measured) = (simulated?, measured?);
        Some(ir::Prototype {
            backend: backend.text.clone(),
            simulated,
            measured,
            length,
            span: block.name.span,
        })
    }

    /// The targets and prototypes that take part in a grammar.
    pub(in crate::types) fn hardware(
        &mut self,
    ) -> Option<(IndexMap<String, ir::Target>, IndexMap<String, ir::Prototype>)> {
        let (mut targets, mut prototypes) = (IndexMap::new(), IndexMap::new());
        let mut sound = true;
        for (declaration, item) in self.environment.known() {
            let Some(name) = declared(item) else { continue };
            match &item.kind {
                ItemKind::Target { block, backend, kind } => {
                    self.expressions.touched.insert(declaration);
                    match self.target(block, backend, kind, item.damaged) {
                        Some(target) => drop(targets.insert(name.text.clone(), target)),
                        None => sound = false,
                    }
                }
                ItemKind::Prototype(block, backend) => {
                    self.expressions.touched.insert(declaration);
                    match self.prototype(block, backend, item.damaged) {
                        Some(prototype) => drop(prototypes.insert(name.text.clone(), prototype)),
                        None => sound = false,
                    }
                }
                _ => {}
            }
        }
        sound.then_some((targets, prototypes))
    }

    /// Threads bend, and air bends, twists or lengthens: a target is for no other actuators, whether a task is simulated on it or not.
    fn check_moves(&mut self, target: &ir::Target, actuators: &IndexMap<String, ir::Actuator>) {
        let Some(actuator) = actuators.get(&target.kind) else { return };
        let joint = actuator.joint.kind;
        if actuator.joint.rests_elsewhere() {
            self.report(
                Diagnostic::new(
                    Code::TARGET_MISFIT,
                    target.span,
                    format!("a board begins with its actuators straight, but `{}` rests bent", target.kind),
                )
                .label("no board can begin there")
                .also(actuator.span, "this actuator")
                .help("take `neutral` out of the actuator, or the target out of the grammar"),
            );
            return;
        }
        let (message, label) = match (&target.backend, joint) {
            (Backend::Tendon(_), ir::JointKind::Bend) => return,
            (Backend::Pneumatic(_), ir::JointKind::Spin) => {
                ("valves cannot turn a motor", "air cannot do this")
            }
            (Backend::Pneumatic(_), _) => return,
            (Backend::Tendon(_), _) => {
                ("a target with threads can only bend an actuator", "threads cannot do this")
            }
        };
        let kind = &target.kind;
        self.report(
            Diagnostic::new(
                Code::TARGET_MISFIT,
                target.span,
                format!("{message}, but `{kind}` {}", joint.does()),
            )
            .label(label)
            .also(actuator.span, "this actuator")
            .help("declare the target for another kind of actuator, or take it out"),
        );
    }

    /// No two targets of a task drive the same kind of actuators.
    fn check_shares(&mut self, task: &ir::Task, targets: &IndexMap<String, ir::Target>) {
        let mut seen: IndexMap<&str, (&str, Span)> = IndexMap::new();
        for name in &task.on {
            let Some(target) = targets.get(name) else { continue };
            if let Some((before, place)) = seen.insert(&target.kind, (name, target.span)) {
                let also = if before == name {
                    format!("the task names `{name}` twice")
                } else {
                    format!("`{before}` and `{name}` both drive `{}`", target.kind)
                };
                self.report(
                    Diagnostic::new(Code::TARGET_MISFIT, target.span, also)
                        .label(format!("for `{}`", target.kind))
                        .also(place, "the first of them")
                        .help("name only one target for each kind of actuator after `on`"),
                );
            }
        }
    }

    /// Whether what drives an actuator is what its target can do.
    pub(in crate::types) fn check_targets(
        &mut self,
        tasks: &Tasks,
        targets: &IndexMap<String, ir::Target>,
        used: &Named,
    ) {
        let Named { actuators, actuations, .. } = used;
        for target in targets.values() {
            self.check_moves(target, actuators);
        }
        for (task, actuated) in tasks.values() {
            self.check_shares(task, targets);
            for (kind, (with, place)) in actuated {
                let (Some(actuator), Some(actuation)) = (actuators.get(kind), actuations.get(with)) else {
                    continue;
                };
                // What it drives could not be read.
                if actuation.drive.ty == Ty::Unknown {
                    continue;
                }
                let valves = actuation.drive.ty == Ty::Valves;
                if valves && actuator.joint.rests_elsewhere() {
                    self.report(
                        Diagnostic::new(
                            Code::TARGET_MISFIT,
                            *place,
                            format!("`{with}` drives valves, but `{kind}` rests bent"),
                        )
                        .label("without air an actuator is at 0")
                        .also(actuator.span, "declared here")
                        .help("take `neutral` out of the actuator, or drive its angle"),
                    );
                }
                let joint = actuator.joint.kind;
                // Where its range reads parameters, its least value must still be 0 for all of a kind.
                let (least, most) = match &actuator.joint.range {
                    None => (f64::NEG_INFINITY, f64::INFINITY),
                    Some(Field::Fixed(ends)) => *ends,
                    Some(Field::Varies(ends)) => written_ends(ends),
                };
                if valves && least < 0.0 {
                    let (does, help) = if joint == ir::JointKind::Spin {
                        ("spins", "drive its speed: `drive speed = ...`".to_owned())
                    } else {
                        let example =
                            if joint == ir::JointKind::Slide { "0 mm .. 20 mm" } else { "0 deg .. 90 deg" };
                        (
                            joint.does(),
                            format!("write for example `set {kind}.{} = {example}`", joint.range()),
                        )
                    };
                    let both = match joint {
                        ir::JointKind::Spin => "",
                        _ if most <= 0.0 => " below 0",
                        _ => " both ways",
                    };
                    self.report(
                        Diagnostic::new(
                            Code::TARGET_MISFIT,
                            *place,
                            format!("`{with}` drives valves, but `{kind}` {does}{both}"),
                        )
                        .label("air can move an actuator in one direction only")
                        .also(actuator.span, "declared here")
                        .help(help),
                    );
                }
                let mut on = task.on.iter().filter_map(|name| Some((name, targets.get(name)?)));
                let Some((name, target)) = on.find(|(_, target)| target.kind == *kind) else { continue };
                self.check_measured((name, target), (with, actuation), used, *place);
                let air = matches!(target.backend, Backend::Pneumatic(_));
                if air != valves {
                    let (drives, wants, example) = if air {
                        (
                            match joint {
                                ir::JointKind::Slide => "a distance",
                                ir::JointKind::Spin => "a speed",
                                _ => "an angle",
                            },
                            "valves",
                            "drive valves = cycle(period, share, [closed, inflate, closed, vent], 0)",
                        )
                    } else {
                        ("valves", "an angle", "drive angle = ...")
                    };
                    self.report(
                        Diagnostic::new(
                            Code::TARGET_MISFIT,
                            *place,
                            format!("`{with}` drives {drives}, but the target drives {wants}"),
                        )
                        .label("does not fit the target")
                        .also(target.span, "the task is simulated on this target")
                        .help(format!("actuate `{kind}` with an actuation that says `{example}`")),
                    );
                }
            }
        }
    }
}

/// The name of an analogue pin that is called by its number, as on the boards of Arduino: 14 is A0.
fn analogue(number: &str) -> Option<String> {
    let number: u8 = number.parse().ok()?;
    (14..=19).contains(&number).then(|| format!("A{}", number - 14))
}

/// The ends of a range as they are written; what reads parameters has none.
fn written_ends(range: &Expr) -> (f64, f64) {
    let end = |end: &Expr, else_: f64| if let ExprKind::Number(x) = end.kind { x } else { else_ };
    match &range.kind {
        ExprKind::Range(low, high) => (end(low, f64::NEG_INFINITY), end(high, f64::INFINITY)),
        _ => (f64::NEG_INFINITY, f64::INFINITY),
    }
}
