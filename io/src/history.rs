//! Results kept over time, in one SQLite file.
//!
//! What was appended is on the disk before its number is told, and stays there whatever happens to the process or the
//! machine afterwards. The journal is SQLite's rollback journal, not a write-ahead log: results come one by one, and a
//! store at rest is a single file that can be copied, or read where nothing may be written. `synchronous` is `EXTRA`, as
//! with that journal a commit is durable only when the folder knows that the journal is gone.

use std::{fs::File, io::Read, path::Path, time::Duration};

use rusqlite::{
    Connection, ErrorCode, OpenFlags, OptionalExtension, Row, TransactionBehavior, named_params, params,
};

use crate::InputError;

/// The version of the tables below; a store of a newer one is refused.
pub const SCHEMA_VERSION: i32 = 1;
/// By which a file is known as one of ours: "touc".
const APPLICATION: i32 = 0x746f_7563;
/// How long to wait for another process that is writing; a write takes milliseconds.
const PATIENCE: Duration = Duration::from_secs(10);

/// `time` is the commit's, UTC. What is told twice, in a column and in `result`, is there to search by.
const TABLES: &str = "
    CREATE TABLE result (
        number INTEGER PRIMARY KEY AUTOINCREMENT,
        time TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
        name TEXT,
        measurement TEXT NOT NULL,
        fixture TEXT NOT NULL,
        status TEXT NOT NULL,
        units TEXT NOT NULL,
        x REAL, y REAL, z REAL,
        json TEXT NOT NULL
    ) STRICT;";

/// Results kept over time.
#[derive(Debug)]
pub struct History {
    connection: Connection,
    file: String,
}

/// What is kept of one result.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// What the user calls it.
    pub name: Option<String>,
    /// Where the measurement came from.
    pub measurement: String,
    /// Kind of the fixture.
    pub fixture: String,
    /// `ok`, or the code of the refusal.
    pub status: String,
    /// Unit of every length.
    pub units: String,
    /// The fixture's origin in the parent; `None` for a refusal.
    pub origin: Option<[f64; 3]>,
    /// The JSON of the result, or of the refusal.
    pub json: String,
}

/// The status of a frame that passed its checks.
pub const OK: &str = "ok";

/// A result in a store.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Its number: from 1, in the order of recording, never given twice.
    pub number: i64,
    /// When it was recorded, UTC: `2026-01-31T12:00:00.000Z`.
    pub time: String,
    /// What is kept.
    pub entry: Entry,
}

/// Which results are wanted; all that is given must hold.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Selection {
    /// The one of this number.
    pub number: Option<i64>,
    /// Recorded at this time or later, UTC: `2026-01-31`, `2026-01-31T12:00`, ...
    pub since: Option<String>,
    /// Recorded before this time.
    pub until: Option<String>,
    /// Of this name.
    pub name: Option<String>,
    /// Of this kind of fixture.
    pub fixture: Option<String>,
    /// Of this status.
    pub status: Option<String>,
    /// Of those, so many of the last.
    pub last: Option<u32>,
}

impl History {
    /// Whether the file is an SQLite database, by its first bytes.
    #[must_use]
    pub fn is_at(path: &Path) -> bool {
        const MAGIC: &[u8; 16] = b"SQLite format 3\0";
        let mut start = [0; MAGIC.len()];
        File::open(path).and_then(|mut file| file.read_exact(&mut start)).is_ok() && start == *MAGIC
    }

    /// Opens a store to append to it; makes it where there is no file.
    ///
    /// # Errors
    /// `unwritable`, or `invalid-input` for a file that is no store, or of a newer version.
    pub fn append_to(path: &Path) -> Result<Self, InputError> {
        let history = Self::connect(path, OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE)?;
        history
            .connection
            .pragma_update(None, "synchronous", "EXTRA")
            .map_err(|error| history.error(&error))?;
        history.prepared().map_err(|error| history.error(&error))?;
        history.check()?;
        Ok(history)
    }

    /// Opens a store to read it.
    ///
    /// # Errors
    /// `unreadable`, or `invalid-input` for a file that is no store, or of a newer version.
    pub fn open(path: &Path) -> Result<Self, InputError> {
        // Read and write: what a crash has left half done is undone first, where that is allowed.
        let history = Self::connect(path, OpenFlags::SQLITE_OPEN_READ_WRITE)?;
        history.check()?;
        Ok(history)
    }

