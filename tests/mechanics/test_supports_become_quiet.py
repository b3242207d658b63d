"""Rock with weight that comes to rest on supports, which absorbing edges replace in a later stage."""
import numpy as np
import pytest
import scree
from scree import block_files, call

SLOPE = [(0, 0), (100, 0), (100, 20), (60, 20), (40, 40), (0, 40)]
LAYERS = [[(0, 0), (100, 0), (100, 10), (0, 10)], [(0, 10), (100, 10), (100, 20), (60, 20), (50, 30), (0, 30)], [(0, 30), (50, 30), (40, 40), (0, 40)]]
BLOCKS = [block_files.box(0, 50, 0, 10), block_files.box(50, 100, 0, 10), [(0, 10), (60, 10), (60, 20), (50, 30), (0, 30)],
          block_files.box(60, 100, 10, 20), [(0, 30), (50, 30), (40, 40), (0, 40)]]
MESH = "model='nmm', strain='small' / &cover edge=4, angle=10 /"
SCENES = {"blocks": (BLOCKS, "model='dda' /"), "blocks, penalty springs hold them": (BLOCKS, "model='dda' / &fixed_points method='penalty' /"),
          "blocks, Green strain": (BLOCKS, "strain='green' / &contact method='augmented' /"), "a mesh": ([SLOPE], MESH),
          "a mesh with joints": (LAYERS, MESH)}
HELD = "normal=0 0 0 40 100 0 100 20, both=0 0 100 0"
QUIET = "&support normal=none, both=none / &absorbing lines={} /"
SIDES = "0 0 0 40 100 0 100 20 0 0 100 0"
STRESS = "-1e4 -2e4 0"


def slope(folder, blocks, method, later, first=0, stress=STRESS):
    """A deck whose first stage brings the rock to rest on its supports: static, or dynamic with mass damping."""
    (folder / "s.blk").write_text(block_files.block_file("slope", [(1, block) for block in blocks]))
    start = f"&step balance={'1e-7' if 'penalty' in method else '1e-10'} /" if first == 0 else "&damping mass=4 / &step size=0.02, end_time=20 /"
    (folder / "s.ana").write_text(f"{first}\n2000\n1 1\n0.05\n0.5\n2500 25000 1e9 0.25 {stress} 0 0 0 0 0 0\n35 0 0\n"
                                  f"&deck geometry='s.blk', dialect='short' /\n&method plane='strain', {method}\n&output every=50 /\n"
                                  f"{start}\n&support {HELD} /\n{later}\n")
    return folder / "s.ana"


def moved_since(r, stage):
    """Largest displacement of a vertex since the end of a stage."""
    frames = [i for i in range(r.n_frames) if r.frame_stages[i] >= stage]
    first = max(i for i in frames if r.frame_stages[i] == stage)
    rest = np.asarray(r.vertices(first))
    return max(np.abs(np.asarray(r.vertices(i)) - rest).max() for i in frames if i > first)


@pytest.mark.parametrize("name", SCENES)
def test_a_slope_at_rest_stays_at_rest_where_its_boundary_becomes_quiet(name, tmp_path):
    """For 20 s, to a millionth of a block of 10; the static tractions are the weight and the initial stress of the rock."""
    blocks, method = SCENES[name]
    later = "&stage name='quiet', kind='dynamic' /\n" + QUIET.format(SIDES) + "\n&step size=0.1, end_time=20 /"
    r = scree.run(slope(tmp_path, blocks, method, later))
    assert r.history.time[-1] > 20
    assert moved_since(r, 1) < 1e-6 * 10
    assert r.history.energy.kinetic[-1] < 1e-12 * r.history.energy.strain[-1]


def test_a_dynamic_stage_hands_its_reactions_over_too(tmp_path):
    """It came to rest by damping. What is left of its motion is what the next stage moves by."""
    later = "&stage kind='dynamic' /\n" + QUIET.format(SIDES) + "\n&damping mass=0 /\n&step size=0.02, end_time=10 /"
    r = scree.run(slope(tmp_path, BLOCKS, "model='dda' /", later, first=1))
    assert moved_since(r, 1) < 1e-6 * 10


@pytest.mark.parametrize("lines", [SIDES + " 0 0 30 0", "0 0 0 40 100 0 100 20 0 0 35 0 35 0 100 0"])
def test_edges_hand_over_to_the_parts_that_absorb(lines, tmp_path):
    """Lines that name an edge in two parts, or part of it again, bear what the whole edge did."""
    r = scree.run(slope(tmp_path, BLOCKS, "model='dda' /", "&stage kind='dynamic' /\n" + QUIET.format(lines) + "\n&step size=0.02, end_time=5 /"))
    assert moved_since(r, 1) < 1e-6 * 10


