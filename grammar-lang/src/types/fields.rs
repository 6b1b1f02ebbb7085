//! Checks the blocks of named values: parts, actuators, models. Searches have a file of their own.

use indexmap::IndexMap;

use super::Checker;
use super::expr::Context;
use super::stage::Stage;
use crate::diagnostics::{Code, Diagnostic, did_you_mean, nearest, respell};
use crate::eval::Value;
use crate::ir::{self, Form, Solid, Ty};
use crate::syntax::ast::{self, Block, Field, Name};
use crate::units::Dimension;

/// Names that are blocks where they are allowed, not values.
const GROUPS: &[&str] = &["bodies", "curves", "descriptors", "supply", "filling"];

/// Blocks that name a method.
const WITH_METHOD: &[&str] = &["bodies", "curves"];

/// What a number must be.
#[derive(Clone, Copy)]
pub(super) enum Sign {
    Positive,
    NotNegative,
}

/// The names that a block may have.
const PART: &[&str] = &["shape", "density", "mass", "friction", "colour"];
const ACTUATOR: &[&str] = &[
    "segment",
    "density",
    "mass",
    "friction",
    "bend",
    "bending_speed",
    "relaxing_speed",
    "torque",
    "stiffness",
    "damping",
    "colour",
];
const MODEL: &[&str] = &[
    "method",
    "filling",
    "step",
    "control",
    "record",
    "gravity",
    "ground_friction",
    "iterations",
    "tolerance",
    "self_collision",
    "speed_limit",
    "pace_limit",
];

/// A block with its values by name.
pub(super) struct Values<'b> {
    block: &'b Block,
    what: &'static str,
    pub(super) values: IndexMap<&'b str, (&'b Name, &'b ast::Expr)>,
    pub(super) groups: IndexMap<&'b str, &'b Block>,
    /// Names that are there, but misspelt, which has been reported.
    pub(super) misspelt: Vec<String>,
}

impl Values<'_> {
    /// Where the block is named.
    pub(super) fn place(&self) -> crate::source::Span {
        self.block.name.span
    }
}

/// The longest step of hinges, s.
const LONGEST_STEP: f64 = 1.0 / 60.0;
/// A motion of fewer steps has no value that could be believed.
const FEWEST_STEPS: f64 = 100.0;

