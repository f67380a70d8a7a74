//! How large an SVG becomes when its references are followed.
//!
//! A few elements that refer to each other ten times each make billions, so they are counted before a parser makes them.
//! A rule of a style sheet that is for a class counts for its elements, any other for every element, which may be more than
//! it holds for.

use std::collections::HashMap;

use usvg::roxmltree;

use crate::error::{Error, Result};

/// Elements once all references are followed, and how deep they nest then: a few references to references make billions.
const MAX_EXPANDED: u64 = 500_000;
const MAX_DEPTH: u32 = 128;

/// Checks that a document stays within bounds.
///
/// # Errors
/// It has more elements than allowed once references are followed, or they nest deeper.
pub(crate) fn check(xml: &roxmltree::Document<'_>) -> Result<()> {
    let mut by_id = HashMap::new();
    for node in xml.descendants() {
        if let Some(id) = node.attribute("id") {
            by_id.entry(id).or_insert(node);
        }
    }
    let mut sheet = Vec::new();
    for text in xml.descendants().filter(|n| n.tag_name().name() == "style") {
        for rule in text.text().unwrap_or_default().split('}') {
            let (selectors, body) = rule.split_once('{').unwrap_or_default();
            for selector in selectors.split(',') {
                let plain = |c: &&str| c.chars().all(|c| c.is_alphanumeric() || c == '-' || c == '_');
                let class = selector.trim().strip_prefix('.').filter(plain);
                sheet.extend(links(body).map(|id| (class, id)));
            }
        }
    }
    let (count, _) = Expansion { by_id, sheet, seen: HashMap::new() }.expand(xml.root_element(), 0)?;
    if count <= MAX_EXPANDED {
        return Ok(());
    }
    Err(Error::Limit {
        what: "the count of an SVG's elements, references followed,".into(),
        value: count,
        max: MAX_EXPANDED,
        remedy: "simplify the drawing".into(),
    })
}

struct Expansion<'a, 'input> {
    by_id: HashMap<&'a str, roxmltree::Node<'a, 'input>>,
    /// What rules of style sheets refer to, and the class that they are for.
    sheet: Vec<(Option<&'a str>, &'a str)>,
    /// Count and depth of elements seen.
    seen: HashMap<roxmltree::NodeId, (u64, u32)>,
}

impl<'a, 'input> Expansion<'a, 'input> {
    fn expand(&mut self, node: roxmltree::Node<'a, 'input>, above: u32) -> Result<(u64, u32)> {
        let too_deep = |depth: u32| {
            (depth > MAX_DEPTH).then(|| Error::Limit {
                what: "how deep an SVG's elements nest, references followed,".into(),
                value: depth.into(),
                max: MAX_DEPTH.into(),
                remedy: "dissolve groups".into(),
            })
        };
        too_deep(above).map_or(Ok(()), Err)?;
        if let Some(&(count, depth)) = self.seen.get(&node.id()) {
            too_deep(above + depth).map_or(Ok(()), Err)?;
            return Ok((count, depth));
        }
        // A reference to oneself is dropped by the parser.
        self.seen.insert(node.id(), (1, 1));
        let (mut count, mut depth) = (1u64, 1u32);
        for child in node.children().filter(roxmltree::Node::is_element) {
            let (c, d) = self.expand(child, above + 1)?;
            count = count.saturating_add(c);
            depth = depth.max(d + 1);
        }
        let classes = node.attribute("class").unwrap_or_default();
        let ruled = |class: &Option<&str>| class.is_none_or(|c| classes.split_whitespace().any(|own| own == c));
        let mut targets: Vec<(&str, u64)> =
            self.sheet.iter().filter(|(c, _)| ruled(c)).map(|(_, id)| (*id, 1)).collect();
        for attribute in node.attributes() {
            let value = attribute.value();
            let uses = (attribute.name() == "href").then(|| value.strip_prefix('#')).flatten();
            // A marker stands at every point of its path.
            let marker = attribute.name().starts_with("marker") || value.contains("marker");
            let points = node.attribute("d").or(node.attribute("points")).map_or(0, |d| d.len() as u64 / 2);
            let times = if marker { 2 + points } else { 1 };
            targets.extend(links(value).chain(uses).map(|id| (id, times)));
        }
        for (id, times) in targets {
            // Gradients hold nothing that is expanded.
            let target = self.by_id.get(id).filter(|t| !t.tag_name().name().ends_with("Gradient"));
            if let Some(&target) = target {
                let (c, d) = self.expand(target, above + 1)?;
                count = count.saturating_add(c.saturating_mul(times));
                depth = depth.max(d + 1);
            }
        }
        self.seen.insert(node.id(), (count, depth));
        Ok((count, depth))
    }
}

/// What `url(#...)` in a text refers to.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let starts = text.split("url(").skip(1).map(|s| s.trim_start_matches(['\'', '"', ' ', '#']));
    starts.filter_map(|s| s.split(['\'', '"', ' ', ')']).next())
}
