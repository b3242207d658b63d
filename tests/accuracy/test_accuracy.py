"""Steps by accuracy: what a run is off by at its end goes with what was asked, and is what it says."""
import math
import os
import pathlib

import numpy as np
import pytest
import scree
from scree.accuracy import scenes
from scree.validation import references

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
G = 9.81
ARM = math.sqrt(0.5)
RADIUS = math.sqrt(ARM**2 + 1 / 6)  # of gyration of a square about its corner


def pendulum(folder, end, *settings):
    """A square of 1 m that swings from beside its pin: its results, and the error of its angle."""
    decks, _ = scenes.SHIPPED["pendulum"][1]().write(folder, 1.0)
    r = scree.run(*decks, output=folder / "x.h5", settings=[f"step.end_time={end}", "method.strain=green", *settings])
    exact = -math.pi / 2 + references.pendulum(math.pi / 2, (ARM**2 + 1 / 6) / ARM, end, G)
    return r, abs(r.history.rotation[-1, 0] - exact)


def triangle(folder, *settings):
    """The turning triangle, of which small strain makes area: its results, and that."""
    decks, _ = scenes.SHIPPED["triangle"][1]().write(folder, 1.0)
    r = scree.run(*decks, output=folder / "x.h5", settings=["step.end_time=1", *settings])
    return r, r.bodies.area[-1, 0] / r.bodies.area[0, 0] - 1


