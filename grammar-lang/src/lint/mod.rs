//! Checks of a whole rule set that need no design. One file each.

mod against_requirements;
mod always_zero;
mod bad_schedule;
mod bad_spread;
mod below;
mod best_world;
mod beyond_bend;
mod both_sides;
mod circles;
mod clash;
mod constant_aim;
mod constant_if;
mod constant_requirement;
mod constant_set;
mod counted;
mod counts;
mod cycles;
mod empty_choice;
mod empty_for_all;
mod endless;
mod example_outside;
mod excludes_nothing;
mod fast_spin;
mod few_channels;
mod first_of_several;
mod fronts;
mod given_to_one;
mod heights;
mod instances;
mod known;
mod learner_times;
mod little_turn;
mod measured_feature;
mod mixed_axes;
mod near_zero;
mod negative_weight;
mod never_applies;
mod never_drawn;
mod never_given;
mod never_matches;
mod never_turns;
mod no_grip;
mod no_possible_value;
mod no_room;
mod no_spread;
mod no_such_param;
mod no_such_port;
mod no_value;
mod noise;
mod nothing_drawn;
mod nothing_to_search;
mod odd_angles;
mod odd_axle;
mod odd_search;
mod odd_size;
mod odd_turns;
mod of_parts;
mod open_curve;
mod open_cycle;
mod other_joint;
mod out_of_range;
mod out_of_reach;
mod outside_lattice;
mod outside_motion;
mod over_nothing;
mod periods;
mod places;
mod pointless;
mod rewarded;
mod rival_preferences;
mod said_twice;
mod same_patterns;
mod same_port;
mod says_nothing;
mod soft_cells;
mod still_drive;
mod stops_at_once;
mod thick;
mod too_strong;
mod twice_in_set;
mod uneven_thread;
mod unmade;
mod unread;
mod unusual;
mod weak;
mod whole_cycles;
mod whole_turns;
mod worlds;

pub use fast_spin::MOST as MOST_TURN;

use std::collections::BTreeSet;

use crate::bounds::Begun;
use crate::diagnostics::Diagnostic;
use crate::eval::Budget;
use crate::ir::RuleSet;
use crate::source::{FileId, Span};

use known::Known;

type Lint = fn(&Known<'_>, &mut Vec<Diagnostic>);

/// What makes a grammar unusable, as far as it can be evaluated as it stands.
const EXACT: &[Lint] = &[
    never_matches::check,
    constant_requirement::check,
    empty_choice::check,
    no_value::check,
    example_outside::check,
    worlds::check,
    unmade::check,
];

/// What makes a grammar unusable whatever the design. A port that is not there
/// comes before the condition that asks for it.
const SOUND: &[Lint] = &[
    no_such_port::check,
    no_such_param::check,
    other_joint::check,
    never_applies::check,
    out_of_reach::check,
    nothing_drawn::check,
    negative_weight::check,
    clash::check,
    bad_schedule::check,
    bad_spread::check,
    fronts::check,
    outside_motion::check,
    outside_lattice::check,
    empty_for_all::check,
    no_possible_value::check,
];

/// What was probably not meant.
const DOUBTFUL: &[Lint] = &[
    never_drawn::check,
    below::check,
    odd_size::check,
    odd_search::check,
    learner_times::check,
    rewarded::check,
    noise::check,
    whole_cycles::check,
    measured_feature::check,
    no_room::check,
    endless::check,
    nothing_to_search::check,
    twice_in_set::check,
    few_channels::check,
    out_of_range::check,
    of_parts::check,
    unread::check,
    weak::check,
    unusual::check,
    beyond_bend::check,
    near_zero::check,
    no_spread::check,
    periods::check,
    little_turn::check,
    uneven_thread::check,
    open_curve::check,
    both_sides::check,
    counted::check,
    odd_angles::check,
    constant_aim::check,
    over_nothing::check,
    stops_at_once::check,
    whole_turns::check,
    no_grip::check,
    no_grip::slopes,
    still_drive::check,
    never_turns::check,
    against_requirements::check,
    first_of_several::check,
    said_twice::check,
    best_world::check,
    fast_spin::check,
    given_to_one::check,
    mixed_axes::check,
    odd_axle::check,
    open_cycle::check,
    odd_turns::check,
    thick::check,
    too_strong::check,
    soft_cells::check,
    heights::check,
    same_patterns::check,
    constant_set::check,
    same_port::check,
    still_drive::grows,
];

/// What says nothing. A text that several grammars share may say in one of them
/// what it does not say in another: only the text that declares the grammar is told.
const POINTLESS: &[Lint] = &[
    pointless::check,
    constant_if::check,
    excludes_nothing::check,
    rival_preferences::check,
    always_zero::check,
    says_nothing::check,
    never_given::check,
];

/// Whose a rule set is.
#[derive(Clone, Copy)]
pub struct Own {
    /// The text that declares the grammar.
    pub entry: FileId,
    /// Whether it is a variant of another.
    pub is_varied: bool,
}

/// Runs every check; later ones only where those before found no error. More is found where it is known how many parts of each kind
/// the initial design has: with the images that the symmetry makes, which only whoever builds the design can tell.
pub fn run(
    ruleset: &RuleSet,
    begun: Option<&Begun>,
    own: Own,
    budget: &Budget,
    findings: &mut Vec<Diagnostic>,
) {
    let stop = |findings: &[Diagnostic]| findings.iter().any(Diagnostic::is_error);
    circles::check(ruleset, findings);
    // The others evaluate: not in circles.
    if stop(findings) {
        return;
    }
    let known = Known::new(ruleset, begun, budget);
    for lints in [EXACT, SOUND, DOUBTFUL] {
        if stop(findings) {
            return;
        }
        lints.iter().for_each(|lint| lint(&known, findings));
    }
    if !own.is_varied && !stop(findings) {
        let mut found = Vec::new();
        POINTLESS.iter().for_each(|lint| lint(&known, &mut found));
        findings.extend(found.into_iter().filter(|d| d.span().file == own.entry));
    }
    once(findings);
}

/// Tells everything once: what a rule repeats is looked at more than once.
fn once(findings: &mut Vec<Diagnostic>) {
    let mut told = BTreeSet::new();
    findings.retain(|finding| {
        let Span { file, start, end } = finding.span();
        told.insert((finding.code.id, file, start, end, finding.message.clone()))
    });
}
