//! Layouts of small texts, and what holds for every text.

use super::*;

fn formatted(text: &str) -> String {
    let mut sources = SourceMap::default();
    let file = sources.add("test", text);
    match format(&sources, file) {
        Ok(out) => out,
        Err(why) => {
            panic!("{why:?}\n{text}\n--- was laid out as\n{}", lay_out(text, &syntax::tokens(text).unwrap()))
        }
    }
}

#[test]
fn show() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    std::fs::create_dir_all("/tmp/fmt-format").unwrap();
    for folder in ["std-rules", "grammars"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let out = formatted(&std::fs::read_to_string(&path).unwrap());
            std::fs::write(std::path::Path::new("/tmp/fmt-format").join(path.file_name().unwrap()), out)
                .unwrap();
        }
    }
}
