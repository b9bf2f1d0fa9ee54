"""Runs two builds of modalign on the same inputs and compares all that they write.

    python3 tests/reference/compare_builds.py BASE [HEAD] [--draws N] [--quick]

BASE and HEAD are commits (HEAD defaults to the working tree), or built programs. Commits are built
in release mode below target/compare and kept there. Every command runs with both programs in
folders of the same relative path: `run`, `update`, `study order` and `report` of the scenes below
measurements/, `theory` of the built-in models, `identify` by every method over synthetic FRFs and
synthetic hammer tests that the first program makes, `convert` to every format, `correlate` with the
model of the tests, and `check` of the modes of one test against another's.

Each output is one of: the same bytes; the same numbers to 1e-12 and the same structure, with other
sentences (a reworded message or heading); other numbers. In JSON 1e-12 is that of the largest number
of a list or shape, so that components that are 0 but for rounding are equal. The exit code is 1 for other numbers, or
for reworded sentences with --bytes.
"""

import argparse
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
BUILDS = ROOT / "target" / "compare"
SCENES = sorted(p.parent.name for p in (ROOT / "measurements").glob("*/scene.toml"))
TESTED_SCENES = [s for s in SCENES if "[[test]]" in (ROOT / "measurements" / s / "scene.toml").read_text()]
MODELS = ["cycloid-ball", "torsional-planetary", "spider-reducer", "helical-planetary"]
METHODS = ["auto", "ml", "lscf", "rfp", "lsce", "circle", "peak"]
FORMATS = [".uff", ".h5", ".mat", ".npz", ".csv"]
# Largest relative difference of equal numbers, beside the last digit of a printed one.
EQUAL = 1e-12
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


# --- builds -------------------------------------------------------------------------------------


def program(name):
    """The program of a commit, of the working tree (None), or a built one."""
    if name is None:
        subprocess.run(["cargo", "build", "--release", "-q"], cwd=ROOT, check=True)
        return ROOT / "target" / "release" / "modalign"
    if os.access(name, os.X_OK) and Path(name).is_file():
        return Path(name).resolve()
    commit = git("rev-parse", "--short", name)
    built = BUILDS / commit / "modalign"
    if not built.exists():
        tree = BUILDS / commit / "tree"
        shutil.rmtree(tree, ignore_errors=True)
        git("worktree", "prune")
        git("worktree", "add", "--detach", "-f", str(tree), commit)
        try:
            command = ["cargo", "build", "--release", "-q", "--target-dir", str(BUILDS / "target")]
            subprocess.run(command, cwd=tree, check=True)
            shutil.copy(BUILDS / "target" / "release" / "modalign", built)
        finally:
            git("worktree", "remove", "--force", str(tree))
    return built


def git(*arguments):
    done = subprocess.run(["git", *arguments], cwd=ROOT, check=True, capture_output=True, text=True)
    return done.stdout.strip()


# --- inputs -------------------------------------------------------------------------------------


def write_uff(path, sets, start_hz, step_hz):
    """Universal datasets 58 of FRFs, and of coherences, as text."""
    text = []
    for function, (response, reference), values in sets:
        complex_values = np.iscomplexobj(values)
        if complex_values:
            pairs = np.column_stack([values.real, values.imag]).ravel()
        else:
            pairs = values
        quantity = (12, "m/s^2", 13, "N") if function == 4 else (0, "NONE", 0, "NONE")
        text.append(
            "    -1\n    58\nsynthetic\nNONE\nNONE\nNONE\nNONE\n"
            f"{function:5}{0:10}{0:5}{0:10} {'NONE':<10}{response:10}{3:4} {'NONE':<10}{reference:10}{3:4}\n"
            f"{6 if complex_values else 4:10}{len(values):10}{1:10}"
            f"{start_hz:13.5e}{step_hz:13.5e}{0.0:13.5e}\n"
            f"{18:10}{0:5}{0:5}{0:5} {'Frequency':<20} {'Hz':<20}\n"
            f"{quantity[0]:10}{0:5}{0:5}{0:5} {'NONE':<20} {quantity[1]:<20}\n"
            f"{quantity[2]:10}{0:5}{0:5}{0:5} {'NONE':<20} {quantity[3]:<20}\n"
            f"{0:10}{0:5}{0:5}{0:5} {'NONE':<20} {'NONE':<20}\n"
        )
        for row in np.array_split(pairs, math.ceil(len(pairs) / 4)):
            text.append("".join(f"{value:20.11e}" for value in row) + "\n")
        text.append("    -1\n")
    path.write_text("".join(text))