    fn connect(path: &Path, flags: OpenFlags) -> Result<Self, InputError> {
        let file = path.display().to_string();
        let connection = Connection::open_with_flags(path, flags).map_err(|error| told(&file, &error))?;
        connection.busy_timeout(PATIENCE).map_err(|error| told(&file, &error))?;
        Ok(Self { connection, file })
    }

    /// Makes the tables of an empty file; as one transaction, as another process may be about to do the same.
    fn prepared(&self) -> rusqlite::Result<()> {
        let empty = |connection: &Connection| {
            connection.query_row("SELECT count(*) = 0 FROM sqlite_schema", [], |row| row.get::<_, bool>(0))
        };
        if !empty(&self.connection)? || self.number("application_id")? != 0 {
            return Ok(());
        }
        let transaction =
            rusqlite::Transaction::new_unchecked(&self.connection, TransactionBehavior::Immediate)?;
        if empty(&transaction)? {
            transaction.execute_batch(TABLES)?;
            transaction.pragma_update(None, "application_id", APPLICATION)?;
            transaction.pragma_update(None, "user_version", SCHEMA_VERSION)?;
        }
        transaction.commit()
    }

    fn number(&self, pragma: &str) -> rusqlite::Result<i32> {
        self.connection.pragma_query_value(None, pragma, |row| row.get(0))
    }

    fn check(&self) -> Result<(), InputError> {
        let [application, version] = ["application_id", "user_version"]
            .map(|pragma| self.number(pragma).map_err(|error| self.error(&error)));
        let (application, version) = (application?, version?);
        if application != APPLICATION {
            let message = format!("{} is an SQLite database, but no history of touchref", self.file);
            return Err(self.wrong(message, "name another file; a new one is made where there is none"));
        }
        if version > SCHEMA_VERSION {
            let message = format!(
                "{} is of version {version}; this touchref knows versions up to {SCHEMA_VERSION}",
                self.file
            );
            return Err(self.wrong(message, "use a newer touchref, or another file"));
        }
        Ok(())
    }

    /// The file, as messages call it.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Appends a result; returns its number once it is on the disk.
    ///
    /// # Errors
    /// `unwritable`; then nothing was appended.
    pub fn append(&mut self, entry: &Entry) -> Result<i64, InputError> {
        self.inserted(entry).map_err(|error| self.error(&error))
    }

    fn inserted(&mut self, entry: &Entry) -> rusqlite::Result<i64> {
        let [x, y, z] = entry.origin.map_or([None; 3], |origin| origin.map(Some));
        let transaction = self.connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
        transaction.execute(
            "INSERT INTO result (name, measurement, fixture, status, units, x, y, z, json)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)",
            params![
                entry.name,
                entry.measurement,
                entry.fixture,
                entry.status,
                entry.units,
                x,
                y,
                z,
                entry.json
            ],
        )?;
        let number = transaction.last_insert_rowid();
        transaction.commit()?;
        Ok(number)
    }

    /// The wanted results, in the order of recording.
    ///
    /// # Errors
    /// `invalid-input` for a time that is none; `unreadable`.
    pub fn select(&self, selection: &Selection) -> Result<Vec<Recorded>, InputError> {
        let since = self.time(selection.since.as_deref(), "since")?;
        let until = self.time(selection.until.as_deref(), "until")?;
        let read = || {
            let mut statement = self.connection.prepare(
                "SELECT * FROM (
                     SELECT * FROM result
                     WHERE (:number IS NULL OR number = :number)
                       AND (:since IS NULL OR time >= :since) AND (:until IS NULL OR time < :until)
                       AND (:name IS NULL OR name = :name) AND (:fixture IS NULL OR fixture = :fixture)
                       AND (:status IS NULL OR status = :status)
                     ORDER BY number DESC LIMIT :last
                 ) ORDER BY number",
            )?;
            let wanted = named_params! {
                ":number": selection.number, ":since": since, ":until": until, ":name": selection.name,
                ":fixture": selection.fixture, ":status": selection.status,
                // All, where the limit is negative.
                ":last": selection.last.map_or(-1, i64::from),
            };
            statement.query_map(wanted, recorded)?.collect::<rusqlite::Result<Vec<_>>>()
        };
        read().map_err(|error| self.error(&error))
    }

    /// A time as the store writes it.
    fn time(&self, text: Option<&str>, key: &str) -> Result<Option<String>, InputError> {
        let Some(text) = text else { return Ok(None) };
        // A bare number would be a Julian day to SQLite.
        let normal = self.connection.query_row(
            "SELECT strftime('%Y-%m-%dT%H:%M:%fZ', ?1) WHERE ?1 GLOB '[0-9][0-9][0-9][0-9]-*'",
            [text],
            |row| row.get::<_, Option<String>>(0),
        );
        let normal = normal.optional().map_err(|error| self.error(&error))?.flatten();
        normal.map(Some).ok_or_else(|| {
            InputError::new("invalid-input", format!("`{text}` is no time"))
                .with_key(key)
                .with_help("times are UTC: 2026-01-31, 2026-01-31T12:00, 2026-01-31T12:00:00Z")
        })
    }

    fn wrong(&self, message: String, help: &str) -> InputError {
        InputError::new("invalid-input", message).with_file(&self.file).with_help(help)
    }

    fn error(&self, error: &rusqlite::Error) -> InputError {
        told(&self.file, error)
    }
}

