//! Which point of a log is a touch of which surface, as `[log]` of a measurement states it.

use std::{collections::HashMap, ops::RangeInclusive, path::Path};

use nalgebra::Point3;
use touchref_core::{Fixture, Probe, Warning, parameters::nearest};

use crate::{
    Input, InputError, TouchRecord, Touches, Units,
    measurement::{UNLABELLED, read_units},
    source::Place,
    tree::Content,
    walk::{Field, Table},
};

use super::{ALL, Column, Columns, Importer, LoggedPoint, MachineLog, Position, find};

const KEYS: &[&str] =
    &["file", "format", "columns", "units", "base", "tool", "compensated", "touch", "ignore"];
const SELECTION_KEYS: &[&str] = &["points", "rows"];
const TOUCH_KEYS: &[&str] = &["surface", "points", "rows"];
const COLUMN_KEYS: &[&str] = &["at", "name", "approach", "normal"];

/// A log, what the measurement states of it, and what its points are.
#[derive(Debug, Clone, PartialEq)]
pub struct LogSource {
    input: Input,
    importer: &'static Importer,
    columns: Option<Columns>,
    units: Option<Stated<Units>>,
    base: Option<Stated<String>>,
    tool: Option<Stated<String>>,
    compensated: Option<Stated<bool>>,
    touches: Vec<(Stated<String>, Selection)>,
    ignored: Selection,
    /// The table itself, where a key is missing.
    table: Stated<()>,
}

/// A value, and where it is stated.
#[derive(Debug, Clone, PartialEq)]
struct Stated<T> {
    value: T,
    key: String,
    place: Place,
}

impl<T> Stated<T> {
    fn new(field: &Field<'_>, value: T) -> Self {
        Self { value, key: field.path.clone(), place: field.place() }
    }

    fn wrong(&self, message: impl Into<String>) -> InputError {
        InputError::new("invalid-input", message).with_key(self.key.clone()).at(self.place.clone())
    }
}

/// Points of a log, by name or by row.
#[derive(Debug, Clone, PartialEq, Default)]
struct Selection {
    points: Vec<Stated<String>>,
    /// Rows from 1.
    rows: Vec<Stated<RangeInclusive<usize>>>,
}

/// What becomes of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    /// A touch of the surface of this mapping.
    Touch(usize),
    Ignored,
}

impl LogSource {
    /// What messages call the log.
    #[must_use]
    pub fn name(&self) -> String {
        self.input.name()
    }