def synthetic_frfs(path, family, seed):
    """FRFs of random modes with noise: the families are those that identification is built for."""
    random = np.random.default_rng([seed, sum(map(ord, family))])
    start, step, lines = 50.0, 0.25, 800
    hz = start + step * np.arange(lines)
    omega = 2 * np.pi * hz
    outputs, inputs = {"one FRF": (1, 1), "repeated": (6, 2)}.get(family, (int(random.integers(3, 9)), 1))
    count = int(random.integers(2, 9))
    modes = np.sort(random.uniform(60, 240, count))
    zeta = 10 ** random.uniform(-3, -1.8, count)
    if family == "close":
        modes = np.repeat(modes[::2], 2)[:count]
        modes[1::2] *= 1 + 2 * zeta[1::2] * random.uniform(0.3, 3)
    if family == "repeated":
        modes = np.repeat(modes[::2], 2)
        zeta = np.repeat(zeta[::2], 2)
    shapes = random.normal(size=(len(modes), max(outputs, inputs)))
    sets = []
    values = {}
    for i in range(outputs):
        for j in range(inputs):
            terms = [
                shape[i] * shape[j] / ((2 * np.pi * f) ** 2 - omega**2 + 2j * z * 2 * np.pi * f * omega)
                for f, z, shape in zip(modes, zeta, shapes)
            ]
            values[i, j] = -(omega**2) * sum(terms)
    level = max(np.abs(h).max() for h in values.values()) * 10 ** (-random.uniform(40, 80) / 20)
    for (i, j), h in values.items():
        noise = level * (random.normal(size=lines) + 1j * random.normal(size=lines)) / math.sqrt(2)
        if family == "force noise":
            noise += 3e-3 * h * (random.normal(size=lines) + 1j * random.normal(size=lines))
        sets.append((4, (i + 1, j + 1), h + noise))
        if family != "without coherence":
            sets.append((6, (i + 1, j + 1), 1 / (1 + 5 * level**2 / np.abs(h) ** 2)))
    write_uff(path, sets, start, step)


FAMILIES = ["separate", "close", "repeated", "one FRF", "force noise", "without coherence"]


def inputs(folder, maker, draws):
    """Files that both programs read; synthetic hammer tests are made by one of them."""
    names = []
    for family in FAMILIES:
        for seed in range(draws):
            names.append(f"{family.replace(' ', '-')}-{seed}.uff")
            synthetic_frfs(folder / names[-1], family, seed)
    spec = (ROOT / "measurements" / "free-free-beam" / "synth.toml").read_text()
    shutil.copy(ROOT / "measurements" / "free-free-beam" / "model.toml", folder)
    recordings = []
    for seed in range(draws):
        text = re.sub(r"(?m)^seed = .*$", f"seed = {seed + 1}", spec)
        text = re.sub(r"(?m)^(\w+_snr_db) = .*$", rf"\1 = {40 + 10 * (seed % 4)}.0", text)
        (folder / f"hits-{seed}.toml").write_text(text)
        recordings.append(f"hits-{seed}.uff")
        made = [maker, "synth", f"hits-{seed}.toml", "-o", recordings[-1], "-q"]
        subprocess.run(made, cwd=folder, check=True, capture_output=True)
        for verb, source, result in [("frf", ".uff", ".h5"), ("identify", ".h5", ".json")]:
            made = [maker, verb, f"hits-{seed}{source}", "-o", f"hits-{seed}{result}", "-q"]
            done = subprocess.run(made, cwd=folder, capture_output=True, text=True)
            # 1: with findings that need attention.
            assert done.returncode <= 1, done.stderr
    return names, recordings


# --- commands -----------------------------------------------------------------------------------


