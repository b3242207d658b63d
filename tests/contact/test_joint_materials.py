"""Which joint material acts at a contact where pieces of several meet: the piece that bears, whatever the numbers of materials are."""
import math
import random

import numpy as np
import pytest
import scree
from scree.block_files import block_file, box

ROCK = ["2500 25000 1e9 0.25" + " 0" * 9, "2300 23000 5e8 0.2" + " 0" * 9]

# A concrete dam on rock under water to its crest, uplift from full to none: a base of 24 m between banks of another joint material.
DAM = """1e-6
9 9  1 0 0 0  2 0
-40 -30 70 -30 BANK
70 -30 70 0 BANK
70 0 24 0 BANK
24 0 0 0 BASE
0 0 -40 0 BANK
-40 0 -40 -30 BANK
24 0 5 30 BANK
5 30 0 30 BANK
0 30 0 0 BANK
1 15 1.5 15 2
2.5 29.9
0.1 0.1
"""
LOADED = """0 100 2 2 0.05 0.1
2600 25506 15e9 0.25 0 0 0 0 0 0 0 0 0
2400 23544 25e9 0.2 0 0 0 0 0 0 0 0 0
{} 0 0
{} 0 0
&deck geometry='dam.geo' /
&method model='nmm', plane='strain' /
&cover edge={} /
&support both=-40 -30 70 -30, normal=-40 -30 -40 0  70 -30 70 0 /
&step balance=1e-4 /
&boundary lines=-40 0 0 0  0 0 0 30  0 0 24 0, pressure=294300 294300  294300 0  294300 0 /
"""


def write_dam(folder, base, phi, edge=2):
    """The dam with joint material `base` at its base and the other one elsewhere; friction angles by number."""
    (folder / "dam.geo").write_text(DAM.replace("BASE", str(base)).replace("BANK", str(3 - base)))
    (folder / "dam.ana").write_text(LOADED.format(phi[1], phi[2], edge))
    return folder / "dam.ana"


@pytest.mark.parametrize("banks", [20, 45])
@pytest.mark.parametrize("base", [1, 2])
@pytest.mark.parametrize("share, stands", [(0.992, True), (1.008, False)])
def test_a_dam_slides_by_the_strength_of_its_base(share, stands, base, banks, tmp_path):
    """Weight less uplift N, thrust T: it slides where tan phi of the base is below T/N, whatever the banks have. It stood with a base
    7 % weaker than that where the base had the smaller number."""
    normal = 23544 * (24 + 5) / 2 * 30 - 294300 * 24 / 2
    thrust = 294300 * 30 / 2
    phi = {base: math.degrees(math.atan(thrust / normal / share)), 3 - base: banks}
    scree.call("run", write_dam(tmp_path, base, phi), "--quiet", "-o", tmp_path / "dam.h5")
    assert scree.read(tmp_path / "dam.h5").summary["status"].startswith("complete" if stands else "moves: block 2")


def wall(rnd):
    """Courses of blocks that lie flush on a floor, their edges divided at random, each piece with a joint material from 1 to 4."""
    blocks = [(1, box(-1, 3, -1, 0))]
    for course in range(3):
        ends = [0.0, *sorted(rnd.sample([0.5, 0.8, 1.0, 1.4, 1.5, 1.7], rnd.randint(1, 3))), 2.0]
        blocks += [(rnd.randint(1, 2), box(left, right, course, course + 1)) for left, right in zip(ends, ends[1:])]
    divided = []
    for rock, outline in blocks:
        corners = []
        for start, end in zip(outline, np.roll(outline, -1, axis=0)):
            shares = [0.0, *sorted(rnd.sample([0.25, 0.4, 0.5, 0.75], rnd.randint(0, 2)))]
            corners += [start + s * (end - start) for s in shares]
        divided.append((rock, np.array(corners), [rnd.randint(1, 4) for _ in corners]))
    return divided


