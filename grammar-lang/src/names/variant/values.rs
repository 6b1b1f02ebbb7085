//! Values within declarations that a variant sets or narrows: by a path, such as `bender.bend`.

use super::super::Loading;
use super::change::Change;
use super::unchanged::{self, Unchanged};
use super::{find, scenarios};
use crate::diagnostics::{Code, Diagnostic, Fix, did_you_mean};
use crate::source::Span;
use crate::syntax::ast::{
    Block, Expr, ExprKind, Field, Item, ItemKind, Joint, Name, NoveltyClause, RuleClause, RuleClauseKind,
};
use crate::syntax::declarations::BlockKind;
use crate::syntax::earlier;

/// Sets or narrows what a path names. If that leaves the value as it is, what there is to say of it.
pub(super) fn change(
    loading: &mut Loading<'_>,
    module: usize,
    path: &[Name],
    change: Change<'_>,
) -> Option<Unchanged> {
    let (head, rest) = path.split_first()?;
    let declaration = find(loading, module, head)?;
    let item = loading.program.item_mut(declaration)?;
    if let (ItemKind::Require { .. }, [], ExprKind::Range(..) | ExprKind::Quantity(..)) =
        (&item.kind, rest, &change.expr().kind)
    {
        let name = &head.text;
        loading.errors.push(
            Diagnostic::new(Code::WRONG_TYPE, head.span, format!("`{name}` is a requirement, not a number"))
                .label(format!("its condition, to {}", change.word()))
                .also(item.span, "declared here")
                .help(format!("write `replace require {name} : ...`, or make its limit a `param`")),
        );
        return None;
    }
    let is_search = matches!(item.kind, ItemKind::Block(BlockKind::Search, _));
    let told = match &change {
        Change::Set(new) => unchanged::check(item, path, new),
        Change::Narrow(_) => None,
    };
    let outcome = change_item(item, rest, &change);
    if let Err(mut offers) = outcome {
        // A part has one of the two, and may get the other in its place.
        for (given, other) in [("density", "mass"), ("mass", "density")] {
            if offers.iter().any(|o| o == given) && offers.iter().all(|o| o != other) {
                offers.push(other.to_owned());
            }
        }
        if let Some(told) = earlier_path(rest).filter(|_| is_search) {
            loading.errors.push(told);
            return None;
        }
        let last = path.last().unwrap_or(head);
        let whole: Vec<&str> = path.iter().map(|n| n.text.as_str()).collect();
        let within = rest
            .split_last()
            .map_or(String::new(), |(_, before)| before.iter().map(|n| format!("{}.", n.text)).collect());
        let near = offers.iter().filter_map(|o| o.strip_prefix(within.as_str()));
        let help = did_you_mean(&last.text, near).unwrap_or_else(|| {
            if offers.is_empty() {
                format!("only the whole of `{}` can be changed: write `replace ...`", head.text)
            } else {
                let offers: Vec<String> = offers.iter().map(|o| format!("{}.{o}", head.text)).collect();
                format!("you can change: {}", offers.join(", "))
            }
        });
        loading.errors.push(
            Diagnostic::new(
                Code::NOTHING_TO_CHANGE,
                last.span,
                format!("there is no `{}` to {}", whole.join("."), change.word()),
            )
            .label("not there")
            .help(help),
        );
    }
    let module = loading.program.modules.get(declaration.module).map(|module| module.name.clone());
    told.map(|told| Unchanged {
        is_library: module.is_some_and(|module| loading.loader.library().contains(&module)),
        told,
    })
}

/// Gives the rows of an actuator, or a part, another joint.
pub(super) fn set_joint(loading: &mut Loading<'_>, module: usize, path: &[Name], joint: &Joint) {
    let Some(head) = path.first() else { return };
    let Some(declaration) = find(loading, module, head) else { return };
    let Some(item) = loading.program.item_mut(declaration) else { return };
    if !matches!(item.kind, ItemKind::Block(BlockKind::Part | BlockKind::Actuator, _)) {
        loading.errors.push(
            Diagnostic::new(Code::NOTHING_TO_CHANGE, joint.word, format!("`{}` has no joint", head.text))
                .label("not there")
                .also(item.span, "declared here")
                .help("only an actuator, or a part that is attached by a joint, has one"),
        );
        return;
    }
    if let Some(block) = item.kind.block_mut() {
        replace_joint(block, Field::Joint(Box::new(joint.clone())));
    }
}

/// A block's joint, whichever way it is written, is another one.
fn replace_joint(block: &mut Block, joint: Field) {
    let is_joint = |field: &Field| match field {
        Field::Value(name, _) => name.text == JOINT,
        Field::Joint(_) => true,
        _ => false,
    };
    match block.fields.iter().position(is_joint) {
        Some(place) => block.fields[place] = joint,
        None => block.fields.push(joint),
    }
}

