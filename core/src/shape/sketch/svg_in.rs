//! Reading a drawing from SVG.
//!
//! usvg resolves styles, units, references and references to references; it runs no script, and here it reads no file and
//! no network: pictures are never loaded. What a drawing cannot hold is left out and told: text, pictures, masks, filters,
//! patterns, blending. Transforms are applied to the paths; a pen under a transform that is no similarity draws a line
//! whose width changes with its direction, so it becomes a filled outline.
//!
//! Pens that were pressed: other programs see the filled outline of such a line, and the line itself is in attributes of
//! that path (see svg_out). They are believed as long as the outline is the one that they make:
//! after an edit by another program the edited outline is what counts.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::Path;

use kurbo::{Affine, BezPath, PathEl, Point, Rect, Shape, StrokeOpts};
use usvg::roxmltree;

use super::drawing::{
    Cap, Clip, Drawing, Fill, Gradient, GradientShape, Group, Join, MAX_STROKES, MIN_DASHES, Paint, Pen, Spread, Stop,
    Stroke,
};
use super::{pressed, svg_expansion};
use crate::error::{Error, Result};

/// The namespace of our own attributes.
pub(crate) const NAMESPACE: &str = "urn:marey:drawing";
/// Bytes of a file; illustrations of ten thousand paths have about ten million.
const MAX_BYTES: usize = 64 << 20;
/// Between the larger and the smaller stretch of a transform that still counts as a similarity.
const SIMILAR: f64 = 1.01;

/// A drawing as it was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SvgIn {
    /// The drawing.
    pub drawing: Drawing,
    /// What the file has that the drawing has not, for a person: "2 texts", "the mask of `moon`".
    pub left_out: Vec<String>,
}

impl Drawing {
    /// Reads an SVG file.
    ///
    /// # Errors
    /// The file cannot be read, or what it says is no drawing, see [`Self::from_svg`].
    pub fn read_svg(path: impl AsRef<Path>) -> Result<SvgIn> {
        let path = path.as_ref();
        let size = std::fs::metadata(path).map_err(|e| Error::io(path, "read", e))?.len();
        too_long(size)?;
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, "read", e))?;
        Self::from_svg(bytes).map_err(|e| e.in_file(path))
    }

    /// Reads the text of an SVG.
    ///
    /// # Errors
    /// It is no SVG, has no path that could be drawn, or is beyond what an engine should be asked to take.
    pub fn from_svg(svg: impl AsRef<[u8]>) -> Result<SvgIn> {
        let bytes = svg.as_ref();
        too_long(bytes.len() as u64)?;
        let unreadable = |problem: String| Error::invalid("SVG", problem, "save it as plain SVG in UTF-8");
        if bytes.starts_with(&[0x1f, 0x8b]) {
            return Err(unreadable("it is compressed".into()));
        }
        let text =
            std::str::from_utf8(bytes).map_err(|e| unreadable(format!("not UTF-8 from byte {}", e.valid_up_to())))?;
        let options = roxmltree::ParsingOptions { allow_dtd: true, nodes_limit: 4_000_000, ..Default::default() };
        let xml = roxmltree::Document::parse_with_options(text.trim_start_matches('\u{feff}'), options)
            .map_err(|e| unreadable(format!("not readable: {e}")))?;
        svg_expansion::check(&xml)?;
        let options = usvg::Options {
            image_href_resolver: usvg::ImageHrefResolver {
                resolve_data: Box::new(|_, _, _| None),
                resolve_string: Box::new(|_, _| None),
            },
            ..Default::default()
        };
        let tree = usvg::Tree::from_xmltree(&xml, &options).map_err(|e| match e {
            usvg::Error::InvalidSize => {
                Error::invalid("SVG", "its page has no size", "give it a width and height above 0")
            }
            e => unreadable(e.to_string()),
        })?;
        Reader::new(&xml).read(&tree)
    }
}

fn too_long(bytes: u64) -> Result<()> {
    if bytes <= MAX_BYTES as u64 {
        return Ok(());
    }
    Err(Error::Limit {
        what: "the size of an SVG in bytes".into(),
        value: bytes,
        max: MAX_BYTES as u64,
        remedy: "take out embedded pictures, or simplify the drawing".into(),
    })
}

/// What the attributes of a pressed line's outline say.
struct Pressed {
    line: BezPath,
    width: f64,
    widths: Vec<f32>,
    /// The path whose line it is, when that is filled too.
    of: Option<String>,
}

