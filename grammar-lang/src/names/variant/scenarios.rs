//! What a variant changes in a set of worlds: fields that the base has or has not, cases by their names.

use super::change::Change;
use crate::syntax::ast::{Block, Field, Name};

/// What a field of the set is called in a path: a case by its own name.
fn called(field: &Field) -> Option<&str> {
    match field {
        Field::Value(name, _) => Some(&name.text),
        Field::Group(group) => Some(&group.method.as_ref().unwrap_or(&group.name).text),
        Field::Param(_) | Field::Port(_) | Field::Joint(_) => None,
    }
}

/// Changes a field or one of a case; a field that is not there yet is set. If there is no such thing, says which there are.
pub(super) fn change(set: &mut Block, rest: &[Name], change: &Change<'_>) -> Result<(), Vec<String>> {
    match rest {
        [field] => change_field(&mut set.fields, field, change),
        [case, field] => {
            let found = set.fields.iter_mut().find_map(|f| match f {
                Field::Group(group) if group.method.as_ref().is_some_and(|m| m.text == case.text) => {
                    Some(group)
                }
                _ => None,
            });
            let Some(group) = found else { return Err(offers(set)) };
            change_field(&mut group.fields, field, change)
                .map_err(|fields| fields.into_iter().map(|field| format!("{}.{field}", case.text)).collect())
        }
        _ => Err(offers(set)),
    }
}

/// What the fields may be, the checker knows.
fn change_field(fields: &mut Vec<Field>, field: &Name, change: &Change<'_>) -> Result<(), Vec<String>> {
    for known in fields.iter_mut() {
        if let Field::Value(name, value) = known
            && name.text == field.text
        {
            *value = change.make(value);
            return Ok(());
        }
    }
    match change {
        Change::Set(value) => {
            fields.push(Field::Value(field.clone(), (*value).clone()));
            Ok(())
        }
        Change::Narrow(_) => Err(fields.iter().filter_map(called).map(str::to_owned).collect()),
    }
}

/// Takes out a field or a case. If there is no such thing, says which there are.
pub(super) fn drop(set: &mut Block, name: &Name) -> Result<(), Vec<String>> {
    let before = set.fields.len();
    set.fields.retain(|field| called(field) != Some(&name.text));
    if set.fields.len() < before { Ok(()) } else { Err(offers(set)) }
}

fn offers(set: &Block) -> Vec<String> {
    let one = |field: &Field| match field {
        Field::Group(group) => {
            let name = called(field)?.to_owned();
            let first = group.fields.iter().find_map(called)?;
            Some(format!("{name}.{first}"))
        }
        field => called(field).map(str::to_owned),
    };
    set.fields.iter().filter_map(one).collect()
}
