"""Whether coulomb.py keeps to the laws it claims: python test_coulomb.py

Bodies of a few parts in MJCF, m, kg, s; each test says what it measured. Needs no sgc.
"""

import mujoco
import numpy as np

import coulomb

GRAVITY = 9.81


def model(bodies, rate, ground=0.8, gravity=(0, 0, -GRAVITY), servos="", plane=True):
    """A model on a plane (or in the air), of bodies with elements of density 1000 and friction 0.8."""
    floor = f'<geom name="ground" type="plane" size="0 0 1" friction="{ground} 0 0"/>' if plane else ""
    return mujoco.MjModel.from_xml_string(f"""<mujoco><compiler angle="radian" autolimits="true"/>
        <option timestep="{1 / rate}" gravity="{gravity[0]} {gravity[1]} {gravity[2]}" cone="elliptic"/>
        <default><geom condim="3" density="1000" friction="{ground} 0 0"/></default>
        <worldbody>{floor}{bodies}</worldbody><actuator>{servos}</actuator></mujoco>""")


def chain(links, length, kp, kv, torque="", height=0.0125, axis="0 1 0", root=""):
    """A cube of 25 mm with a chain of cylinders along x, each hinge at the end of the link before, and its servos."""
    inner, servos = "", ""
    for i in reversed(range(links)):
        place = f"{0.0125 if i == 0 else length} 0 0"
        inner = f"""<body pos="{place}"><joint name="h{i}" type="hinge" axis="{axis if i % 2 == 0 else "0 0 1"}"/>
          <geom type="cylinder" size=".009 {length / 2}" pos="{length / 2} 0 0" quat=".70710678118654757 0
          .70710678118654757 0"/>
          {inner}</body>"""
        limit = f'forcerange="-{torque} {torque}"' if torque else ""
        servos = f'<position joint="h{i}" kp="{kp}" kv="{kv}" {limit}/>' + servos
    body = f'<body pos="0 0 {height}"><freejoint/><geom type="box" size=".0125 .0125 .0125"/>{root}{inner}</body>'
    return body, servos


def run(stepper, steps, targets=()):
    """Steps on; targets may be a function of the time at a step's end."""
    h = stepper.model.opt.timestep
    for _ in range(steps):
        stepper.step(targets((stepper.steps + 1) * h) if callable(targets) else targets)
    assert stepper.unsolved == 0, f"{stepper.unsolved} of {stepper.steps} steps are not solved"
    return stepper


def beats(hinges):
    """A gait: a wave along the hinges."""
    return lambda t: 0.6 * np.sin(2 * np.pi * 1.3 * t - 0.9 * np.arange(hinges)) * min(1, 2 * t)


def test_ice():
    """On ice a gait moves the centre of mass nowhere, at any step, and turns the body nowhere by its momentum."""
    body, servos = chain(6, 0.03, 0.3, 0.01, 0.06)
    for rate in (250, 1000):
        stepper = coulomb.Stepper(coulomb.ice(model(body, rate, servos=servos)))
        start, core, touched, far = stepper.centre(), stepper.place.copy(), 0, 0.0
        for now in range(20 * rate):
            touch, impulse = stepper.step(beats(6)((now + 1) / rate))
            touched += len(touch.gap) > 0
            far = max(far, np.linalg.norm((stepper.centre() - start)[:2]))
        core = np.linalg.norm((stepper.place - core)[:2])
        linear, angular = stepper.momentum()
        print(
            f"ice, {rate} Hz, 20 s: centre of mass goes {1e6 * far:.1e} um at most (the core {1000 * core:.1f} mm), "
            f"angular momentum about the vertical {angular[2]:.1e} kg m2/s, left {stepper.unsolved} steps"
        )
        assert far < 1e-6 and touched > 10 * rate and core > 1e-3 and abs(angular[2]) < 1e-12