struct Reader {
    pressed: HashMap<String, Pressed>,
    /// Names taken, and those that elements further on have.
    names: HashSet<String>,
    ids: HashSet<String>,
    unnamed: usize,
    out: SvgIn,
    told: BTreeSet<String>,
}

impl Reader {
    fn new(xml: &roxmltree::Document<'_>) -> Self {
        let mut told = BTreeSet::new();
        // Drawing programs keep their own format in foreign objects that nothing else shows.
        let seen = |n: &roxmltree::Node<'_, '_>| n.attribute("requiredExtensions").is_none();
        for (tag, name) in [
            ("text", "text"),
            ("image", "picture"),
            ("foreignObject", "foreign object"),
            ("video", "video"),
            ("script", "script"),
        ] {
            let n = xml.descendants().filter(|n| n.tag_name().name() == tag && seen(n)).count();
            if n > 0 {
                told.insert(format!("{n} {name}{}", if n == 1 { "" } else { "s" }));
            }
        }
        let mut pressed = HashMap::new();
        for node in xml.descendants().filter(|n| n.attribute((NAMESPACE, "widths")).is_some()) {
            let get = |name: &str| node.attribute((NAMESPACE, name));
            let line = get("line").and_then(|l| BezPath::from_svg(l).ok());
            let numbers =
                |s: &str| s.split_whitespace().map(|w| w.parse::<f32>().ok().filter(|w| w.is_finite())).collect();
            let widths: Option<Vec<f32>> = get("widths").and_then(numbers);
            let width = get("width").and_then(|w| w.parse::<f64>().ok()).filter(|w| *w > 0.0);
            if let (Some(id), Some(line), Some(widths), Some(width)) = (node.attribute("id"), line, widths, width) {
                pressed.insert(id.to_owned(), Pressed { line, width, widths, of: get("of").map(str::to_owned) });
            }
        }
        let ids = xml.descendants().filter_map(|n| n.attribute("id")).map(str::to_owned).collect();
        Self { pressed, names: HashSet::new(), ids, unnamed: 0, out: SvgIn::default(), told }
    }

    fn read(mut self, tree: &usvg::Tree) -> Result<SvgIn> {
        self.out.drawing.size = (tree.size().width().into(), tree.size().height().into());
        self.group(tree.root(), None)?;
        self.join_lines();
        self.drop_empty_groups();
        self.out.left_out = self.told.into_iter().collect();
        if self.out.drawing.strokes.is_empty() {
            let problem = if self.out.left_out.is_empty() {
                "it draws nothing".to_owned()
            } else {
                format!("it draws nothing but what is left out ({})", self.out.left_out.join(", "))
            };
            return Err(Error::invalid("SVG", problem, "draw paths, or turn texts into paths and trace pictures"));
        }
        self.out.drawing.validate()?;
        Ok(self.out)
    }

    fn group(&mut self, group: &usvg::Group, mut parent: Option<usize>) -> Result<()> {
        let name = group.id();
        let what = called(name, "a group");
        if group.mask().is_some() {
            self.told.insert(format!("the mask of {what}"));
        }
        if !group.filters().is_empty() {
            self.told.insert(format!("the filter of {what}"));
        }
        if group.blend_mode() != usvg::BlendMode::Normal {
            self.told.insert(format!("the blending of {what}"));
        }
        // A clip that is clipped itself shows what both show.
        let mut clips = Vec::new();
        let mut clip = group.clip_path();
        while let Some(c) = clip {
            let at = affine(group.abs_transform()) * affine(c.transform());
            clips.push(self.clip(c.root(), at, &what));
            clip = c.clip_path();
        }
        if clips.iter().any(|c| c.path.elements().is_empty()) {
            return Ok(());
        }
        let opacity = group.opacity().get();
        // The opacity of a path that has one paint is that of its paint.
        if name.is_empty()
            && clips.is_empty()
            && let [usvg::Node::Path(path)] = group.children()
            && path.fill().is_some() != path.stroke().is_some()
        {
            return self.path(path, parent, opacity);
        }
        let groups = &mut self.out.drawing.groups;
        let innermost = clips.pop();
        for clip in clips {
            groups.push(Group { name: String::new(), parent, opacity: 1.0, clip: Some(clip) });
            parent = Some(groups.len() - 1);
        }
        if !name.is_empty() || innermost.is_some() || opacity < 1.0 {
            groups.push(Group { name: name.to_owned(), parent, opacity, clip: innermost });
            parent = Some(groups.len() - 1);
        }
        for node in group.children() {
            match node {
                usvg::Node::Group(g) => self.group(g, parent)?,
                usvg::Node::Path(p) => self.path(p, parent, 1.0)?,
                usvg::Node::Image(_) | usvg::Node::Text(_) => {}
            }
        }
        Ok(())
    }

