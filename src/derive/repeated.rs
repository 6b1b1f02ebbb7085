//! Effects that are repeated: `for i in 0 .. 3`, `for w in wheel`.

use std::sync::atomic::AtomicU64;

use grammar_lang::eval::{EvalError, Reference, Value, evaluate};
use grammar_lang::ir::{Binder, Effect, ExprKind, MadeList};

use super::{Blocked, DesignScope};
use crate::design::PartId;

/// A step that is being carried out.
pub(super) struct UnderWay<'e> {
    /// Its number.
    pub(super) step: u64,
    /// How often something may still be repeated.
    pub(super) room: usize,
    /// Whether an effect has begun: until then, the design is that before the step.
    pub(super) begun: bool,
    /// The effects that make parts.
    pub(super) makers: Vec<&'e Effect>,
    /// What was made so far, with the number of the effect that made it.
    pub(super) made: Vec<(usize, PartId)>,
    /// How many operations all its expressions may still take together.
    pub(super) left: &'e AtomicU64,
}

impl<'e> UnderWay<'e> {
    /// A step that begins, with its effects.
    pub(super) fn new(step: u64, effects: &'e [Effect], left: &'e AtomicU64) -> Self {
        Self { step, room: 0, begun: false, makers: Effect::makers(effects), made: Vec::new(), left }
    }

    /// The lists of what a block has made: all that was made since there were `before` parts.
    pub(super) fn lists(
        &self,
        effects: &[Effect],
        lists: &[MadeList],
        before: usize,
        locals: &[Value],
    ) -> Vec<Value> {
        let own = Effect::makers(effects);
        let is_first = |maker: &&Effect| own.first().is_some_and(|first| std::ptr::eq(*maker, *first));
        let first = self.makers.iter().position(is_first).unwrap_or(0);
        let made = self.made.get(before..).unwrap_or(&[]);
        let list = |list: &MadeList| {
            let earlier =
                list.after.and_then(|slot| locals.get(slot)).map_or(&[][..], |earlier| earlier.items());
            let is_its = |(maker, _): &&(usize, PartId)| list.makers.iter().any(|own| first + own == *maker);
            let parts = made.iter().filter(is_its).map(|(_, part)| Value::Reference(Reference::Part(*part)));
            Value::List(earlier.iter().cloned().chain(parts).collect())
        };
        lists.iter().map(list).collect()
    }
}

/// How often what an effect says may be repeated, all blocks within each other together.
pub(super) const MOST: usize = 1000;

/// What is done each time, with the locals.
type Act<'a, 'e> = dyn FnMut(&mut Vec<Value>, &mut UnderWay<'e>) -> Result<(), Blocked> + 'a;

/// Does something once for everything that effects are repeated for; each time the locals end with what the binders hold.
pub(super) fn each<'e>(
    over: &[Binder],
    scope: &DesignScope<'_>,
    locals: &mut Vec<Value>,
    under_way: &mut UnderWay<'e>,
    act: &mut Act<'_, 'e>,
) -> Result<(), Blocked> {
    let depth = locals.len();
    let done = within(over, scope, locals, under_way, act);
    locals.truncate(depth);
    done
}

fn within<'e>(
    over: &[Binder],
    scope: &DesignScope<'_>,
    locals: &mut Vec<Value>,
    under_way: &mut UnderWay<'e>,
    act: &mut Act<'_, 'e>,
) -> Result<(), Blocked> {
    let Some((binder, rest)) = over.split_first() else { return act(locals, under_way) };
    let too_many = || {
        let reason = format!("an effect is repeated more than {MOST} times");
        Blocked::from(EvalError { span: binder.over.span, reason })
    };
    let values: Vec<Value> = match evaluate(&binder.over, scope, locals)? {
        Value::Domain(domain) if domain.count() > under_way.room => return Err(too_many()),
        Value::Domain(domain) => domain.items().collect(),
        // What is written out is meant as it stands.
        list if matches!(binder.over.kind, ExprKind::List(_)) => list.items().to_vec(),
        list => originals(list.items(), scope),
    };
    for value in values {
        under_way.room = under_way.room.checked_sub(1).ok_or_else(too_many)?;
        locals.truncate(binder.slot);
        locals.resize(binder.slot, Value::Bool(false));
        locals.push(value);
        within(rest, scope, locals, under_way, act)?;
    }
    Ok(())
}

/// Without the images of parts that are among them, too: what is done to a part is done to its images.
fn originals(values: &[Value], scope: &DesignScope<'_>) -> Vec<Value> {
    let part = |value: &Value| match value {
        Value::Reference(Reference::Part(id)) => Some(*id),
        _ => None,
    };
    let original = |value: &Value| scope.design().parts.get(&part(value)?)?.image_of;
    let is_there = |id| values.iter().any(|other| part(other) == Some(id));
    values.iter().filter(|value| !original(value).is_some_and(is_there)).cloned().collect()
}
