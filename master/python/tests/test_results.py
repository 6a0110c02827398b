"""Histories, fields and report of a run, against the files that VTK and csv read."""

import csv
import sys
from pathlib import Path

import crumple
import numpy
import pytest
import pyvista
from crumple.results import verdict


def test_histories_are_the_columns_of_the_files(results: crumple.Results) -> None:
    """Each value is that of the csv module of Python."""
    assert {"history", "parts", "workers"} <= set(results.tables)
    for name in results.tables:
        with (results.folder / f"{name}.csv").open() as file:
            rows = list(csv.reader(file))
        frame = results.history(name)
        assert list(frame.columns) == rows[0]
        assert len(frame) == len(rows) - 1 > 0
        last = [float(value) for value in rows[-1] if _is_number(value)]
        assert [float(v) for v in frame.iloc[-1] if _is_number(str(v))] == last
    assert results.history("parts.csv").equals(results.history("parts"))


def test_equal_bars_exchange_their_momentum(results: crumple.Results) -> None:
    """The first bar stops, the second leaves with its speed (Graff 1975, chapter 2)."""
    parts = results.history("parts")
    momentum = parts.pivot(index="time [ms]", columns="name", values="momentum x [kg mm/ms]")
    assert abs(momentum["two"].iloc[0]) < 0.02 * momentum["one"].iloc[0]
    assert abs(momentum["one"].iloc[-1]) < 0.02 * momentum["one"].iloc[0]


def test_fields_are_those_that_vtk_reads(results: crumple.Results) -> None:
    """By ids of nodes and elements, all arrays equal those of the files as VTK joins them."""
    steps = pyvista.get_reader(results.folder / "fields/fields.pvd")
    assert results.times == steps.time_values
    steps.set_active_time_point(len(results.times) - 1)
    expected = steps.read()[0]
    found = results.fields()
    assert found.time == results.times[-1] > 0
    place = {node: row for row, node in enumerate(found["node_id"])}
    rows = [place[node] for node in expected["node_id"]]
    assert len(set(rows)) == len(found.points)
    assert numpy.array_equal(found.points[rows], expected.points)
    for name in set(expected.point_data) - {"vtkOriginalPointIds", "vtkGhostType"}:
        # Workers write the same values of a node that they share.
        assert numpy.array_equal(found[name][rows], expected.point_data[name]), name
    row_of = {element: row for row, element in enumerate(found["element_id"])}
    cells = [row_of[element] for element in expected["element_id"]]
    assert sorted(cells) == list(range(len(found.types)))
    for name in set(expected.cell_data) - {"vtkOriginalCellIds", "vtkGhostType"}:
        assert numpy.array_equal(found[name][cells], expected.cell_data[name]), name
    centres = results.grid().cell_centers().points[cells]
    assert numpy.array_equal(centres, expected.cell_centers().points)


def test_fields_do_not_depend_on_the_workers(results: crumple.Results, tmp_path: Path) -> None:
    """One worker and two give the same arrays with the same bits."""
    job = results.provenance["starts"][0]["job_file"]
    changes = {"output.field_interval": 0.00623}
    alone = crumple.run(job, workers=1, out=tmp_path / "out", set=changes, progress=False)
    one, two = alone.fields(), results.fields()
    assert len(numpy.unique(two["worker"])) == 2
    for name in ("points", "connectivity", "offsets", "types"):
        assert numpy.array_equal(getattr(one, name), getattr(two, name)), name
    for name in {*one.point_data, *one.cell_data} - {"worker", "class"}:
        assert numpy.array_equal(one[name], two[name]), name
    assert alone.summary["state_digest"] == results.summary["state_digest"]


