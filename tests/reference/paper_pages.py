"""Writes a page for each paper into the guide: its tables, figures and statements, with what comes
out here.

    python3 tests/reference/paper_pages.py [PROGRAM]

PROGRAM is a built modalign; without it, the working tree is built in release mode. The pages and
their figures are written to src/guide/papers. The tables and verdicts are those of `modalign run`
of the scene, the figures those of `modalign run` and `modalign theory -o FIGURE.svg`.
"""

import csv
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = ROOT / "src/guide/papers"

HEAD = """# {title}

{authors} ({year}): {paper}. {journal}{doi}.

Of the paper the text was at hand, not the pictures: each figure is drawn from its caption and from
what the text says of it. No recording of the paper is published; the recordings are synthetic.
[SOURCE.md](../../../measurements/{scene}/SOURCE.md) says which numbers are printed, inferred and
assumed. `python3 tests/reference/paper_pages.py` writes this page from the results of
`modalign run measurements/{scene}`.
"""

# Figures of each paper: number, what it shows, then ("theory", arguments) or ("run", file).
CYCLOID_SWEEPS = [
    ["--sweep", "half_eccentricity=0.6e-3:2.1e-3:16"],
    ["--sweep", "k_03x=1e7:9e7:9"],
    ["--sweep", "k_03y=1e7:9e7:9"],
]
CYCLOID_SWEEPS = [word for sweep in CYCLOID_SWEEPS for word in sweep]
FRF = "figures/{}-frf-output.3-y-housing.{}-s.svg"
PAPERS = [
    {
        "scene": "cycloid-ball",
        "title": "Cycloid ball planetary transmission",
        "figures": [
            (
                "Figures 4 and 5",
                "mode shapes of the meshes: discs and balls of the virtual test, whose truth is the "
                "model with six stiffnesses changed",
                [("run", "figures/virtual-discs-and-balls-shapes.svg")],
            ),
            (
                "Figure 6",
                "ω3 and ω4 over the half eccentricity K r0 (r0 from 2 to 7 mm at K = 0.3), k03x and k03y; K "
                "at a constant K r0 changes neither visibly",
                [("theory", ["cycloid-ball", *CYCLOID_SWEEPS, "--band", "2000:2500"])],
            ),
            (
                "Figure 7",
                "ω13 and ω14 over K r0, k03x and k03y; the mode jump is a crossing",
                [("theory", ["cycloid-ball", *CYCLOID_SWEEPS, "--band", "8500:11500"])],
            ),
            (
                "Figure 8",
                "frequencies over the number of balls",
                [("theory", ["cycloid-ball", "--sweep", "ball_count=8:14:7", "--band", "1000:12000"])],
            ),
            (
                "Figure 9",
                "FRFs of the three hit points, from synthetic recordings with the frequencies of "
                "Table 3",
                [
                    ("run", FRF.format("large-cylinder", 1)),
                    ("run", FRF.format("small-cylinder", 2)),
                    ("run", FRF.format("centre-disc-face", 3)),
                ],
            ),
        ],
    },
    {
        "scene": "spider-reducer",
        "title": "Spider reducer HJW-18B",
        "figures": [
            (
                "Figure 8",
                "energy of the first nine modes by subsystem; equal shafts and gears are summed",
                [("theory", ["spider-reducer", "--energies", "--band", "0:275"])],
            ),
            (
                "Figure 11",
                "FRFs of input and output, from a synthetic recording of the model with a bearing "
                "k_i2 of twice its stiffness",
                [
                    ("run", "figures/input-and-output-frf-input.1-x-input.1-x.svg"),
                    ("run", "figures/input-and-output-frf-output.1-x-input.1-x.svg"),
                ],
            ),
        ],
    },
    {
        "scene": "helical-planetary",
        "title": "Helical planetary gear with varying pressure angle",
        "figures": [
            (
                "Figures 3, 4, 6, 7 and 8",
                "deflection of the meshes and its spectrum, pressure angle, load sharing and "
                "displacement of the sun, with constant and with varying angle",
                [("theory", ["helical-planetary", "--response"])],
            ),
            (
                "Figure 5",
                "the same with bearings of 1e10 N/m",
                [("theory", ["helical-planetary/kb-1e10", "--response"])],
            ),
        ],
    },
    {
        "scene": "torsional-planetary",
        "title": "Torsional 2K-H planetary gear",
        "figures": [
            (
                "Figures 3 to 5",
                "loci of the natural frequencies over the mesh stiffness of the ring and over the "
                "sun's mass, carrier fixed, three planets; the energies of figures 4 and 5 are not "
                "drawn, their exchange is judged below",
                [
                    (
                        "theory",
                        [
                            "torsional-planetary/carrier-fixed",
                            "--sweep",
                            "k_r=1e7:1e11:80",
                            "--sweep",
                            "m_s=0.1:30:80",
                        ],
                    )
                ],
            ),
        ],
    },
]


