//! Dataset 2467, groups, and its forerunners and kin 2417, 2429, 2430, 2432, 2435, 2452 and 2477.
//!
//! | line | columns | fields |
//! |---|---|---|
//! | 1 | 8 I10 | number, six active sets (not used), number of members (the last field; 2417 may have one set less) |
//! | 2 | A40 | name |
//! | 3.. | 8 I10 | 2435, 2452, 2467, 2477: entity type, label, two numbers that are not used, twice on a line |
//! | 3.. | 8 I10 | 2417, 2429, 2430, 2432: entity type, label, four times on a line |

use std::io::{self, Write};

use super::dataset_2412::integer_rows;
use super::dataset_2420::name_line;
use crate::geometry::Group;
use crate::io::formats::uff::fields::records::Records;
use crate::io::formats::uff::fields::{FieldError, Line, text_or_none};

/// Numbers of the datasets of groups.
pub(in crate::io::formats::uff) const NUMBERS: [u32; 8] =
    [2417, 2429, 2430, 2432, 2435, 2452, 2467, 2477];

/// Reads the groups of dataset `number`; `first` is the dataset's first line, for messages.
pub(in crate::io::formats::uff) fn groups(
    number: u32,
    lines: &[Line],
    first: &Line,
) -> Result<Vec<Group>, FieldError> {
    let fields = match number {
        2435 | 2452 | 2467 | 2477 => 4,
        _ => 2,
    };
    let mut records = Records::new(lines, first);
    let mut groups = Vec::new();
    while records.peek().is_some() {
        groups.push(group(&mut records, fields)?);
    }
    Ok(groups)
}

/// One group; a member has `fields` numbers.
fn group(records: &mut Records<'_>, fields: usize) -> Result<Group, FieldError> {
    let (head, row) = records.integer_row("group")?;
    let refuse = || FieldError::line(head, "group", "number, active sets, number of members");
    let count = match row[..] {
        [_, .., count] if (7..=8).contains(&row.len()) => usize::try_from(count).ok(),
        _ => None,
    };
    let numbers = count.and_then(|count| count.checked_mul(fields));
    let numbers = numbers.ok_or_else(refuse)?;
    let name = text_or_none(&records.line("name of a group")?.bytes);
    let members = records.integers(numbers, "members of a group")?;
    Ok(Group {
        label: row[0],
        name,
        members: members
            .chunks_exact(fields)
            .map(|member| (member[0], member[1]))
            .collect(),
    })
}

/// Writes the groups as dataset 2467.
pub(in crate::io::formats::uff) fn write(out: &mut dyn Write, groups: &[&Group]) -> io::Result<()> {
    let mut text = String::from("    -1\n  2467\n");
    for group in groups {
        let count = group.members.len() as i64;
        text.push_str(&integer_rows(&[group.label, 0, 0, 0, 0, 0, 0, count]));
        text.push_str(&name_line(&group.name));
        let members = group.members.iter();
        let numbers: Vec<i64> = members
            .flat_map(|member| [member.0, member.1, 0, 0])
            .collect();
        text.push_str(&integer_rows(&numbers));
    }
    text.push_str("    -1\n");
    out.write_all(text.as_bytes())
}