    /// The area of a clip: all its shapes together.
    fn clip(&mut self, root: &usvg::Group, at: Affine, what: &str) -> Clip {
        let (mut shapes, mut inner) = (Vec::new(), false);
        let mut groups = vec![root];
        while let Some(group) = groups.pop() {
            inner |= group.clip_path().is_some();
            for node in group.children() {
                match node {
                    usvg::Node::Group(g) => groups.push(g),
                    usvg::Node::Path(p) if p.is_visible() => {
                        let even_odd = p.fill().is_some_and(|f| f.rule() == usvg::FillRule::EvenOdd);
                        shapes.push((at * affine(p.abs_transform()) * bez_path(p.data()), even_odd));
                    }
                    _ => {}
                }
            }
        }
        if inner {
            self.told.insert(format!("the clips of shapes within the clip of {what}"));
        }
        if let [(path, even_odd)] = &shapes[..] {
            return Clip { path: path.clone(), even_odd: *even_odd };
        }
        // Together by the nonzero rule, so all must turn the same way.
        let mut path = BezPath::new();
        for (shape, even_odd) in shapes {
            if even_odd {
                self.told.insert(format!("the even-odd rule in the clip of {what}"));
            }
            path.extend(if shape.area() < 0.0 { shape.reverse_subpaths() } else { shape });
        }
        Clip { path, even_odd: false }
    }

    fn path(&mut self, path: &usvg::Path, group: Option<usize>, opacity: f32) -> Result<()> {
        if !path.is_visible() {
            return Ok(());
        }
        if self.out.drawing.strokes.len() >= MAX_STROKES {
            return Err(Error::Limit {
                what: "strokes of a drawing".into(),
                value: MAX_STROKES as u64 + 1,
                max: MAX_STROKES as u64,
                remedy: "simplify the drawing".into(),
            });
        }
        let at = affine(path.abs_transform());
        let local = bez_path(path.data());
        let fill = path.fill().and_then(|fill| {
            let paint = self.paint(fill.paint(), at, path.id())?;
            let even_odd = fill.rule() == usvg::FillRule::EvenOdd;
            Some(Fill { paint, opacity: fill.opacity().get() * opacity, even_odd })
        });
        let pen_below = path.paint_order() == usvg::PaintOrder::StrokeAndFill;
        let mut line = None;
        let mut pen = None;
        if let Some(stroke) = path.stroke()
            && let Some(paint) = self.paint(stroke.paint(), at, path.id())
        {
            let mut local_pen = pen_of(stroke, paint, opacity);
            let (large, small) = stretches(at);
            let finest = local_pen.dashes.iter().sum::<f64>() * small;
            if !local_pen.dashes.is_empty() && finest < MIN_DASHES {
                self.told.insert(format!("dashes too fine to see, of {}", called(path.id(), "a path")));
                local_pen.dashes.clear();
            }
            if large <= small * SIMILAR {
                let scale = (large * small).sqrt();
                local_pen.width *= scale;
                local_pen.dashes.iter_mut().for_each(|d| *d *= scale);
                local_pen.dash_offset *= scale;
                pen = Some(local_pen);
            } else {
                let outline = at * outlined(&local, &local_pen, 0.02 / large.max(1e-6));
                let Pen { paint, opacity, .. } = local_pen;
                line = Some((outline, Fill { paint, opacity, even_odd: false }));
            }
        }
        let shape = at * local;
        let pressed = self.pressed.remove(path.id());
        let name = self.name(path.id());
        let both = fill.is_some() && line.is_some();
        let mut strokes = Vec::new();
        if let (Some(pressed), Some(fill), None) = (&pressed, &fill, &pen) {
            strokes.push(self.press(pressed, &name, &shape, fill, at).unwrap_or_else(|| Stroke {
                name: name.clone(),
                path: shape.clone(),
                fill: Some(fill.clone()),
                group,
                ..Stroke::default()
            }));
            if let Some(of) = &pressed.of
                && strokes[0].pen.is_some()
            {
                // Marked for `join_lines`; no name in a file holds a NUL.
                strokes[0].name = format!("\0{of}");
            }
        } else if fill.is_some() || pen.is_some() {
            strokes.push(Stroke { name: name.clone(), path: shape, fill, pen, pen_below, group });
        }
        if let Some((path, fill)) = line {
            let name = if both { self.name(&format!("{name}-line")) } else { name };
            let outline = Stroke { name, path, fill: Some(fill), ..Stroke::default() };
            strokes.insert(if pen_below { 0 } else { strokes.len() }, outline);
        }
        strokes.iter_mut().for_each(|s| s.group = group);
        self.out.drawing.strokes.extend(strokes);
        Ok(())
    }

