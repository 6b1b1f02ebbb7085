"""How MuJoCo's contacts slide: a ball and two cubes at 1 m/s on a plane, friction 0.8.

    python sliding.py

Coulomb's law gives a stopping distance of v^2 / (2 mu g), and the body stays on the ground.
"""

import mujoco
import numpy as np

FRICTION, SPEED, GRAVITY = 0.8, 1.0, 9.81
CUBE = '<geom type="box" size=".0125 .0125 .0125" pos="{} 0 0"/>'


def model(constant, rate):
    """The body on the plane, with a time constant of its contacts."""
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco>
          <option timestep="{1 / rate}" cone="elliptic" impratio="10" integrator="implicitfast"/>
          <default><geom condim="3" density="1000" friction="{FRICTION} .005 .0001" solref="{constant} 1"/></default>
          <worldbody>
            <geom type="plane" size="0 0 1"/>
            <body pos="0 0 .0125"><freejoint/><geom type="sphere" size=".0125"/>{CUBE.format(0.05)}{CUBE.format(-0.05)}</body>
          </worldbody>
        </mujoco>"""
    )


def main():
    """Prints a line for each stiffness."""
    print(f"Coulomb: {100 * SPEED**2 / (2 * FRICTION * GRAVITY):.2f} cm, always in contact")
    for constant, rate in ((0.02, 1000), (0.02, 8000), (0.008, 1000), (0.002, 2000), (0.001, 2000), (0.00025, 8000)):
        own = model(constant, rate)
        data = mujoco.MjData(own)
        for _ in range(rate):
            mujoco.mj_step(own, data)
        (start, _, rest), touching, steps, top = data.qpos[:3].copy(), 0, 0, 0.0
        data.qvel[0] = SPEED
        while np.hypot(*data.qvel[:2]) > 1e-3 and steps < 2 * rate:
            mujoco.mj_step(own, data)
            steps, touching, top = steps + 1, touching + (data.ncon > 0), max(top, data.qpos[2] - rest)
        print(
            f"time constant {1000 * constant:6.2f} ms at {rate} Hz: {100 * (data.qpos[0] - start):.2f} cm, "
            f"in contact {100 * touching / steps:.0f} % of the time, rises {1000 * top:.2f} mm"
        )


if __name__ == "__main__":
    main()
