#!/usr/bin/env python3
"""Reads the VTKHDF file of a run with VTK and compares it with the field files of the run.

DIR is the folder of a run after `crumple export-vtkhdf DIR`. Compares times, cells, coordinates and
all arrays, matched by the ids of nodes and elements, bit for bit. Exits with 1 and a message at the
first difference. Needs pyvista (deploy/requirements.txt).
"""

import argparse
import sys
from pathlib import Path

import numpy as np
from read_fields import OPTIONAL, Wrong, read, steps_of

try:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError:
    sys.exit("read_vtkhdf: VTK is missing; install it with: pip install -r deploy/requirements.txt")


def arrays(data):
    """Arrays of points or cells by name, without those of VTK such as ghost marks."""
    all_of = (data.GetArray(i) for i in range(data.GetNumberOfArrays()))
    return {a.GetName(): vtk_to_numpy(a) for a in all_of if not a.GetName().startswith("vtk")}


def cells_of(grid, node_ids, element_ids):
    """Type and nodes of each element."""
    offsets = vtk_to_numpy(grid.GetCells().GetOffsetsArray())
    corners = np.asarray(node_ids)[vtk_to_numpy(grid.GetCells().GetConnectivityArray())]
    return {
        int(e): (grid.GetCellType(i), tuple(corners[offsets[i] : offsets[i + 1]]))
        for i, e in enumerate(element_ids)
    }


def compare(name, ours, ids, theirs, other_ids):
    """Compares an array of the file with that of the pieces, matched by ids."""
    found, first = np.unique(other_ids, return_index=True)
    if not np.array_equal(found, ids):
        raise Wrong(f"{name}: {len(ids)} ids, the fields have {len(found)} others")
    if ours.dtype != theirs.dtype:
        raise Wrong(f"{name} is of {ours.dtype}, in the fields of {theirs.dtype}")
    differ = np.flatnonzero((ours != theirs[first]).reshape(len(ids), -1).any(axis=1))
    if len(differ):
        raise Wrong(
            f"{name} of {ids[differ[0]]} is {ours[differ[0]]},"
            f" in the fields {theirs[first][differ[0]]}"
        )


def check(folder):
    """Compares all steps. Returns their number and the cells of the first and the last."""
    path = folder / "fields.vtkhdf"
    if not path.is_file():
        raise Wrong(f"{path} is missing; run: crumple export-vtkhdf {folder}")
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    steps = steps_of(folder / "fields" / "fields.pvd")
    if reader.GetNumberOfSteps() != len(steps):
        raise Wrong(f"{path} has {reader.GetNumberOfSteps()} steps, the fields {len(steps)}")
    cells = []
    for number, (time, file) in enumerate(steps):
        reader.SetStep(number)
        reader.Update()
        grid, fields = reader.GetOutputDataObject(0), read(file)
        where = f"step {number}: "
        if reader.GetTimeValue() != time:
            raise Wrong(f"{where}its time is {reader.GetTimeValue()}, in the fields {time}")
        on_points, on_cells = arrays(grid.GetPointData()), arrays(grid.GetCellData())
        nodes, elements = on_points["node_id"], on_cells["element_id"]
        their_nodes, their_elements = fields.point_data["node_id"], fields.cell_data["element_id"]
        points = vtk_to_numpy(grid.GetPoints().GetData())
        compare(where + "place", points, nodes, np.asarray(fields.points), their_nodes)
        for ours, theirs, ids, other in (
            (on_points, fields.point_data, nodes, their_nodes),
            (on_cells, fields.cell_data, elements, their_elements),
        ):
            if set(ours) != set(theirs.keys()) - set(OPTIONAL):
                raise Wrong(
                    f"{where}arrays are {sorted(ours)}, in the fields {sorted(theirs.keys())}"
                )
            for name, values in ours.items():
                compare(where + name, values, ids, np.asarray(theirs[name]), other)
        if cells_of(grid, nodes, elements) != cells_of(fields, their_nodes, their_elements):
            raise Wrong(f"{where}elements have other nodes than in the fields")
        cells.append(len(elements))
    return len(steps), cells[0], cells[-1]


def main():
    """Reads the arguments, compares, prints."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("dir", type=Path)
    try:
        steps, first, last = check(parser.parse_args().dir)
    except Wrong as wrong:
        sys.exit(f"read_vtkhdf: {wrong}")
    print(f"{steps} steps, {first} cells at first, {last} at last: all agrees")


if __name__ == "__main__":
    main()
