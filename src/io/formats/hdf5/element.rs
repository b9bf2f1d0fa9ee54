//! The bytes of one HDF5 element become a number or a text.

use hdf5_pure::{Datatype, DatatypeByteOrder, FloatingPointLayout, StringPadding};
use num_complex::Complex64;

use crate::io::formats::arrays::store::Elements;

/// The content of the elements of a dataset.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Content {
    /// Real numbers of 32 bits.
    Single(Scalar),
    /// Other real numbers, integers and logical values.
    Real(Scalar),
    /// Real and imaginary part.
    Complex(Scalar, Scalar),
    /// Texts of this many bytes.
    FixedText(StringPadding),
    /// Texts that lie elsewhere in the file.
    VariableText,
    /// References to other objects, as the cells of MATLAB.
    References,
    /// Complex numbers of the HDF5 complex type (datatype class 11).
    NativeComplex,
    /// Nothing that is a number or a text.
    Other,
}

/// Where a number lies in an element, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scalar {
    offset: usize,
    size: usize,
    big_endian: bool,
    form: Form,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// `bits` bits above the lowest `shift`.
    Integer { signed: bool, shift: u32, bits: u32 },
    /// Sign, exponent and mantissa, the sign above the exponent.
    Float(FloatingPointLayout),
}

/// Content, kind for people and length in bytes of one number or text, and the lengths that an
/// array datatype adds.
pub(super) fn describe(datatype: &Datatype) -> (Content, String, usize, Vec<usize>) {
    let mut lengths = Vec::new();
    let mut element = datatype;
    while let Datatype::Array {
        base_type,
        dimensions,
    } = element
    {
        lengths.extend(dimensions.iter().map(|&length| length as usize));
        element = base_type;
    }
    let (content, kind) = content(element);
    (content, kind, element.type_size() as usize, lengths)
}

fn content(datatype: &Datatype) -> (Content, String) {
    if let Some(scalar) = Scalar::of(datatype, 0) {
        let content = if scalar.is_single() {
            Content::Single(scalar)
        } else {
            Content::Real(scalar)
        };
        return (content, scalar_kind(datatype));
    }
    match datatype {
        Datatype::String { padding, .. } => (Content::FixedText(padding.clone()), "text".into()),
        Datatype::VariableLength {
            is_string: true, ..
        } => (Content::VariableText, "text".into()),
        Datatype::Reference { size: 8, .. } => (Content::References, "reference".into()),
        Datatype::Compound { .. } if is_native_complex(datatype) => {
            (Content::NativeComplex, "complex".into())
        }
        Datatype::Compound { .. } => {
            complex_pair(datatype).unwrap_or_else(|| (Content::Other, "struct".into()))
        }
        Datatype::VariableLength { .. } => (Content::Other, "variable-length".into()),
        Datatype::Opaque { .. } => (Content::Other, "opaque".into()),
        Datatype::BitField { .. } => (Content::Other, "bits".into()),
        Datatype::Time { .. } => (Content::Other, "time".into()),
        _ => (Content::Other, "unknown".into()),
    }
}

/// Names of the members of a complex number: h5py's and MATLAB's.
const COMPLEX_MEMBERS: [[&str; 2]; 3] = [["r", "i"], ["real", "imag"], ["re", "im"]];

fn complex_pair(datatype: &Datatype) -> Option<(Content, String)> {
    let Datatype::Compound { size, members } = datatype else {
        return None;
    };
    let [re, im] = members.as_slice() else {
        return None;
    };
    if !COMPLEX_MEMBERS.contains(&[re.name.as_str(), im.name.as_str()]) {
        return None;
    }
    let scalar = |member: &hdf5_pure::CompoundMember| {
        let offset = usize::try_from(member.byte_offset).ok()?;
        let scalar = Scalar::of(&member.datatype, offset)?;
        (offset.checked_add(scalar.size)? <= *size as usize).then_some(scalar)
    };
    let kind = format!("complex {}", scalar_kind(&re.datatype));
    Some((Content::Complex(scalar(re)?, scalar(im)?), kind))
}

