"""Takes out one rule at a time and tells which unit test notices: tools/check --ablate ROOM.

The rules are those of ablations.toml: a file below src/, the text of it that the rule is, what stands there without the rule, and the
unit tests that are to notice. The work is done in a copy of the sources below build/ablate, which later calls go on from.
"""
import os
import pathlib
import re
import shutil
import subprocess
import tomllib

TABLE = pathlib.Path(__file__).with_name("ablations.toml")
NOT_COPIED = ("build", ".git")


def rules_of(room, table=TABLE):
    """The rules of a folder of src/, as dictionaries."""
    rules = tomllib.loads(table.read_text(encoding="utf-8"))["rule"]
    found = [rule for rule in rules if rule["file"].startswith(room.strip("/") + "/")]
    if not found:
        rooms = sorted({str(pathlib.PurePosixPath(rule["file"]).parent) for rule in rules})
        raise ValueError(f"--ablate: expected a folder that has rules in {table.name} ({', '.join(rooms)}), found {room}")
    return found


def without(rule, text):
    """The text of a file without a rule, whose text it is to have once."""
    if text.count(rule["is"]) != 1:
        raise ValueError(f"{rule['file']}: expected the text of the rule '{rule['rule']}' once, found it {text.count(rule['is'])} times")
    return text.replace(rule["is"], rule["becomes"])


def copy_sources(tree, copy):
    """Copies what is new or has changed, so that a build goes on from the one before; what is gone in the tree goes in the copy."""
    there = set()
    for top in tree.iterdir():
        for path in [] if top.name in NOT_COPIED else [top, *top.rglob("*")]:
            target = copy / path.relative_to(tree)
            there.add(target)
            if path.is_file() and not (target.exists() and target.read_bytes() == path.read_bytes()):
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, target)
    for path in copy.rglob("*"):
        if path.is_file() and path not in there:
            path.unlink()


def build(folder, targets):
    """Builds targets. What the compiler says last where that fails, else nothing."""
    done = subprocess.run(["cmake", "--build", folder, "-j", str(os.cpu_count()), "--target", *targets], capture_output=True, text=True)
    return "" if done.returncode == 0 else (done.stdout + done.stderr)[-1500:]


def failing(folder, test):
    """The tests of a unit test that fail, by name; where it stops without a name, its own."""
    done = subprocess.run([folder / "tests" / test], capture_output=True, text=True, cwd=folder)
    if done.returncode == 0:
        return []
    named = re.findall(r"Failure\s+in:?\s+(\w+)", done.stdout + done.stderr)
    return sorted(set(named)) or [test]


def ablate(room, tree):
    """Takes out the rules of a room one by one; 0 where a test notices each, else 1."""
    rules, folder = rules_of(room), tree / "build" / "ablate"
    copy, work = folder / "tree", folder / "build"
    copy_sources(tree, copy)
    for rule in rules:
        without(rule, (copy / "src" / rule["file"]).read_text(encoding="utf-8"))
    done = subprocess.run(["cmake", "-S", copy, "-B", work, "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_Fortran_FLAGS_RELEASE=-O0",
                           "-DBUILD_TESTING=ON"], capture_output=True, text=True)
    if done.returncode:
        raise ValueError(f"{copy} cannot be configured: {done.stderr[-500:]}")
    tests = sorted({test for rule in rules for test in rule["tests"]})
    if wrong := build(work, tests):
        raise ValueError(f"{copy} does not build: {wrong}")
    for test in tests:
        if failed := failing(work, test):
            raise ValueError(f"{test} fails with all rules: {', '.join(failed)}")
    unnoticed = 0
    for rule in rules:
        path = copy / "src" / rule["file"]
        text = path.read_text(encoding="utf-8")
        path.write_text(without(rule, text), encoding="utf-8")
        try:
            if wrong := build(work, rule["tests"]):
                raise ValueError(f"{rule['file']} does not compile without the rule '{rule['rule']}': {wrong}")
            noticed = [f"{test} ({', '.join(failed)})" for test in rule["tests"] if (failed := failing(work, test))]
        finally:
            path.write_text(text, encoding="utf-8")
        print(f"{rule['file']}: {rule['rule']}: {'noticed by ' + '; '.join(noticed) if noticed else 'NOT NOTICED'}", flush=True)
        unnoticed += not noticed
    print(f"{len(rules)} rules, {unnoticed} of which no test notices")
    return 1 if unnoticed else 0
