//! Puts texts, style, scripts and data into the page's frame.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest as _, Sha256};

use super::encode::Data;
use super::{Check, Made, Making, Scene, worlds};
use crate::markup::escape;

/// The frame: HTML with `{{name}}` where something goes.
const FRAME: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const THREE: &str = include_str!("three/three.min.js");
/// What runs in the browser, in order; one function around all of it.
const SCRIPT: [&str; 10] = [
    "(function () {\n\"use strict\";\n",
    include_str!("script/data.js"),
    include_str!("script/ground.js"),
    include_str!("script/solids.js"),
    include_str!("script/making.js"),
    include_str!("script/stage.js"),
    include_str!("script/curves.js"),
    include_str!("script/steps.js"),
    include_str!("script/main.js"),
    "})();\n",
];

/// The page of a scene whose numbers are packed already.
pub(super) fn page(scene: &Scene, data: &Data) -> String {
    let script = SCRIPT.concat();
    let scripts = format!("{} {}", source(THREE), source(&script));
    fill(FRAME, |name| match name {
        "scripts" => scripts.clone(),
        "title" => escape(&scene.title),
        "style" => STYLE.to_owned(),
        "subtitle" => each(&scene.subtitle, |line| format!("<p>{}</p>", escape(line))),
        "value" => value(scene),
        "terms" => section("Terms", "dl", &scene.terms, |(name, text)| {
            format!("<div><dt>{}</dt><dd>{}</dd></div>", escape(name), escape(text))
        }),
        "checks" => section("Cross-checks", "ul", &scene.checks, check),
        "worlds" => scene.worlds.as_ref().map_or_else(String::new, worlds::section),
        "elsewhere" => scene.elsewhere.as_ref().map_or_else(String::new, |other| escape(&other.world)),
        "making" => making(&scene.making),
        "data" => inert(&serde_json::to_string(data).unwrap_or_default()),
        "three" => THREE.to_owned(),
        "script" => script.clone(),
        unknown => format!("{{{{{unknown}}}}}"),
    })
}

/// The name by which a content security policy knows an inline script.
fn source(script: &str) -> String {
    format!("'sha256-{}'", STANDARD.encode(Sha256::digest(script.as_bytes())))
}

/// The frame with every `{{name}}` replaced, in one pass: what is put in is
/// not looked at again.
fn fill(frame: &str, text: impl Fn(&str) -> String) -> String {
    let mut filled = String::new();
    let mut rest = frame;
    while let Some((before, after)) = rest.split_once("{{") {
        let Some((name, after)) = after.split_once("}}") else { break };
        filled.push_str(before);
        filled.push_str(&text(name));
        rest = after;
    }
    filled.push_str(rest);
    filled
}

/// The value of the objective, if there is one.
fn value(scene: &Scene) -> String {
    if scene.value.is_empty() {
        return String::new();
    }
    format!("<p class=\"value\"><span>value</span> {}</p>", escape(&scene.value))
}

/// A headed list, or nothing when it would be empty.
fn section<T>(heading: &str, list: &str, items: &[T], item: impl Fn(&T) -> String) -> String {
    if items.is_empty() {
        return String::new();
    }
    let class = heading.to_ascii_lowercase();
    format!("<section class=\"{class}\"><h2>{heading}</h2><{list}>{}</{list}></section>", each(items, item))
}

/// A cross-check as an item whose state is told by a sign, a word and a colour.
fn check(check: &Check) -> String {
    let (class, sign, word) = match check.agrees {
        Some(true) => ("agrees", "✓", "agrees"),
        Some(false) => ("differs", "✗", "does not agree"),
        None => ("silent", "–", "says nothing"),
    };
    format!(
        "<li class=\"{class}\"><span class=\"sign\" role=\"img\" aria-label=\"{word}\">{sign}</span>\
         <b>{}</b><span class=\"text\">{}</span></li>",
        escape(&check.name),
        escape(&check.text)
    )
}