def commands(frfs, recordings, quick):
    """Name and arguments of every command; `out` is a separate folder for each."""
    for model in MODELS:
        yield f"theory {model}", ["theory", model, "--json"]
    for scene in SCENES:
        path = f"measurements/{scene}"
        yield f"run {scene}", ["run", path, "-o", "out"]
        yield f"run {scene} --json", ["run", path, "--json"]
        yield f"run {scene} --lang zh", ["run", path, "--lang", "zh"]
        if not quick and scene in TESTED_SCENES:
            yield f"update {scene}", ["update", path, "-o", "out"]
            yield f"study order {scene}", ["study", "order", path, "-o", "out"]
    for name in frfs:
        for method in METHODS if name.endswith("-0.uff") else METHODS[:1]:
            arguments = ["identify", f"inputs/{name}", "--method", method, "-o", "modes.json"]
            yield f"identify {name} {method}", arguments
    for name in recordings:
        yield f"frf {name}", ["frf", f"inputs/{name}", "-o", "frfs.h5"]
        frfs_of_hits = f"inputs/{Path(name).stem}.h5"
        yield f"identify {name}", ["identify", frfs_of_hits, "-o", "modes.json"]
        yield f"inspect {name}", ["inspect", f"inputs/{name}", "--json"]
        modes = f"inputs/{Path(name).stem}.json"
        pair = ["correlate", "--test", modes, "--theory", "inputs/model.toml"]
        yield f"correlate {name}", pair
        yield f"correlate {name} --json", [*pair, "--measures", "--json"]
        yield f"check {name}", ["check", modes, "--against", "inputs/hits-0.json", "--json"]
    for ending in FORMATS:
        yield f"convert hits {ending}", ["convert", "inputs/hits-0.uff", "-o", f"hits{ending}"]
        yield f"convert FRFs {ending}", ["convert", f"inputs/{frfs[0]}", "-o", f"frfs{ending}"]


