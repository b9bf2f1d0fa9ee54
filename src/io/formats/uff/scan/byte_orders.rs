//! The byte orders of the binary functions of a file: a stated one that the values contradict is
//! replaced by the opposite one.

use std::io;

use super::scanner::{ByteOrder, Scanner};
use crate::finding::{Code, Finding, Severity};
use crate::io::formats::uff::dataset_58::binary_samples::{BinaryBlock, Samples};
use crate::io::formats::uff::dataset_58::byte_order::{Evidence, evidence};

/// Bytes of a block that are judged at once. With less, a short run of zeros hides the order; with
/// more, opening a file of many functions takes longer.
const SAMPLE_BYTES: usize = 2048;

impl Scanner {
    /// Judges the values at the start of a block, or those in its middle where the former show
    /// nothing, as zeros before an impact.
    pub fn byte_order_evidence(
        &mut self,
        block: &BinaryBlock,
        points: u64,
    ) -> io::Result<Evidence> {
        let stride = block.stride() as u64;
        let count = points.min(SAMPLE_BYTES as u64 / stride);
        for first in [0, (points - count) / 2] {
            let start = block.byte + first * stride;
            let bytes = self.lines.bytes_at(start, (count * stride) as usize)?;
            let found = evidence(bytes, block);
            if found != Evidence::None {
                return Ok(found);
            }
        }
        Ok(Evidence::None)
    }

    /// Gives the functions whose values show nothing the opposite order too, where all others of
    /// the file have it, and reports how many have.
    pub fn settle_byte_orders(&mut self) {
        let orders = std::mem::take(&mut self.byte_orders);
        let opposite = |order: &&ByteOrder| order.evidence == Evidence::Opposite;
        let Some(first) = orders.iter().find(opposite) else {
            return;
        };
        let mut count = orders.iter().filter(opposite).count();
        if !orders
            .iter()
            .any(|order| order.evidence == Evidence::Stated)
        {
            for order in orders
                .iter()
                .filter(|order| order.evidence == Evidence::None)
            {
                if let Samples::Binary(block) = &mut self.samples[order.entry]
                    && block.abscissa_bytes == 0
                {
                    block.little_endian = !block.little_endian;
                    count += 1;
                }
            }
        }
        let location = self.location(first.at);
        let finding = Finding::new(Severity::Warning, Code::ByteOrderWrong, location);
        self.catalog.findings.push(finding.value(count as f64, ""));
    }
}