/// Whether a datatype is the complex type of HDF5 2.0 (class 11). The reader takes its message for
/// a compound of one member, so that the bytes of the base type's message (class 1 and version,
/// byte order, sign bit) come out as the member's name.
fn is_native_complex(datatype: &Datatype) -> bool {
    let Datatype::Compound { members, .. } = datatype else {
        return false;
    };
    let [member] = members.as_slice() else {
        return false;
    };
    let mut bytes = member.name.bytes();
    let class_and_version = bytes.next().unwrap_or(0);
    class_and_version & 0x0f == 1
        && (1..=5).contains(&(class_and_version >> 4))
        && matches!(bytes.next(), Some(0x20 | 0x21))
}

fn scalar_kind(datatype: &Datatype) -> String {
    match datatype {
        Datatype::FixedPoint { size, layout, .. } => {
            let sign = if layout.signed { 'i' } else { 'u' };
            format!("{sign}{}", u64::from(*size) * 8)
        }
        Datatype::FloatingPoint { size, .. } => format!("f{}", u64::from(*size) * 8),
        Datatype::Enumeration {
            base_type, members, ..
        } => {
            let names: Vec<&str> = members.iter().map(|member| member.name.as_str()).collect();
            if names == ["FALSE", "TRUE"] {
                "bool".into()
            } else {
                scalar_kind(base_type)
            }
        }
        _ => "unknown".into(),
    }
}

impl Scalar {
    /// The number of this type at `offset` of an element; `None` for a type that is no number.
    fn of(datatype: &Datatype, offset: usize) -> Option<Self> {
        let (size, order, form) = match datatype {
            Datatype::FixedPoint {
                size,
                byte_order,
                layout,
            } => {
                let (shift, bits) = (layout.bit_offset.into(), layout.bit_precision.into());
                let form = Form::Integer {
                    signed: layout.signed,
                    shift,
                    bits,
                };
                let fits = *size <= 8 && bits > 0 && shift + bits <= size * 8;
                (*size, byte_order, fits.then_some(form)?)
            }
            Datatype::FloatingPoint {
                size,
                byte_order,
                layout,
            } => {
                let exponent =
                    u32::from(layout.exponent_location) + u32::from(layout.exponent_size);
                let mantissa =
                    u32::from(layout.mantissa_location) + u32::from(layout.mantissa_size);
                let fits = *size <= 16
                    && (1..=15).contains(&layout.exponent_size)
                    && layout.mantissa_size > 0
                    && exponent < size * 8
                    && mantissa <= size * 8
                    && layout.exponent_bias < 1 << 15;
                (*size, byte_order, fits.then_some(Form::Float(*layout))?)
            }
            Datatype::Enumeration {
                size, base_type, ..
            } => {
                let base = Self::of(base_type, offset)?;
                return (base.size == *size as usize && !base.is_float()).then_some(base);
            }
            _ => return None,
        };
        let big_endian = match order {
            DatatypeByteOrder::LittleEndian => false,
            DatatypeByteOrder::BigEndian => true,
            _ => return None,
        };
        Some(Self {
            offset,
            size: size as usize,
            big_endian,
            form,
        })
    }

    fn is_float(&self) -> bool {
        matches!(self.form, Form::Float(_))
    }

    fn is_single(&self) -> bool {
        self.form == Form::Float(FloatingPointLayout::IEEE754_BINARY32) && self.size == 4
    }

    fn is_double(&self) -> bool {
        self.form == Form::Float(FloatingPointLayout::IEEE754_BINARY64) && self.size == 8
    }

    /// The bits of the number, least significant first.
    fn bits(&self, element: &[u8]) -> u128 {
        let bytes = &element[self.offset..self.offset + self.size];
        let join = |bits: u128, byte: &u8| bits << 8 | u128::from(*byte);
        if self.big_endian {
            bytes.iter().fold(0, join)
        } else {
            bytes.iter().rev().fold(0, join)
        }
    }

