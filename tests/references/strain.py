"""A03 (b): a bar in uniaxial strain hits a rigid wall at 100 m/s.

Compression of 1.7 % is not a small strain here. The closed form uses the law of the engine,
stress = M ln(stretch) on a constant section, M = lambda + 2 mu. Behind the shock
rho v^2 = -M ln(1 - e) e; its speed is v/e in the initial length. A fan returns from the free end;
its middle has the speed sqrt(M / rho / (1 - e/2)). A chain of lumped masses with such springs, by
central differences, gives the loss of the mesh in the wave front, as in bars.py.

    python3 tests/references/strain.py > tests/references/strain.txt
"""

from math import log, sqrt

LENGTH, YOUNG, POISSON, DENSITY, SPEED = 0.2, 200e9, 0.3, 8000.0, 100.0  # m, Pa, 1, kg/m^3, m/s
MODULUS = YOUNG * (1 - POISSON) / (1 + POISSON) / (1 - 2 * POISSON)
C = sqrt(MODULUS / DENSITY)

e = SPEED / C
for _ in range(50):
    e = sqrt(DENSITY * SPEED**2 / MODULUS * e / -log(1 - e))
pressure = -MODULUS * log(1 - e)
duration = LENGTH * e / SPEED + LENGTH / C * sqrt(1 - e / 2)
print(
    f"closed form: strain {e:.6f}, force on (20 mm)^2 {pressure * 4e-4 * 1e-6:.4f} MN,"
    f" duration {duration * 1e6:.3f} us"
)


def rebound(n, courant, more):
    """Velocity of the centre of mass after the impact over that before."""
    side = LENGTH / n
    mass = [DENSITY * side] * (n + 1)
    mass[0] = mass[-1] = 0.5 * DENSITY * side
    dt = courant * side / C
    u, v = [more * SPEED * dt] * (n + 1), [-SPEED] * (n + 1)
    for _ in range(int(3.2 * LENGTH / C / dt)):
        force = [MODULUS * log(1 + (u[i + 1] - u[i]) / side) for i in range(n)]
        v[0] += dt * force[0] / mass[0]
        for i in range(1, n):
            v[i] += dt * (force[i] - force[i - 1]) / mass[i]
        v[n] -= dt * force[n - 1] / mass[n]
        if u[0] + dt * v[0] < 0.0:
            v[0] = -u[0] / dt
        u = [a + dt * b for a, b in zip(u, v)]
    return sum(m * w for m, w in zip(mass, v)) / sum(mass) / SPEED


for n in (100, 400):
    for courant in (0.5, 0.6, 0.7, 0.8, 0.9):
        phases = [k / 4 for k in range(4)] if n == 100 else [0.0]
        all = [rebound(n, courant, phase) for phase in phases]
        print(f"{n} cells, Courant {courant}: rebound / v from {min(all):.5f} to {max(all):.5f}")
