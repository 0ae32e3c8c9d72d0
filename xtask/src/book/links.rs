//! Finds the links of Markdown and HTML, and follows them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

use anyhow::{Context, Result};

/// A link to a file, to an anchor, or to both.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link {
    /// The path as written; empty for the file itself.
    pub path: String,
    /// The part after `#`; empty for the file as a whole.
    pub anchor: String,
}

impl Link {
    /// `None` for a link to another machine, which can't be followed here.
    fn new(target: &str) -> Option<Link> {
        let outside = target.contains("://") || target.starts_with("mailto:");
        let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
        (!outside).then(|| Link { path: path.to_owned(), anchor: anchor.to_owned() })
    }

    /// The link as written.
    pub fn target(&self) -> String {
        let mark = if self.anchor.is_empty() { "" } else { "#" };
        format!("{}{mark}{}", self.path, self.anchor)
    }
}

/// The file to which a path leads from another file.
pub fn resolve(from: &Path, path: &str) -> PathBuf {
    if path.is_empty() {
        return from.to_owned();
    }
    let mut to = from.parent().unwrap_or(from).to_owned();
    for part in Path::new(path).components() {
        match part {
            Component::ParentDir => drop(to.pop()),
            Component::CurDir => {}
            part => to.push(part),
        }
    }
    to
}

/// The lines of a page that are not code within ``` fences.
fn prose(page: &str) -> impl Iterator<Item = &str> {
    let mut code = false;
    page.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        !code && !fence
    })
}

/// The links of a page of Markdown: `[text](target)`, and `[text]: target` at the start of a
/// line.
pub fn of_markdown(page: &str) -> Vec<Link> {
    let mut links = Vec::new();
    for line in prose(page) {
        let line = without_code(line);
        let inline = line.split("](").skip(1).filter_map(|rest| rest.split([')', ' ']).next());
        let reference = line.strip_prefix('[').and_then(|line| line.split_once("]: "));
        let targets = inline.chain(reference.map(|(_, target)| target.trim()));
        links.extend(targets.filter_map(Link::new));
    }
    links
}

/// A line without the text between backquotes.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join("`")
}

/// The anchors of a page of Markdown, as code hosts and mdBook name them.
fn anchors_of_markdown(page: &str) -> Vec<String> {
    let mut times = BTreeMap::new();
    let heads = prose(page).filter(|line| line.starts_with('#'));
    heads
        .map(|head| {
            let slug = slug(head);
            let times = times.entry(slug.clone()).or_insert(0);
            *times += 1;
            if *times == 1 { slug } else { format!("{slug}-{}", *times - 1) }
        })
        .collect()
}

/// The anchor of a heading.
fn slug(heading: &str) -> String {
    // Only the text of a link counts.
    let text = heading.trim_start_matches('#').trim().to_lowercase();
    let text = text.split("](").enumerate().map(|(n, part)| match n {
        0 => part,
        _ => part.split_once(')').map_or("", |(_, rest)| rest),
    });
    let text: String = text.collect();
    text.chars()
        .filter_map(|c| match c {
            ' ' => Some('-'),
            c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
            _ => None,
        })
        .collect()
}

/// The values of an attribute in a page of HTML: of `href`, `src`, `id`.
fn attributes<'a>(page: &'a str, name: &str) -> Vec<&'a str> {
    let begin = format!(" {name}=\"");
    page.split(&begin).skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

/// The links of a page of HTML, and the files that it loads.
fn of_html(page: &str) -> Vec<Link> {
    let targets = ["href", "src"].map(|name| attributes(page, name)).concat();
    targets
        .into_iter()
        .filter(|target| !target.starts_with("data:"))
        .filter_map(Link::new)
        .collect()
}

/// Follows the links of pages of Markdown or HTML; the file name's extension tells the kind.
/// Returns the number of links and the faults.
pub fn follow(pages: &[PathBuf]) -> Result<(usize, Vec<String>)> {
    let mut anchors = BTreeMap::<PathBuf, Vec<String>>::new();
    let (mut links, mut faults) = (0, Vec::new());
    for page in pages {
        let text = fs::read_to_string(page).with_context(|| page.display().to_string())?;
        let found = if is_html(page) { of_html(&text) } else { of_markdown(&text) };
        for link in found {
            links += 1;
            let to = resolve(page, &link.path);
            let fault = |what| format!("{}: {}: {what}", page.display(), link.target());
            if !to.exists() {
                faults.push(fault("no such file"));
            } else if !link.anchor.is_empty() {
                if !anchors.contains_key(&to) {
                    let text = fs::read_to_string(&to).unwrap_or_default();
                    let named = |name: &&str| (*name).to_owned();
                    let heads = match is_html(&to) {
                        true => attributes(&text, "id").iter().map(named).collect(),
                        false => anchors_of_markdown(&text),
                    };
                    anchors.insert(to.clone(), heads);
                }
                if !anchors[&to].contains(&link.anchor) {
                    faults.push(fault("no such heading"));
                }
            }
        }
    }
    Ok((links, faults))
}

fn is_html(page: &Path) -> bool {
    page.extension().is_some_and(|end| end == "html")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_found_outside_code_alone() {
        let page = "A [b](c.md#d) and `[e](f)` ![g](h.png \"i\").\n```\n[j](k)\n```\n[l]: m.md\n\
                    [n](https://o.example) [p](#q)";
        let links: Vec<_> = of_markdown(page).iter().map(Link::target).collect();
        assert_eq!(links, ["c.md#d", "h.png", "m.md", "#q"]);
    }

    #[test]
    fn a_link_that_leads_nowhere_is_a_fault() {
        let folder = std::env::temp_dir().join(format!("stepwright-links-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            fs::write(&path, text).unwrap();
            path
        };
        let pages = [
            write("a.md", "# One\n[1](b.html#two) [2](#one) [3](#three) [4](c.md)"),
            write("b.html", "<h1 id=\"two\"><a href=\"a.md#one\"></a><img src=\"d.png\">"),
        ];
        let (links, faults) = follow(&pages).unwrap();
        fs::remove_dir_all(&folder).unwrap();
        let ends: Vec<_> = faults.iter().map(|fault| fault.rsplit('/').next().unwrap()).collect();
        let expected = ["a.md: #three: no such heading", "a.md: c.md: no such file"];
        assert_eq!((links, ends), (6, [&expected[..], &["b.html: d.png: no such file"]].concat()));
    }

    #[test]
    fn anchors_are_those_of_code_hosts() {
        let page = "# A b\n## C, `d` (e)!\n## A b\n```\n# no\n```\n### Of [x](y.md)";
        assert_eq!(anchors_of_markdown(page), ["a-b", "c-d-e", "a-b-1", "of-x"]);
    }
}
