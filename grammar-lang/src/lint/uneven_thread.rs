//! Tables of threads that are much steeper in one place than in another: a length or an angle with the wrong unit.

use crate::diagnostics::{Code, Diagnostic};
use crate::ir::Backend;
use crate::units::{Dimension, shown};

use super::known::Known;

/// A thread that is measured is not so many times as steep in one place as in another.
const UNEVEN: f64 = 20.0;

pub(super) fn check(known: &Known<'_>, findings: &mut Vec<Diagnostic>) {
    for (name, target) in &known.ruleset.targets {
        let Backend::Tendon(threads) = &target.backend else { continue };
        let steps = threads.thread.rows.windows(2).map(|pair| {
            let [[from, short], [to, long]] = [pair[0], pair[1]];
            (((long - short) / (to - from)).abs(), (from, to))
        });
        let least = steps.clone().min_by(|a, b| a.0.total_cmp(&b.0));
        let most = steps.max_by(|a, b| a.0.total_cmp(&b.0));
        let Some(((flat, level), (steep, slope))) = least.zip(most) else { continue };
        if steep > UNEVEN * flat {
            let between = |(from, to): (f64, f64)| {
                format!("{} and {}", shown(from, Dimension::ANGLE), shown(to, Dimension::ANGLE))
            };
            findings.push(
                Diagnostic::new(
                    Code::UNUSUAL,
                    target.span,
                    format!(
                        "the thread of `{name}` is {:.0} times as steep in one place as in another",
                        steep / flat
                    ),
                )
                .label(format!("steep between {}, flat between {}", between(slope), between(level)))
                .help("do all rows of its table have the right unit?"),
            );
        }
    }
}
