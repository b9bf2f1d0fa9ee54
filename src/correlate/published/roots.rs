//! Root matching assigns published roots to roots of the model and gives their differences.

use std::f64::consts::TAU;

use crate::correlate::assign;
use crate::linalg::sort_ascending_by;
use crate::theory::ModelRoot;

/// One root as a table of natural frequencies prints it.
#[derive(Clone, Debug, PartialEq)]
pub struct PublishedRoot {
    /// Label, as printed.
    pub label: String,
    /// Angular frequency, rad/s; 0 for rigid-body modes.
    pub omega_rad_s: f64,
    /// The same as a frequency, Hz, as printed; `None` where the angular frequency is what is
    /// printed.
    pub printed_hz: Option<f64>,
    /// Number of modes that share it.
    pub multiplicity: usize,
    /// Kind of motion, as printed.
    pub class: Option<String>,
    /// Whether a parameter of the model was inferred from it, so that its agreement says nothing.
    pub calibrated: bool,
}

/// Options of matching.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchOptions {
    /// Maximum difference of matching roots, as a fraction of the smaller one.
    pub max_frequency_error: f64,
}

impl Default for MatchOptions {
    /// A gate of 5 %.
    fn default() -> Self {
        Self {
            max_frequency_error: 0.05,
        }
    }
}

/// One row: a root of the model, a published one, or both.
#[derive(Clone, Debug, PartialEq)]
pub struct RootRow {
    /// The model's root; `None` where the model has none near the published one.
    pub model: Option<ModelRoot>,
    /// The published root; `None` where it is not printed.
    pub published: Option<PublishedRoot>,
    /// (model − published)/published, percent; `None` unless there are both and they are above 0.
    pub error_percent: Option<f64>,
}

impl RootRow {
    /// Whether model and print have the same number of modes; `None` unless there are both.
    pub fn same_multiplicity(&self) -> Option<bool> {
        let (model, published) = (self.model.as_ref()?, self.published.as_ref()?);
        Some(model.modes.len() == published.multiplicity)
    }

    /// Whether this is a single root on both sides.
    fn is_simple(&self) -> bool {
        let single = self.published.as_ref().map(|root| root.multiplicity) == Some(1);
        single && self.same_multiplicity() == Some(true)
    }

    fn omega_rad_s(&self) -> f64 {
        let published = self.published.as_ref().map(|root| root.omega_rad_s);
        let model = self.model.as_ref().map(|root| root.omega_rad_s);
        published.or(model).unwrap_or(0.0)
    }
}

/// Errors of several rows.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorSummary {
    /// Number of rows.
    pub count: usize,
    /// Root mean square of their errors, percent.
    pub rms_percent: f64,
    /// The error of largest magnitude, with its sign, percent.
    pub largest_percent: f64,
    /// Label of its row.
    pub largest_at: String,
}

/// A model's roots against published ones.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct RootMatch {
    /// All roots of both, ascending.
    pub rows: Vec<RootRow>,
    /// Errors of the rows that are single roots, above 0, on both sides; `None` without any.
    pub simple: Option<ErrorSummary>,
    /// Errors of all rows above 0; `None` without any.
    pub elastic: Option<ErrorSummary>,
}

impl RootMatch {
    /// The published roots, ascending.
    pub fn published(&self) -> impl Iterator<Item = &PublishedRoot> {
        self.rows.iter().filter_map(|row| row.published.as_ref())
    }

    /// The model's roots, ascending.
    pub fn model(&self) -> impl Iterator<Item = &ModelRoot> {
        self.rows.iter().filter_map(|row| row.model.as_ref())
    }
}

/// Frequency of an angular frequency, Hz.
pub fn frequency_hz(omega_rad_s: f64) -> f64 {
    omega_rad_s / TAU
}

