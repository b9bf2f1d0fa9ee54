//! Fields of a structure, one after the other, least significant byte first.

/// The bytes of a structure, of which some have been read.
pub(super) struct Fields<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> Fields<'a> {
    /// From the first byte.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, position: 0 }
    }

    /// Bytes that were read.
    pub fn position(&self) -> u64 {
        self.position as u64
    }

    /// Bytes that follow.
    pub fn left(&self) -> usize {
        self.bytes.len() - self.position
    }

    /// The next bytes; nothing where fewer follow.
    pub fn bytes(&mut self, count: u64) -> Option<&'a [u8]> {
        let end = self.position.checked_add(usize::try_from(count).ok()?)?;
        let bytes = self.bytes.get(self.position..end)?;
        self.position = end;
        Some(bytes)
    }

    /// Passes over the next bytes.
    pub fn skip(&mut self, count: usize) -> Option<()> {
        self.bytes(count as u64).map(drop)
    }

    /// The next whole number of up to 8 bytes.
    pub fn number(&mut self, count: usize) -> Option<u64> {
        if count > 8 {
            return None;
        }
        let bytes = self.bytes(count as u64)?.iter().rev();
        Some(bytes.fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }
}
