//! Lottie with the deformation in its paths: `sh` items whose points move from key to key in straight lines.
//!
//! A run of strokes is one shape layer; a group that is seen through or cut becomes a layer of its own with its opacity and
//! a mask, or a composition where it holds groups. Clips of several pieces, and those that leave out what is enclosed twice,
//! are mattes, as masks have neither. Every stroke has its own keys ([`super::keys`]).
//!
//! Gradients end where players end them: those that go on are told for four rounds on either side, and a radial one under
//! a pen is a circle. Pens that were pressed are filled outlines, and large. Strokes of one point are lines without length.

use std::fmt::Write as _;

use kurbo::{Affine, BezPath};
use serde_json::{Value, json};

use super::curve::{Curve, Kind};
use super::keys::{Keys, Precision};
use super::shade::{Ellipse, Shade};
use super::{of_each, put, text};
use crate::error::Result;
use crate::job::Stage;
use crate::shape::sketch::runs::{Step, steps};
use crate::shape::sketch::{Cap, Drawing, Fill, Gradient, Join, Paint, Pen, SketchCanvas, SketchTake, pressed_outline};

/// Parts of a pixel in which places are told, as whole numbers on layers scaled down again: a third fewer characters than
/// with a decimal. A fifth is finer than what eyes see of an edge that moves, and a whole number of hundredths.
const PARTS: f64 = 5.0;
/// Decimals of places in such parts.
const DECIMALS: u32 = 0;
/// How far a place may be off where nothing else is asked for, in pixels: the first with which the file is small enough.
/// A quarter shifts edges by less than their own softness. Only what moves by many pixels a frame needs many keys, and there
/// a pixel is not seen: pictures of fast strokes differ by a tenth of 255 then.
const TOLERANCES: [f64; 5] = [0.25, 0.35, 0.5, 0.7, 1.0];
/// Bytes a stroke and second of what is small enough: 150 kB for 16 strokes over 3 seconds.
const SMALL: f64 = 150_000.0 / 16.0 / 3.0;
/// The way from key to key, straight.
const LINEAR: &str = "\"o\":{\"x\":0,\"y\":0},\"i\":{\"x\":1,\"y\":1}";
/// How a layer of shapes begins.
const SHAPES: &str = "\"ty\":4";
/// What players do not move, of a composition.
const STILL: &str = "{\"o\":{\"a\":0,\"k\":100},\"r\":{\"a\":0,\"k\":0},\"p\":{\"a\":0,\"k\":[0,0,0]},\"a\":{\"a\":0,\"k\":[0,0,0]},\"s\":{\"a\":0,\"k\":[100,100,100]}}";