/// The list of steps. What a step says stands here only: the script takes it from here.
fn making(making: &Making) -> String {
    if making.steps.is_empty() {
        return String::new();
    }
    let choice =
        |(name, value): &(String, String)| format!("<span><i>{}</i> {}</span> ", escape(name), escape(value));
    let step = |step: &Made| {
        format!(
            "<li><button type=\"button\"><b>{}</b><span class=\"about\">{}</span>\
             <span class=\"choices\">{}</span><span class=\"done\">{}</span></button></li>",
            escape(&step.rule),
            escape(&step.about),
            each(&step.choices, choice),
            escape(&step.done)
        )
    };
    format!("<section id=\"making\"><h2>How it was made</h2><ol>{}</ol></section>", each(&making.steps, step))
}

/// The items, one after the other.
fn each<T>(items: &[T], item: impl Fn(&T) -> String) -> String {
    items.iter().map(item).collect()
}

/// JSON that cannot end the script tag around it: outside its strings JSON has
/// none of these characters, and inside them an escape means the same.
fn inert(json: &str) -> String {
    json.replace('&', "\\u0026").replace('<', "\\u003c").replace('>', "\\u003e")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::view::encode;
    use crate::results::view::tests::walker;

    const NASTY: &str = "</script><script>alert('x')</script><!-- & \"{{data}}\" \u{2028} é";

    /// A scene with the same nasty text wherever there is text.
    fn nasty() -> Scene {
        let mut scene = walker();
        let text = || NASTY.to_owned();
        (scene.title, scene.value) = (text(), text());
        scene.subtitle = vec![text()];
        scene.terms = vec![(text(), text())];
        let choices = vec![(text(), text())];
        scene.making.steps = vec![Made { rule: text(), about: text(), choices, done: text() }];
        scene.making.pieces[0].names = vec![(0, text())];
        scene.checks = vec![Check { name: text(), text: text(), agrees: Some(false) }];
        for element in &mut scene.elements {
            (element.look.label, element.look.colour) = (text(), text());
        }
        for curve in &mut scene.curves {
            curve.name = text();
        }
        scene
    }

    #[test]
    fn no_text_becomes_markup() {
        let tame = page(&walker(), &encode::data(&walker()));
        let page = page(&nasty(), &encode::data(&nasty()));
        for tag in ["<script", "</script>", "<!--"] {
            assert_eq!(page.matches(tag).count(), tame.matches(tag).count(), "{tag}");
        }
        assert!(!page.contains("<script>alert"));
        assert!(page.contains("&lt;/script&gt;&lt;script&gt;alert(&#39;x&#39;)"));
    }

    #[test]
    fn inert_json_means_the_same() {
        let inert = inert(&serde_json::to_string(NASTY).unwrap());
        assert!(!inert.contains(['<', '>', '&']));
        assert_eq!(serde_json::from_str::<String>(&inert).unwrap(), NASTY);
    }

    #[test]
    fn what_is_filled_in_is_not_filled_again() {
        let filled = fill("<{{a}}|{{b}}> {{", |name| format!("{name}{{{{b}}}}"));
        assert_eq!(filled, "<a{{b}}|b{{b}}> {{");
    }

    #[test]
    fn scripts_cannot_end_their_own_tags() {
        for script in SCRIPT.iter().chain([&THREE]) {
            assert!(!script.to_ascii_lowercase().contains("</script"));
            assert!(!script.contains("<!--"));
        }
    }

    #[test]
    fn every_place_in_the_frame_is_filled() {
        let scene = walker();
        let page = page(&scene, &encode::data(&scene));
        let names = FRAME.split("{{").skip(1).filter_map(|rest| rest.split_once("}}"));
        for (name, _) in names {
            assert!(!page.contains(&format!("{{{{{name}}}}}")), "nothing goes to {name}");
        }
        assert!(!FRAME.contains("src=") && !FRAME.contains("http:"), "the page must load nothing");
    }
}
