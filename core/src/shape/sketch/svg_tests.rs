//! Drawings from SVG and back: what is understood, what is refused, and that nothing is lost on the way.

use std::path::Path;

use kurbo::{Affine, BezPath, Point, Rect, Shape};
use proptest::prelude::*;

use super::drawing::*;
use super::svg_in::SvgIn;
use super::svg_out::path_data;

fn svg(body: &str) -> String {
    format!(
        "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink' width='100' height='80'>{body}</svg>"
    )
}

fn read(body: &str) -> Drawing {
    Drawing::from_svg(svg(body)).expect(body).drawing
}

fn bundled(name: &str) -> SvgIn {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/drawings").join(name);
    Drawing::read_svg(path).expect("a bundled drawing")
}

#[test]
fn transforms_styles_and_groups_are_resolved() {
    let drawing = read(
        "<style>.leg{stroke:#f00;stroke-width:2;fill:none}</style>
         <g id='body' transform='translate(10 20) scale(2)' opacity='0.5'>
           <path id='back' class='leg' d='M0 0L5 0' stroke-dasharray='1 2' stroke-dashoffset='1' stroke-linecap='round'/>
           <rect width='4' height='3' style='fill:rgb(0,0,255);fill-opacity:.25' paint-order='stroke'/>
         </g>
         <path d='M1 1H9V9Z' fill-rule='evenodd'/>",
    );
    assert_eq!(drawing.size, (100.0, 80.0));
    let names: Vec<&str> = drawing.strokes.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["back", "path1", "path2"]);
    let [group] = &drawing.groups[..] else { panic!("{:?}", drawing.groups) };
    assert_eq!((group.name.as_str(), group.opacity, group.parent), ("body", 0.5, None));
    assert_eq!(drawing.strokes.iter().map(|s| s.group).collect::<Vec<_>>(), [Some(0), Some(0), None]);
    let back = &drawing.strokes[0];
    assert_eq!(back.path, BezPath::from_svg("M10 20L20 20").expect("a path"));
    let pen = back.pen.as_ref().expect("a pen");
    assert_eq!((pen.paint.clone(), pen.width, pen.cap), (Paint::Color([255, 0, 0]), 4.0, Cap::Round));
    assert_eq!((pen.dashes.as_slice(), pen.dash_offset), ([2.0, 4.0].as_slice(), 2.0));
    assert_eq!(
        drawing.strokes[1].fill.as_ref().map(|f| (f.paint.clone(), f.opacity)),
        Some((Paint::Color([0, 0, 255]), 0.25))
    );
    assert!(drawing.strokes[2].fill.as_ref().is_some_and(|f| f.even_odd));
    assert_eq!(drawing.bounds(), Some(Rect::new(1.0, 1.0, 22.0, 26.0)));
}

#[test]
fn gradients_and_clips_hold_on_the_page() {
    let drawing = read(
        "<defs><linearGradient id='g'><stop offset='0' stop-color='#f00'/><stop offset='1' stop-color='#00f' stop-opacity='.5'/></linearGradient>
         <clipPath id='c'><circle cx='10' cy='10' r='5'/></clipPath></defs>
         <g transform='translate(30 0)' clip-path='url(#c)'><rect x='0' y='0' width='20' height='20' fill='url(#g)'/></g>",
    );
    let clip = drawing.groups[0].clip.as_ref().expect("a clip");
    assert!((clip.path.area().abs() - std::f64::consts::PI * 25.0).abs() < 0.1);
    assert!((clip.path.bounding_box().center() - Point::new(40.0, 10.0)).hypot() < 1e-3);
    assert!(drawing.bounds().is_some_and(|b| (b.x0 - 35.0).abs() < 0.01 && (b.width() - 10.0).abs() < 0.01));
    let Some(Paint::Gradient(gradient)) = drawing.strokes[0].fill.as_ref().map(|f| f.paint.clone()) else {
        panic!("no gradient")
    };
    let GradientShape::Linear { from, to } = gradient.shape else { panic!("not linear") };
    assert!((gradient.transform * from - Point::new(30.0, 0.0)).hypot() < 1e-3);
    assert!((gradient.transform * to - Point::new(50.0, 0.0)).hypot() < 1e-3);
    assert_eq!(gradient.stops[1].opacity, 0.5);
}

