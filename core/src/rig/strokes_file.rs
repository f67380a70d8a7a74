//! strokes.json: the rig as a file.
//!
//! Unknown keys are ignored, an unknown version is an error. Beyond `limb`, `points` and `facing` a stroke may carry
//! `"depth": px` and `"bend": px` ([`LimbDepth`]); with either it may do without points, and then it draws nothing.
//! Beyond strokes a key frame may carry
//! `"paint": [{"kind": "foreground" | "background", "radius": px, "points": [[x, y], ...]}]` and
//! `"mask": "file.png"`, relative to the strokes file.

use std::path::Path;

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::{Facing, KeyFrame, Limb, LimbDepth, Paint, Rig, Side, Stroke};
use crate::error::{Error, Result};

const FORMAT: &str = "marey-strokes";
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
struct StrokesFile {
    format: String,
    version: u32,
    size: (u32, u32),
    limbs: Vec<LimbEntry>,
    keyframes: Vec<KeyEntry>,
}

#[derive(Serialize, Deserialize)]
struct LimbEntry {
    label: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    side: Option<Side>,
}

#[derive(Serialize, Deserialize)]
struct KeyEntry {
    frame: usize,
    #[serde(default)]
    strokes: Vec<StrokeEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    paint: Vec<PaintEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    mask: Option<std::path::PathBuf>,
}

#[derive(Serialize, Deserialize)]
struct StrokeEntry {
    limb: String,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    points: Vec<Vec2>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    facing: Option<Facing>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    depth: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    bend: Option<f32>,
}

#[derive(Serialize, Deserialize)]
struct PaintEntry {
    kind: PaintKind,
    radius: f32,
    points: Vec<Vec2>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum PaintKind {
    Foreground,
    Background,
}

impl Rig {
    /// Reads strokes.json and validates it. Masks are looked for beside the file.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
        let mut rig = Self::from_json(&text).map_err(|e| e.in_file(path))?;
        let beside = path.parent().unwrap_or(Path::new(""));
        for mask in rig.keyframes.iter_mut().filter_map(|k| k.mask.as_mut()) {
            *mask = beside.join(&mask);
        }
        Ok(rig)
    }

    /// Parses and validates the text of a strokes.json.
    pub fn from_json(text: &str) -> Result<Self> {
        let file: StrokesFile = serde_json::from_str(text)
            .map_err(|e| Error::invalid("strokes", format!("not readable: {e}"), "expected a marey-strokes file"))?;
        if file.format != FORMAT || file.version != VERSION {
            return Err(Error::invalid(
                "strokes",
                format!("the file says {} version {}", file.format, file.version),
                format!("expected {FORMAT} version {VERSION}"),
            ));
        }
        let index = |label: &str, frame: usize| {
            file.limbs.iter().position(|l| l.label == label).ok_or_else(|| {
                Error::invalid(
                    format!("key frame {frame}"),
                    format!("no limb is called `{label}`"),
                    "add it to `limbs`",
                )
            })
        };
        let mut keyframes = Vec::with_capacity(file.keyframes.len());
        for key in &file.keyframes {
            let mut strokes = Vec::with_capacity(key.strokes.len());
            let mut depths = Vec::new();
            for s in &key.strokes {
                let limb = index(&s.limb, key.frame)?;
                let in_depth = s.depth.is_some() || s.bend.is_some();
                if in_depth {
                    depths.push(LimbDepth { limb, depth: s.depth, bend: s.bend });
                }
                if !(in_depth && s.points.is_empty()) {
                    strokes.push(Stroke { limb, points: s.points.clone(), facing: s.facing });
                }
            }
            let paint = key.paint.iter().map(|p| Paint {
                foreground: matches!(p.kind, PaintKind::Foreground),
                radius: p.radius,
                points: p.points.clone(),
            });
            let (frame, paint, mask) = (key.frame, paint.collect(), key.mask.clone());
            keyframes.push(KeyFrame { frame, strokes, depths, paint, mask });
        }
        keyframes.sort_by_key(|k| k.frame);
        let limbs = file.limbs.into_iter().map(|l| Limb { label: l.label, side: l.side }).collect();
        let rig = Self { size: file.size, limbs, keyframes };
        rig.validate(None)?;
        Ok(rig)
    }

    /// The rig as the text of a strokes.json.
    pub fn to_json(&self) -> String {
        let keyframes = self.keyframes.iter().map(|k| KeyEntry {
            frame: k.frame,
            strokes: self.stroke_entries(k),
            paint: k
                .paint
                .iter()
                .map(|p| PaintEntry {
                    kind: if p.foreground { PaintKind::Foreground } else { PaintKind::Background },
                    radius: p.radius,
                    points: p.points.clone(),
                })
                .collect(),
            mask: k.mask.clone(),
        });
        let file = StrokesFile {
            format: FORMAT.into(),
            version: VERSION,
            size: self.size,
            limbs: self.limbs.iter().map(|l| LimbEntry { label: l.label.clone(), side: l.side }).collect(),
            keyframes: keyframes.collect(),
        };
        serde_json::to_string(&file).unwrap_or_default()
    }