/// The text of a take, which belongs to the drawing. No place is off by more than `tolerance` pixels of the picture; without
/// one by no more than a quarter of a pixel, or up to a whole one where the file would be large.
pub(in crate::export) fn write(
    name: &str,
    drawing: &Drawing,
    take: &SketchTake,
    canvas: &SketchCanvas,
    tolerance: Option<f64>,
    stage: Stage<'_>,
) -> Result<String> {
    stage.name("writing curves")?;
    let view = Affine::scale(PARTS) * canvas.transform();
    let with = |tolerance: f64| Writer {
        drawing,
        take,
        view,
        scale: PARTS * canvas.scale(),
        precision: Precision { tolerance: PARTS * tolerance, decimals: DECIMALS },
    };
    let told = |writer: &Writer<'_>, stage| of_each(drawing.strokes.len(), stage, |stroke| writer.stroke(stroke));
    let (mut writer, mut strokes) = (with(tolerance.unwrap_or(TOLERANCES[0])), Vec::new());
    if tolerance.is_some() {
        strokes = told(&writer, stage)?;
    } else {
        let small = SMALL * drawing.strokes.len() as f64 * take.frames.len() as f64 / take.fps;
        for (i, tolerance) in TOLERANCES.into_iter().enumerate() {
            writer = with(tolerance);
            let part = |i: usize| i as f64 / TOLERANCES.len() as f64;
            strokes = told(&writer, stage.part(part(i), part(i + 1)))?;
            if strokes.iter().map(String::len).sum::<usize>() as f64 <= small {
                break;
            }
        }
    }
    let (width, height) = canvas.size();
    let mut file =
        File { size: (width, height), frames: take.frames.len(), assets: Vec::new(), open: vec![Open::default()] };
    for step in steps(drawing, &take.order) {
        match step {
            Step::Paint(stroke) if strokes[stroke].is_empty() => {}
            Step::Paint(stroke) => file.top().shapes.push(&strokes[stroke]),
            Step::Enter(group) => {
                file.end_run();
                file.open.push(Open { group: Some(group), ..Open::default() });
            }
            Step::Leave => file.leave(&writer),
        }
    }
    file.end_run();
    let mut layers = file.open.pop().map_or_else(Vec::new, |open| open.layers);
    let [red, green, blue, alpha] = canvas.background;
    if alpha > 0 {
        let opacity = text(f64::from(alpha) / 2.55, 1);
        let solid = format!("\"ty\":1,\"sc\":\"#{red:02x}{green:02x}{blue:02x}\",\"sw\":{width},\"sh\":{height}");
        layers.insert(0, Layer { body: solid, opacity: Some(opacity), ..Layer::default() });
    }
    let text = format!(
        "{{\"v\":\"5.7.0\",\"fr\":{},\"ip\":0,\"op\":{},\"w\":{width},\"h\":{height},\"nm\":{},\"ddd\":0,\"assets\":[{}],\"layers\":{}}}\n",
        text(take.fps, 4),
        take.frames.len(),
        quoted(name),
        file.assets.join(","),
        list(&layers, take.frames.len()),
    );
    stage.at(1.0)?;
    Ok(text)
}

/// What is being gathered, and the compositions that are done.
struct File<'a> {
    size: (u32, u32),
    frames: usize,
    assets: Vec<String>,
    open: Vec<Open<'a>>,
}

/// A group, or the whole, of which not all is there yet; the farthest first.
#[derive(Default)]
struct Open<'a> {
    group: Option<usize>,
    layers: Vec<Layer>,
    /// Strokes since the last layer.
    shapes: Vec<&'a str>,
}

/// A layer without its number and time.
#[derive(Default)]
struct Layer {
    body: String,
    opacity: Option<String>,
    /// What cuts it.
    masks: Option<String>,
    /// The shapes of the layer that cuts it.
    matte: Option<String>,
}

impl<'a> File<'a> {
    fn top(&mut self) -> &mut Open<'a> {
        if self.open.is_empty() {
            self.open.push(Open::default());
        }
        let last = self.open.len() - 1;
        &mut self.open[last]
    }

    fn end_run(&mut self) {
        let top = self.top();
        if !top.shapes.is_empty() {
            // What is told first lies in front.
            top.shapes.reverse();
            let body = format!("{SHAPES},\"shapes\":[{}]", top.shapes.join(","));
            top.shapes.clear();
            top.layers.push(Layer { body, ..Layer::default() });
        }
    }

    fn leave(&mut self, writer: &Writer<'_>) {
        self.end_run();
        let Some(mut open) = self.open.pop() else { return };
        let Some(group) = open.group else { return };
        let plain = |l: &Layer| l.opacity.is_none() && l.masks.is_none() && l.matte.is_none();
        let only = if let [only] = &open.layers[..]
            && plain(only)
        {
            open.layers.pop()
        } else {
            None
        };
        let mut layer = if let Some(only) = only {
            only
        } else {
            let (id, (width, height)) = (self.assets.len(), self.size);
            self.assets.push(format!("{{\"id\":\"g{id}\",\"layers\":{}}}", list(&open.layers, self.frames)));
            Layer { body: format!("\"ty\":0,\"refId\":\"g{id}\",\"w\":{width},\"h\":{height}"), ..Layer::default() }
        };
        let own = &writer.drawing.groups[group];
        layer.opacity = Some(text(100.0 * f64::from(own.opacity.clamp(0.0, 1.0)), 2));
        if let Some(clip) = &own.clip {
            let paths = writer.take.frames.iter().map(|f| f.clips[group].clone());
            let paths = writer.paths(paths, writer.view);
            // The mask of a composition would be in other units.
            if let ([path], false, true) = (&paths[..], clip.even_odd, layer.body.starts_with(SHAPES)) {
                layer.masks = Some(format!(
                    "[{{\"inv\":false,\"mode\":\"a\",\"pt\":{path},\"o\":{{\"a\":0,\"k\":100}},\"x\":{{\"a\":0,\"k\":0}},\"nm\":\"clip\"}}]"
                ));
            } else {
                let rule = if clip.even_odd { 2 } else { 1 };
                let fill = format!(
                    "{{\"ty\":\"fl\",\"c\":{{\"a\":0,\"k\":[0,0,0,1]}},\"o\":{{\"a\":0,\"k\":100}},\"r\":{rule}}}"
                );
                layer.matte = Some(format!("[{}]", shape("clip", &paths, &fill, Ellipse::NONE)));
            }
        }
        self.top().layers.push(layer);
    }
}

