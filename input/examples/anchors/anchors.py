"""A slope of 14 m on joints that dip out of its face: its factor of safety dry, with ground water, and with four rows of anchors.

The dry slope slides on its bedding. Water lifts the blocks that slide, and anchors of 150 kN/m press them together again.

Expect:
    dry = 1.205 within 1 %: by halving
    with water = 0.608 within 1 %: by halving
    with anchors = 2.309 within 1 %: by halving
"""
import matplotlib.pyplot as plt
import scree

m = scree.Model("anchors", title="A slope with ground water and anchors.")
m.material("rock", density=2600, young=1e10)
m.joint_material("bedding", phi=38)
m.joint_material("steep", phi=38)
m.rock([(0, 0), (40, 0), (40, 18), (21, 18), (14, 4), (0, 4)])
m.joint_set("bedding", dip=33, spacing=2.5, length=100, randomness=0.4, seed=12)
m.joint_set("steep", dip=-60, spacing=3, length=8, bridge=1, randomness=0.4, seed=12)
m.support("floor", [(0, 0), (40, 0)])
m.support("left", [(0, 0), (0, 4)], hold="normal")
m.support("right", [(40, 0), (40, 18)], hold="normal")
m.static()
factors = {"dry": scree.fs(m)}
m.water([(0, 4), (14, 4), (21, 15), (40, 16)])
factors["with water"] = scree.fs(m)
m.bolt_row("anchors", [(15, 6), (20, 16)], count=4, length=12, angle=-20, stiffness=2e7, strength=1.5e5, pretension=5e4)
factors["with anchors"] = scree.fs(m)
for name, factor in factors.items():
    print(f"{name}: {float(factor):.4f}")
axis = plt.figure(figsize=(5, 3), layout="constrained").add_subplot(ylabel="factor of safety")
axis.bar_label(axis.bar(list(factors), [float(factor) for factor in factors.values()]), fmt="%.2f")
axis.axhline(1, color="k", linewidth=1)
axis.figure.savefig("anchors-factors.png", dpi=100)
scree.plot(m.run(), joints="state", conditions=True).figure.savefig("anchors.png", dpi=90)