    /// Reads `[log]`; the log it names is looked for in `folder`.
    pub(crate) fn read(field: &Field<'_>, folder: &Path) -> Result<Self, InputError> {
        let table = field.table()?;
        table.only(KEYS)?;
        let file = table.require("file", "the log, relative to this file")?.text()?;
        let importer = read_format(&table, file)?;
        let columns = match (table.get("columns"), importer.takes_columns()) {
            (Some(field), true) => Some(read_columns(&field)?),
            (None, true) => {
                return Err(table.missing("columns", "the columns, as { at = [\"X\", \"Y\", \"Z\"] }"));
            }
            (Some(field), false) => {
                let expected = format!("no such key: format `{}` knows its columns", importer.name);
                return Err(field.wrong("given", &expected));
            }
            (None, false) => None,
        };
        let flag = |field: Field<'_>| match field.node.content {
            Content::Flag(flag) => Ok(Stated::new(&field, flag)),
            _ => Err(field.wrong(field.node.kind(), "true (contact points) or false (tip centres)")),
        };
        let touches = match table.get("touch") {
            Some(list) => list.list("a list of mappings, [[log.touch]]")?,
            None => Vec::new(),
        };
        if touches.is_empty() {
            return Err(table.missing("touch", "[[log.touch]] with `surface`, and `points` or `rows`"));
        }
        let touches = touches.iter().map(|field| {
            let table = field.table()?;
            table.only(TOUCH_KEYS)?;
            let surface = table.require("surface", "the name of a surface of the fixture")?;
            let selection = read_selection(&table)?;
            Ok((Stated::new(&surface, surface.text()?.to_owned()), selection))
        });
        let ignored = table.get("ignore").map_or(Ok(Selection::default()), |field| {
            let table = field.table()?;
            table.only(SELECTION_KEYS)?;
            read_selection(&table)
        });
        Ok(Self {
            // In a file `-` is a name like any other: standard input is for the command line.
            input: Input::File(folder.join(file)),
            importer,
            columns,
            units: table
                .get("units")
                .map(|field| read_units(&field).map(|units| Stated::new(&field, units)))
                .transpose()?,
            base: table.get("base").map(|field| name_or_number(&field)).transpose()?,
            tool: table.get("tool").map(|field| name_or_number(&field)).transpose()?,
            compensated: table.get("compensated").map(flag).transpose()?,
            touches: touches.collect::<Result<_, InputError>>()?,
            ignored: ignored?,
            table: Stated::new(field, ()),
        })
    }

    /// Reads the log, and its touches in the log's order, in the measurement's unit.
    pub(crate) fn touches(
        &self,
        fixture: &dyn Fixture,
        units: Units,
        probe: &Probe,
    ) -> Result<Touches, InputError> {
        self.check_tip(probe)?;
        for (surface, _) in &self.touches {
            if surface.value != UNLABELLED {
                fixture.surface_index(&surface.value).map_err(|error| {
                    InputError::from(error).with_key(surface.key.clone()).at(surface.place.clone())
                })?;
            }
        }
        let log = MachineLog::read(self.importer, &self.input, self.columns.as_ref())?;
        let uses = self.uses(&log)?;
        let mut touched = Vec::new();
        for (index, (point, of)) in log.points().iter().zip(uses).enumerate() {
            match (of, &point.position) {
                (Some(Use::Touch(mapping)), Position::At(at)) => touched.push((index, mapping, point, *at)),
                (Some(Use::Touch(mapping)), Position::Unusable(fault) | Position::Empty(fault)) => {
                    let key = self.touches[mapping].0.key.replace(".surface", "");
                    return Err(log.fault(fault).with_key(key));
                }
                (None, Position::At(_) | Position::Unusable(_)) => {
                    let message =
                        format!("{} is neither mapped to a surface nor ignored", told(index, point));
                    return Err(log
                        .error(point, message)
                        .with_key(format!("{}.touch", self.table.key))
                        .with_help("name it in `points` or `rows` of a [[log.touch]], or of [log.ignore]"));
                }
                _ => {}
            }
        }
        let points: Vec<(usize, &LoggedPoint)> =
            touched.iter().map(|(index, _, point, _)| (*index, *point)).collect();
        let mut warnings = self.check_frames(&log, &points)?;
        warnings.extend(self.check_repeats(&log, &touched)?);
        let mut records = Vec::with_capacity(touched.len());
        for (index, mapping, point, at) in touched {
            let own = self.units_of(&log, point)?;
            records.push(TouchRecord {
                approach: point.approach,
                id: Some(point.name.clone().unwrap_or_else(|| (index + 1).to_string())),
                line: Some(point.line),
                ..TouchRecord::new(&self.touches[mapping].0.value, converted(at, own, units))
            });
        }
        Ok(Touches { records, file: self.name(), warnings, ..Touches::default() })
    }

    /// What becomes of each point.
    fn uses(&self, log: &MachineLog) -> Result<Vec<Option<Use>>, InputError> {
        let mut by_name: HashMap<&str, Vec<usize>> = HashMap::new();
        for (index, point) in log.points().iter().enumerate() {
            if let Some(name) = &point.name {
                by_name.entry(name).or_default().push(index);
            }
        }
        let mut uses = vec![None; log.points().len()];
        let mappings =
            self.touches.iter().enumerate().map(|(index, (_, points))| (Use::Touch(index), points));
        for (what, selection) in mappings.chain([(Use::Ignored, &self.ignored)]) {
            for stated in &selection.points {
                let index = find_point(log, &by_name, stated)?;
                self.put(&mut uses, log, index, what, stated)?;
            }
            for stated in &selection.rows {
                let count = log.points().len();
                if *stated.value.end() > count {
                    let message = format!("row {} is beyond the log's {count} points", stated.value.end());
                    let help = "a probe that missed, or one that the control did not write, leaves no row";
                    return Err(stated.wrong(message).with_help(help));
                }
                for row in stated.value.clone() {
                    self.put(&mut uses, log, row - 1, what, stated)?;
                }
            }
        }
        Ok(uses)
    }

    fn put<T>(
        &self,
        uses: &mut [Option<Use>],
        log: &MachineLog,
        index: usize,
        what: Use,
        stated: &Stated<T>,
    ) -> Result<(), InputError> {
        let told_use = |what: Use| match what {
            Use::Touch(mapping) => format!("a touch of `{}`", self.touches[mapping].0.value),
            Use::Ignored => "ignored".to_owned(),
        };
        match uses[index].replace(what) {
            None => Ok(()),
            Some(before) => Err(stated.wrong(format!(
                "{} is mapped twice: it is {} and {}",
                told(index, &log.points()[index]),
                told_use(before),
                told_use(what)
            ))),
        }
    }

    /// Tip centres and contact points differ where the tip has a radius.
    fn check_tip(&self, probe: &Probe) -> Result<(), InputError> {
        let is_point = probe.tip_radius == 0.0 && probe.tip_radius_u == 0.0;
        match &self.compensated {
            Some(stated) if stated.value && !is_point => Err(stated
                .wrong(format!(
                    "the log has contact points (compensated), but the tip's radius is {}; expected 0",
                    probe.tip_radius
                ))
                .with_help("with tip_radius = 0 the points are taken as they are")),
            None if !self.importer.tip_centres && !is_point => Err(self.missing(
                "compensated",
                "the tip has a radius, and the log does not tell whether it has tip centres or contact points",
                "compensated = false for tip centres, true for contact points",
            )),
            _ => Ok(()),
        }
    }

    fn missing(&self, key: &str, why: &str, help: &str) -> InputError {
        let key = format!("{}.{key}", self.table.key);
        InputError::new("missing-key", format!("`{key}` is missing: {why}"))
            .with_help(help)
            .with_key(key)
            .at(self.table.place.clone())
    }

    fn units_of(&self, log: &MachineLog, point: &LoggedPoint) -> Result<Units, InputError> {
        match (point.units.or(self.importer.units), &self.units) {
            (Some(told), Some(stated)) if told != stated.value => Err(stated.wrong(format!(
                "the log is in {told} (format `{}`, line {}), not in {}",
                self.importer.name, point.line, stated.value
            ))),
            (Some(told), _) => Ok(told),
            (None, Some(stated)) if log.points().iter().any(|point| point.units.is_some()) => Err(log
                .error(point, "this point stands before the log tells its unit")
                .with_key(stated.key.clone())),
            (None, Some(stated)) => Ok(stated.value),
            (None, None) => Err(self.missing(
                "units",
                "the log does not tell its unit",
                &format!("expected one of {}", Units::names()),
            )),
        }
    }

    /// All touches are of one base and one tool, and of those that are stated.
    fn check_frames(
        &self,
        log: &MachineLog,
        touched: &[(usize, &LoggedPoint)],
    ) -> Result<Vec<Warning>, InputError> {
        if let (Some(frame), Some(stated)) = (self.importer.frame, &self.base) {
            let name = self.importer.name;
            return Err(
                stated.wrong(format!("positions of format `{name}` are always in {frame}; remove `base`"))
            );
        }
        let base = self.agreed(log, touched, "base", |point| point.base.as_deref(), self.base.as_ref())?;
        let tool = self.agreed(log, touched, "tool", |point| point.tool.as_deref(), self.tool.as_ref())?;
        let Some(base) = base else {
            return match (&self.base, self.importer.frame) {
                (None, None) => Err(self.missing(
                    "base",
                    "the log does not tell what its positions are relative to",
                    self.importer.about,
                )),
                _ => Ok(Vec::new()),
            };
        };
        let mut warnings = Vec::new();
        if self.base.is_none() {
            let tool = tool.map_or(String::new(), |tool| format!(", taken with tool {tool}"));
            let message = format!(
                "the positions of {} are relative to base {base}{tool}, and so is the frame; state `base` to have it checked",
                self.name()
            );
            warnings.push(Warning { code: "log-frame", message });
        }
        Ok(warnings)
    }

    /// What all touches tell alike of their base or tool.
    fn agreed<'a>(
        &self,
        log: &MachineLog,
        touched: &[(usize, &'a LoggedPoint)],
        what: &str,
        of: impl Fn(&'a LoggedPoint) -> Option<&'a str>,
        stated: Option<&Stated<String>>,
    ) -> Result<Option<&'a str>, InputError> {
        let Some((first_index, first)) = touched.first().copied() else { return Ok(None) };
        let shown =
            |value: Option<&str>| value.map_or(format!("no {what}"), |value| format!("{what} {value}"));
        for (index, point) in touched.iter().copied() {
            let key = format!("{}.{what}", self.table.key);
            if of(point) != of(first) {
                let message = format!(
                    "{} has {}, but {} has {}",
                    told(index, point),
                    shown(of(point)),
                    told(first_index, first),
                    shown(of(first))
                );
                return Err(log.error(point, message).with_key(key));
            }
            if let (Some(own), Some(stated)) = (of(point), stated)
                && own != stated.value
            {
                let message = format!(
                    "{} has {what} {own}; the measurement states {what} {}",
                    told(index, point),
                    stated.value
                );
                return Err(log.error(point, message).with_key(key));
            }
        }
        Ok(of(first))
    }

    /// A position that is there twice to the last digit was rather copied, or kept after a missed probe, than touched.
    fn check_repeats(
        &self,
        log: &MachineLog,
        touched: &[(usize, usize, &LoggedPoint, Point3<f64>)],
    ) -> Result<Vec<Warning>, InputError> {
        let mut seen: HashMap<[u64; 3], (usize, usize, &LoggedPoint)> = HashMap::new();
        let mut warnings = Vec::new();
        for (index, mapping, point, at) in touched {
            // Adding zero makes -0 and 0 the same.
            let key = [at.x, at.y, at.z].map(|v| (v + 0.0).to_bits());
            let Some((before_index, before_mapping, before)) = seen.insert(key, (*index, *mapping, point))
            else {
                continue;
            };
            let message = format!(
                "{} has exactly the position of {}: was it touched, or kept from before?",
                told(*index, point),
                told(before_index, before)
            );
            if self.touches[before_mapping].0.value != self.touches[*mapping].0.value {
                return Err(log.error(point, message).with_help("two surfaces are not touched at one place"));
            }
            warnings.push(Warning { code: "repeated-touch", message });
        }
        Ok(warnings)
    }
}