def program() -> Path:
    if len(sys.argv) > 1:
        return Path(sys.argv[1]).resolve()
    subprocess.run(["cargo", "build", "--release"], cwd=ROOT, check=True)
    return ROOT / "target/release/modalign"


def run(modalign: Path, *arguments: str) -> None:
    # Exit code 1 is a missed limit.
    done = subprocess.run([modalign, *arguments, "-q"], cwd=ROOT, stdout=subprocess.DEVNULL)
    if done.returncode not in (0, 1):
        sys.exit(f"modalign {' '.join(arguments)}: exit code {done.returncode}")


def rows(path: Path) -> list[list[str]]:
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        lines = list(csv.reader(file))
    # Errors are worth fewer digits than frequencies.
    digits = [3 if "(%)" in head else 6 for head in lines[0]]
    text = [[cell_text(cell, n) for cell, n in zip(row, digits)] for row in lines[1:]]
    return [lines[0], *text]


def cell_text(cell: str, digits: int) -> str:
    # A quote before a sign keeps spreadsheet programs from computing.
    if cell.startswith("'"):
        cell = cell[1:]
    try:
        number = float(cell)
    except ValueError:
        return cell.replace("|", "\\|")
    # Below that the error of a printed number is rounding.
    if abs(number) < 1e-9:
        return "0"
    return f"{number:.{digits}g}" if "." in cell else cell


def table(lines: list[list[str]]) -> str:
    kept = [j for j in range(len(lines[0])) if any(line[j] for line in lines[1:])]
    text = [[line[j] or "—" for j in kept] for line in lines]
    rule = ["---"] * len(kept)
    return "\n".join("| " + " | ".join(line) + " |" for line in [text[0], rule, *text[1:]]) + "\n"


def figure_numbers(name: str) -> set[str]:
    words = name.lower().replace("figures", "").replace("figure", "")
    if " to " in words:
        first, last = (int(word) for word in words.split(" to "))
        return {str(number) for number in range(first, last + 1)}
    return set(words.replace("and", ",").replace(" ", "").split(","))


def claim_figures(claim: str) -> set[str]:
    words = claim.lower().replace("beside ", "")
    if not words.startswith("figure"):
        return set()
    head = words.split(":")[0].split(" is ")[0].split(" with ")[0]
    return figure_numbers(head) if any(c.isdigit() for c in head) else set()


def page(modalign: Path, paper: dict, folder: Path) -> str:
    scene = paper["scene"]
    out = folder / scene
    run(modalign, "run", f"measurements/{scene}", "-o", str(out))
    source = tomllib.loads((ROOT / f"measurements/{scene}/expected.toml").read_text())["source"]
    doi = f", doi:{source['doi']}" if "doi" in source else ""
    text = HEAD.format(
        title=paper["title"],
        scene=scene,
        authors=source["authors"],
        year=source["year"],
        paper=source["paper"],
        journal=source["journal"],
        doi=doi,
    )
    for name, title in [
        ("published-roots.csv", "Natural frequencies"),
        ("published-comparison.csv", "Theory and test as printed, errors computed again"),
    ]:
        lines = rows(out / name)
        if lines:
            text += f"\n## {title}\n\n{table(lines)}"
    claims = rows(out / "published-claims.csv")
    left = claims[1:]
    for number, (name, shows, parts) in enumerate(paper["figures"], 1):
        text += f"\n## {name}\n\n{shows[0].upper()}{shows[1:]}.\n"
        for part, (kind, what) in enumerate(parts, 1):
            file = f"{scene}-{number}-{part}.svg"
            if kind == "run":
                shutil.copy(out / what, PAGES / file)
            else:
                run(modalign, "theory", *what, "-o", str(PAGES / file))
                command = " ".join(what)
                text += f"\n`modalign theory {command} -o figure.svg`\n"
            text += f"\n![{name}, part {part}]({file})\n"
        ours = figure_numbers(name)
        judged = [claim for claim in left if claim_figures(claim[0]) & ours]
        left = [claim for claim in left if claim not in judged]
        if judged:
            text += "\n" + table([claims[0], *judged])
    if left:
        text += f"\n## Further statements\n\n{table([claims[0], *left])}"
    return text


def main() -> None:
    modalign = program()
    shutil.rmtree(PAGES, ignore_errors=True)
    PAGES.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as folder:
        for paper in PAPERS:
            text = page(modalign, paper, Path(folder))
            (PAGES / f"{paper['scene']}.md").write_text(text, encoding="utf-8")


main()
