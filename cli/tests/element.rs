//! `element` as a user types it: what it prints, and what is told of tables that give no surface.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use common::Folder;

/// Points of a cylinder of radius 5 about the line through (1, 2, 3) along (0, 0.6, 0.8).
fn cylinder(surface: &str) -> String {
    let points: Vec<String> = (0..9)
        .map(|k| {
            let (turn, along) = (0.7 * f64::from(k), f64::from(k * k % 7));
            let (u, v) = (5.0 * turn.cos(), 5.0 * turn.sin());
            format!("{surface},{},{},{}\n", 1.0 + u, 2.0 + 0.8 * v + 0.6 * along, 3.0 - 0.6 * v + 0.8 * along)
        })
        .collect();
    points.concat()
}

#[test]
fn a_cylinder_is_found_without_a_guess() {
    let folder = Folder::new().with("p.csv", format!("surface,x,y,z\n{}", cylinder("pin")));
    let (status, result) = folder.json(&["element", "cylinder", "p.csv"], b"");
    assert_eq!((status, result["schema"].as_str()), (0, Some("touchref.element/1")));
    assert!((result["radius"].as_f64().unwrap() - 5.0).abs() < 1e-12, "{result}");
    let direction = result["direction"].as_array().unwrap();
    assert!((direction[2].as_f64().unwrap() - 0.8).abs() < 1e-12, "{result}");
    assert!(result.get("apex").is_none() && result["minima"].as_u64().unwrap() >= 1);
}

#[test]
fn a_surface_is_chosen_from_a_table_of_several() {
    let table = format!("surface,x,y,z\n{}{}", cylinder("pin"), "plate,0,0,0\nplate,1,0,0\nplate,0,1,0\n");
    let folder = Folder::new().with("p.csv", table);
    let (status, result) = folder.json(&["element", "plane", "p.csv", "--surface", "plate"], b"");
    assert_eq!((status, result["points"].as_u64()), (0, Some(3)));
    let (status, result) = folder.json(&["element", "plane", "p.csv"], b"");
    assert_eq!((status, result["error"]["key"].as_str()), (2, Some("surface")));
    let (status, result) = folder.json(&["element", "plane", "p.csv", "--surface", "plat"], b"");
    assert_eq!((status, result["error"]["nearest"].as_str()), (2, Some("plate")));
}

/// Sound points that leave the surface free, too few of them, and wrong ones.
#[test]
fn what_gives_no_surface_is_told() {
    let line = (0..8).map(|k| format!("{k},{},{}\n", 2 * k, 3 * k)).collect::<Vec<_>>().concat();
    let cases = [
        ("plane", format!("x,y,z\n{line}"), 1, "degenerate"),
        ("sphere", format!("x,y,z\n{line}"), 1, "degenerate"),
        ("cone", "x,y,z\n1,2,3\n".to_owned(), 2, "too-few-touches"),
        ("plane", "x,y,z\n1,2,inf\n".to_owned(), 2, "invalid-input"),
        ("plane", "x,y\n1,2\n".to_owned(), 2, "missing-column"),
        ("plane", String::new(), 2, "invalid-input"),
    ];
    for (kind, table, expected, code) in cases {
        let folder = Folder::new().with("p.csv", table);
        let (status, result) = folder.json(&["element", kind, "p.csv"], b"");
        assert_eq!((status, result["error"]["code"].as_str()), (expected, Some(code)), "{kind}: {result}");
    }
}
