//! SplitMix draws numbers without a pattern, the same in every run.

/// Numbers without a pattern, the same in every run.
///
/// # Reference
/// Steele, Lea and Flood (2014), Fast splittable pseudorandom number generators, OOPSLA, figure 17.
pub(super) struct SplitMix(pub(super) u64);

impl SplitMix {
    /// The next number from -1 to 1.
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
