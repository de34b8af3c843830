"""The frames of many placements by Polars, from a file of any length.

    python polars_frames.py TOUCHES.parquet FRAMES.parquet
    python polars_frames.py                                    tries it on a file of its own

The table is read, sorted and located in parts; placements may begin in one part and end in the next.
"""

import sys
import tempfile
from pathlib import Path

import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import touchref

from touches import FIXTURE, PROBE, on_one_machine, touches


def frames(source: Path, target: Path, fixture: touchref.Fixture, rows: int = 100_000, **probe: float) -> int:
    """Writes one row a placement, as ``touchref.batch`` gives it; returns how many."""
    parts = pl.scan_parquet(source).sort("placement", "touch").collect_batches(chunk_size=rows, maintain_order=True)
    writer, count = None, 0
    for found in touchref.batches(parts, fixture, **probe):
        table = pa.table(found)
        writer = writer or pq.ParquetWriter(target, table.schema)
        writer.write_table(table)
        count += table.num_rows
    if writer:
        writer.close()
    return count


def main() -> None:
    if len(sys.argv) == 3:
        frames(Path(sys.argv[1]), Path(sys.argv[2]), FIXTURE, **PROBE)
        return
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "touches.parquet"), Path(folder, "frames.parquet")
        table = touches(2000)
        pq.write_table(table, source)
        count = frames(source, target, FIXTURE, rows=1000, **PROBE)
        same = pq.read_table(target).equals(on_one_machine(table))
    print(f"Polars {pl.__version__}: {count} frames, the same as on one machine: {same}")
    sys.exit(not same)


if __name__ == "__main__":
    main()
