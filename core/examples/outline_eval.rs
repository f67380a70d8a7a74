//! Outlines of drawings, to look at: contact sheets of the drawings in folders with their outlines in red (enclosed) or
//! blue (shrink-wrapped), and a line for each with the numbers.
//!
//! `cargo run --release -p marey --example outline_eval -- OUT FOLDER...`
#![expect(clippy::print_stdout, reason = "an example speaks to a person")]

use std::path::{Path, PathBuf};
use std::time::Instant;

use kurbo::{BezPath, PathEl};
use marey::job::Progress;
use marey::shape::sketch::{Drawing, OutlineKind, Paint, pressed_outline};
use tiny_skia::{Color, FillRule, LineCap, LineJoin, PathBuilder, Pixmap, PixmapPaint, Stroke, Transform};

const CELL: u32 = 300;
const COLUMNS: usize = 5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let out = PathBuf::from(args.next().ok_or("OUT FOLDER...")?);
    std::fs::create_dir_all(&out)?;
    let mut files = Vec::new();
    for folder in args {
        for entry in std::fs::read_dir(folder)? {
            files.push(entry?.path());
        }
    }
    files.retain(|f| f.extension().is_some_and(|e| e == "svg"));
    files.sort();
    for (n, sheet) in files.chunks(COLUMNS * 4).enumerate() {
        let mut picture = Pixmap::new(CELL * COLUMNS as u32, CELL * 4).ok_or("no picture")?;
        picture.fill(Color::WHITE);
        for (i, file) in sheet.iter().enumerate() {
            let cell = cell(file).map_err(|e| format!("{}: {e}", file.display()))?;
            let (x, y) = (i % COLUMNS * CELL as usize, i / COLUMNS * CELL as usize);
            picture.draw_pixmap(
                x as i32,
                y as i32,
                cell.as_ref(),
                &PixmapPaint::default(),
                Transform::identity(),
                None,
            );
        }
        let (width, height) = (picture.width(), picture.height());
        let image = image::RgbaImage::from_raw(width, height, picture.take()).ok_or("no picture")?;
        image.save(out.join(format!("outlines{n}.png")))?;
    }
    Ok(())
}

fn cell(file: &Path) -> Result<Pixmap, Box<dyn std::error::Error>> {
    let began = Instant::now();
    let read = Drawing::read_svg(file)?;
    let reading = began.elapsed();
    let drawing = read.drawing;
    let began = Instant::now();
    let outline = drawing.outline(None, &Progress::new().whole())?;
    println!(
        "{:32} strokes {:4}  read {:6.1} ms  {:?} {:4} corners, {} apart, {:6.1} ms  left out {:?}",
        file.file_name().unwrap_or_default().to_string_lossy(),
        drawing.strokes.len(),
        reading.as_secs_f64() * 1e3,
        outline.kind,
        outline.polygon.len(),
        outline.apart,
        began.elapsed().as_secs_f64() * 1e3,
        read.left_out
    );
    let mut cell = Pixmap::new(CELL, CELL).ok_or("no picture")?;
    cell.fill(Color::WHITE);
    let bounds = drawing.bounds().ok_or("nothing drawn")?;
    let scale = f64::from(CELL - 20) / bounds.width().max(bounds.height());
    let to_cell = Transform::from_row(
        scale as f32,
        0.0,
        0.0,
        scale as f32,
        (10.0 - bounds.x0 * scale) as f32,
        (10.0 - bounds.y0 * scale) as f32,
    );
    for stroke in &drawing.strokes {
        let path = &stroke.path;
        if let Some(fill) = &stroke.fill {
            draw(&mut cell, path, &fill.paint, fill.opacity * 0.6, None, to_cell);
        }
        if let Some(pen) = &stroke.pen {
            let style = Stroke {
                width: pen.width as f32,
                line_cap: LineCap::Round,
                line_join: LineJoin::Round,
                ..Stroke::default()
            };
            if pen.widths.is_empty() {
                draw(&mut cell, path, &pen.paint, pen.opacity * 0.6, Some(style), to_cell);
            } else {
                draw(&mut cell, &pressed_outline(path, &pen.widths, pen), &pen.paint, pen.opacity, None, to_cell);
            }
        }
    }
    let mut path = BezPath::new();
    outline.polygon.iter().enumerate().for_each(|(i, p)| {
        let p = (f64::from(p.x), f64::from(p.y));
        if i == 0 { path.move_to(p) } else { path.line_to(p) }
    });
    path.close_path();
    let color = if outline.kind == OutlineKind::Enclosed { [255, 0, 0] } else { [0, 0, 255] };
    let style = Stroke { width: (1.5 / scale) as f32, ..Stroke::default() };
    draw(&mut cell, &path, &Paint::Color(color), 1.0, Some(style), to_cell);
    Ok(cell)
}

fn draw(cell: &mut Pixmap, path: &BezPath, paint: &Paint, opacity: f32, line: Option<Stroke>, at: Transform) {
    let [r, g, b] = match paint {
        Paint::Color(c) => *c,
        Paint::Gradient(g) => g.stops[0].color,
    };
    let paint = tiny_skia::Paint {
        shader: tiny_skia::Shader::SolidColor(Color::from_rgba8(r, g, b, (opacity * 255.0) as u8)),
        anti_alias: true,
        ..tiny_skia::Paint::default()
    };
    let mut out = PathBuilder::new();
    let p = |p: &kurbo::Point| (p.x as f32, p.y as f32);
    for el in path.elements() {
        match el {
            PathEl::MoveTo(a) => out.move_to(p(a).0, p(a).1),
            PathEl::LineTo(a) => out.line_to(p(a).0, p(a).1),
            PathEl::QuadTo(a, b) => out.quad_to(p(a).0, p(a).1, p(b).0, p(b).1),
            PathEl::CurveTo(a, b, c) => out.cubic_to(p(a).0, p(a).1, p(b).0, p(b).1, p(c).0, p(c).1),
            PathEl::ClosePath => out.close(),
        }
    }
    let Some(path) = out.finish() else { return };
    match line {
        Some(style) => cell.stroke_path(&path, &paint, &style, at, None),
        None => cell.fill_path(&path, &paint, FillRule::Winding, at, None),
    }
}
