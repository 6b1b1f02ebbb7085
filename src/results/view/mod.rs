//! The viewer: one HTML page that shows a recorded motion in 3D.
//!
//! The page is self-contained and opens offline by a double click: three.js,
//! the style, the scripts and the recorded poses are all inside it, and its
//! content security policy lets it run those scripts only and load nothing.
//! The same scene always gives the same bytes.
//!
//! [`encode`] packs the numbers, `page.html` is the frame into which the texts
//! go, `page.css` the style, `script/` what runs in the browser.

pub mod encode;
mod html;
#[cfg(test)]
mod tests;

use crate::design::assembly::Shape;
use crate::simulate::Motion;

/// All that the page shows, as plain data. Texts are shown as they are: units
/// and rounding are the caller's choice.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The heading, usually the name of the grammar.
    pub title: String,
    /// Lines below the heading: seed, solver, date or whatever tells runs apart.
    pub subtitle: Vec<String>,
    /// The value of the objective with its unit, such as `38.2 cm`; may be empty.
    pub value: String,
    /// The terms of the objective: name and text.
    pub terms: Vec<(String, String)>,
    /// The elements, in the order of [`Motion::placements`]; the first is the core.
    pub elements: Vec<Element>,
    /// What was recorded.
    pub motion: Motion,
    /// One curve per actuator, in the order of the actuators of [`Motion::bends`].
    pub curves: Vec<Curve>,
    /// The derivation, a line of text per step.
    pub derivation: Vec<String>,
    /// What other models or settings say about the same design.
    pub checks: Vec<Check>,
}

/// How one element of the assembly looks.
#[derive(Clone, Debug)]
pub struct Element {
    /// Its geometry, in metres.
    pub shape: Shape,
    /// Its colour as `#rrggbb`; anything else becomes grey.
    pub colour: String,
    /// The actuator it belongs to: an index into [`Scene::curves`].
    pub actuator: Option<usize>,
    /// What to call it, such as `cube`.
    pub label: String,
}

/// What one actuator was asked to do; what it did is in [`Motion::bends`].
#[derive(Clone, Debug)]
pub struct Curve {
    /// The name of the actuator.
    pub name: String,
    /// Time between samples in s, the first being at time zero.
    pub interval: f64,
    /// Target of the total bend angle in rad; the last sample holds on.
    pub targets: Vec<f64>,
}

/// One cross-check of the result.
#[derive(Clone, Debug)]
pub struct Check {
    /// What was checked.
    pub name: String,
    /// What came out.
    pub text: String,
    /// Whether it agrees.
    pub ok: bool,
}

/// The whole page as HTML text.
///
/// Recordings finer than the screen can show are thinned (see
/// [`encode::stride`]); poses are rounded to about a 65000th of the distance
/// travelled. A scene whose parts do not fit together (an element without a
/// placement, a motion without frames) gives a page that shows the rest.
#[must_use]
pub fn page(scene: &Scene) -> String {
    html::page(scene, &encode::data(scene))
}
