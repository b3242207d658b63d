"""Direct shear tests of a rough joint under three normal stresses, beside the strength of Barton and Choubey (1977).

A ram pushes the upper block along the joint. The peak is s tan(phi + JRC lg(JCS/s)). The ram pushes above
the joint, so the pressure is less at its side, and this end slips first: the curve bends before its peak.

Expect:
    peak at 0.5 MPa = 0.5294 within 0.5 %: 0.5 tan(30 + 8 lg(60/0.5)) MPa
    peak at 1 MPa = 0.9733 within 0.5 %: 1 tan(30 + 8 lg 60) MPa
    peak at 2 MPa = 1.7893 within 0.5 %: 2 tan(30 + 8 lg 30) MPa
"""
import math

import matplotlib.pyplot as plt
import scree

axis = plt.figure(figsize=(5, 3), layout="constrained").add_subplot(xlabel="slip [mm]", ylabel="shear stress [MPa]")
for stress in (0.5, 1, 2):
    m = scree.Model("shear", title=f"A direct shear test of a rough joint under {stress} MPa.")
    m.material("rock", density=2600, young=1e10, unit_weight=0)
    m.joint_material("joint", phi=30, kn=1e10, ks=2e9, jrc=8, jcs=60e6)
    m.joint_material("smooth", phi=0)
    m.block("lower", [(0, -0.1), (1, -0.1), (1, 0), (0, 0)], joint="joint")
    m.block("upper", [(0.1, 0), (0.9, 0), (0.9, 0.1), (0.1, 0.1)], joint=["joint", "smooth", "smooth", "smooth"])
    m.block("ram", [(0, 0.02), (0.1, 0.02), (0.1, 0.08), (0, 0.08)], joint="smooth")
    m.fix("box", block="lower")
    m.fix("ram", block="ram", move=[(0, 0, 0), (1, 0.004, 0)])
    m.load("normal", [(0.1, 0.1), (0.9, 0.1)], pressure=stress * 1e6)
    m.static(balance=None, steps=40)
    r = m.run()
    joints = [r.joint("joint", frame) for frame in range(1, r.n_frames)]
    slip, force = [1000 * joint.slip.max() for joint in joints], [joint.shear_force / 0.8e6 for joint in joints]
    axis.plot(slip, force, label=f"{stress} MPa")
    axis.axhline(stress * math.tan(math.radians(30 + 8 * math.log10(60 / stress))), color="grey", linewidth=0.7)
    print(f"peak at {stress} MPa: {max(force):.4f} MPa")
axis.legend(title="normal stress", loc="upper left")
axis.figure.savefig("shear.png", dpi=100)