    #[expect(clippy::cast_possible_truncation, reason = "a number of 32 bits")]
    fn single(&self, element: &[u8]) -> f32 {
        f32::from_bits(self.bits(element) as u32)
    }

    #[expect(clippy::cast_possible_truncation, reason = "a number of 64 bits")]
    fn double(&self, element: &[u8]) -> f64 {
        let bits = self.bits(element);
        match self.form {
            _ if self.is_double() => f64::from_bits(bits as u64),
            _ if self.is_single() => f64::from(f32::from_bits(bits as u32)),
            Form::Float(layout) => float(bits, layout),
            Form::Integer {
                signed,
                shift,
                bits: width,
            } => {
                let unsigned = (bits as u64 >> shift) << (64 - width);
                if signed {
                    (unsigned as i64 >> (64 - width)) as f64
                } else {
                    (unsigned >> (64 - width)) as f64
                }
            }
        }
    }
}

/// (−1)^s · mantissa · 2^(exponent − bias), with a leading 1 that is not stored unless the mantissa
/// has 64 bits (the 80-bit numbers of x86 store it).
fn float(bits: u128, layout: FloatingPointLayout) -> f64 {
    let field = |location: u8, size: u8| (bits >> location) & ((1_u128 << size) - 1);
    let exponent = field(layout.exponent_location, layout.exponent_size);
    let mantissa = field(layout.mantissa_location, layout.mantissa_size);
    let sign_at = layout.exponent_location + layout.exponent_size;
    let sign = if bits >> sign_at & 1 == 1 { -1.0 } else { 1.0 };
    let width = i32::from(layout.mantissa_size);
    let (leading, fraction) = if width == 64 {
        (mantissa >> 63 << 63, mantissa << 65 >> 65)
    } else {
        (u128::from(exponent > 0) << width, mantissa)
    };
    if exponent == (1 << layout.exponent_size) - 1 {
        return if fraction == 0 {
            sign * f64::INFINITY
        } else {
            f64::NAN
        };
    }
    let fraction_bits = if width == 64 { 63 } else { width };
    let bias = i32::try_from(layout.exponent_bias).unwrap_or(i32::MAX);
    let power = i32::try_from(exponent.max(1)).unwrap_or(i32::MAX) - bias - fraction_bits;
    // In two steps, because 2^power alone can be out of range where the product is not.
    let half = power / 2;
    sign * (leading | fraction) as f64 * 2_f64.powi(half) * 2_f64.powi(power - half)
}

impl Content {
    /// Whether elements of `stride` bytes are numbers of single precision as this machine has them.
    pub fn is_native_single(&self, stride: usize) -> bool {
        let big_endian = cfg!(target_endian = "big");
        matches!(self, Content::Single(scalar) if stride == 4 && scalar.big_endian == big_endian)
    }

    /// No elements yet, of the right kind; `None` for what is no number and no text.
    pub fn empty(&self, count: usize) -> Option<Elements> {
        Some(match self {
            Content::Single(_) => Elements::F32(Vec::with_capacity(count)),
            Content::Real(_) => Elements::F64(Vec::with_capacity(count)),
            Content::Complex(..) => Elements::Complex(Vec::with_capacity(count)),
            Content::FixedText(_) | Content::VariableText => {
                Elements::Text(Vec::with_capacity(count))
            }
            Content::References | Content::NativeComplex | Content::Other => return None,
        })
    }

    /// Appends elements of `stride` bytes each.
    pub fn append(&self, bytes: &[u8], stride: usize, out: &mut Elements) {
        let elements = bytes.chunks_exact(stride);
        match (self, out) {
            (Content::Single(scalar), Elements::F32(out)) if stride == 4 => {
                let big_endian = scalar.big_endian;
                out.extend(elements.map(|element| four_bytes(element, big_endian)));
            }
            (Content::Single(scalar), Elements::F32(out)) => {
                out.extend(elements.map(|element| scalar.single(element)));
            }
            (Content::Real(scalar), Elements::F64(out)) if scalar.is_double() => {
                let scalar = *scalar;
                out.extend(elements.map(|element| eight_bytes(element, scalar.big_endian)));
            }
            (Content::Real(scalar), Elements::F64(out)) => {
                out.extend(elements.map(|element| scalar.double(element)));
            }
            (Content::Complex(re, im), Elements::Complex(out)) => {
                let value = |element| Complex64::new(re.double(element), im.double(element));
                out.extend(elements.map(value));
            }
            (Content::FixedText(padding), Elements::Text(out)) => {
                out.extend(elements.map(|element| text(element, padding)));
            }
            _ => {}
        }
    }
}