/// A point, in a message.
fn told(index: usize, point: &LoggedPoint) -> String {
    match &point.name {
        Some(name) => format!("point `{name}` (line {})", point.line),
        None => format!("row {} (line {})", index + 1, point.line),
    }
}

fn find_point(
    log: &MachineLog,
    by_name: &HashMap<&str, Vec<usize>>,
    stated: &Stated<String>,
) -> Result<usize, InputError> {
    let name = stated.value.as_str();
    match by_name.get(name).map(Vec::as_slice) {
        Some([index]) => Ok(*index),
        Some(indices) => {
            let lines = indices.iter().map(|index| log.points()[*index].line.to_string());
            let lines = lines.collect::<Vec<_>>().join(", ");
            Err(stated
                .wrong(format!("the log has several points `{name}` (lines {lines})"))
                .with_help("say which by `rows`"))
        }
        None => {
            let (message, near) = if by_name.is_empty() {
                ("the points of this log have no names; say which by `rows`".to_owned(), None)
            } else {
                let names = log.points().iter().filter_map(|point| point.name.as_deref());
                (format!("the log has no point `{name}`"), nearest(name, names))
            };
            Err(InputError::new("unknown-point", message)
                .with_nearest(near)
                .with_key(stated.key.clone())
                .at(stated.place.clone()))
        }
    }
}

