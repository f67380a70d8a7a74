//! Writing a drawing as SVG.
//!
//! Groups, gradients, clips and dashes stay what they are, and reading gives the drawing back, to single precision. A line
//! whose width was pressed is written as its filled outline, which every viewer shows; the line itself stands beside it in
//! attributes of our namespace, `marey:line` (path data), `marey:width` and `marey:widths` (a width for each point that
//! the line passes), and `marey:of` names the filled path whose line it is, where it is one. A group whose strokes are not
//! painted one after another is written once for each run of them, and strokes that paint nothing are not written.

use std::collections::HashSet;
use std::fmt::Write as _;

use kurbo::{Affine, BezPath, PathEl, Point};

use super::drawing::{Cap, Clip, Drawing, Fill, Gradient, GradientShape, Join, Paint, Pen, Spread, Stroke};
use super::pressed;
use super::svg_in::NAMESPACE;

impl Drawing {
    /// The drawing as the text of an SVG.
    pub fn to_svg(&self) -> String {
        let mut defs = SvgDefs::new(self);
        let mut body = String::new();
        let mut open: Vec<usize> = Vec::new();
        for stroke in &self.strokes {
            let chain = self.ancestors(stroke);
            let shared = open.iter().zip(&chain).take_while(|(a, b)| a == b).count();
            (shared..open.len()).for_each(|_| body.push_str("</g>\n"));
            for &g in &chain[shared..] {
                let group = &self.groups[g];
                body.push_str("<g");
                if !group.name.is_empty() {
                    let _ = write!(body, " id=\"{}\"", escaped(&group.name));
                }
                if group.opacity < 1.0 {
                    let _ = write!(body, " opacity=\"{}\"", group.opacity);
                }
                if let Some(clip) = &group.clip {
                    let _ = write!(body, " clip-path=\"url(#{})\"", defs.clip(clip));
                }
                body.push_str(">\n");
            }
            open = chain;
            write_stroke(&mut body, stroke, &mut defs);
        }
        open.iter().for_each(|_| body.push_str("</g>\n"));
        let (w, h) = (number(self.size.0), number(self.size.1));
        let defs = defs.finish();
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:marey=\"{NAMESPACE}\" width=\"{w}\" height=\"{h}\" \
             viewBox=\"0 0 {w} {h}\">\n{defs}{body}</svg>\n"
        )
    }
}

fn write_stroke(body: &mut String, stroke: &Stroke, defs: &mut SvgDefs) {
    let name = escaped(&stroke.name);
    let Some(pen) = stroke.pen.as_ref().filter(|p| !p.widths.is_empty()) else {
        if stroke.fill.is_some() || stroke.pen.is_some() {
            let below = if stroke.pen_below { " paint-order=\"stroke\"" } else { "" };
            let fill = defs.fill(stroke.fill.as_ref());
            let pen = stroke.pen.as_ref().map(|p| defs.pen(p)).unwrap_or_default();
            let _ = writeln!(body, "<path id=\"{name}\" d=\"{}\"{fill}{pen}{below}/>", path_data(&stroke.path));
        }
        return;
    };
    let outline = path_data_shown(&pressed::outline(&stroke.path, &pen.widths, pen));
    let paint = defs.paint("fill", &pen.paint, pen.opacity);
    let line = path_data(&stroke.path);
    let widths: Vec<String> = pen.widths.iter().map(f32::to_string).collect();
    let pressed = format!(
        "d=\"{outline}\"{paint} marey:line=\"{line}\" marey:width=\"{}\" marey:widths=\"{}\"",
        number(pen.width),
        widths.join(" ")
    );
    let Some(fill) = &stroke.fill else {
        let _ = writeln!(body, "<path id=\"{name}\" {pressed}/>");
        return;
    };
    let own = defs.id("pressed");
    let line_path = format!("<path id=\"{own}\" {pressed} marey:of=\"{name}\"/>\n");
    let fill_path = format!("<path id=\"{name}\" d=\"{line}\"{}/>\n", defs.fill(Some(fill)));
    let (first, second) = if stroke.pen_below { (line_path, fill_path) } else { (fill_path, line_path) };
    body.push_str(&first);
    body.push_str(&second);
}

/// What paths refer to, collected while they are written: gradients and clips.
pub(crate) struct SvgDefs {
    text: String,
    taken: HashSet<String>,
    count: usize,
}

impl SvgDefs {
    /// Ids stay clear of the drawing's names.
    pub(crate) fn new(drawing: &Drawing) -> Self {
        let names = drawing.strokes.iter().map(|s| &s.name).chain(drawing.groups.iter().map(|g| &g.name));
        Self { text: String::new(), taken: names.cloned().collect(), count: 0 }
    }

    /// An id that nothing else has.
    pub(crate) fn id(&mut self, kind: &str) -> String {
        loop {
            self.count += 1;
            let id = format!("{kind}{}", self.count);
            if self.taken.insert(id.clone()) {
                return id;
            }
        }
    }

    /// The attributes of a fill, or of none.
    pub(crate) fn fill(&mut self, fill: Option<&Fill>) -> String {
        let Some(fill) = fill else { return " fill=\"none\"".into() };
        let rule = if fill.even_odd { " fill-rule=\"evenodd\"" } else { "" };
        self.paint("fill", &fill.paint, fill.opacity) + rule
    }

