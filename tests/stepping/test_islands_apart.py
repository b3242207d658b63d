"""What touches is computed for itself: a pile far away, whatever is done anew for it, changes nothing."""
import numpy as np
import scree
from scree.block_files import block_file, box

GROUND = box(-3, 6, -1, 0)
FALLS = np.array([(-0.482, 0.714), (-1.0, 0.62), (-0.987, 0.001)])   # lands in the first step
STRAINED = np.array([(2.586, 1.022), (1.929, 0.911), (2.208, 0.428)])  # springs apart by its initial stress, farther than is looked
AWAY = np.array([64.0, 0.0])


def velocity(folder, name, blocks):
    """Velocities of the block that falls, which is the second, in a pile with these blocks."""
    fixed = [(*(x + offset), number) for number, offset in [(1, 0 * AWAY), (3, AWAY)][:len(blocks) // 2]
             for x in ([-2.9, -0.9], [5.9, -0.9], [1.0, -0.1])]
    (folder / f"{name}.blk").write_text(block_file(name, blocks, fixed))
    (folder / f"{name}.ana").write_text("\n".join([
        "1 4 3 1 0.05 0.01", "2500 0 5e7 0" + " 0" * 9, "2500 24525 5e7 0 0 0 0 0 0 0 0 -1.9278433933983041 0",
        "2500 24525 5e7 0 -10000 -20000 3000 0 0 0 0 0 0", "30 0 0",
        f"&deck geometry='{name}.blk', dialect='short' /\n&method strain='green' /\n&output every=1 /", ""]))
    f = scree.run(folder / f"{name}.ana", output=folder / f"{name}.h5")
    return f.bodies.velocity[:, 1]


def test_a_search_made_wider_elsewhere_leaves_anchors_where_they_are(tmp_path):
    """The strained block outruns the search, so that the step is made anew for all. What landed in it was anchored where it had come
    to, no longer where its velocity would have brought it: 1 % of its velocity."""
    alone = velocity(tmp_path, "alone", [(1, GROUND), (2, FALLS)])
    beside = velocity(tmp_path, "beside", [(1, GROUND), (2, FALLS), (1, GROUND + AWAY), (3, STRAINED + AWAY)])
    assert np.abs(alone[1]).min() > 0.1
    np.testing.assert_allclose(beside, alone, rtol=0, atol=1e-8)
