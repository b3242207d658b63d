"""Settings that contradict each other, or would do nothing, are refused; the printed table of rules is the truth for the tests."""
import re

import pytest
import scree


GEOMETRY = "0.001\n4 4\n0\n0\n1\n0\n1\n0\n0 0 1 0 1\n1 0 1 1 1\n1 1 0 1 1\n0 1 0 0 1\n0 0 0 0\n0.5 0.5\n"
NUMBERS = {"k01": "1", "g2": "0.05"}
# What a rule needs beside itself so that it is the only one broken.
COMPANY = {
    "contact.rules='conserving'": ["method.strain=green"],
    "contact.rules='shi'": ["method.preset=shi", "method.strain=green"],
    "contact.adapt='shi'": ["method.preset=shi", "method.strain=green", "integrator.scheme=newmark"],
    "cracks.strength": ["method.model=nmm", "cover.edge=0.5", "cracks.length=1"],
    "cracks.toughness": ["method.model=nmm", "cover.edge=0.5"],
    "cover.order='1'": ["method.model=nmm", "cover.edge=0.5"],
    "cover.": ["method.model=nmm"],
    "integrator.gamma": ["method.strain=green"],
    "integrator.rho": ["method.strain=green"],
    "integrator.start='acceleration'": ["method.strain=green"],
}
SMALL = ["integrator.scheme='small_steps'"]
# What a setting needs that breaks the rule of another one, so that no rule of its own is broken too.
COMPANY_OF_BREACH = {"joints.closure=1": ["joints.kn=1"], "joints.dilation=1": ["joints.dilation_slip=1"],
                     "absorbing.base=1": ["absorbing.table=0 0 0 1 0 0"]}
SAMPLES = {"bolt_row.line": "0 0 1 1", "bolt_ring.centre": "0 0", "in_situ.surface": "0 1", "in_situ.k0": "1",
           "excavation.outline": "0 0 1 0 1 1 0 0", "contact.rules": "coulomb", "cover.mesh": "mesh.msh", "cover.origin": "0 0", "acceleration.table": "0 0 0 1 0 0",
           "acceleration.file": "quake.txt", "acceleration.vertical": "up.at2"}


def tables():
    """Lines of the table of settings by name, and of the rules."""
    settings, rules = scree.call("explain", "--settings").stdout.split("\n\n")
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in settings.splitlines()[2:]]
    return {row[0].strip("`"): row for row in cells}, [[c.strip() for c in r.strip("|").split("|")] for r in rules.splitlines()[2:]]


SETTINGS, RULES = tables()


def sample(name):
    """A value that the setting may have."""
    if name in SAMPLES:
        return SAMPLES[name]
    values = SETTINGS[name][1]
    return values.split(", ")[-1] if "," in values else "1"


def breach(subject, condition):
    """Every way to break a rule: the number of the deck that it needs, and settings."""
    match = re.fullmatch(r"(.*?)=('.*')", subject)
    choices = [f"{match[1]}={value}" for value in re.findall(r"'(.*?)'", match[2])] if match else None
    for setting in choices or [f"{name}={sample(name)}" for name in subject.split(", ")]:
        given = [setting]
        if condition.startswith("without "):
            yield {"k01": "0"} if "step.balance" in condition else {}, [*given, f"{condition[8:]}={sample(condition[8:])}"]
        elif condition.endswith(" above 0"):
            other = condition[5:-8]
            if other in NUMBERS:
                yield {other: "0"}, given
            elif other == "step.travel":
                yield {"g2": "0"}, given
            else:
                yield {}, [*given, f"{other}=0"]
        elif "=" in condition:
            other, allowed = condition[5:].split("=")
            other = other.split(" or ")[0]  # the other names have no such value by default
            for value in SETTINGS[other][1].split(", "):
                own_line = f"{other}={value}" == "contact.method=none" and "augmented" not in allowed \
                    or subject in SMALL and other == "contact.rules"  # the other rules of contact refuse these schemes first
                if value not in re.findall(r"'(.*?)'", allowed) and not own_line:
                    yield {"k01": "0"} if subject in ("step.balance", "step.past_peak") else {}, [*given, f"{other}={value}"]  # static runs alone have it
        else:
            yield {}, given


CASES = [(subject, condition, numbers, [*company, *(c for g in given[1:] for c in COMPANY_OF_BREACH.get(g, []) if subject in SMALL or subject.startswith("cracks.")),
                                        *(g for g in given if g not in company)])
         for subject, condition, _ in ([c.strip("`") for c in rule] for rule in RULES)
         for numbers, given in breach(subject, condition)
         for company in [[c for c in next((v for k, v in COMPANY.items() if (subject if "'" in subject else given[0]).startswith(k)), [])
                          if c.split("=")[0] not in [condition[5:].split(" or ")[0], *(g.split("=")[0] for g in given)]]]]


