//! The `sgc` grammar language.