def test_warnings_are_lines(bars: Path, tmp_path: Path) -> None:
    """A wall that nothing touches gives the warning of the summary, also in a notebook."""
    job = crumple.Job.read(bars)
    job["wall"] = [{"name": "far", "point": [-1e3, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}]
    far = crumple.run(job, workers=1, out=tmp_path / "out", progress=False)
    (known,) = far.summary["warnings"]
    assert known["kind"] == "unused_wall"
    (line,) = far.warnings
    assert line == known["message"]
    assert line.startswith("at time ")
    assert known["what"] in line
    assert line.endswith(known["cure"])
    assert "no node has touched these walls: far" in far._repr_html_()


def test_errors_name_what_there_is(results: crumple.Results, tmp_path: Path) -> None:
    """A wrong name or number gets the ones that there are."""
    with pytest.raises(FileNotFoundError, match="has contact_pairs, contacts, history, parts"):
        results.history("walls")
    with pytest.raises(IndexError, match="has 11 steps"):
        results.fields(11)
    with pytest.raises(KeyError, match="there are.*von_mises"):
        results.fields()["mises"]
    with pytest.raises(FileNotFoundError, match="has no results"):
        crumple.open(tmp_path)
    (tmp_path / "history.csv").write_text("time\n")
    unfinished = crumple.open(tmp_path)
    assert (unfinished.status, unfinished.times) == ("unfinished", [])
    with pytest.raises(FileNotFoundError, match="crumple report"):
        _ = unfinished.report


def test_a_damaged_field_file_is_named(results: crumple.Results, tmp_path: Path) -> None:
    """A file that ends early is an error with its name."""
    import shutil

    copy = tmp_path / "copy"
    shutil.copytree(results.folder, copy)
    piece = sorted(copy.glob("fields/step_*/piece_000.vtu"))[-1]
    piece.write_bytes(piece.read_bytes()[:-200])
    with pytest.raises(ValueError, match="piece_000.vtu: ends within array"):
        crumple.open(copy).fields()


def test_notebooks_show_summary_and_report(results: crumple.Results) -> None:
    """The summary is a table with escaped text, the report a frame with the whole page."""
    import html

    assert "<th>status</th><td>completed, end_time</td>" in results._repr_html_()
    frame = results.report._repr_html_()
    page = frame.split('srcdoc="')[1].split('"')[0]
    assert html.unescape(page) == (results.folder / "report.html").read_text()


REQUIREMENTS = [
    {
        "name": "momentum",
        "quantity": {
            "table": "parts",
            "of": "two",
            "history": "momentum",
            "stat": "max",
            "filter": "CFC 1000",
        },
        "below": 0.0,
    },
    {
        "name": "mass",
        "quantity": {"table": "parts", "of": "two", "history": "mass", "stat": "min"},
        "above": 0.0,
    },
]


def test_a_requirement_that_is_not_met_is_a_warning(
    bars: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """It is logged by run and by open, and shown in notebooks; one that is met is only shown."""
    job = crumple.Job.read(bars)
    job["require"] = REQUIREMENTS
    changes = {"output.history_interval": 0.001, "output.field_interval": -1}

    def run() -> crumple.Results:
        return crumple.run(job, out=tmp_path, set=changes, report=False, progress=False)

    for look in (run, lambda: crumple.open(tmp_path)):
        caplog.clear()
        with caplog.at_level("WARNING", "crumple"):
            done = look()
        assert [one["is_met"] for one in done.requirements] == [False, True]
        failed, met = (verdict(one) for one in done.requirements)
        said = [record.getMessage() for record in caplog.records if record.name == "crumple"]
        assert said.count(failed) == 1 and met not in said
        assert failed.startswith("FAIL  momentum: ") and failed.endswith("ms (required: below 0)")
        assert " kg mm/ms at time " in failed
        assert f"<th>requirements</th><td>{failed}; {met}</td>" in done._repr_html_()


def test_a_missing_package_is_named(
    results: crumple.Results, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without pandas or pyvista the error says how to install them."""
    for package, extra, call in [
        ("pandas", "histories", lambda: results.history()),
        ("pyvista", "fields", lambda: results.grid()),
    ]:
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(ImportError, match=rf"{package}: pip install 'crumple\[{extra}\]'"):
            call()


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