#[test]
fn a_pen_that_is_stretched_becomes_a_filled_outline() {
    let drawing =
        read("<path id='a' d='M2 5H8' transform='scale(10 2)' fill='none' stroke='#123456' stroke-width='2'/>");
    let [stroke] = &drawing.strokes[..] else { panic!("one stroke") };
    assert!(stroke.pen.is_none());
    assert_eq!(stroke.fill.as_ref().map(|f| f.paint.clone()), Some(Paint::Color([0x12, 0x34, 0x56])));
    let b = stroke.path.bounding_box();
    assert!((b.x0 - 20.0).abs() < 0.01 && (b.x1 - 80.0).abs() < 0.01 && (b.height() - 4.0).abs() < 0.01, "{b:?}");
    let both =
        read("<path id='a' d='M2 5H8V9Z' transform='scale(10 2)' fill='red' stroke='#123456' paint-order='stroke'/>");
    assert_eq!(both.strokes.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["a-line", "a"]);
}

#[test]
fn names_are_unique_and_stable() {
    let drawing = read(
        "<path d='M0 0H5V5Z'/><path id='path1' d='M0 0H5V5Z'/><path id='a' d='M0 0H5V5Z'/><path id='a' d='M0 0H5V5Z'/>",
    );
    assert_eq!(drawing.strokes.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["path2", "path1", "a", "a-2"]);
}

#[test]
fn what_is_no_drawing_is_told_what_to_do() {
    let nest = |n: usize| svg(&format!("{}<path d='M0 0H5V5Z'/>{}", "<g>".repeat(n), "</g>".repeat(n)));
    let uses: String = (1..12)
        .map(|i| format!("<g id='u{i}'>{}</g>", format!("<use xlink:href='#u{}'/>", i - 1).repeat(10)))
        .collect();
    let patterns: String = (1..12)
        .map(|i| {
            let rects = format!("<rect width='1' height='1' style='fill:url(#p{})'/>", i - 1).repeat(10);
            format!("<pattern id='p{i}' width='1' height='1'>{rects}</pattern>")
        })
        .collect();
    let classes: String = (1..12)
        .map(|i| {
            let rects = format!("<rect class='c{}' width='1' height='1'/>", i - 1).repeat(10);
            format!("<style>.c{i}{{fill:url(#p{i})}}</style><pattern id='p{i}' width='1' height='1'>{rects}</pattern>")
        })
        .collect();
    let laughs: String = (1..12).map(|i| format!("<!ENTITY e{i} '{}'>", format!("&e{};", i - 1).repeat(10))).collect();
    for (bad, says) in [
        (String::new(), "not readable"),
        ("<svg".into(), "not readable"),
        ("<html/>".into(), "SVG"),
        (svg(""), "draws nothing"),
        (svg("<g id='empty'/>"), "draws nothing"),
        (svg("<text x='5' y='20'>Hello</text><text>you</text>"), "2 texts"),
        (svg("<image href='/etc/hostname' width='9' height='9'/>"), "1 picture"),
        (svg("<script>alert(1)</script>"), "1 script"),
        (svg("<path d='M5 5' stroke='red'/>"), "draws nothing"),
        (svg("<path d='M0 0H5V5Z' fill='none'/>"), "draws nothing"),
        (
            svg(
                "<path d='M0 0H5V5Z' fill='url(#p)'/><pattern id='p' width='1' height='1'><path d='M0 0H1V1Z'/></pattern>",
            ),
            "pattern",
        ),
        (svg("<path d='M0 0H5V5Z'/>").replace("'100'", "'0'"), "no size"),
        (svg("<path d='M0 0H5V5Z'/>").replace("'100'", "'-4'"), "no size"),
        (svg("<path d='M0 0H5V5Z'/>").replace("'100'", "'1e9'"), "page"),
        (svg("<path d='M0 0H1e9V5Z'/>"), "beyond"),
        (svg("<path d='M0 0H1e30V5Z'/>"), "SVG"),
        (nest(5_000), "nest"),
        (svg(&format!("<g id='u0'><path d='M0 0H5V5Z'/></g>{uses}")), "references followed"),
        (svg(&format!("<rect id='p0'/>{patterns}<path d='M0 0H5V5Z' fill='url(#p11)'/>")), "references followed"),
        (svg(&format!("{classes}<path class='c11' d='M0 0H5V5Z'/>")), "references followed"),
        (format!("<!DOCTYPE svg [<!ENTITY e0 'ha'>{laughs}]>{}", svg("<text>&e11;</text>")), "not readable"),
        (format!("<!DOCTYPE svg [<!ENTITY x SYSTEM 'file:///etc/hostname'>]>{}", svg("<text>&x;</text>")), "SVG"),
    ] {
        let error = Drawing::from_svg(&bad).expect_err(&bad[..bad.len().min(200)]).to_string();
        assert!(error.contains(says) || says == "SVG", "{error} for {}", &bad[..bad.len().min(200)]);
    }
    assert!(Drawing::from_svg([0x1f, 0x8b, 8]).is_err_and(|e| e.to_string().contains("compressed")));
    assert!(Drawing::from_svg([b'<', 0xff]).is_err_and(|e| e.to_string().contains("UTF-8")));
    assert!(Drawing::read_svg("no/such.svg").is_err_and(|e| e.to_string().contains("no/such.svg")));
    assert!(Drawing::from_svg(nest(100)).is_ok());
}

