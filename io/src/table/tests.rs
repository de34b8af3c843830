use super::*;

fn read(text: impl AsRef<[u8]>) -> Result<(Vec<TouchRecord>, Vec<Warning>), InputError> {
    let reader = Box::new(std::io::Cursor::new(text.as_ref().to_vec()));
    let mut table = TableReader::new(reader, "t.csv", &["cylinder", "plane"])?;
    let rows = (&mut table).collect::<Result<Vec<_>, _>>()?;
    Ok((rows, table.warnings().to_vec()))
}

#[test]
fn every_accepted_form_gives_the_same_touch() {
    let table = [
        "surface,x,y,z\nplane,1.5,-2,3e0\n",
        "\u{feff}# from the robot\r\n\r\nsurface,x,y,z\r\n# first\r\nplane,1.5,-2,3\r\n",
        "surface;x;y;z\nplane;1,5;-2;3,0",
        "z\ty\tx\tsurface\n3\t-2\t1.5\tplane",
        "  surface , x,y ,z\n\"plane\", 1.5 , -2,\"3\"",
    ];
    for text in table {
        let (rows, warnings) = read(text).unwrap();
        assert_eq!(rows.len(), 1, "{text}");
        assert_eq!((rows[0].surface.as_str(), rows[0].at), ("plane", Point3::new(1.5, -2.0, 3.0)), "{text}");
        assert!(warnings.is_empty());
    }
}

#[test]
fn optional_columns_may_be_empty() {
    let (rows, _) =
        read("surface,x,y,z,id,sigma,i,j,k,placement\nplane,1,2,3,a,0.5,0,0,-2,p1\nplane,1,2,3,,,,,,")
            .unwrap();
    assert_eq!((rows[0].noise, rows[0].id.as_deref()), (Noise::Sigma(0.5), Some("a")));
    assert_eq!(rows[0].approach.unwrap().into_inner(), -Vector3::z());
    assert_eq!(rows[0].placement.as_deref(), Some("p1"));
    let nothing = (rows[1].noise, rows[1].approach, rows[1].id.as_deref(), rows[1].line);
    assert_eq!(nothing, (Noise::OfProbe, None, None, Some(3)));
}

#[test]
fn columns_of_others_are_told_not_used() {
    let (_, warnings) = read("surface,x,y,z,qif_feature\nplane,1,2,3,CYL_1").unwrap();
    assert!(warnings[0].message.contains("`qif_feature`"), "{warnings:?}");
}

/// Text, code, line, column (0: the whole line), key, nearest.
type Refused = (&'static [u8], &'static str, usize, usize, &'static str, &'static str);

#[test]
fn errors_name_line_and_column() {
    let table: &[Refused] = &[
        (b"surface,x,y\n", "missing-column", 1, 0, "z", ""),
        (b"surface,x,y,z,x\n", "invalid-input", 1, 15, "x", ""),
        (b"surfce,x,y,z\n", "unknown-column", 1, 1, "surfce", "surface"),
        (b"surface,X,y,z\n", "unknown-column", 1, 9, "X", "x"),
        (b"surface,x_mm,y,z\n", "unknown-column", 1, 9, "x_mm", "x"),
        (b"surface,x,y,z,i,j\n", "missing-column", 1, 0, "k", ""),
        (b"surface,x,y,z,\n", "invalid-input", 1, 15, "", ""),
        (b"surface,x,y,z\nplane,1,2\n", "invalid-input", 2, 0, "", ""),
        (b"surface,x,y,z\nplane,1,2,3,4\n", "invalid-input", 2, 0, "", ""),
        (b"surface,x,y,z\n#\nplane,1, abc,3\n", "invalid-input", 3, 10, "y", ""),
        (b"surface,x,y,z\nplane,1,NaN,3\n", "invalid-input", 2, 9, "y", ""),
        (b"surface,x,y,z\nplane,1,2,inf\n", "invalid-input", 2, 11, "z", ""),
        (b"surface,x,y,z\nplane,1,,3\n", "invalid-input", 2, 9, "y", ""),
        (b"surface,x,y,z\nplain,1,2,3\n", "unknown-surface", 2, 1, "surface", "plane"),
        (b"surface,x,y,z,sigma\nplane,1,2,3,0\n", "invalid-input", 2, 13, "sigma", ""),
        (b"surface,x,y,z,i,j,k\nplane,1,2,3,0,0,0\n", "invalid-input", 2, 0, "i", ""),
        (b"surface,x,y,z,i,j,k\nplane,1,2,3,0,,1\n", "invalid-input", 2, 0, "i", ""),
        (b"surface,x,y,z\nplane,\"1,2,3\n", "invalid-input", 2, 7, "", ""),
        (b"surface,x,y,z\npl\xffne,1,2,3\n", "invalid-input", 2, 3, "", ""),
        (b"surface;x;y;z\nplane;1,2,3;2;3\n", "invalid-input", 2, 7, "x", ""),
    ];
    for (text, code, line, column, key, nearest) in table {
        let error = read(text).unwrap_err();
        let shown = String::from_utf8_lossy(text);
        let place = error.place().unwrap();
        assert_eq!(error.code(), *code, "{shown}");
        assert_eq!((place.line, place.column.unwrap_or(0)), (*line, *column), "{shown}");
        assert_eq!((error.key().unwrap_or(""), error.nearest().unwrap_or("")), (*key, *nearest), "{shown}");
    }
}

#[test]
fn nothing_and_endless_lines_are_refused() {
    assert!(read("").unwrap_err().to_string().contains("empty"));
    assert!(read("\n# only a comment\n").unwrap_err().to_string().contains("empty"));
    let endless = read("x".repeat(1 << 20)).unwrap_err();
    assert_eq!(endless.place().unwrap().line, 1);
    let wide = read(format!("surface,x,y,z{}", ",surface".repeat(5000))).unwrap_err();
    assert!(wide.to_string().contains("twice"));
}

#[test]
fn a_place_counts_the_bytes_of_the_input() {
    let text = "\u{feff}surface,x,y,z\nplane,1,b\u{e4}d,3\n";
    let error = read(text).unwrap_err();
    let place = error.place().unwrap();
    assert_eq!(&text[place.offset..place.offset + place.length], "b\u{e4}d");
}
