//! The `sgc` program.

fn main() {
    let path = std::env::args().nth(1).unwrap_or_default();
    let mut sources = grammar_lang::source::SourceMap::default();
    let text = sgc::world::read_text(std::path::Path::new(&path)).unwrap_or_default();
    let entry = sources.add(path, text);
    let out = grammar_lang::compile(&sgc::world::Files, &mut sources, entry, &[]);
    eprint!("{}", grammar_lang::diagnostics::render::render(&out.diagnostics, &sources, Default::default(), false));
    if let Some(r) = out.ruleset {
        eprintln!("{} rules {} reqs", r.rules.len(), r.requirements.len());
    }
}
