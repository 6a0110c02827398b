"""A01: two equal bars head-on as chains of lumped masses and springs, one-dimensional, by central differences.

What bars of lumped masses lose whoever computes them: the chain has neither contact search nor elements of ours. End masses that would
overlap at the end of a step are kept apart by the impulse that just closes the gap (a Lagrange multiplier of the step), which
can only push. How much that loses depends on where in a step the ends meet: gaps of a step more or less are gone through.
Printed: least, mean and largest restitution e by cells of a bar and Courant number, and the order in the mesh size of the mean
of 1 - e.

    python3 tests/references/bars.py > tests/references/bars.txt
"""

import numpy as np

LENGTH, AREA, YOUNG, DENSITY = 1.0, 1.0, 210e9, 7850.0  # m, m^2 (cancels), Pa, kg/m^3
SPEED, GAP = 10.0, 1e-4  # of the first bar [m/s]; air between the bars [m]
SIZES = [20, 50, 100]
# Of the step over side / c. A third of it where the cells of the other bar are a third as wide.
COURANT = [0.9, 0.999, 0.3, 0.333]
STEPS = 20  # gaps in a step


def restitution(n, courant, more):
    """Ratio of the speeds of separation and approach of two bars of n cells each, `more` of a step's way farther apart."""
    c = np.sqrt(YOUNG / DENSITY)
    side = LENGTH / n
    dt = courant * side / c
    gap = GAP + more * SPEED * dt
    mass = np.full(n + 1, DENSITY * AREA * side)
    mass[[0, -1]] *= 0.5
    stiffness = YOUNG * AREA / side
    x = [np.linspace(0.0, LENGTH, n + 1), LENGTH + gap + np.linspace(0.0, LENGTH, n + 1)]
    at_rest = [p.copy() for p in x]
    v = [np.full(n + 1, SPEED), np.zeros(n + 1)]
    for _ in range(int((gap / SPEED + 3.2 * LENGTH / c) / dt) + 1):
        for b in range(2):
            stretch = np.diff(x[b] - at_rest[b])
            force = np.zeros(n + 1)
            force[:-1] += stiffness * stretch
            force[1:] -= stiffness * stretch
            v[b] += dt * force / mass
        apart = (x[1][0] + dt * v[1][0]) - (x[0][-1] + dt * v[0][-1])
        if apart < 0.0:
            impulse = -apart / dt / (1.0 / mass[-1] + 1.0 / mass[0])
            v[0][-1] -= impulse / mass[-1]
            v[1][0] += impulse / mass[0]
        for b in range(2):
            x[b] += dt * v[b]
    mean = [np.dot(mass, u) / mass.sum() for u in v]
    return (mean[1] - mean[0]) / SPEED


for courant in COURANT:
    e = [[restitution(n, courant, k / STEPS) for k in range(STEPS)] for n in SIZES]
    lost = [1.0 - np.mean(r) for r in e]
    order = np.log(lost[0] / lost[-1]) / np.log(SIZES[-1] / SIZES[0])
    cells = "".join(f"  {n} cells {min(r):.5f} {np.mean(r):.5f} {max(r):.5f}" for n, r in zip(SIZES, e))
    print(f"Courant {courant}:{cells}  order {order:.4f}")
