"""A static stage may end without a block that nothing stops (stage.loose)."""
import numpy as np
import pytest
import scree

# A floor, a block on it, and a block in the air that points hold in the first stage.
BLOCKS = """3 0 24
0 0 0
1 1 4
1 9 12
1 17 20
{}"""
STAGES = "&stage name='let go'{0} /\n&support points=none /\n&stage name='load'{0} /\n&boundary lines=1 1 2 1, pressure=1e4 1e4 /\n"


def block(x, y, width, height):
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)]
    return "".join(f"1 {a} {b}\n" for a, b in corners) + "0 0 0\n" * 3


def decks(folder, loose):
    rows = block(0, -1, 6, 1) + block(1, 0, 1, 1) + block(4, 3, 1, 1)
    (folder / "g.blk").write_text(BLOCKS.format(rows))
    (folder / "g.ana").write_text("0 300 1 1 0.05 0.01\n2500 25000 1e9 0.2\n0 0 0\n0 0 0\n0 0 0\n30 0 0\n&deck geometry='g.blk' /\n&step balance=1e-4 /\n"
                                  "&support both=0 -1 6 -1, points=4.2 3.5  4.8 3.5 /\n" + STAGES.format(f", loose='{loose}'" if loose else ""))
    return folder / "g.ana"


@pytest.mark.parametrize("loose", ["", "stop"])
def test_a_loose_block_ends_the_run(loose, tmp_path):
    result = scree.run(decks(tmp_path, loose), output=tmp_path / "g.h5")
    assert result.scene.status.startswith("moves: stage 2 (let go): block 3"), result.scene.status
    assert result.history.stage[-1] == 2


def test_stages_go_on_without_it_and_name_it(tmp_path):
    """The others are in equilibrium with the load of the last stage; the warning names what falls."""
    result = scree.run(decks(tmp_path, "go on"), output=tmp_path / "g.h5")
    assert result.scene.status == "complete" and result.history.stage[-1] == 3
    assert any("stage 2 (let go) ended without block 3, which nothing stops" in warning for warning in result.warnings), result.warnings
    assert result.bodies.stress[-1, 1, 1] == pytest.approx(-1e4 - 25e3 / 2, rel=1e-2)
    assert result.bodies.centroid[-1, 2, 1] < 3.5 - 0.01
    assert result.history.unbalanced[-1] <= 1e-4


def test_a_restart_knows_it(tmp_path):
    deck = decks(tmp_path, "go on")
    whole = scree.run(deck, output=tmp_path / "whole.h5")
    steps = np.flatnonzero(whole.history.stage == 2)
    scree.run(deck, output=tmp_path / "g.h5", settings=[f"stage(2).step.count={len(steps) // 2}"])
    last = whole.bodies.centroid[-1].tobytes()
    done = scree.call("run", "--restart", "g.h5", "--set", "stage(2).step.count=300", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert scree.read(tmp_path / "g.h5").bodies.centroid[-1].tobytes() == last
