"""The ways that a scene is run: axes, choices on each of them, the settings that these are."""
import dataclasses
import itertools

from ..errors import ScreeError

DECK = "deck"  # as the deck has it
STRAINS = ("small", "green", "auto", "strain_rotation")
CURES = ("exact", "adjusted", "second_order", "trigonometric", "exponential")  # of small strain, as method.rotation has them
INTEGRATORS = {
    "shi": ["integrator.scheme=newmark", "integrator.beta=1", "integrator.gamma=0.5"],
    "newmark": ["integrator.scheme=newmark", "integrator.beta=1", "integrator.gamma=0.5625"],
    "newmark-half": ["integrator.scheme=newmark", "integrator.beta=0.5", "integrator.gamma=0.5"],
    "momentum": ["integrator.scheme=energy_momentum", "integrator.beta=0.5"],
    "momentum-1": ["integrator.scheme=energy_momentum", "integrator.beta=1"],
    "decaying": ["integrator.scheme=energy_decaying", "integrator.beta=1"],
}
# Published ones to compare with, which are no part of a study unless they are asked for.
COMPARED = {
    **{f"alpha-{rho}": ["integrator.scheme=generalized_alpha", f"integrator.rho={rho}"] for rho in ("1", "0.8", "0.5", "0")},
    "bathe": ["integrator.scheme=bathe"],
    "central": ["integrator.scheme=central_difference"],
}
AXES = ("strain", "integrator", "contact", "tolerance", "mesh", "accuracy", "step")
MULTIPLIERS = "multipliers"
ALONE = ("contact", "tolerance", "mesh")  # axes that are varied one at a time


@dataclasses.dataclass(frozen=True)
class Choice:
    """A choice on each axis; contact, mesh and step are factors of what the deck has."""

    strain: str = DECK
    integrator: str = DECK
    contact: str = DECK
    tolerance: str = DECK
    mesh: str = DECK
    accuracy: str = DECK  # that the run chooses its steps by
    step: float = 1.0

    def settings(self, asked, size):
        """The settings of the choice, beside those that were asked for, by name; `size` is a step of the deck."""
        found = [f"step.size={self.step * size}"]
        if self.strain in CURES:
            found += ["method.strain=small", f"method.rotation={self.strain}"]
        elif self.strain != DECK:
            word, _, accuracy = self.strain.partition(":")
            found += [f"method.strain={word}"] + [f"method.accuracy={accuracy}"] * bool(accuracy)
        if self.integrator != DECK:
            found += {**INTEGRATORS, **COMPARED}[self.integrator]
        if self.contact == MULTIPLIERS:
            found.append("contact.method=augmented")
        elif self.contact != DECK:
            found.append(f"contact.stiffness={float(self.contact) * number(asked, 'contact.stiffness')}")
        if self.tolerance != DECK:
            found.append(f"iteration.tolerance={self.tolerance}")
        if self.accuracy != DECK:
            found.append(f"step.accuracy={self.accuracy}")
        return found


def number(asked, name):
    """A setting that must be there."""
    if name not in asked:
        raise ScreeError(f"expected a scene with {name}, found none: leave that axis out")
    return float(asked[name])


def grid(axes, every=False):
    """All choices of axes, lists by name: strains with integrators and steps; and strains with steps and one of contact, tolerance,
    mesh at a time, where the other axes have their first choice. Or every combination. Strains with accuracies have the largest
    step.
    """
    first = {axis: axes[axis][:1] for axis in AXES}
    without = {**axes, "accuracy": first["accuracy"]}
    parts = [without] if every else [{**without, **{axis: first[axis] for axis in ALONE}},
                                     *({**first, "strain": axes["strain"], "step": axes["step"], axis: axes[axis]} for axis in ALONE)]
    parts.append({**first, "strain": axes["strain"], "accuracy": axes["accuracy"][1:], "step": [max(axes["step"])]})
    choices = (Choice(*words) for part in parts for words in itertools.product(*(part[axis] for axis in AXES)))
    return list(dict.fromkeys(choices))
