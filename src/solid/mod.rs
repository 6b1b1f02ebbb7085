//! One actuator as a solid of finite elements, at rest under its loads: from its material, its hole and what drives it to the hinges
//! that stand for it.
//!
//! The material is neo-Hookean rubber, deformations may be large, and only one half is meshed: actuators are symmetric about the plane
//! in which they bend. In this folder x leads from the base to the tip, the actuator bends towards z, and y is sideways.

mod factor;
mod fit;
mod freedoms;
mod mesh;
mod rubber;
mod section;
mod shape;
mod statics;
mod surface;
#[cfg(test)]
mod tests;

pub use fit::{Fitted, Law, UnderLoad, fit};
pub use section::{Hole, Outline};
pub use statics::Lost;

/// An actuator as it is made. Lengths in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Casting {
    /// What its cross-section looks like from outside.
    pub outline: Outline,
    /// The hole in it, along its whole length.
    pub hole: Option<Hole>,
    /// From the base to the tip. Both are glued to something rigid.
    pub length: f64,
    /// Young's modulus for small strains, Pa.
    pub young: f64,
    /// Poisson's ratio, below 0.5.
    pub poisson: f64,
    /// How stiff threads are that are wound around it, N/m: the force in them for each length of the actuator, when they are stretched
    /// to twice their length. They do not push.
    pub winding: f64,
    /// The same for a sheet on its upper side, which is stretched along the actuator, N/m: for each width.
    pub sheet: f64,
    /// How far a thread that bends it lies from its axis, towards the upper side.
    pub thread: f64,
}

/// What acts on an actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// In the hole, Pa.
    pub pressure: f64,
    /// In the thread, N.
    pub pull: f64,
    /// On the tip, towards the upper side, N m.
    pub moment: f64,
}

impl Load {
    /// What lies between this load and another, of which it has a share.
    fn mixed(self, other: Self, share: f64) -> Self {
        let mixed = |own: f64, other: f64| own + share * (other - own);
        Self {
            pressure: mixed(self.pressure, other.pressure),
            pull: mixed(self.pull, other.pull),
            moment: mixed(self.moment, other.moment),
        }
    }
}
