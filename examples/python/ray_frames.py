"""The frames of many placements by Ray Data.

    python ray_frames.py        tries it on two local cores

``map_batches`` cuts its input into blocks that know nothing of placements. So each placement is put into one of some
bins, and ``map_groups`` hands over whole bins: many placements at a time, none of them cut.
"""

import sys

import pyarrow as pa
import pyarrow.compute as pc
import ray
import touchref
from ray.data import Dataset

from touches import FIXTURE, PROBE, on_one_machine, touches


def frames(table: Dataset, fixture: touchref.Fixture, bins: int, **probe: float) -> Dataset:
    """One row a placement, as ``touchref.batch`` gives it."""

    def binned(block: pa.Table) -> pa.Table:
        # A number that is the same in every process, as that of Python's `hash` is not.
        numbers = [int.from_bytes(name.encode()[-6:], "big") % bins for name in block["placement"].to_pylist()]
        return block.append_column("bin", pa.array(numbers))

    def located(touched: pa.Table) -> pa.Table:
        ordered = touched.drop_columns(["bin"]).sort_by([("placement", "ascending"), ("touch", "ascending")])
        return pa.table(touchref.batch(ordered, fixture, threads=1, **probe))

    in_bins = table.map_batches(binned, batch_format="pyarrow")
    return in_bins.groupby("bin", num_partitions=bins).map_groups(located, batch_format="pyarrow")


def main() -> None:
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    table = touches(2000)
    dataset = ray.data.from_arrow([table.slice(first, 1000) for first in range(0, table.num_rows, 1000)])
    parts = [ray.get(part) for part in frames(dataset, FIXTURE, 8, **PROBE).to_arrow_refs()]
    expected = on_one_machine(table)
    found = pa.concat_tables(part for part in parts if part.num_rows)
    found = found.take(pc.sort_indices(found["placement"])).cast(expected.schema)
    same = found.combine_chunks().equals(expected.combine_chunks())
    print(f"Ray {ray.__version__}: {found.num_rows} frames, the same as on one machine: {same}")
    ray.shutdown()
    sys.exit(not same)


if __name__ == "__main__":
    main()
