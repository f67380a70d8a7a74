//! SVG that moves by itself: SMIL animations of paths, gradients and clips, without scripts.
//!
//! The attributes themselves show the first frame, so programs that know no animation show the drawing. Browsers blend
//! paths of the same elements number by number, so frames near the line between two keys are left out.
//!
//! Pens that were pressed are filled outlines; gradients follow as in [`super::shade`].

use std::borrow::Cow;
use std::fmt::Write as _;

use kurbo::Affine;

use super::curve::{Curve, Kind};
use super::keys::{Keys, Precision};
use super::shade::Shade;
use super::{of_each, put, text};
use crate::error::Result;
use crate::job::Stage;
use crate::shape::sketch::runs::{Step, steps};
use crate::shape::sketch::{
    Cap, Drawing, Fill, Gradient, Join, Paint, Pen, SketchCanvas, SketchTake, Spread, Stroke, pressed_outline,
};

/// Decimals of everything in the picture's pixels.
const DECIMALS: u32 = 2;

/// How an SVG moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::export) struct SvgOptions {
    /// How far a coordinate may be off in any frame, in the picture's pixels.
    pub(in crate::export) tolerance: f64,
    /// Whether it begins again when it ends.
    pub(in crate::export) repeat: bool,
}

/// The text of a take, which belongs to the drawing.
pub(in crate::export) fn write(
    name: &str,
    drawing: &Drawing,
    take: &SketchTake,
    canvas: &SketchCanvas,
    options: SvgOptions,
    stage: Stage<'_>,
) -> Result<String> {
    stage.name("writing curves")?;
    let frames = take.frames.len();
    let repeat = if options.repeat { " repeatCount=\"indefinite\"" } else { " fill=\"freeze\"" };
    let timing = format!(" dur=\"{}s\"{repeat}", text(frames as f64 / take.fps, 5));
    let precision = Precision { tolerance: options.tolerance, decimals: DECIMALS };
    let writer = Writer { drawing, take, view: canvas.transform(), scale: canvas.scale(), timing, precision };
    let strokes = of_each(drawing.strokes.len(), stage, |stroke| writer.stroke(stroke))?;
    let (width, height) = canvas.size();
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">"
    );
    let _ = write!(out, "<title>{}</title>", escaped(name));
    let [red, green, blue, alpha] = canvas.background;
    if alpha > 0 {
        let _ = write!(
            out,
            "<rect width=\"100%\" height=\"100%\"{}/>",
            color("fill", [red, green, blue], f32::from(alpha) / 255.0)
        );
    }
    let mut clips = 0;
    for step in steps(drawing, &take.order) {
        match step {
            Step::Paint(stroke) => out.push_str(&strokes[stroke]),
            Step::Leave => out.push_str("</g>"),
            Step::Enter(group) => {
                let own = &drawing.groups[group];
                let mut attributes = share("opacity", own.opacity);
                if let Some(clip) = &own.clip {
                    clips += 1;
                    let rule = if clip.even_odd { " clip-rule=\"evenodd\"" } else { "" };
                    let paths = take.frames.iter().map(|f| f.clips[group].clone());
                    let _ = write!(out, "<clipPath id=\"c{clips}\">{}</clipPath>", writer.path(paths, rule));
                    let _ = write!(attributes, " clip-path=\"url(#c{clips})\"");
                }
                let _ = write!(out, "<g{attributes}>");
            }
        }
    }
    out.push_str("</svg>\n");
    stage.at(1.0)?;
    Ok(out)
}

struct Writer<'a> {
    drawing: &'a Drawing,
    take: &'a SketchTake,
    view: Affine,
    scale: f64,
    timing: String,
    precision: Precision,
}

