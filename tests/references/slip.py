"""A08: a rigid block on a base that moves with velocity r sin(t), and Coulomb friction.

Units are mu g/w and mu g/w^2. The step is so small that the printed digits do not depend on it. The
quantities are measured as in the check: the fraction of a cycle in which the relative speed is
above 0.01, the largest speed of the block, and the sliding distance in a cycle. The steady state is
that of the sixth cycle.

    python3 tests/references/slip.py > tests/references/slip.txt
"""

from math import cos, pi, sin

STEPS = 400_000  # per cycle
THRESHOLD = 0.01


def steady(r):
    """Fraction of time in slip, the same above the threshold, largest speed, sliding distance.

    All in the sixth cycle.
    """
    dt = 2.0 * pi / STEPS
    v, sticks = 0.0, True
    for cycle in range(6):
        slips = above = most = slid = 0.0
        for k in range(STEPS):
            t = (k + 1) * dt
            base, pull = r * sin(t), r * cos(t)
            if sticks and abs(pull) <= 1.0:
                v = base
            else:
                before = v - (r * sin(t - dt))
                # Direction in which it slides or starts to slide: opposite to the pull of the base.
                sign = before if not sticks else -pull
                v += -dt if sign > 0.0 else dt
                after = v - base
                sticks = (after * sign <= 0.0) and abs(pull) <= 1.0
                if sticks:
                    v = base
            relative = abs(v - base)
            slips += dt if not sticks else 0.0
            above += dt if relative > THRESHOLD else 0.0
            slid += relative * dt
            most = max(most, abs(v))
        if cycle == 5:
            return slips / (2.0 * pi), above / (2.0 * pi), most, slid


for r in [1.2, 1.5, 1.8, 3.0]:
    print(
        "r {}: slip {:.4f}, above the threshold {:.4f},"
        " largest speed {:.4f}, sliding {:.4f}".format(r, *steady(r))
    )
