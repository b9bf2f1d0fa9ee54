//! Changed bytes become a file: compressed, encoded, or with their check sums computed anew.

use std::io::{Cursor, Write};
use std::ops::Range;

/// How the bytes of a seed are made a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// They are the file.
    Plain,
    /// Text, written in UTF-16 with its mark, least significant byte first.
    Utf16LittleEndian,
    /// As above, most significant byte first.
    Utf16BigEndian,
    /// An HDF5 file whose check sums are computed anew.
    Hdf5CheckSums,
    /// Data elements of MATLAB behind a header of the file.
    Matlab5,
    /// Data elements of MATLAB, each deflated with its check sum.
    Matlab5Deflated,
    /// Arrays of NumPy, one after the other: members of an archive, deflated with their check sums.
    Npz,
}

/// What divides the members of [`Packing::Npz`].
pub const MEMBER: &[u8] = b"\x93NUMPY";

impl Packing {
    /// The bytes of a seed that a check sum of 32 bits follows.
    pub fn check_sums(self, seed: &[u8]) -> Vec<Range<usize>> {
        match self {
            Packing::Hdf5CheckSums => hdf5_check_sums(seed),
            _ => Vec::new(),
        }
    }

    /// The file of the changed bytes of a seed.
    pub fn pack(
        self,
        mut bytes: Vec<u8>,
        seed_length: usize,
        check_sums: &[Range<usize>],
    ) -> Vec<u8> {
        let utf_16 = |bytes: &[u8], turn: fn(u16) -> [u8; 2]| {
            let text = String::from_utf8_lossy(bytes);
            let units = std::iter::once(0xfeff).chain(text.encode_utf16());
            units.flat_map(turn).collect()
        };
        match self {
            Packing::Plain => bytes,
            Packing::Utf16LittleEndian => utf_16(&bytes, u16::to_le_bytes),
            Packing::Utf16BigEndian => utf_16(&bytes, u16::to_be_bytes),
            Packing::Hdf5CheckSums => {
                // Where bytes were added or removed the sums have moved.
                if bytes.len() == seed_length {
                    for range in check_sums {
                        let sum = lookup3(&bytes[range.clone()]).to_le_bytes();
                        bytes[range.end..range.end + 4].copy_from_slice(&sum);
                    }
                }
                bytes
            }
            Packing::Matlab5 => [matlab_header(), bytes].concat(),
            Packing::Matlab5Deflated => {
                let elements = elements(&bytes).into_iter().map(|range| &bytes[range]);
                let packed = elements.flat_map(|element| {
                    let packed = deflated(element);
                    let tag = [15, packed.len() as u32].map(u32::to_le_bytes).concat();
                    [tag, packed].concat()
                });
                matlab_header().into_iter().chain(packed).collect()
            }
            Packing::Npz => archive(&bytes),
        }
    }
}

fn matlab_header() -> Vec<u8> {
    let mut file = format!("{:<124}", "MATLAB 5.0 MAT-file").into_bytes();
    file.extend([0x00, 0x01, b'I', b'M']);
    file
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(bytes).unwrap();
    packed.finish().unwrap()
}

/// The data elements as their counts say, the last one to the end of the bytes.
fn elements(bytes: &[u8]) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let count = bytes.get(at + 4..at + 8).map(|count| {
            let count = u32::from_le_bytes(count.try_into().unwrap());
            8 + (count as usize).next_multiple_of(8)
        });
        let end = count.map_or(bytes.len(), |count| bytes.len().min(at + count));
        found.push(at..end);
        at = end;
    }
    found
}

