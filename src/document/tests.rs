//! What a page says, and what nobody can make it do.

use grammar_lang::source::Source;

use super::page;
use crate::loader::{Files, LIBRARY};

fn about(text: &str) -> String {
    page("test.sgr", &Files, &[Source { name: "test.sgr".to_owned(), text: text.to_owned() }])
}

/// The page without its head, style and contents.
fn body(text: &str) -> String {
    let page = about(text);
    page.split_once("<main").unwrap().1.to_owned()
}

fn library() -> String {
    let source = |(name, text): &(&str, &str)| Source { name: (*name).to_owned(), text: (*text).to_owned() };
    let texts: Vec<Source> = LIBRARY.iter().map(source).collect();
    page("The standard library", &Files, &texts)
}

/// The targets of all links, and all identifiers.
fn anchors(page: &str) -> (Vec<&str>, Vec<&str>) {
    let after = |mark: &'static str| {
        page.split(mark).skip(1).filter_map(|rest| rest.split('"').next()).collect::<Vec<_>>()
    };
    (after("href=\"#"), after(" id=\""))
}

#[test]
fn every_declaration_of_the_library_is_there_once_and_every_link_leads_somewhere() {
    let page = library();
    for name in
        ["std.blocks.cube", "std.actuators.bender", "std.actuation.bezier_pac", "std.search.plain_annealing"]
    {
        assert!(page.contains(&format!("<article id=\"{name}\">")), "{name}");
    }
    let (links, identifiers) = anchors(&page);
    assert!(links.len() > 20);
    for link in links {
        assert!(identifiers.contains(&link), "#{link} leads nowhere");
    }
    for (place, identifier) in identifiers.iter().enumerate() {
        assert!(!identifiers[..place].contains(identifier), "{identifier} is there twice");
    }
    // The parameter of an actuator names a pattern of the same module.
    assert!(page.contains("= <a href=\"#std.actuators.rest\">rest</a>"));
}

#[test]
fn nothing_comes_from_elsewhere_and_nothing_runs() {
    let page = library();
    for forbidden in ["<script", "http://", "https://", "src=", "@import", "url("] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
}

#[test]
fn no_text_becomes_markup() {
    let evil = "<script>alert('x')</script>";
    let text = format!(
        "## Bad: {evil} and `{evil}` & \"quotes\".\n## - {evil}\ngrammar g\nuse \"{evil}\" {{ a }}\n\
         ## {evil}\nrequire r : 1 < 2 because \"{evil}\"\nlet x = 3 # {evil}\n<b>\n"
    );
    let page = page(evil, &Files, &[Source { name: evil.to_owned(), text }]);
    assert!(!page.contains("<script") && !page.contains("<b>\n"), "{page}");
    assert!(page.matches("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;").count() >= 7, "{page}");
}

#[test]
fn comments_are_prose() {
    let page = body(
        "## One\n## line, `code`, a lone ` mark.\n##\n## Two:\n## - first\n##   item\n## - second\nlet x = 3\n",
    );
    assert!(page.contains("<p>One line, <code>code</code>, a lone ` mark.</p>"), "{page}");
    assert!(page.contains("<p>Two:</p>\n<ul><li>first item</li><li>second</li></ul>"), "{page}");
}

#[test]
fn a_declaration_is_its_text_and_names_are_links() {
    let page = body(
        "grammar g\n\nuse std.actuators { bender }\n\nlet half = 1 / 2   # of all\n\
         rule grow {\n  match  p : part with free port q\n  attach bender(segments = 3) to q\n  weight half\n}\n",
    );
    assert!(page.contains("<h1><span class=\"kind\">grammar</span> g</h1>"), "{page}");
    // Imported: no link, but where it comes from and what it is.
    assert!(
        page.contains("title=\"A bending actuator (from std.actuators)\">bender</span>(segments = "),
        "{page}"
    );
    assert!(page.contains("<b>weight</b> <a href=\"#half\">half</a>"), "{page}");
    assert!(page.contains("<b>let</b> half = <span class=\"number\">1</span>"), "{page}");
    assert!(page.contains("<span class=\"comment\"># of all</span></code>"), "{page}");
}

#[test]
fn a_requirement_says_why() {
    let page =
        body("grammar g\nrequire few : count(part) < 9   because \"a \\\"small\\\" box\"\nrequire 1 < 2\n");
    assert!(page.contains("<p class=\"reason\">because a &quot;small&quot; box</p>"), "{page}");
    assert!(page.contains("&lt; <span class=\"number\">9</span></code>"), "without the reason again: {page}");
    assert_eq!(page.matches("<article").count(), 2, "one without a name is shown, too: {page}");
}

#[test]
fn a_comment_at_the_head_is_about_the_text_and_what_comes_next_keeps_its_own() {
    let page =
        body("## About all.\n\n## About x.\nlet x = 1\n# Only for the author.\n\n## About y.\nlet y = 2\n");
    assert!(page.contains("</h1>\n<p>About all.</p>"), "{page}");
    assert_eq!(page.matches("About y.").count(), 1, "{page}");
    assert!(!page.contains("Only for the author"), "{page}");
    let page = body("## About x.\nlet x = 1\n");
    assert_eq!(page.matches("About x.").count(), 1, "{page}");
}

#[test]
fn what_has_no_name_is_shown_among_its_kind() {
    let page = body("grammar g\nsymmetry none\nsearch s\nmaximize 1\nrequire 1 < 2\n");
    let settings = page.split("<h3>Settings</h3>").nth(1).unwrap();
    for word in ["symmetry", "search", "maximize"] {
        assert!(settings.contains(&format!("<pre><code><b>{word}</b>")), "{word}: {settings}");
    }
    assert!(page.contains("<h3>Requirements</h3>\n<article>\n<pre>"), "{page}");
}

/// Broken, empty or strange texts still give a page.
#[test]
fn any_text_gives_a_page() {
    for text in [
        "",
        "rule {",
        "grammar g\nrule x { match }",
        "\"",
        "3 .. 4 . 5e",
        "## only a comment",
        "a.b\\",
        "é ü 日本",
    ] {
        assert!(about(text).ends_with("</html>\n"), "{text}");
    }
}

proptest::proptest! {
    #[test]
    fn pieces_make_up_the_text(text in "\\PC{0,80}") {
        let again: String = super::lex::pieces(&text).iter().map(|piece| piece.text).collect();
        proptest::prop_assert_eq!(again, text);
    }
}
