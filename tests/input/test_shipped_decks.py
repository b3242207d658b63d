"""Decks that come with the program: `scree check --strict` has nothing to say of any of them, and each names all that it needs."""
import os
import pathlib
from concurrent.futures import ThreadPoolExecutor

import pytest
from scree import call

INPUT = pathlib.Path(os.environ["SCREE_SOURCE"]) / "input"
DECKS = sorted(INPUT.rglob("*.ana"))
# A notch that runs slower than it could, in steps for the fall of what breaks off. Its load and the fall are measured.
ACCEPTED = dict.fromkeys(("validation/k8-overhang/thick.ana", "validation/k8-overhang/thin.ana"), "lets cracks run at")
FOLDERS = ("bench", "examples", "paper", "rockfall", "studies", "validation")


def test_folders_of_input_are_those_that_are_looked_at():
    assert sorted(folder.name for folder in INPUT.iterdir()) == list(FOLDERS)
    assert len(DECKS) > 100


@pytest.mark.parametrize("folder", FOLDERS)
def test_no_shipped_deck_warns(folder):
    """A warning of a shipped deck is of a fault of the deck, or a false alarm."""
    decks = [deck for deck in DECKS if deck.relative_to(INPUT).parts[0] == folder]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        said = list(pool.map(lambda deck: call("check", deck, "--strict", "--quiet", timeout=120), decks))
    wrong = {str(deck.relative_to(INPUT)): done.stdout + done.stderr for deck, done in zip(decks, said)
             if done.returncode or done.stdout or done.stderr}
    accepted = {deck: words for deck, words in ACCEPTED.items() if deck.startswith(folder)}
    for deck, words in accepted.items():
        assert words in wrong.pop(deck)
    assert not wrong, "\n".join(f"{deck}: {words}" for deck, words in wrong.items())


def test_no_shipped_joint_deck_warns(tmp_path):
    for deck in sorted(INPUT.rglob("*.joints")):
        done = call("joints", deck, "-o", tmp_path / "drawn.geo")
        assert done.returncode == 0 and not done.stderr, (deck, done.stderr)
