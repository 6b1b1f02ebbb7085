//! Effects that are repeated: `for i in 0 .. 3`, `for w in wheel`.

use grammar_lang::eval::{EvalError, Reference, Value, evaluate};
use grammar_lang::ir::Binder;

use super::DesignScope;

/// How often an effect may be repeated, all its binders together.
const MOST: usize = 1000;

/// Does something once for everything that an effect is repeated for; each time the locals end with what the binders hold.
pub(super) fn each<E: From<EvalError>>(
    over: &[Binder],
    scope: &DesignScope<'_>,
    locals: &mut Vec<Value>,
    act: &mut dyn FnMut(&mut Vec<Value>) -> Result<(), E>,
) -> Result<(), E> {
    let depth = locals.len();
    let done = within(over, scope, locals, MOST, act);
    locals.truncate(depth);
    done
}

/// The same for `room` values at most.
fn within<E: From<EvalError>>(
    over: &[Binder],
    scope: &DesignScope<'_>,
    locals: &mut Vec<Value>,
    room: usize,
    act: &mut dyn FnMut(&mut Vec<Value>) -> Result<(), E>,
) -> Result<(), E> {
    let Some((binder, rest)) = over.split_first() else { return act(locals) };
    let values: Vec<Value> = match evaluate(&binder.over, scope, locals)? {
        Value::Domain(domain) if domain.count() > room => {
            let reason = format!("an effect is repeated more than {MOST} times");
            return Err(EvalError { span: binder.over.span, reason }.into());
        }
        Value::Domain(domain) => domain.items().collect(),
        list => originals(list.items(), scope),
    };
    let room = room / values.len().max(1);
    for value in values {
        locals.truncate(binder.slot);
        locals.resize(binder.slot, Value::Bool(false));
        locals.push(value);
        within(rest, scope, locals, room, act)?;
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