/// Layers as the format has them: the front one first, a matte before what it cuts.
fn list(layers: &[Layer], frames: usize) -> String {
    let mut texts: Vec<String> = Vec::new();
    for layer in layers.iter().rev() {
        let opacity = layer.opacity.as_deref().unwrap_or("100");
        let mut add = |body: &str, opacity: &str| {
            let mut place = STILL.replacen("\"k\":100", &format!("\"k\":{opacity}"), 1);
            if body.starts_with(SHAPES) {
                let scale = 100.0 / PARTS;
                place = place.replace("[100,100,100]", &format!("[{scale},{scale},100]"));
            }
            let number = texts.len() + 1;
            texts.push(format!("{{\"ddd\":0,\"ind\":{number},{body},\"sr\":1,\"ks\":{place},\"ao\":0,\"ip\":0,\"op\":{frames},\"st\":0,\"bm\":0}}"));
        };
        let mut body = layer.body.clone();
        if let Some(shapes) = &layer.matte {
            add(&format!("{SHAPES},\"td\":1,\"shapes\":{shapes}"), "100");
            body += ",\"tt\":1";
        }
        if let Some(masks) = &layer.masks {
            let _ = write!(body, ",\"hasMask\":true,\"masksProperties\":{masks}");
        }
        add(&body, opacity);
    }
    format!("[{}]", texts.join(","))
}

/// A group of paths that are painted in one way.
fn shape(name: &str, paths: &[String], paint: &str, space: Ellipse) -> String {
    let mut out = String::from("{\"ty\":\"gr\",");
    if !name.is_empty() {
        let _ = write!(out, "\"nm\":{},", quoted(name));
    }
    out.push_str("\"it\":[");
    for path in paths {
        let _ = write!(out, "{{\"ty\":\"sh\",\"ks\":{path}}},");
    }
    let (turn, x, y) =
        (text(space.turn.to_degrees(), 6), text(100.0 * space.scale.0, 6), text(100.0 * space.scale.1, 6));
    let _ = write!(
        out,
        "{paint},{{\"ty\":\"tr\",\"p\":{{\"a\":0,\"k\":[0,0]}},\"a\":{{\"a\":0,\"k\":[0,0]}},\"s\":{{\"a\":0,\"k\":[{x},{y}]}},\"r\":{{\"a\":0,\"k\":{turn}}},\"o\":{{\"a\":0,\"k\":100}}}}]}}"
    );
    out
}

struct Writer<'a> {
    drawing: &'a Drawing,
    take: &'a SketchTake,
    view: Affine,
    scale: f64,
    precision: Precision,
}

