//! What clauses and edits look like, as declarations do: shown where one cannot be read.

use super::declarations::kind;
use super::parser::Rule;

/// Clauses of rules, actuations, tasks, examples and blocks.
const CLAUSES: &[(&str, &str)] = &[
    ("match", "match p : part with free port q"),
    ("choose", "choose n in 3 .. 6"),
    ("when", "when count(part) < 9"),
    ("unless", "unless p is core"),
    ("attach", "attach cube to q"),
    ("set", "set p.turn = 90 deg"),
    ("remove", "remove p"),
    ("replace", "replace p with cube"),
    ("revert", "revert s"),
    ("fill", "fill region(c, 0 .. 3, 0, -1 .. 1) with soft"),
    ("paint", "paint neighbours(c) with soft(grip = true)"),
    ("clear", "clear region(c, 0 .. 3, 0, -1 .. 1)"),
    ("for", "for i in 0 .. 3 { attach cube to core.left[i] as c  attach cube to c.front }"),
    ("if", "if q is left { attach cube to q }"),
    ("then", "then"),
    ("always", "always"),
    ("weight", "weight 2"),
    ("shared", "shared period : Time in 2 s .. 6 s mutate 0.3 by normal(0 s, 1 s)"),
    ("vary", "vary size : Angle in 0 deg .. 90 deg mutate 0.5 by normal(0 deg, 20 deg)"),
    ("state", "state phase : Number from 0 next fraction(phase + control_interval / 2 s)"),
    ("action", "action push : Number in -1 .. 1 of brain from [bent(a) / 60 deg]"),
    ("drive", "drive angle = 30 deg * sin(t / 1 s * 360 deg)"),
    ("place", "place head : cube to core.front"),
    ("step", "step head = grow(p = core, q = core.front)"),
    ("refuse", "refuse grow(p = core, q = core.front)"),
    ("expect", "expect count(part) == 2"),
    ("feature", "feature legs = count(actuator) weight 2"),
    ("known", "known \"Shepherd et al.\" { legs = 4 }"),
    ("param", "param segments : Count in 2 .. 12 = 5"),
    ("joint", "joint = bend about z"),
    ("port", "port left at vector(0 cm, 0 cm, -1 cm) facing vector(0, 0, -1)"),
];

/// Edits of variants.
const EDITS: &[(&str, &str)] = &[
    ("set", "set bender.bend = 0 deg .. 90 deg"),
    ("narrow", "narrow grow.n in 4 .. 5"),
    ("drop", "drop turn_part"),
    ("replace", "replace require few : count(part) <= 9"),
    ("add", "add require light : count(ball) == 0"),
];

/// What a declaration or clause that begins with this word looks like.
pub(super) fn form(entry: Rule, first: &str) -> Option<&'static str> {
    let of =
        |forms: &[(&str, &'static str)]| forms.iter().find(|(word, _)| *word == first).map(|(_, form)| *form);
    let declaration = || kind(first).map(|kind| kind.form);
    match entry {
        // A field may be called like a declaration: `record` of a model.
        Rule::only_field if !["param", "port", "joint"].contains(&first) => None,
        Rule::only_edit => of(EDITS).or_else(declaration).or_else(|| of(CLAUSES)),
        Rule::only_item => declaration().or_else(|| of(CLAUSES)).or_else(|| of(EDITS)),
        _ => of(CLAUSES).or_else(declaration).or_else(|| of(EDITS)),
    }
}

#[cfg(test)]
mod tests {
    use pest::Parser;

    use super::super::declarations::KINDS;
    use super::super::parser::SgrParser;
    use super::*;

    /// What cannot be read ends where a declaration begins, whichever it is.
    #[test]
    fn every_declaration_ends_what_cannot_be_read() {
        for kind in KINDS {
            let text = format!("odd (\n{}", kind.form.replace("{ ... }", "{ }"));
            let file = SgrParser::parse(Rule::file, &text).unwrap().next().unwrap();
            let items = file.into_inner().filter(|pair| pair.as_rule() == Rule::item).count();
            assert_eq!(items, 1, "`{}` is not in `item_word`: {text}", kind.word);
        }
    }

    #[test]
    fn what_is_shown_can_be_read() {
        let read = |entry, form: &str| {
            let form = form.replace("{ ... }", "{ }");
            assert!(SgrParser::parse(entry, &form).is_ok(), "{form}");
        };
        for kind in KINDS {
            read(Rule::only_item, kind.form);
        }
        for (_, form) in EDITS {
            read(Rule::only_edit, form);
        }
        for (word, form) in CLAUSES {
            let entry = match *word {
                "shared" | "vary" | "state" | "action" | "drive" => Rule::only_actuation,
                "place" => Rule::only_begin,
                "step" | "refuse" | "expect" => Rule::only_example,
                "feature" | "known" => Rule::only_novelty,
                "param" | "port" | "joint" => Rule::only_field,
                _ => Rule::only_rule,
            };
            read(entry, form);
        }
    }
}