    /// The key frame's strokes with their depths, and then the depths of limbs that are not drawn there.
    fn stroke_entries(&self, key: &KeyFrame) -> Vec<StrokeEntry> {
        let entry = |limb: usize, stroke: Option<&Stroke>| {
            let mark = key.depths.iter().find(|d| d.limb == limb);
            Some(StrokeEntry {
                limb: self.limbs.get(limb)?.label.clone(),
                points: stroke.map_or_else(Vec::new, |s| s.points.clone()),
                facing: stroke.and_then(|s| s.facing),
                depth: mark.and_then(|d| d.depth),
                bend: mark.and_then(|d| d.bend),
            })
        };
        let drawn = |limb: usize| key.strokes.iter().any(|s| s.limb == limb);
        let undrawn = key.depths.iter().filter(|d| !drawn(d.limb)).map(|d| (d.limb, None));
        let strokes = key.strokes.iter().map(|s| (s.limb, Some(s)));
        strokes.chain(undrawn).filter_map(|(limb, stroke)| entry(limb, stroke)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(limbs: &str, keys: &str) -> String {
        format!(
            r#"{{"format":"marey-strokes","version":1,"size":[100,80],"extra":1,"limbs":[{limbs}],"keyframes":[{keys}]}}"#
        )
    }

    #[test]
    fn round_trip_keeps_everything() {
        let text = file(
            r#"{"label":"body"},{"label":"leg","side":"near"}"#,
            r#"{"frame":3,"strokes":[{"limb":"leg","points":[[1,2],[3.5,40]],"facing":"toward","depth":-4,"bend":12.5},
                {"limb":"body","depth":3}],"mask":"m.png"},
               {"frame":0,"strokes":[{"limb":"body","points":[[1,2],[90,2]]}],
                "paint":[{"kind":"background","radius":4,"points":[[5,5]]}]}"#,
        );
        let rig = Rig::from_json(&text).expect("valid");
        assert_eq!(rig.keyframes[0].frame, 0);
        let marks = &rig.keyframes[1].depths;
        assert_eq!(marks[0], LimbDepth { limb: 1, depth: Some(-4.0), bend: Some(12.5) });
        assert_eq!(marks[1], LimbDepth { limb: 0, depth: Some(3.0), bend: None });
        assert!(rig.stroke(0, 3).is_none(), "a depth alone draws nothing");
        assert_eq!(Rig::from_json(&rig.to_json()).expect("valid"), rig);
    }

    #[test]
    fn every_mistake_is_named() {
        let body = r#"{"label":"body"}"#;
        let cases = [
            (file(body, ""), "no stroke"),
            (file("", ""), "no key frame"),
            (file(body, r#"{"frame":0,"strokes":[{"limb":"body","points":[[1,2]]}]}"#), "1 point"),
            (file(body, r#"{"frame":0,"strokes":[{"limb":"body","points":[[1,2],[1e9,3]]}]}"#), "far outside"),
            (file(body, r#"{"frame":0,"strokes":[{"limb":"body","points":[[1,2],[1,2]]}]}"#), "shorter than a pixel"),
            (file(body, r#"{"frame":0,"strokes":[{"limb":"tail","points":[[1,2],[9,2]]}]}"#), "`tail`"),
            (file(r#"{"label":"a"},{"label":"a"}"#, ""), "listed twice"),
            (file(body, r#"{"frame":0,"strokes":[{"limb":"body","points":[[1,2],[NaN,3]]}]}"#), "not readable"),
            (file(body, r#"{"frame":0,"strokes":[{"limb":"body"}]}"#), "0 points"),
            (file(body, r#"{"frame":0,"strokes":[{"limb":"body","depth":1e6}]}"#), "its depth is 1000000"),
            (file(body, r#"{"frame":0,"strokes":[{"limb":"body","bend":-201}]}"#), "its bend is -201"),
            (file(body, r#"{"frame":0,"strokes":[{"limb":"body","depth":1},{"limb":"body","bend":1}]}"#), "two depths"),
            (file(body, "").replace("\"version\":1", "\"version\":2"), "version 2"),
        ];
        for (text, expected) in cases {
            let message = Rig::from_json(&text).expect_err(expected).to_string();
            assert!(message.contains(expected), "{message} should say {expected}");
        }
    }
}
