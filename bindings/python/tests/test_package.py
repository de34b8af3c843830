"""Results as objects, classes of plugins and their stubs, waiting, and batches."""

from __future__ import annotations

import json
import multiprocessing
import os
import pickle
import runpy
import signal
import subprocess
import sys
import threading
import time
from dataclasses import fields
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import measurements
import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest
import touchref
import touchref._touchref
from test_same_as_command import table

PAPER = "examples/nederbragt-ravani.toml"


@pytest.fixture()
def paper(root: Path) -> touchref.Solution:
    return touchref.Measurement.read(root / PAPER).locate()


def test_frame(paper: touchref.Solution) -> None:
    frame = paper.frame
    assert frame.matrix.shape == (4, 4) and not frame.matrix.flags.writeable
    np.testing.assert_array_equal(frame.matrix[:3, 3], frame.origin)
    np.testing.assert_array_equal(frame.matrix[:3, :3].T, [frame.x_axis, frame.y_axis, frame.z_axis])
    # The rotation of the quaternion, by its formula.
    x, y, z, w = frame.quaternion
    column = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
    np.testing.assert_allclose(column, frame.z_axis, atol=1e-15)
    points = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    np.testing.assert_allclose((frame.matrix @ [1, 2, 3, 1])[:3], frame.to_parent(points)[0], rtol=1e-15)
    np.testing.assert_allclose(frame.to_fixture(frame.to_parent(points)), points, atol=1e-14)
    assert frame.dialect("kuka").startswith("{")
    assert frame.dialect_note("kuka")["units"] == "mm, degrees"


def test_solution(paper: touchref.Solution) -> None:
    covariance = paper.covariance
    assert covariance is not None and covariance.shape == (6, 6)
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-12)
    assert np.linalg.eigvalsh(covariance).min() > 0
    assert [root.selected for root in paper.roots].count(True) == 1 and len(paper.roots) == 4
    assert paper.residuals.shape == (7,) and paper.touches[6].surface == "plane"
    assert paper.trust.up_to_sigma is not None and paper.trust.up_to_sigma > 0.00005
    assert paper.fixture == touchref.CylinderPlane(radius=1.0, angle_deg=45.0)
    assert (paper.units, paper.solver, paper.sigma_source) == ("mm", "least-squares", "given")


def test_without_sigma(root: Path) -> None:
    text = (root / PAPER).read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("sigma")]
    solution = touchref.Measurement.from_toml("\n".join(lines)).locate()
    assert solution.normalized is None and solution.chi_square is None and solution.p_value is None
    six = touchref.locate(
        touchref.Cube(edge=50),
        [[50, 10, 10], [50, 40, 10], [50, 10, 40], [10, 50, 10], [10, 50, 40], [10, 10, 50]],
        ["+x", "+x", "+x", "+y", "+y", "+z"],
    )
    assert six.covariance is None and six.sigma is None


def test_objects_have_what_the_schema_has(root: Path) -> None:
    """Every key of ``touchref.solution/1`` is an attribute, so that a new key is not forgotten."""
    schema = json.loads((root / "docs/schema/solution.json").read_text(encoding="utf-8"))
    definitions = schema["$defs"]
    classes = {
        "AdjustmentRecord": touchref.Adjustment,
        "IterationRecord": touchref.Iteration,
        "ObservabilityRecord": touchref.Observability,
        "ProbeRecord": touchref.Probe,
        "ResidualRecord": touchref.Touch,
        "RootRecord": touchref.Root,
        "SecondMinimumRecord": touchref.SecondMinimum,
        "TrustRecord": touchref.Trust,
        "TwistRecord": touchref.Twist,
        "WarningRecord": touchref.Warning,
    }
    for name, cls in classes.items():
        # The steps of an iteration are told where somebody asks, on the command line.
        assert {field.name for field in fields(cls)} == set(definitions[name]["properties"]) - {"history"}, name
    frame = {"quaternion" if key == "quaternion_xyzw" else key for key in definitions["FrameRecord"]["properties"]}
    assert {field.name for field in fields(touchref.Frame)} == frame
    elsewhere = {"schema": "document", "dialects": "to_json", "dialect_notes": "to_json"}
    for key in schema["properties"]:
        assert hasattr(touchref.Solution, elsewhere.get(key, key)), key