#[test]
fn what_is_left_out_is_told_and_the_rest_is_drawn() {
    let read = Drawing::from_svg(svg(
        "<defs><mask id='m'><rect width='9' height='9' fill='white'/></mask><filter id='f'><feGaussianBlur stdDeviation='1'/></filter></defs>
         <g id='moon' mask='url(#m)'><path d='M0 0H5V5Z'/></g><g id='fog' filter='url(#f)'><path d='M0 0H5V5Z'/></g>
         <text>Hi</text><script>evil()</script><path onclick='evil()' d='M0 0H5V5Z'/><use xlink:href='#me' id='me'/>
         <use xlink:href='http://example.com/a.svg#b'/>",
    ))
    .expect("a drawing");
    assert_eq!(read.drawing.strokes.len(), 3);
    assert_eq!(read.left_out, ["1 script", "1 text", "the filter of `fog`", "the mask of `moon`"]);
}

#[test]
fn dots_and_degenerate_paths_are_read() {
    let drawing = read(
        "<g fill='none' stroke='black' stroke-width='4' stroke-linecap='round'><path d='M5 5L5 5'/><path d='M5 5Z'/>
         <path d='M5 5C5 5 5 5 5 5'/><path d='M0 0L9 9L0 0'/><path d='M0 0L9 9L9 0L0 9Z'/><path d='M nan'/></g>",
    );
    assert!(drawing.strokes.len() >= 4);
    for stroke in &drawing.strokes {
        assert!(stroke.flatten(0.1).iter().all(|l| !l.is_empty()));
    }
}

#[test]
fn ten_thousand_strokes_are_read_and_written() {
    let body: String = (0..10_000).map(|i| format!("<path d='M{} {}l3 1' stroke='red'/>", i % 97, i / 130)).collect();
    let began = std::time::Instant::now();
    let drawing = read(&body);
    assert_eq!(drawing.strokes.len(), 10_000);
    assert_eq!(Drawing::from_svg(drawing.to_svg()).expect("our own").drawing, drawing);
    assert!(began.elapsed().as_secs() < 20);
}

#[test]
fn bundled_drawings_come_back_from_their_own_svg() {
    for (name, strokes) in [("horse.svg", 16), ("clipart/fish.svg", 16)] {
        let read = bundled(name);
        assert_eq!((read.drawing.strokes.len(), read.left_out.len()), (strokes, 0), "{name}");
        let again = Drawing::from_svg(read.drawing.to_svg()).expect("our own").drawing;
        same(&again, &read.drawing).expect(name);
    }
}

