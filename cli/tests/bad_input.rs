//! What is wrong with an input is told by status, code, line, column, key and nearest name; nothing panics.
//!
//! Cases are rows of tables, ` | ` between the fields; `\n` stands for a new line. The place is line and column from
//! 1, nothing where none is told, and only the line where the line as a whole is meant. In the paper's measurement
//! `radius:10` is column 10 of the first line that begins with `radius`, `touch+3:6` the third line after one.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use common::{Folder, TABLE, paper, without_touches};
use rayon::prelude::*;

/// The paper's measurement with a part replaced:
/// name | part | replacement | code | place | key | nearest
const EDITED: &str = r#"
duplicate key         | angle_deg = 45.0 | radius = 2.0                    | invalid-input   | angle_deg:1  |                       |
key without value     | sigma = 0.00005  | sigma =                         | invalid-input   | sigma:8      |                       |
not closed            | radius = 1.0     | radius = "1                     | invalid-input   | radius:12    |                       |
unknown units         | "mm"             | "mmm"                           | invalid-input   | units:9      | units                 | mm
units in words        | "mm"             | "millimeters"                   | invalid-input   | units:9      | units                 | mm
units a number        | "mm"             | 1                               | invalid-input   | units:9      | units                 |
no units              | units = "mm"     |                                 | missing-key     | 1:1          | units                 |
unknown key           | units            | unts                            | unknown-key     | units:1      | unts                  | units
unknown table         | [probe]          | [prob]                          | unknown-key     | [probe]:2    | prob                  | probe
unknown fixture       | cylinder-plane   | cylinder-plain                  | unknown-fixture | kind:8       | fixture.kind          | cylinder-plane
kind a list           | "cylinder-plane" | [1]                             | invalid-input   | kind:8       | fixture.kind          |
no kind               | kind = "cylinder-plane" |                          | missing-key     | [fixture]:1  | fixture.kind          |
unknown parameter     | radius = 1.0     | radus = 1.0                     | unknown-key     | radius:1     | fixture.radus         | radius
missing parameter     | radius = 1.0     |                                 | missing-key     | [fixture]:1  | fixture.radius        |
radius negative       | radius = 1.0     | radius = -1.0                   | invalid-input   | radius:10    | fixture.radius        |
radius zero           | radius = 1.0     | radius = 0                      | invalid-input   | radius:10    | fixture.radius        |
radius nan            | radius = 1.0     | radius = nan                    | invalid-input   | radius:10    | fixture.radius        |
radius inf            | radius = 1.0     | radius = inf                    | invalid-input   | radius:10    | fixture.radius        |
radius overflows      | radius = 1.0     | radius = 1e999                  | invalid-input   | radius:10    | fixture.radius        |
radius a word         | radius = 1.0     | radius = "one"                  | invalid-input   | radius:10    | fixture.radius        |
radius a date         | radius = 1.0     | radius = 1979-05-27             | invalid-input   | radius:10    | fixture.radius        |
radius a list         | radius = 1.0     | radius = [1.0, 2.0]             | invalid-input   | radius:10    | fixture.radius        |
u negative            | radius = 1.0     | radius = { value = 1, u = -1 }  | invalid-input   | radius:27    | fixture.radius.u      |
u misspelt            | radius = 1.0     | radius = { value = 1, uu = 1 }  | unknown-key     | radius:23    | fixture.radius.uu     | u
u missing             | radius = 1.0     | radius = { value = 1 }          | missing-key     | radius:10    | fixture.radius.u      |
angle 0               | angle_deg = 45.0 | angle_deg = 0                   | invalid-input   | angle_deg:13 | fixture.angle_deg     |
angle 90              | angle_deg = 45.0 | angle_deg = 90.0                | invalid-input   | angle_deg:13 | fixture.angle_deg     |
unknown word          | angle_deg = 45.0 | cylinder_side = "fornt"         | invalid-input   | angle_deg:17 | fixture.cylinder_side | front
flag a word           | angle_deg = 45.0 | bore = "yes"                    | invalid-input   | angle_deg:8  | fixture.bore          |
sigma 0               | sigma = 0.00005  | sigma = 0                       | invalid-input   | sigma:9      | probe.sigma           |
tip radius negative   | tip_radius = 0.0 | tip_radius = -1                 | invalid-input   | tip_radius:14 | probe.tip_radius     |
probe key unknown     | tip_radius = 0.0 | tipradius = 0.0                 | unknown-key     | tip_radius:1 | probe.tipradius       | tip_radius
probe a list          | [probe]\ntip_radius = 0.0\nsigma = 0.00005 | [[probe]] | invalid-input | [probe]:1   | probe                 |
unknown surface       | "cylinder"\nat   | "cilinder"\nat                  | unknown-surface | [[touch]]+2:11 | touch[0].surface    | cylinder
no surface            | surface = "cylinder"\nat | at                      | missing-key     | [[touch]]:1  | touch[0].surface      |
no at                 | at = [2.9270, 2.0000, 1.6250] |                    | missing-key     | [[touch]]:1  | touch[0].at           |
two coordinates       | [2.9270, 2.0000, 1.6250] | [2.9270, 2.0000]        | invalid-input   | [[touch]]+3:6 | touch[0].at          |
coordinate nan        | 2.0000, 1.6250   | nan, 1.6250                     | invalid-input   | [[touch]]+3:15 | touch[0].at[1]      |
coordinate a word     | 2.0000, 1.6250   | "2", 1.6250                     | invalid-input   | [[touch]]+3:15 | touch[0].at[1]      |
touch key unknown     | id = "x1"        | idd = "x1"                      | unknown-key     | [[touch]]+1:1 | touch[0].idd         | id
approach zero         | id = "x1"        | approach = [0, 0, 0]            | invalid-input   | [[touch]]+1:12 | touch[0].approach   |
covariance lopsided   | id = "x1"        | covariance = [[1,1,0],[0,1,0],[0,0,1]] | invalid-input | [[touch]]+1:14 | touch[0].covariance |
touch sigma negative  | id = "x1"        | sigma = -1                      | invalid-input   | [[touch]]+1:9 | touch[0].sigma       |
touches given twice   | [fixture]        | touches = "t.csv"\n[fixture]    | invalid-input   | [fixture]:11 | touches               |
sigma of one only     | sigma = 0.00005\n\n[[touch]] | \n[[touch]]\nsigma = 1 | invalid-input |             | probe.sigma           |
"#;

