//! `stepwright completions`: completion scripts for shells.

use std::io::{self, Write};

use clap::CommandFactory;
use clap_complete::Shell;

use crate::failure::{Failure, unless_closed};

/// Print a completion script for a shell
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stepwright completions bash > ~/.local/share/bash-completion/completions/stepwright
  stepwright completions zsh  > ~/.zfunc/_stepwright
  stepwright completions fish > ~/.config/fish/completions/stepwright.fish
In PowerShell, a line of the file $PROFILE:
  stepwright completions powershell | Out-String | Invoke-Expression")]
pub struct Args {
    /// Your shell
    shell: Shell,
}

/// Prints the script on standard output.
pub fn run(args: Args) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut crate::Cli::command(), "stepwright", &mut script);
    unless_closed(io::stdout().write_all(&script))
}
