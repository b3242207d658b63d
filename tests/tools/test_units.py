"""Units of pictures: what becomes of dimensions, and of the numbers."""
import os
import pathlib

import numpy as np
import pytest
import scree
from scree import drawing, overlays
from scree.errors import PlotError
from scree.model.words import UnitSystem
from scree.units import Units, units_of_deck, units_of_files, units_of_settings

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])


def test_dimensions_get_names_and_factors():
    units = Units("m,MPa=1e6,s")
    for label, unit, factor in (("x [length]", "x [m]", 1), ("[force/length$^2$]", "[MPa]", 1e6), ("v [length/time]", "v [m/s]", 1),
                                ("[force/length]", "[MN/m]", 1e6), ("[force*length/length]", "[MJ/m]", 1e6),
                                ("[length^2]", "[m$^2$]", 1), ("[rad]", "[rad]", 1), ("[1]", "[1]", 1), ("block", "block", 1)):
        assert units.of(label) == (unit, pytest.approx(factor)), label
    assert Units("km=1000,kPa=1e3").of("[force/length]") == ("[kPa km]", pytest.approx(1e6))
    assert Units("mm=1e-3,MPa=1e6,ms=1e-3").of("[length/time]") == ("[mm/ms]", pytest.approx(1))
    assert Units("m,Pa").of("[mass*length/time]")[0] == "[N time]"  # a force times a time, of unit thickness
    for words, force, energy, moment, stiffness in (("m,kPa", "kN/m", "kJ/m", "kN m", "kPa/m"), ("mm,MPa", "N/mm", "mJ/mm", "N mm", "MPa/mm"),
                                                    ("cm,kPa", "kPa cm", "kPa cm$^2$", "kPa cm$^3$", "kPa/cm")):
        found = [Units(words).of(f"[{what}]")[0] for what in ("force/length", "force*length/length", "force*length", "force/length^3")]
        assert found == [f"[{unit}]" for unit in (force, energy, moment, stiffness)]
    assert Units().of("x [length]") == ("x [length]", 1.0) and Units("m,Pa").of("t [time]") == ("t [time]", 1.0)


@pytest.mark.parametrize("words", ["m,mm=1e-3", "m,s", "m", "m,Pa,s,kg", "m,", "m,Pa=0", "m,Pa=x", "m,Pa=-1", "m,Pa=inf", "", "m=1=2,Pa"])
def test_other_words_are_refused(words):
    with pytest.raises(PlotError, match="expected LENGTH,STRESS or"):
        Units(words)


def test_pictures_say_numbers_in_the_units(tmp_path):
    """A weight in N and m: stress in kPa, lengths in mm; the bar of displacement is as long as it says."""
    scree.run(SOURCE / "input/paper/rockfall/rockfall.ana", output=tmp_path / "r.h5",
              settings=["step.end_time=0.1", "output.interval=0.05"])
    file = drawing.Frames(tmp_path / "r.h5", "r")
    look = drawing.Look(units=Units("mm=1e-3,kPa=1e3,ms=1e-3"))
    figure = drawing.draw_frames([file], ["last"], "stress_yy", [overlays.VECTORS["displacement"]], look)
    panel, bar = figure.axes[0], figure.axes[1]
    true = file.values(2, "stress_yy")[0]
    np.testing.assert_allclose(panel.collections[1].get_array(), true / 1e3)
    assert bar.get_ylabel() == "stress yy [kPa]" and panel.get_title() == "t = 100 ms"
    assert panel.get_xlabel() == "x [mm]" and panel.get_ylabel() == "y [mm]"
    assert panel.xaxis.get_major_formatter()(0.25, 0) == "250" and panel.yaxis.get_major_formatter()(5200.0012, 0) == "5200001.2"
    words = next(text.get_text() for text in panel.texts)
    value = float(words.split()[0])
    largest = np.linalg.norm(overlays.displacements(file, 2), axis=1).max()
    assert words.endswith("displacement [mm]") and value == overlays.round_below(1e3 * largest)
    line, = [line for line in panel.lines if line.get_label() == "_scale"]
    size = max(np.ptp(panel.get_xlim()), np.ptp(panel.get_ylim()))
    assert np.ptp(line.get_xdata()) == pytest.approx(overlays.LONGEST * size * value / 1e3 / largest)
    axis = drawing.draw_histories([tmp_path / "r.h5"], ["overlap", "energy/kinetic"], look.units).axes[1]
    r = scree.read(tmp_path / "r.h5")
    np.testing.assert_allclose(axis.lines[0].get_ydata(), r.history.energy.kinetic / (1e3 * 1e-6))
    assert axis.get_ylabel() == "[kPa mm$^2$]" and axis.get_xlabel() == "time [ms]"


