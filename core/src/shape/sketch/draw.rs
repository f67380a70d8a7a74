//! Pictures of a sketch, by tiny-skia: antialiased, the same bits every time.
//!
//! Painted as SVG says: a fill, then the pen's line (or the other way), groups as a whole with their opacity and their clip.
//! Places that are not numbers leave their stroke out; groups within more than [`MOST_LAYERS`] others keep their opacity, by
//! stroke, and lose their clip. Dashes of a pen that was pressed are not drawn: its line is whole.

use image::RgbaImage;
use kurbo::{Affine, BezPath, PathEl, Point};
use tiny_skia::{
    Color, FillRule, GradientStop, LinearGradient, Mask, Paint as Ink, Path, Pixmap, PixmapPaint, RadialGradient,
    Shader, SpreadMode, StrokeDash, Transform,
};

use super::runs::{Step, steps};
use super::skia::{FAR, nib, skia_path};
use super::{
    Drawing, Gradient, GradientShape, Paint, Pen, SketchCanvas, SketchFrame, SketchTake, Spread, pressed_outline,
};

/// Groups inside each other that are painted as a whole: each takes a picture's memory.
const MOST_LAYERS: usize = 32;
/// Dashes along one path: beyond that the line is whole, as it looks.
const MOST_DASHES: f64 = 1e5;

/// The picture of one frame; where the take has no such frame, its background.
pub fn draw_sketch(drawing: &Drawing, take: &SketchTake, frame: usize, canvas: &SketchCanvas) -> RgbaImage {
    let (width, height) = canvas.size();
    let mut picture = RgbaImage::new(width, height);
    let Some(mut bottom) = Pixmap::new(width, height) else { return picture };
    let [red, green, blue, alpha] = canvas.background;
    bottom.fill(Color::from_rgba8(red, green, blue, alpha));
    if let Some(frame) = take.frames.get(frame) {
        let layers = vec![Layer { pixmap: Some(bottom), left: 0, top: 0, group: None, opacity: 1.0 }];
        let mut painter = Painter { drawing, take, frame, view: canvas.transform(), scale: canvas.scale(), layers };
        painter.paint();
        let Some(painted) = painter.layers.pop().and_then(|layer| layer.pixmap) else { return picture };
        bottom = painted;
    }
    picture.copy_from_slice(&bottom.take_demultiplied());
    picture
}

impl SketchTake {
    /// A drawing that does not move: one frame of it.
    pub fn still(drawing: &Drawing) -> Self {
        let paths = drawing.strokes.iter().map(|s| s.path.clone()).collect();
        let clips =
            drawing.groups.iter().map(|g| g.clip.as_ref().map_or_else(BezPath::new, |c| c.path.clone())).collect();
        let widths =
            drawing.strokes.iter().map(|s| s.pen.as_ref().map_or_else(Vec::new, |p| p.widths.clone())).collect();
        let frame = SketchFrame { paths, clips, affines: vec![Affine::IDENTITY; drawing.strokes.len()] };
        Self { fps: 1.0, frames: vec![frame], order: (0..drawing.strokes.len()).collect(), widths }
    }
}

/// A picture that a group is painted on before it is laid over what is below.
struct Layer {
    /// None where nothing of it would be seen.
    pixmap: Option<Pixmap>,
    left: i32,
    top: i32,
    group: Option<usize>,
    /// What strokes painted on it are multiplied by.
    opacity: f32,
}

struct Painter<'a> {
    drawing: &'a Drawing,
    take: &'a SketchTake,
    frame: &'a SketchFrame,
    view: Affine,
    scale: f64,
    layers: Vec<Layer>,
}

