//! A function of another quantity leaves the others usable.

use super::universal_file::{
    AxisLabel, Function, OneFile, Point, accelerances, file_of, finds_the_mode,
};

/// The accelerances and a function that differs from the second one.
fn with(change: impl Fn(&mut Function)) -> OneFile {
    let mut functions = accelerances();
    let mut other = functions[1].clone();
    other.response = Point {
        name: "Extra".to_owned(),
        ..Point::new(9, 0)
    };
    change(&mut other);
    functions.push(other);
    OneFile::new("other.uff", file_of(&functions))
}

#[test]
fn a_function_of_another_quantity_is_left_out() {
    let ordinate = |data_type, unit: &'static str| AxisLabel::new(data_type, "Other", unit);
    for (ordinate, denominator) in [
        (ordinate(15, "Pa"), ordinate(13, "N")),
        (ordinate(15, "NONE"), ordinate(13, "N")),
        (ordinate(3, "µm/m"), ordinate(13, "N")),
        (ordinate(0, "mV"), ordinate(13, "N")),
        (ordinate(13, "N"), ordinate(13, "N")),
        (ordinate(12, "rad/s²"), ordinate(13, "N")),
        (ordinate(12, "m/s2"), ordinate(0, "V")),
        (ordinate(12, "m/s2"), ordinate(12, "m/s2")),
    ] {
        let file = with(|other| {
            (other.ordinate, other.denominator) = (ordinate.clone(), denominator.clone());
        });
        let ran = finds_the_mode(&file.path(), &[]);
        let units = format!("{ordinate:?} {denominator:?}");
        assert!(ran.findings().contains("function-left-out"), "{units}");
        let shape = &ran.json()["modes"][0]["shape"];
        assert_eq!(shape.as_object().unwrap().len(), 3, "{units}");
    }
}

#[test]
fn rotations_and_moments_of_a_virtual_point_are_left_out() {
    let file = with(|other| {
        (other.response.name, other.response.direction) = ("VP1".to_owned(), 5);
        other.ordinate.unit = "rad/s^2".to_owned();
    });
    let mut functions = accelerances();
    let mut moment = functions[1].clone();
    moment.reference = Point::new(4, 4);
    moment.denominator = AxisLabel::new(13, "Moment", "Nm");
    functions.push(moment);
    let by_moment = OneFile::new("moment.uff", file_of(&functions));
    for file in [file, by_moment] {
        assert!(
            finds_the_mode(&file.path(), &[])
                .findings()
                .contains("function-left-out")
        );
    }
}

#[test]
fn time_records_without_a_force_are_left_out_beside_frfs() {
    let response = Function::record(1, false, vec![0.5; 200]);
    let two = [
        response.clone(),
        Function::record(2, false, vec![0.25; 200]),
    ];
    let force = Function::record(1, true, vec![1.0; 200]);
    for records in [&two[..1], &two[..], &[force][..]] {
        let mut functions = accelerances();
        functions.extend(records.iter().cloned());
        let file = OneFile::new("mixed.uff", file_of(&functions));
        let ran = finds_the_mode(&file.path(), &[]);
        assert!(ran.findings().contains("records-passed-over"), "{ran:?}");
        // Before them as well.
        functions.rotate_right(records.len());
        finds_the_mode(&OneFile::new("mixed.uff", file_of(&functions)).path(), &[]);
    }
}