impl Writer<'_> {
    fn stroke(&self, index: usize) -> String {
        let stroke = &self.drawing.strokes[index];
        let paths = |space: Ellipse| {
            self.paths(self.take.frames.iter().map(|f| f.paths[index].clone()), space.affine().inverse() * self.view)
        };
        let pressed = self.take.widths.get(index).filter(|w| !w.is_empty());
        let fill = stroke.fill.as_ref().map(|fill| self.fill(index, fill));
        // In one group where both lie on the same paths.
        if let (Some(pen), None) = (&stroke.pen, pressed)
            && fill.as_ref().is_none_or(|f| f.1 == Ellipse::NONE)
        {
            let line = self.pen(index, pen);
            let paint = match (fill, stroke.pen_below) {
                (None, _) => line,
                (Some((area, _)), false) => format!("{line},{area}"),
                (Some((area, _)), true) => format!("{area},{line}"),
            };
            return shape(&stroke.name, &paths(Ellipse::NONE), &paint, Ellipse::NONE);
        }
        let mut parts = Vec::new();
        if let Some((area, space)) = fill {
            parts.push(shape(&stroke.name, &paths(space), &area, space));
        }
        if let Some(pen) = &stroke.pen {
            let line = if let Some(widths) = pressed {
                let outlines = self.take.frames.iter().map(|f| pressed_outline(&f.paths[index], widths, pen));
                let fill = Fill { paint: pen.paint.clone(), opacity: pen.opacity, even_odd: false };
                let (paint, space) = self.fill(index, &fill);
                shape(&stroke.name, &self.paths(outlines, space.affine().inverse() * self.view), &paint, space)
            } else {
                shape(&stroke.name, &paths(Ellipse::NONE), &self.pen(index, pen), Ellipse::NONE)
            };
            parts.push(line);
        }
        if !stroke.pen_below {
            parts.reverse();
        }
        parts.join(",")
    }

    fn fill(&self, index: usize, fill: &Fill) -> (String, Ellipse) {
        let (kind, paint, space) = self.paint(index, &fill.paint, true);
        let rule = if fill.even_odd { 2 } else { 1 };
        (
            format!("{{\"ty\":\"{}\",{paint},{},\"r\":{rule}}}", if kind { "gf" } else { "fl" }, opacity(fill.opacity)),
            space,
        )
    }

    fn pen(&self, index: usize, pen: &Pen) -> String {
        let (kind, paint, _) = self.paint(index, &pen.paint, false);
        let cap = match pen.cap {
            Cap::Butt => 1,
            Cap::Round => 2,
            Cap::Square => 3,
        };
        let join = match pen.join {
            Join::Miter => 1,
            Join::Round => 2,
            Join::Bevel => 3,
        };
        let length = |v: f64| text(v * self.scale, 2);
        let mut out = format!(
            "{{\"ty\":\"{}\",{paint},{},\"w\":{{\"a\":0,\"k\":{}}},\"lc\":{cap},\"lj\":{join}",
            if kind { "gs" } else { "st" },
            opacity(pen.opacity),
            length(pen.width.max(0.0))
        );
        if pen.join == Join::Miter {
            let _ = write!(out, ",\"ml\":{}", text(pen.miter_limit.max(1.0), 3));
        }
        if pen.dashes.iter().sum::<f64>() > 0.0 {
            // An odd number of lengths goes round twice. Players find them by their names.
            let lengths = pen.dashes.repeat(1 + pen.dashes.len() % 2);
            let dash = |(i, d): (usize, &f64)| json!({ "n": if i % 2 == 0 { "d" } else { "g" }, "nm": format!("dash {i}"), "v": still(&number(*d * self.scale)) });
            let offset = json!({ "n": "o", "nm": "offset", "v": still(&number(pen.dash_offset * self.scale)) });
            let dashes: Value = lengths.iter().enumerate().map(dash).chain(std::iter::once(offset)).collect();
            let _ = write!(out, ",\"d\":{dashes}");
        }
        out + "}"
    }

    /// Whether it is a gradient, what says so, and the space it is in.
    fn paint(&self, index: usize, paint: &Paint, ellipses: bool) -> (bool, String, Ellipse) {
        match paint {
            Paint::Color(rgb) => {
                let [r, g, b] = rgb.map(|v| text(f64::from(v) / 255.0, 4));
                (false, format!("\"c\":{{\"a\":0,\"k\":[{r},{g},{b},1]}}"), Ellipse::NONE)
            }
            Paint::Gradient(gradient) => {
                let (text, space) = self.gradient(index, gradient, ellipses);
                (true, text, space)
            }
        }
    }

    fn gradient(&self, index: usize, gradient: &Gradient, ellipses: bool) -> (String, Ellipse) {
        let affines = self.take.frames.iter().map(|f| f.affines[index]);
        let (shade, stops) = Shade::new(gradient, affines, self.view, ellipses).unrolled(gradient);
        let place = |c: usize| {
            let frames: Vec<Vec<f64>> = shade.frames.iter().map(|f| f[c..c + 2].to_vec()).collect();
            self.property(&Keys::new(&frames, self.precision), |point, out| {
                out.push('[');
                numbers(point, out);
                out.push(']');
            })
        };
        let mut colors: Vec<String> = Vec::new();
        for stop in &stops {
            colors.push(text(stop.offset.into(), 4));
            colors.extend(stop.color.map(|v| text(f64::from(v) / 255.0, 4)));
        }
        if stops.iter().any(|s| s.opacity < 1.0) {
            let alpha =
                |s: &crate::shape::sketch::Stop| [s.offset, s.opacity.clamp(0.0, 1.0)].map(|v| text(v.into(), 4));
            colors.extend(stops.iter().flat_map(alpha));
        }
        let mut out = format!(
            "\"t\":{},\"s\":{},\"e\":{},\"g\":{{\"p\":{},\"k\":{{\"a\":0,\"k\":[{}]}}}}",
            if shade.radial { 2 } else { 1 },
            place(0),
            place(2),
            stops.len(),
            colors.join(",")
        );
        if let (true, Some(f)) = (shade.radial, shade.frames.first()) {
            let (axis, focus) =
                (kurbo::Vec2::new(f[2] - f[0], f[3] - f[1]), kurbo::Vec2::new(f[4] - f[0], f[5] - f[1]));
            let length = 100.0 * (focus.hypot() / axis.hypot()).min(1.0);
            let angle = (focus.atan2() - axis.atan2()).to_degrees();
            let _ =
                write!(out, ",\"h\":{{\"a\":0,\"k\":{}}},\"a\":{{\"a\":0,\"k\":{}}}", text(length, 2), text(angle, 2));
        }
        (out, shade.space)
    }

    /// Each piece of paths over time, as a property.
    fn paths(&self, paths: impl IntoIterator<Item = BezPath>, view: Affine) -> Vec<String> {
        Piece::of(&Curve::new(paths, view))
            .iter()
            .map(|piece| self.property(&Keys::new(&piece.frames, self.precision), |k, out| piece.put(k, out)))
            .collect()
    }

    fn property(&self, keys: &Keys, put: impl Fn(&[i64], &mut String)) -> String {
        if let [only] = &keys.values[..] {
            let mut out = String::from("{\"a\":0,\"k\":");
            put(only, &mut out);
            return out + "}";
        }
        let mut out = String::from("{\"a\":1,\"k\":[");
        for (i, (frame, values)) in keys.at.iter().zip(&keys.values).enumerate() {
            let _ = write!(out, "{{\"t\":{frame},\"s\":");
            // Of several numbers a list, of a path a list of one.
            let mut value = String::new();
            put(values, &mut value);
            out += &if value.starts_with('[') { value } else { format!("[{value}]") };
            if i + 1 < keys.at.len() {
                let _ = write!(out, ",{LINEAR}}},");
            }
        }
        out + "}]}"
    }
}

