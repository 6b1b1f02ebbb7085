//! Policies of two sides that know what changes its sign in the mirror as if it did not.

use crate::diagnostics::{Code, Diagnostic};

use super::known::Known;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for policy in known.ruleset.policies.values().filter(|policy| policy.mirrored.is_some()) {
        let wrong = policy.inputs.iter().find(|input| known.ruleset.knows_a_side(input));
        findings.extend(wrong.map(|input| {
            Diagnostic::new(Code::UNUSUAL, input.span, "a heading changes its sign in the mirror")
                .label("here both sides know it alike")
                .help("move it from `inputs` to `mirrored`")
        }));
    }
}
