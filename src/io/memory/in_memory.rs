//! A source whose samples are in memory.

use std::ops::Range;

use crate::io::catalog::sample_range::uneven_without_values;
use crate::io::{Block, Catalog, Entry, IoError, Source};

/// A source whose samples are in memory.
#[derive(Debug, Default)]
pub struct MemorySource {
    /// Its contents.
    pub catalog: Catalog,
    /// Values of each entry.
    pub blocks: Vec<Block>,
    /// Abscissa of each entry; empty where the entry's axis is even.
    pub abscissae: Vec<Vec<f64>>,
}

impl MemorySource {
    /// An empty source with this title; a blank title is none.
    pub(super) fn with_title(title: &str) -> Self {
        let mut source = MemorySource::default();
        let title = title.trim();
        if !title.is_empty() {
            source.catalog.title.push(title.to_owned());
        }
        source
    }

    /// Adds an entry with its values; `abscissa` is empty where the axis is even.
    pub fn push(&mut self, entry: Entry, values: Block, abscissa: Vec<f64>) {
        self.catalog.entries.push(entry);
        self.blocks.push(values);
        self.abscissae.push(abscissa);
    }
}

impl Source for MemorySource {
    fn catalog(&self) -> &Catalog {
        &self.catalog
    }

    fn catalog_mut(&mut self) -> &mut Catalog {
        &mut self.catalog
    }

    fn read_samples(
        &mut self,
        entry: usize,
        range: Range<usize>,
        block: &mut Block,
    ) -> Result<(), IoError> {
        match (&self.blocks[entry], &mut *block) {
            (Block::F32(values), Block::F32(out)) => replace(out, &values[range]),
            (Block::F64(values), Block::F64(out)) => replace(out, &values[range]),
            (Block::Complex(values), Block::Complex(out)) => replace(out, &values[range]),
            (Block::F32(values), _) => *block = Block::F32(values[range].to_vec()),
            (Block::F64(values), _) => *block = Block::F64(values[range].to_vec()),
            (Block::Complex(values), _) => *block = Block::Complex(values[range].to_vec()),
        }
        Ok(())
    }

    fn read_abscissa(
        &mut self,
        entry: usize,
        range: Range<usize>,
        out: &mut Vec<f64>,
    ) -> Result<(), IoError> {
        let abscissa = self
            .abscissae
            .get(entry)
            .and_then(|values| values.get(range));
        let abscissa = abscissa.ok_or_else(|| uneven_without_values(&self.catalog, entry))?;
        replace(out, abscissa);
        Ok(())
    }
}

fn replace<T: Copy>(out: &mut Vec<T>, values: &[T]) {
    out.clear();
    out.extend_from_slice(values);
}
