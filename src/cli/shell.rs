//! `siloflow completions` and `siloflow man`: completions of shells and man pages, from the same description as `--help`. Programs without
//! the feature `shell`, which is on by default, lack them.

use std::fs;
use std::path::PathBuf;

use clap::{Args, CommandFactory as _};
use clap_complete::Shell;

use crate::cli::exit_status::ExitStatus;
use crate::cli::{Cli, say, unwritable};
use siloflow_files::whole_file;
use siloflow_text::fault::Fault;

/// Arguments of `completions`.
#[derive(Args, Debug)]
#[command(after_help = "\
  siloflow completions bash > ~/.local/share/bash-completion/completions/siloflow
  siloflow completions zsh > ~/.zfunc/_siloflow      # a directory of fpath
  siloflow completions fish > ~/.config/fish/completions/siloflow.fish")]
pub(super) struct CompletionsArgs {
    /// The shell.
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Args, Debug)]
#[command(after_help = "\
  siloflow man --out ~/.local/share/man/man1
  man siloflow-run")]
pub(super) struct ManArgs {
    /// The directory for the pages. It is made if it does not exist; pages of the same names are replaced.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(super) fn completions(args: &CompletionsArgs) -> ExitStatus {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "siloflow", &mut script);
    say(&String::from_utf8_lossy(&script));
    ExitStatus::Done
}

pub(super) fn man(args: &ManArgs) -> Result<ExitStatus, Fault> {
    let mut program = Cli::command();
    program.build();
    let commands = program.get_subcommands().filter(|command| command.get_name() != "help");
    // The built description has the page's name, `siloflow-run`, and no version.
    let commands = commands.map(|command| command.clone().version(env!("CARGO_PKG_VERSION")));
    let pages: Vec<_> = std::iter::once(program.clone()).chain(commands).map(page).collect();
    // Pages of other programs may be in the directory, so it is not replaced as a whole.
    fs::create_dir_all(&args.out).map_err(|error| unwritable(&args.out, &error))?;
    for (name, content) in &pages {
        whole_file::write(&args.out.join(name), content).map_err(|error| unwritable(&args.out, &error))?;
    }
    say(&format!("{}: {} pages\n", args.out.display(), pages.len()));
    Ok(ExitStatus::Done)
}

/// The file of a command's page: its name and content.
fn page(command: clap::Command) -> (String, Vec<u8>) {
    let man = clap_mangen::Man::new(command);
    let mut page = Vec::new();
    // Writing to memory cannot fail.
    let _ = man.render(&mut page);
    (man.get_filename(), page)
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum as _;

    use super::*;

    /// Names of all commands, hidden ones and `help` too.
    fn commands() -> Vec<String> {
        Cli::command().get_subcommands().map(|command| command.get_name().to_owned()).collect()
    }

    #[test]
    fn completions_of_every_shell_know_every_command() {
        for shell in Shell::value_variants() {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "siloflow", &mut script);
            let script = String::from_utf8(script).unwrap();
            assert!(commands().iter().all(|command| script.contains(command.as_str())), "{shell}");
            // Nothing in a script is changed for the terminal.
            assert_eq!(siloflow_text::safe::for_terminal(&script), script, "{shell}");
        }
    }

    #[test]
    fn there_is_a_page_for_every_command_and_other_pages_stay() {
        let here = tempfile::tempdir().unwrap();
        let out = here.path().join("man1");
        fs::create_dir(&out).unwrap();
        fs::write(out.join("other.1"), "of another program").unwrap();
        assert_eq!(man(&ManArgs { out: out.clone() }).unwrap(), ExitStatus::Done);
        for name in commands() {
            let page = fs::read_to_string(out.join(format!("siloflow-{name}.1"))).unwrap();
            assert!(page.contains(".SH NAME") && page.contains(&format!("siloflow\\-{name} \\-")), "{page}");
        }
        assert!(fs::read_to_string(out.join("siloflow.1")).unwrap().contains("siloflow\\-run(1)"));
        assert_eq!(fs::read_to_string(out.join("other.1")).unwrap(), "of another program");
        let fault = man(&ManArgs { out: out.join("other.1") }).unwrap_err();
        assert_eq!(fault.code(), "results::write");
    }
}
