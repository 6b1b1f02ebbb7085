//! What goes where: data to standard output, everything else to standard error.

use std::fmt::Display;
use std::io::{IsTerminal, Write};
use std::path::Path;

use super::exit;

/// Why a command ends, and with which exit code.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) code: u8,
    /// Empty if everything has been said already.
    pub(super) message: String,
}

impl Fault {
    /// The input is wrong.
    pub(super) fn input(message: impl Display) -> Self {
        Self { code: exit::INPUT, message: message.to_string() }
    }

    /// Usage, configuration or files.
    pub(super) fn usage(message: impl Display) -> Self {
        Self { code: exit::USAGE, message: message.to_string() }
    }
}

/// Writes data. A reader that has gone away is no fault of the command.
pub(super) fn data(text: &str) -> Result<(), Fault> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Fault::usage(format!("cannot write the output: {e}")))
        }
        _ => Ok(()),
    }
}

/// Tells people something.
pub(super) fn note(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// A path as it is typed into a shell.
pub(super) fn typed(path: &Path) -> String {
    let path = path.to_string_lossy();
    let is_plain = |c: char| c.is_alphanumeric() || "._-+/:,@%=\\".contains(c);
    if !path.is_empty() && path.chars().all(is_plain) {
        return path.into_owned();
    }
    if cfg!(windows) { format!("\"{path}\"") } else { format!("'{}'", path.replace('\'', "'\\''")) }
}

fn colour_wanted() -> bool {
    std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
}

/// Whether standard output may be coloured.
pub(super) fn colour_out() -> bool {
    colour_wanted() && std::io::stdout().is_terminal()
}

/// Whether standard error may be coloured.
pub(super) fn colour_err() -> bool {
    colour_wanted() && std::io::stderr().is_terminal()
}

/// A count with what is counted: `1 run`, `3 runs`.
pub(super) fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(not(windows))]
    #[test]
    fn paths_can_be_copied_into_a_shell() {
        let typed = |path: &str| typed(Path::new(path));
        assert_eq!(typed("runs/codesign-1"), "runs/codesign-1");
        assert_eq!(typed("my out/x"), "'my out/x'");
        assert_eq!(typed("it's $HOME"), r"'it'\''s $HOME'");
        assert_eq!(typed(""), "''");
    }
}