impl Painter<'_> {
    fn paint(&mut self) {
        let steps = steps(self.drawing, &self.take.order);
        // Groups that have no layer of their own: where they end, the layer's opacity is as before.
        let mut folded: Vec<Option<f32>> = Vec::new();
        for (i, step) in steps.iter().enumerate() {
            match *step {
                Step::Paint(stroke) => self.stroke(stroke),
                Step::Enter(group) => {
                    let alone = matches!(steps[i..], [_, Step::Paint(s), Step::Leave, ..] if self.is_one_coat(s));
                    let fold = alone && self.drawing.groups[group].clip.is_none() || self.layers.len() > MOST_LAYERS;
                    let layer = if fold { None } else { Some(self.layer(group, &steps[i + 1..])) };
                    let opacity = self.drawing.groups[group].opacity;
                    let top = self.layers.last_mut().map(|top| &mut top.opacity);
                    folded.push(top.filter(|_| fold).map(|top| std::mem::replace(top, *top * share(opacity))));
                    self.layers.extend(layer);
                }
                Step::Leave => match (folded.pop().flatten(), self.layers.last_mut()) {
                    (Some(before), Some(top)) => top.opacity = before,
                    _ => self.flatten(),
                },
            }
        }
    }

    /// Whether a stroke is painted in one go, so that its opacity and its group's are one.
    fn is_one_coat(&self, stroke: usize) -> bool {
        let stroke = &self.drawing.strokes[stroke];
        stroke.fill.is_some() != stroke.pen.is_some()
    }

    /// A layer for a group, as large as what it shows: its clip, and the strokes up to its end.
    fn layer(&self, group: usize, steps: &[Step]) -> Layer {
        let opacity = 1.0;
        let none = Layer { pixmap: None, left: 0, top: 0, group: Some(group), opacity };
        let Some(below) = self.layers.last() else { return none };
        let Some(pixmap) = &below.pixmap else { return none };
        let mut area: Option<tiny_skia::Rect> = None;
        let mut depth = 0;
        for step in steps {
            match step {
                Step::Enter(_) => depth += 1,
                Step::Leave if depth == 0 => break,
                Step::Leave => depth -= 1,
                Step::Paint(stroke) => {
                    let Some(own) = self.area(*stroke) else { continue };
                    area = Some(area.map_or(own, |area| union(area, own)));
                }
            }
        }
        if self.drawing.groups[group].clip.is_some() {
            let clip = self.frame.clips.get(group).and_then(|c| skia_path(c, self.view)).map(|c| c.bounds());
            area = area.zip(clip).and_then(|(area, clip)| area.intersect(&clip));
        }
        let Some(area) = area else { return none };
        let low = |v: f32, from: i32, to: i32| (v.floor() as i32 - 1).clamp(from, to);
        let high = |v: f32, from: i32, to: i32| (v.ceil() as i32 + 1).clamp(from, to);
        let (right, bottom) = (below.left + pixmap.width() as i32, below.top + pixmap.height() as i32);
        let (left, top) = (low(area.left(), below.left, right), low(area.top(), below.top, bottom));
        let (right, bottom) = (high(area.right(), left, right), high(area.bottom(), top, bottom));
        Layer {
            pixmap: Pixmap::new((right - left) as u32, (bottom - top) as u32),
            left,
            top,
            group: Some(group),
            opacity,
        }
    }

    /// Where a stroke can leave colour.
    fn area(&self, stroke: usize) -> Option<tiny_skia::Rect> {
        let path = skia_path(self.frame.paths.get(stroke)?, self.view)?;
        let pen = self.drawing.strokes[stroke].pen.as_ref();
        let outline =
            pen.and_then(|pen| pen_outline(self.frame.paths.get(stroke)?, &path, pen, self.widths(stroke), self.scale));
        let bounds = path.bounds();
        Some(outline.map_or(bounds, |outline| union(bounds, outline.bounds())))
    }

    fn widths(&self, stroke: usize) -> &[f32] {
        self.take.widths.get(stroke).map_or(&[], |w| w)
    }

    fn stroke(&mut self, index: usize) {
        let Some((layer, path)) = self.layers.last_mut().zip(self.frame.paths.get(index)) else { return };
        let Some(pixmap) = &mut layer.pixmap else { return };
        let stroke = &self.drawing.strokes[index];
        let view = Affine::translate((f64::from(-layer.left), f64::from(-layer.top))) * self.view;
        let Some(outline) = skia_path(path, view) else { return };
        let colors = view * self.frame.affines.get(index).copied().unwrap_or_default();
        let mut coat = |pen: bool| {
            if let (true, Some(pen)) = (pen, &stroke.pen) {
                let Some(ink) = ink(&pen.paint, pen.opacity * layer.opacity, colors) else { return };
                let widths = self.take.widths.get(index).map_or(&[][..], |w| w);
                if widths.is_empty() {
                    let Some((line, nib)) = line(&outline, pen, self.scale) else { return };
                    pixmap.stroke_path(line.as_ref().unwrap_or(&outline), &ink, &nib, Transform::identity(), None);
                } else if let Some(shape) = pressed(path, pen, widths, view) {
                    pixmap.fill_path(&shape, &ink, FillRule::Winding, Transform::identity(), None);
                }
            } else if let (false, Some(fill)) = (pen, &stroke.fill) {
                let Some(ink) = ink(&fill.paint, fill.opacity * layer.opacity, colors) else { return };
                pixmap.fill_path(&outline, &ink, rule(fill.even_odd), Transform::identity(), None);
            }
        };
        coat(stroke.pen_below);
        coat(!stroke.pen_below);
    }

    /// Lays the top layer over the one below.
    fn flatten(&mut self) {
        let Some(layer) = self.layers.pop() else { return };
        let (Some(mut pixmap), Some(below)) = (layer.pixmap, self.layers.last_mut()) else { return };
        let (Some(target), Some(group)) = (&mut below.pixmap, layer.group) else { return };
        if let Some(clip) = &self.drawing.groups[group].clip {
            let view = Affine::translate((f64::from(-layer.left), f64::from(-layer.top))) * self.view;
            let path = self.frame.clips.get(group).and_then(|c| skia_path(c, view));
            let (Some(path), Some(mut mask)) = (path, Mask::new(pixmap.width(), pixmap.height())) else { return };
            mask.fill_path(&path, rule(clip.even_odd), true, Transform::identity());
            pixmap.apply_mask(&mask);
        }
        let opacity = share(self.drawing.groups[group].opacity) * below.opacity;
        let (x, y) = (layer.left - below.left, layer.top - below.top);
        let how = PixmapPaint { opacity, ..PixmapPaint::default() };
        target.draw_pixmap(x, y, pixmap.as_ref(), &how, Transform::identity(), None);
    }
}

