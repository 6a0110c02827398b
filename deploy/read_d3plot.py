#!/usr/bin/env python3
"""Reads the d3plot database of a run with an independent reader, and compares it with the fields.

DIR is the folder of a run after `crumple export-d3plot DIR`. For each state the script compares, to
the last bit of single precision: times, coordinates, velocities, stress, plastic strain, thickness,
ids, parts, and the elements that have not failed. Exits with 1 and a message at a difference. Needs
lasso-python and pyvista (deploy/requirements.txt).
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np

try:
    from lasso.dyna import ArrayType, D3plot
except ImportError:
    sys.exit(
        "read_d3plot: lasso-python is missing;"
        " install it with: pip install -r deploy/requirements.txt"
    )

from read_fields import Wrong, read, steps_of


def same(what, time, ours, theirs):
    """Raises an error if two arrays are not equal, bit for bit."""
    ours, theirs = np.asarray(ours), np.asarray(theirs)
    if ours.shape != theirs.shape:
        raise Wrong(f"time {time:g}: {what}: {theirs.shape} values, the fields have {ours.shape}")
    if not np.array_equal(ours, theirs):
        at = tuple(np.argwhere(ours != theirs)[0])
        raise Wrong(f"time {time:g}: {what}: {theirs[at]} at {at}, the fields have {ours[at]}")


# Solids by their VTK types: the corners that the eight nodes of the format are.
SOLIDS = {
    10: [0, 1, 2, 3, 3, 3, 3, 3],
    12: list(range(8)),
    13: [0, 2, 5, 3, 1, 1, 4, 4],
    24: [0, 1, 2, 3, 3, 3, 3, 3],
}


def places(ids, wanted, what):
    """Positions of the wanted ids in `ids`."""
    order = np.argsort(ids)
    found = order[np.clip(np.searchsorted(ids, wanted, sorter=order), 0, len(ids) - 1)]
    if not np.array_equal(ids[found], wanted):
        raise Wrong(f"the {what} of the database are not those of the fields")
    return found


def check_elements(kind, state, time, arrays, grid, of_kind):
    """Compares values and ids of one kind of element. Returns the number of failed elements."""
    ids = arrays[f"element_{kind}_ids"]
    alive = arrays[f"element_{kind}_is_alive"][state] != 0.0
    here = np.asarray(grid.cell_data["element_id"])[of_kind]
    same(f"remaining {kind}s", time, np.sort(here), np.sort(ids[alive]))
    at = places(ids, here, f"{kind}s")

    def column(name):
        return np.asarray(grid.cell_data[name])[of_kind]

    stress = arrays[f"element_{kind}_stress"]
    strain = arrays[f"element_{kind}_effective_plastic_strain"]
    if kind == "shell" and "stress_of_points" in grid.cell_data:
        count = strain.shape[2]
        # The format has the middle point first if there are three.
        order = [1, 0, 2] if count == 3 else list(range(count))
        of_points = column("stress_of_points").reshape(-1, count, 6)[:, order]
        same("stress of points", time, of_points, stress[state, at])
        of_points = column("plastic_strain_of_points").reshape(-1, count)[:, order]
        same("plastic strain of points", time, of_points, strain[state, at])
    else:
        point = (state, at) if kind == "solid" else (state, at, 0)
        same(f"{kind} stress", time, column("stress"), stress[point].reshape(-1, 6))
        same(f"{kind} plastic strain", time, column("plastic_strain"), strain[point].reshape(-1))
    if kind == "shell":
        same(
            "thickness",
            time,
            column("thickness"),
            arrays[ArrayType.element_shell_thickness][state, at],
        )
    parts = arrays["part_ids"][arrays[f"element_{kind}_part_indexes"][at]]
    same(f"{kind} parts", time, column("part"), parts)
    return int((~alive).sum())


def check(folder):
    """Compares all states of a run."""
    database = D3plot(str(folder / "d3plot"))
    arrays, header = database.arrays, database.header
    steps = steps_of(folder / "fields" / "fields.pvd")
    times = np.array([time for time, _ in steps], dtype=np.float32)
    same("times", 0.0, times, arrays[ArrayType.global_timesteps])
    for state, (time, path) in enumerate(steps):
        grid = read(path)
        ids = np.asarray(grid.point_data["node_id"])
        at = places(arrays[ArrayType.node_ids], ids, "nodes")
        same(
            "coordinates",
            time,
            np.asarray(grid.points),
            arrays[ArrayType.node_displacement][state, at],
        )
        same(
            "velocities",
            time,
            grid.point_data["velocity"],
            arrays[ArrayType.node_velocity][state, at],
        )
        # The database has no beams and springs (lines).
        types = np.asarray(grid.celltypes)
        is_solid, is_shell = np.isin(types, tuple(SOLIDS)), np.isin(types, (5, 9))
        kinds = [
            (kind, of_kind)
            for kind, of_kind in (("solid", is_solid), ("shell", is_shell))
            if getattr(header, f"n_{kind}s") > 0
        ]
        gone = sum(
            check_elements(kind, state, time, arrays, grid, of_kind) for kind, of_kind in kinds
        )
        if state == 0:
            start = np.asarray(grid.points) - np.asarray(grid.point_data["displacement"])
            same("initial coordinates", time, start, arrays[ArrayType.node_coordinates][at])
            for cell in np.flatnonzero(is_solid | is_shell):
                kind = "solid" if is_solid[cell] else "shell"
                wanted = ids[grid.get_cell(cell).point_ids]
                if kind == "solid":
                    wanted = wanted[SOLIDS[types[cell]]]
                wanted = np.append(wanted, [wanted[-1]] * (4 - len(wanted)))
                row = places(
                    arrays[f"element_{kind}_ids"],
                    np.array([grid.cell_data["element_id"][cell]]),
                    kind,
                )
                nodes = arrays[ArrayType.node_ids][arrays[f"element_{kind}_node_indexes"][row[0]]]
                same(f"nodes of {kind} {row[0]}", time, wanted, nodes)
    points = arrays.get(ArrayType.element_shell_effective_plastic_strain)
    if points is not None and points.shape[2] > 1:
        print(f"{points.shape[2]} points of shells")
    strain = arrays.get(ArrayType.element_shell_strain)
    if strain is not None:
        print(f"strains of shells: {np.max(strain[-1]):.4f} at most")
    named = {
        part["id"]: part["name"]
        for part in json.loads((folder / "summary.json").read_text())["parts"]
    }
    for part, title in zip(arrays[ArrayType.part_titles_ids], arrays[ArrayType.part_titles]):
        if named.get(int(part), "") not in ("", title.decode().strip()):
            raise Wrong(f"part {part} has title {title.decode().strip()}, not {named[int(part)]}")
    print(
        f"{len(steps)} states, {header.n_nodes} nodes, {header.n_shells} shells,"
        f" {header.n_solids} solids, {gone} gone: all agrees"
    )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("dir", metavar="DIR", type=Path, help="folder of a run")
    arguments = parser.parse_args()
    try:
        check(arguments.dir)
    except Wrong as wrong:
        sys.stdout.flush()
        sys.exit(f"read_d3plot: {wrong}")


if __name__ == "__main__":
    main()
