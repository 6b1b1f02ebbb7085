//! The `sgc` program.

fn main() {}
