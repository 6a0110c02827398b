#!/usr/bin/env python3
"""Reads the binout of a run with two other programs and compares it with the histories of the run.

DIR is the folder of a run after `crumple export-binout DIR`. Compares each channel with its column,
number by number: once as lasso-python reads it, which contains the reader of LSTC, and once as
dynars does. Exits with 1 and a message at the first difference. Needs lasso-python, dynars and
pandas (deploy/requirements.txt).
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np

try:
    import dynars
    import pandas as pd
    from lasso.dyna import Binout
except ImportError as error:
    sys.exit(f"read_binout: {error}; install it with: pip install -r deploy/requirements.txt")

AXES = "xyz"
# Branch: table, columns that name an object, channels and their columns.
OF_OBJECTS = {
    "matsum": (
        "parts",
        ["part"],
        {"mass": "mass"}
        | {f"{kind}_energy": kind for kind in ("kinetic", "internal", "hourglass")}
        | {f"{axis}_momentum": f"momentum {axis}" for axis in AXES},
    ),
    "nodout": (
        "nodes",
        ["id"],
        {f"{axis}_coordinate": axis for axis in AXES}
        | {
            f"{axis}_{kind}": f"{kind} {axis}"
            for axis in AXES
            for kind in ("displacement", "velocity", "acceleration")
        },
    ),
    "secforc": (
        "sections",
        ["section"],
        {f"{axis}_{kind}": f"{kind} {axis}" for axis in AXES for kind in ("force", "moment")}
        | {f"{axis}_centroid": f"middle {axis}" for axis in AXES},
    ),
    "abstat": (
        "airbags",
        ["airbag"],
        {
            "volume": "volume",
            "pressure": "pressure",
            "internal_energy": "energy",
            "total_mass": "mass",
            "gas_temp": "temperature",
        },
    ),
    "rwforc": ("walls", ["wall"], {f"{axis}_force": f"mean force {axis}" for axis in AXES}),
}


class Wrong(Exception):
    """A difference."""


class Channels:
    """Channels of a binout by two readers, which must agree."""

    def __init__(self, path):
        self.lasso, self.dynars = Binout(str(path)), dynars.Binout(str(path))
        self.branches = set(self.lasso.read())

    def path(self, branch, name):
        """The forces of walls are in a folder of their branch."""
        return [branch, "forces", name] if branch == "rwforc" else [branch, name]

    def read(self, branch, name):
        path = self.path(branch, name)
        one = np.asarray(self.lasso.read(*path), dtype=float)
        two = self.by_dynars(path)
        if not np.array_equal(one, two.reshape(one.shape), equal_nan=True):
            raise Wrong(f"{branch}: lasso and dynars differ in {name}")
        return one

    def by_dynars(self, path):
        """It joins the states of branches at the top only."""
        *folder, name = path
        if name in self.dynars.channels([*folder, "metadata"]):
            return self.dynars.read_f64([*folder, "metadata", name])
        if len(folder) == 1:
            return np.asarray(self.dynars.read(path), dtype=float)
        states = sorted(set(self.dynars.channels(folder)) - {"metadata"})
        return np.array([self.dynars.read_f64([*folder, state, name]) for state in states])

    def words(self, branch, name, width=80):
        path = self.path(branch, name)
        text = self.lasso.read(*path)
        return [text[at : at + width].strip() for at in range(0, len(text), width)]


def table(folder, name):
    """A history with bare names of columns; none if it does not exist."""
    path = folder / f"{name}.csv"
    if not path.is_file():
        return None
    frame = pd.read_csv(path, float_precision="round_trip")
    return frame.rename(columns=lambda column: column.split(" [")[0])


def equal(what, found, expected):
    """Compares numbers; the text of the table has ten digits, which are the same numbers."""
    found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    if found.size != expected.size:
        raise Wrong(f"{what}: {found.size} numbers, expected {expected.size}")
    if not np.array_equal(found.ravel(), expected.ravel()):
        raise Wrong(f"{what} differs")


def compare_objects(binout, folder):
    """Compares the branches whose rows are those of a table. Returns the number of channels."""
    count = 0
    for branch, (name, words, channels) in OF_OBJECTS.items():
        rows = table(folder, name)
        if (rows is None) != (branch not in binout.branches):
            raise Wrong(f"{branch} and {name}.csv: one of them is missing")
        if rows is None:
            continue
        # Nodes of several groups are in the table several times, in the binout once.
        objects = rows[words[0]].drop_duplicates().tolist()
        rows = rows[~rows.duplicated(["time", *words]) | (rows["time"] == rows["time"].max())]
        if branch in ("matsum", "nodout"):
            equal(f"ids of {branch}", binout.read(branch, "ids"), objects)
        elif binout.words(branch, "legend") != [str(one) for one in objects]:
            raise Wrong(f"{branch} has the objects {binout.words(branch, 'legend')}")
        times = rows.loc[rows[words[0]] == objects[0], "time"]
        equal(f"times of {branch}", binout.read(branch, "time"), times)
        for channel, column in channels.items():
            expected = np.array([rows.loc[rows[words[0]] == one, column] for one in objects]).T
            equal(f"{channel} of {branch}", binout.read(branch, channel), expected)
            count += 1
    return count


def compare_glstat(binout, folder):
    """Compares the energies of the whole model, and their sum."""
    rows = table(folder, "history")
    pairs = {
        "time": rows["time"],
        "cycle": rows["cycle"],
        "time_step": rows["dt"],
        "kinetic_energy": rows["kinetic"],
        "internal_energy": rows["internal"],
        "hourglass_energy": rows["hourglass"],
        "sliding_interface_energy": -rows["contact work"],
        "external_work": rows["external work"],
    }
    if "stonewall_energy" in binout.lasso.read("glstat"):
        pairs["stonewall_energy"] = -rows["wall work"]
    for channel, expected in pairs.items():
        equal(f"{channel} of glstat", binout.read("glstat", channel), expected)
    total = sum(rows[kind] for kind in ("kinetic", "internal", "hourglass"))
    total = total - rows["contact work"] - rows["wall work"]
    equal("total_energy of glstat", binout.read("glstat", "total_energy"), total)
    error = abs(binout.read("glstat", "energy_ratio") - 1).max()
    # The error of the history is a fraction of another energy; both are small together.
    if not error <= 10 * abs(rows["energy error"]).max() + 1e-6:
        raise Wrong(f"energy_ratio of glstat is off by {error}")
    return len(pairs) + 2


def compare_forces(binout, folder):
    """Compares contact forces: of transducers, or else of pairs of parts, zero without contact."""
    rows, words = table(folder, "transducers"), ["transducer"]
    if rows is None:
        rows, words = table(folder, "contact_pairs"), ["on part", "from part"]
    if rows is None:
        return 0
    times = table(folder, "history")["time"]
    found = binout.read("rcforc", "time")
    equal("times of rcforc", found, times)
    names = binout.words("rcforc", "legend")
    for number, name in enumerate(names):
        if words == ["transducer"]:
            own = rows[rows["transducer"] == name]
        else:
            on, source = name.removeprefix("part ").split(" from part ")
            own = rows[(rows["on part"] == int(on)) & (rows["from part"] == int(source))]
        if own.empty:
            raise Wrong(f"rcforc has {name}, which is not in the histories")
        for axis in AXES:
            values = binout.read("rcforc", f"{axis}_force").reshape(len(found), -1)[:, number]
            at = own.groupby("time")[f"force {axis}"].last()
            first = own.groupby("time")[f"force {axis}"].first()
            for time, value in zip(found, values):
                if value not in (at.get(time, 0.0), first.get(time, 0.0)):
                    raise Wrong(f"{axis}_force of {name} at {time} is {value}")
    return 3


def compare_normal_forces(binout, folder):
    """Normal forces are the forces along the normals of the walls."""
    if "rwforc" not in binout.branches:
        return 0
    walls = json.loads((folder / "summary.json").read_text())["walls"]
    shape = (len(binout.read("rwforc", "time")), -1)
    found = binout.read("rwforc", "normal_force").reshape(shape)
    for number, wall in enumerate(walls):
        if "normal" not in wall:
            if not np.isnan(found[:, number]).all():
                raise Wrong("a wall without a normal has a normal force")
            continue
        normal = np.array(wall["normal"]) / np.linalg.norm(wall["normal"])
        forces = [binout.read("rwforc", f"{axis}_force").reshape(shape)[:, number] for axis in AXES]
        if not np.allclose(found[:, number], normal @ np.array(forces), rtol=1e-12, atol=0):
            raise Wrong(f"the normal force of wall {number + 1} differs")
    return 1


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dir", type=Path, help="folder of a run")
    folder = parser.parse_args().dir
    try:
        binout = Channels(folder / "binout0000")
        count = compare_glstat(binout, folder) + compare_objects(binout, folder)
        count += compare_forces(binout, folder) + compare_normal_forces(binout, folder)
    except Wrong as difference:
        sys.exit(f"read_binout: {difference}")
    states = len(binout.read("glstat", "time"))
    print(f"{', '.join(sorted(binout.branches))}: {states} states, {count} channels: all agrees")


if __name__ == "__main__":
    main()
