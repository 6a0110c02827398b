#!/usr/bin/env python3
"""Reads the field files of a run with VTK, prints their contents and checks them.

DIR is the folder of a run, or its `fields` folder. Prints times, cells, points, arrays and their
ranges. Exits with 1 and a message at an error: an element that is present twice, a node with two
positions, values that are not finite, files that are named but missing or not readable.
Needs pyvista (deploy/requirements.txt).
"""

import argparse
import json
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

try:
    import pyvista
except ImportError:
    sys.exit(
        "read_fields: pyvista is missing; install it with: pip install -r deploy/requirements.txt"
    )

POINT_ARRAYS = {"displacement": 3, "velocity": 3, "rotational_velocity": 3, "node_id": 1}
CELL_ARRAYS = {
    "plastic_strain": 1,
    "von_mises": 1,
    "stress": 6,
    "thickness": 1,
    "part": 1,
    "worker": 1,
    "class": 1,
    "element_id": 1,
}
# Arrays that only some runs have.
OPTIONAL = {"damage": 1}
INTERIOR, INTERFACE, EXTERIOR = 0, 1, 2


class Wrong(Exception):
    """An error in the field files."""


def read(path):
    """The grid of a .vtu or .pvtu file; warnings of VTK are errors."""
    if not path.is_file():
        raise Wrong(f"{path}: named but missing")
    with pyvista.VtkErrorCatcher() as catcher:
        try:
            grid = pyvista.get_reader(str(path)).read()
        except RuntimeError as error:  # newer pyvista raises VTK's errors
            raise Wrong(f"{path}: VTK cannot read it: {error}") from error
    if catcher.events:
        raise Wrong(f"{path}: VTK reports: {catcher.events[0].alert}")
    return grid


def steps_of(collection):
    """Pairs (time, path) of the steps of a .pvd file."""
    try:
        root = ElementTree.parse(collection).getroot()
    except ElementTree.ParseError as error:
        raise Wrong(f"{collection}: not valid XML: {error}") from error
    steps = [
        (float(e.get("timestep")), collection.parent / e.get("file")) for e in root.iter("DataSet")
    ]
    if not steps:
        raise Wrong(f"{collection}: no steps")
    for (earlier, _), (later, path) in zip(steps, steps[1:]):
        if later <= earlier:
            raise Wrong(f"{collection}: {path} is at time {later}, after {earlier}")
    return steps


def pieces_of(step):
    """Paths of the pieces of a .pvtu file."""
    if not step.is_file():
        raise Wrong(f"{step}: named but missing")
    try:
        root = ElementTree.parse(step).getroot()
    except ElementTree.ParseError as error:
        raise Wrong(f"{step}: not valid XML: {error}") from error
    return [step.parent / e.get("Source") for e in root.iter("Piece")]


def check_arrays(path, grid):
    """Checks that arrays have the declared names and components, and are finite."""
    for place, data, declared in (
        ("point", grid.point_data, POINT_ARRAYS),
        ("cell", grid.cell_data, CELL_ARRAYS),
    ):
        declared = declared | {name: n for name, n in OPTIONAL.items() if name in data.keys()}
        if set(data.keys()) != set(declared):
            raise Wrong(f"{path}: {place} arrays are {sorted(data.keys())}, not {sorted(declared)}")
        for name, components in declared.items():
            values = data[name]
            width = 1 if values.ndim == 1 else values.shape[1]
            if width != components and len(values):
                raise Wrong(f"{path}: {name} has {width} components, not {components}")
            if not np.isfinite(values).all():
                first = int(np.argwhere(~np.isfinite(values))[0][0])
                raise Wrong(f"{path}: {name} is not finite at {place} {first}")
    if not np.isfinite(grid.points).all():
        raise Wrong(f"{path}: coordinates are not finite")


def check_once(path, what, ids):
    """Checks that no id is present twice."""
    found, counts = np.unique(ids, return_counts=True)
    if (counts > 1).any():
        worst = np.flatnonzero(counts > 1)[0]
        raise Wrong(
            f"{path}: {what} {found[worst]} is there {counts[worst]} times "
            f"({(counts > 1).sum()} {what}s are there more than once)"
        )


def check_nodes_agree(path, grid):
    """Checks that shared nodes have one position and one velocity, to the last bit."""
    ids = grid.point_data["node_id"]
    order = np.argsort(ids, kind="stable")
    same = np.flatnonzero(ids[order][1:] == ids[order][:-1])
    one, other = order[same], order[same + 1]
    columns = {"coordinates": grid.points} | {
        name: grid.point_data[name] for name in ("displacement", "velocity")
    }
    for name, values in columns.items():
        differ = np.flatnonzero((values[one] != values[other]).any(axis=1))
        if len(differ):
            a, b = one[differ[0]], other[differ[0]]
            raise Wrong(
                f"{path}: node {ids[a]} has two {name}: {values[a]} and {values[b]} "
                f"({len(differ)} such nodes)"
            )


