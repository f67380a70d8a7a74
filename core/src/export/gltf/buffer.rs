//! The binary buffer of a glTF file: views, each on a four-byte boundary, and the accessors over them.

use gltf_json::accessor::sparse::{Indices, Sparse, Values};
use gltf_json::accessor::{Accessor, ComponentType, GenericComponentType, IndexComponentType, Type};
use gltf_json::buffer::{Target, View};
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Index, Root};

/// Bytes that grow, with what the file says about them.
#[derive(Debug, Default)]
pub(in crate::export) struct Buffer {
    bytes: Vec<u8>,
}

impl Buffer {
    /// All bytes, padded to whole words.
    pub(in crate::export) fn into_bytes(mut self) -> Vec<u8> {
        self.align();
        self.bytes
    }

    fn align(&mut self) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    /// A view of its own for `bytes`.
    pub(in crate::export) fn view(&mut self, root: &mut Root, bytes: &[u8], target: Option<Target>) -> Index<View> {
        self.align();
        let view = View {
            buffer: Index::new(0),
            byte_length: USize64::from(bytes.len()),
            byte_offset: (!self.bytes.is_empty()).then(|| USize64::from(self.bytes.len())),
            byte_stride: None,
            extensions: None,
            extras: None,
            name: None,
            target: target.map(Checked::Valid),
        };
        self.bytes.extend_from_slice(bytes);
        root.push(view)
    }

    /// An accessor over `N` floats an element; `bounds` writes the smallest and largest value of each component.
    pub(in crate::export) fn floats<const N: usize>(
        &mut self,
        root: &mut Root,
        values: &[[f32; N]],
        type_: Type,
        target: Option<Target>,
        bounds: bool,
    ) -> Index<Accessor> {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(root, &bytes, target);
        let extreme = |pick: fn(f32, f32) -> f32| {
            let first = values.first().copied().unwrap_or([0.0; N]);
            let all = values.iter().fold(first, |a, b| std::array::from_fn(|i| pick(a[i], b[i])));
            Some(serde_json::Value::from(all.to_vec()))
        };
        let mut accessor = plain(view, values.len(), ComponentType::F32, type_);
        if bounds {
            accessor.min = extreme(f32::min);
            accessor.max = extreme(f32::max);
        }
        root.push(accessor)
    }

    /// An accessor over triples of floats of which only those that are not zero are kept, where that is shorter. It has
    /// bounds.
    pub(in crate::export) fn displacements(&mut self, root: &mut Root, values: &[[f32; 3]]) -> Index<Accessor> {
        let moved: Vec<usize> = (0..values.len()).filter(|v| values[*v] != [0.0; 3]).collect();
        // An index of four bytes beside twelve of a value.
        if moved.is_empty() || 4 * moved.len() >= 3 * values.len() {
            return self.floats(root, values, Type::Vec3, Some(Target::ArrayBuffer), true);
        }
        let (bytes, component): (Vec<u8>, _) = if values.len() <= usize::from(u16::MAX) {
            (moved.iter().flat_map(|v| (*v as u16).to_le_bytes()).collect(), ComponentType::U16)
        } else {
            (moved.iter().flat_map(|v| (*v as u32).to_le_bytes()).collect(), ComponentType::U32)
        };
        let indices = self.view(root, &bytes, None);
        let bytes: Vec<u8> = moved.iter().flat_map(|v| values[*v]).flat_map(f32::to_le_bytes).collect();
        let told = self.view(root, &bytes, None);
        let extreme = |pick: fn(f32, f32) -> f32| {
            let all = moved.iter().fold([0f32; 3], |a, v| std::array::from_fn(|i| pick(a[i], values[*v][i])));
            Some(serde_json::Value::from(all.to_vec()))
        };
        root.push(Accessor {
            buffer_view: None,
            count: USize64::from(values.len()),
            component_type: Checked::Valid(GenericComponentType(ComponentType::F32)),
            type_: Checked::Valid(Type::Vec3),
            min: extreme(f32::min),
            max: extreme(f32::max),
            sparse: Some(Sparse {
                count: USize64::from(moved.len()),
                indices: Indices {
                    buffer_view: indices,
                    byte_offset: USize64(0),
                    component_type: Checked::Valid(IndexComponentType(component)),
                    extensions: None,
                    extras: None,
                },
                values: Values { buffer_view: told, byte_offset: USize64(0), extensions: None, extras: None },
                extensions: None,
                extras: None,
            }),
            byte_offset: None,
            extensions: None,
            extras: None,
            name: None,
            normalized: false,
        })
    }

    /// Vertex indices, as short as they can be.
    pub(in crate::export) fn indices(
        &mut self,
        root: &mut Root,
        triangles: &[[u32; 3]],
        vertices: usize,
    ) -> Index<Accessor> {
        // The largest value of each width is reserved for restarting strips.
        let all = triangles.iter().flatten();
        let (bytes, component): (Vec<u8>, _) = if vertices <= usize::from(u16::MAX) {
            (all.flat_map(|i| (*i as u16).to_le_bytes()).collect(), ComponentType::U16)
        } else {
            (all.flat_map(|i| i.to_le_bytes()).collect(), ComponentType::U32)
        };
        let view = self.view(root, &bytes, Some(Target::ElementArrayBuffer));
        root.push(plain(view, 3 * triangles.len(), component, Type::Scalar))
    }

    /// Four joints a vertex, in bytes where all `joints` fit.
    pub(in crate::export) fn joints(&mut self, root: &mut Root, values: &[[u16; 4]], joints: usize) -> Index<Accessor> {
        let all = values.iter().flatten();
        let (bytes, component): (Vec<u8>, _) = if joints <= 256 {
            (all.map(|j| *j as u8).collect(), ComponentType::U8)
        } else {
            (all.flat_map(|j| j.to_le_bytes()).collect(), ComponentType::U16)
        };
        let view = self.view(root, &bytes, Some(Target::ArrayBuffer));
        root.push(plain(view, values.len(), component, Type::Vec4))
    }
}

fn plain(view: Index<View>, count: usize, component: ComponentType, type_: Type) -> Accessor {
    Accessor {
        buffer_view: Some(view),
        byte_offset: None,
        count: USize64::from(count),
        component_type: Checked::Valid(GenericComponentType(component)),
        extensions: None,
        extras: None,
        type_: Checked::Valid(type_),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    }
}
