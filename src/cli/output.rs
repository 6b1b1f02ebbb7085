//! What goes where: data to standard output, everything else to standard error.

use std::io::{IsTerminal, Write};

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
    pub(super) fn input(message: impl Into<String>) -> Self {
        Self { code: exit::INPUT, message: message.into() }
    }

    /// Usage, configuration or files.
    pub(super) fn usage(message: impl Into<String>) -> Self {
        Self { code: exit::USAGE, message: message.into() }
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
