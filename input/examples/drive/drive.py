"""A tunnel 120 m deep under K0 = 1.5, dug in two stages. A ring of bolts holds the heading before the bench is dug.

Expect:
    closure of the walls = 3.76 within 2 %: mm, in the last stage
"""
import matplotlib.pyplot as plt
import scree

m = scree.Model("drive", title="A tunnel 120 m deep, dug in two stages under K0 = 1.5, with a ring of bolts.")
m.material("rock", density=2600, young=5e9)
m.joint_material("joints", phi=35)
m.joint_material("face", phi=45, cohesion=1e9, tensile_strength=1e9)
m.rock([(-20, -20), (20, -20), (20, 20), (-20, 20)])
m.excavation("heading", scree.arc((0, 0), 4, 0, 180, sides=12), material="face")
m.excavation("bench", [(4, 0), (-4, 0), (-4, -3), (4, -3)], material="face")
m.joint_set("joints", dip=50, spacing=4, length=200, randomness=0.3, seed=3)
m.joint_set("joints", dip=-35, spacing=5, length=200, randomness=0.3, seed=4)
m.in_situ(surface=120, k0=1.5)
m.load("overburden", [(-20, 20), (20, 20)], pressure=100 * 25506)
m.support("floor", [(-20, -20), (20, -20)])
m.support("sides", [(-20, -20), (-20, 20)], hold="normal")
m.support("sides", [(20, -20), (20, 20)], hold="normal")
m.static()
m.stage("heading", reset="displacements")
m.excavate("heading")
m.stage("bench")
m.bolt_ring("ring", (0, 0), 4, count=7, length=8, stiffness=3e7, strength=2e5, start=20, end=160)
m.excavate("bench")
r = m.run()
axis = plt.figure(figsize=(5, 3), layout="constrained").add_subplot(ylabel="closure of the walls [mm]")
closure = 1000 * r.closure((-4, 0), (4, 0))
ends = [max(k for k in range(r.n_frames) if r.frame_stages[k] == stage) for stage in (1, 2, 3)]
axis.bar_label(axis.bar(["in situ", "heading", "bolts and bench"], closure[ends]), fmt="%.2f")
axis.figure.savefig("drive-closure.png", dpi=100)
print(f"closure of the walls: {closure[-1]:.3f}")
scree.plot(r, joints="state", magnify=200).figure.savefig("drive.png", dpi=70)