def deck(folder, settings, **numbers):
    """An analysis deck of a square with settings as groups, one a line from line 4 on."""
    numbers = {**NUMBERS, **numbers}
    groups = {}
    for setting in settings:
        (group, name), value = setting.split("=")[0].split("."), setting.split("=", 1)[1]
        quoted = value if re.fullmatch(r"[-0-9. e]+", value) else f"'{value}'"
        groups.setdefault(group, []).append(f"{name}={quoted}")
    lines = "".join(f"&{group} {', '.join(names)} /\n" for group, names in groups.items())
    (folder / "g.geo").write_text(GEOMETRY)
    joint = "30 1 1" if any(s.startswith(("joints.energy", "joints.shear_energy")) for s in settings) else "30 0 0"  # a bond to soften
    (folder / "a.ana").write_text(f"{numbers['k01']} 10 1 1 {numbers['g2']} 0.01\n2500 25000 1e10 0.3 0 0 0 0 0 0 0 0 0 {joint}\n"
                                  f"&deck geometry='g.geo' /\n{lines}")


def check(folder, *options):
    return scree.call("check", "a.ana", *options, cwd=folder)


@pytest.mark.parametrize("subject, condition, numbers, settings", CASES, ids=[f"{c[0]} {c[1]} {c[3]}"[-60:] for c in CASES])
def test_every_line_of_the_table_refuses_what_breaks_it(subject, condition, numbers, settings, tmp_path):
    deck(tmp_path, settings, **numbers)
    done = check(tmp_path)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stdout + done.stderr
    assert re.match(r"scree: a\.ana:\d+: expected .* only with(out)? .*, found ", done.stderr), done.stderr
    assert f"only {condition} (" in done.stderr, done.stderr


def test_conserving_contact_is_refused_with_an_adapting_stiffness(tmp_path):
    """It gained 20 % of the energy in a step, and 32 m g h in a bounce."""
    deck(tmp_path, ["method.strain=green", "contact.rules=conserving", "contact.adapt=shi"])
    done = check(tmp_path)
    assert done.returncode == 2
    assert "a.ana:5: expected contact.adapt='shi' only with contact.rules='shi'" in done.stderr
    assert "found contact.rules='conserving'" in done.stderr


@pytest.mark.parametrize("given, option, gone", [
    (["output.every=5"], "output.interval=0.05", "output.every"),
    (["output.interval=0.05"], "output.every=5", "output.interval"),
    (["method.strain=green", "iteration.method=newton"], "method.strain=small", None),
    (["contact.restitution=0.5"], "contact.method=none", "contact.restitution"),
    (["method.model=nmm", "cover.edge=0.5"], "method.model=dda", "cover.edge")])
def test_the_command_line_wins_over_what_it_makes_idle(given, option, gone, tmp_path):
    deck(tmp_path, given)
    done = scree.call("explain", "a.ana", "--set", option, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert option.replace("=", " = ") in done.stdout
    assert gone is None or gone not in done.stdout


def test_the_command_line_does_not_win_over_a_contradiction(tmp_path):
    deck(tmp_path, ["method.strain=green", "contact.rules=conserving"])
    done = check(tmp_path, "--set", "contact.restitution=1")
    assert done.returncode == 2 and "without contact.restitution" in done.stderr, done.stderr


@pytest.mark.parametrize("settings", [["method.preset=shi"], ["method.preset=shi", "method.strain=green"],
                                      ["method.preset=shi", "contact.method=augmented"], ["method.preset=shi", "contact.method=none"],
                                      ["method.preset=shi", "step.control=shi", "contact.adapt=shi"], ["method.strain=green"],
                                      ["method.model=nmm", "cover.edge=0.5"], ["integrator.beta=0.5"]])
def test_defaults_break_no_rule(settings, tmp_path):
    deck(tmp_path, settings)
    assert check(tmp_path).returncode == 0, check(tmp_path).stderr


def test_who_chooses_steps_by_the_mass_of_the_first_material_needs_one(tmp_path):
    """Its blocks stand for all; others may have no mass."""
    deck(tmp_path, ["step.control=shi"])
    assert check(tmp_path).returncode == 0
    done = check(tmp_path, "--set", "material(1).density=0")
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert "a.ana:4: expected a density of block material 1 above 0 with step.control='shi'" in done.stderr, done.stderr
