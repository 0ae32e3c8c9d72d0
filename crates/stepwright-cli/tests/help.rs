//! Every command has `--help` with an example that begins with its own name.

use crate::common::stepwright;

/// The subcommands that a help text lists, between its usage and its options.
fn listed(help: &str) -> Vec<String> {
    let list = help.split("\nUsage: ").nth(1).unwrap_or("").split("\nOptions:\n").next().unwrap();
    if !list.contains("<COMMAND>") {
        return Vec::new();
    }
    let names = list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names.filter_map(|line| Some(line.split_whitespace().next()?.to_owned())).collect()
}

/// Walks all commands; how many have no subcommands.
fn walk(path: &[String]) -> usize {
    let ended = stepwright(&[path, &["--help".to_owned()]].concat());
    assert_eq!(ended.code(), Some(0), "{path:?}");
    let below: Vec<_> = listed(&ended.stdout).into_iter().filter(|name| name != "help").collect();
    if below.is_empty() {
        let example = format!("  stepwright {} ", path.join(" "));
        let bare = example.trim_end();
        let has = ended.stdout.lines().any(|line| line.contains(&example) || line.ends_with(bare));
        assert!(has, "no example of {path:?}: {}", ended.stdout);
        return 1;
    }
    below.into_iter().map(|name| walk(&[path, &[name]].concat())).sum()
}

#[test]
fn every_command_has_help_with_an_example() {
    let commands = walk(&[]);
    assert!(commands > 30, "{commands}");
}
