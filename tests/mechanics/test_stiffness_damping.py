"""Rayleigh damping: modes of strain decay as the closed form says, rigid motions are left alone, and the books close."""
import numpy as np
import pytest
import scree
from scree import block_files, call

RHO, YOUNG, LENGTH = 2.0, 2e4, 2.0
OMEGA = np.sqrt(12 * YOUNG / (RHO * LENGTH**2))  # of a bar whose strain is uniform
SCHEMES = {"Newmark": "scheme='newmark', beta=0.5 / &method strain='small'", "alpha": "scheme='generalized_alpha', rho=1 / &method strain='small'",
           "Bathe's": "scheme='bathe' / &method strain='small'", "momentum": "scheme='energy_momentum', beta=0.5 / &method strain='green'",
           "decomposed": "scheme='newmark', beta=0.5 / &method strain='strain_rotation'"}
KEEPING = {"Newmark": "scheme='newmark', beta=0.5, start='zero' / &method strain='small'", "momentum": SCHEMES["momentum"]}  # no step of theirs dissipates


def bar(folder, damping, form=SCHEMES["Newmark"], stress=-1.0, velocity="0 0 0", periods=2, parts=100, every=1):
    """A bar of one block without Poisson's ratio that begins with a stress, and its history of stress."""
    dt = 2 * np.pi / OMEGA / parts
    (folder / "b.blk").write_text(block_files.block_file("bar", [(1, block_files.box(0, LENGTH, 0, 0.5))]))
    (folder / "b.ana").write_text(f"1\n{periods * parts}\n1 1\n0.05\n{dt}\n{RHO} 0 {YOUNG} 0 {stress} 0 0 0 0 0 {velocity}\n30 0 0\n"
                                  f"&deck geometry='b.blk' /\n&contact method='none' /\n&output every={every} /\n&damping {damping} /\n"
                                  f"&step size={dt} /\n&integrator {form} /\n")
    return scree.run(folder / "b.ana")


def decay(time, alpha, beta):
    """Stress over that at the start, of an oscillator that is let go."""
    z = (alpha / OMEGA + beta * OMEGA) / 2
    turn = OMEGA * np.sqrt(1 - z**2)
    return np.exp(-z * OMEGA * time) * (np.cos(turn * time) + z * OMEGA / turn * np.sin(turn * time))


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("alpha, beta", [(0, 0.1), (0, 0.6), (0.05, 0.05)])
def test_a_mode_decays_as_the_closed_form_says(alpha, beta, name, tmp_path):
    """For numbers alpha/w and beta w; from a twentieth of critical damping to three tenths."""
    alpha, beta = alpha * OMEGA, beta / OMEGA
    r = bar(tmp_path, f"mass={alpha}, stiffness={beta}", SCHEMES[name])
    found = np.array([r.stress(i)[0, 0] for i in range(r.n_frames)]) / -1.0
    assert found == pytest.approx(decay(np.asarray(r.times), alpha, beta), abs=0.01)


def test_a_fraction_at_a_frequency_stands_for_both_coefficients(tmp_path):
    """Half of it by the mass and half by the stiffness."""
    found = []
    w = 1.5 * OMEGA
    for damping in (f"fraction=0.07, frequency={w / (2 * np.pi)}", f"mass={0.07 * w}, stiffness={0.07 / w}"):
        r = bar(tmp_path, damping)
        found.append([r.stress(i)[0, 0] for i in range(r.n_frames)])
    assert found[0] == pytest.approx(found[1], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", KEEPING)
def test_the_books_have_the_energy_that_it_takes(name, tmp_path):
    """All that is lost, to the second order of the step."""
    off = []
    for parts in (50, 100):
        e = bar(tmp_path, f"stiffness={0.3 / OMEGA}", KEEPING[name], parts=parts).history.energy
        damping = np.asarray(e.damping)
        assert (np.diff(damping) >= 0).all() and damping[-1] > 0
        off.append(np.abs(np.asarray(e.dissipated) - damping).max() / damping[-1])
    assert off[1] < 1e-3 and (off[1] < 1e-9 or off[0] / off[1] > 3)


def test_a_block_that_spins_is_not_damped(tmp_path):
    """Its strain stays what it is, as far as it turns: five times around, with the damping of a half."""
    r = bar(tmp_path, f"stiffness={1 / OMEGA}", SCHEMES["momentum"], stress=0, velocity=f"0 0 {OMEGA / 30}", periods=150, parts=10, every=500)
    kinetic = np.asarray(r.history.energy.kinetic)
    assert abs(np.asarray(r.bodies.rotation)[-1, 0]) > 5 * 2 * np.pi * 0.9
    assert kinetic[-1] == pytest.approx(kinetic[0], rel=2e-3)


BAD = {"&damping stiffness=0.1 / &integrator scheme='central_difference' / &method strain='small' /": "unstable",
       "&damping fraction=0.1, frequency=1 / &integrator scheme='small_steps' /": "no strain", "&damping fraction=0.1 /": "damping.frequency",
       "&damping fraction=0.1, frequency=1, mass=2 /": "damping.mass", "&damping frequency=1 /": "damping.fraction"}


@pytest.mark.parametrize("groups", BAD)
def test_damping_that_is_none_is_refused(groups, tmp_path):
    (tmp_path / "g.blk").write_text(block_files.block_file("g", [(1, block_files.box(0, 1, 0, 1))]))
    (tmp_path / "g.ana").write_text(f"1\n5\n1 1\n0.05\n0.1\n1 0 1 0 0 0 0 0 0 0 0 0 0\n30 0 0\n&deck geometry='g.blk' /\n{groups}\n")
    done = call("check", tmp_path / "g.ana")
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and BAD[groups] in done.stderr, done.stderr
