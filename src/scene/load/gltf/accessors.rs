//! Vectors and indices out of buffers. The crate's own iterators would panic where a file promises more than it has.

use gltf::Accessor;
use gltf::accessor::{DataType, Dimensions};

use super::buffers::Buffers;
use crate::math::{Vec2, Vec3};

/// The three floats of each element.
pub(super) fn vectors(accessor: &Accessor, buffers: &Buffers) -> Result<Vec<Vec3>, String> {
    if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
        return Err(told(accessor, "holds no vectors of three floats, which are expected"));
    }
    let float = |bytes: &[u8], k: usize| {
        bytes[4 * k..].first_chunk().map_or(f32::NAN, |four| f32::from_le_bytes(*four))
    };
    let vector = |bytes: &[u8]| Vec3::new(float(bytes, 0), float(bytes, 1), float(bytes, 2));
    Ok(elements(accessor, buffers)?.map(vector).collect())
}

/// The two numbers of each element: floats, or shares of the largest whole number.
pub(super) fn pairs(accessor: &Accessor, buffers: &Buffers) -> Result<Vec<Vec2>, String> {
    let number: fn(&[u8]) -> f32 = match (accessor.data_type(), accessor.dimensions()) {
        (DataType::F32, Dimensions::Vec2) => {
            |bytes| bytes.first_chunk().map_or(f32::NAN, |four| f32::from_le_bytes(*four))
        }
        (DataType::U8, Dimensions::Vec2) => |bytes| f32::from(bytes[0]) / 255.0,
        (DataType::U16, Dimensions::Vec2) => {
            |bytes| f32::from(u16::from_le_bytes([bytes[0], bytes[1]])) / 65535.0
        }
        _ => return Err(told(accessor, "holds no pairs of floats or shares, which are expected")),
    };
    let size = accessor.size() / 2;
    let pair = |bytes: &[u8]| Vec2::new(number(&bytes[..size]), number(&bytes[size..]));
    Ok(elements(accessor, buffers)?.map(pair).collect())
}

/// Indices of one, two or four bytes.
pub(super) fn indices(accessor: &Accessor, buffers: &Buffers) -> Result<Vec<u32>, String> {
    let whole = |bytes: &[u8]| bytes.iter().rev().fold(0, |number, &byte| number << 8 | u32::from(byte));
    match (accessor.data_type(), accessor.dimensions()) {
        (DataType::U8 | DataType::U16 | DataType::U32, Dimensions::Scalar) => {
            Ok(elements(accessor, buffers)?.map(whole).collect())
        }
        _ => Err(told(accessor, "holds no indices, which are expected")),
    }
}

/// The bytes of each element.
fn elements<'b>(accessor: &Accessor, buffers: &'b Buffers) -> Result<impl Iterator<Item = &'b [u8]>, String> {
    if accessor.sparse().is_some() {
        return Err(told(accessor, "is sparse, which is not supported"));
    }
    let view = accessor.view().ok_or_else(|| told(accessor, "has no data"))?;
    let (size, stride) = (accessor.size(), view.stride().unwrap_or(accessor.size()).max(1));
    let whole = buffers.part(view.buffer().index(), view.offset(), view.length());
    let bytes = whole.and_then(|bytes| bytes.get(accessor.offset()..)).unwrap_or_default();
    let needed = accessor
        .count()
        .checked_sub(1)
        .and_then(|n| n.checked_mul(stride))
        .and_then(|end| end.checked_add(size));
    if accessor.count() > 0 && needed.is_none_or(|needed| needed > bytes.len()) {
        return Err(told(accessor, "reaches beyond its buffer"));
    }
    Ok((0..accessor.count()).map(move |k| &bytes[k * stride..][..size]))
}

fn told(accessor: &Accessor, what: &str) -> String {
    format!("accessor {} {what}", accessor.index())
}
