//! `sgc man`: the manual pages, from the definition of the command line.

use clap::{Args, CommandFactory};
use clap_mangen::Man;

use super::exit;
use super::output::{self, Fault};

/// Print the manual page of sgc, or of one of its commands
///
/// To read one:
///   sgc man run | man -l -
/// To install them:
///   sgc man > ~/.local/share/man/man1/sgc.1
///   for c in check run view; do sgc man $c > ~/.local/share/man/man1/sgc-$c.1; done
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Manual {
    /// The command [default: sgc itself, with a list of its commands]
    #[arg(value_name = "COMMAND")]
    command: Option<String>,
}

impl Manual {
    pub(super) fn run(self) -> Result<u8, Fault> {
        let mut sgc = super::Arguments::command();
        // Only then the pages of commands say `sgc run`, and have their options.
        sgc.build();
        let page = match &self.command {
            None => Man::new(sgc),
            Some(name) => match sgc.find_subcommand(name) {
                Some(command) => Man::new(command.clone()).title(format!("sgc-{name}")),
                None => {
                    let help = "`sgc --help` lists the commands";
                    return Err(Fault::usage(format!("there is no command `{name}`: {help}")));
                }
            },
        };
        let mut text = Vec::new();
        page.render(&mut text).map_err(|error| Fault::usage(error.to_string()))?;
        output::data(&String::from_utf8_lossy(&text))?;
        Ok(exit::DONE)
    }
}
