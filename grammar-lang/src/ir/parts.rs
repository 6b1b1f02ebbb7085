//! Parts: passive ones and actuators.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::text::{Names, Writer, range, shape, tabulated};
use super::{Construction, Expr, Form, Joint, JointKind, NAMED_AXES, Table, Ty};
use crate::source::Span;
use crate::units::{self, Dimension};

/// The ports of every block that declares none.
pub const BLOCK_PORTS: &[&str] = &["front", "back", "left", "right", "top", "bottom"];

/// The ports of an actuator.
pub const ACTUATOR_PORTS: &[&str] = &["base", "tip"];

/// A field of a part: one value for all parts of the kind, or one for each part, which reads its parameters. They are the first
/// locals of the expression, in their order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Field<T> {
    /// The same for all.
    Fixed(T),
    /// By the parameters.
    Varies(Expr),
}

impl<T> Field<T> {
    /// The value, if it is the same for all.
    #[must_use]
    pub fn fixed(&self) -> Option<&T> {
        match self {
            Self::Fixed(value) => Some(value),
            Self::Varies(_) => None,
        }
    }

    /// The expression, if it is not.
    #[must_use]
    pub fn varies(&self) -> Option<&Expr> {
        match self {
            Self::Fixed(_) => None,
            Self::Varies(value) => Some(value),
        }
    }
}

/// How heavy one piece is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Mass {
    /// In kg.
    Given(Field<f64>),
    /// By its volume: kg/m^3. Where neither varies the mass itself is kept.
    Dense {
        /// kg/m^3.
        density: Field<f64>,
    },
}

impl Mass {
    /// In kg, if it is the same for all.
    #[must_use]
    pub fn fixed(&self) -> Option<f64> {
        match self {
            Self::Given(mass) => mass.fixed().copied(),
            Self::Dense { .. } => None,
        }
    }

    /// What the field is called that says it.
    #[must_use]
    pub fn field(&self) -> &'static str {
        match self {
            Self::Given(_) => "mass",
            Self::Dense { .. } => "density",
        }
    }

    /// The expression that reads the parameters, if it does.
    #[must_use]
    pub fn varies(&self) -> Option<&Expr> {
        match self {
            Self::Given(field) | Self::Dense { density: field } => field.varies(),
        }
    }
}

/// A passive part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its shape.
    pub shape: Field<Form>,
    /// Its mass.
    pub mass: Mass,
    /// Coulomb coefficient of its surface.
    pub friction: Field<f64>,
    /// `#rrggbb`
    pub colour: Field<String>,
    /// Its ports, if they are not the six that every block has.
    pub ports: Vec<Port>,
    /// The joint with which it hangs on what holds it, if it is not fixed there. Nothing drives it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<Joint>,
    /// Parameters of each such part.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub params: IndexMap<String, InstanceParam>,
    /// Where it is declared.
    pub span: Span,
}

/// A port that a part declares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Port {
    /// Its name; several may share one.
    pub name: String,
    /// Its number among those that share the name.
    pub index: f64,
    /// Its place in the part's frame, m.
    pub at: Field<[f64; 3]>,
    /// What points outwards; a unit vector where it is the same for all.
    pub facing: Field<[f64; 3]>,
}

/// How fast a joint moves: rad/s, of a slide m/s.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Speed {
    /// Always alike.
    Constant(f64),
    /// By its bend in rad.
    ByBend(Table),
}

impl Speed {
    /// The speed at a bend in rad.
    #[must_use]
    pub fn at(&self, bend: f64) -> f64 {
        match self {
            Self::Constant(speed) => *speed,
            Self::ByBend(table) => table.at(bend),
        }
    }

    /// The greatest speed.
    #[must_use]
    pub fn most(&self) -> f64 {
        match self {
            Self::Constant(speed) => *speed,
            Self::ByBend(table) => table.range().1,
        }
    }
}

/// An actuator: a row of equal segments with a joint between each and the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actuator {
    /// One segment.
    pub segment: Field<Form>,
    /// Mass of one segment.
    pub mass: Mass,
    /// Coulomb coefficient of its surface.
    pub friction: Field<f64>,
    /// How its segments move against each other.
    pub joint: Joint,
    /// What drives it; nothing drives a passive row.
    pub motor: Option<Motor>,
    /// `#rrggbb`
    pub colour: Field<String>,
    /// How it is made, if it says so: simulations do not read it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub construction: Option<Construction>,
    /// Parameters of an instance.
    pub params: IndexMap<String, InstanceParam>,
    /// Where it is declared.
    pub span: Span,
}

/// What drives the joints of a row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motor {
    /// Speed of the tip against the base while it goes away from rest, rad/s or m/s. Of a spin the greatest.
    pub speed: Field<Speed>,
    /// Speed while it goes back to rest.
    pub relaxing_speed: Field<Speed>,
    /// Greatest torque or force of each joint, N m or N.
    pub effort: Field<f64>,
}

/// A parameter that each part of a kind has for itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InstanceParam {
    /// Its type.
    pub ty: Ty,
    /// The values it may take: low and high, in SI units.
    pub domain: Option<(f64, f64)>,
    /// Its value if a rule does not say otherwise.
    pub default: Option<Expr>,
}

