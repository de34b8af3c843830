"""The frames of many placements by Apache Spark.

    spark-submit spark_frames.py TOUCHES.parquet FRAMES.parquet
    python spark_frames.py                                        tries it on two local cores

``mapInArrow`` hands over partitions in parts of some thousand rows, and neither partitions nor parts know of placements.
So the rows of a placement come into one partition (``repartition``), and stand together there in the order in which they
were measured (``sortWithinPartitions``); ``touchref.batches`` puts together what the parts cut through.
"""

import sys
from collections.abc import Iterator

import pyarrow as pa
import touchref
from pyspark.sql import DataFrame, SparkSession
from pyspark.sql.pandas.types import from_arrow_schema

from touches import FIXTURE, PROBE, on_one_machine, touches


def frames(table: DataFrame, fixture: touchref.Fixture, **probe: float) -> DataFrame:
    """One row a placement, as ``touchref.batch`` gives it."""

    def located(parts: Iterator[pa.RecordBatch]) -> Iterator[pa.RecordBatch]:
        # Spark has one task a core already.
        for found in touchref.batches(parts, fixture, threads=1, **probe):
            yield from pa.table(found).to_batches()

    none = pa.table({"placement": [""], "surface": [""], "x": [0.0], "y": [0.0], "z": [0.0]}).slice(0, 0)
    schema = from_arrow_schema(pa.table(touchref.batch(none, fixture)).schema)
    ordered = table.repartition("placement").sortWithinPartitions("placement", "touch")
    return ordered.mapInArrow(located, schema)


def main() -> None:
    if len(sys.argv) == 3:
        spark = SparkSession.builder.getOrCreate()
        frames(spark.read.parquet(sys.argv[1]), FIXTURE, **PROBE).write.parquet(sys.argv[2])
        return
    spark = (
        SparkSession.builder.master("local[2]")
        .config("spark.ui.enabled", False)
        .config("spark.sql.shuffle.partitions", 4)
        # Small, so that parts cut through placements here, too.
        .config("spark.sql.execution.arrow.maxRecordsPerBatch", 100)
        .getOrCreate()
    )
    table = touches(2000)
    found = frames(spark.createDataFrame(table), FIXTURE, **PROBE).toArrow()
    expected = on_one_machine(table)
    same = found.sort_by("placement").cast(expected.schema).equals(expected)
    print(f"Spark {spark.version}: {found.num_rows} frames, the same as on one machine: {same}")
    spark.stop()
    sys.exit(not same)


if __name__ == "__main__":
    main()
