"""Free fields at the sides: closed forms of columns, columns that rollers hold, and waves that leave."""
import numpy as np
import pytest
import scree
from scree import block_files, call

RHO, NU = 2000.0, 0.25
SOFT, STIFF = 200.0, 600.0  # speeds of shear waves
HEIGHT, BED = 40.0, 20.0
TRAPEZOIDAL = "&integrator scheme='newmark', beta=0.5, start='zero' /"


def young(speed):
    return 2 * (1 + NU) * RHO * speed**2


def model(folder, groups, wave="", width=60.0, bed=True, sides="sides", h=5.0, dt=0.005, end=8.0):
    """A layer, on a bed or not, measured in the middle of its top; at the sides free fields, or lines that absorb, or rollers along x or y."""
    foot = -BED if bed else 0.0
    parts = ([(2, block_files.box(0, width, -BED, 0))] if bed else []) + [(1, block_files.box(0, width, 0, HEIGHT))]
    (folder / "f.blk").write_text(block_files.block_file("layers", parts, measured=[(width / 2, HEIGHT - 1e-6, len(parts))]))
    lines = f"0 {foot} 0 {HEIGHT}  {width} {foot} {width} {HEIGHT}"
    base = f"base=0 {foot} {width} {foot}, table={wave}" if wave else ""
    side = f"&absorbing {base} /\n&support {sides}={lines} /" if sides in "xy" else f"&absorbing {sides}={lines}, {base} /"
    rock = "".join(f"{RHO} 0 {young(speed)} {NU} 0 0 0 0 0 0 0 0 0\n" for speed in ((SOFT, STIFF) if bed else (SOFT,)))
    (folder / "f.ana").write_text(f"1\n100\n{len(parts)} 1\n0.05\n{dt}\n{rock}30 1e9 1e9\n&deck geometry='f.blk', dialect='short' /\n"
                                  f"&method model='nmm', plane='strain', strain='small' / &cover edge={h}, angle=10 /\n{TRAPEZOIDAL}\n"
                                  f"&step size={dt}, end_time={end} /\n&output every=200 /\n{side}\n{groups}\n")
    return scree.run(folder / "f.ana")


def harmonic(w, amplitude=1.0, end=8.0):
    """A table of a sine that begins softly."""
    time = np.arange(0, end + 0.01, 0.01)
    value = amplitude * np.sin(w * time) * np.minimum(1, time * w / (4 * np.pi))
    return "\n".join(f"{t:.6g} {v:.9g} 0" for t, v in zip(time, value))


def amplitude(r, w, what):
    """Complex amplitude of the last three periods."""
    time = np.asarray(r.history.time)
    last = time > time[-1] - 3 * 2 * np.pi / w
    basis = np.column_stack([np.sin(w * time), np.cos(w * time), np.ones_like(time)])[last]
    c = np.linalg.lstsq(basis, np.asarray(getattr(r.measured_points, what))[last, 0, 0], rcond=None)[0]
    return c[0] + 1j * c[1]


@pytest.mark.parametrize("share", [0.5, 0.8, 1.4])
def test_a_layer_on_a_rigid_base_amplifies_as_the_closed_form_says(share, tmp_path):
    """1/cos(k H) with Rayleigh damping, about its first frequency c/(4 H)."""
    w1 = np.pi * SOFT / (2 * HEIGHT)
    w = share * w1
    alpha, beta = 0.1 * w1, 0.1 / w1
    groups = f"&damping fraction=0.1, frequency={w1 / (2 * np.pi)} /\n&support both=0 0 60 0 /\n&acceleration table={harmonic(w)} /"
    r = model(tmp_path, groups, bed=False)
    k = np.sqrt((w**2 - 1j * w * alpha) / (SOFT**2 * (1 + 1j * w * beta)))
    exact = (1 - 1 / np.cos(k * HEIGHT)) / (w**2 - 1j * w * alpha)  # relative to the ground, of e^(iwt)
    assert abs(amplitude(r, w, "displacement")) == pytest.approx(abs(exact), rel=0.02)


@pytest.mark.parametrize("share", [1.0, 2.0])
def test_a_layer_on_rock_amplifies_as_the_contrast_of_impedances_says(share, tmp_path):
    """2/|cos(k H) + i q sin(k H)| of a wave that comes up in the rock, q the soft impedance over the stiff one."""
    w = share * np.pi * SOFT / (2 * HEIGHT)
    r = model(tmp_path, "&contact stiffness=1e12 /", harmonic(w, 0.01), end=8 * 2 * np.pi / w)
    k = w / SOFT
    exact = 0.01 * 2 / abs(np.cos(k * HEIGHT) + 1j * SOFT / STIFF * np.sin(k * HEIGHT))
    assert abs(amplitude(r, w, "velocity")) == pytest.approx(exact, rel=0.02)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_wave_passes_as_in_the_free_field(axis, tmp_path):
    """As in a column that rollers hold along the wave: a pulse of shear or of pressure that comes up, to 2 %; dashpots alone do worse."""
    time = np.linspace(0, 0.5, 51)
    rows = np.zeros((51, 2))
    rows[:, axis] = 0.01 * np.sin(2 * np.pi * time) ** 2
    table = "\n".join(f"{t:.6g} {x:.9g} {y:.9g}" for t, (x, y) in zip(time, rows))
    found = {}
    for sides in ("sides", "lines", "yx"[axis]):
        folder = tmp_path / sides
        folder.mkdir()
        r = model(folder, "", table, bed=False, sides=sides, end=1.5, h=4.0)
        found[sides if len(sides) > 1 else "rollers"] = np.asarray(r.measured_points.velocity)[:, 0, axis]
    most = np.abs(found["rollers"]).max()
    assert most == pytest.approx(0.02, rel=0.02)
    assert np.abs(found["sides"] - found["rollers"]).max() < 0.02 * most
    assert np.abs(found["lines"] - found["rollers"]).max() > 0.1 * most


def test_what_is_no_side_is_refused(tmp_path):
    corners = [(0, 0), (60, 0), (60, 40), (10, 40)]
    (tmp_path / "g.blk").write_text(block_files.block_file("g", [(1, corners)]))
    for groups, expected in {"sides=0 0 10 40": "leans", "sides=60 0 60 40, base=0 0 10 40, table=0 1 0 1 0 0": "found none"}.items():
        (tmp_path / "g.ana").write_text(f"1\n5\n1 1\n0.05\n0.1\n1 0 1 0 0 0 0 0 0 0 0 0 0\n30 0 0\n&deck geometry='g.blk' /\n&absorbing {groups} /\n")
        done = call("check", tmp_path / "g.ana")
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and expected in done.stderr, done.stderr