def outputs(binary, arguments, folder, shared):
    """All that one command writes, by name."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for name in ["inputs", "measurements"]:
        (folder / name).symlink_to(shared[name])
    done = subprocess.run([binary, *arguments], cwd=folder, capture_output=True)
    written = {"exit code": str(done.returncode).encode(), "stdout": done.stdout, "stderr": done.stderr}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and not path.is_symlink():
            written[str(path.relative_to(folder))] = path.read_bytes()
    return written


# --- comparison ---------------------------------------------------------------------------------


class Difference:
    """What differs between two outputs."""

    def __init__(self):
        self.numbers = 0.0  # largest relative difference
        self.first = None  # where
        self.sentences = set()

    def number(self, a, b, where, scale=0.0):
        """`scale`: largest magnitude of the list or shape that the number belongs to."""
        if a == b or (math.isnan(a) and math.isnan(b)):
            return
        apart = abs(a - b) / max(abs(a), abs(b), scale)
        if not apart <= self.numbers:
            self.numbers, self.first = apart, f"{where}: {a} {b}"

    def other(self, where):
        self.numbers, self.first = math.inf, where


def magnitude(value):
    """Largest magnitude of a number, or of the numbers of a list or of an object of lists; 0 else."""
    if isinstance(value, bool):
        return 0.0
    if isinstance(value, (int, float)):
        return abs(value)
    entries = value.values() if isinstance(value, dict) else value if isinstance(value, list) else []
    return max(map(magnitude, entries), default=0.0)


def is_shape(value):
    """An object of lists of numbers, such as a shape by degree of freedom."""
    return bool(value) and all(isinstance(entry, list) for entry in value.values())


def compare_json(a, b, where, difference, scale=0.0):
    if isinstance(a, dict) and isinstance(b, dict):
        if a.keys() != b.keys():
            return difference.other(f"{where}: keys {sorted(a.keys() ^ b.keys())}")
        scale = magnitude(a) if is_shape(a) else 0.0
        for key in a:
            compare_json(a[key], b[key], f"{where}.{key}", difference, scale)
    elif isinstance(a, list) and isinstance(b, list):
        if len(a) != len(b):
            return difference.other(f"{where}: {len(a)} and {len(b)} entries")
        if all(isinstance(entry, (int, float)) for entry in a):
            scale = max(scale, magnitude(a))
        for i, (x, y) in enumerate(zip(a, b)):
            compare_json(x, y, f"{where}[{i}]", difference, scale)
    elif isinstance(a, bool) or isinstance(b, bool) or a is None or b is None:
        if a is not b:
            difference.other(f"{where}: {a} {b}")
    elif isinstance(a, (int, float)) and isinstance(b, (int, float)):
        difference.number(float(a), float(b), where, scale)
    elif isinstance(a, str) and isinstance(b, str):
        if a != b:
            compare_text(a, b, where, difference)
    else:
        difference.other(f"{where}: {a} {b}")


def compare_text(a, b, where, difference):
    """Texts with the same numbers in the same order are reworded; codes and names count as words."""
    x, y = NUMBER.findall(a), NUMBER.findall(b)
    if len(x) == len(y):
        for p, q in zip(x, y):
            difference.number(float(p), float(q), where)
        difference.sentences.add((a.strip()[:160], b.strip()[:160]))
    else:
        difference.other(f"{where}: {a.strip()[:80]!r} {b.strip()[:80]!r}")


def compare(name, a, b):
    difference = Difference()
    if name.endswith(".json") or (name == "stdout" and a[:1] in b"{[" and b[:1] in b"{["):
        try:
            compare_json(json.loads(a), json.loads(b), name, difference)
            return difference
        except ValueError:
            pass
    try:
        lines = [text.decode().splitlines() for text in (a, b)]
    except UnicodeDecodeError:
        difference.other(f"{name}: bytes")
        return difference
    if len(lines[0]) != len(lines[1]):
        difference.other(f"{name}: {len(lines[0])} and {len(lines[1])} lines")
        return difference
    for i, (x, y) in enumerate(zip(*lines)):
        if x != y:
            compare_text(x, y, f"{name}:{i + 1}", difference)
    return difference


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base", help="commit or program")
    parser.add_argument("head", nargs="?", help="commit or program; without it the working tree")
    parser.add_argument("--draws", type=int, default=4, help="of every synthetic family (default 4)")
    parser.add_argument("--quick", action="store_true", help="without update and study")
    parser.add_argument("--bytes", action="store_true", help="reworded sentences fail as well")
    parser.add_argument("--only", default="", help="commands whose name holds this")
    arguments = parser.parse_args()
    base, head = program(arguments.base), program(arguments.head)
    counts = {kind: Counter() for kind in ["same bytes", "reworded", "other numbers"]}
    sentences = set()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "inputs").mkdir()
        frfs, recordings = inputs(folder / "inputs", base, arguments.draws)
        shared = {"inputs": folder / "inputs", "measurements": ROOT / "measurements"}
        for name, command in commands(frfs, recordings, arguments.quick):
            if arguments.only not in name:
                continue
            # One folder for both, so that no path differs.
            a = outputs(base, command, folder / "run", shared)
            b = outputs(head, command, folder / "run", shared)
            if a["exit code"] == b"2":
                sys.exit(f"{name} fails and compares nothing: {a['stderr'].decode()}")
            for file in sorted(a.keys() | b.keys()):
                kind = Path(file).suffix or ("JSON" if "--json" in command else "") + file
                if file not in a or file not in b:
                    counts["other numbers"][kind] += 1
                    print(f"{name}: {file}: only by {'base' if file in a else 'head'}")
                elif a[file] == b[file]:
                    counts["same bytes"][kind] += 1
                else:
                    difference = compare(file, a[file], b[file])
                    sentences |= difference.sentences
                    if difference.numbers <= EQUAL:
                        counts["reworded"][kind] += 1
                    else:
                        counts["other numbers"][kind] += 1
                        print(f"{name}: {difference.numbers:.1e} {difference.first}")
            sys.stdout.flush()
    for before, after in sorted(sentences):
        print(f"- {before}\n+ {after}")
    for result, files in counts.items():
        kinds = ", ".join(f"{kind} {count}" for kind, count in sorted(files.items()))
        print(f"{files.total()} {result} ({kinds})")
    fails = counts["other numbers"].total() + (counts["reworded"].total() if arguments.bytes else 0)
    sys.exit(1 if fails else 0)


if __name__ == "__main__":
    main()