def write_wall(folder, number, rock_number, groups, seed=7):
    """A wall pushed aside, with joint material `number[i]` in place of i + 1, and block materials likewise."""
    blocks = [(rock_number[rock - 1], corners, [number[j - 1] for j in joints]) for rock, corners, joints in wall(random.Random(seed))]
    (folder / "a.blk").write_text(block_file("wall", blocks, [(-0.9, -0.9, 1), (2.9, -0.9, 1), (1.0, -0.9, 1)]))
    strength = ["10 0 0", "40 0 0", "25 1e3 0", "25 0 0"]
    lists = {"kn": "1e10 4e9 2e9 1e9", "jrc": "2 8 0 12"}
    for name, values in lists.items():
        groups = groups.replace(name.upper(), " ".join(by_number(values.split(), number)))
    (folder / "a.ana").write_text("\n".join([
        "1 40 2 4 0.05 0.002", *by_number(ROCK, rock_number), *by_number(strength, number),
        f"&deck geometry='a.blk', dialect='short' /\n&acceleration table=0 -6 0  1e9 -6 0 /\n{groups}", ""]))
    return folder / "a.ana"


def by_number(rows, number):
    """Rows in the order of the numbers that they get."""
    return [row for _, row in sorted(zip(number, rows))]


JOINTS = """&window x=0 30, y=0 20, material=OUTLINE /
&slope x=0 10 18 30, y=6 6 18 18, material=OUTLINE /
&joint_set dip=-60, spacing=3, length=200, material=FIRST /
&joint_set dip=25, spacing=4, length=9, bridge=1, randomness=0.4, material=SECOND /
&support x=0 30, y=0 0, hold='both' /
&deck least_area=0.5 /
&seed value=3 /
"""


def write_slope(folder, number, rock_number, groups):
    """A slope of two joint sets, its outline of a third joint material."""
    first, second, outline, _ = number
    (folder / "a.joints").write_text(JOINTS.replace("FIRST", str(first)).replace("SECOND", str(second)).replace("OUTLINE", str(outline)))
    assert scree.call("joints", "a.joints", cwd=folder).returncode == 0
    strength = by_number(["20 0 0", "30 0 0", "10 0 0", "15 0 0"], number)
    (folder / "a.ana").write_text("\n".join(["1 40 1 4 0.05 0.005", ROCK[0], *strength, f"&deck geometry='a.geo' /\n{groups}", ""]))
    return folder / "a.ana"


SCENES = {
    "blocks": (write_wall, ""),
    "elements": (write_wall, "&method model='nmm' /\n&cover edge=0.5 /"),
    "stiffness and roughness": (write_wall, "&joints kn=KN, ks=KN, jrc=JRC, jcs=1e8 1e8 1e8 1e8 /"),
    "Shi's rules": (write_wall, "&method preset='shi' /"),
    "joint sets": (write_slope, ""),
}


@pytest.mark.parametrize("joints, rocks", [((4, 3, 2, 1), (2, 1)), ((2, 3, 1, 4), (1, 2)), ((3, 1, 2, 4), (2, 1))])
@pytest.mark.parametrize("scene", SCENES)
def test_renumbering_materials_changes_nothing(scene, joints, rocks, tmp_path):
    """The same scene with other numbers of its joint and block materials moves alike, to the last bit. Where faces of two materials lay
    on each other the larger number acted."""
    write, groups = SCENES[scene]
    runs = []
    for name, numbers in (("as it is", ((1, 2, 3, 4), (1, 2))), ("renumbered", (joints, rocks))):
        (tmp_path / name).mkdir()
        runs.append(scree.run(write(tmp_path / name, *numbers, groups), output=tmp_path / f"{name}.h5"))
    one, other = runs
    assert one.history.contacts[-1, 1:].sum() > 0
    for what in ("centroid", "velocity", "stress"):
        np.testing.assert_array_equal(getattr(one.bodies, what), getattr(other.bodies, what))
    np.testing.assert_array_equal(one.history.contacts, other.history.contacts)


@pytest.mark.parametrize("base", [1, 2])
def test_check_names_where_joint_materials_meet(base, tmp_path):
    done = scree.call("check", write_dam(tmp_path, base, {1: 45, 2: 45}))
    line, = (line for line in done.stdout.splitlines() if line.startswith("joint materials that meet "))
    assert "2 places" in line and "1 and 2 at (0, 0)" in line and "1 and 2 at (24, 0)" in line


def test_check_names_nothing_where_one_material_meets_itself(tmp_path):
    (tmp_path / "dam.geo").write_text(DAM.replace("BASE", "1").replace("BANK", "1"))
    (tmp_path / "dam.ana").write_text(LOADED.format(45, 45, 6))
    done = scree.call("check", tmp_path / "dam.ana")
    assert done.returncode == 0 and "joint materials that meet" not in done.stdout
