//! Checks passive parts, and what actuators have as they do: shape, mass, colour.

use indexmap::IndexMap;
use nalgebra::{Point3, Vector3};

use super::Declarations;
use super::fields::{Fields, Sign, Values, reads_params};
use super::joints::{OF_JOINTS, Owner, own_fields, says_joint};
use crate::diagnostics::{Code, Diagnostic};
use crate::eval::{Value, is_colour, unit};
use crate::ir::{self, ExprKind, Field, Form, Function, Mass, PartAttribute, Solid, Ty};
use crate::source::Span;
use crate::syntax::ast::{self, Block};
use crate::types::expressions::context::{Context, Local};
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

/// A port that lies deeper in its part than this share of what the part measures there is inside it.
const BURIED: f64 = 0.25;
const PART: &[&str] = &["shape", "density", "mass", "friction", "colour", "joint"];

impl Declarations<'_> {
    pub(in crate::types) fn part(&mut self, block: &Block, damaged: bool) -> Option<ir::Part> {
        let row = if says_joint(block) { Some(self.joint(block, Owner::Part)?) } else { None };
        let mut all = PART.to_vec();
        all.extend(row.into_iter().flat_map(own_fields));
        // A joint that cannot be read leaves its fields behind.
        if damaged && row.is_none() {
            all.extend(OF_JOINTS);
        }
        let from = match row {
            Some(row) => self.row_values(block, row, &all),
            None => self.values(block, "a part", Fields::values(&all)),
        };
        let is_port = |name: &str| {
            ir::BLOCK_PORTS.contains(&name)
                || block
                    .fields
                    .iter()
                    .any(|field| matches!(field, ast::Field::Port(p) if p.name.text == name))
        };
        let is_taken = |name: &str| {
            PartAttribute::named(name).is_some() || all.contains(&name) || is_port(name) || name == "pi"
        };
        let params = self.instance_params_of(block, &is_taken, damaged);
        let cx = self.context_of(block, &params, damaged);
        let shape = self.shape(&from, "shape", "box(2 cm, 2 cm, 2 cm)", &cx);
        let mass = self.mass(&from, shape.as_ref(), &cx);
        let friction =
            self.varying_number(&from, "friction", Dimension::NUMBER, (Sign::NotNegative, "0.8"), &cx);
        let colour = self.colour(&from, &cx);
        let ports = self.ports(block, &cx);
        if let (Some(Field::Fixed(form)), Some(ports)) = (&shape, &ports) {
            self.check_places(block, *form, ports);
        }
        let joint = match row {
            Some(row) => {
                let axis = self.joint_axis(row, &cx)?;
                let joint = self.joint_of(&from, (row, axis), 1.0, &cx)?;
                if let (Some(Field::Fixed(form)), Some(Field::Fixed(pivot))) = (&shape, &joint.pivot) {
                    self.check_pivot(&from, *form, *pivot);
                }
                Some(joint)
            }
            None => None,
        };
        Some(ir::Part {
            shape: shape?,
            mass: mass?,
            friction: friction?,
            colour: colour?,
            ports: ports?,
            joint,
            params,
            span: block.name.span,
        })
    }

    /// Where the fields of a kind stand: what they read first are its parameters, in their order.
    pub(super) fn context_of(
        &mut self,
        block: &Block,
        params: &IndexMap<String, ir::InstanceParam>,
        damaged: bool,
    ) -> Context {
        let mut cx = Context::new(Stage::Declaration, damaged);
        for (name, param) in params {
            let span = block.fields.iter().find_map(|field| match field {
                ast::Field::Param(written) if written.name.text == *name => Some(written.name.span),
                _ => None,
            });
            let span = span.unwrap_or(block.name.span);
            cx.locals.push(Local::new(name.clone(), param.ty.clone(), span));
        }
        let fields = block.fields.iter().filter_map(|field| match field {
            ast::Field::Value(name, value) => Some((name.clone(), value.clone())),
            _ => None,
        });
        cx.fields.all = fields.collect();
        cx.fields.params = cx.locals.len();
        self.expressions.find_circles(&mut cx);
        cx
    }

    /// The ports that a part declares.
    fn ports(&mut self, block: &Block, cx: &Context) -> Option<Vec<ir::Port>> {
        let mut ports: Vec<ir::Port> = Vec::new();
        let mut sound = true;
        for field in &block.fields {
            let ast::Field::Port(port) = field else { continue };
            if ports.iter().any(|p| p.name == port.name.text) {
                let first = block.fields.iter().find_map(|f| match f {
                    ast::Field::Port(p) if p.name.text == port.name.text => Some(p.name.span),
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
                Diagnostic::new(Code::OUT_OF_DOMAIN, block.name.span, "a part can have at most 64 ports")
                    .label(format!("this one has {}", ports.len()))
                    .help("declare fewer, or narrow the ranges of their numbers"),
            );
            return None;
        }
        sound.then_some(ports)
    }

    /// Warns of an axis further from the part than the part is long.
    fn check_pivot(&mut self, from: &Values<'_>, form: Form, pivot: [f64; 3]) {
        let Some((_, tree)) = from.values.get("pivot") else { return };
        if Point3::from(pivot).coords.norm() > 3.0 * form.shape.reach() + 1e-3 {
            self.stray_pivot(tree.span, pivot, form.shape.reach());
        }
    }

    /// Warns of ports that lie off the part, and of two in one place.
    fn check_places(&mut self, block: &Block, form: Form, ports: &[ir::Port]) {
        let place = |name: &str| {
            block.fields.iter().find_map(|field| match field {
                ast::Field::Port(port) if port.name.text == name => Some(port.at.span),
                _ => None,
            })
        };
        let shape = form.shape;
        let slack = 0.05 * shape.longest() + 1e-3;
        let mut told: Vec<&str> = Vec::new();
        let fixed = |port: &ir::Port| Some((*port.at.fixed()?, *port.facing.fixed()?));
        let there: Vec<_> = ports.iter().filter_map(|port| Some((port, fixed(port)?))).collect();
        for (i, (port, (at, facing))) in there.iter().enumerate() {
            let Some(span) = place(&port.name) else { continue };
            let at = Point3::from(*at);
            // What stands has its own x axis upright.
            let own = if form.stands { Point3::new(at.y, at.x, at.z) } else { at };
            if !shape.holds(&own, slack) && !told.contains(&port.name.as_str()) {
                told.push(&port.name);
                // How far the part reaches towards the port.
                let distance = at.coords.norm();
                let reach = shape.depth(&Point3::origin(), &(own.coords / distance));
                self.stray_port(&port.name, span, distance, reach);
            }
            let [x, y, z] = *facing;
            let ahead = if form.stands { Vector3::new(y, x, z) } else { Vector3::new(x, y, z) };
            self.misnamed_port(&port.name, span, facing);
            let (depth, behind) = (shape.depth(&own, &ahead), shape.depth(&own, &-ahead));
            if depth > BURIED * (depth + behind) + 1e-3 && !told.contains(&port.name.as_str()) {
                told.push(&port.name);
                self.buried_port(&port.name, span, (depth, behind), facing);
            }
            let outwards: f64 = (0..3).map(|k| facing[k] * at.coords[k]).sum();
            if outwards < -0.1 * at.coords.norm() && !told.contains(&port.name.as_str()) {
                told.push(&port.name);
                self.report(
                    Diagnostic::new(
                        Code::STRAY_PORT,
                        span,
                        format!("the port `{}` faces into its part", port.name),
                    )
                    .label("`facing` points from here towards the middle")
                    .help("let it face outwards: reverse the sign of `facing`"),
                );
            }
            let same = |(_, (place, other)): &&(&ir::Port, ([f64; 3], [f64; 3]))| {
                let apart = (Point3::from(*place) - at).norm();
                let aligned: f64 = (0..3).map(|k| other[k] * facing[k]).sum();
                apart < 1e-6 && aligned > 0.5
            };
            let Some((first, _)) = there[..i].iter().find(same) else { continue };
            let names = if first.name == port.name {
                format!("`{0}[{1}]` and `{0}[{2}]`", port.name, first.index, port.index)
            } else {
                format!("`{}` and `{}`", first.name, port.name)
            };
            self.report(
                Diagnostic::new(
                    Code::PORTS_TOGETHER,
                    span,
                    format!("the ports {names} lie in the same place"),
                )
                .label("the same place, and the same direction")
                .help("parts attached to both would overlap: move or remove one of the ports"),
            );
            return;
        }
    }

    fn port(&mut self, port: &ast::Port, cx: &Context) -> Option<Vec<ir::Port>> {
        let params = cx.locals.len();
        let mut cx = cx.clone();
        let mut numbers = vec![0.0];
        if let Some((name, domain)) = &port.index {
            let ty = Ty::Domain(Box::new(Ty::Count));
            let mut outside = Context::new(cx.stage, cx.damaged);
            let domain = self.expressions.expect(domain, &mut outside, &ty, "the number of a port");
            let Value::Domain(domain) = self.expressions.constant(&domain)? else { return None };
            numbers = domain.items().take(65).filter_map(|v| v.as_number()).collect();
            self.expressions.bind(name, Ty::Count, &mut cx);
        }
        let length = Ty::Vector(Dimension::LENGTH);
        let at = self.expressions.expect(&port.at, &mut cx, &length, "the place of a port");
        let facing = self.expressions.infer(&port.facing, &mut cx);
        if !matches!(facing.ty, Ty::Vector(_) | Ty::Unknown) {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, facing.span, "the direction of a port must be a vector")
                    .label(format!("this is {}", crate::types::expressions::fit::article(&facing.ty)))
                    .help("write for example `facing vector(0, 0, 1)`"),
            );
        }
        if [&at, &facing].iter().any(|e| e.any(&mut |e| e.ty == Ty::Unknown)) {
            return None;
        }
        let mut ports = Vec::new();
        for index in numbers {
            let at = self.vector(&at, params, index)?;
            let facing = self.vector(&facing, params, index)?;
            let facing = match facing {
                Field::Fixed(facing) => {
                    let Some(facing) = unit(facing) else {
                        self.report(
                            Diagnostic::new(
                                Code::BAD_VALUE,
                                port.facing.span,
                                "a port must face in some direction",
                            )
                            .label("a vector of length zero")
                            .help("write for example `facing vector(1, 0, 0)`"),
                        );
                        return None;
                    };
                    Field::Fixed(facing)
                }
                varies => varies,
            };
            ports.push(ir::Port { name: port.name.text.clone(), index, at, facing });
        }
        Some(ports)
    }

    /// A vector of the port with this number; its expression reads that behind the parameters.
    fn vector(&mut self, expr: &ir::Expr, params: usize, index: f64) -> Option<Field<[f64; 3]>> {
        if reads_params(expr, params) {
            return Some(Field::Varies(expr.clone()));
        }
        let mut locals = vec![Value::Number(index); params + 1];
        let Value::Vector(vector) = self.expressions.constant_with(expr, &mut locals)? else { return None };
        Some(Field::Fixed(vector))
    }

    /// The mass of one piece: given, or from its density.
    pub(super) fn mass(
        &mut self,
        from: &Values<'_>,
        shape: Option<&Field<Form>>,
        cx: &Context,
    ) -> Option<Mass> {
        if let (Some((mass, _)), Some((name, _))) = (from.values.get("mass"), from.values.get("density")) {
            self.report(
                Diagnostic::new(Code::DUPLICATE, name.span, "mass and density are both given")
                    .label("only one of them can count")
                    .also(mass.span, "the mass")
                    .help("keep the one that was measured"),
            );
        }
        if !from.values.contains_key("mass") && !from.values.contains_key("density") {
            self.missing(from, "density", "1 g/cm^3` or `mass = 8 g", cx.damaged);
            return None;
        }
        let form = shape.and_then(Field::fixed);
        if let Some((_, tree)) = from.values.get("mass") {
            let mass = self.varying_number(from, "mass", Dimension::MASS, (Sign::Positive, "8 g"), cx);
            if let (Some(Field::Fixed(mass)), Some(form)) = (&mass, form) {
                self.usual_density(from.what, *mass, form.shape.volume(), tree);
            }
            return mass.map(Mass::Given);
        }
        let density =
            self.varying_number(from, "density", Dimension::DENSITY, (Sign::Positive, "1 g/cm^3"), cx)?;
        // Where the shape is at fault, that is told.
        shape?;
        Some(match (density, form) {
            (Field::Fixed(density), Some(form)) => {
                let mass = density * form.shape.volume();
                if let Some((_, tree)) = from.values.get("density") {
                    self.usual_mass(from.what, mass, tree);
                }
                Mass::Given(Field::Fixed(mass))
            }
            (density, _) => Mass::Dense { density },
        })
    }

    pub(super) fn shape(
        &mut self,
        from: &Values<'_>,
        name: &str,
        example: &str,
        cx: &Context,
    ) -> Option<Field<Form>> {
        let field = self.varying(from, name, (&Ty::Shape, example), cx, |own, value, span| {
            let Value::Shape(form) = value else { return None };
            own.sound_form(form, name, example, span).then_some(form)
        })?;
        if let Field::Varies(expr) = &field
            && !self.right_solids(expr, name == "segment")
        {
            return None;
        }
        Some(field)
    }

    /// Whether a shape has sizes, and is one that such a part may have.
    fn sound_form(&mut self, form: Form, name: &str, example: &str, span: Span) -> bool {
        let (solid, sizes) = form.written();
        if let Some(bad) = sizes.iter().find(|s| **s <= 0.0) {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, span, "every size of a shape must be above 0")
                    .label(format!(
                        "one is {}",
                        crate::types::expressions::shown(*bad, &Ty::Quantity(Dimension::LENGTH))
                    ))
                    .help(format!("write for example `{name} = {example}`")),
            );
            return false;
        }
        self.right_solid(solid, name == "segment", span)
    }

    /// Whether a segment is a cylinder or a box, and a passive part no cylinder.
    fn right_solid(&mut self, solid: Solid, segment: bool, span: Span) -> bool {
        let is_right = match solid {
            Solid::Box => true,
            Solid::Cylinder => segment,
            Solid::Sphere | Solid::Disk | Solid::Capsule => !segment,
        };
        if is_right {
            return true;
        }
        let (message, help) = if segment {
            (
                "a segment must be a cylinder or a box",
                "write `segment = cylinder(radius, length)`, or `box(length, thickness, width)` for a flat strip",
            )
        } else {
            (
                "the shape of a part must be a box, a sphere, a disk or a capsule",
                "write `box(x, y, z)`, `sphere(radius)`, `disk(radius, height)` or `capsule(radius, length)`",
            )
        };
        self.report(Diagnostic::new(Code::BAD_VALUE, span, message).label("another shape").help(help));
        false
    }

    /// The same of all shapes that an expression can come to.
    fn right_solids(&mut self, expr: &ir::Expr, segment: bool) -> bool {
        let mut solids = Vec::new();
        expr.any(&mut |e| {
            if let ExprKind::Call(Function::Solid(solid), _) = &e.kind {
                solids.push((*solid, e.span));
            }
            false
        });
        solids.into_iter().all(|(solid, span)| self.right_solid(solid, segment, span))
    }

    pub(super) fn colour(&mut self, from: &Values<'_>, cx: &Context) -> Option<Field<String>> {
        const PLAIN: &str = "#9aa3ad";
        if !from.values.contains_key("colour") {
            return Some(Field::Fixed(PLAIN.to_owned()));
        }
        // A colour that is no colour is reported, and the rest of the part is looked at all the same.
        let plain = || Some(Field::Fixed(PLAIN.to_owned()));
        let field = self.varying(from, "colour", (&Ty::Text, "\"#e8963c\""), cx, |own, value, span| {
            let Value::Text(text) = value else { return None };
            if !is_colour(&text) {
                own.report(
                    Diagnostic::new(Code::BAD_VALUE, span, "a colour must be written as `#rrggbb`")
                        .label("not in this form")
                        .help("write for example `colour = \"#e8963c\"`"),
                );
                return None;
            }
            Some(text.to_string())
        });
        field.or_else(plain)
    }
}