def test_tumbling():
    """In the air without weight momenta stay while hinges are driven; paths converge with the square of the step."""
    body, servos = chain(4, 0.04, 0.02, 0.0005)
    ends = {}
    for rate in (250, 500, 1000, 2000, 4000):
        own = model(body, rate, gravity=(0, 0, 0), servos=servos, plane=False)
        stepper = coulomb.Stepper(own, [3.0, 5.0, -4.0, 0.1, 0.2, -0.05, 2.0, -1.0, 3.0, 1.0])
        stepper.step(beats(4)(1 / rate))
        (p, l), way = stepper.momentum(), stepper.centre()
        run(stepper, rate - 1, beats(4))
        (q, m), t = stepper.momentum(), 1 - 1 / rate
        mass = stepper.tree.mass.sum()
        off = np.abs(q - p).max() / np.abs(p).max(), np.abs(m - l).max() / np.abs(l).max()
        gone = np.abs(stepper.centre() - way - p / mass * t).max()
        print(
            f"tumbling, {rate} Hz, 1 s: momentum off by {off[0]:.1e}, angular by {off[1]:.1e}, centre by {gone:.1e} m"
        )
        assert max(off) < 1e-9 and gone < 1e-9
        ends[rate] = np.concatenate([stepper.pose.centre.ravel(), stepper.angles])
    errors = [np.abs(ends[rate] - ends[4000]).max() for rate in (250, 500, 1000, 2000)]
    print("  poses after 1 s differ from 4000 Hz by", ", ".join(f"{e:.1e}" for e in errors), "(250 to 2000 Hz)")
    assert errors[0] / errors[1] > 3 and errors[1] / errors[2] > 3 and errors[2] < 1e-3


def test_energy():
    """A limp chain that lashes about a block at 30 rad/s keeps its energy, to the second power of the step."""
    body, _ = chain(2, 0.1, 0, 0, height=1)
    swings = []
    for rate in (1000, 2000, 4000):
        stepper = coulomb.Stepper(model(body, rate, gravity=(0, 0, 0), plane=False), [0, 2.0, 0, 0, 0, 0, 20.0, -30.0])
        energies = []
        for _ in range(2 * rate):
            one = stepper.pose
            stepper.step(())
            v = (stepper.pose.centre - one.centre) * rate
            # What a body turns by in a step, about its own axes.
            turn = np.einsum("nji,njk->nik", one.turn, stepper.pose.turn) * rate / 2
            spin = np.stack([turn[:, k - 1, k - 2] - turn[:, k - 2, k - 1] for k in range(3)], axis=1)
            energies.append(
                (stepper.tree.mass @ (v * v).sum(1) + np.einsum("ni,nij,nj", spin, stepper.tree.inertia, spin)) / 2
            )
        low, high = 100 * (np.array([min(energies), max(energies)]) / energies[0] - 1)
        swings.append(high - low)
        print(
            f"limp chain, {rate} Hz, 2 s: energy {1000 * energies[0]:.2f} mJ at first, then {low:+.4f} to {high:+.4f} %"
        )
    assert swings[0] / swings[1] > 3 and swings[1] / swings[2] > 3 and swings[2] < 1e-3


