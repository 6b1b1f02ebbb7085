//! What earlier versions of the language called things: texts that have it get an error with a fix.
//!
//! A loop of a search was `outer` or `inner`. What it searched by was said by a block in it, `archive` or `cma_es`, or by
//! a temperature.

/// The block within a loop whose fields stand in the loop itself now.
pub(crate) const EVOLUTION: &str = "cma_es";
/// The block within a loop that is called `descriptors` now.
pub(crate) const DESCRIPTORS: &str = "archive";

/// What a loop of a search is called now that was called so.
pub(crate) fn loop_now(name: &str) -> Option<&'static str> {
    match name {
        "outer" => Some("bodies"),
        "inner" => Some("curves"),
        _ => None,
    }
}
