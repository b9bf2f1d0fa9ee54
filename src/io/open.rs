//! Opening files, and their fingerprints.

use std::io::{BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

use sha2::{Digest, Sha256};

use super::error::system;
use super::input::open_input;
use super::{Confidence, FORMATS, Format, Hints, IoError, ReadSeek, Source};

/// How many bytes a format sees when it judges a file.
const DETECTION_BYTES: usize = 4096;

/// The format that claims these first bytes with the highest confidence.
///
/// # Errors
/// [`IoError::UnknownFormat`] when none does; [`IoError::Tie`] when several are as sure.
pub fn detect(head: &[u8], path: &str) -> Result<&'static dyn Format, IoError> {
    let judged = FORMATS.iter().map(|format| (format.detect(head), *format));
    let claims: Vec<_> = judged
        .filter(|(confidence, _)| *confidence > Confidence::No)
        .collect();
    let best = claims.iter().map(|(confidence, _)| *confidence).max();
    let winners: Vec<_> = claims
        .iter()
        .filter(|(confidence, _)| Some(*confidence) == best)
        .collect();
    match winners.as_slice() {
        [(_, format)] => Ok(*format),
        [] => Err(IoError::UnknownFormat {
            path: path.to_owned(),
            got: content_kind(head),
            known: format_names(),
        }),
        several => Err(IoError::Tie {
            path: path.to_owned(),
            candidates: several
                .iter()
                .map(|(_, format)| format.name())
                .collect::<Vec<_>>()
                .join(", "),
        }),
    }
}

/// Maximum part of the bytes of a text that are control characters. Larger, at a half: numbers pass
/// for a text. Smaller, at 1e-4: a stray character in a heading makes a short text binary. Test
/// `a_text_with_a_control_character_is_named_with_its_byte`.
const MAX_CONTROL_FRACTION: f64 = 0.1;

/// Text or numbers; contents are not quoted, because a scene may name any file.
pub(super) fn content_kind(head: &[u8]) -> String {
    let is_control = |byte: &u8| !matches!(byte, b'\t' | b'\n' | b'\r' | b' '..);
    let controls = head.iter().filter(|byte| is_control(byte)).count();
    let first = head.iter().position(is_control);
    let is_rare = controls as f64 <= MAX_CONTROL_FRACTION * head.len() as f64;
    match first {
        _ if head.is_empty() => "an empty file".to_owned(),
        None => "a text file of unknown format".to_owned(),
        Some(at) if is_rare && !head.contains(&0) => format!(
            "a text file of unknown format, with the control character 0x{:02x} at byte {at}",
            head[at]
        ),
        Some(_) => "a binary file of unknown format".to_owned(),
    }
}

fn format_names() -> String {
    FORMATS
        .iter()
        .map(|format| format.name())
        .collect::<Vec<_>>()
        .join(", ")
}

fn format_named(name: &str, path: &str) -> Result<&'static dyn Format, IoError> {
    let found = FORMATS.iter().copied().find(|format| format.name() == name);
    found.ok_or_else(|| IoError::UnknownFormat {
        path: path.to_owned(),
        got: format!("--format {name}"),
        known: format_names(),
    })
}

/// The format of this name, or the one that a file's content shows.
///
/// # Errors
/// As [`open_path`].
pub fn format_of(path: &Path, format: Option<&str>) -> Result<&'static dyn Format, IoError> {
    let shown = path.display().to_string();
    if let Some(name) = format {
        return format_named(name, &shown);
    }
    let mut head = Vec::with_capacity(DETECTION_BYTES);
    let file = open_input(path).map_err(system(&shown, "open"))?;
    file.take(DETECTION_BYTES as u64)
        .read_to_end(&mut head)
        .map_err(system(&shown, "read"))?;
    detect(&head, &shown)
}

/// Opens a file with the format of this name, or the one that its content shows.
///
/// # Errors
/// [`IoError`] when it cannot be read, no format claims it, or its headers cannot be used at all.
pub fn open_path(
    path: &Path,
    hints: &Hints,
    format: Option<&str>,
) -> Result<Box<dyn Source>, IoError> {
    let file = open_input(path).map_err(system(&hints.path, "open"))?;
    open_stream(Box::new(BufReader::new(file)), hints, format)
}

/// Opens bytes as if they were a file.
///
/// # Errors
/// As [`open_path`].
pub fn open_bytes(bytes: Vec<u8>, hints: &Hints) -> Result<Box<dyn Source>, IoError> {
    open_stream(Box::new(Cursor::new(bytes)), hints, None)
}

fn open_stream(
    mut input: Box<dyn ReadSeek>,
    hints: &Hints,
    format: Option<&str>,
) -> Result<Box<dyn Source>, IoError> {
    let mut head = Vec::with_capacity(DETECTION_BYTES);
    input
        .by_ref()
        .take(DETECTION_BYTES as u64)
        .read_to_end(&mut head)
        .map_err(system(&hints.path, "read"))?;
    input
        .seek(SeekFrom::Start(0))
        .map_err(system(&hints.path, "read"))?;
    let format = format.map_or_else(
        || detect(&head, &hints.path),
        |name| format_named(name, &hints.path),
    )?;
    format.open(input, hints)
}

/// SHA-256 of a file, lower-case hexadecimal.
///
/// # Errors
/// [`IoError::System`] when it cannot be read.
pub fn sha256_hex(path: &Path) -> Result<String, IoError> {
    let name = path.display().to_string();
    let mut file = open_input(path).map_err(system(&name, "open"))?;
    let mut hasher = Sha256::new();
    std::io::copy(&mut file, &mut hasher).map_err(system(&name, "read"))?;
    Ok(hexadecimal(&hasher.finalize()))
}

/// SHA-256 of bytes, lower-case hexadecimal.
pub fn sha256_of_bytes(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_with_a_control_character_is_named_with_its_byte() {
        let text = b"force [N],accel\x01eration [m/s2]\n1,2\n3,4\n";
        let kind = content_kind(text);
        assert!(
            kind.ends_with("control character 0x01 at byte 15"),
            "{kind}"
        );
        let numbers: Vec<u8> = (0..200).map(|n| if n % 3 == 0 { 1 } else { 200 }).collect();
        assert_eq!(content_kind(&numbers), "a binary file of unknown format");
        assert_eq!(content_kind(b"a\0b"), "a binary file of unknown format");
        assert_eq!(content_kind(b"words"), "a text file of unknown format");
    }

    #[test]
    fn bytes_of_no_known_format_are_refused_with_the_known_formats() {
        let error = open_bytes(
            vec![0, 1, 2, 3],
            &Hints {
                path: "x.bin".to_owned(),
                ..Hints::default()
            },
        );
        let text = error.err().unwrap().to_string();
        assert!(
            text.starts_with("x.bin: got a binary file of unknown format") && text.contains("uff"),
            "{text}"
        );
    }
}