/// A piece of a path, without a gap, as the format has it: for each vertex where it is and where its two handles are.
#[derive(Debug, PartialEq)]
struct Piece {
    closed: bool,
    /// For each vertex x and y of itself, of the handle before and of the one after it.
    frames: Vec<Vec<f64>>,
}

impl Piece {
    fn of(curve: &Curve) -> Vec<Self> {
        let mut pieces: Vec<Self> = Vec::new();
        let mut place = 0;
        let mut open = false;
        for kind in &curve.kinds {
            let starts = *kind == Kind::Move || !open && *kind != Kind::Close;
            if starts {
                // After a close a path goes on from where it began.
                let from = |f: usize, c: &[f64]| match (*kind, pieces.last()) {
                    (Kind::Move, _) => [c[place], c[place + 1]],
                    (_, Some(last)) => [last.frames[f][0], last.frames[f][1]],
                    _ => [0.0, 0.0],
                };
                let frames = curve.frames.iter().enumerate().map(|(f, c)| from(f, c).repeat(3)).collect();
                pieces.push(Self { closed: false, frames });
                open = true;
            }
            let Some(piece) = pieces.last_mut() else { continue };
            for (frame, c) in piece.frames.iter_mut().zip(&curve.frames) {
                let n = frame.len();
                let at = [frame[n - 6], frame[n - 5]];
                let point = |p: usize| [c[place + 2 * p], c[place + 2 * p + 1]];
                let toward = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|d| a[d] + (b[d] - a[d]) * 2.0 / 3.0);
                let (after, before, end) = match kind {
                    Kind::Line => (at, point(0), point(0)),
                    Kind::Quad => (toward(at, point(0)), toward(point(1), point(0)), point(1)),
                    Kind::Cubic => (point(0), point(1), point(2)),
                    Kind::Move | Kind::Close => continue,
                };
                [frame[n - 2], frame[n - 1]] = after;
                frame.extend([end, before, end].concat());
            }
            place += 2 * kind.points();
            if *kind == Kind::Close {
                piece.close();
                open = false;
            }
        }
        pieces
    }

    /// A last vertex on the first is that one.
    fn close(&mut self) {
        self.closed = true;
        let meets = |f: &Vec<f64>| {
            let n = f.len();
            n > 6 && (f[n - 6] - f[0]).abs() + (f[n - 5] - f[1]).abs() < 1e-3
        };
        if self.frames.iter().all(meets) {
            for frame in &mut self.frames {
                let n = frame.len();
                [frame[2], frame[3]] = [frame[n - 4], frame[n - 3]];
                frame.truncate(n - 6);
            }
        }
    }

    fn put(&self, values: &[i64], out: &mut String) {
        out.push_str(if self.closed { "{\"c\":true," } else { "{" });
        for (letter, from, relative) in [('v', 0, false), ('i', 2, true), ('o', 4, true)] {
            let _ = write!(out, "{}\"{letter}\":[", if letter == 'v' { "" } else { "," });
            for (i, vertex) in values.chunks_exact(6).enumerate() {
                out.push_str(if i > 0 { ",[" } else { "[" });
                let base = |c: usize| if relative { vertex[c] } else { 0 };
                numbers(&[vertex[from] - base(0), vertex[from + 1] - base(1)], out);
                out.push(']');
            }
            out.push(']');
        }
        out.push('}');
    }
}

fn numbers(units: &[i64], out: &mut String) {
    for (i, value) in units.iter().enumerate() {
        if i > 0 {
            out.push(',');
        }
        put(out, *value, DECIMALS, true);
    }
}

fn opacity(share: f32) -> String {
    format!("\"o\":{{\"a\":0,\"k\":{}}}", text(100.0 * f64::from(share.clamp(0.0, 1.0)), 2))
}

fn still(value: &Value) -> Value {
    json!({ "a": 0, "k": value })
}

fn number(value: f64) -> Value {
    let rounded = (value * 100.0).round() / 100.0;
    json!(rounded)
}

/// As JSON has it, without control characters.
fn quoted(text: &str) -> String {
    Value::from(text.chars().filter(|c| !c.is_control()).collect::<String>()).to_string()
}
