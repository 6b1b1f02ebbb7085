//! Comments as prose: paragraphs, lists and `code`, and no more.

use crate::markup::escape;

/// What a block of lines is.
#[derive(PartialEq)]
enum Block {
    Paragraph(String),
    Items(Vec<String>),
}

fn blocks(doc: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open = false;
    for line in doc.lines().map(str::trim) {
        match (line.strip_prefix("- "), blocks.last_mut()) {
            _ if line.is_empty() => open = false,
            (Some(item), Some(Block::Items(items))) if open => items.push(item.to_owned()),
            (Some(item), _) => {
                blocks.push(Block::Items(vec![item.to_owned()]));
                open = true;
            }
            (None, Some(Block::Paragraph(text))) if open => *text += &format!(" {line}"),
            (None, Some(Block::Items(items))) if open => {
                if let Some(last) = items.last_mut() {
                    *last += &format!(" {line}");
                }
            }
            (None, _) => {
                blocks.push(Block::Paragraph(line.to_owned()));
                open = true;
            }
        }
    }
    blocks
}

/// A line with `code` in it. A mark without its partner is just a mark.
fn line(text: &str) -> String {
    let pieces: Vec<&str> = text.split('`').collect();
    let mut out = String::new();
    for (place, piece) in pieces.iter().enumerate() {
        let last = place + 1 == pieces.len();
        match (place % 2 == 1, last) {
            (true, false) => out += &format!("<code>{}</code>", escape(piece)),
            (true, true) => out += &format!("`{}", escape(piece)),
            (false, _) => out += &escape(piece),
        }
    }
    out
}

/// A comment as HTML.
pub(super) fn html(doc: &str) -> String {
    let block = |block: Block| match block {
        Block::Paragraph(text) => format!("<p>{}</p>\n", line(&text)),
        Block::Items(items) => {
            let items: String = items.iter().map(|item| format!("<li>{}</li>", line(item))).collect();
            format!("<ul>{items}</ul>\n")
        }
    };
    blocks(doc).into_iter().map(block).collect()
}

/// The first sentence of a comment, without its full stop.
pub(super) fn first_sentence(doc: &str) -> String {
    let text = match blocks(doc).into_iter().next() {
        Some(Block::Paragraph(text)) => text,
        Some(Block::Items(items)) => items.into_iter().next().unwrap_or_default(),
        None => String::new(),
    };
    let end = text.find(". ").unwrap_or(text.len());
    text.get(..end).unwrap_or("").trim_end_matches('.').to_owned()
}