def test_numbers_along_axes_are_whole(tmp_path):
    """Where they hardly change, as an area or places far from the origin, none is to be added to them."""
    (tmp_path / "far.geo").write_text("0.001\n4 4 0 0 1 0 0 0\n" + "".join(
        f"{450000 + a} {5200000 + b} {450000 + c} {5200000 + d} 1\n" for a, b, c, d in ((0, 0, 9, 0), (9, 0, 9, 4), (9, 4, 0, 4), (0, 4, 0, 0)))
        + "450000 5200000 450009 5200000\n")
    (tmp_path / "far.ana").write_text("1 5 1 1 0.05 0.01\n2500 24525 1e10 0.25\n0 0 0  0 0 0  0 0 0\n45 0 0\n&deck geometry='far.geo' /\n")
    scree.run("far.ana", output="far.h5", cwd=tmp_path)
    for figure in (drawing.draw_frames([drawing.Frames(tmp_path / "far.h5", "far")], ["last"], "stress_yy"),
                   drawing.draw_histories([tmp_path / "far.h5"], ["area"])):
        figure.canvas.draw()
        axes = [axis for panel in figure.axes for axis in (panel.xaxis, panel.yaxis)]
        assert not any("+" in axis.get_offset_text().get_text() for axis in axes)
    assert all(float(label.get_text()) == pytest.approx(36, rel=1e-4) for label in axes[1].get_ticklabels())


@pytest.mark.parametrize("names, words", [("m kN s", "m,kPa,s"), ("mm N s", "mm,MPa,s"), ("rod N s", None), ("", None)])
def test_units_of_a_deck_are_those_of_pictures(names, words, tmp_path):
    """A picture and a report of a run whose deck names its units print them; names that make no stress are left out."""
    given = [f"units.{name}={unit}" for name, unit in zip(("length", "force", "time"), names.split())]
    r = scree.run(SOURCE / "input/paper/rockfall/rockfall.ana", output=tmp_path / "r.h5",
                  settings=["step.end_time=0.02", "output.interval=0.01", *given])
    assert units_of_deck(r) == words
    page = scree.report(r, tmp_path / "r.html").read_text()
    assert ("kJ/m" in page) == (words == "m,kPa,s")
    deck = tmp_path / "d.ana"
    named_in_deck = ", ".join(f"{name.partition('.')[2]}='{unit}'" for name, unit in (one.split("=") for one in given))
    text = (SOURCE / "input/paper/rockfall/rockfall.ana").read_text().replace("geometry='", f"geometry='{SOURCE}/input/paper/rockfall/")
    deck.write_text(text + (f"\n&units {named_in_deck} /\n" if given else ""))
    assert units_of_files(tmp_path / "r.h5") == units_of_files(deck) == words


@pytest.mark.parametrize("system, force, words", [("m kg s", "N", "m,Pa,s"), ("m t s", "kN", "m,kPa,s"), ("mm t s", "N", "mm,MPa,s"),
                                                  ("mm kg ms", "kN", "mm,GPa,ms"), ("mm kg s", "mN", None), ("cm g s", "g*cm/s^2", None)])
def test_units_of_a_model_are_those_of_its_deck(system, force, words, tmp_path):
    """A deck names them in &units; the model that is read from it has them, with the gravity that it was made with."""
    for gravity in None, 10:
        m = scree.Model("u", units=system, gravity=gravity)
        m.material("rock", density=1, young=1)
        m.joint_material("joint")
        m.block("block", [(0, 0), (1, 0), (1, 1)])
        first = m.save(tmp_path / "u.ana").read_text()
        again = scree.Model.read(tmp_path / "u.ana")
        assert f"force='{force}'" in first and again.units == UnitSystem(" ".join((again.units.length, again.units.mass, again.units.time)))
        assert again.gravity == m.gravity and ("gravity" in first) == (gravity is not None)
        assert again.save(tmp_path / "u.ana").read_text() == first and units_of_settings(again.named_units()) == words


def test_units_that_a_model_does_not_know_stay_as_they_are(tmp_path):
    m = scree.Model.read(SOURCE / "input/paper/rockfall/rockfall.ana")
    m["units.length"], m["units.force"] = "ft", "lbf"
    first = m.save(tmp_path / "u.ana").read_text()
    again = scree.Model.read(tmp_path / "u.ana")
    assert again.units is None and again.gravity is None and again.save(tmp_path / "u.ana").read_text() == first and "'ft'" in first
