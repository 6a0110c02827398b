"""Jobs as tables: keys and types are checked, files stay those of the job."""

from pathlib import Path

import crumple
import numpy
import pytest


def test_a_job_is_written_as_it_was_read(bars: Path, tmp_path: Path) -> None:
    """A copy of a job, read again, is the same table."""
    job = crumple.Job.read(bars)
    assert (job.name, job["part"][1]["name"]) == ("bars", "two")
    again = crumple.Job.read(job.write(tmp_path / "copy.toml"))
    assert dict(again) == dict(job)
    assert job.problems() == []


def test_files_of_a_job_are_found_from_its_new_folder(tmp_path: Path) -> None:
    """Names of mesh files, also of added ones, hold in the folder of the written job."""
    there = tmp_path / "there"
    there.mkdir()
    text = 'end_time = 1.0\n[mesh]\nfile = "p.msh"\n[[mesh.add]]\nfile = "a.stl"\n'
    (there / "job.toml").write_text(text)
    written = crumple.Job.read(there / "job.toml").write(tmp_path / "here" / "job.toml")
    mesh = crumple.Job.read(written)["mesh"]
    assert mesh["file"] == "../there/p.msh"
    assert mesh["add"][0]["file"] == "../there/a.stl"


def test_a_wrong_key_or_type_is_refused_when_it_is_set(bars: Path) -> None:
    """The error has the key, and the job is unchanged."""
    job = crumple.Job.read(bars)
    before = job.toml()
    for key, value, words in [
        ("end_tme", 1.0, "end_tme.*end_time"),
        ("end_time", "soon", "end_time"),
        ("part", [{"id": 1, "materal": "steel"}], "material"),
    ]:
        with pytest.raises(crumple.JobError, match=words):
            job[key] = value
    with pytest.raises(crumple.JobError) as raised:
        crumple.Job({"end_time": "soon", "titel": "x"})
    assert {one.key for one in raised.value.findings} == {"end_time", "titel"}
    assert job.toml() == before


def test_a_table_without_its_keys_is_not_written(tmp_path: Path) -> None:
    """Keys that are missing are reported all at once, and no file is made."""
    job = crumple.Job()
    job["title"] = "empty"
    with pytest.raises(crumple.JobError, match="end_time") as raised:
        job.write(tmp_path / "job.toml")
    assert {one.key for one in raised.value.findings} >= {"end_time", "mesh"}
    assert not (tmp_path / "job.toml").exists()


def test_numbers_of_numpy_are_numbers(bars: Path) -> None:
    """Arrays and scalars of NumPy are written as lists and numbers."""
    job = crumple.Job.read(bars)
    job["end_time"] = numpy.float64(0.01)
    job["part"][0]["points"] = numpy.int32(3)
    job["output"] = {"field_times": numpy.linspace(0, 0.01, 3), "d3plot": numpy.bool_(False)}
    read = crumple.Job({}, name="x")
    read["output"] = job["output"]
    assert "points = 3" in job.toml()
    assert job["output"] == {"field_times": [0.0, 0.005, 0.01], "d3plot": False}


def test_files_of_a_job_are_found_from_another_folder(tmp_path: Path) -> None:
    """A mesh file is named relative to the new job file."""
    source = tmp_path / "source"
    source.mkdir()
    (source / "mesh.toml").write_text("nodes = []\n")
    job = crumple.Job({"mesh": {"file": "mesh.toml"}, "end_time": 1.0}, folder=source)
    written = crumple.Job.read(job.write(tmp_path / "a/b/job.toml"))
    assert written["mesh"]["file"] == "../../source/mesh.toml"
    assert job["mesh"]["file"] == "mesh.toml"


def test_check_returns_warnings_or_raises_all_errors(bars: Path) -> None:
    """A file and a table have the same problems; each has its line, key or argument."""
    good = crumple.check(bars, workers=2)
    assert good.memory_mb > 0 and "mass" in str(good)
    job = crumple.Job.read(bars)
    # Costs are measured, so that they differ.
    described = str(crumple.check(job, workers=2)).splitlines()[:20]
    assert described == str(good).splitlines()[:20]
    job["part"][0]["material"] = "stel"
    job["part"][1]["thickness"] = -1.0
    with pytest.raises(crumple.JobError, match="stel") as raised:
        crumple.check(job, set={"end_time": -1})
    findings = raised.value.findings
    assert len(findings) == 3 and all(one.severity == "error" for one in findings)
    assert [one.change for one in findings if one.change] == ["end_time=-1"]
    lines = job.toml().splitlines()
    assert all(one.text == lines[one.line - 1] for one in findings if one.line)


def test_a_job_takes_materials_of_the_library_and_includes_others(tmp_path: Path) -> None:
    """Keys from an included file or the library are not missing; names of files stay right."""
    (tmp_path / "steel.toml").write_text('[[material]]\nname = "steel"\nuse = "steel DP600"\n')
    text = 'title = "x"\nunits = "mm, ms, kg"\ninclude = ["steel.toml"]\n'
    (tmp_path / "job.toml").write_text(text)
    job = crumple.Job.read(tmp_path)
    moved = job.write(tmp_path / "below" / "job.toml")
    assert crumple.Job.read(moved)["include"] == ["../steel.toml"]
    library = crumple.Job({"units": "mm, ms, kg"})
    library["material"] = [{"name": "steel", "use": "steel DP600"}]
    with pytest.raises(crumple.JobError, match="DP60"):
        library["material"] = [{"name": "steel", "use": "steel DP60"}]
    (tmp_path / "plate.k").write_text("*KEYWORD\n*END\n")
    deck = crumple.Job.read(tmp_path / "plate.k")
    assert deck.write(tmp_path / "of_deck.toml").exists()
