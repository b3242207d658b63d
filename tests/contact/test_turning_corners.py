"""Corners that overlap, and turn past the angle up to which their edges are taken for parallel: one load, on one line or the other."""
import math

import numpy as np
import pytest
import scree
from scree.block_files import block_file, box, turned

DIAMOND = turned(box(0, 1, 0, 1), math.pi / 4)


@pytest.mark.parametrize("E, dt, steps, velocity, start, angles, group", [
    (1e10, 1e-3, 40, (0, -1), (-0.001, 0.005), (0, 3.0), "&joints kn=1e10 1e10 /"),
    (1e8, 1e-4, 300, (1.56, -1.24), (-0.016, 0.005), (4.8, -0.35), "")])
@pytest.mark.parametrize("strain", ["auto", "green"])
def test_corners_that_turn_past_parallel_gain_nothing(E, dt, steps, velocity, start, angles, group, strain, tmp_path):
    """The vertex of either may press on the edge of the other, that faces it nearly parallel: first one of them, then both. What is
    found inside rests there, and what pressed before goes on with its own spring. It gained a tenth of its energy in a step."""
    low = turned(-DIAMOND, math.radians(angles[0]))
    top = turned(DIAMOND, math.radians(angles[1])) + start
    (tmp_path / "a.blk").write_text(block_file("tips", [(1, low), (2, top)], []))
    (tmp_path / "a.ana").write_text("\n".join([
        f"1 {steps} 2 1 0.05 {dt}", f"2500 0 {E} 0.25 {'0 ' * 9}", f"2500 0 {E} 0.25 {'0 ' * 6} {velocity[0]} {velocity[1]} 0", "0 0 0",
        "&deck geometry='a.blk', dialect='short' /", f"&method strain='{strain}' /", group.replace("1e10 1e10", "1e10"), ""]))
    energy = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5").history.energy
    assert energy.contact.max() > 0.01 * energy.kinetic[0]
    assert np.diff(energy.dissipated, prepend=0).min() > -1e-9 * energy.kinetic[0]


@pytest.mark.parametrize("sides, friction", [(20, 0), (30, 0), (30, 20)])
def test_what_rests_behind_a_line_is_met_once(sides, friction, tmp_path):
    """Two wheels of many sides, each held at its middle, turn against each other. A corner that was found inside and rests there is
    looked for each step; as its edges turned past parallel it was met as often as it had been, pressed twice, then three times, and
    made up to ten times the energy of the wheels."""
    angles = math.pi / sides * (1 + 2 * np.arange(sides))
    wheel = 0.5 * np.column_stack([np.cos(angles), np.sin(angles)])
    apart = np.array([2 * 0.5 * math.cos(math.pi / sides) + 0.001, 0])
    (tmp_path / "a.blk").write_text(block_file("wheels", [(1, wheel), (2, wheel + apart)], [(0, 0, 1), (*apart, 2)]))
    (tmp_path / "a.ana").write_text("\n".join([
        "1 5000 2 1 0.05 0.0002", f"2500 0 1e10 0.2 {'0 ' * 8} 2", f"2500 0 1e10 0.2 {'0 ' * 8} -2", f"{friction} 0 0",
        "&deck geometry='a.blk', dialect='short' /", "&joints kn=5e8, ks=5e8 /", ""]))
    energy = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5").history.energy
    assert energy.contact.max() > 0.01 * energy.kinetic[0]
    assert np.diff(energy.dissipated, prepend=0).min() > -1e-7 * energy.kinetic[0]


def test_a_vertex_presses_on_an_edge_once(tmp_path):
    """A stack on a floor beside a box of its size: as the boxes turn, corners that meet where three come together do so by several pairs of
    lines, some of which are the same. Up to three contacts pressed with the same vertex on the same edge, each with its own spring."""
    w = 4 / 3
    boxes = [box(-1, 5, -1, 0), box(0, w, 0, 1), box(w, 2 * w, 0, 1), box(0, w, 1, 2)]
    (tmp_path / "a.blk").write_text(block_file("stack", [(1 + (k > 0), b) for k, b in enumerate(boxes)]))
    (tmp_path / "a.ana").write_text("\n".join([
        "1 16 2 1 0.05 0.01", f"2500 0 1e7 0.25 {'0 ' * 9}", f"2500 0 1e7 0.25 {'0 ' * 6} 0.378 0.683 -0.0745", "0 0 0",
        "&deck geometry='a.blk', dialect='short' /", "&method strain='small' /", "&acceleration table=0 0 10 100 0 10 /",
        "&support both=-1 -1 5 -1 /", "&output every=1 /", ""]))
    r = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
    assert r.history.contacts[-1, 1:].sum() > 8
    for step in range(1, 17):
        contacts = r.contacts_of(step)
        lines = [tuple(np.round([*place, *normal], 12)) for place, normal in zip(contacts.place, contacts.normal)]
        assert len(set(lines)) == len(lines)
