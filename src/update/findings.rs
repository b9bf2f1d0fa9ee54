//! Findings of an update report parameters, misfit and pairing that need attention.

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};

use super::{MAX_POSTERIOR_OVER_PRIOR, ParameterVerdict, UpdateResult, UpdatedParameter};

impl UpdateResult {
    /// Parameters that the data do not determine or that end at a bound, a remaining misfit,
    /// measured roots that changed or lost their partner, an iteration that did not converge.
    pub fn findings(&self) -> Vec<Finding> {
        let mut findings: Vec<Finding> = self.parameters.iter().filter_map(of_parameter).collect();
        if !self.fits() {
            findings.push(
                warn(Code::MisfitRemains, Location::Whole)
                    .value(self.reduced_chi_square(), "")
                    .limit(self.largest_reduced_chi_square()),
            );
        }
        let rows = self.after.rows.iter();
        let lost = rows.filter(|row| row.model_hz.is_none());
        findings.extend(lost.map(|row| warn(Code::PartnerLost, Location::Mode(row.test_hz))));
        findings.extend(self.changed_pairings());
        findings.extend(self.reversed.iter().map(|reversed| {
            let dofs: Vec<String> = reversed.dofs.iter().map(Dof::to_string).collect();
            let finding = warn(Code::ReversedLeftOut, Location::Whole).value(dofs.len() as f64, "");
            finding.detail(format!("{}: {}", reversed.test, dofs.join(", ")))
        }));
        if !self.stop_reason.converged() {
            let finding = warn(Code::NotConverged, Location::Whole);
            findings.push(finding.value(self.history.len() as f64, ""));
        }
        findings
    }

    fn changed_pairings(&self) -> impl Iterator<Item = Finding> {
        self.pairing_changes.iter().map(|change| {
            let mut rows = self.after.rows.iter();
            let row = rows.find(|row| row.label == change.label);
            let location = Location::Mode(row.map_or(0.0, |row| row.test_hz));
            let finding = Finding::new(Severity::Info, Code::PairingChanged, location);
            match (change.from.first(), change.to.first()) {
                (Some(from), Some(to)) => finding.value(*from as f64, "").limit(*to as f64),
                _ => finding,
            }
        })
    }
}

fn of_parameter(parameter: &UpdatedParameter) -> Option<Finding> {
    let location = Location::Parameter(parameter.name.clone());
    match parameter.verdict {
        ParameterVerdict::Identified => None,
        ParameterVerdict::NotSupported => {
            let finding = warn(Code::ParameterNotSupported, location);
            Some(
                finding
                    .value(parameter.posterior_over_prior, "")
                    .limit(MAX_POSTERIOR_OVER_PRIOR),
            )
        }
        ParameterVerdict::AtBound => {
            let finding = warn(Code::ParameterAtBound, location);
            Some(finding.value(parameter.updated, &parameter.unit))
        }
    }
}

fn warn(code: Code, location: Location) -> Finding {
    Finding::new(Severity::Warning, code, location)
}