impl Writer<'_> {
    fn stroke(&self, index: usize) -> String {
        let stroke = &self.drawing.strokes[index];
        let paths = || self.take.frames.iter().map(|f| f.paths[index].clone());
        let widths = self.take.widths.get(index).filter(|w| !w.is_empty());
        let Some((pen, widths)) = stroke.pen.as_ref().zip(widths) else {
            let (mut out, pen) = (String::new(), stroke.pen.as_ref());
            let look = self.fill(index, stroke.fill.as_ref(), &mut out)
                + &pen.map_or_else(String::new, |pen| self.pen(index, stroke, pen, &mut out));
            return out + &self.path(paths(), &format!("{}{look}", id(stroke)));
        };
        let mut line = String::new();
        let as_fill = Fill { paint: pen.paint.clone(), opacity: pen.opacity, even_odd: false };
        let look = self.paint("fill", index, "p", &as_fill.paint, as_fill.opacity, &mut line);
        line += &self.path(paths().map(|p| pressed_outline(&p, widths, pen)), &format!("{}{look}", id(stroke)));
        let Some(fill) = &stroke.fill else { return line };
        let mut area = String::new();
        let look = self.fill(index, Some(fill), &mut area);
        area += &self.path(paths(), &look);
        if stroke.pen_below { line + &area } else { area + &line }
    }

    fn fill(&self, index: usize, fill: Option<&Fill>, defs: &mut String) -> String {
        let Some(fill) = fill else { return " fill=\"none\"".into() };
        let rule = if fill.even_odd { " fill-rule=\"evenodd\"" } else { "" };
        self.paint("fill", index, "f", &fill.paint, fill.opacity, defs) + rule
    }

    fn pen(&self, index: usize, stroke: &Stroke, pen: &Pen, defs: &mut String) -> String {
        let mut out = self.paint("stroke", index, "p", &pen.paint, pen.opacity, defs);
        let length = |v: f64| text(v * self.scale, 3);
        let _ = write!(out, " stroke-width=\"{}\"", length(pen.width.max(0.0)));
        out += match pen.cap {
            Cap::Butt => "",
            Cap::Round => " stroke-linecap=\"round\"",
            Cap::Square => " stroke-linecap=\"square\"",
        };
        out += match pen.join {
            Join::Miter => "",
            Join::Round => " stroke-linejoin=\"round\"",
            Join::Bevel => " stroke-linejoin=\"bevel\"",
        };
        if pen.join == Join::Miter && pen.miter_limit != 4.0 {
            let _ = write!(out, " stroke-miterlimit=\"{}\"", text(pen.miter_limit.max(1.0), 3));
        }
        if !pen.dashes.is_empty() {
            let dashes: Vec<String> = pen.dashes.iter().map(|d| length(*d)).collect();
            let _ = write!(out, " stroke-dasharray=\"{}\"", dashes.join(" "));
            if pen.dash_offset != 0.0 {
                let _ = write!(out, " stroke-dashoffset=\"{}\"", length(pen.dash_offset));
            }
        }
        if stroke.pen_below && stroke.fill.is_some() {
            out += " paint-order=\"stroke\"";
        }
        out
    }

    fn paint(&self, what: &str, index: usize, letter: &str, paint: &Paint, opacity: f32, defs: &mut String) -> String {
        match paint {
            Paint::Color(rgb) => color(what, *rgb, opacity),
            Paint::Gradient(gradient) => {
                self.gradient(&format!("{letter}{index}"), index, gradient, defs);
                format!(" {what}=\"url(#{letter}{index})\"{}", share(&format!("{what}-opacity"), opacity))
            }
        }
    }

    fn gradient(&self, id: &str, index: usize, gradient: &Gradient, out: &mut String) {
        let affines = self.take.frames.iter().map(|f| f.affines[index]);
        let shade = Shade::new(gradient, affines, self.view, true);
        let (tag, names, values): (_, &[&str], Vec<Vec<f64>>) = if shade.radial {
            let radius = |f: &[f64]| (f[2] - f[0]).hypot(f[3] - f[1]);
            let frames = shade.frames.iter().map(|f| vec![f[0], f[1], radius(f), f[4], f[5]]);
            ("radialGradient", &["cx", "cy", "r", "fx", "fy"], frames.collect())
        } else {
            ("linearGradient", &["x1", "y1", "x2", "y2"], shade.frames)
        };
        let keys = Keys::new(&values, self.precision);
        let column =
            |c: usize| keys.values.iter().map(move |v| text(v[c] as f64 / 10f64.powi(DECIMALS as i32), DECIMALS));
        let _ = write!(out, "<{tag} id=\"{id}\" gradientUnits=\"userSpaceOnUse\"");
        for (c, name) in names.iter().enumerate() {
            let _ = write!(out, " {name}=\"{}\"", column(c).next().unwrap_or_default());
        }
        if shade.space != super::shade::Ellipse::NONE {
            let numbers = shade.space.affine().as_coeffs().map(|v| text(v, 6));
            let _ = write!(out, " gradientTransform=\"matrix({})\"", numbers.join(" "));
        }
        out.push_str(match gradient.spread {
            Spread::Pad => ">",
            Spread::Reflect => " spreadMethod=\"reflect\">",
            Spread::Repeat => " spreadMethod=\"repeat\">",
        });
        for stop in &gradient.stops {
            let _ = write!(
                out,
                "<stop offset=\"{}\"{}/>",
                text(stop.offset.into(), 4),
                color("stop-color", stop.color, stop.opacity)
            );
        }
        for (c, name) in names.iter().enumerate().filter(|_| keys.at.len() > 1) {
            if keys.values.iter().any(|v| v[c] != keys.values[0][c]) {
                self.animate(name, &keys.at, column(c), out);
            }
        }
        let _ = write!(out, "</{tag}>");
    }

    /// A path that moves, with these attributes.
    fn path(&self, paths: impl IntoIterator<Item = kurbo::BezPath>, attributes: &str) -> String {
        let curve = Curve::new(paths, self.view);
        let keys = Keys::new(&curve.frames, self.precision);
        let mut texts = keys.values.iter().map(|v| path_text(&curve.kinds, v));
        let first = texts.next().unwrap_or_default();
        if keys.at.len() < 2 {
            return format!("<path d=\"{first}\"{attributes}/>");
        }
        let mut out = format!("<path d=\"{first}\"{attributes}>");
        self.animate("d", &keys.at, std::iter::once(first).chain(texts), &mut out);
        out + "</path>"
    }

    /// The last key is held until the last frame ends.
    fn animate(&self, what: &str, keys: &[usize], values: impl Iterator<Item = String>, out: &mut String) {
        let count = self.take.frames.len() as f64;
        let _ = write!(out, "<animate attributeName=\"{what}\"{} keyTimes=\"", self.timing);
        for key in keys {
            // As many decimals as tell a hundredth of a frame.
            let decimals = 3 + count.log10().ceil() as u32;
            put(out, super::units(*key as f64 / count, decimals), decimals, false);
            out.push(';');
        }
        out.push_str("1\" values=\"");
        let mut last = String::new();
        for value in values {
            out.push_str(&value);
            out.push(';');
            last = value;
        }
        let _ = write!(out, "{last}\"/>");
    }
}

