//! Points by name alone.

use super::universal_file::{OneFile, Point, accelerances, file_of, finds_the_mode};

#[test]
fn names_without_node_and_direction_are_scalar_points() {
    for (response, reference, expected) in [
        ("acc", "hammer", "acc2:+S"),
        ("a ", "1", "a_2:+S"),
        ("Ch-", "F 1", "Ch-2:+S"),
    ] {
        let mut functions = accelerances();
        for (function, number) in functions.iter_mut().zip(1..) {
            function.response = Point {
                name: format!("{response}{number}"),
                ..Point::new(0, 0)
            };
            function.reference = Point {
                name: reference.to_owned(),
                ..Point::new(0, 0)
            };
        }
        let file = OneFile::new("n.uff", file_of(&functions));
        let shape = finds_the_mode(&file.path(), &[]).json()["modes"][0]["shape"].clone();
        let points: Vec<&String> = shape.as_object().unwrap().keys().collect();
        assert!(points.iter().any(|point| *point == expected), "{points:?}");
    }
}
