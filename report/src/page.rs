//! The page: from the verdict to the record.

use data_encoding::BASE64;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use nalgebra::Point3;
use sha2::{Digest, Sha256};
use touchref_core::Registry;
use touchref_io::{
    InputError, SolutionRecord,
    number::short,
    words::{fixture, probe, touches},
};

use crate::{
    scene::Scene,
    subject::{PROBABILITY, Subject},
    svg,
    verdict::Verdict,
    view,
};

mod frame;
mod measured;
mod parts;
mod record;
mod sureness;

use parts::section;

const STYLE: &str = include_str!("../assets/report.css");
const SCRIPT: &str = include_str!("../assets/report.js");

/// What a page says besides what the result does.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// The title; one that names the fixture where there is none.
    pub title: Option<String>,
    /// The user's own words, for the record.
    pub notes: Vec<String>,
    /// Points of use, in fixture coordinates; the fixture's origin where there are none.
    pub points: Vec<Point3<f64>>,
}

/// The page about a result: a whole HTML document.
///
/// # Errors
/// `unknown-fixture`, or `invalid-input` for a result that contradicts itself.
pub fn page(record: &SolutionRecord, registry: &Registry, options: &Options) -> Result<String, InputError> {
    let subject = Subject::new(record, registry)?;
    let points = if options.points.is_empty() { vec![Point3::origin()] } else { options.points.clone() };
    let title = options.title.clone().unwrap_or_else(|| format!("Frame of {}", record.fixture.kind));
    let influences = subject.influences();
    let scene = Scene::of(&subject);
    let body = html! {
        header {
            h1 { (title) }
            p.subtitle {
                (touches(&record.touches)) ", solver " (record.solver) ". Fixture "
                (fixture(&record.fixture, "\u{b1}")) ". Probe: " (probe(&record.probe, "\u{b1}", &record.units)) "."
            }
            div.tools hidden[true] { button #scheme type="button" { "Light or dark" } }
        }
        main {
            (verdict(&subject, &Verdict::of(&subject, &influences)))
            (frame::frame(&subject))
            (picture(&subject, scene.as_ref()))
            (measured::residuals(&subject))
            (measured::influence(&subject, &influences, &points))
            (sureness::budget(&subject, &points))
            (frame::roots(&subject))
            (frame::dialects(&subject, registry))
            (record::record(&subject, &options.notes))
        }
        footer { p { "touchref " (env!("CARGO_PKG_VERSION")) ". This page is one file and uses no network." } }
    };
    Ok(document(&title, &body, scene.as_ref()).into_string())
}

fn document(title: &str, body: &Markup, scene: Option<&Scene>) -> Markup {
    let policy = format!(
        "default-src 'none'; style-src '{}'; script-src '{}'; base-uri 'none'; form-action 'none'",
        hash(STYLE),
        hash(SCRIPT)
    );
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(policy);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                (body)
                @if let Some(scene) = scene {
                    script #scene type="application/json" { (PreEscaped(harmless(&view::json(scene).to_string()))) }
                }
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
}

/// The source that a content security policy has for an inline style or script.
fn hash(text: &str) -> String {
    format!("sha256-{}", BASE64.encode(&Sha256::digest(text)))
}

/// JSON that ends no script and opens no comment: only strings have such signs in them.
fn harmless(json: &str) -> String {
    json.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026")
}

fn verdict(subject: &Subject<'_>, verdict: &Verdict) -> Markup {
    let body = html! {
        p class=(if verdict.sound { "headline sound" } else { "headline caution" }) { (verdict.headline) }
        dl.answers {
            @for (question, answer) in &verdict.answers {
                div { dt { (question) } dd { (answer) } }
            }
        }
        @if !subject.record.warnings.is_empty() {
            h3 { "Warnings" }
            ul.warnings {
                @for warning in &subject.record.warnings { li { (warning.message) " " code { (warning.code) } } }
            }
        }
    };
    section("verdict", "Verdict", &body)
}

fn picture(subject: &Subject<'_>, scene: Option<&Scene>) -> Markup {
    const HELP: &str = "Drag to turn, arrow keys too; plus and minus zoom, the wheel while the view has the focus; right and \
                        left bracket (or n and p) step through the touches; 0 or Home is the first view.";
    let Some(scene) = scene else {
        return section(
            "picture",
            "Picture",
            &html! {
                p { "There is no picture: the result, an older one, does not tell where the touches were." }
            },
        );
    };
    let layers = [
        ("surfaces", "surfaces", true),
        ("normals", "normals and tips", true),
        ("residuals", "residuals", true),
        ("ellipsoids", "uncertainty", !scene.ellipsoids.is_empty()),
        ("ghosts", "rejected frames", !scene.ghosts.is_empty()),
        ("numbers", "numbers", true),
    ];
    let body = html! {
        figure {
            div.view hidden[true] {
                canvas #view tabindex="0" role="application" aria-roledescription="view in three dimensions"
                    aria-label={ "Fixture, touches and frame. " (HELP) } aria-describedby="caption" {}
                div.tools {
                    button type="button" data-do="in" aria-label="zoom in" { "+" }
                    button type="button" data-do="out" aria-label="zoom out" { "\u{2212}" }
                    button type="button" data-do="reset" { "first view" }
                    button type="button" data-do="x" { "along x" }
                    button type="button" data-do="y" { "along y" }
                    button type="button" data-do="z" { "along z" }
                    button type="button" data-do="previous" aria-label="previous touch" { "\u{2039}" }
                    button type="button" data-do="next" aria-label="next touch" { "\u{203a}" }
                }
                div.tools {
                    @for (name, text, there) in layers {
                        @if there { label { input type="checkbox" data-layer=(name) checked; " " (text) } }
                    }
                }
                output #told aria-live="polite" { "Point at a touch, or step through them." }
                p.help { (HELP) }
            }
            div #still { (svg::picture(scene, "Fixture, touches and frame")) }
            figcaption #caption { (caption(subject, scene)) }
        }
    };
    section("picture", "Picture", &body)
}

/// What the picture shows, and by how much it magnifies.
fn caption(subject: &Subject<'_>, scene: &Scene) -> Markup {
    html! {
        span.key.residual { "Residuals" } " are drawn " (times(scene.residuals_magnified)) ", from the surface along its normal. "
        @if scene.ellipsoids.is_empty() {
            "No uncertainty is drawn: none can be told. "
        } @else {
            span.key.ellipsoid { "Ellipsoids" } " hold the true place of the origin"
            @if scene.ellipsoids.len() > 1 { ", and of the points touched," }
            " at a chance of " (short(100.0 * PROBABILITY)) " % each (" (short(subject.coverage_factor_of_region()))
            " standard uncertainties); they are drawn " (times(scene.ellipsoids_magnified)) ". "
        }
        @if !scene.ghosts.is_empty() {
            span.key.ghost { "Dashed" } " are the frames that were rejected"
            @if scene.ghosts_left_out > 0 { ", the best " (scene.ghosts.len()) " of " (scene.ghosts.len() + scene.ghosts_left_out) }
            ". "
        }
        @if scene.tip_radius > 0.0 { "Circles are the tips of the probe. " }
        "Surfaces are drawn as far as they were touched or can be reached. X, Y and Z are the fixture's axes; those of the parent \
         stand in the corner. Seen without perspective."
    }
}

fn times(magnification: f64) -> String {
    if magnification > 1.0 {
        format!("{magnification} times larger")
    } else {
        "as large as they are".to_owned()
    }
}
