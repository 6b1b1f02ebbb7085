//! Checks passive parts, and what actuators have as they do: shape, mass, colour.

use nalgebra::Point3;

use super::Declarations;
use super::fields::{Fields, Sign, Values};
use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Value;
use crate::ir::{self, Form, Solid, Ty};
use crate::syntax::ast::{self, Block, Field};
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

const PART: Fields<'static> = Fields::values(&["shape", "density", "mass", "friction", "colour"]);
impl Declarations<'_> {
    pub(in crate::types) fn part(&mut self, block: &Block, damaged: bool) -> Option<ir::Part> {
        let cx = Context::new(Stage::Declaration, damaged);
        let from = self.values(block, "a part", PART);
        let shape = self.shape(&from, "shape", "box(2 cm, 2 cm, 2 cm)", &cx);
        let mass = self.mass(&from, shape, &cx);
        let friction = self.number(&from, "friction", Dimension::NUMBER, Sign::NotNegative, "0.8", &cx);
        let colour = self.colour(&from, &cx);
        let ports = self.ports(block, &cx);
        if let (Some(form), Some(ports)) = (shape, &ports) {
            self.check_places(block, form, ports);
        }
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

    /// Warns of ports that lie off the part, and of two in one place.
    fn check_places(&mut self, block: &Block, form: Form, ports: &[ir::Port]) {
        let place = |name: &str| {
            block.fields.iter().find_map(|field| match field {
                Field::Port(port) if port.name.text == name => Some(port.at.span),
                _ => None,
            })
        };
        let shape = form.shape;
        let slack = 0.05 * shape.longest() + 1e-3;
        let mut told: Vec<&str> = Vec::new();
        for (i, port) in ports.iter().enumerate() {
            let Some(span) = place(&port.name) else { continue };
            let at = Point3::from(port.at);
            // What stands has its own x axis upright.
            let own = if form.stands { Point3::new(at.y, at.x, at.z) } else { at };
            if !shape.holds(&own, slack) && !told.contains(&port.name.as_str()) {
                told.push(&port.name);
                self.stray_port(&port.name, span, at.coords.norm(), shape.reach());
            }
            let outwards: f64 = (0..3).map(|k| port.facing[k] * at.coords[k]).sum();
            if outwards < -0.1 * at.coords.norm() && !told.contains(&port.name.as_str()) {
                told.push(&port.name);
                self.report(
                    Diagnostic::new(
                        Code::STRAY_PORT,
                        span,
                        format!("the port `{}` looks into its part", port.name),
                    )
                    .label("`facing` points from here towards the middle")
                    .help("let it look outwards: turn the sign of `facing` round"),
                );
            }
            let same = |other: &&ir::Port| {
                let apart = (Point3::from(other.at) - at).norm();
                let aligned: f64 = (0..3).map(|k| other.facing[k] * port.facing[k]).sum();
                apart < 1e-6 && aligned > 0.5
            };
            let Some(first) = ports[..i].iter().find(same) else { continue };
            let names = if first.name == port.name {
                format!("`{0}[{1}]` and `{0}[{2}]`", port.name, first.index, port.index)
            } else {
                format!("`{}` and `{}`", first.name, port.name)
            };
            self.report(
                Diagnostic::new(Code::PORTS_TOGETHER, span, format!("the ports {names} lie in one place"))
                    .label("the same place, and the same direction")
                    .help("what is attached to both would overlap: move one of them, or take it out"),
            );
            return;
        }
    }

    fn port(&mut self, port: &ast::Port, cx: &Context) -> Option<Vec<ir::Port>> {
        let mut cx = cx.clone();
        let mut numbers = vec![0.0];
        if let Some((name, domain)) = &port.index {
            let ty = Ty::Domain(Box::new(Ty::Count));
            let domain = self.expressions.expect(domain, &mut cx, &ty, "the numbers of the ports");
            let Value::Domain(domain) = self.expressions.constant(&domain)? else { return None };
            numbers = domain.items().take(65).filter_map(|v| v.as_number()).collect();
            self.expressions.bind(name, Ty::Count, &mut cx);
        }
        let length = Ty::Vector(Dimension::LENGTH);
        let at = self.expressions.expect(&port.at, &mut cx, &length, "the place of a port");
        let facing = self.expressions.infer(&port.facing, &mut cx);
        if !matches!(facing.ty, Ty::Vector(_) | Ty::Unknown) {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, facing.span, "where a port looks must be a vector")
                    .label(format!("this is {}", crate::types::expressions::fit::article(&facing.ty)))
                    .help("write for example `facing vector(0, 0, 1)`"),
            );
        }
        if [&at, &facing].iter().any(|e| e.any(&mut |e| e.ty == Ty::Unknown)) {
            return None;
        }
        let mut ports = Vec::new();
        for index in numbers {
            let mut locals = if port.index.is_some() { vec![Value::Number(index)] } else { Vec::new() };
            let Value::Vector(at) = self.expressions.constant_with(&at, &mut locals)? else { return None };
            let Value::Vector([x, y, z]) = self.expressions.constant_with(&facing, &mut locals)? else {
                return None;
            };
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

    /// The mass of one piece: given, or from its density.
    pub(super) fn mass(&mut self, from: &Values<'_>, shape: Option<Form>, cx: &Context) -> Option<f64> {
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
        if let Some((_, tree)) = from.values.get("mass") {
            let mass = self.number(from, "mass", Dimension::MASS, Sign::Positive, "8 g", cx);
            if let (Some(mass), Some(shape)) = (mass, shape) {
                self.usual_density(from.what, mass, shape.shape.volume(), tree);
            }
            return mass;
        }
        Some(
            self.number(from, "density", Dimension::DENSITY, Sign::Positive, "1 g/cm^3", cx)?
                * shape?.shape.volume(),
        )
    }

    pub(super) fn shape(
        &mut self,
        from: &Values<'_>,
        name: &str,
        example: &str,
        cx: &Context,
    ) -> Option<Form> {
        let (value, span) = self.value(from, name, &Ty::Shape, example, cx)?;
        let Value::Shape(shape) = value else { return None };
        let (solid, sizes) = shape.written();
        let segment = name == "segment";
        if let Some(bad) = sizes.iter().find(|s| **s <= 0.0) {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, span, "every size of a shape must be above 0")
                    .label(format!(
                        "one is {}",
                        crate::types::expressions::shown(*bad, &Ty::Quantity(Dimension::LENGTH))
                    ))
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

    pub(super) fn colour(&mut self, from: &Values<'_>, cx: &Context) -> String {
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
}
