//! The list of subcommands in the help, grouped by purpose.

use clap::Command;

/// A heading, and the subcommands beneath it.
const GROUPS: [(&str, &[&str]); 5] = [
    ("Move a motor", &["move", "line", "run", "home", "jog", "retarget", "stop", "kill", "serve"]),
    ("See where it is", &["status", "position", "watch", "zero"]),
    ("Plan and look", &["plan", "timed", "cycle", "gcode", "figures", "calc"]),
    ("Boards", &["ports", "flash", "selftest", "board", "grbl", "settings", "init", "send"]),
    ("Other", &["completions", "help"]),
];

/// The command whose help lists its subcommands by [`GROUPS`].
pub fn grouped(command: Command) -> Command {
    let about = |name: &str| match command.find_subcommand(name) {
        Some(sub) => sub.get_about().map(ToString::to_string).unwrap_or_default(),
        None => "Print this message or the help of a subcommand".to_owned(),
    };
    let mut list = String::new();
    for (heading, names) in GROUPS {
        list.push_str(&format!("{heading}:\n"));
        for name in names {
            list.push_str(&format!("  {name:<13}{}\n", about(name)));
        }
        list.push('\n');
    }
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{list}{{options}}{{after-help}}"
    );
    let template = template.replace("{options}", "Options:\n{options}");
    command.help_template(template)
}

#[cfg(test)]
mod tests {
    use super::GROUPS;
    use clap::CommandFactory;

    #[test]
    fn every_subcommand_is_in_one_group() {
        let mut listed: Vec<_> = GROUPS.iter().flat_map(|(_, names)| names.iter()).collect();
        let command = crate::Cli::command();
        let mut there: Vec<_> = command.get_subcommands().map(|sub| sub.get_name()).collect();
        there.push("help");
        there.sort_unstable();
        listed.sort_unstable();
        assert_eq!(listed.into_iter().copied().collect::<Vec<_>>(), there);
    }
}