    /// The line that makes an outline, when it is still that outline.
    fn press(&mut self, pressed: &Pressed, name: &str, shape: &BezPath, fill: &Fill, at: Affine) -> Option<Stroke> {
        let (large, small) = stretches(at);
        let scale = (large * small).sqrt();
        let pen = Pen {
            paint: fill.paint.clone(),
            opacity: fill.opacity,
            widths: pressed.widths.iter().map(|w| (f64::from(*w) * scale) as f32).collect(),
            ..Pen::plain(pressed.width * scale)
        };
        let path = at * pressed.line.clone();
        let points = path.elements().iter().filter(|e| !matches!(e, PathEl::ClosePath)).count();
        let again = pressed::outline(&path, &pen.widths, &pen);
        let near = |a: Rect, b: Rect| {
            let off = (a.origin() - b.origin()).hypot().max((a.x1 - b.x1).hypot(a.y1 - b.y1));
            // Other programs round to a tenth or hundredth of a pixel.
            off <= 0.2 + 0.005 * (a.width() + a.height())
        };
        if points != pen.widths.len() || large > small * SIMILAR || !near(again.bounding_box(), shape.bounding_box()) {
            self.told.insert(format!("the pressure of `{name}`, whose outline was edited"));
            return None;
        }
        Some(Stroke { name: name.to_owned(), path, pen: Some(pen), ..Stroke::default() })
    }

    /// Gives pressed lines back to the filled paths that they belong to.
    fn join_lines(&mut self) {
        let strokes = &mut self.out.drawing.strokes;
        let mut i = 0;
        while i < strokes.len() {
            let Some(of) = strokes[i].name.strip_prefix('\0').map(str::to_owned) else {
                i += 1;
                continue;
            };
            let mut beside = [i.checked_sub(1), Some(i + 1)].into_iter().flatten();
            let owner = beside.find(|&k| strokes.get(k).is_some_and(|s| s.name == of && s.pen.is_none()));
            if let Some(k) = owner {
                strokes[k].pen = strokes[i].pen.take();
                strokes[k].pen_below = i < k;
                strokes.remove(i);
            } else {
                strokes[i].name = String::new();
                i += 1;
            }
        }
        for i in 0..self.out.drawing.strokes.len() {
            if self.out.drawing.strokes[i].name.is_empty() {
                self.out.drawing.strokes[i].name = self.name("");
            }
        }
    }

    /// Takes out groups in which nothing is.
    fn drop_empty_groups(&mut self) {
        let Drawing { strokes, groups, .. } = &mut self.out.drawing;
        let mut used = vec![false; groups.len()];
        for stroke in strokes.iter() {
            let mut at = stroke.group;
            while let Some(g) = at.filter(|&g| !std::mem::replace(&mut used[g], true)) {
                at = groups[g].parent;
            }
        }
        let mut kept = 0;
        let places: Vec<Option<usize>> = used
            .iter()
            .map(|&used| {
                kept += usize::from(used);
                used.then(|| kept - 1)
            })
            .collect();
        let mut keep = used.iter();
        groups.retain(|_| *keep.next().unwrap_or(&false));
        groups.iter_mut().for_each(|g| g.parent = g.parent.and_then(|p| places[p]));
        strokes.iter_mut().for_each(|s| s.group = s.group.and_then(|g| places[g]));
    }

    /// A name of its own: the id, the id and a number where it is taken, or "path" and a number.
    fn name(&mut self, id: &str) -> String {
        if !id.is_empty() && self.names.insert(id.to_owned()) {
            return id.to_owned();
        }
        let mut n = if id.is_empty() { self.unnamed } else { 1 };
        loop {
            n += 1;
            let name = if id.is_empty() { format!("path{n}") } else { format!("{id}-{n}") };
            if id.is_empty() {
                self.unnamed = n;
            }
            if !self.ids.contains(&name) && self.names.insert(name.clone()) {
                return name;
            }
        }
    }

