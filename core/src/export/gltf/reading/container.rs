//! The container of a binary glTF file (glTF 2.0 section 4.4) and the numbers in its buffer, read without trust: every
//! offset and count is checked against the bytes that are there.

use gltf_json::accessor::{Accessor, ComponentType, Type};
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Index, Root};

/// What is wrong with a file, in the words of its user.
pub(super) type Found<T> = Result<T, String>;

/// Elements that an accessor may have, so that a few bytes cannot ask for all memory.
const MAX_ELEMENTS: usize = 1 << 26;

/// A file taken apart.
pub(super) struct Container<'a> {
    pub(super) root: Root,
    binary: &'a [u8],
}

impl<'a> Container<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Found<Self> {
        let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        if bytes.get(..4) != Some(b"glTF") {
            return Err("is no binary glTF file".into());
        }
        if word(4) != Some(2) {
            return Err("is not of glTF 2".into());
        }
        let (mut json, mut binary, mut at) = (None, None, 12);
        while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
            let end = (at + 8).checked_add(length as usize).filter(|end| *end <= bytes.len());
            let chunk = &bytes[at + 8..end.ok_or("is cut off")?];
            match &kind.to_le_bytes() {
                b"JSON" => json = json.or(Some(chunk)),
                b"BIN\0" => binary = binary.or(Some(chunk)),
                _ => {}
            }
            at += 8 + chunk.len().next_multiple_of(4);
        }
        let root = Root::from_slice(json.ok_or("is cut off")?).map_err(|e| format!("is damaged: {e}"))?;
        Ok(Self { root, binary: binary.unwrap_or_default() })
    }

    /// The bytes of a view.
    pub(super) fn view(&self, view: Index<gltf_json::buffer::View>) -> Found<&'a [u8]> {
        let view = self.root.buffer_views.get(view.value()).ok_or("is damaged: a buffer view is not there")?;
        let buffer = self.root.buffers.get(view.buffer.value());
        if view.buffer.value() != 0 || buffer.is_none_or(|b| b.uri.is_some()) {
            return Err("keeps its data in other files".into());
        }
        slice(self.binary, whole(view.byte_offset), view.byte_length.0 as usize)
    }

    /// The elements of an accessor, `N` numbers each. Integers that stand for shares of one come as such.
    pub(super) fn numbers<const N: usize>(&self, index: Index<Accessor>) -> Found<Vec<[f64; N]>> {
        let accessor = self.root.accessors.get(index.value()).ok_or("is damaged: an accessor is not there")?;
        let (Checked::Valid(component), Checked::Valid(kind)) = (&accessor.component_type, &accessor.type_) else {
            return Err("is damaged: an accessor is of no known type".into());
        };
        // Integer matrices pad their columns; nothing that is read here has them.
        let integer_matrix = matches!(kind, Type::Mat2 | Type::Mat3) && component.0.size() < 4;
        if kind.multiplicity() != N || integer_matrix {
            return Err(format!("is damaged: an accessor holds {} numbers an element, not {N}", kind.multiplicity()));
        }
        let count = accessor.count.0 as usize;
        if count > MAX_ELEMENTS {
            return Err(format!("has an accessor of {count} elements, and {MAX_ELEMENTS} are the most"));
        }
        let mut out = match accessor.buffer_view {
            None => vec![[0.0; N]; count],
            Some(view) => {
                let stride = self.root.buffer_views.get(view.value()).and_then(|v| v.byte_stride).map(|s| s.0);
                let bytes = self.view(view)?;
                let from = whole(accessor.byte_offset);
                elements(slice(bytes, from, bytes.len().saturating_sub(from))?, count, stride, component.0)?
            }
        };
        if let Some(sparse) = &accessor.sparse {
            self.replace(&mut out, sparse, component.0)?;
        }
        if accessor.normalized {
            let unit = |v: f64| match component.0 {
                ComponentType::U8 => v / 255.0,
                ComponentType::U16 => v / 65535.0,
                ComponentType::I8 => (v / 127.0).max(-1.0),
                ComponentType::I16 => (v / 32767.0).max(-1.0),
                ComponentType::U32 | ComponentType::F32 => v,
            };
            out.iter_mut().flatten().for_each(|v| *v = unit(*v));
        }
        Ok(out)
    }

    /// Puts the values of a sparse accessor in.
    fn replace<const N: usize>(
        &self,
        out: &mut [[f64; N]],
        sparse: &gltf_json::accessor::sparse::Sparse,
        component: ComponentType,
    ) -> Found<()> {
        let count = sparse.count.0 as usize;
        let Checked::Valid(index_type) = &sparse.indices.component_type else {
            return Err("is damaged: a sparse accessor's indices are of no known type".into());
        };
        let tail = |view, offset: USize64| {
            let bytes = self.view(view)?;
            slice(bytes, offset.0 as usize, bytes.len().saturating_sub(offset.0 as usize))
        };
        let indices: Vec<[f64; 1]> =
            elements(tail(sparse.indices.buffer_view, sparse.indices.byte_offset)?, count, None, index_type.0)?;
        let values = elements(tail(sparse.values.buffer_view, sparse.values.byte_offset)?, count, None, component)?;
        for ([index], value) in indices.into_iter().zip(values) {
            *out.get_mut(index as usize).ok_or("is damaged: a sparse accessor replaces what is not there")? = value;
        }
        Ok(())
    }
}

fn whole(offset: Option<USize64>) -> usize {
    offset.unwrap_or_default().0 as usize
}

fn slice(bytes: &[u8], from: usize, length: usize) -> Found<&[u8]> {
    let part = from.checked_add(length).and_then(|to| bytes.get(from..to));
    part.ok_or_else(|| "is damaged: it ends before its data does".into())
}

fn elements<const N: usize>(
    bytes: &[u8],
    count: usize,
    stride: Option<usize>,
    component: ComponentType,
) -> Found<Vec<[f64; N]>> {
    let size = component.size();
    let stride = stride.unwrap_or(size * N);
    let needed = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size * N));
    if needed.is_none_or(|n| n > bytes.len()) {
        return Err("is damaged: it ends before its data does".into());
    }
    let number = |b: &[u8]| match component {
        ComponentType::I8 => f64::from(b[0] as i8),
        ComponentType::U8 => f64::from(b[0]),
        ComponentType::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
        ComponentType::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
        ComponentType::U32 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        ComponentType::F32 => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
    };
    Ok((0..count).map(|i| std::array::from_fn(|k| number(&bytes[i * stride + k * size..]))).collect())
}
