//! Charts as SVG that stands by itself: no script, no font of its own, its colours for a light and a dark page.

use std::fmt::Write as _;

/// Width of every figure; a page shows it at about this size.
pub(super) const WIDTH: f64 = 760.0;

/// Colours by class. The picture of a scene brings attributes for a light page, which these rules replace.
pub(super) const STYLE: &str = "\
.paper{fill:#fff;stroke:#d5dbe2}text{fill:#1d2733}text.faint{fill:#5a6472}text.title{font-weight:600}\
.grid{stroke:#e3e8ed;fill:none}.axis{stroke:#66707c;fill:none}.level{stroke:#66707c;fill:none;stroke-dasharray:6 4}\
.s0{stroke:#1a5a96;fill:none}.s1{stroke:#c2571a;fill:none}.s2{stroke:#2b7a33;fill:none}.s3{stroke:#6d4bb0;fill:none}\
.f0{fill:#1a5a96}.f1{fill:#c2571a}.f2{fill:#2b7a33}.f3{fill:#6d4bb0}.f4{fill:#b3261e}.f5{fill:#8a6d00}.body{fill:#e6ecf1}\
.scene .axis-x text{fill:#b3261e}.scene .axis-y text{fill:#2b7a33}.scene .axis-z text{fill:#1f5fbf}\
@media (prefers-color-scheme:dark){\
.paper{fill:#14181d;stroke:#353e49}text{fill:#e4e8ed}text.faint{fill:#9aa5b1}\
.grid{stroke:#262e37}.axis,.level{stroke:#93a0ad}\
.s0{stroke:#7db6ea}.s1{stroke:#f29a5c}.s2{stroke:#7fd08a}.s3{stroke:#b39ae8}\
.f0{fill:#7db6ea}.f1{fill:#f29a5c}.f2{fill:#7fd08a}.f3{fill:#b39ae8}.f4{fill:#ff8a80}.f5{fill:#e0c24f}.body{fill:#27303a}\
.scene .shade-0{fill:#27303a;stroke:#27303a}.scene .shade-1{fill:#2e3842;stroke:#2e3842}\
.scene .shade-2{fill:#35404b;stroke:#35404b}.scene .shade-3{fill:#3c4854;stroke:#3c4854}\
.scene .shade-4{fill:#43505d;stroke:#43505d}.scene .shade-5{fill:#4a5865;stroke:#4a5865}\
.scene .shade-6{fill:#51606e;stroke:#51606e}.scene .shade-7{fill:#596775;stroke:#596775}\
.scene .back{fill:#303a45;stroke:#303a45}.scene .edge,.scene .hidden{stroke:#93a0ad}\
.scene .ellipsoids{fill:#b39ae8;stroke:#b39ae8}.scene .touch circle:not(.tip){fill:#e4e8ed}.scene .parent{stroke:#9aa5b1}\
.scene .axis-x{fill:#ff8a80;stroke:#ff8a80}.scene .axis-y{fill:#7fd08a;stroke:#7fd08a}.scene .axis-z{fill:#8ab4f8;stroke:#8ab4f8}\
.scene .axis-x text{fill:#ff8a80}.scene .axis-y text{fill:#7fd08a}.scene .axis-z text{fill:#8ab4f8}\
.scene .touch{fill:#e4e8ed;stroke:#e4e8ed}.scene .residual{stroke:#f29a5c}}";

/// A figure as it is drawn.
pub(super) struct Picture {
    title: String,
    height: f64,
    body: String,
}

