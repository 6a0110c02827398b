"""Folds of cases/tube along the middle of its first face (B19).

    python3 tube_folds.py DIR

DIR has the results of a run; the last field file is read. The result is the number of reversals of
the outward displacement by more than two thicknesses of 1 mm. README.md has the results.
"""

import sys
from pathlib import Path

import pyvista

SIDE, THICKNESS = 30.0, 1.0

last = sorted(Path(sys.argv[1], "fields").glob("*/fields.pvtu"))[-1]
mesh = pyvista.read(last)
moved = mesh.point_data["displacement"]
start = mesh.points - moved
# The trigger bulges a face by 0.3 mm at most.
face = [(z, u) for (x, y, z), (u, _, _) in zip(start, moved) if x > 0.47 * SIDE and abs(y) < 1e-3]
count, extreme, outward = 0, 0.0, None
for _, u in sorted(face):
    past = abs(u) if outward is None else (extreme - u if outward else u - extreme)
    if past > 2.0 * THICKNESS:
        outward = u > 0.0 if outward is None else not outward
        count, extreme = count + 1, u
    elif outward is not None and (u > extreme) == outward:
        extreme = u
print(f"{last.parent.name}: {len(face)} nodes, {count} folds")
