//! Completions of shells, and manual pages.

use std::io;
use std::path::{Path, PathBuf};

use clap::CommandFactory;
use clap_complete::Shell;
use serde_json::json;

use crate::terminal::Terminal;

/// Prints the script that completes the command's arguments in a shell.
pub fn completions<A: CommandFactory>(terminal: &Terminal, shell: Shell) {
    let mut command = A::command();
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command, name, &mut script);
    let script = String::from_utf8_lossy(&script);
    if terminal.wants_json() {
        terminal.object(&json!({ "shell": shell.to_string(), "script": script }));
    } else {
        terminal.print(&script);
    }
}

/// Writes a manual page for the command and for each of its subcommands into `folder`, and prints their paths.
///
/// # Errors
/// A folder or a file that cannot be written, with its path.
pub fn pages<A: CommandFactory>(
    terminal: &Terminal,
    folder: &Path,
) -> Result<(), (PathBuf, io::Error)> {
    let mut command = A::command().disable_help_subcommand(true);
    command.build();
    let mut files = Vec::new();
    page(&command, folder, &mut files)?;
    if !terminal.wants_json() {
        let lines: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
        terminal.print(&(lines.join("\n") + "\n"));
    }
    terminal.object(&json!({ "files": files }));
    Ok(())
}

fn page(
    command: &clap::Command,
    folder: &Path,
    files: &mut Vec<PathBuf>,
) -> Result<(), (PathBuf, io::Error)> {
    let manual = clap_mangen::Man::new(command.clone());
    let path = folder.join(manual.get_filename());
    let mut text = Vec::new();
    let written = manual
        .render(&mut text)
        .and_then(|()| touchdown_files::write(&path, &text));
    written.map_err(|e| (path.clone(), e))?;
    files.push(path);
    command
        .get_subcommands()
        .try_for_each(|sub| page(sub, folder, files))
}
