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

/// A text with a last line that holds its checksum.
#[must_use]
pub fn sealed(text: &str) -> String {
    let newline = if text.ends_with('\n') { "" } else { "\n" };
    let text = format!("{text}{newline}");
    let sum = sum(&text);
    text + BEGIN + &sum + END
}

/// Whether a file is as sgc wrote it: its last line holds the checksum of what stands above.
#[must_use]
pub fn is_as_written(path: &Path) -> bool {
    let text = reading::to_replace(path).ok().and_then(|bytes| String::from_utf8(bytes).ok());
    text.is_some_and(|text| holds(&text))
}

fn holds(text: &str) -> bool {
    let Some((above, line)) = text.rfind(BEGIN).and_then(|at| text.split_at_checked(at)) else {
        return false;
    };
    line.strip_prefix(BEGIN)
        .and_then(|line| line.strip_suffix(END))
        .is_some_and(|written| written == sum(above))
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
            let written = sealed(text);
            assert!(holds(&written), "{written}");
            assert!(holds(&sealed(&written)), "what was written twice");
            assert!(!holds(&written.replace("sgc", "me")) && !holds(&format!("{written} ")));
            assert!(!holds(&format!("x{written}")) && !holds(text));
        }
    }
}
