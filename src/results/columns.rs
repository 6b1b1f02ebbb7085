//! Names of the columns of a table, of which no two are the same.

/// What the name of an observed term begins with, where a column of its name stands in the table already.
pub(super) const OBSERVED: &str = "observed ";
/// The same for a descriptor.
pub(super) const DESCRIPTOR: &str = "descriptor ";

/// A name, unless the table has a column of that name: then with what it is of before it.
pub(super) fn distinct<'t>(name: &str, of: &str, taken: impl IntoIterator<Item = &'t str>) -> String {
    if taken.into_iter().any(|other| other == name) { format!("{of}{name}") } else { name.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_is_taken_says_what_it_is_of() {
        assert_eq!(distinct("height", OBSERVED, ["move", "value"]), "height");
        assert_eq!(distinct("value", OBSERVED, ["move", "value"]), "observed value");
    }
}