def test_a_class_for_every_plugin(command: Any) -> None:
    _, printed = command("list", "--format", "json")
    listed = json.loads(printed)
    for kind, known in (
        ("fixtures", touchref.FIXTURES),
        ("solvers", touchref.SOLVERS),
        ("dialects", touchref.DIALECTS),
    ):
        assert [plugin["name"] for plugin in listed[kind]] == list(known)
    for name in (*touchref.FIXTURES, *touchref.SOLVERS):
        cls = getattr(touchref, name.title().replace("-", ""))
        assert issubclass(cls, (touchref.Fixture, touchref.Solver)) and cls.__doc__
    assert isinstance(touchref.fixture("cube", edge=1), touchref.Cube)
    assert touchref.fixture("cube", edge=1) != touchref.Cube(edge=2)


def test_stubs_are_current(root: Path) -> None:
    """Else: ``python bindings/python/stubs.py bindings/python/python/touchref/plugins.pyi``."""
    written = (root / "bindings/python/python/touchref/plugins.pyi").read_text(encoding="utf-8")
    assert written == runpy.run_path(str(root / "bindings/python/stubs.py"))["text"]()


def test_pickling(paper: touchref.Solution) -> None:
    plate = {"name": "p", "type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1]}
    for one in (
        touchref.CylinderPlane(radius=touchref.Uncertain(1, 0.1), angle_deg=45, bore=True),
        touchref.Composite(surface=[plate, {**plate, "name": "q", "normal": [1, 0, 0]}], free=["y"], size=10),
        touchref.LeastSquares(margin="near"),
    ):
        assert pickle.loads(pickle.dumps(one)) == one
    again = pickle.loads(pickle.dumps(paper))
    assert again.to_json() == paper.to_json()


def test_files(paper: touchref.Solution, tmp_path: Path) -> None:
    path = tmp_path / "result.json"
    path.write_text(paper.to_json(), encoding="utf-8")
    again = touchref.Solution.read(path)
    assert again.to_json() == paper.to_json()
    np.testing.assert_allclose(json.loads(again.frame.dialect("matrix")), paper.frame.matrix, rtol=0, atol=1e-15)


def test_near(root: Path) -> None:
    """Any form of the frame is the same frame; it decides where touches do not."""
    measurement = touchref.Measurement.read(root / "examples/cube.toml")
    solution = measurement.locate()
    frame = solution.frame
    for near in (solution, frame, frame.matrix, [*frame.origin, *frame.quaternion], frame.matrix.tolist()):
        found = measurement.locate(near=near)
        np.testing.assert_allclose(found.frame.matrix, frame.matrix, rtol=0, atol=1e-9)


def test_near_decides() -> None:
    """Planes that end nowhere may be touched from either side: two frames, of which the nearer one is meant."""
    names = [("a", [1, 0, 0]), ("b", [0, 1, 0]), ("c", [0, 0, 1])]
    planes = [{"name": name, "type": "plane", "point": [0, 0, 0], "normal": normal} for name, normal in names]
    fixture = touchref.Composite(surface=planes, size=50)
    touches = [[0, 10, 10], [0, 40, 10], [0, 10, 40], [10, 0, 10], [10, 0, 40], [10, 10, 0], [40, 10, 0]]
    measurement = touchref.Measurement(fixture, touches, list("aaabbcc"), sigma=0.01)
    with pytest.raises(touchref.Refused) as caught:
        measurement.locate()
    assert caught.value.code == "ambiguous"
    for turn in ([0, 0, 0, 1], [1, 0, 0, 0], [0, 1, 0, 0]):
        near = measurement.locate(near=[0.1, 0, 0, *turn])
        np.testing.assert_allclose(np.abs(near.frame.quaternion @ turn), 1.0, atol=1e-6)


def test_labels_that_are_open(root: Path) -> None:
    """``robust`` finds the surface of a touch whose label is open; the others ask for it."""
    cube = touchref.Measurement.read(root / "examples/cube.toml")
    touches: Any = [touch.at for touch in cube.locate().touches]
    labels = ["+z", "+z", "?", "+x", "+x", "+x", "+y", "+y", "+y"]
    arguments: Any = {"tip_radius": 1.5, "sigma": 0.005}
    solution = touchref.locate(cube.fixture, touches, labels, solver="robust", **arguments)
    assert [(touch.surface, touch.label_found) for touch in solution.touches][1:3] == [("+z", False), ("+z", True)]
    with pytest.raises(touchref.InputError) as caught:
        touchref.locate(cube.fixture, touches, labels, **arguments)
    assert caught.value.code == "unknown-surface"


def test_notebook(paper: touchref.Solution) -> None:
    html = paper._repr_html_()
    assert html.startswith("<div>") and "Frame of cylinder-plane" in html
    ElementTree.fromstring(html.replace("&plusmn;", "+-"))
    svg = paper.picture()
    assert svg is not None
    ElementTree.fromstring(svg)
    assert repr(paper).startswith("<Solution: cylinder-plane at [2.90003, 3.80003, 4.22489] mm, 7 touches")


def test_frames_share_their_memory() -> None:
    """Two tables of the same frames have the same buffers: nothing is copied on the way out."""
    fixture = measurements.fixtures()["cube"][0]
    frames = touchref.batch(table("cube"), fixture, tip_radius=1.5, sigma=0.005)
    one, two = pa.table(frames), pa.table(frames)
    addresses = [[chunk.buffers()[1].address for chunk in t["x"].chunks] for t in (one, two)]
    assert addresses[0] == addresses[1]
    assert len(frames) == one.num_rows == sum(frames.counts.values())
    assert f"{frames.counts['ok']} ok" in repr(frames)


def test_tables_of_any_library() -> None:
    fixture = measurements.fixtures()["cube"][0]
    touches = table("cube")
    expected = pa.table(touchref.batch(touches, fixture, tip_radius=1.5, sigma=0.005))

    def same(given: Any) -> bool:
        found = pa.table(touchref.batch(given, fixture, tip_radius=1.5, sigma=0.005))
        return bool(found.combine_chunks().equals(expected.combine_chunks()))

    assert same(pl.DataFrame(touches)) and same(touches.to_reader()) and same(touches.combine_chunks().to_batches()[0])
    frames = touchref.batch(touches, fixture, tip_radius=1.5, sigma=0.005)
    assert pl.DataFrame(frames)["status"].to_list() == expected["status"].to_pylist()
    if not hasattr(pd.DataFrame, "from_arrow"):
        pytest.skip("pandas 3 takes Arrow's streams")
    # To pandas a coordinate that is NaN is missing: the same refusal, in other words.
    of_pandas = touchref.batch(pd.DataFrame.from_arrow(touches), fixture, tip_radius=1.5, sigma=0.005)
    assert pa.table(of_pandas).drop_columns("message").equals(expected.drop_columns("message"))
    assert pd.DataFrame.from_arrow(frames)["status"].tolist() == expected["status"].to_pylist()


@pytest.mark.parametrize("rows", [1, 7, 100])
def test_parts(rows: int) -> None:
    """However the table is cut, placements are whole."""
    fixture = measurements.fixtures()["cube"][0]
    touches = table("cube").slice(0, 400)
    whole = pa.table(touchref.batch(touches, fixture, tip_radius=1.5, sigma=0.005))
    parts = list(touchref.batches(touches.to_batches(rows), fixture, tip_radius=1.5, sigma=0.005, threads=1))
    assert pa.concat_tables(map(pa.table, parts)).combine_chunks().equals(whole.combine_chunks())


def test_parts_that_do_not_fit() -> None:
    fixture = measurements.fixtures()["cube"][0]
    touches = table("cube")
    with pytest.raises(touchref.InputError, match="those before had"):
        list(touchref.batches([touches, touches.drop_columns(["sigma"])], fixture))
    with pytest.raises(touchref.InputError, match="comes again"):
        list(touchref.batches([touches, touches], fixture))

    def breaks() -> Any:
        yield touches.to_batches()[0]
        raise OSError("the disk is gone")

    with pytest.raises(touchref.InputError, match="the disk is gone"):
        touchref.batch(pa.RecordBatchReader.from_batches(touches.schema, breaks()), fixture)
    with pytest.raises(OSError, match="the disk is gone"):
        list(touchref.batches(breaks(), fixture))


def test_fast_frames_are_the_same_to_a_millionth() -> None:
    fixture = measurements.fixtures()["cylinder-plane"][0]
    touches = table("cylinder-plane")
    alone, fast = (
        pa.table(touchref.batch(touches, fixture, sigma=0.005, tip_radius=1.5, fast=fast)) for fast in (False, True)
    )
    assert alone["status"] == fast["status"] and alone["placement"] == fast["placement"]
    deviations = np.sqrt(alone["cov_x_x"].drop_null().to_numpy())
    off = alone["x"].drop_null().to_numpy() - fast["x"].drop_null().to_numpy()
    assert (np.abs(off) < 1e-6 * deviations).all()


def test_a_stream_that_failed_has_ended() -> None:
    """Else the touches before the failure would be a placement."""
    fixture = measurements.fixtures()["cube"][0]
    touches = table("cube").slice(0, 100)
    native = touchref._touchref.Measurement.of(fixture.kind, fixture.parameters, "mm", (1.5, 0.0), 0.005, None)
    stream = touchref._touchref.Stream(native, None, {}, None, False, 1)
    stream.add(touches)
    with pytest.raises(touchref.InputError, match="comes again"):
        stream.add(touches)
    for call in (stream.finish, lambda: stream.add(touches)):
        with pytest.raises(touchref.InputError, match="has ended"):
            call()


def test_no_touches() -> None:
    """An empty part of a table, as engines hand over, has no frames."""
    fixture = measurements.fixtures()["cube"][0]
    touches = table("cube")
    assert list(touchref.batches([], fixture)) == []
    assert len(touchref.batch(touches.slice(0, 0), fixture)) == 0


def test_a_measurement_states_the_probe(root: Path) -> None:
    measurement = touchref.Measurement.read(root / "examples/cube.toml")
    touches = table("cube")
    stated = touchref.batch(touches, measurement.fixture, tip_radius=1.5, sigma=0.005)
    assert pa.table(touchref.batch(touches, measurement)).equals(pa.table(stated))
    with pytest.raises(touchref.InputError, match="beside a measurement"):
        touchref.batch(touches, measurement, sigma=1.0)


def many(copies: int) -> pa.Table:
    """A long table."""
    touches = table("cylinder-plane")
    names = touches["placement"].to_pylist()
    return pa.concat_tables(
        touches.set_column(0, "placement", pa.array([f"{copy} {name}" for name in names])) for copy in range(copies)
    )


def test_other_threads_run() -> None:
    touches, fixture = many(10), measurements.fixtures()["cylinder-plane"][0]
    ended, beats = threading.Event(), []

    def beat() -> None:
        while not ended.wait(0.005):
            beats.append(time.perf_counter())

    thread = threading.Thread(target=beat)
    thread.start()
    began = time.perf_counter()
    touchref.batch(touches, fixture, tip_radius=1.5, sigma=0.005, threads=1)
    took = time.perf_counter() - began
    ended.set()
    thread.join()
    during = [at for at in beats if began < at < began + took]
    assert len(during) > 0.2 * took / 0.005, (len(during), took)


LONG = """
import sys, signal, time
sys.path.insert(0, {tests!r})
import numpy as np, touchref, measurements, test_package
fixture = measurements.fixtures()["cylinder-plane"][0]
if {what!r} == "batch":
    touches = test_package.many(400)
    call = lambda: touchref.batch(touches, fixture, tip_radius=1.5, sigma=0.005)
else:
    placement = measurements.placements("composite")[0]
    composite = measurements.fixtures()["composite"][0]
    touches = np.repeat(placement.touches, 400, axis=0)
    call = lambda: touchref.locate(composite, touches, placement.labels * 1 and [l for l in placement.labels for _ in range(400)], sigma=0.005, solver="global")
print("begun", flush=True)
try:
    call()
    print("ended")
except KeyboardInterrupt:
    print("interrupted", time.time())
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("what", ["batch", "locate"])
def test_interrupts(what: str) -> None:
    """Ctrl-C ends the wait for long work at once."""
    program = LONG.format(tests=str(Path(__file__).parent), what=what)
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "begun\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    sent = time.time()
    told = process.stdout.readline().split()
    process.kill()
    process.wait()
    assert told[0] == "interrupted", told
    assert float(told[1]) - sent < 0.5


def _in_a_child(_: int) -> int:
    return len(touchref.batch(table("cube"), measurements.fixtures()["cube"][0], tip_radius=1.5, sigma=0.005))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_forked_processes() -> None:
    """What was used before a fork works after it."""
    expected = _in_a_child(0)
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(_in_a_child, range(2)).get(timeout=60) == [expected] * 2
