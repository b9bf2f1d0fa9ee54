//! An FRF set as a source.

use std::ops::Range;

use crate::frf::{FrfSet, Function};
use crate::io::{
    Block, Catalog, Entry, EntryAxis, FunctionMetadata, FunctionType, Identification, IoError,
    MemorySource, SampleFormat, Source,
};
use crate::quantity::Quantity;

/// Type of a multiple coherence in dataset 58.
const MULTIPLE_COHERENCE: i32 = 26;

/// An FRF set as a source, its values where they are: every function (complex, 64 bits), then the
/// coherences that there are, those of several references, then the variances
/// ([`FunctionType::Variance`], SI unit squared). Values are in SI units; each entry has the note
/// of its function.
pub struct FrfSource<'a> {
    /// Its contents; geometry may be added.
    pub catalog: Catalog,
    set: &'a FrfSet,
    /// Function of each entry; the number of the response for a multiple coherence.
    functions: Vec<usize>,
}

/// The source of a set.
pub fn frf_source<'a>(set: &'a FrfSet, title: &str) -> FrfSource<'a> {
    let mut source = FrfSource {
        catalog: MemorySource::with_title(title).catalog,
        set,
        functions: Vec::new(),
    };
    let functions = || set.functions().iter().enumerate();
    for (i, function) in functions() {
        let mut entry = function_entry(set, function, title);
        entry.unit_label = function.kind.si_unit().to_owned();
        source.push(entry, i);
    }
    for (i, function) in functions().filter(|(i, _)| set.coherence(*i).is_some()) {
        let entry = Entry {
            function_type: FunctionType::Coherence,
            quantity: None,
            denominator: None,
            format: SampleFormat::RealF64,
            ..function_entry(set, function, title)
        };
        source.push(entry, i);
    }
    for (i, response) in set.multiple_coherence.keys().enumerate() {
        let axis = EntryAxis::Frequency(*set.axis());
        let entry = Entry {
            identification: Identification::with_title(title),
            response: Some(response.clone()),
            to_si: Some(1.0),
            axis_label: "Hz".to_owned(),
            ..Entry::new(
                FunctionType::Other(MULTIPLE_COHERENCE),
                axis,
                SampleFormat::RealF64,
            )
        };
        source.push(entry, i);
    }
    for (i, function) in functions().filter(|(i, _)| set.variance(*i).is_some()) {
        let entry = Entry {
            function_type: FunctionType::Variance,
            format: SampleFormat::RealF64,
            unit_label: format!("({})^2", function.kind.si_unit()),
            ..function_entry(set, function, title)
        };
        source.push(entry, i);
    }
    source
}

impl FrfSource<'_> {
    fn push(&mut self, entry: Entry, function: usize) {
        self.catalog.entries.push(entry);
        self.functions.push(function);
    }
}

impl Source for FrfSource<'_> {
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
        let function = self.functions[entry];
        let real = match self.catalog.entries[entry].function_type {
            FunctionType::Coherence => self.set.coherence(function),
            FunctionType::Variance => self.set.variance(function),
            FunctionType::Other(MULTIPLE_COHERENCE) => {
                let mut values = self.set.multiple_coherence.values();
                values.nth(function).map(Vec::as_slice)
            }
            _ => None,
        };
        *block = match real {
            Some(values) => Block::F64(values[range].to_vec()),
            None => Block::Complex(self.set.values(function)[range].to_vec()),
        };
        Ok(())
    }
}

/// The entry of an FRF; a coherence or variance differs by type and ordinate.
fn function_entry(set: &FrfSet, function: &Function, title: &str) -> Entry {
    let axis = EntryAxis::Frequency(*set.axis());
    Entry {
        identification: Identification::with_title(title),
        response: Some(function.response.clone()),
        reference: Some(function.reference.clone()),
        quantity: Some(function.kind.response_quantity()),
        denominator: Some(Quantity::Force),
        to_si: Some(1.0),
        axis_label: "Hz".to_owned(),
        note: FunctionMetadata {
            averages: function.averages,
            estimator: function.estimator,
            added_damping_rad_s: Some(set.added_damping_rad_s).filter(|decay| *decay > 0.0),
            record_s: set.record_duration_s,
            window: set.window,
            variance_dof: function.variance_dof,
            interpolated: set.is_interpolated,
            valid_hz: set.valid_band.map(|band| (band.lo_hz, band.hi_hz)),
        },
        ..Entry::new(FunctionType::Frf, axis, SampleFormat::ComplexF64)
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;
    use crate::axis::FrequencyAxis;
    use crate::frf::{Estimator, FunctionData};
    use crate::quantity::FrfKind;

    #[test]
    fn functions_then_coherences_then_variances() {
        let axis = FrequencyAxis {
            start_hz: 0.5,
            step_hz: 0.25,
            len: 2,
        };
        let mut set = FrfSet::new(axis);
        set.added_damping_rad_s = 2.5;
        for (response, quality) in [("1:+Z", None), ("2:-X#2", Some(vec![0.5, 0.75]))] {
            let function = Function {
                response: response.parse().expect("a degree of freedom"),
                reference: "1:+Z".parse().expect("a degree of freedom"),
                kind: FrfKind::Mobility,
                averages: Some(3),
                estimator: Some(Estimator::H1),
                variance_dof: None,
            };
            let data = FunctionData {
                values: vec![Complex64::new(1.0, 2.0), Complex64::new(3.0, 4.0)],
                coherence: quality.clone(),
                variance: quality,
            };
            set.push(function, data).expect("a function of the set");
        }
        let mut source = frf_source(&set, " Beam ");
        let types: Vec<FunctionType> = source
            .catalog()
            .entries
            .iter()
            .map(|entry| entry.function_type)
            .collect();
        use FunctionType::{Coherence, Frf, Variance};
        assert_eq!(types, [Frf, Frf, Coherence, Variance]);
        assert_eq!(source.catalog().title, ["Beam"]);
        let variance = &source.catalog().entries[3];
        assert_eq!(variance.unit_label, "((m/s)/N)^2");
        assert_eq!(
            variance.response.as_ref().expect("a response").to_string(),
            "2:-X#2"
        );
        assert_eq!(variance.note.averages, Some(3));
        assert_eq!(variance.note.added_damping_rad_s, Some(2.5));
        assert_eq!(source.catalog().entries[0].axis, EntryAxis::Frequency(axis));
        let mut block = Block::F32(Vec::new());
        source
            .read(2, 1..2, &mut block)
            .expect("samples of the entry");
        assert_eq!(block, Block::F64(vec![0.75]));
    }
}
