//! What elements look like, and where they were as the design grew: each thing once.

use nalgebra::Isometry3;
use serde::Serialize;

use super::Making;
use crate::design::assembly::Shape;

/// A look as the page's script reads it.
#[derive(Debug, Serialize)]
pub struct Look {
    /// `box` with three half edges, `ball` with a radius, `cylinder` with
    /// radius and half length along x; in m.
    pub shape: (&'static str, Vec<f64>),
    /// Colour as `#rrggbb`.
    pub colour: String,
    /// What to call it.
    pub label: String,
}

/// An element over the steps as the page's script reads it.
#[derive(Debug, Serialize)]
pub struct Piece {
    /// Index of its look.
    pub look: usize,
    /// The first step after which it is there.
    pub from: usize,
    /// The first step after which it is gone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until: Option<usize>,
    /// Poses and the steps from which on they hold: x, y, z in m, quaternion i, j, k, w.
    pub poses: Vec<(usize, [f64; 7])>,
    /// Names and the steps from which on they hold.
    pub names: Vec<(usize, String)>,
}

/// Looks, each once.
#[derive(Debug, Default)]
pub(super) struct Looks {
    known: Vec<super::Look>,
    /// As the page's script reads them.
    pub(super) list: Vec<Look>,
}

impl Looks {
    /// The index of a look.
    pub(super) fn index(&mut self, look: &super::Look) -> usize {
        if let Some(index) = self.known.iter().position(|known| known == look) {
            return index;
        }
        let (shape, colour) = (shape(&look.shape), colour(&look.colour));
        self.list.push(Look { shape, colour, label: look.label.clone() });
        self.known.push(look.clone());
        self.known.len() - 1
    }
}

/// The pieces of a design as it grew.
pub(super) fn pieces(making: &Making, looks: &mut Looks) -> Vec<Piece> {
    let piece = |piece: &super::Piece| Piece {
        look: looks.index(&piece.look),
        from: piece.from,
        until: piece.until,
        poses: piece.poses.iter().map(|(step, pose)| (*step, rounded(pose))).collect(),
        names: piece.names.clone(),
    };
    making.pieces.iter().map(piece).collect()
}

/// A pose to a micrometre and a millionth: few digits, and more than can be seen.
fn rounded(pose: &Isometry3<f64>) -> [f64; 7] {
    let (at, turn) = (pose.translation.vector, pose.rotation.coords);
    [at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w].map(|x| (finite(x) * 1e6).round() / 1e6 + 0.0)
}

/// A shape as its kind and lengths in m.
fn shape(shape: &Shape) -> (&'static str, Vec<f64>) {
    (shape.name(), shape.lengths().into_iter().map(finite).collect())
}

/// The colour if it is one, else grey: nothing but a colour may reach the page.
fn colour(text: &str) -> String {
    let is_colour = text
        .strip_prefix('#')
        .is_some_and(|digits| digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit()));
    if is_colour { text.to_ascii_lowercase() } else { "#8a9099".to_owned() }
}

/// The value, or zero for what JSON has no word for.
pub(super) fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_colours_pass_for_colours() {
        assert_eq!(colour("#A0b1C2"), "#a0b1c2");
        for bad in ["", "red", "#fff", "#12345g", "#1234567", "url(x)"] {
            assert_eq!(colour(bad), "#8a9099");
        }
    }
}