/// A position in another unit.
fn converted(at: Point3<f64>, from: Units, to: Units) -> Point3<f64> {
    if from == to { at } else { at.map(|v| v * from.millimetres() / to.millimetres()) }
}

fn read_format(table: &Table<'_>, file: &str) -> Result<&'static Importer, InputError> {
    let names = ALL.iter().map(|importer| importer.name).collect::<Vec<_>>().join(", ");
    let Some(field) = table.get("format") else {
        let extension =
            Path::new(file).extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        let fitting: Vec<&str> = ALL
            .iter()
            .filter(|importer| importer.extensions.contains(&extension.as_str()))
            .map(|importer| importer.name)
            .collect();
        let hint = if fitting.is_empty() {
            String::new()
        } else {
            format!("; files .{extension} can be {}", fitting.join(" or "))
        };
        return Err(table.missing("format", &format!("one of {names}{hint}")));
    };
    find(field.text()?).map_err(|error| error.with_key(field.path.clone()).at(field.place()))
}

fn read_columns(field: &Field<'_>) -> Result<Columns, InputError> {
    let table = field.table()?;
    table.only(COLUMN_KEYS)?;
    let at = three(&table.require("at", "the columns of the position, as [\"X\", \"Y\", \"Z\"]")?)?;
    let columns = Columns {
        at,
        name: table.get("name").map(|field| column(&field)).transpose()?,
        approach: table.get("approach").map(|field| three(&field)).transpose()?,
        normal: table.get("normal").map(|field| three(&field)).transpose()?,
    };
    if let (Some(_), Some(normal)) = (&columns.approach, table.get("normal")) {
        return Err(normal.wrong("given beside `approach`", "one of the two"));
    }
    let numbered = columns.all().filter(|column| matches!(column, Column::Numbered(_))).count();
    if numbered > 0 && numbered < columns.all().count() {
        return Err(
            field.wrong("of names and numbers", "names in the header, or numbers where there is none")
        );
    }
    Ok(columns)
}

fn three(field: &Field<'_>) -> Result<[Column; 3], InputError> {
    const EXPECTED: &str = "three columns, as [\"X\", \"Y\", \"Z\"] or [1, 2, 3]";
    let columns = field.list(EXPECTED)?;
    let [x, y, z] = columns.as_slice() else {
        return Err(field.wrong(&format!("a list of {}", columns.len()), EXPECTED));
    };
    Ok([column(x)?, column(y)?, column(z)?])
}

fn column(field: &Field<'_>) -> Result<Column, InputError> {
    match &field.node.content {
        Content::Text(name) => Ok(Column::Named(name.clone())),
        _ => Ok(Column::Numbered(whole(field, 1.0, "the name of a column, or its number from 1")? as usize)),
    }
}

/// A whole number from `lowest` on.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a whole number within its range"
)]
fn whole(field: &Field<'_>, lowest: f64, expected: &str) -> Result<u32, InputError> {
    let right = |value: f64| value.fract() == 0.0 && value >= lowest && value <= f64::from(u32::MAX);
    Ok(field.number_where(right, expected)? as u32)
}