impl Writer<'_> {
    pub(super) fn part(&mut self, name: &str, part: &Part) {
        let names: Names = part.params.keys().cloned().collect();
        self.gap();
        self.line(0, format!("part {name} {{"));
        self.instance_params(&part.params);
        self.field(&names, "shape", &part.shape, |form| shape(*form));
        self.mass(&names, &part.mass);
        self.field(&names, "friction", &part.friction, f64::to_string);
        for port in &part.ports {
            let at = self.written(&names, &port.at, place);
            let plain = |x: &[f64; 3]| format!("vector({})", x.map(|x| x.to_string()).join(", "));
            let facing = self.written(&names, &port.facing, plain);
            self.line(1, format!("port {}[{}] at {at} facing {facing}", port.name, port.index));
        }
        if let Some(joint) = &part.joint {
            self.joint(&names, joint, true);
            self.reach(&names, joint);
            self.springs(&names, joint);
        }
        self.line(0, "}");
    }

    /// A field as a grammar says it.
    fn written<T>(&self, names: &Names, field: &Field<T>, shown: impl Fn(&T) -> String) -> String {
        match field {
            Field::Fixed(value) => shown(value),
            Field::Varies(value) => self.expr(value, names),
        }
    }

    fn field<T>(&mut self, names: &Names, name: &str, field: &Field<T>, shown: impl Fn(&T) -> String) {
        let value = self.written(names, field, shown);
        self.line(1, format!("{name} = {value}"));
    }

    fn quantity(&mut self, names: &Names, name: &str, field: &Field<f64>, dimension: Dimension) {
        self.field(names, name, field, |x| units::shown(*x, dimension));
    }

    fn mass(&mut self, names: &Names, mass: &Mass) {
        match mass {
            Mass::Given(mass) => self.quantity(names, "mass", mass, Dimension::MASS),
            Mass::Dense { density } => self.quantity(names, "density", density, Dimension::DENSITY),
        }
    }

    pub(super) fn actuator(&mut self, name: &str, actuator: &Actuator) {
        let names: Names = actuator.params.keys().cloned().collect();
        let joint = &actuator.joint;
        self.gap();
        self.line(0, format!("actuator {name} {{"));
        self.instance_params(&actuator.params);
        self.field(&names, "segment", &actuator.segment, |form| shape(*form));
        let kind = joint.kind;
        let usual = kind == JointKind::Bend && joint.axis.fixed() == Some(&kind.usual_axis());
        if !usual || actuator.motor.is_none() {
            self.joint(&names, joint, actuator.motor.is_none());
        }
        self.reach(&names, joint);
        if let Some(motor) = &actuator.motor {
            let speed = |speed: &Speed| match speed {
                Speed::Constant(speed) => units::shown(*speed, kind.speed()),
                Speed::ByBend(table) => tabulated(table, Dimension::ANGLE, Dimension::ANGULAR_VELOCITY),
            };
            self.field(&names, kind.speed_field(), &motor.speed, speed);
            if kind != JointKind::Spin {
                self.field(&names, "relaxing_speed", &motor.relaxing_speed, speed);
            }
        }
        self.mass(&names, &actuator.mass);
        self.quantity(&names, "friction", &actuator.friction, Dimension::NUMBER);
        if let Some(motor) = &actuator.motor {
            self.quantity(&names, kind.effort_field(), &motor.effort, kind.effort());
        }
        self.springs(&names, joint);
        if let Some(construction) = &actuator.construction {
            self.construction(construction);
        }
        self.line(0, "}");
    }

    fn joint(&mut self, names: &Names, joint: &Joint, passive: bool) {
        let plain = |x: &[f64; 3]| match NAMED_AXES.iter().find(|(_, axis)| axis == x) {
            Some((name, _)) => (*name).to_owned(),
            None => format!("vector({})", x.map(|x| x.to_string()).join(", ")),
        };
        let axis = match joint.kind.axis_word() {
            Some(word) => format!(" {word} {}", self.written(names, &joint.axis, plain)),
            None => String::new(),
        };
        let passive = if passive { " passive" } else { "" };
        self.line(1, format!("joint = {}{axis}{passive}", joint.kind.text()));
    }

    fn reach(&mut self, names: &Names, joint: &Joint) {
        if let Some(limits) = &joint.range {
            let position = Ty::Quantity(joint.kind.position());
            self.field(names, joint.kind.range(), limits, |limits| range(*limits, &position));
        }
    }

    fn springs(&mut self, names: &Names, joint: &Joint) {
        let kind = joint.kind;
        if kind != JointKind::Spin {
            self.quantity(names, "stiffness", &joint.stiffness, kind.stiffness());
        }
        self.quantity(names, "damping", &joint.damping, kind.damping());
        for (name, across) in [("sideways", &joint.sideways), ("torsion", &joint.torsion)] {
            if let Some(across) = across {
                self.quantity(names, name, across, kind.stiffness());
            }
        }
        if joint.neutral != Field::Fixed(0.0) {
            self.quantity(names, "neutral", &joint.neutral, kind.position());
        }
        if let Some(begins) = &joint.begins {
            self.quantity(names, "begins", begins, kind.position());
        }
        if let Some(pivot) = &joint.pivot {
            self.field(names, "pivot", pivot, place);
        }
    }

    pub(super) fn instance_params(&mut self, params: &IndexMap<String, InstanceParam>) {
        for (name, param) in params {
            let domain = param.domain.map_or(String::new(), |d| format!(" in {}", range(d, &param.ty)));
            let default = param
                .default
                .as_ref()
                .map_or(String::new(), |d| format!(" = {}", self.expr(d, &Names::new())));
            self.line(1, format!("param {name} : {}{domain}{default}", param.ty));
        }
    }
}

/// A place as a grammar writes it.
fn place(at: &[f64; 3]) -> String {
    format!("vector({})", at.map(|x| units::shown(x, Dimension::LENGTH)).join(", "))
}
