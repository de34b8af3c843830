//! The documents hold together: links lead somewhere, the book has every chapter, and its figures are those that the
//! library draws now.

#![allow(clippy::unwrap_used)] // A test may panic.

#[path = "../examples/figures/drawn/mod.rs"]
mod drawn;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files of a folder and of those in it that end in this.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path, extension));
        } else if path.extension().is_some_and(|of| of == extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn documents() -> Vec<PathBuf> {
    let named = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "fuzz/README.md"];
    let mut all: Vec<PathBuf> = named.iter().map(|name| root().join(name)).collect();
    all.extend(files(&root().join("docs"), "md"));
    all
}

/// What a document links to, and the anchors of its headings as forges and mdBook make them.
struct Document {
    links: Vec<String>,
    anchors: Vec<String>,
}

impl Document {
    fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).unwrap();
        let (mut links, mut anchors) = (Vec::new(), Vec::new());
        let mut heading: Option<String> = None;
        let mut times: BTreeMap<String, usize> = BTreeMap::new();
        for event in Parser::new_ext(&text, Options::ENABLE_TABLES) {
            match event {
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    links.push(dest_url.to_string());
                }
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::Text(text) | Event::Code(text) => {
                    if let Some(heading) = &mut heading {
                        heading.push_str(&text);
                    }
                }
                Event::End(TagEnd::Heading(_)) => {
                    let anchor = anchor(&heading.take().unwrap());
                    let before = times.entry(anchor.clone()).or_default();
                    anchors.push(if *before == 0 { anchor } else { format!("{anchor}-{before}") });
                    *before += 1;
                }
                _ => {}
            }
        }
        Self { links, anchors }
    }
}

fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let mut wrong = Vec::new();
    let mut seen = 0;
    for path in documents() {
        for link in Document::read(&path).links {
            if link.contains("://") {
                continue;
            }
            seen += 1;
            let (file, anchor) = link.split_once('#').map_or((link.as_str(), None), |(f, a)| (f, Some(a)));
            let target = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            let sound = target.exists()
                && anchor.is_none_or(|anchor| {
                    target.is_file() && Document::read(&target).anchors.iter().any(|known| known == anchor)
                });
            if !sound {
                wrong.push(format!("{}: {link}", path.strip_prefix(root()).unwrap().display()));
            }
        }
    }
    assert!(wrong.is_empty(), "links that lead nowhere:\n{}", wrong.join("\n"));
    assert!(seen > 50, "only {seen} links were found");
}

#[test]
fn the_book_has_every_chapter() {
    let docs = root().join("docs");
    let listed: Vec<PathBuf> =
        Document::read(&docs.join("SUMMARY.md")).links.iter().map(|link| docs.join(link)).collect();
    for chapter in files(&docs, "md").into_iter().filter(|path| !path.ends_with("SUMMARY.md")) {
        assert!(listed.contains(&chapter), "SUMMARY.md does not list {}", chapter.display());
    }
}

#[test]
fn every_figure_is_used() {
    let docs = root().join("docs");
    let links = |path: &PathBuf| {
        let folder = path.parent().unwrap().to_owned();
        Document::read(path).links.into_iter().map(move |link| folder.join(link)).collect::<Vec<_>>()
    };
    let linked: Vec<PathBuf> = files(&docs, "md").iter().flat_map(links).collect();
    let figures = files(&docs.join("figures"), "svg");
    for figure in &figures {
        assert!(linked.contains(figure), "no chapter shows {}", figure.display());
    }
}

/// A figure that shows other numbers than the library computes would be wrong without a sign.
#[test]
fn the_figures_are_those_that_the_library_draws() {
    for (name, picture) in drawn::all() {
        let kept = fs::read_to_string(root().join("docs/figures").join(name)).unwrap_or_default();
        let (kept, drawn) = (kept.lines(), picture.lines());
        let other = kept.clone().zip(drawn.clone()).find(|(kept, drawn)| kept != drawn);
        assert!(
            other.is_none() && kept.count() == drawn.count(),
            "docs/figures/{name} is not what is drawn now: look at what `cargo run --release --example figures` makes, \
             and commit it if it is right; first difference: {other:?}"
        );
    }
}