fn union(a: tiny_skia::Rect, b: tiny_skia::Rect) -> tiny_skia::Rect {
    let (low, high) =
        ((a.left().min(b.left()), a.top().min(b.top())), (a.right().max(b.right()), a.bottom().max(b.bottom())));
    tiny_skia::Rect::from_ltrb(low.0, low.1, high.0, high.1).unwrap_or(a)
}

fn rule(even_odd: bool) -> FillRule {
    if even_odd { FillRule::EvenOdd } else { FillRule::Winding }
}

/// A share in 0..=1; 0 for what is not a number.
fn share(value: f32) -> f32 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

/// What a pen's line covers, on a path given twice: on the page, and as `scale` pixels of a picture a pixel of the page.
pub(super) fn pen_outline(path: &BezPath, scaled: &Path, pen: &Pen, widths: &[f32], scale: f64) -> Option<Path> {
    if widths.is_empty() {
        let (dashed, nib) = line(scaled, pen, scale)?;
        return dashed.as_ref().unwrap_or(scaled).stroke(&nib, 1.0);
    }
    let start = scaled.points().first()?;
    let page = path.elements().first().and_then(PathEl::end_point)?;
    let to = Affine::translate((f64::from(start.x) - page.x * scale, f64::from(start.y) - page.y * scale))
        * Affine::scale(scale);
    pressed(path, pen, widths, to)
}

/// What a pen that was pressed covers.
fn pressed(path: &BezPath, pen: &Pen, widths: &[f32], view: Affine) -> Option<Path> {
    skia_path(&pressed_outline(path, widths, pen), view)
}

/// The line's own path where it has dashes, and the pen, in pixels of a picture.
fn line(path: &Path, pen: &Pen, scale: f64) -> Option<(Option<Path>, tiny_skia::Stroke)> {
    let width = Some(pen.width * scale).filter(|w| *w > 0.0)?.min(FAR) as f32;
    let nib = nib(pen, width);
    let dashed = dash(path, pen, scale)
        .and_then(|dash| path.dash(&dash, 1.0))
        .filter(|p| p.points().iter().all(|p| p.is_finite()));
    Some((dashed, nib))
}

fn dash(path: &Path, pen: &Pen, scale: f64) -> Option<StrokeDash> {
    let period: f64 = pen.dashes.iter().sum::<f64>() * scale;
    let length: f64 = path.points().windows(2).map(|p| f64::from(p[0].distance(p[1]))).sum();
    if !(period > 0.0 && length / period * pen.dashes.len() as f64 <= MOST_DASHES) {
        return None;
    }
    // An odd number of lengths goes round twice.
    let rounds = 1 + pen.dashes.len() % 2;
    let lengths = pen.dashes.repeat(rounds).iter().map(|d| (d * scale) as f32).collect();
    StrokeDash::new(lengths, (pen.dash_offset * scale) as f32)
}

