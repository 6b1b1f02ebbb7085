//! The best designs, side by side.

use super::solid::{picture, scale};
use super::words::{counted, or_dash, value};
use super::{Link, heading, label};
use crate::markup::escape;
use crate::results::report::gather::bodies::{Piece, pieces};
use crate::results::report::read::{Group, Run};

/// A run and what its best design is made of.
type Drawn<'a> = (&'a Run, Result<Vec<Piece>, String>);

pub(super) fn section(groups: &[Group], link: Link) -> String {
    let made: Vec<Vec<Drawn>> = groups
        .iter()
        .map(|group| group.runs.iter().filter_map(|run| Some((run, pieces(run)?))).collect())
        .collect();
    let bodies = || made.iter().flatten().filter_map(|(_, pieces)| pieces.as_ref().ok().map(Vec::as_slice));
    if made.iter().all(Vec::is_empty) {
        return "<p>No run has a design yet.</p>\n".to_owned();
    }
    let scale = scale(bodies());
    let mut out = String::new();
    for (i, (group, made)) in groups.iter().zip(&made).enumerate() {
        let mut order: Vec<&Drawn> = made.iter().collect();
        let fitness = |run: &Run| run.value().map_or(f64::NEG_INFINITY, |value| group.fitness(value));
        order.sort_by(|a, b| fitness(b.0).total_cmp(&fitness(a.0)));
        let cards: String =
            order.into_iter().map(|(run, pieces)| card(groups, group, run, pieces, scale, link)).collect();
        out += &format!("{}<div class=\"cards\">\n{cards}</div>\n", heading(groups, i));
    }
    out + "<p class=\"small\">The best design of each run at rest, best first; y is up, and all have the same scale. A design whose page <code>sgc view</code> has written is linked to it.</p>\n"
}

fn card(
    groups: &[Group],
    group: &Group,
    run: &Run,
    pieces: &Result<Vec<Piece>, String>,
    scale: f64,
    link: Link,
) -> String {
    let name = label(groups, group, run);
    let best = or_dash(run.value().map(|best| value(best, &group.unit)));
    let size = run.found().map_or(String::new(), |m| {
        format!("{}, {}", counted(m.parts, "part"), counted(m.actuators, "actuator"))
    });
    let drawn = match pieces {
        Ok(pieces) => picture(pieces, scale, &format!("the best design of {name}")),
        Err(why) => format!(
            "<p class=\"lost\">No picture: the saved design cannot be made again. {}.</p>",
            escape(why)
        ),
    };
    let drawn = match link(&run.path) {
        Some(address) => format!("<a href=\"{}\" title=\"see it move\">{drawn}</a>", escape(&address)),
        None => drawn,
    };
    format!(
        "<figure class=\"card\">{drawn}<figcaption><b>{best}</b> seed {}<br>{size}</figcaption></figure>\n",
        run.asked.seed
    )
}
