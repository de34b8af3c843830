//! `report`: what the page says of a result, and of what is none.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]
#![allow(clippy::print_stdout, reason = "a test tells its figures")]

mod common;

use std::fs;

use common::{Folder, example, paper};
use scraper::{Html, Selector};
use serde_json::Value;

/// Bytes of the largest page.
const LARGEST: usize = 1_500_000;

/// A result and its page.
struct Reported {
    folder: Folder,
    result: Value,
    page: Html,
    text: String,
}

impl Reported {
    /// Of a measurement, located with these arguments.
    fn new(measurement: &str, locate: &[&str], report: &[&str]) -> Self {
        let folder = Folder::new().with("m.toml", measurement);
        let (status, result) = folder.json(&[&["locate", "m.toml"], locate].concat(), b"");
        assert_eq!(status, 0, "{result}");
        Self::of(folder, result, report)
    }

    /// Of a result.
    fn of(folder: Folder, result: Value, report: &[&str]) -> Self {
        let page = folder.run(&[&["report", "-"], report].concat(), result.to_string().as_bytes());
        assert_eq!(page.status.code(), Some(0), "{}", String::from_utf8_lossy(&page.stderr));
        let text = String::from_utf8(page.stdout).unwrap();
        assert!(text.len() < LARGEST, "{} bytes", text.len());
        let page = Html::parse_document(&text);
        assert!(page.errors.is_empty(), "{:?}", page.errors);
        Self { folder, result, page, text }
    }

    /// The text of every element that a selector finds.
    fn texts(&self, selector: &str) -> Vec<String> {
        let selector = Selector::parse(selector).unwrap();
        self.page.select(&selector).map(|element| element.text().collect()).collect()
    }

    /// The text of the one element that a selector finds.
    fn text_of(&self, selector: &str) -> String {
        let texts = self.texts(selector);
        assert_eq!(texts.len(), 1, "{selector}: {texts:?}");
        texts[0].clone()
    }

    /// The answer to a question of the verdict.
    fn answer(&self, question: &str) -> String {
        let questions = self.texts("#verdict dt");
        let index = questions.iter().position(|known| known == question);
        self.texts("#verdict dd").swap_remove(index.unwrap_or_else(|| panic!("{question}: {questions:?}")))
    }
}

