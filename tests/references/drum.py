"""C18: a rigid block slides inside a drum of n facets, in the plane of the drum.

Plastic impacts and Coulomb friction act at the two lower corners of the block. The impulses of a
step are solved by projected Gauss-Seidel. No elements and no contact search of Crumple.

A polygon turns the path of a sliding body by 2 pi/n at every corner. A plastic law loses the
velocity component into the next facet. For the polygon of the check and for a nearly round one, the
script prints the energy kept over half a turn, its loss per facet, and the energy that a point
would keep: cos^2(2 pi/n) at a corner, (cos - mu sin)^2 with friction, exp(-2 mu angle) for a round
drum.

    python3 tests/references/drum.py > tests/references/drum.txt
"""

from math import cos, exp, hypot, pi, sin

INNER, SIDE, SPEED = 0.1 * cos(pi / 72) - 1e-3, 8e-3, 10.0  # m, m, m/s


def half_turn(n, mu, steps):
    """Share of the energy that is left after half a turn of the centre, and its path angle."""
    normals = [(sin(2 * pi * k / n), -cos(2 * pi * k / n)) for k in range(n)]
    low = (INNER * INNER - 0.25 * SIDE * SIDE) ** 0.5
    centre = low - 0.5 * SIDE
    x, z, turned = 0.0, -centre, 0.0
    vx, vz, spin = SPEED, 0.0, SPEED / centre
    inertia = SIDE * SIDE / 6.0  # square of mass 1
    dt = 2 * pi * INNER / (n * SPEED * steps)
    start = 0.5 * (vx * vx + vz * vz + inertia * spin * spin)
    angle, last = 0.0, 0.0
    from math import atan2

    while angle < pi and hypot(vx, vz) > 0.05 * SPEED:
        points = []
        for sx in (-0.5, 0.5):
            c, s = cos(turned), sin(turned)
            rx, rz = SIDE * (c * sx + s * 0.5), SIDE * (s * sx - c * 0.5)
            at = atan2(x + rx, -(z + rz)) * n / (2 * pi)
            for k in {round(at - 0.5) % n, round(at + 0.5) % n}:
                nx, nz = normals[k]
                gap = INNER - (nx * (x + rx) + nz * (z + rz))
                points.append([rx, rz, nx, nz, gap, 0.0, 0.0])
        for _ in range(30):
            for p in points:
                rx, rz, nx, nz, gap, pressed, sheared = p
                tx, tz = -nz, nx
                vpx, vpz = vx - spin * rz, vz + spin * rx
                arm = rx * -nz - rz * -nx
                more = (nx * vpx + nz * vpz - gap / dt) / (1.0 + arm * arm / inertia)
                new = max(0.0, pressed + more)
                d, p[5] = new - pressed, new
                vx, vz, spin = vx - d * nx, vz - d * nz, spin + d * arm / inertia
                if mu > 0.0:
                    vpx, vpz = vx - spin * rz, vz + spin * rx
                    arm = rx * tz - rz * tx
                    trial = sheared - (tx * vpx + tz * vpz) / (1.0 + arm * arm / inertia)
                    trial = max(-mu * new, min(mu * new, trial))
                    d, p[6] = trial - sheared, trial
                    vx, vz, spin = vx + d * tx, vz + d * tz, spin + d * arm / inertia
        x, z, turned = x + dt * vx, z + dt * vz, turned + dt * spin
        now = atan2(x, -z)
        step = now - last
        angle += step - 2 * pi * round(step / (2 * pi))
        last = now
    return 0.5 * (vx * vx + vz * vz + inertia * spin * spin) / start, angle


for n, steps in [(72, 100), (72, 400), (1440, 30)]:
    for mu in (0.0, 0.3):
        kept, angle = half_turn(n, mu, steps)
        facets = angle / (2 * pi / n)
        point = (cos(2 * pi / n) - mu * sin(2 * pi / n)) ** (2 * facets)
        print(
            f"{n} facets, {steps} steps a facet, mu {mu}: kept {kept:.4f} after {angle:.3f},"
            f" lost per facet {(1 - kept) / facets:.5f};"
            f" a point {point:.4f}; kept / exp(-2 mu angle) {kept / exp(-2 * mu * angle):.4f}"
        )