/// Whole measurement files:
/// name | file | content | code | place | key | nearest
const WHOLE: &str = r#"
empty file            | m.toml |                                          | missing-key     | 1:1 | units |
blank file            | m.toml | \n\n                                     | missing-key     | 1:1 | units |
a shell script        | m.toml | #!/bin/sh\nexit                          | invalid-input   | 2:5 |       |
table instead         | m.toml | surface,x,y,z\nplane,1,2,3               | invalid-input   | 1:8 |       |
missing table         | m.toml | touches = "none.csv"\n{bare}             | unreadable      |     |       |
no touches            | m.toml | {bare}                                   | too-few-touches |     |       |
one touch             | m.toml | {bare}[[touch]]\nsurface = "plane"\nat = [1, 2, 3] | too-few-touches | | |
empty json            | m.json |                                          | invalid-input   | 1:1 |       |
json, trailing comma  | m.json | {"units": "mm",\n}                       | invalid-input   | 1:15 |      |
json, comment         | m.json | {"units": "mm" // millimetres\n}         | invalid-input   | 1:16 |      |
json, duplicate key   | m.json | {"units": "mm",\n "units": "m"}          | invalid-input   | 2:2 | units |
json, null            | m.json | {"units": null}                          | invalid-input   | 1:11 | units |
json, a list          | m.json | [1]                                      | invalid-input   | 1:1 |       |
json, unknown key     | m.json | {"units": "mm",\n "fixtur": {}}          | unknown-key     | 2:2 | fixtur | fixture
json, touch no list   | m.json | {"units": "mm", "fixture": {"kind": "k"},\n "touch": {}} | invalid-input | 2:11 | touch |
"#;

/// The paper's touches as a table with a part replaced, or a whole table where no part is named:
/// name | part | replacement | code | place | key | nearest
const TABLES: &str = r"
empty table           |                |                                   | invalid-input   |      |          |
only a comment        |                | # nothing\n                       | invalid-input   |      |          |
header only           |                | surface,x,y,z\n                   | too-few-touches |      |          |
no header             |                | plane,1,2,3\n                     | missing-column  | 1    |          |
missing column        |                | surface,x,y\nplane,1,2\n          | missing-column  | 1    | z        |
half an approach      |                | surface,x,y,z,i,j\nplane,1,2,3,0,0\n | missing-column | 1  | k        |
zero approach         |                | surface,x,y,z,i,j,k\nplane,1,2,3,0,0,0\n | invalid-input | 2 | i       |
comma for decimals    |                | surface,x,y,z\nplane,1,5,2,5,3,5\n | invalid-input  | 2    |          |
misspelt column       | surface        | surfaces                          | unknown-column  | 1:1  | surfaces | surface
column with a unit    | x,y            | x_mm,y                            | unknown-column  | 1:9  | x_mm     | x
column in capitals    | x,y            | X,y                               | unknown-column  | 1:9  | X        | x
column twice          | id             | x                                 | invalid-input   | 1:15 | x        |
field missing         | ,1.6250,x1     | ,1.6250                           | invalid-input   | 2    |          |
field too many        | x1             | x1,x1                             | invalid-input   | 2    |          |
not a number          | 1.4438         | 1.44.38                           | invalid-input   | 3:24 | z        |
nan in a table        | 1.4438         | nan                               | invalid-input   | 3:24 | z        |
inf in a table        | 1.4438         | -inf                              | invalid-input   | 3:24 | z        |
empty field           | 1.4438         |                                   | invalid-input   | 3:24 | z        |
surface misspelt      | plane          | plan                              | unknown-surface | 6:1  | surface  | plane
quote not closed      | x1             | 'x1                               | invalid-input   | 2:31 |          |
";

/// Calls on the paper's measurement:
/// name | arguments | code | key | nearest
const CALLS: &str = r"
missing file            | locate none.toml                              | unreadable      |                  |
directory               | locate .                                      | unreadable      |                  |
directory as table      | locate m.toml --touches .                     | unreadable      |                  |
both standard input     | locate - --touches -                          | invalid-input   | touches          |
unknown solver          | locate m.toml --solver closed-from            | unknown-solver  | solver           | closed-form
unknown dialect         | locate m.toml --dialect klingon               | unknown-dialect | dialect          |
unknown -p              | locate m.toml -p radios=1                     | unknown-key     | radios           | radius
-p no number            | locate m.toml -p radius=big                   | invalid-input   | radius           |
-p negative             | locate m.toml -p radius=-1                    | invalid-input   | fixture.radius   |
-p without value        | locate m.toml -p radius                       | usage           | --parameter <NAME=VALUE> |
sigma negative          | locate m.toml --sigma -1                      | invalid-input   | probe.sigma      |
sigma nan               | locate m.toml --sigma nan                     | invalid-input   | probe.sigma      |
sigma a word            | locate m.toml --sigma small                   | usage           | --sigma <S>      |
tip radius a word       | locate m.toml --tip-radius x                  | invalid-input   | probe.tip_radius |
tip radius negative     | locate m.toml --tip-radius -1                 | invalid-input   | probe.tip_radius |
near of six             | locate m.toml --near 1,2,3,4,5,6              | invalid-input   | near             |
near without rotation   | locate m.toml --near -1,2,3,0,0,0,0           | invalid-input   | near             |
near no result file     | locate m.toml --near m.toml                   | invalid-input   | near             |
unknown --fixture       | locate --fixture cilinder-plane               | unknown-fixture | fixture.kind     | cylinder-plane
fixture without radius  | locate --fixture cylinder-plane               | missing-key     | radius           |
no triangle             | locate --fixture three-sphere -p radius=9 -p ab=300 -p bc=120 -p ca=100 | invalid-input | ab |
too flat a triangle     | locate --fixture three-sphere -p radius=9 -p ab=100 -p bc=220 -p ca=120 | invalid-input | bc |
radius and radii        | locate --fixture three-sphere -p radius=9 -p radii=[9,9,8] -p ab=99 -p bc=99 -p ca=99 | invalid-input | radii |
neither                 | locate --fixture three-sphere -p ab=99 -p bc=99 -p ca=99 | missing-key | radius    |
two radii               | locate --fixture three-sphere -p radii=9,9 -p ab=99 -p bc=99 -p ca=99 | invalid-input | radii |
radii no numbers        | locate --fixture three-sphere -p radii=[9,9,x] | invalid-input  | radii            |
a ball within another   | locate --fixture three-sphere -p radii=9,9,60 -p ab=50 -p bc=50 -p ca=50 | invalid-input | radii |
unknown -p of balls     | locate --fixture three-sphere -p raddii=9,9,9 | unknown-key     | raddii           | radii
nothing to locate       | locate                                        | usage           | <MEASUREMENT>    |
file and fixture        | locate m.toml --fixture cylinder-plane        | usage           | [MEASUREMENT]    |
unknown --units         | locate --fixture cylinder-plane --units cm    | usage           | --units <UNIT>   |
study, unknown layout   | study m.toml --layout nominl                  | usage           | --layout <LAYOUT> | nominal
study, no trials        | study m.toml --trials 0                       | usage           | --trials <N>     |
study, trials a word    | study m.toml --trials many                    | usage           | --trials <N>     |
study, sigma 0          | study m.toml --sigma 0                        | invalid-input   | probe.sigma      |
study, sigma nan        | study m.toml --sigma nan                      | invalid-input   | probe.sigma      |
study, sigma overflows  | study m.toml --layout nominal --sigma 1e308   | invalid-input   |                  |
study, unknown solver   | study m.toml --solver closed-from             | unknown-solver  | solver           | closed-form
study, no threads       | study m.toml --threads 0                      | usage           | --threads <N>    |
study, too few touches  | study m.toml --layout random --touches-per-surface 3,3 | too-few-touches |         |
study, counts of one    | study m.toml --layout random --touches-per-surface 4   | invalid-input | touches-per-surface |
study, nothing touched  | study m.toml --layout random --touches-per-surface 0,0 | too-few-touches |         |
study, radius negative  | study m.toml --layout nominal -p radius=1+-1  | invalid-input   | fixture.radius   |
study, endless          | study m.toml --layout nominal -p radius=1+-1 --trials 18446744073709551615 | invalid-input | fixture.radius |
uncertainty, no draws   | uncertainty m.toml --samples 0                | usage           | --samples <N>    |
uncertainty, few draws  | uncertainty m.toml --samples 50               | invalid-input   | samples          |
uncertainty, endless    | uncertainty m.toml --samples 18446744073709551615 | usage       | --samples <N>    |
uncertainty, samples a word | uncertainty m.toml --samples atuo         | usage           | --samples <N>    |
uncertainty, certainty  | uncertainty m.toml --probability 1            | usage           | --probability <P> |
uncertainty, digits 3   | uncertainty m.toml --digits 3                 | usage           | --digits <N>     |
uncertainty, half a point | uncertainty m.toml --at 1,2                 | usage           | --at <X,Y,Z>     |
uncertainty, no point   | uncertainty m.toml --at 1,2,nan               | usage           | --at <X,Y,Z>     |
uncertainty, no frame   | uncertainty m.toml --near 1,2,3               | invalid-input   | near             |
reliability, alpha 0    | reliability m.toml --alpha 0                  | usage           | --alpha <A>      |
reliability, power 1    | reliability m.toml --power 1                  | usage           | --power <P>      |
study, no measurement   | study --fixture cylinder-plane -p radius=1 --layout measurement --sigma 1 | too-few-touches | |
unknown subcommand      | lcate m.toml                                  | usage           | lcate            | locate
unknown option          | locate m.toml --solvr x                       | usage           | --solvr          | --solver
unknown name            | describe cylinder-plan                        | unknown-name    | name             | cylinder-plane
unknown thing to list   | list solver                                   | usage           | [WHAT]           | solvers
";

/// A wrong input and what is to be said of it.
struct Case {
    name: String,
    file: &'static str,
    content: Vec<u8>,
    args: Vec<String>,
    stdin: Vec<u8>,
    told: Told,
}

/// Code, line, column (0 where there is none), key, nearest name.
type Told = (String, u64, u64, String, String);

/// The rows of a table of cases, split into trimmed fields.
fn rows(table: &str) -> impl Iterator<Item = Vec<String>> {
    table.lines().filter(|line| !line.trim().is_empty()).map(|line| {
        let fields = line.split('|').map(|field| field.trim().replace("\\n", "\n"));
        fields.chain(std::iter::repeat_n(String::new(), 2)).collect()
    })
}

/// Line and column of a place as the tables write it.
fn place(text: &str) -> (u64, u64) {
    let (line, column) = text.rsplit_once(':').unwrap_or((text, "0"));
    let (anchor, further) = line.rsplit_once('+').unwrap_or((line, "0"));
    let at_anchor =
        |anchor: &str| paper().lines().position(|line| line.starts_with(anchor)).map_or(0, |at| at + 1);
    let line =
        anchor.parse().unwrap_or_else(|_| if anchor.is_empty() { 0 } else { at_anchor(anchor) as u64 });
    (line + further.parse::<u64>().unwrap(), column.parse().unwrap())
}

fn case(name: &str, args: &[&str], content: impl Into<Vec<u8>>, told: [&String; 4]) -> Case {
    let [code, at, key, nearest] = told.map(String::as_str);
    let (line, column) = place(at);
    Case {
        name: name.to_owned(),
        file: "m.toml",
        content: content.into(),
        args: args.iter().map(|arg| (*arg).to_owned()).collect(),
        stdin: Vec::new(),
        told: (code.to_owned(), line, column, key.to_owned(), nearest.to_owned()),
    }
}

fn edited() -> impl Iterator<Item = Case> {
    rows(EDITED).map(|row| {
        let [name, from, to, told @ ..] = row.as_slice() else { panic!("{row:?}") };
        assert!(paper().contains(from), "{name}");
        let content = paper().replacen(from, to, 1);
        case(name, &["locate", "m.toml"], content, [&told[0], &told[1], &told[2], &told[3]])
    })
}

fn whole() -> impl Iterator<Item = Case> {
    rows(WHOLE).map(|row| {
        let [name, file, content, told @ ..] = row.as_slice() else { panic!("{row:?}") };
        let content = content.replace("{bare}", &without_touches());
        let case = case(name, &["locate", file], content, [&told[0], &told[1], &told[2], &told[3]]);
        Case { file: if file == "m.json" { "m.json" } else { "m.toml" }, ..case }
    })
}

fn tables() -> impl Iterator<Item = Case> {
    rows(TABLES).map(|row| {
        let [name, from, to, told @ ..] = row.as_slice() else { panic!("{row:?}") };
        let table = if from.is_empty() { to.clone() } else { TABLE.replacen(from, to, 1) };
        let args = ["locate", "m.toml", "--touches", "-"];
        let case = case(name, &args, without_touches(), [&told[0], &told[1], &told[2], &told[3]]);
        Case { stdin: table.replace('\'', "\"").into(), ..case }
    })
}

fn calls() -> impl Iterator<Item = Case> {
    rows(CALLS).map(|row| {
        let [name, args, code, key, nearest, ..] = row.as_slice() else { panic!("{row:?}") };
        let args: Vec<&str> = args.split_whitespace().collect();
        case(name, &args, paper(), [code, &String::new(), key, nearest])
    })
}

/// Bytes that are no text.
fn binary() -> Vec<Case> {
    let told = |at: &str| ["invalid-input", at, "", ""].map(str::to_owned);
    let case = |name, at, content: &[u8], stdin: &[u8]| {
        let args: &[&str] =
            if stdin.is_empty() { &["locate", "m.toml"] } else { &["locate", "m.toml", "--touches", "-"] };
        Case { stdin: stdin.to_vec(), ..case(name, args, content, told(at).each_ref()) }
    };
    let bare = without_touches();
    vec![
        case("control characters", "1:7", b"\x01\x02\x00ELF", b""),
        case("not utf-8", "1:11", b"units = \"m\xff\"", b""),
        case("utf-16", "1:1", b"\xff\xfeu\x00n\x00", b""),
        case("binary table", "1:6", bare.as_bytes(), b"\x7fELF\x01\xff\n"),
        case("utf-16 table", "1:1", bare.as_bytes(), b"\xff\xfes\x00u\x00"),
        case("table of one endless line", "1", bare.as_bytes(), &vec![b'7'; 1 << 20]),
    ]
}

/// What is told of a case, if that is not what is to be told.
fn wrong(case: &Case) -> Option<String> {
    let folder = Folder::new().with(case.file, &case.content);
    let args: Vec<&str> = case.args.iter().map(String::as_str).collect();
    let (status, printed) = folder.json(&args, &case.stdin);
    let error = &printed["error"];
    let number = |key: &str| error[key].as_u64().unwrap_or(0);
    let text = |key: &str| error[key].as_str().unwrap_or("").to_owned();
    let told = (text("code"), number("line"), number("column"), text("key"), text("nearest"));
    let plain = folder.run(&args, &case.stdin);
    let complaint = String::from_utf8_lossy(&plain.stderr);
    let sound = (status, plain.status.code()) == (2, Some(2))
        && printed["schema"] == "touchref.error/1"
        && !text("message").is_empty()
        && plain.stdout.is_empty()
        && !complaint.is_empty()
        && complaint.is_ascii()
        && !complaint.contains("panicked");
    (told != case.told || !sound)
        .then(|| format!("{}: {told:?}, expected {:?}\n{complaint}", case.name, case.told))
}

#[test]
fn every_error_is_told_by_code_place_key_and_nearest_name() {
    let cases: Vec<Case> = edited().chain(whole()).chain(tables()).chain(calls()).chain(binary()).collect();
    let wrong: Vec<String> = cases.par_iter().filter_map(wrong).collect();
    assert!(wrong.is_empty(), "{} cases\n{}", wrong.len(), wrong.join("\n"));
}