/// What the command says of a file that it cannot report.
fn refused(content: &[u8]) -> (Option<i32>, String) {
    let folder = Folder::new().with("r.json", content);
    let output = folder.run(&["report", "r.json", "-o", "page.html"], b"");
    assert!(output.stdout.is_empty() && !folder.0.path().join("page.html").exists());
    // Lines are broken where they are full.
    let text = String::from_utf8(output.stderr).unwrap();
    (output.status.code(), text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// The paper's result, edited.
fn edited(edit: impl FnOnce(&mut Value)) -> Value {
    let (_, mut result) = Folder::new().with("m.toml", paper()).json(&["locate", "m.toml"], b"");
    edit(&mut result);
    result
}

#[test]
fn every_fixture_has_every_section() {
    let registry = touchref::registry().unwrap();
    for name in ["nederbragt-ravani", "three-sphere", "cube", "v-block", "bore-and-faces", "tooling-balls"] {
        let report = Reported::new(&example(&format!("{name}.toml")), &[], &[]);
        let section = Selector::parse("section").unwrap();
        let sections: Vec<_> =
            report.page.select(&section).map(|section| section.attr("id").unwrap()).collect();
        let expected = [
            "verdict",
            "frame",
            "picture",
            "residuals",
            "influence",
            "budget",
            "roots",
            "dialects",
            "record",
        ];
        assert_eq!(sections, expected, "{name}");
        // Not a dialect less than there are, and what is not told has a reason.
        let told = report.texts(".dialect h3 code");
        let known: Vec<_> = registry.dialects().iter().map(|dialect| dialect.name.to_owned()).collect();
        assert_eq!(told, known, "{name}");
        for dialect in report.page.select(&Selector::parse(".dialect").unwrap()) {
            let any = |selector| dialect.select(&Selector::parse(selector).unwrap()).next().is_some();
            assert!(any("pre") || any(".missing"), "{name}: {}", dialect.html());
        }
        // Every surface is drawn, every touch is marked and has its rows.
        let touches = report.result["touches"].as_array().unwrap();
        assert_eq!(report.texts("svg.scene .touch title").len(), touches.len(), "{name}");
        assert_eq!(report.texts("#residuals tbody tr").len(), touches.len(), "{name}");
        assert!(report.texts("svg.scene .surfaces path").len() > 30, "{name}");
        assert!(!report.text.contains("NaN") && !report.text.contains("inf "), "{name}");
        println!("{name}: {} bytes", report.text.len());
    }
}

#[test]
fn the_page_needs_nothing_and_may_fetch_nothing() {
    let report = Reported::new(&paper(), &[], &[]);
    let policy = Selector::parse("meta[http-equiv='Content-Security-Policy']").unwrap();
    let policy = report.page.select(&policy).next().unwrap().attr("content").unwrap();
    assert!(
        policy.starts_with("default-src 'none'; style-src 'sha256-") && !policy.contains("unsafe"),
        "{policy}"
    );
    let ids = Selector::parse("[id]").unwrap();
    let mut ids: Vec<_> = report.page.select(&ids).map(|element| element.attr("id").unwrap()).collect();
    ids.sort_unstable();
    assert!(ids.windows(2).all(|pair| pair[0] != pair[1]), "{ids:?}");
    for element in report.page.select(&Selector::parse("*").unwrap()) {
        for (name, value) in element.value().attrs() {
            let fetches = matches!(name, "src" | "href" | "data" | "action" | "srcset" | "style")
                || name.starts_with("on");
            assert!(!fetches, "{name}={value}");
        }
    }
    assert!(!report.text.contains("url(") && !report.text.contains("@import"));
    assert!(report.page.select(&Selector::parse("html[lang=en]").unwrap()).next().is_some());
}

#[test]
fn the_verdict_says_what_the_result_does() {
    let report = Reported::new(&paper(), &[], &[]);
    assert_eq!(report.text_of(".headline"), "Frame found; it passed its checks.");
    assert!(report.answer("Where it is").contains("x 2.900029, y 3.800033, z 4.224893 mm"));
    assert!(
        report
            .answer("When it stands")
            .contains("lies between 0.0000114 and 0.0137 mm; stated is 0.00005 mm")
    );
    let trust = &report.result["trust"];
    let times = trust["up_to_sigma"].as_f64().unwrap() / trust["sigma"].as_f64().unwrap();
    assert!(report.answer("When it stands").contains(&format!("could be {times:.0} times larger")));
    assert!(report.answer("Do the touches agree").contains("p = 0.453"));
    assert!(report.answer("What else was possible").contains("4 frames"));
    assert!(report.answer("What else was possible").contains("does not fit the known geometry (3 of them)"));
    // What the README says of them.
    assert!(report.answer("What nothing checks").contains("touches 1, 4, 5, 6"));

    let without = paper().replace("sigma = 5e-5", "").replace("sigma = 0.00005", "");
    assert_ne!(without, paper());
    let report = Reported::new(&without, &[], &[]);
    assert_eq!(report.text_of(".headline"), "Frame found, on a condition.");
    assert!(report.answer("How sure that is").contains("as the residuals tell it, with 1 degree of freedom"));
    assert!(report.answer("When it stands").contains("none is stated"));
    assert!(report.answer("Do the touches agree").contains("only a stated sigma could tell"));

    // Six touches of six unknowns.
    let cube = example("cube.toml");
    let mut sections = cube.split("[[touch]]");
    let head = sections.next().unwrap().to_owned();
    let six: Vec<&str> = [0, 1, 2, 3, 4, 6].into_iter().map(|k| sections.clone().nth(k).unwrap()).collect();
    let six = [head.as_str()].into_iter().chain(six).collect::<Vec<_>>().join("[[touch]]");
    let six: String = six.split_inclusive('\n').filter(|line| !line.starts_with("sigma")).collect();
    let report = Reported::new(&six, &[], &[]);
    assert_eq!(report.text_of(".headline"), "Frame found; how sure it is cannot be told.");
    assert!(report.answer("Do the touches agree").contains("nothing checks them"));
    assert!(report.text_of("#budget .missing").contains("no uncertainty to tell"));
    assert!(report.text_of("#picture figcaption").contains("No uncertainty is drawn"));

    let report = Reported::new(&example("bore-and-faces.toml"), &[], &[]);
    assert!(report.answer("What is left free").contains("the turn about the fixture's Z axis"));
}

#[test]
fn a_touch_that_is_left_out_is_told_loudly() {
    let bad = example("cube.toml").replacen(
        "at = [426.5496, -151.5672, 87.7929]",
        "id = \"chip\"\nat = [426.5496, -151.5672, 88.7929]",
        1,
    );
    let report = Reported::new(&bad, &["--solver", "robust"], &[]);
    assert_eq!(report.text_of(".headline"), "Frame found without touch 0, which is held for bad.");
    assert!(report.answer("What is left out").starts_with("Touch 0 `chip` lies"));
    assert_eq!(report.texts("svg.scene .excluded").len(), 1);
    assert_eq!(report.texts("#residuals .hollow").len(), 1);
    // It is part of what was measured all the same, and nothing is told of what it does to the frame.
    assert_eq!(report.text_of("#raw pre").lines().count(), 10);
    assert!(!report.texts("#influence tbody th").iter().any(|name| name.starts_with("0 on")));
    assert_eq!(report.texts("#influence tbody tr").len(), 8);
}

/// The oracle is `sha256sum` and touchref's own reader of tables.
#[test]
fn the_touches_shown_are_those_measured() {
    let report = Reported::new(&example("three-sphere.toml"), &[], &[]);
    let raw = report.text_of("#raw pre");
    fs::write(report.folder.0.path().join("raw.csv"), &raw).unwrap();
    let sum =
        std::process::Command::new("sha256sum").arg(report.folder.0.path().join("raw.csv")).output().unwrap();
    let sum = String::from_utf8(sum.stdout).unwrap();
    assert_eq!(sum.split_whitespace().next().unwrap(), report.text_of("#hash"));

    let head = example("three-sphere.toml").split("[[touch]]").next().unwrap().to_owned();
    fs::write(report.folder.0.path().join("head.toml"), head).unwrap();
    let (status, again) = report.folder.json(&["locate", "head.toml", "--touches", "raw.csv"], b"");
    assert_eq!(status, 0, "{again}");
    assert_eq!(again["frame"], report.result["frame"]);
}

#[test]
fn points_of_use_have_their_budget() {
    let report = Reported::new(&example("three-sphere.toml"), &[], &["--at", "300,0,0", "--at=0,0,200"]);
    let arguments = ["uncertainty", "m.toml", "--samples", "none", "--at", "300,0,0", "--at=0,0,200"];
    let (_, told) = report.folder.json(&arguments, b"");
    let cells = report.texts("#budget .wide:last-child td");
    let points = told["points"].as_array().unwrap().iter().chain([&told["rotation"]]);
    let columns: Vec<Vec<f64>> = points
        .map(|point| {
            point["budget"].as_array().unwrap().iter().map(|b| 100.0 * b["share"].as_f64().unwrap()).collect()
        })
        .collect();
    let rows = cells.chunks(3).enumerate();
    for (source, row) in rows {
        for (column, cell) in row.iter().enumerate() {
            // A digit after the point; the parts are of their own sum.
            let off = cell.parse::<f64>().unwrap() - columns[column][source];
            assert!(off.abs() < 0.1, "source {source}, column {column}: {cell}, {}", columns[column][source]);
        }
    }
    // Noise on three balls, and three stated distances.
    assert_eq!(cells.len(), 6 * columns.len());
}

#[test]
fn words_of_others_stay_words() {
    const HOSTILE: &str =
        "</script><script>alert(1)</script><img src=x onerror=alert(1)>\"'&amp;\u{202e}<!--";
    let result = edited(|result| {
        result["touches"][0]["id"] = HOSTILE.into();
        result["roots"][1]["reason"] = HOSTILE.into();
        result["warnings"] = serde_json::json!([{ "code": HOSTILE, "message": HOSTILE }]);
        result["solver"] = HOSTILE.into();
        result["trust"]["limited_by"] = HOSTILE.into();
        result["observability"]["weakest"] = HOSTILE.into();
        result["free"] = serde_json::json!([HOSTILE]);
        result["iteration"]["stopped_by"] = HOSTILE.into();
        result["dialects"] = serde_json::json!({ HOSTILE: HOSTILE, format!("kuka:{HOSTILE}"): "" });
        result["covariance"]["order"][0] = HOSTILE.into();
    });
    let report =
        Reported::of(Folder::new(), result, &["--title", HOSTILE, "--note", HOSTILE, "--note", "second"]);
    let scripts = report.texts("script");
    assert_eq!(scripts.len(), 2);
    assert!(report.texts("img").is_empty());
    assert_eq!(report.text_of("h1"), HOSTILE);
    assert_eq!(report.text_of("head > title"), HOSTILE);
    assert_eq!(report.texts("#record .words"), [HOSTILE, "second"]);
    assert!(report.texts("#residuals bdi").contains(&HOSTILE.to_owned()));
    assert!(report.texts("#roots td").contains(&HOSTILE.to_owned()));
    let scene: Value = serde_json::from_str(&scripts[0]).unwrap();
    assert!(scene["touches"][0]["text"].as_str().unwrap().contains(HOSTILE));
}

#[test]
fn older_results_and_other_solvers_are_told_as_far_as_they_go() {
    let older = edited(|result| {
        for touch in result["touches"].as_array_mut().unwrap() {
            touch.as_object_mut().unwrap().remove("at");
        }
    });
    let report = Reported::of(Folder::new(), older, &[]);
    assert!(report.text_of("#picture p").contains("does not tell where the touches were"));
    assert!(report.text_of("#influence .missing").contains("does not tell where the touches were"));
    assert!(report.text_of("#budget .missing").contains("does not tell where the touches were"));
    assert!(report.texts("#record .missing")[0].contains("nothing to hash"));

    let report = Reported::new(&example("three-sphere.toml"), &["--solver", "closed-form"], &[]);
    assert_eq!(report.texts("#residuals tbody tr").len(), 9);
    assert!(!report.texts("#budget tbody tr").is_empty());
}

#[test]
fn what_is_no_result_is_refused() {
    let refusal = paper().replace("sigma = 5e-5", "sigma = 0.1").replace("sigma = 0.00005", "sigma = 0.1");
    let refusal = Folder::new().with("m.toml", refusal).run(&["locate", "m.toml", "--format", "json"], b"");
    assert_eq!(refusal.status.code(), Some(1));
    let (status, told) = refused(&refusal.stdout);
    assert_eq!(status, Some(2));
    assert!(
        told.contains("it is a refusal") && told.contains("a refused measurement has no frame"),
        "{told}"
    );

    let result = |edit: &dyn Fn(&mut Value)| edited(edit).to_string().into_bytes();
    let cases: Vec<(Vec<u8>, &str)> = vec![
        (Vec::new(), "EOF"),
        (paper().into_bytes(), "is no result of `locate`"),
        (b"\x00\xff\xfe garbage".to_vec(), "UTF-8"),
        (b"[1, 2]".to_vec(), "is no result of `locate`"),
        (b"{\"schema\": \"touchref.solution/2\"}".to_vec(), "touchref.solution/2"),
        (b"{\"schema\": \"touchref.solution/1\"}".to_vec(), "missing field"),
        (result(&|r| r["units"] = "feet".into()), "`feet` is not known"),
        (result(&|r| r["fixture"]["kind"] = "sphere".into()), "sphere"),
        (result(&|r| r["fixture"]["parameters"]["radius"] = (-1).into()), "radius"),
        (result(&|r| r["touches"][2]["surface"] = "plan".into()), "plan"),
        (result(&|r| r["touches"][2]["index"] = 5.into()), "out of order"),
        (result(&|r| r["touches"][2]["at"][0] = 1e300.into()), "farther away"),
        (result(&|r| r["touches"][2]["residual"] = 0.5.into()), "contradicts itself"),
        (result(&|r| r["frame"]["origin"][0] = 2.95.into()), "contradicts itself"),
        (result(&|r| r["frame"]["quaternion_xyzw"][0] = 0.5.into()), "contradicts itself"),
        (result(&|r| r["covariance"]["matrix"][0][0] = (-1).into()), "covariance"),
        (result(&|r| r["covariance"]["matrix"][0][1] = 1.into()), "covariance"),
        (result(&|r| r["fixture"]["parameters"]["radius"] = 1e14.into()), "farther than any probe"),
        (result(&|r| r["probe"]["sigma"] = (-1).into()), "sigma"),
    ];
    for (content, expected) in cases {
        let (status, told) = refused(&content);
        assert_eq!(status, Some(2), "{told}");
        assert!(told.contains(expected), "{expected}: {told}");
    }
    let missing = Folder::new().run(&["report", "no-such-file.json"], b"");
    assert_eq!(missing.status.code(), Some(2));
}
