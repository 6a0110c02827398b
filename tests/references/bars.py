"""A01: two equal bars collide head-on, as one-dimensional chains of lumped masses and springs.

Loss of bars of lumped masses in any code: the chain has neither the contact search nor the elements
of Crumple. Time integration is by central differences. If end masses would overlap at the end of a
step, an impulse separates them that just closes the gap (a Lagrange multiplier of the step, which
can only push). The loss depends on when in a step the ends touch. So the script uses a series of
gaps that differ by fractions of a step.
Prints the smallest, mean and largest restitution e for each number of cells of a bar and Courant
number, and the order of the mean of 1 - e in the mesh size.

    python3 tests/references/bars.py > tests/references/bars.txt
"""

from math import log, sqrt

LENGTH, YOUNG, DENSITY = 1.0, 210e9, 7850.0  # m, Pa, kg/m^3; the area cancels
SPEED, GAP = 10.0, 1e-4  # speed of the first bar [m/s]; gap between the bars [m]
SIZES = [20, 50, 100]
# Step over side / c. 0.998 if the step is 0.999 of the stable step of cells that are compressed by
# v / 2c, a thousandth. A third if the cells of the other bar have a third of the width.
COURANT = [0.9, 0.998, 0.999, 0.3, 0.333]
STEPS = 20  # number of gaps in a step


def restitution(n, courant, more):
    """Ratio of the speeds of separation and approach of two bars of n cells each.

    The gap is larger by `more` times the displacement of a step.
    """
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
    cells = "".join(
        f"  {n} cells {min(r):.5f} {sum(r) / len(r):.5f} {max(r):.5f}" for n, r in zip(SIZES, e)
    )
    print(f"Courant {courant}:{cells}  order {order:.4f}")
