"""A01: two equal bars head-on as chains of lumped masses and springs, one-dimensional, by central differences.

What bars of lumped masses lose whoever computes them: the chain has neither contact search nor elements of ours. End masses that would
overlap at the end of a step are kept apart by the impulse that just closes the gap (a Lagrange multiplier of the step), which
can only push. How much that loses depends on where in a step the ends meet: gaps of a step more or less are gone through.
Printed: least, mean and largest restitution e by cells of a bar and Courant number, and the order in the mesh size of the mean
of 1 - e.

    python3 tests/references/bars.py > tests/references/bars.txt
"""

from math import log, sqrt

LENGTH, YOUNG, DENSITY = 1.0, 210e9, 7850.0  # m, Pa, kg/m^3; the area cancels
SPEED, GAP = 10.0, 1e-4  # of the first bar [m/s]; air between the bars [m]
SIZES = [20, 50, 100]
# Of the step over side / c. 0.998 where the step is 0.999 of that of cells compressed by v / 2c, a thousandth. A third of it where
# the cells of the other bar are a third as wide.
COURANT = [0.9, 0.998, 0.999, 0.3, 0.333]
STEPS = 20  # gaps in a step


def restitution(n, courant, more):
    """Ratio of the speeds of separation and approach of two bars of n cells each, `more` of a step's way farther apart."""
    c = sqrt(YOUNG / DENSITY)
    side = LENGTH / n
    dt = courant * side / c
    gap = GAP + more * SPEED * dt
    mass = [DENSITY * side] * (n + 1)
    mass[0] = mass[-1] = 0.5 * DENSITY * side
    stiffness = YOUNG / side
    u, v = [[0.0] * (n + 1), [0.0] * (n + 1)], [[SPEED] * (n + 1), [0.0] * (n + 1)]
    for _ in range(int((gap / SPEED + 3.2 * LENGTH / c) / dt) + 1):
        for b in range(2):
            pull = [0.0] + [stiffness * (q - p) for p, q in zip(u[b], u[b][1:])] + [0.0]
            v[b] = [w + dt * (pull[i + 1] - pull[i]) / mass[i] for i, w in enumerate(v[b])]
        apart = (gap + u[1][0] + dt * v[1][0]) - (u[0][n] + dt * v[0][n])
        if apart < 0.0:
            impulse = -apart / dt / (1.0 / mass[n] + 1.0 / mass[0])
            v[0][n] -= impulse / mass[n]
            v[1][0] += impulse / mass[0]
        for b in range(2):
            u[b] = [p + dt * w for p, w in zip(u[b], v[b])]
    mean = [sum(m * w for m, w in zip(mass, x)) / sum(mass) for x in v]
    return (mean[1] - mean[0]) / SPEED


for courant in COURANT:
    e = [[restitution(n, courant, k / STEPS) for k in range(STEPS)] for n in SIZES]
    lost = [1.0 - sum(r) / len(r) for r in e]
    order = log(lost[0] / lost[-1]) / log(SIZES[-1] / SIZES[0])
    cells = "".join(f"  {n} cells {min(r):.5f} {sum(r) / len(r):.5f} {max(r):.5f}" for n, r in zip(SIZES, e))
    print(f"Courant {courant}:{cells}  order {order:.4f}")