/// Where a text begins, ends, or has its middle.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Picture {
    /// `title` is what it shows, for who cannot see it.
    pub(super) fn new(title: &str, height: f64) -> Self {
        Self { title: title.to_owned(), height, body: String::new() }
    }

    fn add(&mut self, element: std::fmt::Arguments<'_>) {
        self.body.write_fmt(element).unwrap();
        self.body.push('\n');
    }

    /// A text at a place; `class` may be empty.
    pub(super) fn text(&mut self, at: [f64; 2], class: &str, anchor: Anchor, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let [x, y] = at;
        self.add(format_args!(
            r#"<text class="{class}" x="{x:.1}" y="{y:.1}" text-anchor="{anchor}">{text}</text>"#
        ));
    }

    /// A line through points.
    pub(super) fn line(&mut self, class: &str, width: f64, points: &[[f64; 2]]) {
        let mut path = String::new();
        for [x, y] in points {
            write!(path, "{}{x:.1} {y:.1}", if path.is_empty() { "M" } else { "L" }).unwrap();
        }
        self.add(format_args!(r#"<path class="{class}" stroke-width="{width}" d="{path}"/>"#));
    }

    pub(super) fn rectangle(&mut self, class: &str, from: [f64; 2], to: [f64; 2]) {
        let ([x, y], [width, height]) = (from, [to[0] - from[0], to[1] - from[1]]);
        self.add(format_args!(
            r#"<rect class="{class}" x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}"/>"#
        ));
    }

    pub(super) fn dot(&mut self, class: &str, at: [f64; 2], radius: f64) {
        let [x, y] = at;
        self.add(format_args!(r#"<circle class="{class}" cx="{x:.1}" cy="{y:.1}" r="{radius}"/>"#));
    }

    /// The SVG.
    pub(super) fn finish(self) -> String {
        let Self { title, height, body } = self;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" width=\"{WIDTH}\" \
             height=\"{height}\" role=\"img\" font-family=\"system-ui, sans-serif\" font-size=\"14\">\n\
             <title>{title}</title>\n<style>{STYLE}</style>\n{}\n{body}</svg>\n",
            background(height)
        )
    }
}

/// What a figure stands on, so that it is read on any page.
pub(super) fn background(height: f64) -> String {
    let (width, height) = (WIDTH - 1.0, height - 1.0);
    format!(r#"<rect class="paper" x="0.5" y="0.5" width="{width}" height="{height}" rx="6"/>"#)
}

/// How numbers are laid along an axis.
#[derive(Clone, Copy)]
pub(super) enum Scale {
    Linear { from: f64, to: f64 },
    Logarithmic { from: f64, to: f64 },
}

impl Scale {
    fn part(self, value: f64) -> f64 {
        match self {
            Self::Linear { from, to } => (value - from) / (to - from),
            Self::Logarithmic { from, to } => (value / from).ln() / (to / from).ln(),
        }
    }
}

/// A field of a figure in which numbers have places.
#[derive(Clone, Copy)]
pub(super) struct Field {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
    pub(super) x: Scale,
    pub(super) y: Scale,
}

impl Field {
    pub(super) fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let along = self.left + self.x.part(x) * (self.right - self.left);
        [along, self.bottom + self.y.part(y) * (self.top - self.bottom)]
    }

    /// Whether a number has a place on the vertical axis.
    fn holds(&self, y: f64) -> bool {
        (0.0..=1.0).contains(&self.y.part(y))
    }

    /// The field with marks along both axes, and what is told along them.
    pub(super) fn draw(&self, picture: &mut Picture, x: &[(f64, &str)], y: &[(f64, &str)], names: [&str; 2]) {
        for (value, name) in x {
            let [at, _] = self.at(*value, 0.0);
            picture.line("grid", 1.0, &[[at, self.top], [at, self.bottom]]);
            picture.text([at, self.bottom + 19.0], "faint", Anchor::Middle, name);
        }
        for (value, name) in y {
            let [_, at] = self.at(0.0, *value);
            picture.line("grid", 1.0, &[[self.left, at], [self.right, at]]);
            picture.text([self.left - 8.0, at + 5.0], "faint", Anchor::End, name);
        }
        let corners = [[self.left, self.top], [self.left, self.bottom], [self.right, self.bottom]];
        picture.line("axis", 1.0, &corners);
        picture.text([self.right, self.bottom + 38.0], "faint", Anchor::End, names[0]);
        picture.text([self.left, self.top - 10.0], "faint", Anchor::Start, names[1]);
    }

    /// A curve, interrupted where it leaves the field.
    pub(super) fn curve(&self, picture: &mut Picture, class: &str, points: &[[f64; 2]]) {
        let (mut run, mut last): (Vec<[f64; 2]>, Option<bool>) = (Vec::new(), None);
        for [x, y] in points {
            let inside = self.holds(*y);
            if inside {
                run.push(self.at(*x, *y));
            } else if last == Some(true) {
                picture.line(class, 2.0, &run);
                run.clear();
            }
            last = Some(inside);
        }
        if run.len() > 1 {
            picture.line(class, 2.0, &run);
        }
    }

    /// A level across the field.
    pub(super) fn level(&self, picture: &mut Picture, y: f64) {
        let [_, at] = self.at(0.0, y);
        picture.line("level", 1.2, &[[self.left, at], [self.right, at]]);
    }
}
