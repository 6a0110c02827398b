"""The S-beam of B15 as a job with its own mesh, QUADS over a side.

    python3 s_beam.py QUADS ELEMENT > job.toml

QUADS = 24 (3.33 mm) and fully_integrated_quad gave the references of
`tests/verification/src/crashes.rs`. README.md has the commands.
"""

import math
import sys

QUADS, ELEMENT = int(sys.argv[1]), sys.argv[2]
SIDE, THICKNESS, LEG, RADIUS, ANGLE = 0.08, 1.5e-3, 0.16, 0.2, math.pi / 4
ARC = RADIUS * ANGLE
LENGTH = 2 * LEG + 2 * ARC


def axis(s):
    """Point of the axis and the angle of its tangent."""
    x, y, angle = min(s, LEG), 0.0, 0.0
    if s > LEG:
        angle = min(s - LEG, ARC) / RADIUS
        x, y = LEG + RADIUS * math.sin(angle), RADIUS * (1 - math.cos(angle))
    if s > LEG + ARC:
        turned = min(s - LEG - ARC, ARC) / RADIUS
        angle = ANGLE - turned
        x += RADIUS * (math.sin(ANGLE) - math.sin(angle))
        y += RADIUS * (math.cos(angle) - math.cos(ANGLE))
    return x + max(s - LEG - 2 * ARC, 0.0), y, angle


def section(k):
    """Offset to the left of the axis, and height."""
    face, t = divmod(k, QUADS)
    along = SIDE * (t / QUADS - 0.5)
    return [(SIDE / 2, along), (-along, SIDE / 2), (-SIDE / 2, -along), (along, -SIDE / 2)][face]


around, rings = 4 * QUADS, 8 * QUADS
print('title = "B15 S-beam"\nunits = "m, s, kg"\nend_time = 6.2e-3\n[mesh]\nnodes = [')
for i in range(rings + 1):
    x, y, angle = axis(LENGTH * i / rings)
    for k in range(around):
        left, up = section(k)
        at = (x - left * math.sin(angle), y + left * math.cos(angle), up)
        print(f"[{i * around + k + 1}, {at[0]!r}, {at[1]!r}, {at[2]!r}],")
print("]\nshells = [")
for i in range(rings):
    for k in range(around):
        a, b = i * around + k + 1, i * around + (k + 1) % around + 1
        print(f"[{i * around + k + 1}, 1, {a}, {b}, {b + around}, {a + around}],")
foot = list(range(1, around + 1))
head = [rings * around + n for n in foot]
curve = [[e, 185.4e6 + 540e6 * e**0.32] for e in [0, 1e-3, 5e-3, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8]]
print(f"""]
[mesh.node_sets]
foot = {foot}
head = {head}
moving = {list(range(around + 1, (rings + 1) * around + 1))}
[output]
field_interval = -1.0
history_interval = 1e-4
[[material]]
name = "steel"
law = "j2"
density = 7900.0
youngs_modulus = 199.355e9
poisson = 0.3
hardening = {curve}
[[part]]
id = 1
name = "beam"
material = "steel"
thickness = {THICKNESS}
points = 5
element = "{ELEMENT}"
[[fix]]
nodes = "foot"
dofs = ["x", "y", "z", "rx", "ry", "rz"]
[[mass]]
nodes = "head"
mass = 500.0
[[rigid]]
name = "head"
nodes = "head"
fixed = ["y", "z", "rx", "ry", "rz"]
[[initial_velocity]]
nodes = "moving"
velocity = [-10.0, 0.0, 0.0]
[contact]
friction = 0.1""")
