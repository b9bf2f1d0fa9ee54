//! Random numbers of a cell of a study, from its coordinates alone.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The generator of a cell: a stream of the seed for every list of coordinates, whatever was drawn
/// before.
pub fn cell_random(seed: u64, coordinates: &[u64]) -> ChaCha8Rng {
    let stream = coordinates
        .iter()
        .fold(coordinates.len() as u64, |state, coordinate| {
            mixed(state ^ mixed(*coordinate))
        });
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(stream);
    random
}

/// A bijection of 64 bits without visible pattern (Steele, Lea and Flood 2014, Fast splittable
/// pseudorandom number generators, SplitMix64).
fn mixed(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngCore;

    #[test]
    fn random_streams_of_cells_differ() {
        let first = |coordinates: &[u64]| cell_random(7, coordinates).next_u64();
        assert_eq!(first(&[1, 2]), first(&[1, 2]));
        let cells = [&[1, 2][..], &[2, 1], &[1, 3], &[1], &[1, 2, 0], &[]];
        let drawn: std::collections::BTreeSet<u64> = cells.map(first).into();
        assert_eq!(drawn.len(), cells.len());
    }
}
