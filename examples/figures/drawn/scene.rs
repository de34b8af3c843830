//! The worked example: fixture, touches and frame, with the frames that the equations allow and the radius rejects.

use touchref::report::{Scene, Subject, svg};

use super::{chart, paper, solver};

pub(super) fn drawn() -> String {
    const HEIGHT: f64 = 540.0;
    let setup = paper();
    let solution = setup.solve(&*solver(), None).unwrap();
    let record = setup.record(&solution).unwrap();
    let subject = Subject::new(&record, &touchref::registry().unwrap()).unwrap();
    let scene = Scene::of(&subject).unwrap();
    let title =
        "Seven touches on a cylinder and its oblique face, the frame, and three rejected frames dashed";
    let picture = svg::picture(&scene, title).into_string();
    let (head, body) = picture.split_once("</title>").unwrap();
    format!("{head}</title>\n<style>{}</style>\n{}\n{body}\n", chart::STYLE, chart::background(HEIGHT))
}
