//! Peaks of a power over frequency that are clear: above the noise, with half-power points on both
//! sides.

/// A clear peak, in lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Peak {
    /// Its highest line.
    pub line: usize,
    /// Half-power point below, interpolated between lines.
    pub lower: f64,
    /// Half-power point above.
    pub upper: f64,
}

impl Peak {
    /// Lines between the half-power points.
    pub fn width(&self) -> f64 {
        self.upper - self.lower
    }

    /// The lines between the half-power points.
    pub fn inside(&self) -> std::ops::Range<usize> {
        self.lower.ceil() as usize..self.upper.floor() as usize + 1
    }
}

/// Lines at least `floor` high that are the highest between the points on both sides where the
/// power falls to half, and those points at least `min_width` lines apart.
pub(super) fn clear_peaks(power: &[f64], floor: &[f64], min_width: f64) -> Vec<Peak> {
    let peak = |k: usize| {
        let lower = half_power_point(power, k, (0..k).rev())?;
        let upper = half_power_point(power, k, k + 1..power.len())?;
        let line = k;
        Some(Peak { line, lower, upper }).filter(|peak| peak.width() >= min_width)
    };
    let lines = 1..power.len().saturating_sub(1);
    let high = lines.filter(|k| power[*k] > power[k - 1] && power[*k] >= power[k + 1]);
    high.filter(|k| power[*k] > 0.0 && power[*k] >= floor[*k])
        .filter_map(peak)
        .collect()
}

/// Where the power falls to half of that of line `top`; `None` when it first rises above it or the
/// lines end.
fn half_power_point(power: &[f64], top: usize, lines: impl Iterator<Item = usize>) -> Option<f64> {
    let half = 0.5 * power[top];
    let mut inside = top;
    for k in lines.take_while(|k| power[*k] <= power[top]) {
        if power[k] <= half {
            let share = (power[inside] - half) / (power[inside] - power[k]);
            return Some(inside as f64 + share * (k as f64 - inside as f64));
        }
        inside = k;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lorentzian_has_its_half_power_points() {
        // 1/(1 + x²) with x = (k - 40.3)/8: half power at 40.3 ± 8.
        let power: Vec<f64> = (0..100)
            .map(|k| 1.0 / (1.0 + ((f64::from(k) - 40.3) / 8.0).powi(2)))
            .collect();
        let peaks = clear_peaks(&power, &[0.5; 100], 5.0);
        assert_eq!(peaks.len(), 1);
        assert_eq!(peaks[0].line, 40);
        assert!((peaks[0].lower - 32.3).abs() < 0.05 && (peaks[0].upper - 48.3).abs() < 0.05);
        assert_eq!(peaks[0].inside(), 33..49);
        assert!(clear_peaks(&power, &[1.1; 100], 5.0).is_empty());
        assert!(clear_peaks(&power, &[0.5; 100], 17.0).is_empty());
    }

    #[test]
    fn a_bump_on_a_flank_or_a_peak_at_the_edge_is_no_peak() {
        let power = [9.0, 1.0, 2.0, 4.0, 6.0, 7.0, 6.9, 7.5, 10.0, 8.0, 4.0, 1.0];
        let peaks = clear_peaks(&power, &[0.1; 12], 2.0);
        assert_eq!(peaks.len(), 1);
        assert_eq!(peaks[0].line, 8);
    }
}