def test_stages_after_it_keep_the_static_forces_and_supports_take_them_back(tmp_path):
    """A stage that absorbs on, and one with the supports of the first."""
    step = "\n&step size=0.02, end_time=2 /\n"
    later = "&stage kind='dynamic' /\n" + QUIET.format(SIDES) + step + "&stage kind='dynamic' /" + step \
        + f"&stage kind='dynamic' /\n&absorbing lines=none /\n&support {HELD} /" + step
    r = scree.run(slope(tmp_path, BLOCKS, "model='dda' /", later))
    assert r.frame_stages[-1] == 4 and moved_since(r, 1) < 1e-6 * 10


def test_an_edge_that_no_support_held_bears_nothing(tmp_path):
    """Without supports in the first stage the rock falls through its quiet boundary, at the speed that the dashpots let it reach."""
    later = "&stage kind='dynamic' /\n" + QUIET.format("0 0 100 0") + "\n&step size=0.02, end_time=2 /"
    deck = slope(tmp_path, [block_files.box(0, 100, 0, 10)], "model='dda' /", later, stress="0 0 0")
    deck.write_text(deck.read_text().replace(f"&support {HELD} /", "&support both=0 10 100 10 /"))
    r = scree.run(deck)
    impedance = np.sqrt(2500 * 1e9 * 0.75 / (1.25 * 0.5))
    speed = 25000 * 10 / impedance
    assert np.asarray(r.velocity())[-1][1] == pytest.approx(-speed, rel=1e-3)


def column(folder, weight):
    """A column 2 x 20 on a quiet base; a pulse of shear comes in after it came to rest. Returns the results of both stages."""
    time = np.linspace(0, 0.02, 41)
    pulse = "\n".join(f"{t} {v} 0" for t, v in zip(time.tolist(), (0.01 * np.sin(np.pi * time / 0.02)**2).tolist()))
    (folder / "c.blk").write_text(block_files.block_file("column", [(1, block_files.box(0, 2, 0, 20))], measured=[(1.0, 19.99, 1)]))
    (folder / "c.ana").write_text(
        f"0\n2000\n1 1\n0.05\n0.5\n2500 {weight} 1e10 0.25 0 0 0 0 0 0 0 0 0\n35 0 0\n&deck geometry='c.blk', dialect='short' /\n"
        "&method model='nmm', plane='strain', strain='small' / &cover edge=1, angle=10 / &integrator scheme='newmark', beta=0.5 /\n"
        "&support both=0 0 2 0, y=0 0 0 20 2 0 2 20 /\n&step balance=1e-10 /\n&stage kind='dynamic' /\n&support both=none /\n"
        f"&absorbing base=0 0 2 0, table={pulse} /\n&step size=1e-4, end_time=0.06 /\n")
    return scree.run(folder / "c.ana")


def test_a_wave_moves_rock_with_weight_as_rock_without(tmp_path):
    """Small strain is linear, so that static forces and waves add up."""
    speeds = []
    for weight in (0, 25000):
        folder = tmp_path / str(weight)
        folder.mkdir()
        r = column(folder, weight)
        now = np.asarray(r.history.time) > r.history.time[-1] - 0.06
        speeds.append(np.asarray(r.measured_points.velocity)[now, 0, 0])
    assert np.abs(speeds[0]).max() == pytest.approx(0.02, rel=0.02)  # a free top moves twice as fast as the wave
    assert speeds[1] == pytest.approx(speeds[0], abs=1e-6 * 0.02)


def test_the_books_have_the_work_of_the_static_forces(tmp_path):
    """Rock that the ground shakes loses energy to its quiet boundary alone, in a step that does not dissipate."""
    later = "&stage kind='dynamic' /\n" + QUIET.format(SIDES) + "\n&acceleration table=0 0 0 0.1 2 0 0.3 -2 0 0.4 0 0 /\n" \
        "&integrator scheme='newmark', beta=0.5, start='zero' /\n&step size=0.002, end_time=1 /"
    r = scree.run(slope(tmp_path, [SLOPE], MESH, later))
    e = r.history.energy
    now = np.asarray(r.history.time) > r.history.time[-1] - 1
    assert np.asarray(e.damping)[-1] > 0
    off = np.asarray(e.dissipated)[now] - np.asarray(e.damping)[now]
    assert np.ptp(off) < 1e-3 * np.asarray(e.damping)[-1]
