//! The viewer: one HTML page that shows a recorded motion in 3D.
//!
//! The page is self-contained and opens offline by a double click: three.js,
//! the style, the scripts and the recorded poses are all inside it, and its
//! content security policy lets it run those scripts only and load nothing.
//! The same scene always gives the same bytes.
//!
//! [`encode`] packs the numbers, `pieces` what the making of the design needs, `page.html` is the frame into which the texts
//! go, `page.css` the style, `script/` what runs in the browser.

pub mod encode;
mod html;
mod pieces;
#[cfg(test)]
mod tests;
mod worlds;

use nalgebra::Isometry3;
use serde::Serialize;

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
    /// How the design was made.
    pub making: Making,
    /// What other models or settings say about the same design.
    pub checks: Vec<Check>,
    /// How it does in worlds that the search never saw, if it was tested in some.
    pub worlds: Option<Worlds>,
    /// Its motion in another world, which is shown beside [`Scene::motion`].
    pub elsewhere: Option<Elsewhere>,
}

/// A motion in a world that is not the nominal one.
#[derive(Clone, Debug)]
pub struct Elsewhere {
    /// What the page calls the world, such as `Worst world`.
    pub world: String,
    /// The motion, recorded as [`Scene::motion`] is.
    pub motion: Motion,
}

/// How a design does in worlds that the search never saw.
#[derive(Clone, Debug)]
pub struct Worlds {
    /// The values, in this unit; none where the motion is not valid.
    pub values: Vec<Option<f64>>,
    /// The unit; empty if there is none.
    pub unit: String,
    /// The value in the nominal world.
    pub nominal: f64,
    /// All of that in a sentence.
    pub text: String,
}

/// How an element looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Its geometry, in metres.
    pub shape: Shape,
    /// Its colour as `#rrggbb`; anything else becomes grey.
    pub colour: String,
    /// What to call it, such as `cube`.
    pub label: String,
}

/// One element of the assembly.
#[derive(Clone, Debug)]
pub struct Element {
    /// How it looks.
    pub look: Look,
    /// The actuator it belongs to: an index into [`Scene::curves`].
    pub actuator: Option<usize>,
}

/// How a design was made, step by step.
#[derive(Clone, Debug, Default)]
pub struct Making {
    /// The beginning, then the rule applications.
    pub steps: Vec<Made>,
    /// All elements that ever were part of it. Each is there once, with its changes: a design of a
    /// thousand steps and elements does not become a million poses.
    pub pieces: Vec<Piece>,
}

/// One step in words.
#[derive(Clone, Debug)]
pub struct Made {
    /// The rule.
    pub rule: String,
    /// What the rule is for; may be empty.
    pub about: String,
    /// What it matched and chose: names and values.
    pub choices: Vec<(String, String)>,
    /// What became of it.
    pub done: String,
}

/// An element over the steps: indices into [`Making::steps`].
#[derive(Clone, Debug)]
pub struct Piece {
    /// How it looks.
    pub look: Look,
    /// The first step after which it is there.
    pub from: usize,
    /// The first step after which it is gone.
    pub until: Option<usize>,
    /// Its poses in the undeformed body, each from a step on; also where a step changed its part otherwise.
    pub poses: Vec<(usize, Isometry3<f64>)>,
    /// What its part is called, each from a step on.
    pub names: Vec<(usize, String)>,
}

/// What one actuator was asked to do; what it did is in [`Motion::bends`].
#[derive(Clone, Debug)]
pub struct Curve {
    /// The name of the actuator.
    pub name: String,
    /// What its target is, and what it did.
    pub measure: Measure,
    /// Time between samples in s, the first being at time zero.
    pub interval: f64,
    /// Its target in SI units; the last sample holds on.
    pub targets: Vec<f64>,
}

/// What is driven of an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// An angle from base to tip, rad.
    Angle,
    /// A distance that the tip slides, m.
    Distance,
    /// How fast the tip turns, rad/s.
    Speed,
    /// By how much cells grow, as a share of their size.
    Strain,
}

/// One cross-check of the result.
#[derive(Clone, Debug)]
pub struct Check {
    /// What was checked.
    pub name: String,
    /// What came out.
    pub text: String,
    /// Whether it agrees; none where it says nothing, for or against.
    pub agrees: Option<bool>,
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
