//! The page: sections of words, tables and pictures. No script is in it, and nothing is loaded.

pub(crate) mod chart;
mod convergence;
mod designs;
mod front;
mod learning;
mod observed;
mod rejections;
mod rules;
mod runs;
mod sizes;
mod solid;
mod spending;
mod temperature;
mod time;
pub(crate) mod words;

use std::path::Path;

use super::Reload;
use super::read::{Group, Run, Standing};
use crate::markup::escape;

/// The style of pages with charts.
const STYLE: &str = include_str!("page.css");
/// How many colours `page.css` has for groups.
const COLOURS: usize = 6;
/// How long a page of runs under way waits before it loads itself again, in s.
const WAIT: u32 = 5;

/// The address of the page of a run, or of a saved design on a front, if there is one.
type Link<'a> = &'a dyn Fn(&Path) -> Option<String>;

/// A part of the page.
struct Section {
    /// Its place in addresses.
    id: &'static str,
    heading: &'static str,
    /// Its markup; nothing is shown of a section that has none.
    body: fn(&[Group], Link) -> String,
}

/// The sections, in order.
const SECTIONS: [Section; 12] = [
    Section { id: "runs", heading: "Runs", body: runs::section },
    Section { id: "convergence", heading: "Convergence", body: convergence::section },
    Section { id: "learning", heading: "Learning", body: learning::section },
    Section { id: "designs", heading: "Best designs", body: designs::section },
    Section { id: "front", heading: "The front", body: front::section },
    Section { id: "rules", heading: "Rules", body: rules::section },
    Section { id: "temperature", heading: "Temperature and acceptance", body: temperature::section },
    Section { id: "spending", heading: "Where evaluations went", body: spending::section },
    Section { id: "sizes", heading: "Size and value", body: sizes::section },
    Section { id: "observed", heading: "What was observed", body: observed::section },
    Section { id: "rejections", heading: "Refused moves and failed evaluations", body: rejections::section },
    Section { id: "time", heading: "Time spent", body: time::section },
];

/// The whole page.
pub(super) fn page(groups: &[Group], link: Link, reload: Reload) -> String {
    let names: Vec<&str> = groups.iter().map(|group| group.name.as_str()).collect();
    let title = escape(&names.join(" / "));
    let sections: Vec<(&Section, String)> =
        SECTIONS.iter().map(|section| (section, (section.body)(groups, link))).collect();
    let there = || sections.iter().filter(|(_, body)| !body.is_empty());
    let ways: String = there().map(|(s, _)| format!("<a href=\"#{}\">{}</a>", s.id, s.heading)).collect();
    let bodies: String = there()
        .map(|(s, body)| format!("<section id=\"{}\">\n<h2>{}</h2>\n{body}</section>\n", s.id, s.heading))
        .collect();
    let (refresh, note) = match reload {
        Reload::Never => (String::new(), unfinished(groups)),
        Reload::WhileRunning => (
            format!("<meta http-equiv=\"refresh\" content=\"{WAIT}\">\n"),
            "<p class=\"note\">These runs are still going: the page reloads every few seconds, and sgc writes the tables at the end.</p>\n".to_owned(),
        ),
    };
    let header = format!("<h1>{title}</h1>\n{note}<nav>{ways}</nav>");
    Document { title: &title, kind: "report", refresh: &refresh, style: "", header: &header, main: &bodies }
        .html()
}

/// A page of words, tables and pictures. All but its kind is markup.
pub(crate) struct Document<'a> {
    pub(crate) title: &'a str,
    /// What it is, for its title.
    pub(crate) kind: &'a str,
    /// What makes it load itself again.
    pub(crate) refresh: &'a str,
    /// Beside that of all such pages.
    pub(crate) style: &'a str,
    pub(crate) header: &'a str,
    pub(crate) main: &'a str,
}

impl Document<'_> {
    /// The whole page: no script is in it, and nothing is loaded.
    pub(crate) fn html(&self) -> String {
        let Self { title, kind, refresh, style, header, main } = self;
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'\">\n\
             {refresh}<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n<meta name=\"generator\" content=\"sgc {}\">\n\
             <title>{title}: {kind}</title>\n<style>\n{STYLE}{style}</style>\n</head>\n<body>\n\
             <header>\n{header}\n</header>\n<main>\n{main}</main>\n</body>\n</html>\n",
            env!("CARGO_PKG_VERSION")
        )
    }
}

/// What to know of runs that are not complete.
fn unfinished(groups: &[Group]) -> String {
    let all = || groups.iter().flat_map(|group| &group.runs);
    let open = all().filter(|run| !run.is_complete()).count();
    if open == 0 {
        return String::new();
    }
    let is_going = all().any(|run| matches!(run.standing, Standing::UnderWay | Standing::Waiting));
    let going = if is_going { " Some are under way: report them again later." } else { "" };
    format!(
        "<p class=\"note\">{open} of {} runs are not complete: the page shows their results so far.{going}</p>\n",
        all().count()
    )
}

/// The class of a group's colour.
fn colour(group: usize) -> String {
    format!("g{}", group % COLOURS)
}

/// The groups by their colours; nothing where there is only one.
fn names(groups: &[Group]) -> Vec<(String, String)> {
    if groups.len() < 2 {
        return Vec::new();
    }
    groups.iter().enumerate().map(|(i, group)| (format!("chip {}", colour(i)), group.name.clone())).collect()
}

/// What is seen of a group, in words: after its name, where there are several.
fn told(groups: &[Group], group: &Group, sentences: &[String]) -> String {
    if sentences.is_empty() {
        return String::new();
    }
    let name = if groups.len() < 2 { String::new() } else { format!("<b>{}.</b> ", escape(&group.name)) };
    format!("<p>{name}{}</p>\n", sentences.join(" "))
}

/// A heading above what a group has for itself; nothing where there is only one.
fn heading(groups: &[Group], index: usize) -> String {
    let Some(group) = groups.get(index).filter(|_| groups.len() > 1) else { return String::new() };
    format!("<h3><i class=\"chip {}\"></i>{}</h3>\n", colour(index), escape(&group.name))
}

/// The name of an axis of values.
fn axis(what: &str, group: Option<&Group>) -> String {
    match group.map(|group| group.unit.as_str()).filter(|unit| !unit.is_empty()) {
        Some(unit) => format!("{what} ({unit})"),
        None => what.to_owned(),
    }
}

/// Which seed a run had, and of which group where there are several.
fn label(groups: &[Group], group: &Group, run: &Run) -> String {
    if groups.len() < 2 {
        format!("seed {}", run.asked.seed)
    } else {
        format!("{}, seed {}", group.name, run.asked.seed)
    }
}