/// A path into a search that was right in an earlier version.
fn earlier_path(rest: &[Name]) -> Option<Diagnostic> {
    let (group, within) = rest.split_first()?;
    let now = earlier::loop_now(&group.text)?;
    let mut fix = Fix::replace(group.span, now, format!("write `{now}`"));
    match within {
        [block, field, ..] if block.text == earlier::EVOLUTION => {
            fix = fix.and(Span { end: field.span.start, ..block.span }, "");
        }
        [block, ..] if block.text == earlier::DESCRIPTORS => fix = fix.and(block.span, "descriptors"),
        _ => {}
    }
    Some(
        Diagnostic::new(Code::NOTHING_TO_CHANGE, group.span, format!("a search has no `{}`", group.text))
            .label(format!("it is called `{now}` now"))
            .help(format!("write `{now}`"))
            .fix(fix),
    )
}

/// Changes a part of a declaration; if there is no such part, says which there are.
fn change_item(item: &mut Item, rest: &[Name], change: &Change<'_>) -> Result<(), Vec<String>> {
    match (&mut item.kind, rest) {
        (ItemKind::Param(param), []) => {
            match change {
                Change::Set(value) => param.default = Some((*value).clone()),
                Change::Narrow(value) => {
                    param.domain =
                        Some(param.domain.as_ref().map_or((*value).clone(), |old| change.make(old)));
                }
            }
            Ok(())
        }
        (
            ItemKind::Let(_, None, value)
            | ItemKind::Pattern(_, value)
            | ItemKind::Term(_, _, value)
            | ItemKind::Require { condition: value, .. },
            [],
        ) => {
            *value = change.make(value);
            Ok(())
        }
        (ItemKind::Sense(sense), []) => {
            sense.value = change.make(&sense.value);
            Ok(())
        }
        (ItemKind::Sense(sense), [field]) => {
            let field = match field.text.as_str() {
                "noise" => &mut sense.noise,
                "delay" => &mut sense.delay,
                _ => return Err(vec!["noise".to_owned(), "delay".to_owned()]),
            };
            *field = Some(match field.as_ref() {
                Some(old) => change.make(old),
                None => change.expr().clone(),
            });
            Ok(())
        }
        (ItemKind::State(of_body), [field]) => {
            let state = &mut of_body.state;
            let field = match field.text.as_str() {
                "from" => &mut state.from,
                "next" => &mut state.next,
                _ => return Err(vec!["from".to_owned(), "next".to_owned()]),
            };
            *field = change.make(field);
            Ok(())
        }
        (ItemKind::Shared(variable), []) => {
            variable.domain = Some(match &variable.domain {
                Some(old) => change.make(old),
                None => change.expr().clone(),
            });
            Ok(())
        }
        (ItemKind::Prefer { weight, .. }, [field]) if field.text == "weight" => {
            *weight = change.make(weight);
            Ok(())
        }
        (ItemKind::Prefer { condition, .. }, []) => {
            *condition = change.make(condition);
            Ok(())
        }
        (ItemKind::Rule(_, clauses), [field]) => change_rule(clauses, field, change),
        (ItemKind::Novelty(_, clauses), rest) => change_novelty(clauses, rest, change),
        (ItemKind::Block(BlockKind::Scenarios, set), rest) => scenarios::change(set, rest, change),
        (ItemKind::Actuation { clauses, .. }, [field]) => {
            let mut names = Vec::new();
            for clause in clauses {
                match clause {
                    crate::syntax::ast::ActuationClause::Variable(v) => {
                        if v.name.text == field.text {
                            v.domain = Some(match &v.domain {
                                Some(old) => change.make(old),
                                None => change.expr().clone(),
                            });
                            return Ok(());
                        }
                        names.push(v.name.text.clone());
                    }
                    crate::syntax::ast::ActuationClause::Let(name, value) => {
                        if name.text == field.text {
                            *value = change.make(value);
                            return Ok(());
                        }
                        names.push(name.text.clone());
                    }
                    crate::syntax::ast::ActuationClause::State(_)
                    | crate::syntax::ast::ActuationClause::Action(_)
                    | crate::syntax::ast::ActuationClause::Drive(..) => {}
                }
            }
            Err(names)
        }
        (ItemKind::Rule(_, clauses), _) => Err(choices_of(clauses)),
        (kind, rest) => match kind.block_mut() {
            Some(block) => change_block(block, rest, change),
            None => Err(Vec::new()),
        },
    }
}

/// Changes a feature of a novelty set, or its weight.
fn change_novelty(
    clauses: &mut [NoveltyClause],
    rest: &[Name],
    change: &Change<'_>,
) -> Result<(), Vec<String>> {
    let mut offers = Vec::new();
    for clause in clauses {
        let NoveltyClause::Feature { name, value, weight } = clause else { continue };
        match rest {
            [wanted] if wanted.text == name.text => {
                *value = change.make(value);
                return Ok(());
            }
            [wanted, field] if wanted.text == name.text && field.text == "weight" => {
                *weight = Some(change.expr().clone());
                return Ok(());
            }
            _ => offers.extend([name.text.clone(), format!("{}.weight", name.text)]),
        }
    }
    Err(offers)
}

