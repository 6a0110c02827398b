#!/usr/bin/env python3
"""Reads the EXODUS II file of a run with VTK and compares it with the field files of the run.

DIR is the folder of a run after `crumple export-exodus DIR`. Compares times, coordinates and all
variables, matched by the ids of nodes and elements: bit for bit, except coordinates, which are
those of the start plus the displacement. Exits with 1 and a message at the
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
    sys.exit("read_exodus: VTK is missing; install it with: pip install -r deploy/requirements.txt")

RENAMED = {"displacement": "displ"}
TENSOR = ("xx", "yy", "zz", "xy", "yz", "zx")
# In the model instead of in the results.
MODEL = {"node_id", "element_id", "part"}


def opened(path):
    """A reader with all arrays switched on, in undeformed coordinates."""
    reader = vtk.vtkExodusIIReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    reader.ApplyDisplacementsOff()
    reader.GenerateGlobalElementIdArrayOn()
    reader.GenerateGlobalNodeIdArrayOn()
    for kind in (reader.NODAL, reader.ELEM_BLOCK):
        for i in range(reader.GetNumberOfObjectArrays(kind)):
            reader.SetObjectArrayStatus(kind, reader.GetObjectArrayName(kind, i), 1)
    return reader


def arrays(data):
    """Arrays of points or cells by name."""
    all_of = (data.GetArray(i) for i in range(data.GetNumberOfArrays()))
    return {a.GetName(): vtk_to_numpy(a) for a in all_of}


def blocks_of(reader):
    """The element blocks of the present step."""
    reader.Update()
    iterator = reader.GetOutput().NewIterator()
    while not iterator.IsDoneWithTraversal():
        yield iterator.GetCurrentDataObject()
        iterator.GoToNextItem()


def compare(name, ours, theirs):
    """Compares the values of the file with those of the pieces."""
    ours, theirs = (np.asarray(a, dtype=np.float64).reshape(len(a), -1) for a in (ours, theirs))
    if ours.shape != theirs.shape:
        raise Wrong(f"{name} has the shape {ours.shape}, in the fields {theirs.shape}")
    differ = np.flatnonzero((ours != theirs).any(axis=1))
    if len(differ):
        raise Wrong(f"{name}: {ours[differ[0]]}, in the fields {theirs[differ[0]]}")


def check_step(reader, fields):
    """Compares all blocks of a step. Returns the number of elements that have not failed."""
    node_ids, element_ids = fields.point_data["node_id"], fields.cell_data["element_id"]
    nodes, elements = np.argsort(node_ids), np.argsort(element_ids)
    found = 0
    for block in blocks_of(reader):
        on_points, on_cells = arrays(block.GetPointData()), arrays(block.GetCellData())
        alive = on_cells["status"] == 1
        ids = on_cells["GlobalElementId"][alive]
        found += len(ids)
        cell = elements[np.searchsorted(element_ids[elements], ids)]
        point = nodes[np.searchsorted(node_ids[nodes], on_points["GlobalNodeId"])]
        on_cells["stress"] = np.column_stack([on_cells[f"stress_{c}"] for c in TENSOR])
        for name in set(fields.cell_data.keys()) - MODEL - set(OPTIONAL):
            compare(name, on_cells[name][alive], np.asarray(fields.cell_data[name])[cell])
        for name in set(fields.point_data.keys()) - MODEL:
            ours = on_points[RENAMED.get(name, name)]
            compare(name, ours, np.asarray(fields.point_data[name])[point])
        start = vtk_to_numpy(block.GetPoints().GetData())
        now = np.asarray(fields.points)[point]
        moved = start + np.asarray(fields.point_data["displacement"])[point]
        if not np.allclose(moved, now, rtol=0, atol=1e-6 * np.abs(now).max()):
            raise Wrong("the coordinates differ")
    if found != len(element_ids):
        raise Wrong(f"{found} elements have not failed, in the fields {len(element_ids)}")
    return found


def check(folder):
    """Compares all steps. Returns their number and the elements of the last."""
    path = folder / "fields.exo"
    if not path.is_file():
        raise Wrong(f"{path} is missing; run: crumple export-exodus {folder}")
    reader = opened(path)
    steps = steps_of(folder / "fields" / "fields.pvd")
    times = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    if list(times or []) != [time for time, _ in steps]:
        raise Wrong(f"times {times}, in the fields {[time for time, _ in steps]}")
    count = 0
    for i, (_, file) in enumerate(steps):
        reader.SetTimeStep(i)
        count = check_step(reader, read(file))
    return len(steps), count


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("dir", type=Path)
    folder = parser.parse_args().dir
    try:
        steps, cells = check(folder)
    except Wrong as wrong:
        sys.exit(f"read_exodus: {wrong}")
    print(f"{steps} steps as in the fields; the last has {cells} elements")


if __name__ == "__main__":
    main()
