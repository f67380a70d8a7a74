//! 3MF (3MF Core Specification 1.3): a zip with one XML model, in millimetres, and a colour for each vertex by a colour
//! group (3MF Materials and Properties Extension 1.2). Programs that do not know colours show the form.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::error::{Error, Result};
use crate::job::Stage;
use crate::shape::solid::Solid;

const CONTENT_TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>
"#;
const RELATIONSHIPS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
"#;
const HEAD: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xml:lang="en-US" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02">
<metadata name="Application">Marey</metadata>
<resources>
<m:colorgroup id="1">
"#;
/// Text that is packed at once.
const CHUNK: usize = 1 << 18;

/// A solid as a 3MF file.
///
/// # Errors
/// A cancel.
pub fn three_mf(solid: &Solid, stage: Stage<'_>) -> Result<Vec<u8>> {
    let mut out = Packed { zip: ZipWriter::new(Cursor::new(Vec::new())), text: String::new() };
    out.file("[Content_Types].xml")?;
    out.text.push_str(CONTENT_TYPES);
    out.file("_rels/.rels")?;
    out.text.push_str(RELATIONSHIPS);
    out.file("3D/3dmodel.model")?;

    let (mut colours, mut number) = (Vec::new(), HashMap::new());
    let of_vertex: Vec<usize> = solid
        .colours
        .iter()
        .map(|colour| {
            *number.entry(*colour).or_insert_with(|| {
                colours.push(*colour);
                colours.len() - 1
            })
        })
        .collect();
    out.text.push_str(HEAD);
    for [r, g, b] in &colours {
        out.line(format_args!("<m:color color=\"#{r:02X}{g:02X}{b:02X}FF\"/>"))?;
    }
    out.line(format_args!(
        "</m:colorgroup>\n<object id=\"2\" type=\"model\" name=\"creature\" pid=\"1\" pindex=\"0\"><mesh><vertices>"
    ))?;
    for (i, p) in solid.positions.iter().enumerate() {
        if i % 4096 == 0 {
            stage.at(0.3 * i as f64 / solid.positions.len() as f64)?;
        }
        out.line(format_args!("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", p.x, p.y, p.z))?;
    }
    out.line(format_args!("</vertices><triangles>"))?;
    for (i, &[a, b, c]) in solid.triangles.iter().enumerate() {
        if i % 4096 == 0 {
            stage.at(0.3 + 0.7 * i as f64 / solid.triangles.len() as f64)?;
        }
        let [p, q, r] = [a, b, c].map(|v| of_vertex[v as usize]);
        out.line(format_args!(
            "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\" pid=\"1\" p1=\"{p}\" p2=\"{q}\" p3=\"{r}\"/>"
        ))?;
    }
    // A build lies where all coordinates are positive.
    let [x, y, _] = solid.report.size_mm.map(|s| 0.5 * s);
    out.line(format_args!(
        "</triangles></mesh></object>\n</resources>\n<build><item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 {x} {y} 0\"/></build>\n</model>"
    ))?;
    out.flush()?;
    Ok(out.zip.finish().map_err(packing)?.into_inner())
}

fn packing(error: impl std::fmt::Display) -> Error {
    Error::invalid("the 3MF file", format!("cannot be packed: {error}"), "write STL, or fewer triangles")
}

/// A zip in memory, and text on its way into it.
struct Packed {
    zip: ZipWriter<Cursor<Vec<u8>>>,
    text: String,
}

impl Packed {
    fn file(&mut self, name: &str) -> Result<()> {
        self.flush()?;
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        self.zip.start_file(name, options).map_err(packing)
    }

    fn line(&mut self, line: std::fmt::Arguments<'_>) -> Result<()> {
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "{line}");
        if self.text.len() >= CHUNK { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<()> {
        self.zip.write_all(self.text.as_bytes()).map_err(packing)?;
        self.text.clear();
        Ok(())
    }
}