impl Checker<'_> {
    pub(super) fn values<'b>(
        &mut self,
        block: &'b Block,
        what: &'static str,
        allowed: &[&str],
    ) -> Values<'b> {
        self.values_among(block, block.fields.iter(), what, allowed)
    }

    /// The values of some fields of a block.
    pub(super) fn values_among<'b>(
        &mut self,
        block: &'b Block,
        fields: impl Iterator<Item = &'b Field>,
        what: &'static str,
        allowed: &[&str],
    ) -> Values<'b> {
        let mut values: IndexMap<&str, (&Name, &ast::Expr)> = IndexMap::new();
        let mut groups: IndexMap<&str, &Block> = IndexMap::new();
        let mut misspelt = Vec::new();
        let given = |name: &str| {
            block.fields.iter().any(|f| match f {
                Field::Value(n, _) => n.text == name,
                Field::Group(group) => group.name.text == name,
                Field::Param(_) | Field::Port(_) => false,
            })
        };
        for field in fields {
            let name = match field {
                Field::Value(name, _) => name,
                Field::Group(group) => &group.name,
                Field::Param(_) | Field::Port(_) => {
                    self.check_declares(field, what);
                    continue;
                }
            };
            let text = name.text.as_str();
            let is_group = GROUPS.contains(&text);
            if !allowed.contains(&text) || matches!(field, Field::Group(_)) != is_group {
                let open: Vec<&str> = allowed.iter().copied().filter(|a| !given(a)).collect();
                self.not_a_field(name, what, allowed, &open);
                misspelt.extend(nearest(text, open).map(str::to_owned));
                // What is there in the wrong form is not missing, too.
                misspelt.push(name.text.clone());
                continue;
            }
            let first = values.get(text).map(|(n, _)| n.span);
            if let Some(first) = first.or_else(|| groups.get(text).map(|g| g.name.span)) {
                self.report(
                    Diagnostic::new(Code::DUPLICATE, name.span, format!("`{text}` is given twice"))
                        .label("again")
                        .also(first, "first given here")
                        .help("keep one of them"),
                );
            }
            match field {
                Field::Value(_, value) => drop(values.insert(text, (name, value))),
                Field::Group(group) => {
                    if let Some(method) = group.method.as_ref().filter(|_| !WITH_METHOD.contains(&text)) {
                        self.no_method(name, method);
                    }
                    groups.insert(text, group);
                }
                Field::Param(_) | Field::Port(_) => {}
            }
        }
        Values { block, what, values, groups, misspelt }
    }

    /// Parameters and ports are declared where something has them.
    fn check_declares(&mut self, field: &Field, what: &str) {
        let (name, message, help) = match field {
            Field::Param(param) if !matches!(what, "an actuator" | "a cell") => {
                (&param.name, "parameters", "declare it outside, for the whole grammar")
            }
            Field::Port(port) if what != "a part" => (
                &port.name,
                "ports of its own",
                "only a passive part declares ports; an actuator has `base` and `tip`",
            ),
            _ => return,
        };
        let error = Diagnostic::new(Code::UNKNOWN_FIELD, name.span, format!("{what} has no {message}"));
        self.report(error.label("not possible here").help(help));
    }

    /// A name that is no field, or not in this form; `open` are the fields that are not given yet.
    fn not_a_field(&mut self, name: &Name, what: &str, allowed: &[&str], open: &[&str]) {
        let text = name.text.as_str();
        let (message, label, help) = match (allowed.contains(&text), GROUPS.contains(&text)) {
            (true, true) => (
                format!("`{text}` is a block, not a value"),
                "not in this form",
                format!("write `{text} {{ ... }}`"),
            ),
            (true, false) => (
                format!("`{text}` is a value, not a block"),
                "not in this form",
                format!("write `{text} = ...`"),
            ),
            (false, _) => (
                format!("{what} has no `{text}`"),
                "not known",
                did_you_mean(text, allowed.iter().copied())
                    .unwrap_or_else(|| format!("{what} has: {}", allowed.join(", "))),
            ),
        };
        self.report(
            Diagnostic::new(Code::UNKNOWN_FIELD, name.span, message).label(label).help(help).fix_if(respell(
                name.span,
                text,
                open.iter().copied(),
            )),
        );
    }

    /// A word behind the name of a block that has none there.
    pub(super) fn no_method(&mut self, name: &Name, word: &Name) {
        self.report(
            Diagnostic::new(
                Code::UNKNOWN_FIELD,
                word.span,
                format!("no word stands between `{}` and its bracket", name.text),
            )
            .label("not read")
            .help(format!("write `{} {{ ... }}`", name.text)),
        );
    }

    pub(super) fn missing(&mut self, from: &Values<'_>, name: &str, example: &str, damaged: bool) {
        if damaged || from.misspelt.iter().any(|m| m == name) {
            return;
        }
        let lacks = format!("`{}` has no ", from.block.name.text);
        // All that one block lacks is one finding.
        let place = from.block.name.span;
        let more = self.errors.amend(place, Code::MISSING_FIELD, &lacks, |known| {
            // A declaration may be looked at twice.
            if known.message.contains(&format!("`{name}`")) {
                return;
            }
            known.message = format!("{}, `{name}`", known.message.replace(" or `", ", `"));
            if let Some(last) = known.message.rfind(", ") {
                known.message.replace_range(last..last + 2, " or ");
            }
            if let Some(label) = known.labels.first_mut() {
                label.text = format!("{} needs them", from.what);
            }
            let help = known.help.take().unwrap_or_default().replace("a line such", "lines such");
            known.help = Some(format!("{help}, `{name} = {example}`"));
        });
        if more {
            return;
        }
        self.report(
            Diagnostic::new(Code::MISSING_FIELD, place, format!("{lacks}`{name}`"))
                .label(format!("{} needs it", from.what))
                .help(format!("add a line such as `{name} = {example}`")),
        );
    }

    pub(super) fn value(
        &mut self,
        from: &Values<'_>,
        name: &str,
        ty: &Ty,
        example: &str,
        cx: &Context,
    ) -> Option<(Value, crate::source::Span)> {
        let Some((_, tree)) = from.values.get(name) else {
            self.missing(from, name, example, cx.damaged);
            return None;
        };
        let mut cx = cx.clone();
        let known = self.errors.len();
        let expr = self.expect(tree, &mut cx, ty, &format!("`{name}`"));
        self.show_example(known, tree.span, name, example);
        Some((self.constant(&expr)?, tree.span))
    }

    /// What does not fit a field is mended as the field is usually written.
    pub(super) fn show_example(
        &mut self,
        known: usize,
        place: crate::source::Span,
        name: &str,
        example: &str,
    ) {
        for mut error in self.errors.split_off(known) {
            let unit =
                example.split_once(' ').map(|(_, unit)| unit).filter(|u| crate::units::parse(u).is_ok());
            if error.span() == place && error.code == Code::MISSING_UNIT {
                if let Some(unit) = unit {
                    error.help = Some(format!("write `{} {unit}`", self.sources.slice(place)));
                }
            } else if error.span() == place && error.code == Code::WRONG_TYPE && error.fix.is_none() {
                error.help = Some(format!("write for example `{name} = {example}`"));
            }
            self.errors.add(error);
        }
    }

    pub(super) fn number(
        &mut self,
        from: &Values<'_>,
        name: &str,
        ty: impl Into<Ty>,
        sign: Sign,
        example: &str,
        cx: &Context,
    ) -> Option<f64> {
        let ty = ty.into();
        let (value, span) = self.value(from, name, &ty, example, cx)?;
        let x = value.as_number()?;
        let fine = match sign {
            Sign::Positive => x > 0.0,
            Sign::NotNegative => x >= 0.0,
        };
        if !fine {
            let must = if matches!(sign, Sign::Positive) { "must be above 0" } else { "must not be below 0" };
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, span, format!("`{name}` {must}"))
                    .label(format!("this is {}", super::shown(x, &ty)))
                    .help(format!("write for example `{name} = {example}`")),
            );
            return None;
        }
        Some(x)
    }

    /// The mass of one piece: given, or from its density.
    fn mass(&mut self, from: &Values<'_>, shape: Option<Form>, cx: &Context) -> Option<f64> {
        if let (Some((mass, _)), Some((name, _))) = (from.values.get("mass"), from.values.get("density")) {
            self.report(
                Diagnostic::new(Code::DUPLICATE, name.span, "mass and density are both given")
                    .label("which one counts?")
                    .also(mass.span, "the mass")
                    .help("keep the one that was measured"),
            );
        }
        if !from.values.contains_key("mass") && !from.values.contains_key("density") {
            self.missing(from, "density", "1 g/cm^3` or `mass = 8 g", cx.damaged);
            return None;
        }
        if from.values.contains_key("mass") {
            return self.number(from, "mass", Dimension::MASS, Sign::Positive, "8 g", cx);
        }
        Some(
            self.number(from, "density", Dimension::DENSITY, Sign::Positive, "1 g/cm^3", cx)?
                * shape?.shape.volume(),
        )
    }

    fn shape(&mut self, from: &Values<'_>, name: &str, example: &str, cx: &Context) -> Option<Form> {
        let (value, span) = self.value(from, name, &Ty::Shape, example, cx)?;
        let Value::Shape(shape) = value else { return None };
        let (solid, sizes) = shape.written();
        let segment = name == "segment";
        if let Some(bad) = sizes.iter().find(|s| **s <= 0.0) {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, span, "every size of a shape must be above 0")
                    .label(format!("one is {}", super::shown(*bad, &Ty::Quantity(Dimension::LENGTH))))
                    .help(format!("write for example `{name} = {example}`")),
            );
            return None;
        }
        if segment != (solid == Solid::Cylinder) {
            let (message, help) = if segment {
                ("a segment is a cylinder", "write `segment = cylinder(radius, length)`")
            } else {
                (
                    "a passive part is a box, a sphere, a disk or a capsule",
                    "write `box(x, y, z)`, `sphere(radius)`, `disk(radius, height)` or `capsule(radius, length)`",
                )
            };
            self.report(Diagnostic::new(Code::BAD_VALUE, span, message).label("another shape").help(help));
            return None;
        }
        Some(shape)
    }

    fn colour(&mut self, from: &Values<'_>, cx: &Context) -> String {
        let plain = "#9aa3ad".to_owned();
        if !from.values.contains_key("colour") {
            return plain;
        }
        let Some((Value::Text(text), span)) = self.value(from, "colour", &Ty::Text, "\"#e8963c\"", cx) else {
            return plain;
        };
        let hex =
            text.strip_prefix('#').is_some_and(|h| h.len() == 6 && h.bytes().all(|b| b.is_ascii_hexdigit()));
        if !hex {
            self.report(
                Diagnostic::new(Code::BAD_VALUE, span, "a colour is written as `#rrggbb`")
                    .label("not such a text")
                    .help("write for example `colour = \"#e8963c\"`"),
            );
            return plain;
        }
        text.to_string()
    }

    pub(super) fn part(&mut self, block: &Block, damaged: bool) -> Option<ir::Part> {
        let cx = Context::new(Stage::Declaration, damaged);
        let from = self.values(block, "a part", PART);
        let shape = self.shape(&from, "shape", "box(2 cm, 2 cm, 2 cm)", &cx);
        let mass = self.mass(&from, shape, &cx);
        let friction = self.number(&from, "friction", Dimension::NUMBER, Sign::NotNegative, "0.8", &cx);
        let colour = self.colour(&from, &cx);
        let ports = self.ports(block, &cx);
        Some(ir::Part {
            shape: shape?,
            mass: mass?,
            friction: friction?,
            colour,
            ports: ports?,
            span: block.name.span,
        })
    }

    /// The ports that a part declares.
    fn ports(&mut self, block: &Block, cx: &Context) -> Option<Vec<ir::Port>> {
        let mut ports: Vec<ir::Port> = Vec::new();
        let mut sound = true;
        for field in &block.fields {
            let Field::Port(port) = field else { continue };
            if ports.iter().any(|p| p.name == port.name.text) {
                let first = block.fields.iter().find_map(|f| match f {
                    Field::Port(p) if p.name.text == port.name.text => Some(p.name.span),
                    _ => None,
                });
                let first = first.unwrap_or(port.name.span);
                self.report(
                    Diagnostic::new(
                        Code::DUPLICATE,
                        port.name.span,
                        format!("there are two ports `{}`", port.name.text),
                    )
                    .label("again")
                    .also(first, "the first one")
                    .help(format!(
                        "choose another name; several of one name are written `port {}[i in 0 .. 7] ...`",
                        port.name.text
                    )),
                );
            }
            match self.port(port, cx) {
                Some(several) => ports.extend(several),
                None => sound = false,
            }
        }
        if ports.len() > 64 {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, block.name.span, "a part has at most 64 ports")
                    .label(format!("this one has {}", ports.len()))
                    .help("declare fewer, or narrow the ranges of their numbers"),
            );
            return None;
        }
        sound.then_some(ports)
    }

    fn port(&mut self, port: &ast::Port, cx: &Context) -> Option<Vec<ir::Port>> {
        let mut cx = cx.clone();
        let mut numbers = vec![0.0];
        if let Some((name, domain)) = &port.index {
            let ty = Ty::Domain(Box::new(Ty::Count));
            let domain = self.expect(domain, &mut cx, &ty, "the numbers of the ports");
            let Value::Domain(domain) = self.constant(&domain)? else { return None };
            numbers = domain.items().take(65).filter_map(|v| v.as_number()).collect();
            self.bind(name, Ty::Count, &mut cx);
        }
        let length = Ty::Vector(Dimension::LENGTH);
        let at = self.expect(&port.at, &mut cx, &length, "the place of a port");
        let facing = self.infer(&port.facing, &mut cx);
        if !matches!(facing.ty, Ty::Vector(_) | Ty::Unknown) {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, facing.span, "where a port looks must be a vector")
                    .label(format!("this is {}", super::fit::article(&facing.ty)))
                    .help("write for example `facing vector(0, 0, 1)`"),
            );
        }
        if [&at, &facing].iter().any(|e| e.any(&mut |e| e.ty == Ty::Unknown)) {
            return None;
        }
        let mut ports = Vec::new();
        for index in numbers {
            let mut locals = if port.index.is_some() { vec![Value::Number(index)] } else { Vec::new() };
            let Value::Vector(at) = self.constant_with(&at, &mut locals)? else { return None };
            let Value::Vector([x, y, z]) = self.constant_with(&facing, &mut locals)? else { return None };
            let length = (x * x + y * y + z * z).sqrt();
            if length <= 0.0 || !length.is_finite() {
                self.report(
                    Diagnostic::new(Code::BAD_VALUE, port.facing.span, "a port must look somewhere")
                        .label("a vector without length")
                        .help("write for example `facing vector(1, 0, 0)`"),
                );
                return None;
            }
            let facing = [x / length, y / length, z / length];
            ports.push(ir::Port { name: port.name.text.clone(), index, at, facing });
        }
        Some(ports)
    }

    pub(super) fn actuator(&mut self, block: &Block, damaged: bool) -> Option<ir::Actuator> {
        let cx = Context::new(Stage::Declaration, damaged);
        let from = self.values(block, "an actuator", ACTUATOR);
        let segment = self.shape(&from, "segment", "cylinder(8 mm, 16 mm)", &cx);
        let mass = self.mass(&from, segment, &cx);
        let friction = self.number(&from, "friction", Dimension::NUMBER, Sign::NotNegative, "0.8", &cx);
        let bend = self.bend(&from, &cx);
        let bending_speed = self.speed(&from, "bending_speed", &cx);
        let relaxing_speed = self.speed(&from, "relaxing_speed", &cx);
        let mut positive = |name: &str, dimension: Dimension, example: &str| {
            self.number(&from, name, dimension, Sign::Positive, example, &cx)
        };
        let torque = positive("torque", Dimension::TORQUE, "0.06 N*m/rad");
        let stiffness = positive("stiffness", Dimension::ANGULAR_STIFFNESS, "0.3 N*m/rad^2");
        let damping = self.number(
            &from,
            "damping",
            Dimension::ANGULAR_DAMPING,
            Sign::NotNegative,
            "0.01 N*m*s/rad^2",
            &cx,
        );
        let colour = self.colour(&from, &cx);
        let params = self.actuator_params(block, damaged);
        Some(ir::Actuator {
            segment: segment?,
            mass: mass?,
            friction: friction?,
            bend: bend?,
            bending_speed: bending_speed?,
            relaxing_speed: relaxing_speed?,
            torque: torque?,
            stiffness: stiffness?,
            damping: damping?,
            colour,
            params,
            span: block.name.span,
        })
    }

    fn bend(&mut self, from: &Values<'_>, cx: &Context) -> Option<(f64, f64)> {
        let Some((_, tree)) = from.values.get("bend") else {
            self.missing(from, "bend", "-90 deg .. 90 deg", cx.damaged);
            return None;
        };
        let ty = Ty::Domain(Box::new(Ty::Quantity(Dimension::ANGLE)));
        let expr = self.expect(tree, &mut cx.clone(), &ty, "`bend`");
        let (low, high) = self.constant_range(&expr)?;
        if low > 0.0 || high < 0.0 || low >= high {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    "the range of `bend` must hold 0 deg, and more than that",
                )
                .label("the actuator is straight at rest")
                .help("write for example `bend = 0 deg .. 90 deg`"),
            );
            return None;
        }
        Some((low, high))
    }

    fn actuator_params(&mut self, block: &Block, damaged: bool) -> IndexMap<String, ir::InstanceParam> {
        let params = self.instance_params_of(block, damaged);
        self.check_segments(block, params.get("segments"), damaged);
        params
    }

    /// The parameters that each instance of a kind has for itself.
    pub(super) fn instance_params_of(
        &mut self,
        block: &Block,
        damaged: bool,
    ) -> IndexMap<String, ir::InstanceParam> {
        let mut params = IndexMap::new();
        for field in &block.fields {
            let Field::Param(param) = field else { continue };
            let mut cx = Context::new(Stage::Declaration, damaged);
            let ty = self.type_named(&param.ty);
            let domain = param.domain.as_ref().and_then(|d| {
                let domain =
                    self.expect(d, &mut cx, &Ty::Domain(Box::new(ty.clone())), "the domain of a parameter");
                self.constant_range(&domain)
            });
            let default = param
                .default
                .as_ref()
                .map(|d| self.expect(d, &mut cx, &ty, &format!("`{}`", param.name.text)));
            if let (Some((low, high)), Some(value)) =
                (domain, default.as_ref().and_then(|d| self.quiet_number(d)))
                && (value < low || value > high)
            {
                self.report(
                    Diagnostic::new(
                        Code::OUT_OF_DOMAIN,
                        param.name.span,
                        format!("`{}` is outside its domain", param.name.text),
                    )
                    .label("by its default"),
                );
            }
            if params.contains_key(&param.name.text) {
                let first = block.fields.iter().find_map(|f| match f {
                    Field::Param(p) if p.name.text == param.name.text => Some(p.name.span),
                    _ => None,
                });
                let first = first.unwrap_or(param.name.span);
                self.report(
                    Diagnostic::new(
                        Code::DUPLICATE,
                        param.name.span,
                        format!("`{}` is declared twice", param.name.text),
                    )
                    .label("again")
                    .also(first, "first declared here")
                    .help("keep one of them"),
                );
            }
            params.insert(param.name.text.clone(), ir::InstanceParam { ty, domain, default });
        }
        params
    }

    /// Every actuator has a number of segments, as many as the simulators take.
    fn check_segments(&mut self, block: &Block, checked: Option<&ir::InstanceParam>, damaged: bool) {
        let written = block.fields.iter().find_map(|f| match f {
            Field::Param(param) if param.name.text == "segments" => Some(param),
            _ => None,
        });
        let error = match (written, checked) {
            (None, _) if damaged => return,
            (None, _) | (_, None) => Diagnostic::new(
                Code::MISSING_FIELD,
                block.name.span,
                format!("`{}` has no parameter `segments`", block.name.text),
            )
            .label("an actuator is a row of segments"),
            (_, Some(ir::InstanceParam { ty: Ty::Unknown, .. })) => return,
            (Some(param), Some(ir::InstanceParam { ty, .. })) if *ty != Ty::Count => Diagnostic::new(
                Code::WRONG_TYPE,
                param.ty.span,
                "`segments` says how many there are: it is a Count",
            )
            .label(format!("this is {}", super::fit::article(ty))),
            (Some(param), Some(ir::InstanceParam { domain, .. })) => {
                let place = param.domain.as_ref().map_or(param.name.span, |d| d.span);
                match domain {
                    Some((low, high)) if *low >= 2.0 && *high <= 64.0 => return,
                    // What is wrong with the domain has been told.
                    None if param.domain.is_some() => return,
                    _ => Diagnostic::new(
                        Code::OUT_OF_DOMAIN,
                        place,
                        "the number of `segments` must lie within 2 .. 64",
                    )
                    .label(if domain.is_some() {
                        "reaches further"
                    } else {
                        "no domain"
                    }),
                }
            }
        };
        self.report(error.help("write for example `param segments : Count in 2 .. 12 = 5`"));
    }

    /// How a model works; with hinges if it does not say.
    fn method(&mut self, from: &Values<'_>, cx: &Context) -> Option<ir::Method> {
        let hinges =
            !from.values.contains_key("method") || self.either(from, "method", ["hinges", "balls"], cx)?;
        let filling = match from.groups.get("filling") {
            Some(group) => Some(self.filling_of_parts(group, cx)?),
            None => None,
        };
        match (hinges, from.groups.get("filling")) {
            (true, Some(group)) => {
                self.report(
                    Diagnostic::new(
                        Code::UNKNOWN_FIELD,
                        group.name.span,
                        "a model of hinges fills nothing with balls",
                    )
                    .label("not possible here")
                    .help("write `method = balls`, or take the block out"),
                );
                None
            }
            (true, None) => Some(ir::Method::Hinges),
            (false, _) => Some(ir::Method::Balls(filling)),
        }
    }

    /// Refuses steps that no value can come of.
    fn check_step(
        &mut self,
        from: &Values<'_>,
        (step, control, duration): (Option<f64>, Option<f64>, Option<f64>),
        balls: bool,
    ) -> Option<()> {
        let (Some(step), Some((_, tree))) = (step, from.values.get("step")) else { return Some(()) };
        let steps = duration.map_or(f64::INFINITY, |duration| duration / step);
        let is_above = |most: f64| step > most * (1.0 + 1e-9);
        let (what, label, help) = if !balls && is_above(LONGEST_STEP) {
            let what = "a step of hinges must be at most 1/60 s: longer ones have no truth in them";
            (what, "too long".to_owned(), "write for example `step = 1 s / 240`")
        } else if control.is_some_and(is_above) {
            let what = "`step` must not be longer than `control`, the time between two samples of a curve";
            let label = format!("longer than {} s", control.unwrap_or_default());
            (what, label, "write for example `step = 1 s / 240` and `control = 1 s / 60`")
        } else if steps * (1.0 + 1e-9) < FEWEST_STEPS {
            let what = "a motion of fewer than 100 steps is too coarse to have a value";
            (what, format!("{steps:.0} steps"), "write a shorter `step`, or simulate for a longer time")
        } else {
            return Some(());
        };
        self.report(Diagnostic::new(Code::OUT_OF_DOMAIN, tree.span, what).label(label).help(help));
        None
    }

    pub(super) fn model(&mut self, block: &Block, duration: Option<f64>, damaged: bool) -> Option<ir::Model> {
        let cx = Context::new(Stage::Declaration, damaged);
        let from = self.values(block, "a model", MODEL);
        let method = self.method(&from, &cx);
        let balls = matches!(method, Some(ir::Method::Balls(_)));
        let mut get =
            |name: &str, ty: Ty, sign: Sign, example: &str| self.number(&from, name, ty, sign, example, &cx);
        let step = get("step", Dimension::TIME.into(), Sign::Positive, "1 s / 240");
        let control = get("control", Dimension::TIME.into(), Sign::Positive, "1 s / 60");
        let record = get("record", Dimension::TIME.into(), Sign::Positive, "1 s / 30");
        let gravity = get("gravity", Dimension::ACCELERATION.into(), Sign::NotNegative, "9.81 m/s^2");
        let ground_friction = get("ground_friction", Dimension::NUMBER.into(), Sign::NotNegative, "0.8");
        // Springs are not swept over.
        let swept = |name: &str| !balls || from.values.contains_key(name);
        let (sweeps, rest) = (swept("iterations"), swept("tolerance"));
        let iterations = if sweeps { get("iterations", Ty::Count, Sign::Positive, "10") } else { Some(1.0) };
        let tolerance = if rest {
            get("tolerance", Dimension::NUMBER.into(), Sign::NotNegative, "0.2 %")
        } else {
            Some(0.0)
        };
        let speed_limit = get("speed_limit", Dimension::VELOCITY.into(), Sign::Positive, "10 m/s");
        let self_collision = self.value(&from, "self_collision", &Ty::Bool, "true", &cx);
        let pace_limit = if from.values.contains_key("pace_limit") {
            Some(self.number(&from, "pace_limit", Dimension::VELOCITY, Sign::Positive, "20 cm/s", &cx)?)
        } else {
            None
        };
        if let (Some(n), Some((_, tree))) = (iterations, from.values.get("iterations"))
            && n > 1000.0
        {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    "more than 1000 sweeps in each step never pay",
                )
                .label("too many")
                .help("write for example `iterations = 10`"),
            );
        }
        for (name, value) in [("step", step), ("control", control), ("record", record)] {
            let (Some(value), Some(duration), Some((_, tree))) = (value, duration, from.values.get(name))
            else {
                continue;
            };
            if duration / value > 1e6 || value > duration {
                self.report(
                    Diagnostic::new(
                        Code::OUT_OF_DOMAIN,
                        tree.span,
                        format!(
                            "`{name}` must be shorter than the motion, and not more than a million times"
                        ),
                    )
                    .label(format!("{} s of a motion of {duration} s", value)),
                );
                return None;
            }
        }
        self.check_step(&from, (step, control, duration), balls)?;
        Some(ir::Model {
            name: block.name.text.clone(),
            method: method?,
            duration: duration?,
            step: step?,
            control: control?,
            record: record?,
            gravity: gravity?,
            ground_friction: ground_friction?,
            iterations: iterations? as usize,
            tolerance: tolerance?,
            self_collision: self_collision?.0 == Value::Bool(true),
            speed_limit: speed_limit?,
            pace_limit,
        })
    }
}
