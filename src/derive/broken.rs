//! Why a design breaks a requirement.

use grammar_lang::eval::{Reference, Value, evaluate};
use grammar_lang::ir::{DesignWord, Expr, ExprKind, Gather, Operator, Rule, RuleSet, Word};
use grammar_lang::units;

use super::{Derivation, DesignScope};
use crate::design::PartId;

impl Derivation {
    /// The design that a rule makes, whatever requirements it breaks.
    fn unchecked(&self, rules: &RuleSet, rule: &Rule, locals: &[Value]) -> Option<Self> {
        let mut next = self.clone();
        self.carry_out(&mut next, rules, &rule.effects, locals, self.next).ok()?;
        next.carry_out_always(rules).ok()?;
        Some(next)
    }

    /// What the requirement that a rule would break compares, if it does: what that is, and what it must be.
    #[must_use]
    pub fn would_be(&self, rules: &RuleSet, rule: &Rule, locals: &[Value], broken: usize) -> Option<String> {
        let next = self.unchecked(rules, rule, locals)?;
        let (is, must) = compared(rules, &next, &rules.requirements.get(broken)?.condition)?;
        Some(format!("it is {is}, and must be {must}"))
    }

    /// The kinds of two parts that would overlap if a rule were applied, where a requirement asks that none do.
    #[must_use]
    pub fn would_overlap(
        &self,
        rules: &RuleSet,
        rule: &Rule,
        locals: &[Value],
        broken: usize,
    ) -> Option<String> {
        let next = self.unchecked(rules, rule, locals)?;
        let (first, second) = next.overlap(rules, broken)?;
        let (a, b) = (next.design.parts.get(&first)?, next.design.parts.get(&second)?);
        let bent =
            a.begins_bent().or_else(|| b.begins_bent()).map_or_else(String::new, |bent| format!("; {bent}"));
        let its_image =
            a.image_of.is_some_and(|of| b.image_of == Some(of) || of == second) || b.image_of == Some(first);
        let other = if its_image { "its image".to_owned() } else { format!("`{}`", b.kind) };
        Some(format!("`{}` and {other}{bent}", a.kind))
    }

    /// Two parts that overlap, where a requirement asks that none do.
    #[must_use]
    pub fn overlap(&self, rules: &RuleSet, broken: usize) -> Option<(PartId, PartId)> {
        let asks = |e: &Expr| matches!(&e.kind, ExprKind::Word(Word::Design(DesignWord::NoOverlap)));
        rules.requirements.get(broken)?.condition.any(&mut |e| asks(e)).then_some(())?;
        self.design.overlapping(rules)
    }
}

/// What the left side of a comparison is for a design, and what it must be. Of several conditions, the first that does not hold counts; of
/// a condition on each of some parts, the first part for which it does not hold.
pub(super) fn compared(rules: &RuleSet, design: &Derivation, condition: &Expr) -> Option<(String, String)> {
    within(&DesignScope::new(rules, design), condition, &mut Vec::new())
}

fn within(scope: &DesignScope<'_>, condition: &Expr, locals: &mut Vec<Value>) -> Option<(String, String)> {
    let holds =
        |e: &Expr, locals: &mut Vec<Value>| evaluate(e, scope, locals).is_ok_and(|v| v == Value::Bool(true));
    match &condition.kind {
        ExprKind::Binary(a, Operator::And, b) => {
            let broken = if holds(a, locals) { b } else { a };
            within(scope, broken, locals)
        }
        ExprKind::Aggregate { how: Gather::Forall, binders, condition, body: Some(body), .. } => {
            let [binder] = binders.as_slice() else { return None };
            let over = evaluate(&binder.over, scope, locals).ok()?;
            for item in over.items() {
                locals.truncate(binder.slot);
                locals.push(item.clone());
                let counts = condition.as_ref().is_none_or(|condition| holds(condition, locals));
                if counts && !holds(body, locals) {
                    let (is, must) = within(scope, body, locals)?;
                    let Value::Reference(Reference::Part(id)) = item else { return Some((is, must)) };
                    let kind = &scope.design().parts.get(id)?.kind;
                    return Some((format!("{is} for one `{kind}`"), must));
                }
            }
            None
        }
        ExprKind::Binary(left, operator, right) => {
            let must = match operator {
                Operator::Less => "less than ",
                Operator::LessEqual => "at most ",
                Operator::Greater => "more than ",
                Operator::GreaterEqual => "at least ",
                Operator::Equal => "",
                _ => return None,
            };
            let mut shown = |side: &Expr| {
                let number = evaluate(side, scope, locals).ok()?.as_number()?;
                Some(units::shown(number, side.ty.dimension()?))
            };
            Some((shown(left)?, format!("{must}{}", shown(right)?)))
        }
        _ => None,
    }
}