fn four_bytes(element: &[u8], big_endian: bool) -> f32 {
    let bytes: [u8; 4] = element.try_into().unwrap_or_default();
    if big_endian {
        f32::from_be_bytes(bytes)
    } else {
        f32::from_le_bytes(bytes)
    }
}

fn eight_bytes(element: &[u8], big_endian: bool) -> f64 {
    let bytes: [u8; 8] = element.try_into().unwrap_or_default();
    if big_endian {
        f64::from_be_bytes(bytes)
    } else {
        f64::from_le_bytes(bytes)
    }
}

/// A text without its padding; bytes that are not UTF-8 are taken for Latin-1.
fn text(bytes: &[u8], padding: &StringPadding) -> String {
    let end = match padding {
        StringPadding::NullTerminate => bytes.iter().position(|&byte| byte == 0),
        StringPadding::NullPad => bytes.iter().rposition(|&byte| byte != 0).map(|at| at + 1),
        StringPadding::SpacePad => bytes
            .iter()
            .rposition(|&byte| byte != b' ')
            .map(|at| at + 1),
    };
    let end = match padding {
        StringPadding::NullTerminate => end.unwrap_or(bytes.len()),
        _ => end.unwrap_or(0),
    };
    match std::str::from_utf8(&bytes[..end]) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes[..end].iter().copied().map(char::from).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(bits: [u8; 4], bias: u32) -> FloatingPointLayout {
        FloatingPointLayout {
            bit_offset: 0,
            bit_precision: 0,
            exponent_location: bits[0],
            exponent_size: bits[1],
            mantissa_location: bits[2],
            mantissa_size: bits[3],
            exponent_bias: bias,
        }
    }

    #[test]
    fn half_precision_and_the_80_bits_of_x86_are_read() {
        let half = |bits| float(bits, layout([10, 5, 0, 10], 15));
        // 1, -2, the largest (65504), the smallest normal (2^-14) and subnormal (2^-24) number of
        // IEEE 754 binary16.
        let values = [0x3c00, 0xc000, 0x7bff, 0x0400, 0x0001, 0x0000].map(half);
        let expected = [1.0, -2.0, 65504.0, 2_f64.powi(-14), 2_f64.powi(-24), 0.0];
        assert_eq!(values.map(f64::to_bits), expected.map(f64::to_bits));
        assert_eq!(half(0x7c00).to_bits(), f64::INFINITY.to_bits());
        assert!(half(0x7e00).is_nan());
        let extended = |bits| float(bits, layout([64, 15, 0, 64], 16383));
        let (one, minus_three) = (0x3fff_8000_0000_0000_0000, 0xc000_c000_0000_0000_0000);
        assert_eq!(extended(one).to_bits(), 1_f64.to_bits());
        assert_eq!(extended(minus_three).to_bits(), (-3_f64).to_bits());
        assert_eq!(
            extended(0x7fff_8000_0000_0000_0000).to_bits(),
            f64::INFINITY.to_bits()
        );
    }

    #[test]
    fn padding_is_taken_off_and_other_bytes_are_latin_1() {
        assert_eq!(text(b"ab\0cd", &StringPadding::NullTerminate), "ab");
        assert_eq!(text(b"ab\0d\0\0", &StringPadding::NullPad), "ab\0d");
        assert_eq!(text(b"ab  ", &StringPadding::SpacePad), "ab");
        assert_eq!(text(b"    ", &StringPadding::SpacePad), "");
        assert_eq!(text(b"m/s\xb2\0", &StringPadding::NullTerminate), "m/s²");
    }
}
