//! The best designs as bodies that can be drawn.

use std::rc::Rc;

use nalgebra::Isometry3;

use crate::derive::Candidate;
use crate::design::assembly::Shape;
use crate::results::DesignError;
use crate::results::replay;
use crate::results::report::read::{Found, Run};

/// One rigid piece of a body at rest.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) shape: Shape,
    pub(crate) pose: Isometry3<f64>,
    /// As `#rrggbb`; anything else is grey.
    pub(crate) colour: String,
}

/// The body of a run's best design, at rest; none if there is none yet.
///
/// # Errors
///
/// Why it cannot be made again, in a sentence for the page.
pub(crate) fn pieces(run: &Run) -> Option<Result<Vec<Piece>, String>> {
    let found = run.design.as_ref()?.as_ref();
    Some(match found {
        Ok(found) => made(found).map_err(|why| why.to_string()),
        Err(lost) => Err(lost.to_string()),
    })
}

fn made(found: &Found) -> Result<Vec<Piece>, Rc<DesignError>> {
    let rules = &found.rules.as_ref().map_err(Rc::clone)?.0;
    let Candidate { derivation, body, .. } = replay::candidate(rules, &found.design)?;
    if !derivation.design.is_body(&found.design.body) {
        return Err(found.design.differs(DesignError::OtherBody).into());
    }
    let elements = body.assembly.elements.iter().zip(&body.parts_of_elements);
    let piece = elements.map(|(element, id)| {
        let part = derivation.design.parts.get(id);
        let colour = part.map_or(String::new(), |part| part.made.colour().to_owned());
        Piece { shape: element.shape, pose: element.pose, colour }
    });
    Ok(piece.collect())
}
