"""The tubes of B11, B12 and B13 as jobs with their own mesh, and their results.

    python3 tubes.py CASE REFINE ELEMENT [DEPTH] > job.toml    CASE is B11, B12a, B12b or B13
    crumple run job.toml --out DIR
    python3 tubes.py --results CASE DIR

The results are the mean force and the largest force over 0.1 ms [kN], the energy that the head has
lost at each station [kJ], and the number of folds along the middle of a face at the last station.

REFINE = 1 is the mesh of the catalogue (`tests/verification/src/crush.rs`), 2 has half its sides.
DEPTH multiplies the depth of the trigger (default 1).
README.md has the results.
"""

import csv
import math
import sys

# around, along, length, trigger, thickness, yield stress, modulus, head, thinning, depth
CASES = {
    "B11": (48, 60, 0.3, (0.01, 0.04), 1.5e-3, 250e6, 1e9, 650.0, True, 0.15),
    "B12a": (40, 54, 0.2, (0.006, 0.029), 1.152e-3, 300e6, 0.0, 300.0, False, 0.12),
    "B12b": (40, 54, 0.266, (0.008, 0.039), 1.63e-3, 300e6, 0.0, 300.0, False, 0.6 * 0.266),
    "B13": (64, 40, 0.1, (0.0, 0.01), 1e-3, 200e6, 0.0, 100.0, False, 0.05),
}
# Stations of B11 [m]; the other tubes have them at quarters of the depth.
STATIONS = [0.025, 0.05, 0.075, 0.1, 0.125, 0.15]
WINDOW = 1e-4
SQUARES = {"B11": (0.06, 5e-4), "B12a": (0.03707, 4e-4), "B12b": (0.04931, 4e-4)}
SPEED = 15.0


def section(case, s):
    """Point of the section, and the outward normal times the depth of the trigger [m]."""
    if case == "B13":
        y, x = math.sin(math.tau * s), math.cos(math.tau * s)
        return (0.025 * x, 0.025 * y), (2e-4 * x, 2e-4 * y)
    side, depth = SQUARES[case]
    half, face, t = side / 2, int(4 * s), (4 * s) % 1
    along, bulge = side * t - half, depth * math.sin(math.pi * t)
    return [
        ((half, along), (-bulge, 0.0)),
        ((-along, half), (0.0, bulge)),
        ((-half, -along), (bulge, 0.0)),
        ((along, -half), (0.0, -bulge)),
    ][face]


def job(case, refine, element, deeper=1.0):
    around, along, length, trigger, thickness, strength, modulus, head = CASES[case][:8]
    thinning, depth = CASES[case][8:]
    around, along = 4 * round(around * refine / 4), round(along * refine)
    low, high = trigger
    out = [f'title = "{case}"\nunits = "m, s, kg"\nend_time = {1.3 * depth / SPEED!r}']
    out.append("[mesh]\nnodes = [")
    for i in range(along + 1):
        z = length * i / along
        wave = deeper * math.sin(math.pi * (z - low) / (high - low)) if low < z < high else 0.0
        for k in range(around):
            (x, y), (dx, dy) = section(case, k / around)
            out.append(f"[{i * around + k + 1}, {x + wave * dx!r}, {y + wave * dy!r}, {z!r}],")
    out.append("]\nshells = [")
    for i in range(along):
        for k in range(around):
            a, b = i * around + k + 1, i * around + (k + 1) % around + 1
            out.append(f"[{i * around + k + 1}, 1, {a}, {b}, {b + around}, {a + around}],")
    top = list(range(along * around + 1, (along + 1) * around + 1))
    out.append(f"""]
[mesh.node_sets]
head = {top}
measured = {top[:: around // 8]}
face = {list(range(around // 8 + 1, (along + 1) * around + 1, around))}
all = {list(range(1, (along + 1) * around + 1))}
[output]
field_interval = -1.0
history_interval = 2e-5
[[output.node]]
nodes = "measured"
[[output.node]]
nodes = "face"
[[material]]
name = "steel"
law = "j2"
density = 7850.0
youngs_modulus = 210e9
poisson = 0.3
yield_stress = {strength!r}
hardening_modulus = {modulus!r}
[[part]]
id = 1
material = "steel"
thickness = {thickness!r}
points = 5
element = "{element}"
thinning = {str(thinning).lower()}
[[fix]]
nodes = "head"
dofs = ["x", "y", "rx", "ry", "rz"]
[[mass]]
nodes = "head"
mass = {head!r}
[[initial_velocity]]
nodes = "all"
velocity = [0.0, 0.0, -{SPEED!r}]
[[wall]]
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
friction = 0.1
[contact]
friction = 0.1""")
    return "\n".join(out)


def moved(folder):
    """Rows of the nodes by set and time, with the names of the columns without units."""
    sets = {}
    with open(f"{folder}/nodes.csv") as file:
        for row in csv.DictReader(file):
            at = {name.split(" [")[0]: value for name, value in row.items()}
            sets.setdefault(at["nodes"], {}).setdefault(float(at["time"]), []).append(at)
    return sets


def folds(case, rows):
    """Reversals of the displacement along a face by more than two thicknesses."""
    count, extreme, outward = 0, 0.0, None
    for row in rows:
        x, y, ux, uy = (float(row[name]) for name in ("x", "y", "displacement x", "displacement y"))
        u = math.hypot(x, y) - math.hypot(x - ux, y - uy)
        past = abs(u) if outward is None else (extreme - u if outward else u - extreme)
        if past > 2.0 * CASES[case][4]:
            outward = u > 0.0 if outward is None else not outward
            count, extreme = count + 1, u
        elif outward is not None and (u > extreme) == outward:
            extreme = u
    return count


def results(case, folder):
    head, depth = CASES[case][7], CASES[case][9]
    stations = STATIONS if case == "B11" else [depth * k / 4 for k in range(1, 5)]
    sets = moved(folder)
    means = []
    for time, rows in sorted(sets["measured"].items()):
        u, v = (sum(float(r[name]) for r in rows) / len(rows)
                for name in ("displacement z", "velocity z"))
        means.append((time, -u, v))
    lost = lambda v: 0.5e-3 * head * (SPEED**2 - v * v)
    absorbed, peak, last = [], 0.0, (0.0, -SPEED)
    for (_, u, v), (time, next_u, next_v) in zip(means, means[1:]):
        if time >= last[0] + 0.999 * WINDOW:
            peak = max(peak, 1e-3 * head * (next_v - last[1]) / (time - last[0]))
            last = (time, next_v)
        while len(absorbed) < len(stations) and next_u >= stations[len(absorbed)]:
            station = stations[len(absorbed)]
            absorbed.append(lost(v + (next_v - v) * (station - u) / (next_u - u)))
        if len(absorbed) == len(stations):
            end = time
            break
    else:
        raise SystemExit(f"{folder}: the run ended before {depth} m")
    energies = ", ".join(f"{energy:.3f}" for energy in absorbed)
    return (f"mean force {absorbed[-1] / depth:.2f} kN, largest {peak:.2f} kN, "
            f"energies {energies} kJ, folds {folds(case, sets['face'][end])}")


if sys.argv[1] == "--results":
    print(results(*sys.argv[2:4]))
else:
    print(job(sys.argv[1], float(sys.argv[2]), sys.argv[3], *map(float, sys.argv[4:])))