fn name_or_number(field: &Field<'_>) -> Result<Stated<String>, InputError> {
    let text = match &field.node.content {
        Content::Text(name) if !name.trim().is_empty() => name.trim().to_owned(),
        _ => whole(field, 0.0, "a name, or a whole number, 0 or more")?.to_string(),
    };
    Ok(Stated::new(field, text))
}

fn read_selection(table: &Table<'_>) -> Result<Selection, InputError> {
    let mut selection = Selection::default();
    if let Some(points) = table.get("points") {
        for name in points.list("a list of names of points")? {
            selection.points.push(Stated::new(&name, name.text()?.to_owned()));
        }
    }
    if let Some(rows) = table.get("rows") {
        const EXPECTED: &str = "rows counted from 1, as \"1-4, 7\"";
        for part in rows.text()?.split(',') {
            let (from, to) = part.split_once('-').unwrap_or((part, part));
            let ends = from.trim().parse::<usize>().ok().zip(to.trim().parse::<usize>().ok());
            let Some((from, to)) = ends.filter(|(from, to)| *from >= 1 && from <= to) else {
                return Err(rows.wrong(&format!("\"{}\"", rows.text()?), EXPECTED));
            };
            selection.rows.push(Stated::new(&rows, from..=to));
        }
    }
    if selection == Selection::default() {
        return Err(table.missing("points", "points = [\"P1\", ...], or rows = \"1-4\""));
    }
    Ok(selection)
}
