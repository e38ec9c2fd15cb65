use clap::Args;
use clap_complete::Shell;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica completions bash > ~/.local/share/bash-completion/completions/caustica
  caustica completions fish > ~/.config/fish/completions/caustica.fish
  caustica completions zsh > ~/.zfunc/_caustica

zsh needs a folder of its fpath. `make install` puts those of bash, fish and zsh where they are looked for.")]
pub struct CompletionsArgs {
    /// The shell to complete commands in
    pub shell: Shell,
}