fn recorded(row: &Row<'_>) -> rusqlite::Result<Recorded> {
    let origin: [Option<f64>; 3] = [row.get("x")?, row.get("y")?, row.get("z")?];
    Ok(Recorded {
        number: row.get("number")?,
        time: row.get("time")?,
        entry: Entry {
            name: row.get("name")?,
            measurement: row.get("measurement")?,
            fixture: row.get("fixture")?,
            status: row.get("status")?,
            units: row.get("units")?,
            origin: match origin {
                [Some(x), Some(y), Some(z)] => Some([x, y, z]),
                _ => None,
            },
            json: row.get("json")?,
        },
    })
}

/// What went wrong with a store, for its user.
fn told(file: &str, error: &rusqlite::Error) -> InputError {
    let (code, message, help) = match error.sqlite_error_code() {
        Some(ErrorCode::NotADatabase) => {
            ("invalid-input", format!("{file} is no store of results"), "name another file, or a new one")
        }
        Some(ErrorCode::DatabaseCorrupt) => {
            ("invalid-input", format!("{file} is damaged: {error}"), "restore it from a copy")
        }
        Some(ErrorCode::DatabaseBusy | ErrorCode::DatabaseLocked) => (
            "unwritable",
            format!("{file} is in use by another process, for {} seconds now", PATIENCE.as_secs()),
            "try again when that has ended",
        ),
        Some(ErrorCode::DiskFull) => (
            "unwritable",
            format!("no space is left for {file}"),
            "nothing was recorded: make room, and try again",
        ),
        Some(ErrorCode::ReadOnly | ErrorCode::PermissionDenied) => (
            "unwritable",
            format!("cannot write {file}: {error}"),
            "check the permissions of the file and of its folder",
        ),
        Some(ErrorCode::CannotOpen) => (
            "unreadable",
            format!("cannot open {file}: {error}"),
            "check the path, the folder and its permissions",
        ),
        _ => ("unreadable", format!("{file}: {error}"), "check the file and its folder"),
    };
    InputError::new(code, message).with_file(file).with_help(help)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(name: &str) -> Entry {
        Entry {
            name: Some(name.to_owned()),
            measurement: "m.toml".to_owned(),
            fixture: "cube".to_owned(),
            status: OK.to_owned(),
            units: "mm".to_owned(),
            origin: Some([0.1, -2.0, 3.0]),
            json: "{\"schema\": \"touchref.solution/1\"}\n".to_owned(),
        }
    }

    fn store() -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("h.db");
        (folder, path)
    }

    fn numbers(history: &History, selection: &Selection) -> Vec<i64> {
        history.select(selection).unwrap().iter().map(|recorded| recorded.number).collect()
    }

    #[test]
    fn what_was_appended_is_read_back() {
        let (_folder, path) = store();
        assert!(!History::is_at(&path));
        let mut history = History::append_to(&path).unwrap();
        let refusal = Entry { status: "ambiguous".to_owned(), origin: None, name: None, ..entry("") };
        for (number, entry) in [entry("a"), refusal.clone(), entry("b"), entry("a")].iter().enumerate() {
            assert_eq!(history.append(entry).unwrap(), i64::try_from(number).unwrap() + 1);
        }
        drop(history);
        assert!(History::is_at(&path));
        // One file at rest.
        assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
        let history = History::open(&path).unwrap();
        let all = history.select(&Selection::default()).unwrap();
        assert_eq!((&all[0].entry, &all[1].entry), (&entry("a"), &refusal));
        assert!(all[0].time.len() == 24 && all[0].time.ends_with('Z') && all[0].time <= all[3].time);
        let of = |selection| numbers(&history, &selection);
        let any = Selection::default();
        assert_eq!(of(Selection { last: Some(2), ..any.clone() }), [3, 4]);
        assert_eq!(of(Selection { name: Some("a".to_owned()), ..any.clone() }), [1, 4]);
        assert_eq!(of(Selection { status: Some(OK.to_owned()), last: Some(2), ..any.clone() }), [3, 4]);
        assert_eq!(of(Selection { fixture: Some("cylinder-plane".to_owned()), ..any.clone() }), [0; 0]);
        assert_eq!(of(Selection { number: Some(3), ..any.clone() }), [3]);
        let at = |time: &str| Some(time.to_owned());
        assert_eq!(
            of(Selection { since: at("2020-01-01"), until: at("9999-01-01T00:00"), ..any.clone() }),
            [1, 2, 3, 4]
        );
        assert_eq!(of(Selection { until: at("2020-01-01"), ..any.clone() }), [0; 0]);
        assert_eq!(of(Selection { since: at(&all[2].time), ..any.clone() }).last(), Some(&4));
        for wrong in ["2020", "yesterday", "2020-13-01", "now", ""] {
            let error = history.select(&Selection { since: at(wrong), ..any.clone() }).unwrap_err();
            assert_eq!(error.key(), Some("since"), "{wrong}");
        }
    }

    #[test]
    fn what_is_no_store_is_refused() {
        let (folder, path) = store();
        let message = |path: &Path| {
            [History::append_to(path), History::open(path)].map(|history| history.unwrap_err().to_string())
        };
        let other = folder.path().join("notes.txt");
        std::fs::write(&other, "not a database, but long enough to be taken for one").unwrap();
        assert!(message(&other).iter().all(|text| text.contains("is no store of results")));
        let foreign = folder.path().join("foreign.db");
        Connection::open(&foreign).unwrap().execute_batch("CREATE TABLE t (a)").unwrap();
        assert!(message(&foreign).iter().all(|text| text.contains("no history of touchref")));
        assert!(message(&folder.path().join("no/folder.db")).iter().all(|text| text.contains("cannot open")));
        assert!(
            History::open(&folder.path().join("none.db")).unwrap_err().to_string().contains("cannot open")
        );
        drop(History::append_to(&path).unwrap());
        Connection::open(&path).unwrap().pragma_update(None, "user_version", SCHEMA_VERSION + 1).unwrap();
        assert!(message(&path).iter().all(|text| text.contains("versions up to 1")));
    }

    #[test]
    fn a_full_disk_and_a_busy_store_lose_nothing() {
        let (_folder, path) = store();
        let mut history = History::append_to(&path).unwrap();
        assert_eq!(history.append(&entry("a")).unwrap(), 1);
        let pages: i64 = history.connection.pragma_query_value(None, "page_count", |row| row.get(0)).unwrap();
        history.connection.pragma_update(None, "max_page_count", pages).unwrap();
        let long = Entry { json: "x".repeat(100_000), ..entry("b") };
        let error = history.append(&long).unwrap_err();
        assert!(error.to_string().contains("no space is left") && error.code() == "unwritable", "{error}");
        let mut other = History::append_to(&path).unwrap();
        other.connection.busy_timeout(Duration::from_millis(1)).unwrap();
        let writing = history.connection.transaction_with_behavior(TransactionBehavior::Immediate).unwrap();
        let error = other.append(&entry("c")).unwrap_err();
        assert!(error.to_string().contains("in use"), "{error}");
        drop(writing);
        assert_eq!(other.append(&entry("c")).unwrap(), 2);
        assert_eq!(numbers(&other, &Selection::default()), [1, 2]);
    }

    #[test]
    fn many_may_append_at_once() {
        const EACH: usize = 5;
        let (_folder, path) = store();
        let append = || {
            // Each may be the one that makes the file.
            let mut history = History::append_to(&path).unwrap();
            (0..EACH).map(|_| history.append(&entry("a")).unwrap()).collect::<Vec<_>>()
        };
        let told: Vec<i64> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(append)).collect();
            threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
        });
        let mut told = told;
        told.sort_unstable();
        assert_eq!(told, numbers(&History::open(&path).unwrap(), &Selection::default()));
        assert_eq!(told.len(), 4 * EACH);
    }
}
