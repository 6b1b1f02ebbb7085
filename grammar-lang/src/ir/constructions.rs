//! How actuators are made: what `sgc fit` reads.

use serde::{Deserialize, Serialize};

use super::Field;
use super::text::Writer;
use crate::units::{Dimension, shown};

/// What an actuator is made of, and what bends it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Construction {
    /// What it is made of.
    pub material: Material,
    /// What bends it; none if nothing does.
    pub bent_by: Option<BentBy>,
}

/// A rubber.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Young's modulus for small strains, Pa.
    pub young: f64,
    /// Poisson's ratio, below 0.5.
    pub poisson: f64,
    /// kg/m^3
    pub density: f64,
    /// The loss factor: the share of the elastic energy that a cycle loses, over 2 pi.
    pub loss: f64,
}

/// What bends an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum BentBy {
    /// Air in a chamber.
    Chamber(Chamber),
    /// A thread that is pulled.
    Thread(Thread),
}

/// A chamber along the whole actuator. Lengths in m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chamber {
    /// Its section.
    pub hole: Hole,
    /// How far its middle lies from the axis, away from where the actuator bends to.
    pub offset: f64,
    /// The greatest pressure, Pa.
    pub pressure: f64,
    /// How stiff threads are that are wound around the actuator, N/m.
    pub winding: f64,
    /// How stiff a sheet is on the side to which it bends, N/m.
    pub sheet: f64,
}

/// The section of a chamber.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Hole {
    /// A rectangle.
    Box {
        /// Along the axis of the hinges, m.
        width: f64,
        /// Along the bending direction, m.
        height: f64,
    },
    /// A circle.
    Round {
        /// In m.
        radius: f64,
    },
}

/// A thread along the actuator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thread {
    /// How far it lies from the axis, towards where the actuator bends to, m.
    pub offset: f64,
    /// The greatest pull, N.
    pub pull: f64,
}

/// How far a section with these half sizes (along x, y, z of a row) goes along the axis of its hinges, and across it, where it bends to;
/// none if the axis is neither z nor y.
#[must_use]
pub fn across(axis: &Field<[f64; 3]>, half: [f64; 3]) -> Option<[f64; 2]> {
    let [x, y, z] = *axis.fixed()?;
    let [_, along_y, along_z] = half;
    if x == 0.0 && y == 0.0 {
        Some([along_z, along_y])
    } else if x == 0.0 && z == 0.0 {
        Some([along_y, along_z])
    } else {
        None
    }
}

impl Writer<'_> {
    pub(super) fn construction(&mut self, construction: &Construction) {
        let Material { young, poisson, density, loss } = construction.material;
        let length = |x: f64| shown(x, Dimension::LENGTH);
        let (young, density) = (shown(young, Dimension::PRESSURE), shown(density, Dimension::DENSITY));
        self.line(
            1,
            format!(
                "material {{ young = {young}, poisson = {poisson}, density = {density}, loss = {loss} }}"
            ),
        );
        match construction.bent_by {
            Some(BentBy::Chamber(Chamber { hole, offset, pressure, winding, sheet })) => {
                let hole = match hole {
                    Hole::Box { width, height } => {
                        format!("width = {}, height = {}", length(width), length(height))
                    }
                    Hole::Round { radius } => format!("radius = {}", length(radius)),
                };
                let pressure = shown(pressure, Dimension::PRESSURE);
                let [winding, sheet] = [winding, sheet].map(|x| shown(x, Dimension::STIFFNESS));
                let offset = length(offset);
                self.line(
                    1,
                    format!("chamber {{ {hole}, offset = {offset}, pressure = {pressure}, winding = {winding}, sheet = {sheet} }}"),
                );
            }
            Some(BentBy::Thread(Thread { offset, pull })) => {
                let (offset, pull) = (length(offset), shown(pull, Dimension::FORCE));
                self.line(1, format!("thread {{ offset = {offset}, pull = {pull} }}"));
            }
            None => {}
        }
    }
}
