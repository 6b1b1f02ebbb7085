//! A loop of a search that stops, or begins anew, after each iteration.

use crate::bounds::Truth;
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::ExprKind;

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (schedule, _) in known.ruleset.search.loops() {
        let stop = &schedule.stop;
        let is_always = known.reasoning(&[]).truth(stop) == Truth::Always;
        // A plain `true` is meant.
        if is_always && !matches!(stop.kind, ExprKind::Bool(_)) {
            findings.push(
                Diagnostic::new(Code::POINTLESS, stop.span, "the search stops after one iteration")
                    .label("this always holds")
                    .help("write `stop = false` to go on as long as `iterations` says"),
            );
        }
    }
}
