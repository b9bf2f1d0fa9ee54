//! From the order in which MATLAB stores elements to rows.

use crate::io::formats::arrays::store::Elements;

/// Elements that are stored with the lengths `stored` in reverse order (column by column), row by
/// row.
pub(super) fn row_major(elements: Elements, stored: &[usize]) -> Elements {
    if stored.iter().filter(|&&length| length != 1).count() <= 1 {
        return elements;
    }
    match elements {
        Elements::F32(values) => Elements::F32(turned(&values, stored)),
        Elements::F64(values) => Elements::F64(turned(&values, stored)),
        Elements::Complex(values) => Elements::Complex(turned(&values, stored)),
        Elements::Text(values) => Elements::Text(turned(&values, stored)),
    }
}

/// The array with its lengths in reverse order.
fn turned<T: Clone>(values: &[T], stored: &[usize]) -> Vec<T> {
    // Steps in the stored order of the presented lengths, which are the stored ones from the last
    // to the first.
    let steps: Vec<usize> = stored
        .iter()
        .scan(values.len(), |step, &length| {
            *step = step.checked_div(length).unwrap_or(0);
            Some(*step)
        })
        .collect();
    let mut counter = vec![0; stored.len()];
    let mut at = 0;
    let mut out = Vec::with_capacity(values.len());
    for _ in 0..values.len() {
        out.push(values[at].clone());
        // The last presented length, the first stored one, runs fastest.
        for (place, (&length, &step)) in stored.iter().zip(&steps).enumerate() {
            counter[place] += 1;
            at += step;
            if counter[place] < length {
                break;
            }
            at -= step * length;
            counter[place] = 0;
        }
    }
    out
}

/// A text for each row of codes of UTF-16; `None` when they are not codes.
pub(super) fn texts_of_rows(codes: &Elements, stored: &[usize]) -> Option<Elements> {
    let Elements::F64(codes) = codes else {
        return None;
    };
    // Without characters there are no rows of them, however many the lengths state.
    if codes.is_empty() {
        return Some(Elements::Text(vec![String::new()]));
    }
    let rows = stored.last().copied().unwrap_or(1);
    let columns = codes.len().checked_div(rows).unwrap_or(0);
    let texts = (0..rows).map(|row| {
        let units = (0..columns).map(|column| codes[column * rows + row]);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a code of 16 bits, saturated otherwise"
        )]
        let units: Vec<u16> = units.map(|code| code as u16).collect();
        String::from_utf16_lossy(&units)
    });
    Some(Elements::Text(texts.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_become_rows() {
        // MATLAB's a(i,j,k) = 100 i + 10 j + k of size 2 x 3 x 2, first index fastest.
        let mut stored = Vec::new();
        for k in 1..=2_u8 {
            for j in 1..=3_u8 {
                stored.extend((1..=2_u8).map(|i| f64::from(100 * i + 10 * j + k)));
            }
        }
        let Elements::F64(rows) = row_major(Elements::F64(stored), &[2, 3, 2]) else {
            panic!("doubles stay doubles");
        };
        let expected = [
            111., 112., 121., 122., 131., 132., 211., 212., 221., 222., 231., 232.,
        ];
        assert_eq!(rows.map_bits(), expected.to_vec().map_bits());
    }

    trait Bits {
        fn map_bits(self) -> Vec<u64>;
    }

    impl Bits for Vec<f64> {
        fn map_bits(self) -> Vec<u64> {
            self.into_iter().map(f64::to_bits).collect()
        }
    }

    #[test]
    fn no_codes_are_one_empty_text() {
        let texts = texts_of_rows(&Elements::F64(Vec::new()), &[0, 1 << 50]);
        assert_eq!(texts, Some(Elements::Text(vec![String::new()])));
    }

    #[test]
    fn rows_of_codes_become_texts() {
        let codes = [b'a', b'c', b'b', b'd'].map(f64::from).to_vec();
        let texts = texts_of_rows(&Elements::F64(codes), &[2, 2]);
        assert_eq!(
            texts,
            Some(Elements::Text(vec!["ab".to_owned(), "cd".to_owned()]))
        );
    }
}
