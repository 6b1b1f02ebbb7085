//! A last line that tells that a page, drawing or model is still as sgc wrote it.
//!
//! Only what is still so may be replaced without asking: a file of the same name that somebody else
//! wrote, or one that was edited since, is somebody's work.

use std::path::Path;

use sha2::{Digest as _, Sha256};

use super::saved::hex;
use crate::reading;

/// How the line begins, and how it ends: a comment in HTML, SVG and XML.
const BEGIN: &str = "<!-- written by sgc ";
const END: &str = " -->\n";

/// A text with a last line that holds the command that wrote it, such as `view`, and its checksum.
#[must_use]
pub fn sealed(text: &str, command: &str) -> String {
    let newline = if text.ends_with('\n') { "" } else { "\n" };
    let text = format!("{text}{newline}");
    let sum = sum(&text);
    format!("{text}{BEGIN}{command} {sum}{END}")
}

/// Whether a file is as sgc wrote it: its last line holds the checksum of what stands above.
#[must_use]
pub fn is_as_written(path: &Path) -> bool {
    text(path).is_some_and(|text| author(&text).is_some())
}

/// The same, and by this command. Earlier versions did not say by which.
#[must_use]
pub fn is_as_written_by(path: &Path, command: &str) -> bool {
    text(path).is_some_and(|text| author(&text).is_some_and(|author| author == command || author.is_empty()))
}

fn text(path: &Path) -> Option<String> {
    String::from_utf8(reading::to_replace(path).ok()?).ok()
}

/// The command that wrote a text which is still as it was; nothing if it is not, and an empty name if it does not say.
fn author(text: &str) -> Option<&str> {
    let (above, line) = text.rfind(BEGIN).and_then(|at| text.split_at_checked(at))?;
    let line = line.strip_prefix(BEGIN)?.strip_suffix(END)?;
    let (command, written) = line.split_once(' ').unwrap_or(("", line));
    (written == sum(above)).then_some(command)
}

fn sum(text: &str) -> String {
    hex(&Sha256::digest(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_edited_is_no_longer_as_written() {
        for text in ["", "<svg/>", "<svg/>\n", "a\n<!-- written by sgc 1 -->\n"] {
            let written = sealed(text, "view");
            assert_eq!(author(&written), Some("view"), "{written}");
            assert_eq!(author(&sealed(&written, "doc")), Some("doc"), "what was written twice");
            for edited in [written.replace("sgc", "me"), format!("{written} "), format!("x{written}")] {
                assert_eq!(author(&edited), None, "{edited}");
            }
            assert_eq!(author(text), None);
            // As earlier versions wrote it.
            assert_eq!(author(&written.replace("view ", "")), Some(""));
        }
    }
}