    /// The attributes of a pen, but for the widths that were pressed.
    pub(crate) fn pen(&mut self, pen: &Pen) -> String {
        let mut out = self.paint("stroke", &pen.paint, pen.opacity);
        let _ = write!(out, " stroke-width=\"{}\"", number(pen.width));
        match pen.cap {
            Cap::Butt => {}
            Cap::Round => out.push_str(" stroke-linecap=\"round\""),
            Cap::Square => out.push_str(" stroke-linecap=\"square\""),
        }
        match pen.join {
            // 4 is SVG's own.
            Join::Miter if pen.miter_limit == 4.0 => {}
            Join::Miter => drop(write!(out, " stroke-miterlimit=\"{}\"", number(pen.miter_limit))),
            Join::Round => out.push_str(" stroke-linejoin=\"round\""),
            Join::Bevel => out.push_str(" stroke-linejoin=\"bevel\""),
        }
        if !pen.dashes.is_empty() {
            let dashes: Vec<String> = pen.dashes.iter().map(|d| number(*d)).collect();
            let _ = write!(out, " stroke-dasharray=\"{}\"", dashes.join(" "));
            if pen.dash_offset != 0.0 {
                let _ = write!(out, " stroke-dashoffset=\"{}\"", number(pen.dash_offset));
            }
        }
        out
    }

    /// The attributes of a paint; `property` is "fill" or "stroke".
    pub(crate) fn paint(&mut self, property: &str, paint: &Paint, opacity: f32) -> String {
        let mut out = match paint {
            Paint::Color(color) => format!(" {property}=\"{}\"", hex(*color)),
            Paint::Gradient(gradient) => format!(" {property}=\"url(#{})\"", self.gradient(gradient)),
        };
        if opacity < 1.0 {
            let _ = write!(out, " {property}-opacity=\"{opacity}\"");
        }
        out
    }

    /// The id of a gradient, written now.
    pub(crate) fn gradient(&mut self, gradient: &Gradient) -> String {
        let id = self.id("gradient");
        let n = number;
        let (kind, shape) = match gradient.shape {
            GradientShape::Linear { from, to } => {
                ("linear", format!("x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"", n(from.x), n(from.y), n(to.x), n(to.y)))
            }
            GradientShape::Radial { center: c, radius, focus: f } => (
                "radial",
                format!("cx=\"{}\" cy=\"{}\" r=\"{}\" fx=\"{}\" fy=\"{}\"", n(c.x), n(c.y), n(radius), n(f.x), n(f.y)),
            ),
        };
        let _ = write!(self.text, "<{kind}Gradient id=\"{id}\" gradientUnits=\"userSpaceOnUse\" {shape}");
        if gradient.transform != Affine::IDENTITY {
            let matrix = gradient.transform.as_coeffs().map(number).join(" ");
            let _ = write!(self.text, " gradientTransform=\"matrix({matrix})\"");
        }
        self.text.push_str(match gradient.spread {
            Spread::Pad => ">",
            Spread::Reflect => " spreadMethod=\"reflect\">",
            Spread::Repeat => " spreadMethod=\"repeat\">",
        });
        for stop in &gradient.stops {
            let _ = write!(self.text, "<stop offset=\"{}\" stop-color=\"{}\"", stop.offset, hex(stop.color));
            if stop.opacity < 1.0 {
                let _ = write!(self.text, " stop-opacity=\"{}\"", stop.opacity);
            }
            self.text.push_str("/>");
        }
        let _ = writeln!(self.text, "</{kind}Gradient>");
        id
    }

    /// The id of a clip, written now.
    pub(crate) fn clip(&mut self, clip: &Clip) -> String {
        let id = self.id("clip");
        let rule = if clip.even_odd { " clip-rule=\"evenodd\"" } else { "" };
        let _ = writeln!(self.text, "<clipPath id=\"{id}\"><path d=\"{}\"{rule}/></clipPath>", path_data(&clip.path));
        id
    }

    /// The element that holds them; empty for none.
    pub(crate) fn finish(self) -> String {
        if self.text.is_empty() { String::new() } else { format!("<defs>\n{}</defs>\n", self.text) }
    }
}

/// The path as SVG path data, absolute, in the fewest digits that single precision needs.
pub(crate) fn path_data(path: &BezPath) -> String {
    path_data_with(path, number)
}

/// The path as SVG path data, absolute, to a hundredth of a pixel: what is only shown, and not read again.
pub(crate) fn path_data_shown(path: &BezPath) -> String {
    path_data_with(path, |v| number((v * 100.0).round() / 100.0))
}

fn path_data_with(path: &BezPath, number: impl Fn(f64) -> String) -> String {
    let mut out = String::new();
    for el in path.elements() {
        let (letter, points): (char, &[Point]) = match el {
            PathEl::MoveTo(p) => ('M', &[*p]),
            PathEl::LineTo(p) => ('L', &[*p]),
            PathEl::QuadTo(a, p) => ('Q', &[*a, *p]),
            PathEl::CurveTo(a, b, p) => ('C', &[*a, *b, *p]),
            PathEl::ClosePath => ('Z', &[]),
        };
        out.push(letter);
        for (i, p) in points.iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            let _ = write!(out, "{gap}{} {}", number(p.x), number(p.y));
        }
    }
    out
}

/// A number in the fewest digits that single precision needs.
pub(crate) fn number(v: f64) -> String {
    // 0.0 also for -0.0.
    (v as f32 + 0.0).to_string()
}

/// A colour as `#rrggbb`.
pub(crate) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Text for an attribute in double quotes.
pub(crate) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' | '\n' | '\r' => drop(write!(out, "&#{};", c as u32)),
            // No XML can hold the others.
            c if c.is_control() && c < ' ' || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}
