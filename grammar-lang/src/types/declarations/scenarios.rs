//! Checks scenarios: in what worlds differ, and how many there are.

use indexmap::IndexMap;

use super::Declarations;
use super::fields::{Fields, Values};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{Difference, Scenarios, Ty};
use crate::source::Span;
use crate::syntax::ast::{Block, Field, ItemKind, Name};
use crate::syntax::declarations::BlockKind;
use crate::types::expressions::context::Context;
use crate::types::expressions::stage::Stage;

/// What may differ between worlds.
const DIFFERENCES: [&str; Difference::ALL.len()] = {
    let mut names = [""; Difference::ALL.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = Difference::ALL[i].text();
        i += 1;
    }
    names
};

const CASE: Fields<'static> = Fields::values(&DIFFERENCES);

/// A case as it may stand in a text.
const EXAMPLE: &str = "case ice { ground_friction = 0.2 }";

/// Worlds in which all factors are below this are no likely ones.
const LEAST_FACTOR: f64 = 0.2;

/// Fewer drawn worlds than this say little.
const FEW_DRAWN: f64 = 4.0;

/// What stands for the world that nothing differs in.
const NOMINAL: &str = "nominal";

impl Declarations<'_> {
    /// Whether a name is that of a set of worlds.
    pub(super) fn set_of_worlds(&mut self, name: &Name) -> bool {
        let is_set = |kind: &ItemKind| matches!(kind, ItemKind::Block(BlockKind::Scenarios, _));
        self.named(name, "scenarios", is_set).is_some()
    }

    pub(super) fn scenarios(&mut self, block: &Block, damaged: bool) -> Option<Scenarios> {
        let is_case = |field: &&Field| matches!(field, Field::Group(group) if group.name.text == "case");
        let all = [&DIFFERENCES[..], &["drawn", "case"]].concat();
        let allowed = Fields { all: &all, blocks: &["case"] };
        if let Some(word) = &block.method {
            self.no_method(&block.name, word);
        }
        let plain = block.fields.iter().filter(|field| !is_case(field));
        let from = self.values_among(block, plain, "a set of worlds", allowed);
        let cases = self.cases(block.fields.iter().filter(is_case), &from, damaged);
        let mut ranges = IndexMap::new();
        let mut is_sound = true;
        for difference in Difference::ALL {
            let Some((_, tree)) = from.values.get(difference.text()) else { continue };
            let known = self.expressions.errors.len();
            let ty = Ty::Domain(Box::new(difference.into()));
            let mut cx = Context::new(Stage::Declaration, damaged);
            let what = format!("`{}`", difference.text());
            let expr = self.expressions.expect(tree, &mut cx, &ty, &what);
            self.show_example(known, tree.span, difference.text(), difference.example());
            let range = self.expressions.constant_range(&expr);
            let range = range.filter(|range| self.within(difference, *range, tree.span));
            is_sound &= range.is_some();
            let is_factor = Ty::from(difference) == Ty::NUMBER && difference != Difference::GroundFriction;
            if let Some((_, high)) = range
                && is_factor
                && high < LEAST_FACTOR
            {
                self.far_less(difference, high, tree.span);
            }
            if let Some((_, high)) = range {
                self.usual(from.what, difference.text(), high, tree);
            }
            ranges.extend(range.map(|range| (difference, range)));
        }
        let asked = from.values.get("drawn").map(|(_, tree)| tree.span);
        let drawn = match asked {
            Some(place) => self.drawn(&from, place, damaged),
            None => Some(0),
        };
        if damaged || !from.misspelt.is_empty() {
            return None;
        }
        match (from.values.keys().any(|name| *name != "drawn"), asked) {
            (true, None) => self.missing(&from, "drawn", "13", damaged),
            (false, Some(place)) => self.report(
                Diagnostic::new(Code::MISSING_FIELD, place, "there is nothing to draw: no field has a range")
                    .label("all drawn worlds would be alike")
                    .help("add a line such as `mass = 90 % .. 110 %`, or take `drawn` out"),
            ),
            (false, None) if block.fields.is_empty() => self.report(
                Diagnostic::new(
                    Code::MISSING_FIELD,
                    block.name.span,
                    format!("`{}` contains no world other than the nominal one", block.name.text),
                )
                .label("empty")
                .help(format!("add `mass = 90 % .. 110 %  drawn = 13`, or a case: `{EXAMPLE}`")),
            ),
            _ => {}
        }
        let (drawn, cases) = (drawn?, cases?);
        is_sound.then_some(Scenarios { ranges, drawn, cases, span: block.name.span })
    }

    /// Warns of a factor that takes nearly all away: it may be meant as the quantity itself.
    fn far_less(&mut self, difference: Difference, most: f64, place: Span) {
        let name = difference.text();
        let message = format!("`{name}` is far less than it is in the grammar");
        let coefficient = match difference {
            Difference::Friction => "; a coefficient of the ground is `ground_friction`",
            _ => "",
        };
        self.report(
            Diagnostic::new(Code::UNUSUAL, place, message)
                .label(format!("at most {} of it", difference.shown(most)))
                .help(format!(
                    "it is a factor: write for example `{name} = {}`{coefficient}",
                    difference.example()
                )),
        );
    }

    /// How many worlds are drawn.
    fn drawn(&mut self, from: &Values<'_>, place: Span, damaged: bool) -> Option<usize> {
        let cx = Context::new(Stage::Declaration, damaged);
        let drawn = self.number(from, "drawn", Ty::Count, super::fields::Sign::Positive, "13", &cx)?;
        if drawn > Scenarios::MOST as f64 {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    place,
                    format!("at most {} worlds can be drawn", Scenarios::MOST),
                )
                .label("too many")
                .help("each world costs a simulation: 13 are enough for a search, 64 for a test"),
            );
            return None;
        }
        if drawn < FEW_DRAWN
            && let Some((_, tree)) = from.values.get("drawn")
        {
            let message = format!(
                "{drawn} drawn world{} too few to represent all possible worlds",
                if drawn == 1.0 { " is" } else { "s are" }
            );
            self.report(
                Diagnostic::new(Code::UNUSUAL, tree.span, message)
                    .label("a gait that works there may fail in most others")
                    .help("draw 8 or more worlds, or declare these worlds as cases"),
            );
        }
        Some(drawn as usize)
    }

    /// Whether values are among those that a difference can have.
    fn within(&mut self, difference: Difference, (low, high): (f64, f64), place: Span) -> bool {
        let (least, most) = difference.limits();
        if low >= least - 1e-12 && high <= most + 1e-12 {
            return true;
        }
        let (least, most) = (difference.shown(least), difference.shown(most));
        let name = difference.text();
        self.report(
            Diagnostic::new(
                Code::OUT_OF_DOMAIN,
                place,
                format!("`{name}` must lie within {least} .. {most}"),
            )
            .label("outside this range")
            .help(format!("write for example `{name} = {}`", difference.example())),
        );
        false
    }

    fn cases<'b>(
        &mut self,
        blocks: impl Iterator<Item = &'b Field>,
        from: &Values<'_>,
        damaged: bool,
    ) -> Option<IndexMap<String, IndexMap<Difference, f64>>> {
        let mut cases = IndexMap::new();
        let mut names: Vec<&Name> = Vec::new();
        let mut is_sound = true;
        for field in blocks {
            let Field::Group(block) = field else { continue };
            let Some(name) = &block.method else {
                is_sound = false;
                self.report(
                    Diagnostic::new(Code::MISSING_FIELD, block.name.span, "this case has no name")
                        .label("without a name")
                        .help(format!("write for example `{EXAMPLE}`")),
                );
                continue;
            };
            if name.text == NOMINAL {
                is_sound = false;
                self.report(
                    Diagnostic::new(Code::DUPLICATE, name.span, "every set has a world `nominal` already")
                        .label("this name is taken")
                        .help("choose another name: in the nominal world, everything is as the grammar says"),
                );
            }
            if from.values.contains_key(name.text.as_str()) {
                is_sound = false;
                self.report(
                    Diagnostic::new(
                        Code::DUPLICATE,
                        name.span,
                        format!(
                            "drawn worlds of this set differ in `{}`, so a case cannot have this name",
                            name.text
                        ),
                    )
                    .label("this name is taken")
                    .help("choose another name: a variant changes fields and cases by their names"),
                );
            }
            names.push(name);
            let case = self.case(block, name, damaged);
            is_sound &= case.is_some();
            cases.extend(case.map(|case| (name.text.clone(), case)));
        }
        self.distinct(names.into_iter(), "case");
        is_sound.then_some(cases)
    }

    fn case(&mut self, block: &Block, name: &Name, damaged: bool) -> Option<IndexMap<Difference, f64>> {
        let from = self.values_among(block, block.fields.iter(), "a case", CASE);
        if block.fields.is_empty() && !damaged {
            self.report(
                Diagnostic::new(
                    Code::MISSING_FIELD,
                    name.span,
                    format!("the case `{}` does not differ from the nominal world", name.text),
                )
                .label("empty")
                .help(format!("write for example `{EXAMPLE}`")),
            );
        }
        let cx = Context::new(Stage::Declaration, damaged);
        let mut case = IndexMap::new();
        for difference in Difference::ALL {
            if !from.values.contains_key(difference.text()) {
                continue;
            }
            let example = difference.example().split(" .. ").next().unwrap_or_default();
            let (value, place) = self.value(&from, difference.text(), &difference.into(), example, &cx)?;
            let value = value.as_number()?;
            if !self.within(difference, (value, value), place) {
                return None;
            }
            let is_factor = Ty::from(difference) == Ty::NUMBER && difference != Difference::GroundFriction;
            if is_factor && value < LEAST_FACTOR {
                self.far_less(difference, value, place);
            }
            if let (Difference::GroundFriction, Some((_, tree))) =
                (difference, from.values.get(difference.text()))
            {
                self.usual("a set of worlds", difference.text(), value, tree);
            }
            case.insert(difference, value);
        }
        (!case.is_empty() && from.misspelt.is_empty()).then_some(case)
    }
}
