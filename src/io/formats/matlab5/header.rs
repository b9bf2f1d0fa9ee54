//! The header of a MATLAB file ends with its version and byte order.

/// Bytes of the header.
pub(super) const HEADER: usize = 128;

/// Version and byte-order mark of a little-endian file, at byte 124.
pub(super) const LITTLE_ENDIAN: &[u8] = b"\x00\x01IM";

/// As [`LITTLE_ENDIAN`], of a big-endian file.
pub(super) const BIG_ENDIAN: &[u8] = b"\x01\x00MI";
