//! The page: what texts declare, and where to find it.

use super::names::Names;
use super::sections::{Entry, Group, Import, about, grammar, groups, imports};
use super::{Module, code, prose};
use crate::markup::escape;

const STYLE: &str = include_str!("page.css");

/// The whole page.
pub(super) fn page(title: &str, modules: &[Module]) -> String {
    let names = Names::new(modules);
    let several = modules.len() > 1;
    let body: String = modules.iter().map(|module| section(&names, module, several)).collect();
    let index: String = modules.iter().map(|module| index(&names, module, several)).collect();
    let heading = match modules {
        [module] => heading(module, title),
        _ => format!("<header><h1>{}</h1></header>\n", escape(title)),
    };
    let title = escape(title);
    // Nothing on the page may come from elsewhere, whatever a comment says.
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta name=\"generator\" content=\"sgc\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <nav aria-label=\"Contents\"><p class=\"top\"><a href=\"#top\">{title}</a></p>\n{index}</nav>\n\
         <main id=\"top\">\n{heading}{body}</main>\n</body>\n</html>\n"
    )
}

/// The head of a page about one text.
fn heading(module: &Module, title: &str) -> String {
    let (kind, name) = match grammar(module) {
        Some(name) => ("grammar", name),
        None => ("module", title),
    };
    format!(
        "<header><h1><span class=\"kind\">{kind}</span> {}</h1>\n{}</header>\n",
        escape(name),
        prose::html(&about(module))
    )
}

/// Everything about a module.
fn section(names: &Names<'_>, module: &Module, several: bool) -> String {
    let groups: String = groups(module).iter().map(|g| group(names, module, g, several)).collect();
    let imports = import_list(names, module, &imports(module));
    if !several {
        return format!("{imports}{groups}");
    }
    let name = escape(&module.name);
    format!(
        "<section class=\"module\" id=\"{name}\">\n<h2><a href=\"#{name}\">{name}</a></h2>\n{}{imports}{groups}</section>\n",
        prose::html(&about(module))
    )
}

/// What a module takes from others.
fn import_list(names: &Names<'_>, module: &Module, imports: &[Import<'_>]) -> String {
    if imports.is_empty() {
        return String::new();
    }
    let row = |(from, taken): &Import<'_>| {
        let taken = match taken {
            Some(taken) => {
                let words: Vec<String> = taken.iter().map(|n| code::word(names, module, n)).collect();
                words.join(", ")
            }
            None => "everything".to_owned(),
        };
        format!("<div><dt>{}</dt><dd>{taken}</dd></div>\n", escape(from))
    };
    let rows: String = imports.iter().map(row).collect();
    format!("<section class=\"imports\"><h3>Imports</h3>\n<dl>\n{rows}</dl></section>\n")
}

fn group(names: &Names<'_>, module: &Module, group: &Group<'_>, several: bool) -> String {
    let entries: String = group.entries.iter().map(|e| entry(names, module, e)).collect();
    let title = escape(&group.title);
    // With several modules a title occurs several times, and is no anchor.
    let id = if several { String::new() } else { format!(" id=\"kind:{title}\"") };
    format!("<section class=\"group\"{id}>\n<h3>{title}</h3>\n{entries}</section>\n")
}

fn entry(names: &Names<'_>, module: &Module, entry: &Entry<'_>) -> String {
    let (id, heading) = match entry.name {
        Some(name) => {
            let anchor = escape(&names.anchor(&module.name, name));
            let (word, name) = (escape(entry.word), escape(name));
            (
                format!(" id=\"{anchor}\""),
                format!("<h4><span class=\"kind\">{word}</span> <a href=\"#{anchor}\">{name}</a></h4>\n"),
            )
        }
        None => (String::new(), String::new()),
    };
    let (source, reason) = match code::reason(entry.source) {
        Some((source, reason)) => (source, format!("<p class=\"reason\">because {}</p>\n", escape(&reason))),
        None => (entry.source, String::new()),
    };
    format!(
        "<article{id}>\n{heading}{}{reason}<pre><code>{}</code></pre>\n</article>\n",
        prose::html(entry.doc),
        code::html(names, module, entry.name, source)
    )
}

/// A module's part of the contents.
fn index(names: &Names<'_>, module: &Module, several: bool) -> String {
    let link = |entry: &Entry<'_>| {
        let name = entry.name?;
        let anchor = escape(&names.anchor(&module.name, name));
        Some(format!("<li><a href=\"#{anchor}\">{}</a></li>\n", escape(name)))
    };
    let groups = groups(module);
    let list = |group: &Group<'_>| group.entries.iter().filter_map(link).collect::<String>();
    if several {
        let name = escape(&module.name);
        let all: String = groups.iter().map(list).collect();
        return format!("<p><a href=\"#{name}\">{name}</a></p>\n<ul>\n{all}</ul>\n");
    }
    let one = |group: &Group<'_>| {
        let title = escape(&group.title);
        format!("<p><a href=\"#kind:{title}\">{title}</a></p>\n<ul>\n{}</ul>\n", list(group))
    };
    groups.iter().map(one).collect()
}
