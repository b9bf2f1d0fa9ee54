//! Files of Data Physics SignalCalc for MATLAB: names and texts of the arrays state the functions.
//!
//! | array | content |
//! |---|---|
//! | `H1_2`, `C1_2` | FRF and coherence of channel 2, the response, over channel 1, the reference; columns are frequency in Hz and values |
//! | `X1`, `W1` | record of channel 1 of the last hit, without and with its window; columns are time in s and values |
//! | `ChanNum`, `ChanName`, `Unit` | number, name and unit of each channel, one row each |
//! | `DP_Info` | pairs of rows: `Signal H1_2`, then how it is stored and its unit, `Real/Imag (g)(N)`; of an FRF the second bracket is the denominator |
//!
//! FRFs and coherences become entries. Records stay arrays: they are those of the last hit alone,
//! of which an FRF says less than the average over all hits. Spectra, powers and impulse responses
//! stay arrays too. The files state no number of averages, and points only in names of channels.

mod channels;
mod named_columns;
mod record_window;

use crate::finding::{Code, Finding, Location, Severity};
use crate::io::formats::text::{Abscissa, axis_of, report_uneven_axis};
use crate::io::{
    ArrayInfo, Block, Catalog, Domain, Entry, FunctionType, MemorySource, Part, SampleFormat,
};

use super::store::ArrayStore;
use channels::Channels;
use named_columns::{AxisAndValues, FunctionName, columns_of, function_of, record_channel};
use record_window::{RecordWindow, of_function};

/// Whether names and texts of the arrays are those of such a file.
pub(super) fn is_signalcalc(store: &dyn ArrayStore) -> bool {
    let list = store.list();
    let is_frf = |info: &ArrayInfo| {
        function_of(info).is_some_and(|name| name.function_type == FunctionType::Frf)
    };
    let describes_channels = |info: &ArrayInfo| match info.name.as_str() {
        "DP_Info" => info.kind == "text",
        name => name == "ChanNum",
    };
    list.iter().any(is_frf) && list.iter().any(describes_channels)
}

/// Makes the source; `catalog` has format, path and the findings of the store.
pub(super) fn open(store: &mut dyn ArrayStore, catalog: Catalog) -> MemorySource {
    let mut source = MemorySource {
        catalog,
        ..MemorySource::default()
    };
    let channels = Channels::read(store, &mut source.catalog);
    let windows = RecordWindow::read_all(store, &mut source.catalog);
    let list = store.list().to_vec();
    for (index, info) in list.iter().enumerate() {
        let Some(name) = function_of(info) else {
            source.catalog.arrays.push(info.clone());
            continue;
        };
        match store
            .read(index)
            .and_then(|array| columns_of(array, &source.catalog.path))
        {
            Ok(columns) => {
                let window = of_function(&windows, name.reference, name.response);
                push_function(name, info, columns, &channels, window, &mut source);
            }
            Err(error) => {
                let part = Part::of_function(name.function_type);
                source.catalog.note_damage(error, part);
            }
        }
    }
    let is_record = |info: &&ArrayInfo| record_channel(info, 'X').is_some();
    let records = source.catalog.arrays.iter().filter(is_record).count();
    if records > 0 {
        let finding = Finding::new(Severity::Info, Code::LastHitPassedOver, Location::Whole);
        let finding = finding.value(records as f64, "records");
        source.catalog.findings.push(finding);
    }
    source
}

fn push_function(
    name: FunctionName,
    info: &ArrayInfo,
    columns: AxisAndValues,
    channels: &Channels,
    window: Option<RecordWindow>,
    source: &mut MemorySource,
) {
    let frequency = Abscissa {
        domain: Domain::Frequency,
        uneven: false,
        label: "Hz".to_owned(),
    };
    let (axis, abscissa, label) = axis_of(&frequency, columns.axis);
    report_uneven_axis(&axis, None, source);
    let format = match columns.values {
        Block::Complex(_) => SampleFormat::ComplexF64,
        _ => SampleFormat::RealF64,
    };
    let mut entry = Entry::new(name.function_type, axis, format);
    entry.axis_label = label;
    entry.identification.lines[0].clone_from(&info.name);
    let (response, reference) = (
        channels.point(name.response),
        channels.point(name.reference),
    );
    (entry.response, entry.response_is_channel) = (response.dof, response.is_channel);
    (entry.reference, entry.reference_is_channel) = (reference.dof, reference.is_channel);
    if name.function_type == FunctionType::Frf {
        let unit = channels.frf_unit(info, name.reference, name.response);
        (entry.quantity, entry.denominator) = (unit.quantity, unit.denominator);
        (entry.to_si, entry.unit_label) = (unit.to_si, unit.label);
        if let Some(window) = window {
            window.describe(&mut entry.note);
        }
    } else {
        entry.to_si = Some(1.0);
    }
    source.push(entry, columns.values, abscissa);
}
