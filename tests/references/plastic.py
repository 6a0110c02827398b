"""A01, A03: loss of bars of lumped masses whose end masses stop in a step.

The other side is another bar or a rigid wall. One-dimensional, central differences at 0.9 of the
stable step.

The end masses have 1/2N of the kinetic energy of a bar of N cells. It is lost if they stop at once.
If they touch inside a step, they stop over two steps: first the rest of the gap closes, while the
springs behind them push. So the loss depends on when in a step the ends touch. The script uses a
series of gaps that differ by fractions of a step. Prints the smallest and largest loss over 1/2N.

    python3 tests/references/plastic.py > tests/references/plastic.txt
"""

from math import sqrt

LENGTH, YOUNG, DENSITY = 1.0, 210e9, 7850.0  # m, Pa, kg/m^3; the area cancels
SPEED, GAP, COURANT, PHASES = 10.0, 1e-6, 0.9, 40


def lost(n, more):
    """Energy lost at a rigid wall over 1/2N of the kinetic energy.

    The gap is larger by `more` times the displacement of a step. By symmetry two equal bars with
    half the speed each lose the same, twice.
    """
    c = sqrt(YOUNG / DENSITY)
    side = LENGTH / n
    dt = COURANT * side / c
    mass = [DENSITY * side] * (n + 1)
    mass[0] = mass[-1] = 0.5 * DENSITY * side
    stiffness = YOUNG / side
    u, v = [GAP + more * SPEED * dt] * (n + 1), [-SPEED] * (n + 1)
    work = 0.0
    for _ in range(int(3.0 * LENGTH / c / dt)):
        before = v[0]
        force = [stiffness * (u[i + 1] - u[i]) for i in range(n)]
        v[0] += dt * force[0] / mass[0]
        for i in range(1, n):
            v[i] += dt * (force[i] - force[i - 1]) / mass[i]
        v[n] -= dt * force[n - 1] / mass[n]
        if u[0] + dt * v[0] < 0.0:
            push = mass[0] * (-u[0] / dt - v[0])
            v[0] = -u[0] / dt
            work += 0.5 * push * (before + v[0])
        u = [a + dt * b for a, b in zip(u, v)]
    return -work / (0.5 * DENSITY * LENGTH * SPEED * SPEED) * 2 * n


for n in [5, 10, 20, 40, 50, 80, 100]:
    all = [lost(n, k / PHASES) for k in range(PHASES)]
    print(f"{n} cells: lost / (1/2N) from {min(all):.4f} to {max(all):.4f}")