def test_sliding():
    """A block slides v^2 / (2 mu g) and stays on the ground."""
    block = '<body pos="0 0 .0125"><freejoint/><geom type="box" size=".0125 .0125 .0125"/>{}</body>'
    wings = "".join(f'<geom type="box" size=".0125 .0125 .0125" pos="{x} 0 0"/>' for x in (0.05, -0.05))
    law = 1 / (2 * 0.8 * GRAVITY)
    for rate in (250, 1000):
        stepper = coulomb.Stepper(model(block.format(wings), rate), [0, 0, 0, 1.0, 0, 0])
        heights = []
        for _ in range(rate // 2):
            stepper.step(())
            heights.append(stepper.place[2])
        way, hop = stepper.place[0], 1e6 * np.ptp(heights)
        print(f"sliding, {rate} Hz: {100 * way:.4f} cm, law {100 * law:.4f} cm, goes {hop:.1e} um up and down")
        assert abs(way / law - 1) < 2e-3 and hop < 0.1 and stepper.unsolved == 0


def test_slope():
    """Below the angle of friction a block stays; above it slides as the law says. The slope is a tilted gravity."""
    block = '<body pos="0 0 .0125"><freejoint/><geom type="box" size=".025 .025 .0125"/></body>'
    for share in (0.999, 1.01):
        angle = np.arctan(0.8 * share)
        pull = (GRAVITY * np.sin(angle), 0, -GRAVITY * np.cos(angle))
        stepper = run(coulomb.Stepper(model(block, 1000, gravity=pull)), 2000)
        law = max(0, pull[0] + 0.8 * pull[2]) * 2**2 / 2
        print(f"slope at {share:.3f} of the friction, 2 s: {1e6 * stepper.place[0]:.4f} um, law {1e6 * law:.1f} um")
        assert abs(stepper.place[0] - law) < max(1e-7, 2e-3 * law)


def test_servo():
    """A servo holds an arm: it gives way by torque / kp; one that is too weak lets it down; a limit holds it, too."""
    arm = """<body pos="0 0 .05"><freejoint/><geom type="box" size=".1 .1 .05"/><body pos="0 0 .2">
      <joint name="h0" type="hinge" axis="0 1 0" range="-1 .5"/>
      <geom type="box" size=".05 .01 .01" pos=".05 0 0"/></body></body>"""
    law = 0.04 * GRAVITY * 0.05
    for torque, sag in ((1, None), (0.7 * law, 0.5)):
        servo = f'<position joint="h0" kp=".3" kv=".01" forcerange="-{torque} {torque}"/>'
        stepper = run(coulomb.Stepper(model(arm, 1000, servos=servo)), 3000, np.zeros(1))
        angle = stepper.angles[0]
        wanted = sag if sag else law * np.cos(angle) / 0.3
        print(f"servo of {torque:.4f} N m under {law:.4f} N m: gives way by {angle:.6f} rad, law {wanted:.6f} rad")
        assert abs(angle - wanted) < 1e-4


def test_feet():
    """Two heavy feet stand while the body between them bends; and the cone of friction is not left."""
    foot = '<geom type="box" size=".0125 .0125 .0125" density="50000"/>'
    ball = '<geom type="sphere" size=".006" pos="{} 0 {}"/>'
    links = [
        ((0, 0, 0.0125), ball.format(0, 0.02)),
        ((0, 0, 0.04), ball.format(0.03, 0)),
        ((0.06, 0, 0), ball.format(0, -0.02)),
    ]
    links.append(((0, 0, -0.04), foot.replace("/>", ' pos="0 0 -.0125"/>')))
    inner = ""
    for i in reversed(range(4)):
        (x, y, z), geom = links[i]
        inner = f'<body pos="{x} {y} {z}"><joint name="h{i}" type="hinge" axis="0 1 0"/>{geom}{inner}</body>'
    body = f'<body pos="0 0 .0125"><freejoint/>{foot}{inner}</body>'
    servos = "".join(f'<position joint="h{i}" kp=".3" kv=".01" forcerange="-.02 .02"/>' for i in range(4))
    count = 4
    for rate in (250, 1000):
        stepper = coulomb.Stepper(model(body, rate, servos=servos))
        start, bent, far = [stepper.pose.place[i].copy() for i in (0, -1)], 0.0, 0.0
        for now in range(20 * rate):
            stepper.step(beats(count)((now + 1) / rate))
            bent = max(bent, np.abs(stepper.angles).max())
            far = max(far, *(np.abs(stepper.pose.place[i] - s).max() for i, s in zip((0, -1), start)))
        print(
            f"feet, {rate} Hz, 20 s: hinges bend by up to {bent:.3f} rad, feet go {1e6 * far:.2e} um at most, "
            f"left {stepper.unsolved} steps"
        )
        assert far < 2e-5 and bent > 0.02


def test_rolling():
    """A ball that starts sliding ends rolling at 5/7 of its speed, and goes on."""
    ball = '<body pos="0 0 .0125"><freejoint/><geom type="sphere" size=".0125"/></body>'
    for rate in (250, 1000):
        stepper = run(coulomb.Stepper(model(ball, rate), [0, 0, 0, 1.0, 0, 0]), 10 * rate)
        print(
            f"ball, {rate} Hz, 10 s: rolls at {stepper.v[3]:.6f} of its speed, law {5 / 7:.6f}, "
            f"{1e6 * (stepper.place[2] - 0.0125):.1e} um high"
        )
        assert abs(stepper.v[3] - 5 / 7) < 2e-3 and abs(stepper.place[2] - 0.0125) < 1e-5


def main():
    """All tests."""
    for name, test in list(globals().items()):
        if name.startswith("test_"):
            test()
    print("all hold")


if __name__ == "__main__":
    main()
