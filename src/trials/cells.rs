//! Archives of which all bodies fall into one cell.

use grammar_lang::diagnostics::Diagnostic;
use grammar_lang::ir::{Descriptor, ExprKind};
use grammar_lang::units::shown;

use super::{Trials, odd};

/// So many bodies must have moved.
const ENOUGH: usize = 3;
/// All values lie within this share of the domain.
const NARROW: f64 = 0.03;
/// Of fewer cells, one may well hold most bodies.
const FEW: usize = 4;
/// Values above the axis are beyond it if they are so many times its length away.
const BEYOND: f64 = 3.0;

pub(super) fn check(trials: &Trials<'_>) -> Vec<Diagnostic> {
    let Some(first) = trials.trials.first() else { return Vec::new() };
    let search = &first.drive.candidate().rules.search;
    let descriptors = search.archive().into_iter().flat_map(|archive| archive.descriptors.values());
    descriptors.filter(|_| trials.trials.len() >= ENOUGH).filter_map(|one| in_one_cell(trials, one)).collect()
}

fn in_one_cell(trials: &Trials<'_>, descriptor: &Descriptor) -> Option<Diagnostic> {
    let values = trials.values(&descriptor.value);
    if values.len() < ENOUGH || values.len() < trials.recordings().count() {
        return None;
    }
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(*v), high.max(*v)));
    let (from, to) = (descriptor.from, descriptor.to);
    // The walks may have gone further than many bodies of a search.
    let is_beyond = high < from || low > to + BEYOND * (to - from);
    let is_narrow = high > low && high - low < NARROW * (to - from);
    // What depends on the motion may be far larger after the whole time.
    let is_of_design = !descriptor.value.any(&mut |e| {
        matches!(&e.kind, ExprKind::At(..) | ExprKind::Term(_))
            || matches!(&e.kind, ExprKind::Attribute(_, attribute) if attribute.is_of_motion())
    });
    let cell = |value: f64| libm::floor((value - from) / (to - from) * descriptor.cells as f64);
    let is_one = is_of_design && high > low && descriptor.cells >= FEW && cell(low) == cell(high);
    if !is_beyond && !is_narrow && !is_one {
        return None;
    }
    let dimension = descriptor.value.ty.dimension().unwrap_or_default();
    let shown = |value: f64| shown(value, dimension);
    Some(
        odd(descriptor.value.span, "all bodies of short motions fall into one cell of this axis".to_owned())
            .label(format!(
                "they have {} .. {}, and the axis goes from {} to {}",
                shown(low),
                shown(high),
                shown(from),
                shown(to)
            ))
            .help("choose the ends of the axis so that the bodies of the grammar spread over its cells"),
    )
}