/// A path in the fewest characters that say the same: relative, each command once for those of its kind that follow.
fn path_text(kinds: &[Kind], units: &[i64]) -> String {
    let mut out = String::new();
    let (mut at, mut start, mut next) = ([0, 0], [0, 0], units.chunks_exact(2));
    let mut last = Kind::Close;
    for kind in kinds {
        let letter = match kind {
            Kind::Move => 'm',
            Kind::Line => 'l',
            Kind::Quad => 'q',
            Kind::Cubic => 'c',
            Kind::Close => 'z',
        };
        let again = *kind == last && !matches!(kind, Kind::Move | Kind::Close);
        if !again {
            out.push(letter);
        }
        let mut first = !again;
        let mut end = at;
        for point in next.by_ref().take(kind.points()) {
            end = [point[0], point[1]];
            for (to, from) in end.iter().zip(at) {
                if !first && *to >= from {
                    out.push(' ');
                }
                put(&mut out, to - from, DECIMALS, false);
                first = false;
            }
        }
        match kind {
            Kind::Move => start = end,
            Kind::Close => end = start,
            _ => {}
        }
        at = end;
        last = *kind;
    }
    out
}

fn color(what: &str, [r, g, b]: [u8; 3], opacity: f32) -> String {
    let alpha = if what == "stop-color" { "stop-opacity".into() } else { Cow::from(format!("{what}-opacity")) };
    format!(" {what}=\"#{r:02x}{g:02x}{b:02x}\"{}", share(&alpha, opacity))
}

fn share(what: &str, value: f32) -> String {
    if value >= 1.0 { String::new() } else { format!(" {what}=\"{}\"", text(f64::from(value.max(0.0)), 4)) }
}

fn id(stroke: &Stroke) -> String {
    if stroke.name.is_empty() { String::new() } else { format!(" data-name=\"{}\"", escaped(&stroke.name)) }
}

/// Text as XML has it; what XML cannot hold is left out.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => {}
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