def check_pieces(step, time, exterior):
    """Checks each piece alone: its time, classes and worker. Returns the number of cells."""
    cells = 0
    for worker, path in enumerate(pieces_of(step)):
        grid = read(path)
        stamp = grid.field_data.get("TimeValue")
        if stamp is None or stamp[0] != time:
            raise Wrong(f"{path}: its time is {stamp}, in the collection it is {time}")
        check_arrays(path, grid)
        check_once(path, "node", grid.point_data["node_id"])
        if (grid.cell_data["worker"] != worker).any():
            raise Wrong(f"{path}: `worker` is not {worker} everywhere")
        allowed = (EXTERIOR,) if exterior else (INTERIOR, INTERFACE)
        if not np.isin(grid.cell_data["class"], allowed).all():
            raise Wrong(f"{path}: `class` is not one of {allowed} everywhere")
        if (grid.cell_data["thickness"] < 0).any():
            raise Wrong(f"{path}: negative thickness")
        cells += grid.n_cells
    return cells


def print_ranges(grid):
    """Smallest and largest value of every array; for vectors, of their length."""
    for place, data in (("point", grid.point_data), ("cell", grid.cell_data)):
        for name in data.keys():
            values = data[name]
            width = 1 if values.ndim == 1 else values.shape[1]
            shown = np.linalg.norm(values, axis=1) if width == 3 else values
            label = f"{name}({width})" if width > 1 else name
            span = f"{shown.min():>14.6g} .. {shown.max():.6g}" if shown.size else "         empty"
            print(f"  {place:5}  {label:24} {span}")


def check_series(collection, exterior, owners, quiet):
    """Reads all steps of a collection.

    `owners` maps a time to the elements of the main collection, which fills it.
    """
    print(f"{collection}")
    steps = steps_of(collection)
    before = None
    for time, path in steps:
        cells = check_pieces(path, time, exterior)
        grid = read(path)
        if grid.n_cells != cells:
            raise Wrong(f"{path}: {grid.n_cells} cells, its pieces have {cells}")
        print(f"  time {time:g}: {grid.n_cells} cells, {grid.n_points} points")
        if grid.n_cells == 0:
            if exterior:
                continue
            raise Wrong(f"{path}: no cells")
        check_arrays(path, grid)
        ids = grid.cell_data["element_id"]
        nodes = dict(zip(grid.point_data["node_id"].tolist(), grid.points.tolist()))
        if exterior:
            elements, places = owners.get(time, (None, None))
            if elements is None:
                raise Wrong(f"{path}: time {time:g} is not in the main collection")
            strange = np.setdiff1d(ids, elements)
            if len(strange):
                raise Wrong(f"{path}: element {strange[0]} is a ghost of an element without owner")
            for node, x in nodes.items():
                if node in places and places[node] != x:
                    raise Wrong(
                        f"{path}: node {node} is at {x} as a ghost"
                        f" and at {places[node]} at its owner"
                    )
        else:
            check_once(path, "element", ids)
            if before is not None and len(np.setdiff1d(ids, before)):
                raise Wrong(
                    f"{path}: element {np.setdiff1d(ids, before)[0]} was not present in the"
                    " previous step"
                )
            owners[time] = (ids, nodes)
            before = ids
        check_nodes_agree(path, grid)
    if not quiet:
        print(f"  at time {time:g}:")
        print_ranges(grid)


def check_summary(folder, owners):
    """Checks that the first step has the number of elements in the summary of the run."""
    path = folder / "summary.json"
    if not path.is_file():
        return
    counted = sum(json.loads(path.read_text())["elements"].values())
    shown = len(owners[min(owners)][0])
    if counted != shown:
        raise Wrong(f"{path}: {counted} elements, the first field step has {shown}")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "dir", metavar="DIR", type=Path, help="folder of a run, or its fields folder"
    )
    parser.add_argument("--quiet", action="store_true", help="no ranges")
    arguments = parser.parse_args()
    run = arguments.dir
    fields = run / "fields" if (run / "fields").is_dir() else run
    try:
        if not (fields / "fields.pvd").is_file():
            raise Wrong(f"{fields}: fields.pvd is missing")
        owners = {}
        check_series(fields / "fields.pvd", False, owners, arguments.quiet)
        if (fields / "exterior.pvd").is_file():
            check_series(fields / "exterior.pvd", True, owners, arguments.quiet)
        check_summary(run, owners)
    except Wrong as wrong:
        sys.stdout.flush()
        sys.exit(f"read_fields: {wrong}")
    print("all checks passed")


if __name__ == "__main__":
    main()