#[test]
fn an_edited_outline_counts_more_than_its_pressure() {
    let mut drawing = read("<path id='a' d='M10 10L50 50' stroke='red'/>");
    drawing.strokes[0].fill = None;
    drawing.strokes[0].pen = Some(Pen { widths: vec![2.0, 8.0], ..Pen::plain(4.0) });
    let text = drawing.to_svg();
    same(&Drawing::from_svg(&text).expect("ours").drawing, &drawing).expect("the same");
    // Moved as a whole by another program, it is still a line.
    let moved = text.replace("<path id=\"a\"", "<path transform=\"translate(20 0)\" id=\"a\"");
    assert_ne!(moved, text);
    let moved = Drawing::from_svg(moved).expect("ours").drawing;
    assert_eq!(moved.strokes[0].path, BezPath::from_svg("M30 10L70 50").expect("a path"));
    let edited = text.replace("d=\"M", "d=\"M0 0L");
    let read = Drawing::from_svg(edited).expect("an outline");
    assert!(read.drawing.strokes[0].pen.is_none() && read.left_out[0].contains("pressure"));
}

/// Equal to single precision.
fn same(a: &Drawing, b: &Drawing) -> Result<(), String> {
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-4 * (1.0 + b.abs());
    let paths = |a: &BezPath, b: &BezPath| {
        let numbers = |p: &BezPath| -> Vec<f64> {
            path_data(p).split(|c: char| c == ' ' || c.is_ascii_uppercase()).filter_map(|s| s.parse().ok()).collect()
        };
        let kinds = |p: &BezPath| p.elements().iter().map(std::mem::discriminant).collect::<Vec<_>>();
        kinds(a) == kinds(b) && numbers(a).iter().zip(numbers(b)).all(|(a, b)| near(*a, b))
    };
    let paints = |a: &Paint, b: &Paint| match (a, b) {
        (Paint::Gradient(a), Paint::Gradient(b)) => {
            let at = |g: &Gradient| match g.shape {
                GradientShape::Linear { from, to } => [g.transform * from, g.transform * to, Point::ZERO],
                GradientShape::Radial { center, radius, focus } => {
                    [g.transform * center, g.transform * focus, g.transform * (center + kurbo::Vec2::new(radius, 0.0))]
                }
            };
            let places = at(a).iter().zip(at(b)).all(|(a, b)| near(a.x, b.x) && near(a.y, b.y));
            let stops =
                a.stops.iter().zip(&b.stops).all(|(a, b)| a.color == b.color && near(a.offset.into(), b.offset.into()));
            places && stops && a.spread == b.spread && a.stops.len() == b.stops.len()
        }
        (a, b) => a == b,
    };
    let fills = |a: &Fill, b: &Fill| {
        paints(&a.paint, &b.paint) && a.even_odd == b.even_odd && near(a.opacity.into(), b.opacity.into())
    };
    let pens = |a: &Pen, b: &Pen| {
        paints(&a.paint, &b.paint)
            && (a.cap, a.join) == (b.cap, b.join)
            && near(a.width, b.width)
            && (a.dashes.len(), a.widths.len()) == (b.dashes.len(), b.widths.len())
            && a.dashes.iter().zip(&b.dashes).all(|(a, b)| near(*a, *b))
            && a.widths.iter().zip(&b.widths).all(|(a, b)| near((*a).into(), (*b).into()))
    };
    for (a, b) in a.strokes.iter().zip(&b.strokes) {
        let fill = a.fill.as_ref().zip(b.fill.as_ref()).is_none_or(|(a, b)| fills(a, b))
            && a.fill.is_some() == b.fill.is_some();
        let pen =
            a.pen.as_ref().zip(b.pen.as_ref()).is_none_or(|(a, b)| pens(a, b)) && a.pen.is_some() == b.pen.is_some();
        let below = a.pen_below == b.pen_below;
        if !(a.name == b.name && paths(&a.path, &b.path) && fill && pen && below && a.group == b.group) {
            return Err(format!("{a:?}\nis not\n{b:?}"));
        }
    }
    let groups = |d: &Drawing| {
        d.groups.iter().map(|g| (g.name.clone(), g.parent, g.clip.as_ref().map(|c| c.even_odd))).collect::<Vec<_>>()
    };
    let clips = a.groups.iter().zip(&b.groups).all(|(a, b)| match (&a.clip, &b.clip) {
        (Some(a), Some(b)) => paths(&a.path, &b.path),
        _ => true,
    });
    if a.strokes.len() != b.strokes.len() || groups(a) != groups(b) || !clips || a.size != b.size {
        return Err(format!("{:?}\nis not\n{:?}", a.groups, b.groups));
    }
    Ok(())
}

