"""Sets every table that modalign writes as LaTeX for the scenes below measurements/ with pdflatex.

    python3 tests/reference/latex_tables.py [PROGRAM] [--scene NAME]... [--keep FOLDER]

PROGRAM is a built modalign; without it, the working tree is built in release mode. It runs `run` of
every scene, `update` and `correlate` of those with tests, each with its files in a temporary folder.
All LaTeX files of a scene become one document of the class `article` with 10, 11 and 12 pt on A4,
with the packages array, booktabs and longtable and no other.

A scene fails on an error of pdflatex, such as a character that it refuses; on a line or table that
is more than 1 pt too wide; on a table that is longer than a page; on a missing character of a font;
on a document without tables. For every scene one line has the number of tables, and for each size
the pages and the widest overfull box. The exit code is 1 where a scene fails, 2 where the program
does. --keep copies the documents and their PDF into a folder.

Needs pdflatex with booktabs: Debian's texlive-latex-base and texlive-latex-recommended.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCENES = sorted(p.parent.name for p in (ROOT / "measurements").glob("*/scene.toml"))
SIZES = ["10pt", "11pt", "12pt"]
MAX_OVERFULL_PT = 1.0
DOCUMENT = r"""\documentclass[%s,a4paper]{article}
\usepackage{array,booktabs,longtable}
\begin{document}
%s
\end{document}
"""
OVERFULL = re.compile(r"Overfull \\hbox \(([\d.]+)pt too wide\)[^\n]*")
TOO_LONG = re.compile(r"(?:Float too large for page|Overfull \\vbox \((?:\d{2,}|[2-9])\.)[^\n]*")
ERROR = re.compile(r"^!.*", re.MULTILINE)


def build():
    """The program of the working tree."""
    subprocess.run(["cargo", "build", "--release", "-q"], cwd=ROOT, check=True)
    return ROOT / "target" / "release" / "modalign"


def run(program, *arguments, folder=ROOT):
    """Runs a verb quietly. An exit code of 1 reports missed limits, not a failure."""
    command = [str(program), *map(str, arguments), "-q"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode not in (0, 1):
        sys.stderr.write(f"{' '.join(command)}\n{done.stderr}")
        sys.exit(2)


def latex_files(program, scene, folder):
    """The LaTeX files of a scene."""
    source = Path("measurements") / scene
    run(program, "run", source, "-o", folder / "run")
    tests = sorted(p for p in (folder / "run").glob("*.modes.json") if ".truth." not in p.name)
    if tests:
        run(program, "update", source, "-o", folder / "update")
        # Paths are captions and names of tests; relative ones are the same in every folder.
        arguments = [a for test in tests for a in ("--test", Path("run") / test.name)]
        theory = ["--theory", ROOT / source]
        for name, more in [("table", theory), ("measures", [*theory, "--measures"]), ("mac", [])]:
            output = folder / f"{name}.tex"
            run(program, "correlate", *arguments, *more, "-o", output, folder=folder)
    return sorted(folder.rglob("*.tex"))


def compile_document(text, size, folder):
    """Pages, the largest overfull box in pt, and what is wrong."""
    folder.mkdir()
    (folder / "tables.tex").write_text(DOCUMENT % (size, text), encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "tables.tex"]
    # A longtable knows its widths in the third run.
    for _ in range(3):
        subprocess.run(command, cwd=folder, capture_output=True)
    log = (folder / "tables.log").read_text(encoding="latin-1")
    pages = re.search(r"Output written on tables\.pdf \((\d+)", log)
    widest = max((float(width) for width in OVERFULL.findall(log)), default=0.0)
    wrong = ERROR.findall(log) + [found.group(0) for found in TOO_LONG.finditer(log)]
    wrong += re.findall(r"Missing character:[^\n]*", log)
    if widest > MAX_OVERFULL_PT:
        wrong += [found.group(0) for found in OVERFULL.finditer(log)]
    if not pages:
        wrong.append("no pages")
    return int(pages.group(1)) if pages else 0, widest, wrong


def check(program, scene, keep):
    """Prints the line of a scene; whether it is as it has to be."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = latex_files(program, scene, folder)
        text = "\n\\clearpage\n".join(file.read_text(encoding="utf-8") for file in files)
        tables = len(re.findall(r"\\begin\{(?:table|longtable)\}", text))
        wrong = [] if tables else ["no tables"]
        results = []
        for size in SIZES:
            pages, widest, wrong_here = compile_document(text, size, folder / size)
            results.append(f"{size} {pages} pages, widest overfull {widest:.1f} pt")
            wrong += [f"{size}: {message}" for message in wrong_here]
            if keep:
                target = keep / f"{scene}-{size}"
                for kind in ("tex", "pdf", "log"):
                    file = folder / size / f"tables.{kind}"
                    if file.exists():
                        shutil.copy(file, target.with_suffix(f".{kind}"))
    print(f"{scene}: {tables} tables; {'; '.join(results)}", flush=True)
    for message in wrong[:20]:
        print(f"    {message}")
    return not wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", nargs="?", type=Path)
    parser.add_argument("--scene", action="append", choices=SCENES)
    parser.add_argument("--keep", type=Path)
    arguments = parser.parse_args()
    if shutil.which("pdflatex") is None:
        sys.exit("pdflatex is missing: install texlive-latex-base and texlive-latex-recommended")
    program = arguments.program.resolve() if arguments.program else build()
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
    met = [check(program, scene, arguments.keep) for scene in arguments.scene or SCENES]
    sys.exit(0 if all(met) else 1)


if __name__ == "__main__":
    main()
