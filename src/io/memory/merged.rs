//! Several sources as one.

use std::ops::Range;

use crate::dof::Dof;
use crate::finding::Location;
use crate::io::{Block, Catalog, IoError, Part, Source};

/// Several sources as one: entries, modes and geometry one after the other.
pub struct Merged {
    catalog: Catalog,
    sources: Vec<Box<dyn Source>>,
    /// Source and entry within it, for each entry.
    places: Vec<(usize, usize)>,
}

impl Merged {
    /// The sources in order. A title is the first one that there is; geometry is put together by
    /// [`crate::geometry::Geometry::add`].
    pub fn new(mut sources: Vec<Box<dyn Source>>) -> Self {
        let mut catalog = Catalog::default();
        let mut places = Vec::new();
        for (number, source) in sources.iter_mut().enumerate() {
            catalog.damage.extend(source.take_damage());
            let part = source.catalog();
            if number == 0 {
                (catalog.format, catalog.path) = (part.format, part.path.clone());
            }
            if catalog.title.is_empty() {
                catalog.title = part.title.clone();
            }
            places.extend((0..part.entries.len()).map(|entry| (number, entry)));
            catalog.entries.extend(part.entries.iter().cloned());
            catalog.modes.extend(part.modes.iter().cloned());
            catalog.arrays.extend(part.arrays.iter().cloned());
            catalog.findings.extend(part.findings.iter().cloned());
            catalog.geometry.add(&part.geometry);
        }
        Self {
            catalog,
            sources,
            places,
        }
    }
}

impl Merged {
    /// Sets the DOFs of source `number` where its headers do not state them or name channels.
    pub fn state_points(&mut self, number: usize, response: Option<&Dof>, reference: Option<&Dof>) {
        for (entry, place) in self.catalog.entries.iter_mut().zip(&self.places) {
            if place.0 == number {
                entry.response = entry.response_point(response);
                entry.reference = entry.reference_point(reference);
                entry.response_is_channel &= response.is_none();
                entry.reference_is_channel &= reference.is_none();
            }
        }
    }

    /// Reads every entry once and leaves out those that cannot be read, each with its damage: a
    /// text may turn out not to be numbers only when it is read.
    pub fn leave_out_unreadable(&mut self) {
        let (mut block, mut abscissa) = (Block::F64(Vec::new()), Vec::new());
        let mut good = vec![true; self.places.len()];
        for (entry, good) in good.iter_mut().enumerate() {
            let all = 0..self.catalog.entries[entry].len();
            let uneven = self.catalog.entries[entry].axis.even().is_none();
            let mut read = self.read(entry, all.clone(), &mut block);
            if read.is_ok() && uneven {
                read = self.abscissa(entry, all, &mut abscissa);
            }
            if let Err(error) = read {
                *good = false;
                let path = &self.sources[self.places[entry].0].catalog().path;
                let entry = &self.catalog.entries[entry];
                let location = Location::File {
                    path: path.clone(),
                    line: entry.line,
                    byte: entry.byte.filter(|_| entry.line.is_none()),
                };
                let part = Part::of_function(entry.function_type);
                self.catalog.note_damage_at(error, part, location);
            }
        }
        let mut kept = good.iter();
        self.catalog.entries.retain(|_| kept.next() == Some(&true));
        let mut kept = good.iter();
        self.places.retain(|_| kept.next() == Some(&true));
    }
}

impl Source for Merged {
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
        let (source, entry_in_source) = self.places[entry];
        self.sources[source].read(entry_in_source, range, block)
    }

    fn read_abscissa(
        &mut self,
        entry: usize,
        range: Range<usize>,
        out: &mut Vec<f64>,
    ) -> Result<(), IoError> {
        let (source, entry_in_source) = self.places[entry];
        self.sources[source].abscissa(entry_in_source, range, out)
    }
}