/// An archive with the members `H1_2`, `run` and others.
fn archive(bytes: &[u8]) -> Vec<u8> {
    let starts = bytes.windows(MEMBER.len()).enumerate();
    let starts = starts.filter(|(_, window)| *window == MEMBER);
    let mut limits: Vec<usize> = starts.map(|(at, _)| at).collect();
    limits.insert(0, 0);
    limits.push(bytes.len());
    limits.dedup();
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    let options = options.compression_method(zip::CompressionMethod::Deflated);
    for (number, limits) in limits.windows(2).enumerate() {
        let name = match number {
            0 => "run.npy".to_owned(),
            1 => "H1_2.npy".to_owned(),
            _ => format!("C1_{number}.npy"),
        };
        archive.start_file(name, options).unwrap();
        archive.write_all(&bytes[limits[0]..limits[1]]).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// Signatures of the parts of an HDF5 file that end with a check sum.
const SIGNATURES: [&[u8]; 10] = [
    b"\x89HDF\r\n\x1a\n",
    b"OHDR",
    b"OCHK",
    b"BTHD",
    b"BTIN",
    b"BTLF",
    b"FRHP",
    b"FHDB",
    b"FHIB",
    b"EAHD",
];

/// No part with a check sum is looked for beyond so many bytes.
const MAX_PART_BYTES: usize = 4096;

/// The parts of an intact file: from a signature to where the check sum of it stands.
fn hdf5_check_sums(seed: &[u8]) -> Vec<Range<usize>> {
    let starts = (0..seed.len()).filter(|at| {
        let rest = &seed[*at..];
        SIGNATURES
            .iter()
            .any(|signature| rest.starts_with(signature))
    });
    let part = |start: usize| {
        let last = seed.len().saturating_sub(4).min(start + MAX_PART_BYTES);
        let end = (start + 8..=last).find(|end| {
            let stated = seed[*end..*end + 4].try_into().unwrap();
            lookup3(&seed[start..*end]) == u32::from_le_bytes(stated)
        });
        Some(start..end?)
    };
    starts.filter_map(part).collect()
}

/// The check sum of HDF5: Jenkins's lookup3, which begins with 0.
fn lookup3(bytes: &[u8]) -> u32 {
    let first = 0xdead_beef_u32.wrapping_add(bytes.len() as u32);
    let [mut a, mut b, mut c] = [first; 3];
    let word = |bytes: &[u8], at: usize| {
        let byte = |n: usize| u32::from(bytes.get(at + n).copied().unwrap_or(0));
        byte(0) | byte(1) << 8 | byte(2) << 16 | byte(3) << 24
    };
    let mut rest = bytes;
    while rest.len() > 12 {
        a = a.wrapping_add(word(rest, 0));
        b = b.wrapping_add(word(rest, 4));
        c = c.wrapping_add(word(rest, 8));
        for (x, y, z, bits) in [(0, 2, 1, 4), (1, 0, 2, 6), (2, 1, 0, 8)]
            .into_iter()
            .chain([(0, 2, 1, 16), (1, 0, 2, 19), (2, 1, 0, 4)])
        {
            let mut words = [a, b, c];
            words[x] = words[x].wrapping_sub(words[y]) ^ words[y].rotate_left(bits);
            words[y] = words[y].wrapping_add(words[z]);
            [a, b, c] = words;
        }
        rest = &rest[12..];
    }
    if rest.is_empty() {
        return c;
    }
    a = a.wrapping_add(word(rest, 0));
    b = b.wrapping_add(word(rest, 4));
    c = c.wrapping_add(word(rest, 8));
    let mixed = |x: u32, y: u32, bits| (x ^ y).wrapping_sub(y.rotate_left(bits));
    c = mixed(c, b, 14);
    a = mixed(a, c, 11);
    b = mixed(b, a, 25);
    c = mixed(c, b, 16);
    a = mixed(a, c, 4);
    b = mixed(b, a, 14);
    mixed(c, b, 24)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds;

    #[test]
    fn check_sums_of_hdf5_are_found() {
        let seeds = seeds::hdf5();
        let parts = seeds.iter().map(|seed| hdf5_check_sums(seed).len());
        let parts: usize = parts.sum();
        assert!(parts >= 10, "{parts}");
    }
}
