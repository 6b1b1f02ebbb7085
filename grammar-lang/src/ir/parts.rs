//! Parts: passive ones and actuators.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::text::{Names, Writer, range, shape, tabulated};
use super::{Expr, Form, Table, Ty};
use crate::source::Span;
use crate::units::{self, Dimension};

/// The ports of every block that declares none.
pub const BLOCK_PORTS: &[&str] = &["front", "back", "left", "right", "top", "bottom"];

/// The ports of an actuator.
pub const ACTUATOR_PORTS: &[&str] = &["base", "tip"];

/// A passive part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its shape.
    pub shape: Form,
    /// Mass in kg.
    pub mass: f64,
    /// Coulomb coefficient of its surface.
    pub friction: f64,
    /// `#rrggbb`
    pub colour: String,
    /// Its ports, if they are not the six that every block has.
    pub ports: Vec<Port>,
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
    pub at: [f64; 3],
    /// The unit vector that points outwards.
    pub facing: [f64; 3],
}

/// How fast an actuator bends, rad/s.
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

/// An actuator: a row of equal segments joined by driven hinges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Actuator {
    /// One segment.
    pub segment: Form,
    /// Mass of one segment in kg.
    pub mass: f64,
    /// Coulomb coefficient of its surface.
    pub friction: f64,
    /// Total bend from base to tip in rad, least and greatest.
    pub bend: (f64, f64),
    /// Speed of the total bend while it grows, rad/s.
    pub bending_speed: Speed,
    /// Speed of the total bend while it goes back to zero, rad/s.
    pub relaxing_speed: Speed,
    /// Greatest torque of a hinge, N m.
    pub torque: f64,
    /// Stiffness of a hinge's servo, N m/rad.
    pub stiffness: f64,
    /// Damping of a hinge's servo, N m s/rad.
    pub damping: f64,
    /// `#rrggbb`
    pub colour: String,
    /// Parameters of an instance.
    pub params: IndexMap<String, InstanceParam>,
    /// Where it is declared.
    pub span: Span,
}

/// A parameter of an actuator instance.
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

    pub(super) fn actuator(&mut self, name: &str, actuator: &Actuator) {
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
