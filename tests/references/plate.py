"""The plate of B08 as a job with its own mesh, N by N on a quarter.

    python3 plate.py ELEMENT N > plate.toml

N = 64 and fully_integrated_quad gave the reference of `tests/verification/src/plates.rs`.
"""

import sys

ELEMENT, N = sys.argv[1], int(sys.argv[2])
HALF, DEPTH, PRESSURE = 0.127, 0.0127, 2.0684e6


def number(i, j):
    return i * (N + 1) + j + 1


cells = [(i, j) for i in range(N) for j in range(N)]
edge = sorted({number(N, j) for j in range(N + 1)} | {number(i, N) for i in range(N + 1)})
print('title = "B08 plate"\nunits = "m, s, kg"\nend_time = 1.4e-3\n[mesh]\nnodes = [')
for i in range(N + 1):
    for j in range(N + 1):
        print(f"[{number(i, j)}, {HALF * i / N!r}, {HALF * j / N!r}, 0.0],")
print("]\nshells = [")
for k, (i, j) in enumerate(cells, 1):
    print(
        f"[{k}, 1, {number(i, j)}, {number(i + 1, j)},"
        f" {number(i + 1, j + 1)}, {number(i, j + 1)}],"
    )
print(f"""]
[mesh.node_sets]
edge = {edge}
[output]
field_interval = -1.0
history_interval = 2e-6
[[output.node]]
ids = [1]
[[material]]
name = "aluminium"
law = "j2"
density = 2765.8
youngs_modulus = 68.95e9
poisson = 0.3
yield_stress = 206.84e6
hardening_modulus = 0.0
[[part]]
id = 1
material = "aluminium"
thickness = {DEPTH}
points = 5
element = "{ELEMENT}"
[[symmetry]]
point = [0.0, 0.0, 0.0]
normal = [1.0, 0.0, 0.0]
[[symmetry]]
point = [0.0, 0.0, 0.0]
normal = [0.0, 1.0, 0.0]
[[fix]]
nodes = "edge"
dofs = ["z"]
[[pressure]]
parts = [1]
pressure = {PRESSURE}""")
