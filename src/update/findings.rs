//! Findings of an update report parameters, misfit and pairing that need attention.

use crate::dof::Dof;
use crate::finding::{Code, Finding, Location, Severity};

use super::{
    Alternative, MAX_POSTERIOR_OVER_PRIOR, ParameterVerdict, ResidualKind, UpdateResult,
    UpdatedParameter,
};

impl UpdateResult {
    /// Parameters that the data do not determine or that end at a bound, a remaining misfit,
    /// measured roots that changed or lost their partner, an iteration that did not converge.
    pub fn findings(&self) -> Vec<Finding> {
        let parameters = self.parameters.iter().enumerate();
        let findings = parameters.filter_map(|(j, parameter)| self.of_parameter(j, parameter));
        let mut findings: Vec<Finding> = findings.collect();
        if !self.fits() {
            let (value, limit, kind) = self.worst_reduced_chi_square();
            let finding = warn(Code::MisfitRemains, Location::Whole);
            let finding = finding.value(value, "").limit(limit);
            findings.push(match kind.filter(|_| self.model_errors.len() > 1) {
                Some(kind) => finding.detail(kind.of_what()),
                None => finding,
            });
        }
        findings.extend(self.unpredicted.iter().map(|mode| {
            let finding = warn(Code::ModeNotPredicted, Location::Mode(mode.hz));
            let what = match mode.kind {
                ResidualKind::Frequency => "frequency",
                ResidualKind::Shape => "shape",
                ResidualKind::Other => "residual",
            };
            finding
                .value(mode.deviations, "")
                .limit(1.0)
                .detail(what.to_owned())
        }));
        findings.extend(self.contradiction.iter().map(|found| {
            let location = Location::Parameter(found.parameter.clone());
            let finding = warn(Code::ConfigurationsDisagree, location);
            finding
                .value(found.there, &found.unit)
                .limit(found.elsewhere)
                .detail(found.configuration.clone())
        }));
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

    fn of_parameter(&self, j: usize, parameter: &UpdatedParameter) -> Option<Finding> {
        let location = Location::Parameter(parameter.name.clone());
        match parameter.verdict {
            ParameterVerdict::Identified | ParameterVerdict::IdentifiedWithinModelError => None,
            ParameterVerdict::Ambiguous => {
                let distance = |other: &&Alternative| (other.values[j] - parameter.updated).abs();
                let others = self.alternatives.iter();
                let other = others.max_by(|a, b| distance(a).total_cmp(&distance(b)))?;
                let finding = warn(Code::ParameterAmbiguous, location);
                Some(finding.value(other.values[j], &parameter.unit))
            }
            // A misfit, a lost mode, one that is not predicted, and configurations that disagree
            // have their finding; the table states that one start alone ended at the optimum.
            ParameterVerdict::NotSupported
                if parameter.posterior_over_prior <= MAX_POSTERIOR_OVER_PRIOR =>
            {
                None
            }
            ParameterVerdict::NotSupported => {
                let finding = warn(Code::ParameterNotSupported, location);
                let finding = finding.value(parameter.posterior_over_prior, "");
                Some(finding.limit(MAX_POSTERIOR_OVER_PRIOR))
            }
            ParameterVerdict::AtBound => {
                let finding = warn(Code::ParameterAtBound, location);
                Some(finding.value(parameter.updated, &parameter.unit))
            }
        }
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

fn warn(code: Code, location: Location) -> Finding {
    Finding::new(Severity::Warning, code, location)
}
