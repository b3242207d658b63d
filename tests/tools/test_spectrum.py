"""tools/spectrum and scree.response_spectrum: closed forms, scipy, and records that end at rest."""
import subprocess

import numpy as np
import pytest
import scree
from scipy.integrate import solve_ivp
from scree import ground_motion
from scree.program import TREE


def noise(seed=1, n=400, dt=0.01):
    time = np.arange(n) * dt
    return time, np.random.default_rng(seed).normal(size=n) * np.sin(np.pi * time / time[-1])


@pytest.mark.parametrize("damping", [0.0, 0.02, 0.2, 0.7])
def test_the_spectrum_is_that_of_an_integration_by_other_means(damping):
    """Runge-Kutta of order eight, with 100 values in each step of the record."""
    time, values = noise(n=120)
    periods = np.array([0.05, 0.3, 1.7])
    found = scree.response_spectrum((time, values), damping, periods)
    for period, most in zip(periods, found.displacement):
        w = 2 * np.pi / period
        end = time[-1] + period
        fine = np.unique(np.concatenate([np.linspace(0, end, 20001), time]))
        done = solve_ivp(lambda t, y: [y[1], -2 * damping * w * y[1] - w**2 * y[0] - np.interp(t, time, values, right=0)], (0, end), [0.0, 0.0],
                         method="DOP853", rtol=1e-10, atol=1e-14, t_eval=fine, max_step=0.01)
        assert most == pytest.approx(np.abs(done.y[0]).max(), rel=2e-3)


@pytest.mark.parametrize("period", [0.2, 1.0])
def test_a_step_of_acceleration_doubles_the_static_displacement(period):
    """Without damping u is at most 2 a/w^2, with it 1 + exp(-pi z/(1 - z^2)^1/2)."""
    time = np.array([0.0, 5.0])
    for damping in (0.0, 0.1):
        found = scree.response_spectrum((time, np.array([3.0, 3.0])), damping, period)
        assert found.acceleration[0] == pytest.approx(3 * (1 + np.exp(-np.pi * damping / np.sqrt(1 - damping**2))), rel=6e-3)


def test_at_resonance_the_response_is_that_of_the_closed_form():
    """A sine of the frequency of an oscillator makes 1/(2 z) of its static displacement after many periods."""
    time = np.linspace(0, 40, 8001)
    found = scree.response_spectrum((time, np.sin(2 * np.pi * time)), 0.05, 1.0)
    assert found.acceleration[0] == pytest.approx(1 / (2 * 0.05), rel=5e-3)


def test_stiff_oscillators_move_with_the_ground_and_soft_ones_stay():
    """Pseudo acceleration tends to the largest acceleration, displacement to the largest displacement of the ground."""
    time, values = ground_motion.corrected(noise())
    assert scree.response_spectrum((time, np.sin(time)[:, None]), 0.05, 1e-2).acceleration[0] == pytest.approx(np.abs(np.sin(time)).max(), rel=2e-2)
    shift = np.abs(ground_motion.displaced(time, values)).max()
    assert scree.response_spectrum((time, values), 0.05, 1e3).displacement[0] == pytest.approx(shift, rel=2e-2)


def test_a_corrected_record_ends_at_rest_by_the_smallest_change():
    """Any other correction that does so is larger, by the part that it adds; a record that ends at rest stays as it is."""
    time, values = noise(3)
    still, better = ground_motion.corrected((time, values))
    assert np.abs(ground_motion.integrated(still, better)[-1]).max() < 1e-12
    assert np.abs(ground_motion.displaced(still, better)[-1]).max() < 1e-12
    assert ground_motion.corrected((still, better))[1] == pytest.approx(better, abs=1e-12)
    x = time / time[-1]
    other = better + (x**2 - x + 1 / 6)[:, None]  # its velocity and displacement at the end vanish
    assert np.abs(ground_motion.displaced(time, other - better)[-1]).max() < 1e-3
    size = [ground_motion.integrated(time, (one - values[:, None]) ** 2)[-1, 0] for one in (better, other)]
    assert size[0] < size[1]


def test_a_record_of_peer_is_that_of_its_lines(tmp_path):
    time, values = noise(n=23)
    rows = "\n".join(" ".join(f"{v:.7E}" for v in values[i:i + 5]) for i in range(0, 23, 5))
    (tmp_path / "a.AT2").write_text(f"PEER\nname\nunits of g\nNPTS=   23, DT=   .0100 SEC\n{rows}\n")
    (tmp_path / "a.txt").write_text("! t ax\n" + "".join(f"{t} {v:.7E}\n" for t, v in zip(time, values)))
    a, b = (scree.response_spectrum(tmp_path / name, 0.05, [0.1, 1.0]).displacement for name in ("a.AT2", "a.txt"))
    assert a == pytest.approx(b, rel=1e-9)


BAD = {"1 2\n": "two lines", "0 1\n0 2\n": "times that increase", "0 1\n1 x\n": "a.txt:2", "0 1\n1 2 3\n": "as many numbers"}


@pytest.mark.parametrize("text", BAD)
def test_a_bad_record_is_refused_in_a_line(text, tmp_path):
    (tmp_path / "a.txt").write_text(text)
    done = subprocess.run([TREE / "tools" / "spectrum", "a.txt"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and BAD[text] in done.stderr, done.stderr


def test_the_command_draws_spectra_and_writes_records(tmp_path):
    time, values = noise()
    (tmp_path / "a.txt").write_text("".join(f"{t:.17g} {v:.17g} {0.5 * v:.17g}\n" for t, v in zip(time, values)))

    def call(*more):
        done = subprocess.run([TREE / "tools" / "spectrum", "a.txt", *more], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "damping 0.02: pseudo acceleration at most" in call("--damping", "0.02", "0.05")
    assert (tmp_path / "spectrum.png").stat().st_size > 10000
    call("-o", "s.csv")
    rows = np.genfromtxt(tmp_path / "s.csv", delimiter=",", names=True)
    assert rows["displacement"] == pytest.approx(scree.response_spectrum((time, values)).displacement)
    call("--corrected", "b.txt", "--velocity", "v.txt")
    t, velocity = ground_motion.read_record(tmp_path / "v.txt")
    assert velocity[-1] == pytest.approx([0, 0], abs=1e-8) and velocity.shape == (400, 2)
    assert np.diff(velocity[:, 0]) == pytest.approx(np.diff(t) * (lambda a: (a[1:] + a[:-1]) / 2)(ground_motion.read_record(tmp_path / "b.txt")[1][:, 0]),
                                                    abs=1e-8)
