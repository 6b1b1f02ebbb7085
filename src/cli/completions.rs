//! `sgc completions`: what a shell needs to complete the command line.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::exit;
use super::output::{self, Fault};

/// Print a shell script that completes sgc's commands and options
///
/// To install it for each shell:
///   bash        sgc completions bash > ~/.local/share/bash-completion/completions/sgc
///   zsh         sgc completions zsh > ~/.zfunc/_sgc   (a folder of your fpath)
///   fish        sgc completions fish > ~/.config/fish/completions/sgc.fish
///   powershell  sgc completions powershell >> $PROFILE
///   elvish      sgc completions elvish >> ~/.config/elvish/rc.elv
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Completions {
    /// The shell
    #[arg(value_enum, value_name = "SHELL")]
    shell: Shell,
}

impl Completions {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut super::Arguments::command(), "sgc", &mut script);
        output::data(&String::from_utf8_lossy(&script))?;
        Ok(exit::DONE)
    }
}
