"""Validates what `touchref export --to qif` writes by the public XML schema of QIF 3.0.

    python3 tests/oracle/qif_schema.py PATH/QIFApplications/QIFDocument.xsd [TOUCHREF]

TOUCHREF is the command, `target/debug/touchref` unless it is given. Every example in `examples/` that gives a frame is
located, exported and validated by xmllint (Debian: libxml2-utils). Besides, each document is broken in several ways, and
the schema must notice: a validation that cannot fail proves nothing.

The schema is published by the Digital Metrology Standards Consortium at https://qifstandards.org/qif-download, as a folder
`QIFApplications` beside `QIFLibrary`. It imports the schema of XML signatures from the web; where that cannot be had, let its
<xs:import> name a copy beside it. Nothing of it is kept here.
"""

import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]

# What is changed in a document, and the error of the schema that this must give.
BREAKS = [
    ("<QPId>", "<QPId>x", "QPId"),
    ('versionQIF="3.0.0"', 'versionQIF="2.0.0"', "versionQIF"),
    ("FeatureNominalId>", "FeatureNominalIds>", "FeatureNominalId"),
    ("<CommonCoordinateSystemId>", "<CommonCoordinateSystemId>9", "Keyref"),
    ("<FeatureItemId>", "<FeatureItemId>9", "Keyref"),
    ("<Compensated>", "<Compensated>perhaps ", "Compensated"),
    ("<XDirection>", "<XDirection>0 ", "XDirection"),
]


def validate(schema, document):
    """The schema's complaints, empty for a valid document."""
    with tempfile.NamedTemporaryFile(suffix=".qif") as file:
        file.write(document)
        file.flush()
        run = subprocess.run(
            ["xmllint", "--nonet", "--noout", "--schema", schema, file.name], capture_output=True, text=True
        )
    if run.returncode not in (0, 3):
        sys.exit(f"xmllint could not validate:\n{run.stderr}")
    return "" if run.returncode == 0 else run.stderr


def documents(command):
    """Each example, exported, by a name for it."""
    for file in sorted((ROOT / "examples").glob("**/*.toml")):
        for solver in ("least-squares", "closed-form", "robust"):
            located = subprocess.run(
                [command, "locate", file, "--solver", solver, "--format", "json"], capture_output=True
            )
            if located.returncode == 0:
                exported = subprocess.run(
                    [command, "export", "-", "--to", "qif"], input=located.stdout, capture_output=True, check=True
                )
                yield f"{file.name} by {solver}", exported.stdout


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    schema = sys.argv[1]
    command = sys.argv[2] if len(sys.argv) == 3 else ROOT / "target" / "debug" / "touchref"
    count = 0
    for name, document in documents(command):
        complaints = validate(schema, document)
        if complaints:
            sys.exit(f"{name} is not valid:\n{complaints}")
        count += 1
        print(f"valid: {name}, {len(document)} bytes")
    for before, after, word in BREAKS:
        broken = document.replace(before.encode(), after.encode())
        complaints = validate(schema, broken)
        if broken == document or word not in complaints:
            sys.exit(f"the schema does not notice {after}: {complaints}")
    print(f"{count} documents are valid; {len(BREAKS)} broken ones are not")


if __name__ == "__main__":
    main()