/// What to paint with; `None` where that would not be seen.
fn ink(paint: &Paint, opacity: f32, view: Affine) -> Option<Ink<'static>> {
    let opacity = share(opacity);
    let color = |[r, g, b]: [u8; 3], alpha: f32| {
        let channel = |v: u8| f32::from(v) / 255.0;
        Color::from_rgba(channel(r), channel(g), channel(b), share(alpha))
    };
    let shader = match paint {
        Paint::Color(rgb) => Shader::SolidColor(color(*rgb, opacity)?),
        Paint::Gradient(gradient) => {
            let last = gradient.stops.last()?;
            let degenerate = || color(last.color, last.opacity * opacity).map(Shader::SolidColor);
            shader(gradient, opacity, view, &color).or_else(degenerate)?
        }
    };
    (opacity > 0.0).then(|| Ink { shader, ..Ink::default() })
}

fn shader(
    gradient: &Gradient,
    opacity: f32,
    view: Affine,
    color: &dyn Fn([u8; 3], f32) -> Option<Color>,
) -> Option<Shader<'static>> {
    let stop = |s: &super::Stop| Some(GradientStop::new(share(s.offset), color(s.color, s.opacity * opacity)?));
    let stops = gradient.stops.iter().map(stop).collect::<Option<Vec<_>>>()?;
    let mode = match gradient.spread {
        Spread::Pad => SpreadMode::Pad,
        Spread::Reflect => SpreadMode::Reflect,
        Spread::Repeat => SpreadMode::Repeat,
    };
    let to = (view * gradient.transform).as_coeffs();
    let far = |v: f64| v.is_finite() && v.abs() < 1e12;
    if !to.iter().copied().all(far) {
        return None;
    }
    let [a, b, c, d, e, f] = to.map(|v| v as f32);
    let to = Transform::from_row(a, b, c, d, e, f);
    let at = |p: Point| (far(p.x) && far(p.y)).then(|| tiny_skia::Point::from_xy(p.x as f32, p.y as f32));
    match gradient.shape {
        GradientShape::Linear { from, to: end } => LinearGradient::new(at(from)?, at(end)?, stops, mode, to),
        GradientShape::Radial { center, radius, focus } => {
            RadialGradient::new(at(focus)?, 0.0, at(center)?, far(radius).then_some(radius as f32)?, stops, mode, to)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::sketch::{Cap, Clip, Fill, GradientShape, Group, Join, Stop, Stroke};
    use kurbo::{Rect, Shape};
    use proptest::prelude::*;

    fn rect(x0: f64, y0: f64, x1: f64, y1: f64) -> BezPath {
        Rect::new(x0, y0, x1, y1).to_path(0.1)
    }

    fn filled(path: BezPath, color: [u8; 3], group: Option<usize>) -> Stroke {
        let fill = Some(Fill { paint: Paint::Color(color), opacity: 1.0, even_odd: false });
        Stroke { path, fill, group, ..Stroke::default() }
    }

    fn pen(width: f64) -> Pen {
        let paint = Paint::Color([0, 0, 255]);
        Pen {
            paint,
            opacity: 1.0,
            width,
            widths: vec![],
            cap: Cap::Butt,
            join: Join::Miter,
            miter_limit: 4.0,
            dashes: vec![],
            dash_offset: 0.0,
        }
    }

    fn draw(drawing: &Drawing) -> RgbaImage {
        let canvas = SketchCanvas::page(drawing, 1.0).expect("a page");
        draw_sketch(drawing, &SketchTake::still(drawing), 0, &canvas)
    }

    fn at(picture: &RgbaImage, x: u32, y: u32) -> [u8; 4] {
        picture.get_pixel(x, y).0
    }

    #[test]
    fn layers_order_what_is_in_front_and_pens_lie_where_they_are_told() {
        let mut drawing = Drawing { size: (40.0, 20.0), ..Drawing::default() };
        drawing.strokes = vec![
            filled(rect(0.0, 0.0, 20.0, 20.0), [255, 0, 0], None),
            filled(rect(10.0, 0.0, 40.0, 20.0), [0, 255, 0], None),
        ];
        drawing.strokes[1].pen = Some(pen(4.0));
        let canvas = SketchCanvas::page(&drawing, 1.0).expect("a page");
        let mut take = SketchTake::still(&drawing);
        let picture = draw_sketch(&drawing, &take, 0, &canvas);
        assert_eq!((at(&picture, 15, 10), at(&picture, 11, 10)), ([0, 255, 0, 255], [0, 0, 255, 255]));
        take.order = vec![1, 0];
        assert_eq!(at(&draw_sketch(&drawing, &take, 0, &canvas), 15, 10), [255, 0, 0, 255]);
        drawing.strokes[1].pen_below = true;
        let picture = draw(&drawing);
        assert_eq!((at(&picture, 11, 10), at(&picture, 9, 10)), ([0, 255, 0, 255], [0, 0, 255, 255]));
    }

    #[test]
    fn groups_are_seen_through_as_a_whole_and_cut_by_their_clips() {
        let clip = |path| Some(Clip { path, even_odd: false });
        let group = |parent, opacity, clip| Group { name: String::new(), parent, opacity, clip };
        let groups = vec![group(None, 0.5, None), group(Some(0), 1.0, clip(rect(5.0, 5.0, 30.0, 30.0)))];
        let strokes = vec![
            filled(rect(0.0, 0.0, 40.0, 20.0), [255, 0, 0], Some(0)),
            filled(rect(0.0, 10.0, 40.0, 40.0), [0, 255, 0], Some(1)),
        ];
        let picture = draw(&Drawing { size: (40.0, 40.0), strokes, groups });
        // Where both lie only the front one is seen, and half of the nothing behind.
        let near = |x, y, rgb: [u8; 3]| {
            let own = at(&picture, x, y);
            assert!(own[..3] == rgb && own[3].abs_diff(128) <= 1, "{x} {y}: {own:?}");
        };
        near(20, 15, [0, 255, 0]);
        near(2, 15, [255, 0, 0]);
        near(20, 25, [0, 255, 0]);
        assert_eq!(at(&picture, 20, 35), [0; 4]);
        assert_eq!(at(&picture, 2, 25), [0; 4]);
    }

    #[test]
    fn gradients_go_along_with_their_stroke() {
        let stop = |offset, color| Stop { offset, color, opacity: 1.0 };
        let gradient = Gradient {
            shape: GradientShape::Linear { from: Point::new(0.0, 0.0), to: Point::new(10.0, 0.0) },
            transform: Affine::IDENTITY,
            spread: Spread::Pad,
            stops: vec![stop(0.0, [0; 3]), stop(1.0, [255; 3])],
        };
        let mut stroke = filled(rect(0.0, 0.0, 10.0, 10.0), [0; 3], None);
        stroke.fill = Some(Fill { paint: Paint::Gradient(gradient), opacity: 1.0, even_odd: false });
        let drawing = Drawing { size: (40.0, 10.0), strokes: vec![stroke], groups: vec![] };
        let mut take = SketchTake::still(&drawing);
        let moved = Affine::translate((30.0, 0.0));
        let frame =
            SketchFrame { paths: vec![moved * drawing.strokes[0].path.clone()], clips: vec![], affines: vec![moved] };
        take.frames.push(frame);
        let canvas = SketchCanvas::page(&drawing, 1.0).expect("a page");
        let (first, second) = (draw_sketch(&drawing, &take, 0, &canvas), draw_sketch(&drawing, &take, 1, &canvas));
        assert!(at(&first, 1, 5)[0] < 50 && at(&first, 8, 5)[0] > 200);
        assert!((0..10).all(|x| at(&first, x, 5)[0].abs_diff(at(&second, x + 30, 5)[0]) <= 1));
    }

    #[test]
    fn the_page_grows_to_what_leaves_it() {
        let mut drawing = Drawing { size: (40.0, 40.0), ..Drawing::default() };
        drawing.strokes = vec![filled(rect(10.0, 10.0, 20.0, 20.0), [255, 0, 0], None)];
        drawing.strokes[0].pen = Some(pen(4.0));
        let mut take = SketchTake::still(&drawing);
        let still = SketchCanvas::around(&drawing, &take, 2.0).expect("a page");
        assert_eq!(still, SketchCanvas::page(&drawing, 2.0).expect("a page"));
        let mut frame = take.frames[0].clone();
        frame.paths[0] = Affine::translate((-30.0, 5.0)) * frame.paths[0].clone();
        take.frames.push(frame);
        let grown = SketchCanvas::around(&drawing, &take, 2.0).expect("a page");
        assert_eq!(grown.shown(), Rect::new(-23.0, 0.0, 40.0, 40.0));
        let picture = draw_sketch(&drawing, &take, 1, &grown);
        assert_eq!((at(&picture, 2, 40)[3], at(&picture, 0, 40)[3]), (255, 0));
        // Beyond its clip nothing of it is seen.
        drawing.groups = vec![Group { name: String::new(), parent: None, opacity: 1.0, clip: Some(Clip::default()) }];
        drawing.strokes[0].group = Some(0);
        take.frames.iter_mut().for_each(|f| f.clips = vec![rect(-15.0, 0.0, 40.0, 40.0)]);
        let cut = SketchCanvas::around(&drawing, &take, 2.0).expect("a page");
        assert_eq!(cut.shown(), Rect::new(-16.0, 0.0, 40.0, 40.0));
        assert!(SketchCanvas::page(&drawing, 1e6).is_err() && SketchCanvas::page(&Drawing::default(), 1.0).is_err());
    }

    fn number() -> impl Strategy<Value = f64> {
        let special = [f64::NAN, f64::INFINITY, -1e300, 1e300, 1e9, 0.0, -0.0, 1e-310];
        prop_oneof![4 => -50.0..100.0f64, 1 => proptest::sample::select(special.to_vec())]
    }

    fn path() -> impl Strategy<Value = BezPath> {
        let point = || (number(), number()).prop_map(Point::from);
        let element = prop_oneof![
            point().prop_map(PathEl::MoveTo),
            point().prop_map(PathEl::LineTo),
            (point(), point()).prop_map(|(a, b)| PathEl::QuadTo(a, b)),
            (point(), point(), point()).prop_map(|(a, b, c)| PathEl::CurveTo(a, b, c)),
            Just(PathEl::ClosePath),
        ];
        (point(), proptest::collection::vec(element, 0..6))
            .prop_map(|(start, rest)| BezPath::from_vec(std::iter::once(PathEl::MoveTo(start)).chain(rest).collect()))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]
        #[test]
        fn nothing_is_too_odd_to_be_drawn(
            paths in proptest::collection::vec(path(), 1..4), clip in path(), width in number(), dash in number(),
            widths in proptest::collection::vec(number(), 0..4), at in proptest::collection::vec(number(), 6), opacity in number(),
        ) {
            let stop = |offset: f64| Stop { offset: offset as f32, color: [9; 3], opacity: opacity as f32 };
            let transform = Affine::new([at[0], at[1], at[2], at[3], at[4], at[5]]);
            let shapes = [
                GradientShape::Linear { from: Point::new(at[0], at[1]), to: Point::new(at[2], at[3]) },
                GradientShape::Radial { center: Point::new(at[0], at[1]), radius: at[2], focus: Point::new(at[3], at[4]) },
            ];
            let groups = vec![Group { name: String::new(), parent: Some(3), opacity: opacity as f32, clip: Some(Clip { path: clip, even_odd: true }) }];
            let strokes: Vec<Stroke> = paths.into_iter().enumerate().map(|(i, path)| {
                let stops = vec![stop(at[5]), stop(at[0])];
                let paint = Paint::Gradient(Gradient { shape: shapes[i % 2], transform, spread: Spread::Repeat, stops });
                let fill = Some(Fill { paint: paint.clone(), opacity: 1.0, even_odd: i == 0 });
                let widths = if i == 1 { widths.iter().map(|w| *w as f32).collect() } else { vec![] };
                let pen = Some(Pen { paint, widths, dashes: vec![dash, 3.0, at[4]], join: Join::Round, cap: Cap::Square, ..pen(width) });
                Stroke { path, fill, pen, group: Some(i), ..Stroke::default() }
            }).collect();
            let drawing = Drawing { size: (50.0, 40.0), strokes, groups };
            let take = SketchTake::still(&drawing);
            let canvas = SketchCanvas::page(&drawing, 1.0).expect("a page");
            let picture = draw_sketch(&drawing, &take, 0, &canvas);
            prop_assert!(picture == draw_sketch(&drawing, &take, 0, &canvas));
            drop(SketchCanvas::around(&drawing, &take, 1.0));
        }
    }
}
