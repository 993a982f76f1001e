//! The reference of commands, made from the help of each.

use std::fmt::Write;
use std::process::Command;

/// Commands without a section.
const LEFT_OUT: [&str; 1] = ["help"];

const HEAD: &str = "# Commands

Made from the help: `LAYERSPLAT_WRITE_REFERENCE=1 cargo test --test command guide::reference`. `layersplat COMMAND -h` prints the most common options,
`layersplat COMMAND --help` all of them.
";

fn help(arguments: &[&str]) -> String {
    // The values of these variables would appear in the help.
    let variables = ["LAYERSPLAT_DEVICE", "LAYERSPLAT_VOLUMES"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_layersplat"));
    for name in variables {
        command.env_remove(name);
    }
    String::from_utf8(command.args(arguments).arg("--help").output().unwrap().stdout).unwrap()
}

fn names_of_commands() -> Vec<String> {
    let help = help(&[]);
    let list = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let names = list.lines().map(|line| line.split_whitespace().next().unwrap().to_owned());
    names.filter(|name| !LEFT_OUT.contains(&name.as_str())).collect()
}

/// Code for a cell of a table. In code, Markdown of GitHub and of MkDocs disagree on an escaped bar.
fn code(text: &str) -> String {
    if !text.contains('|') {
        return format!("`{text}`");
    }
    format!("<code>{}</code>", text.replace('<', "&lt;").replace('>', "&gt;").replace('|', "&#124;").replace('[', "\\["))
}

/// Text for a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "&lt;").replace('[', "\\[")
}

/// An argument or option, and what is said of it. Short help has both in a line, separated by two spaces.
fn entry(first: &str, rest: &[&str]) -> String {
    let (name, inline) = first.trim().split_once("  ").unwrap_or((first.trim(), ""));
    let said = std::iter::once(inline).chain(rest.iter().copied()).map(str::trim).filter(|line| !line.is_empty());
    format!("| {} | {} |\n", code(name), said.map(cell).collect::<Vec<_>>().join("<br>"))
}

/// The help of one command as a section.
fn section(name: &str, help: &str) -> String {
    let mut page = format!("\n## {name}\n\n");
    for part in help.trim_end().split("\n\n").fold(Vec::<String>::new(), joined) {
        let (title, body) = part.split_once('\n').unwrap_or((&part, ""));
        if let Some(usage) = title.strip_prefix("Usage: ") {
            write!(page, "```text\n{usage}\n```\n").unwrap();
        } else if !title.ends_with(':') || body.is_empty() {
            write!(page, "{part}\n\n").unwrap();
        } else if body.trim_start().starts_with(['-', '[', '<']) {
            write!(page, "\n**{}**\n\n| | |\n|---|---|\n", title.trim_end_matches(':')).unwrap();
            let lines: Vec<&str> = body.lines().filter(|line| !line.trim().is_empty()).collect();
            let is_start = |line: &str| line.len() - line.trim_start().len() < 8 && !line.trim_start().starts_with("- ");
            let starts: Vec<usize> = (0..lines.len()).filter(|&n| is_start(lines[n])).collect();
            for (n, &start) in starts.iter().enumerate() {
                let end = starts.get(n + 1).copied().unwrap_or(lines.len());
                page += &entry(lines[start], &lines[start + 1..end]);
            }
        } else {
            write!(page, "\n**{}**\n\n```text\n{body}\n```\n", title.trim_end_matches(':')).unwrap();
        }
    }
    page
}

/// Joins a paragraph to the part before, unless it begins one: parts begin at the left margin.
fn joined(mut parts: Vec<String>, paragraph: &str) -> Vec<String> {
    match parts.last_mut() {
        Some(last) if paragraph.starts_with(' ') => *last = format!("{last}\n{paragraph}"),
        _ => parts.push(paragraph.trim_start_matches('\n').to_owned()),
    }
    parts
}

#[test]
#[cfg_attr(any(not(feature = "viewer"), feature = "mpi"), ignore = "the reference is that of the default features")]
fn reference_is_that_of_the_help() {
    let mut page = String::from(HEAD);
    for name in names_of_commands() {
        page += &section(&name, &help(&[&name]));
    }
    assert!(page.contains("## render") && page.contains("| `--iso <V>` | Show the surface"), "{page}");
    let path = super::root().join("docs/guide/reference.md");
    if std::env::var_os("LAYERSPLAT_WRITE_REFERENCE").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        written == page,
        "docs/guide/reference.md is out of date: LAYERSPLAT_WRITE_REFERENCE=1 cargo test --test command guide::reference"
    );
}
