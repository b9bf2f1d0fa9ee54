//! Links of a group with many of them: link messages in a fractal heap, which a version 2 B-tree
//! indexes by their names.

use super::fields::Fields;
use super::{GroupLinks, LINK_BYTES, Walk};

/// Nodes of a B-tree below each other; a tree of so many levels has more records than a file.
const MAX_TREE_DEPTH: u64 = 16;

/// Where the objects of a fractal heap are.
struct Heap {
    /// Bytes of an offset, and of a length, in the identifier of an object.
    offset_bytes: usize,
    length_bytes: usize,
    /// Blocks in a row of the heap.
    width: u64,
    /// Bytes of a block of the first two rows, and of the largest that holds objects itself.
    first_block: u64,
    largest_block: u64,
    /// The root block, and its rows; without rows it holds objects itself.
    root: u64,
    rows: u64,
}

impl Walk<'_> {
    /// The links that a link info message leads to; none where the group has no such storage.
    pub(super) fn dense_links(&mut self, data: &[u8], links: &mut GroupLinks) -> Option<()> {
        let mut fields = Fields::new(data);
        fields.skip(1)?;
        let flags = fields.number(1)?;
        fields.skip(if flags & 1 != 0 { 8 } else { 0 })?;
        let heap = fields.number(self.file.address_bytes)?;
        let tree = fields.number(self.file.address_bytes)?;
        if self.file.is_undefined(heap) {
            return Some(());
        }
        let heap = self.heap(heap)?;
        for identifier in self.tree_records(tree)? {
            let message = self.heap_object(&heap, &identifier)?;
            self.link(&message, links)?;
        }
        Some(())
    }

    fn heap(&self, address: u64) -> Option<Heap> {
        let (lengths, addresses) = (self.file.length_bytes, self.file.address_bytes);
        let bytes = 22 + 12 * lengths + 3 * addresses;
        let header = self.file.read(address, bytes as u64)?;
        let mut fields = Fields::new(&header);
        if fields.bytes(4)? != b"FRHP" {
            return None;
        }
        fields.skip(3)?;
        // Objects of a filtered heap cannot be read where they are.
        if fields.number(2)? != 0 {
            return None;
        }
        fields.skip(1)?;
        let largest_object = fields.number(4)?;
        fields.skip(10 * lengths + 2 * addresses)?;
        let width = fields.number(2)?;
        let (first_block, largest_block) = (fields.number(lengths)?, fields.number(lengths)?);
        let offset_bits = fields.number(2)?;
        fields.skip(2)?;
        let root = fields.number(addresses)?;
        let rows = fields.number(2)?;
        // A length takes the bytes that the smaller of the two limits needs.
        let largest = largest_block.min(largest_object);
        let length_bits = u64::BITS - largest.leading_zeros();
        (first_block > 0 && width > 0 && offset_bits <= 64).then_some(Heap {
            offset_bytes: offset_bits.div_ceil(8) as usize,
            length_bytes: length_bits.div_ceil(8) as usize,
            width,
            first_block,
            largest_block,
            root,
            rows,
        })
    }

    /// The link message of an identifier.
    fn heap_object(&self, heap: &Heap, identifier: &[u8]) -> Option<Vec<u8>> {
        let mut fields = Fields::new(identifier);
        // Version and kind: an object in a block of the heap.
        if fields.number(1)? & 0xf0 != 0 {
            return None;
        }
        let offset = fields.number(heap.offset_bytes)?;
        let length = fields.number(heap.length_bytes)?;
        let (block, start) = self.heap_block(heap, offset)?;
        let at = block.checked_add(offset.checked_sub(start)?)?;
        self.file.read(at, length)
    }

    /// Address of the block that holds an offset of the heap, and its first offset. The blocks of
    /// the first two rows have one size, those of every further row twice that of the row before.
    fn heap_block(&self, heap: &Heap, offset: u64) -> Option<(u64, u64)> {
        if heap.rows == 0 {
            return Some((heap.root, 0));
        }
        let mut start: u64 = 0;
        let mut size = heap.first_block;
        for row in 0..heap.rows {
            if row > 1 {
                size = size.checked_mul(2)?;
            }
            // Larger blocks hold rows of blocks; groups of some ten thousand links have them.
            if size > heap.largest_block {
                return None;
            }
            let end = start.checked_add(size.checked_mul(heap.width)?)?;
            if offset < end {
                let column = (offset - start) / size;
                let child = row * heap.width + column;
                let head = 5 + self.file.address_bytes + heap.offset_bytes;
                let at = head as u64 + child * self.file.address_bytes as u64;
                let address = heap.root.checked_add(at)?;
                let bytes = self.file.read(address, self.file.address_bytes as u64)?;
                let block = Fields::new(&bytes).number(self.file.address_bytes)?;
                return Some((block, start + column * size));
            }
            start = end;
        }
        None
    }

    /// The heap identifiers of the records of a version 2 B-tree.
    fn tree_records(&mut self, address: u64) -> Option<Vec<Vec<u8>>> {
        let (lengths, addresses) = (self.file.length_bytes, self.file.address_bytes);
        let bytes = 18 + addresses + lengths;
        let header = self.file.read(address, bytes as u64)?;
        let mut fields = Fields::new(&header);
        if fields.bytes(4)? != b"BTHD" {
            return None;
        }
        fields.skip(1)?;
        // Links by the hash of their names: 4 bytes before the identifier.
        if fields.number(1)? != 5 {
            return None;
        }
        let (node_bytes, record_bytes) = (fields.number(4)?, fields.number(2)?);
        let depth = fields.number(2)?;
        fields.skip(2)?;
        let (root, count) = (fields.number(addresses)?, fields.number(2)?);
        if depth > MAX_TREE_DEPTH || record_bytes < 5 {
            return None;
        }
        // Records that a node of each depth can hold, and below it: they set the width of counts.
        let bytes_of = |number: u64| u64::from(u64::BITS - number.leading_zeros()).div_ceil(8);
        let in_leaf = node_bytes.checked_sub(10)? / record_bytes;
        let count_bytes = bytes_of(in_leaf);
        let mut total_bytes = vec![0];
        let mut below = in_leaf;
        for level in 1..=depth {
            let pointer = addresses as u64 + count_bytes + total_bytes[level as usize - 1];
            let left = node_bytes.checked_sub(10 + pointer)?;
            let in_node = left / (record_bytes + pointer);
            below = (in_node + 1).checked_mul(below)?.checked_add(in_node)?;
            total_bytes.push(bytes_of(below));
        }
        let mut records = Vec::new();
        let mut open = vec![(root, count, depth)];
        while let Some((address, count, level)) = open.pop() {
            if count == 0 {
                continue;
            }
            let node = self.file.read(address, node_bytes)?;
            let mut fields = Fields::new(&node);
            let signature = if level == 0 { b"BTLF" } else { b"BTIN" };
            if fields.bytes(4)? != signature {
                return None;
            }
            fields.skip(2)?;
            for _ in 0..count {
                self.name_bytes = self.name_bytes.checked_sub(LINK_BYTES)?;
                records.push(fields.bytes(record_bytes)?.get(4..)?.to_vec());
            }
            if level == 0 {
                continue;
            }
            for _ in 0..=count {
                let child = fields.number(addresses)?;
                let child_count = fields.number(count_bytes as usize)?;
                fields.skip(total_bytes[level as usize - 1] as usize)?;
                open.push((child, child_count, level - 1));
            }
        }
        Some(records)
    }
}