    fn paint(&mut self, paint: &usvg::Paint, at: Affine, id: &str) -> Option<Paint> {
        let (base, shape, inner) = match paint {
            usvg::Paint::Color(c) => return Some(Paint::Color([c.red, c.green, c.blue])),
            usvg::Paint::Pattern(_) => {
                self.told.insert(format!("the pattern of {}", called(id, "a path")));
                return None;
            }
            usvg::Paint::LinearGradient(g) => {
                let (from, to) = (point(g.x1(), g.y1()), point(g.x2(), g.y2()));
                (&***g, GradientShape::Linear { from, to }, 0.0)
            }
            usvg::Paint::RadialGradient(g) => {
                let radius = f64::from(g.r().get());
                let shape =
                    GradientShape::Radial { center: point(g.cx(), g.cy()), radius, focus: point(g.fx(), g.fy()) };
                (&***g, shape, (g.fr().get() / g.r().get()).clamp(0.0, 1.0))
            }
        };
        let spread = match base.spread_method() {
            usvg::SpreadMethod::Pad => Spread::Pad,
            usvg::SpreadMethod::Reflect => Spread::Reflect,
            usvg::SpreadMethod::Repeat => Spread::Repeat,
        };
        // A focal circle moves the stops outward; exact where it lies about the centre.
        let stops = base.stops().iter().map(|s| Stop {
            offset: inner + s.offset().get() * (1.0 - inner),
            color: [s.color().red, s.color().green, s.color().blue],
            opacity: s.opacity().get(),
        });
        let transform = at * affine(base.transform());
        Some(Paint::Gradient(Gradient { shape, transform, spread, stops: stops.collect() }))
    }
}

fn called(id: &str, else_: &str) -> String {
    if id.is_empty() { else_.to_owned() } else { format!("`{id}`") }
}

fn pen_of(stroke: &usvg::Stroke, paint: Paint, opacity: f32) -> Pen {
    Pen {
        paint,
        opacity: stroke.opacity().get() * opacity,
        width: stroke.width().get().into(),
        widths: Vec::new(),
        cap: match stroke.linecap() {
            usvg::LineCap::Butt => Cap::Butt,
            usvg::LineCap::Round => Cap::Round,
            usvg::LineCap::Square => Cap::Square,
        },
        join: match stroke.linejoin() {
            usvg::LineJoin::Miter | usvg::LineJoin::MiterClip => Join::Miter,
            usvg::LineJoin::Round => Join::Round,
            usvg::LineJoin::Bevel => Join::Bevel,
        },
        miter_limit: stroke.miterlimit().get().into(),
        dashes: stroke.dasharray().unwrap_or_default().iter().map(|d| f64::from(*d)).collect(),
        dash_offset: stroke.dashoffset().into(),
    }
}

/// The filled outline of a line.
fn outlined(path: &BezPath, pen: &Pen, tolerance: f64) -> BezPath {
    let cap = match pen.cap {
        Cap::Butt => kurbo::Cap::Butt,
        Cap::Round => kurbo::Cap::Round,
        Cap::Square => kurbo::Cap::Square,
    };
    let join = match pen.join {
        Join::Miter => kurbo::Join::Miter,
        Join::Round => kurbo::Join::Round,
        Join::Bevel => kurbo::Join::Bevel,
    };
    let style = kurbo::Stroke::new(pen.width)
        .with_caps(cap)
        .with_join(join)
        .with_miter_limit(pen.miter_limit)
        .with_dashes(pen.dash_offset, pen.dashes.iter().copied());
    kurbo::stroke(path.elements().iter().copied(), &style, &StrokeOpts::default(), tolerance)
}

/// How much a transform stretches where it does so most and least.
fn stretches(at: Affine) -> (f64, f64) {
    let [a, b, c, d, ..] = at.as_coeffs();
    // The singular values of a 2x2 matrix by its parts that turn alike and against.
    let (alike, against) = ((a + d).hypot(b - c) / 2.0, (a - d).hypot(b + c) / 2.0);
    (alike + against, (alike - against).abs())
}

fn affine(t: usvg::Transform) -> Affine {
    Affine::new([t.sx, t.ky, t.kx, t.sy, t.tx, t.ty].map(f64::from))
}

fn point(x: f32, y: f32) -> Point {
    Point::new(x.into(), y.into())
}

fn bez_path(path: &tiny_skia::Path) -> BezPath {
    use tiny_skia::PathSegment;
    let at = |p: tiny_skia::Point| point(p.x, p.y);
    let mut out = BezPath::new();
    for segment in path.segments() {
        match segment {
            PathSegment::MoveTo(p) => out.move_to(at(p)),
            PathSegment::LineTo(p) => out.line_to(at(p)),
            PathSegment::QuadTo(a, p) => out.quad_to(at(a), at(p)),
            PathSegment::CubicTo(a, b, p) => out.curve_to(at(a), at(b), at(p)),
            PathSegment::Close => out.close_path(),
        }
    }
    out
}