@pytest.mark.parametrize("end", [0.5, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("scheme", [["integrator.scheme=energy_momentum", "integrator.beta=0.5"], ["integrator.scheme=energy_decaying"],
                                    ["integrator.scheme=newmark"]])
def test_the_estimate_is_the_error(tmp_path, end, scheme):
    """It is within a factor 2, also where half a period has brought the errors of steps against each other."""
    r, error = pendulum(tmp_path, end, *scheme, "step.size=0.01", "output.error=estimate")
    assert error / 2 < r.history.error.displacement[-1] / RADIUS < 2 * error
    assert r.bodies.error[-1, 0] == r.history.error.displacement[-1]


@pytest.mark.parametrize("accuracy", [1e-2, 1e-3])
def test_a_pendulum_is_off_by_what_was_asked(tmp_path, accuracy):
    """At most by 3 times that share of its way, and within 3 of it."""
    r, error = pendulum(tmp_path, 2.0, f"step.accuracy={accuracy}", "step.size=0.04")
    share = error / 2  # of the chord of half a turn
    assert accuracy / 3 < share < 3 * accuracy
    assert r.history.step_size.max() <= 0.04 * (1 + 1e-6) and r.history.time[-1] == 2.0


def place_of_bounce(end):
    """Height of a body that falls by 1 m and bounces with restitution 1/2, less 1 m."""
    left, speed = end - math.sqrt(2 / G), math.sqrt(2 * G)
    if left < 0:
        return -G * end**2 / 2
    speed /= 2
    while left > 2 * speed / G:
        left, speed = left - 2 * speed / G, speed / 2
    return speed * left - G * left**2 / 2 - 1


def bounce(folder, end, *settings):
    """A square that falls on the flat and bounces: its results, and the error of its place."""
    scene = scenes.SHIPPED["bounce"][1]()
    decks, more = scene.write(folder, 1.0)
    r = scree.run(*decks, output=folder / "x.h5", settings=[*more, f"step.end_time={end}", *settings])
    return r, abs(r.measured_points.displacement[-1, 0, 1] - place_of_bounce(end))


@pytest.mark.parametrize("end", [0.8, 1.1])  # in its first and in its second flight
@pytest.mark.parametrize("size", [8e-3, 3e-3, 1e-3])
def test_the_instants_of_bounces_are_in_the_estimate(tmp_path, end, size):
    """They are nearly all of the error: 3 to 8 mm in steps of 8 ms."""
    r, error = bounce(tmp_path, end, f"step.size={size}", "output.error=estimate")
    assert error > 1e-4
    assert error / 1.2 < r.history.error.displacement[-1] < 1.2 * error


@pytest.mark.parametrize("end", [0.12, 0.15])
@pytest.mark.parametrize("size", [4e-3, 1.3e-3, 5e-4])
def test_the_instant_of_a_blow_on_a_corner_is_in_the_estimate(tmp_path, end, size):
    """A square that sticks by a corner and spins off: in place and angle, by friction and by the turn of its arm."""
    decks, more = scenes.SHIPPED["corner-drop"][1]().write(tmp_path, 1.0)
    r = scree.run(*decks, output=tmp_path / "x.h5", settings=[*more, f"step.end_time={end}", f"step.size={size}", "output.error=estimate"])
    x, y, angle = references.SlopeImpact(0.05, 0.05, 0.3).place((0, 0), end)
    moved = r.measured_points.displacement[-1, 0]
    error = math.hypot(moved[0] - x, moved[1] - y, (r.history.rotation[-1, 1] - angle) * 0.05 / math.sqrt(6))
    assert error / 1.3 < r.history.error.displacement[-1] < 1.3 * error


@pytest.mark.parametrize("end", [0.8, 0.98, 1.3])  # up the arc, at the top, down again
def test_the_instants_of_kinks_are_in_the_estimate(tmp_path, end):
    """A block on a track of chords without friction; held against steps of a twentieth."""
    decks, more = scenes.SHIPPED["arc-slide"][1]().write(tmp_path, 1.0)
    coarse, fine = (scree.run(*decks, output=tmp_path / f"{size}.h5",
                              settings=[*more, f"step.end_time={end}", f"step.size={size}", "method.strain=green", "output.error=estimate"])
                    for size in (2e-3, 1e-4))
    error = np.linalg.norm(coarse.measured_points.position[-1, 0] - fine.measured_points.position[-1, 0])
    assert error / 2 < coarse.history.error.displacement[-1] < 2 * error


@pytest.mark.parametrize("accuracy", [1e-2, 1e-3, 1e-4])
def test_what_bounces_is_off_by_no_more_than_was_asked(tmp_path, accuracy):
    """In flight, of a way of 1 m: steps end at the blows. By steps that do not, it would be off by 5 to 80 times that."""
    _, error = bounce(tmp_path, 0.8, f"step.accuracy={accuracy}", "step.size=8e-3")
    assert error < accuracy


@pytest.mark.parametrize("strain", ["small", "green", "auto"])
@pytest.mark.parametrize("accuracy", [1e-3, 1e-4])
def test_a_block_that_rings_at_first_is_off_by_what_was_asked(tmp_path, strain, accuracy):
    """A block that falls back about its corner gets its weight at once: what its contact rings is no error that stays, and shortens no step
    after it. The estimate is within a factor 2."""
    scene = scenes.SHIPPED["rocking-block"][1]()
    decks, settings = scene.write(tmp_path, 1.0)
    r = scree.run(*decks, output=tmp_path / "x.h5",
                  settings=[*settings, f"step.end_time={scene.end}", f"step.accuracy={accuracy}", "step.size=0.04", f"method.strain={strain}"])
    exact = scene.quantities["angle"].exact
    share = abs(r.history.rotation[-1, 1] / exact - 1)
    assert accuracy / 3 < share < 3 * accuracy
    assert share / 2 < r.history.error.share[-1] < 2 * share


@pytest.mark.parametrize("accuracy", [1e-2, 3e-3])
def test_small_strain_makes_no_more_area_than_was_asked(tmp_path, accuracy):
    r, growth = triangle(tmp_path, f"step.accuracy={accuracy}", "step.size=0.04", "method.strain=small")
    assert accuracy / 3 < growth < 3 * accuracy
    assert r.history.error.growth[-1] == pytest.approx(growth, rel=0.05)


def falling(folder, boxes, end):
    """A run of boxes that fall on the first, and on each other, and bounce with all of their speed."""
    lines = [f"{x0} {y0} {x1} {y1} 1" for a, b, c, d in boxes
             for (x0, y0), (x1, y1) in zip([(a, b), (c, b), (c, d), (a, d)], [(c, b), (c, d), (a, d), (a, b)])]
    (folder / "a.geo").write_text("\n".join(["1e-6", f"{len(lines)} 0", "1", "0", "2", "0", "0", "0", *lines, "0.125 -0.5 0.25 -0.5 2",
                                            "0.25 -0.5 0.25 -0.5", "2.75 -0.5 2.75 -0.5", ""]))
    rock = "2500 {} 1e9 0.25\n0 0 0\n0 0 0\n0 0 0\n"
    (folder / "a.ana").write_text(f"1\n{round(end / 0.005)}\n2 1\n0.05\n0.005\n{rock.format(24525)}{rock.format(0)}30 0 0\n&deck geometry='a.geo' /\n"
                                  "&contact restitution=1 /\n&step accuracy=1e-3, sleep=0 /\n")
    return scree.run(folder / "a.ana", timeout=300)


def test_a_blow_whose_instant_stays_unknown_holds_no_run_up(tmp_path):
    """The step that ends at a blow is made, however much that leaves unknown. It was made again for ever."""
    f = falling(tmp_path, [(0, -1, 3, 0), (1, 0.1, 2, 0.6), (1.02, 0.65, 1.99, 1.15), (1.04, 1.2, 1.98, 1.7)], 2.0)
    assert f.scene.status == "complete" and f.history.time[-1] == pytest.approx(2.0)


def test_who_was_lost_on_the_way_is_not_found_again(tmp_path):
    """Eight blocks that bounce on each other end anywhere: a run says so to its end, and errors do not multiply from blow to blow: they
    came to 1e27 of the displacement on the way, and to 1e-27 at the end."""
    f = falling(tmp_path, [(0, -1, 3, 0), *((1, 0.1 + 0.56 * i, 2, 0.6 + 0.56 * i) for i in range(8))], 6.0)
    lost = f.history.error.share >= 1
    assert lost[-1] and (np.maximum.accumulate(lost) == lost).all() and f.history.error.share.max() < 1e6


def test_frames_fall_on_their_times(tmp_path):
    r, _ = pendulum(tmp_path, 1.0, "step.accuracy=1e-3", "step.size=0.04", "output.interval=0.13")
    np.testing.assert_array_equal(r.times, [0.13 * k for k in range(8)] + [1.0])
    sizes = r.history.step_size
    assert (sizes[1:] / sizes[:-1]).min() > 0.15  # none is a sliver


def test_what_rests_gets_to_the_largest_step(tmp_path):
    """Blocks that are put up at once ring for a while, and stand."""
    decks, settings = scenes.SHIPPED["wall"][1]().write(tmp_path, 1.0)
    r = scree.run(*decks, output=tmp_path / "x.h5",
                  settings=[*settings, "step.end_time=0.5", "step.size=0.02", "step.accuracy=1e-3"])
    assert r.history.step_size.max() == pytest.approx(0.02) and len(r.history.time) < 300


@pytest.mark.parametrize("accuracy", [1e-2, 1e-3, 1e-4])
def test_what_rings_at_the_start_is_not_followed(tmp_path, accuracy):
    """A block on a plane gets its weight at once: its contacts ring ten times in a hundredth of the run, and it slides away evenly."""
    decks, settings = scenes.SHIPPED["slide"][1]().write(tmp_path, 1.0)
    r = scree.run(*decks, output=tmp_path / "x.h5", settings=[*settings, f"step.accuracy={accuracy}", "step.size=2e-3"])
    way = np.linalg.norm(r.measured_points.displacement[-1, 0])
    assert way == pytest.approx(0.5 * G * (0.5 - 0.3 * math.sqrt(0.75)), rel=max(accuracy, 1e-3))
    assert (r.history.time < 0.01).sum() < 100


def test_nothing_is_said_of_errors_unless_asked(tmp_path):
    r, _ = pendulum(tmp_path, 0.1)
    assert "error" not in r.history and "error" not in r.bodies


@pytest.mark.parametrize("settings, said", [
    (["method.preset=shi"], "step.accuracy only with step.control='fixed'|method.preset='none'"),
    (["contact.rules=shi", "method.preset=shi"], "method.preset='none'"),
    (["step.accuracy=0"], "above 0")])
def test_what_cannot_be_is_refused_in_a_line(tmp_path, settings, said):
    with pytest.raises(scree.RunFailed, match=said) as failed:
        pendulum(tmp_path, 0.1, "step.accuracy=1e-3", *settings)
    assert failed.value.status == 2 and len(failed.value.said.strip().splitlines()) == 1


def test_a_static_deck_is_refused(tmp_path):
    decks, _ = scenes.SHIPPED["cantilever"][1]().write(tmp_path, 1.0)
    with pytest.raises(scree.RunFailed, match="step.accuracy only with k01 above 0") as failed:
        scree.run(*decks, output=tmp_path / "x.h5", settings=["step.accuracy=1e-3"])
    assert failed.value.status == 2


ROTATION = SOURCE / "input" / "paper" / "rotation"


def test_steps_of_newmark_change_only_where_that_makes_nothing(tmp_path):
    """T4 of Zhang et al. 2019 has beta 1/2, gamma 1/2, whose roots are +-i: a step that changes makes its stress grow. It is refused, where
    it is; its accuracy is that of the energy-momentum form."""
    asked = ["step.accuracy=1e-2"]
    with pytest.raises(scree.RunFailed, match=r"t4.ana:14: expected integrator.gamma at most \(beta \+ 1/2\)\^2/4") as problem:
        scree.run(ROTATION / "t4.ana", output=tmp_path / "x.h5", settings=asked)
    assert problem.value.status == 2
    for more in (["integrator.beta=0.59"], ["integrator.gamma=0.26"]):
        with pytest.raises(scree.RunFailed, match="expected integrator.gamma at most"):
            scree.run(ROTATION / "t4.ana", output=tmp_path / "x.h5", settings=[*asked, *more])
    scree.run(ROTATION / "t3.ana", output=tmp_path / "x.h5", settings=["step.accuracy=0.1", "step.end_time=0.2"])


@pytest.mark.parametrize("accuracy", [1e-2, 1e-3, 1e-4])
def test_the_triangle_that_conserves_is_off_by_no_more_than_was_asked(tmp_path, accuracy):
    """T4 with the energy-momentum form, that keeps its spin and has its order."""
    r = scree.run(ROTATION / "t4.ana", output=tmp_path / "x.h5",
                  settings=[f"step.accuracy={accuracy}", "integrator.scheme=energy_momentum", "integrator.start=dissipative", "step.size=0.04",
                            "step.end_time=1"])
    assert abs(r.history.rotation[-1, 0] - 2 * math.pi) / 2 < 3 * accuracy
    assert abs(r.history.momentum[-1, 2] / r.history.momentum[0, 2] - 1) < 1e-9


@pytest.mark.parametrize("steps, lost", [(63, True), (6300, False)])
def test_a_run_warns_of_swings_that_its_estimate_does_not_have(steps, lost, tmp_path):
    """5000 kg on two bolts of 1e6 N/m, thrown at 1 m/s: the closed form is sin(20 t)/20."""
    (tmp_path / "a.geo").write_text("0.001\n4 4 0 2 0 0 1 0\n0 0 2 0 1\n2 0 2 1 1\n2 1 0 1 1\n0 1 0 0 1\n"
                                    "0.5 0.5 0.5 5 1e6 0 0\n1.5 0.5 1.5 5 1e6 0 0\n1 0.5\n&bolts outside='ground' /\n")
    (tmp_path / "a.ana").write_text("1 100000 1 1 0.05 0.1\n2500 0 1e10 0.25\n0 0 0  0 0 0  0 -1 0\n45 0 0\n&deck geometry='a.geo' /\n")
    period = 2 * np.pi / 20
    done = scree.call("run", tmp_path / "a.ana", "-o", tmp_path / "a.h5", "--quiet", "--set", f"step.size={period / steps}",
                      "--set", f"step.end_time={1.25 * period}", "--set", "output.error=estimate")
    r = scree.read(tmp_path / "a.h5")
    assert done.returncode == 0 and ("swing on bolts" in done.stderr) == lost
    assert (abs(r.bodies.centroid[-1, 0, 1] - (0.5 - 1 / 20)) > 1e-2 / 20) == lost