/// Matches published roots with roots of the model by frequency, never by their index.
///
/// A root at 0 matches a root at 0 only. The assignment within the gate minimises the sum of
/// `|ln(model/published)|`, where a published root without a partner costs as much as one at the
/// gate. Several assignments can have that sum: roots with a partner are therefore paired in
/// ascending order, which increases neither the sum nor the largest distance. Multiplicities are
/// compared, but do not affect the assignment.
pub fn match_roots(
    model: &[ModelRoot],
    published: &[PublishedRoot],
    options: &MatchOptions,
) -> RootMatch {
    let partners = partners(model, published, options);
    let mut taken = vec![false; model.len()];
    let mut rows = Vec::with_capacity(model.len() + published.len());
    for (root, partner) in published.iter().zip(partners) {
        if let Some(j) = partner {
            taken[j] = true;
        }
        rows.push(row(partner.map(|j| &model[j]), Some(root)));
    }
    let unmatched = (0..model.len()).filter(|j| !taken[*j]);
    rows.extend(unmatched.map(|j| row(Some(&model[j]), None)));
    sort_ascending_by(&mut rows, |row| row.omega_rad_s());
    RootMatch {
        simple: summary(rows.iter().filter(|row| row.is_simple())),
        elastic: summary(rows.iter()),
        rows,
    }
}

/// The model's root of every published one.
fn partners(
    model: &[ModelRoot],
    published: &[PublishedRoot],
    options: &MatchOptions,
) -> Vec<Option<usize>> {
    let gate = options.max_frequency_error.ln_1p();
    let costs_of = |root: &PublishedRoot| {
        let cost =
            |candidate: &ModelRoot| Some(distance(candidate.omega_rad_s, root.omega_rad_s)? / gate);
        let allowed = |candidate: &ModelRoot| cost(candidate).filter(|cost| *cost <= 1.0);
        model.iter().map(allowed).collect::<Vec<_>>()
    };
    let costs: Vec<_> = published.iter().map(costs_of).collect();
    let mut partners = assign(&costs, 1.0);
    let mut rows: Vec<usize> = (0..published.len())
        .filter(|i| partners[*i].is_some())
        .collect();
    rows.sort_by(|a, b| {
        published[*a]
            .omega_rad_s
            .total_cmp(&published[*b].omega_rad_s)
    });
    let mut columns: Vec<usize> = partners.iter().copied().flatten().collect();
    sort_ascending_by(&mut columns, |column| model[*column].omega_rad_s);
    for (row, column) in rows.into_iter().zip(columns) {
        partners[row] = Some(column);
    }
    partners
}

/// `|ln(a/b)|` of two frequencies above 0, 0 of two zeros; `None` of a zero and another.
fn distance(a: f64, b: f64) -> Option<f64> {
    match (a > 0.0, b > 0.0) {
        (true, true) => Some((a / b).ln().abs()),
        (false, false) => Some(0.0),
        _ => None,
    }
}

fn row(model: Option<&ModelRoot>, published: Option<&PublishedRoot>) -> RootRow {
    let error = |computed: f64, printed: f64| {
        (printed > 0.0).then(|| 100.0 * (computed - printed) / printed)
    };
    RootRow {
        error_percent: model
            .zip(published)
            .and_then(|(computed, root)| error(computed.omega_rad_s, root.omega_rad_s)),
        model: model.cloned(),
        published: published.cloned(),
    }
}

fn summary<'a>(rows: impl Iterator<Item = &'a RootRow>) -> Option<ErrorSummary> {
    let errors: Vec<(f64, &str)> = rows
        .filter_map(|row| Some((row.error_percent?, row.published.as_ref()?.label.as_str())))
        .collect();
    let largest = errors
        .iter()
        .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    let squares: f64 = errors.iter().map(|(error, _)| error * error).sum();
    Some(ErrorSummary {
        count: errors.len(),
        rms_percent: (squares / errors.len() as f64).sqrt(),
        largest_percent: largest.0,
        largest_at: largest.1.to_owned(),
    })
}