fn choices_of(clauses: &[RuleClause]) -> Vec<String> {
    let choices = clauses.iter().filter_map(|c| match &c.kind {
        RuleClauseKind::Choose(name, ..) => Some(name.text.clone()),
        _ => None,
    });
    choices.chain(["weight".to_owned()]).collect()
}

fn change_rule(clauses: &mut Vec<RuleClause>, field: &Name, change: &Change<'_>) -> Result<(), Vec<String>> {
    for clause in clauses.iter_mut() {
        match &mut clause.kind {
            RuleClauseKind::Choose(name, domain, _) if name.text == field.text => {
                *domain = match change {
                    Change::Set(new) => Expr {
                        span: new.span,
                        kind: ExprKind::Exchanged(Box::new((*new).clone()), Box::new(domain.clone())),
                    },
                    Change::Narrow(_) => change.make(domain),
                };
                return Ok(());
            }
            RuleClauseKind::Weight(weight) if field.text == "weight" => {
                *weight = change.make(weight);
                return Ok(());
            }
            _ => {}
        }
    }
    if field.text == "weight" {
        let kind = RuleClauseKind::Weight(change.expr().clone());
        clauses.push(RuleClause { kind, span: change.expr().span });
        return Ok(());
    }
    Err(choices_of(clauses))
}

/// The field that may be written as more than a value.
const JOINT: &str = "joint";

/// Fields that need not be there to be set. In which blocks they mean something, the checker knows.
const MAY_BE_LEFT_OUT: &[&str] = &[
    "sideways",
    "torsion",
    "material",
    "offset",
    "winding",
    "sheet",
    "colour",
    "walk",
    "chains",
    "exchange",
    "side_by_side",
    "warm",
    "restart",
    "judge",
    "checks",
    "keep_with_rods",
    "pace_limit",
    "sensors",
    "neutral",
    "begins",
    "pivot",
    "inputs",
    "mirrored",
    "hidden",
    "every",
    "reward",
    "mutation_chance",
    "mutation_size",
    "critic",
    "entropy",
    "learning_rate",
    "discount",
    "batch",
    "updates",
    "replay",
    "warm_up",
    "target_rate",
    "worlds",
];

fn change_block(block: &mut Block, rest: &[Name], change: &Change<'_>) -> Result<(), Vec<String>> {
    let Some((field, rest)) = rest.split_first() else { return Err(fields_of(block)) };
    for known in &mut block.fields {
        match known {
            Field::Value(name, value) if name.text == field.text && rest.is_empty() => {
                *value = change.make(value);
                return Ok(());
            }
            Field::Group(group) if group.name.text == field.text => {
                return change_block(group, rest, change)
                    .map_err(|offers| offers.into_iter().map(|o| format!("{}.{o}", field.text)).collect());
            }
            Field::Param(param) if param.name.text == field.text && rest.is_empty() => {
                match change {
                    Change::Set(value) => param.default = Some((*value).clone()),
                    Change::Narrow(value) => {
                        param.domain =
                            Some(param.domain.as_ref().map_or((*value).clone(), |old| change.make(old)));
                    }
                }
                return Ok(());
            }
            _ => {}
        }
    }
    if let (JOINT, Change::Set(value), []) = (field.text.as_str(), change, rest) {
        replace_joint(block, Field::Value(field.clone(), (*value).clone()));
        return Ok(());
    }
    // Of mass and density each stands for the other.
    let other = match field.text.as_str() {
        "mass" => Some("density"),
        "density" => Some("mass"),
        _ => None,
    };
    let stands = block.fields.iter().position(|f| match f {
        Field::Value(name, _) => Some(name.text.as_str()) == other,
        _ => false,
    });
    if let (Some(place), Change::Set(value), []) = (stands, change, rest) {
        block.fields.remove(place);
        block.fields.push(Field::Value(field.clone(), (*value).clone()));
        return Ok(());
    }
    if let (true, Change::Set(value), []) = (MAY_BE_LEFT_OUT.contains(&field.text.as_str()), change, rest) {
        block.fields.push(Field::Value(field.clone(), (*value).clone()));
        return Ok(());
    }
    Err(fields_of(block))
}

fn fields_of(block: &Block) -> Vec<String> {
    block
        .fields
        .iter()
        .map(|f| match f {
            Field::Value(name, _) => name.text.clone(),
            Field::Group(group) => group.name.text.clone(),
            Field::Param(param) => param.name.text.clone(),
            Field::Port(port) => port.name.text.clone(),
            Field::Joint(_) => JOINT.to_owned(),
        })
        .collect()
}