fn paint() -> impl Strategy<Value = Paint> {
    let gradient = (any::<bool>(), 0.0..100.0f64, 1.0..80.0f64, -1.0..1.0f64, any::<[u8; 3]>(), any::<[u8; 3]>())
        .prop_map(|(radial, x, r, turn, from, to)| {
            let shape = if radial {
                GradientShape::Radial { center: Point::new(x, 30.0), radius: r, focus: Point::new(x + r / 4.0, 30.0) }
            } else {
                GradientShape::Linear { from: Point::new(x, 30.0), to: Point::new(x + r, 20.0) }
            };
            let stop = |offset: f32, color| Stop { offset, color, opacity: 1.0 };
            Paint::Gradient(Gradient {
                shape,
                transform: Affine::rotate(turn) * Affine::scale_non_uniform(1.5, 0.5),
                spread: if turn > 0.0 { Spread::Reflect } else { Spread::Pad },
                stops: vec![stop(0.25, from), stop(0.75, to)],
            })
        });
    prop_oneof![any::<[u8; 3]>().prop_map(Paint::Color), gradient]
}

fn stroke() -> impl Strategy<Value = Stroke> {
    let points = prop::collection::vec((0.0..100.0f64, 0.0..80.0f64), 7..8);
    let look = (any::<[bool; 6]>(), 0.05..1.0f32, 0.5..9.0f64);
    (points, paint(), paint(), look, "[a-z<&\"' ]{0,6}").prop_map(|(p, fill, line, (flags, opacity, width), name)| {
        let at = |i: usize| Point::new(p[i].0, p[i].1);
        let mut path = BezPath::new();
        path.move_to(at(0));
        path.line_to(at(1));
        path.quad_to(at(2), at(3));
        path.curve_to(at(4), at(5), at(6));
        let [closed, filled, lined, below, pressed, dashed] = flags;
        if closed {
            path.close_path();
        }
        let fill = (filled || !lined).then_some(Fill { paint: fill, opacity, even_odd: closed });
        let pen = lined.then(|| Pen {
            paint: line,
            opacity,
            widths: if pressed { vec![1.0, 2.5, width as f32, 4.0] } else { vec![] },
            dashes: if dashed && !pressed { vec![width, 2.0] } else { vec![] },
            ..Pen::plain(width)
        });
        let pen_below = below && fill.is_some() && pen.is_some();
        Stroke { name, path, fill, pen, pen_below, group: None }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn what_is_written_is_read_back(strokes in prop::collection::vec(stroke(), 1..8), opacity in 0.1..1.0f32) {
        let clip = Clip { path: BezPath::from_svg("M5 5H90V70Z").expect("a path"), even_odd: true };
        let mut drawing = Drawing {
            size: (100.0, 80.0),
            strokes,
            groups: vec![
                Group { name: "all & <more>".into(), parent: None, opacity, clip: None },
                Group { name: "clipped".into(), parent: Some(0), opacity: 1.0, clip: Some(clip) },
            ],
        };
        let count = drawing.strokes.len();
        for (i, stroke) in drawing.strokes.iter_mut().enumerate() {
            stroke.name = format!("{}{i}", stroke.name.trim_start());
            stroke.group = if i + 1 == count { Some(1) } else if i > 0 { Some(0) } else { None };
        }
        drawing.validate().expect("a valid drawing");
        let read = Drawing::from_svg(drawing.to_svg()).expect("our own SVG");
        prop_assert_eq!(read.left_out.len(), 0, "{:?}", read.left_out);
        if let Err(differs) = same(&read.drawing, &drawing) {
            prop_assert!(false, "{}", differs);
        }
    }
}
