"""Puts hostile texts into a scene and looks at what other programs make of the results.

    python tests/reference/untrusted_text.py target/release/modalign [FOLDER]

Each of 60 texts is title, name of the test, method and reason of a scene of two files of modes. The
table has a row for each text and a column for each target:

terminal  no control character but the end of a line reaches standard output or standard error
html      headless Chromium runs no script of the text, and runs that of the page
svg, xml  figures and the JUnit file are well-formed
markdown  markdown-it makes no element of the text
latex     pdflatex makes a document of every table
csv       LibreOffice computes no cell
json      the results are JSON without raw control characters

Needs Chromium, LibreOffice Calc, pdflatex with booktabs, and the Python package markdown-it-py.
"""

import csv
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as tree

from markdown_it import MarkdownIt

RUN = "document.documentElement.setAttribute('data-run','1')"
TEXTS = [
    "\x1b]0;title\x07",
    "\x1b[2J\x1b[H",
    "\x1b[31mred\x1b[0m",
    "\x9b2J",
    "\x9d0;x\x9c",
    "\x1bP+q\x1b\\",
    "a\x08\x08b",
    "a\rb",
    "a\x7fb",
    "a\tb",
    "one\ntwo",
    "\u202eabc\u202c",
    "\u2066abc\u2069",
    "a\u2028b\u2029c",
    "\ufeffa\u200bb",
    f"<script>{RUN}</script>",
    f"<img src=x onerror=\"{RUN}\">",
    f"<svg onload=\"{RUN}\">",
    f"\"'><body onload=\"{RUN}\">",
    f"</script><script>{RUN}</script>",
    f"</title><script>{RUN}</script>",
    f"</pre></details><script>{RUN}</script>",
    f"<iframe srcdoc=\"<script>parent.{RUN}</script>\">",
    f"javascript:{RUN}",
    f"\" onmouseover=\"{RUN}\" autofocus onfocus=\"{RUN}\" x=\"",
    f"';{RUN};'",
    f"\\u003cscript\\u003e{RUN}",
    "<!-- <script>",
    "<![CDATA[ ]]> ]]>",
    "<?xml version='1.0'?><!DOCTYPE x [<!ENTITY y 'z'>]>&y;",
    "&lt;b&gt; &amp; &#60;i&#62;",
    "=1+1",
    "=HYPERLINK(\"http://localhost\",\"x\")",
    "=cmd|' /C calc'!A0",
    "+1+1",
    "-1+1",
    "@SUM(1,1)",
    "\t=1+1",
    " =1+1",
    "=1+1\"; =2+2",
    "＝1+1",
    "# heading",
    "> quotation",
    "1. item",
    "**bold** __bold__ *i* _i_",
    "`code` ``code``",
    "[a](javascript:x) ![b](http://localhost/x.png)",
    "[a]: http://localhost",
    "https://localhost www.localhost a@localhost.org",
    "| a | b |",
    "~~struck~~ ==x==",
    "<b>bold</b> <br>",
    "---",
    "\\input{/etc/passwd}",
    "\\immediate\\write18{ls}",
    "$x^2$ \\(y\\) 50% {a #1 & ~ ^ _",
    "\\begin{document}\\end{document}\\\\[1em]",
    "Σφ模态Жا😀\u0301",
    "%s %n {} {0} ${x} $(ls) `ls`",
    "a" * 3000,
]

HIDDEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff]")


def modes(text, hz):
    quality = {"verdict": "good", "frequency": None, "damping": None, "shape": None, "reasons": [text]}
    mode = {
        "frequency_hz": hz,
        "damping_ratio": 0.01,
        "shape": {"1:+X": [1.0, 0.0], "2:+X": [0.5, 0.0], "3:+X": [-0.4, 0.0]},
        "residues": {},
        "method": text,
        "quality": quality,
    }
    file = {"schema": "modalign-modes/1", "producer": text, "inputs": [], "references": []}
    return json.dumps({**file, "modes": [mode], "findings": []})


def scene(folder, text):
    folder.mkdir()
    quoted = json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
    lines = [
        'schema = "modalign-scene/1"',
        f"title = {quoted}",
        "[[test]]",
        f"name = {quoted}",
        'modes = "test.json"',
        "[model]",
        'file = "theory.json"',
        "[limits]",
        "min_mac = 0.9",
    ]
    (folder / "scene.toml").write_text("\n".join(lines), encoding="utf-8")
    (folder / "test.json").write_text(modes(text, 100.0))
    (folder / "theory.json").write_text(modes(text, 101.0))


def passes(check):
    try:
        check()
        return True
    except Exception as error:  # every failure is a cell of the table
        print(f"    {type(error).__name__}: {str(error)[:300]}")
        return False


def verify(condition, message):
    if not condition:
        raise AssertionError(message)


def results(program, folder, text):
    """Runs the scene; what was printed."""
    scene(folder, text)
    ran = subprocess.run(
        [program, "run", ".", "-o", "out", "--full"], cwd=folder, capture_output=True
    )
    verify(ran.returncode != 2, ran.stderr.decode(errors="replace"))
    checked = subprocess.run(
        [program, "check", "out/comparison.json", "--against", "scene.toml", "--junit", "out/check.xml"],
        cwd=folder,
        capture_output=True,
    )
    printed = [ran.stdout, ran.stderr, checked.stdout, checked.stderr]
    return [part.decode("utf-8") for part in printed]


def check_html(page):
    command = ["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=3000"]
    dom = subprocess.run(
        [*command, "--dump-dom", page.as_uri()], capture_output=True, timeout=60
    ).stdout.decode()
    head = re.search("<html[^>]*>", dom)
    verify(head is not None, "no document")
    verify("data-run" not in head.group(), "the script of the text ran")
    # The script of the page hides all tabs but one and draws the first.
    verify("aria-selected=\"true\"" in dom, "the script of the page did not run")


def check_markdown(text):
    known = {"paragraph", "heading", "table", "thead", "tbody", "tr", "th", "td", "strong", "em"}
    known |= {"bullet_list", "list_item", "inline", "text", "softbreak", "code_inline"}

    def walk(tokens):
        for token in tokens:
            kind = token.type.removesuffix("_open").removesuffix("_close")
            verify(kind in known, kind)
            # Codes of findings are code, and so are no texts of files.
            if kind == "code_inline":
                verify(re.fullmatch("[a-z-]+", token.content), token.content)
            walk(token.children or [])

    renderer = MarkdownIt("gfm-like", {"html": True, "linkify": False})
    walk(renderer.parse(text))


def check_latex(folder):
    document = "\\documentclass{article}\\usepackage[utf8]{inputenc}\\usepackage[T1]{fontenc}"
    document += "\\usepackage{array,booktabs,longtable}\\begin{document}"
    (folder / "all.tex").write_text(document + "\\input{comparison.tex}\\end{document}")
    ran = subprocess.run(
        ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "all.tex"],
        cwd=folder,
        capture_output=True,
        timeout=60,
    )
    log = ran.stdout.decode(errors="replace")
    verify(ran.returncode == 0, "\n".join(line for line in log.splitlines() if line.startswith("!")))


def check_csv(folder):
    tables = sorted(str(path) for path in folder.glob("*.csv"))
    converted = folder / "computed"
    subprocess.run(
        ["soffice", "--headless", "--convert-to", "csv", "--outdir", str(converted), *tables],
        capture_output=True,
        timeout=120,
    )
    for path in tables:
        with open(path, encoding="utf-8", newline="") as file:
            before = list(csv.reader(file))
        with open(converted / pathlib.Path(path).name, encoding="utf-8", newline="") as file:
            after = list(csv.reader(file))
        for old_row, new_row in zip(before, after):
            for old, new in zip(old_row, new_row):
                # Numbers are rounded; a text stays as it is, but for its apostrophe.
                if re.search("[^-+0-9.e]", old):
                    same = new.lstrip("'") == old.lstrip("'")
                    verify(same or new.startswith(old[:30]), f"{old!r} became {new!r}")


def check_json(folder):
    for path in folder.glob("*.json"):
        text = path.read_text(encoding="utf-8")
        json.loads(text)
        verify(not HIDDEN.search(text), path.name)


def check_xml(paths):
    for path in paths:
        tree.parse(path)


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    whole = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else tempfile.mkdtemp()) / "untrusted"
    shutil.rmtree(whole, ignore_errors=True)
    whole.mkdir(parents=True)
    targets = ["terminal", "html", "svg", "xml", "markdown", "latex", "csv", "json"]
    counts = dict.fromkeys(targets, 0)
    print("text".ljust(34), *targets)
    for number, text in enumerate(TEXTS):
        folder = whole / str(number)
        try:
            printed = results(program, folder, text)
        except AssertionError as error:
            print(repr(text)[:32].ljust(34), "refused:", str(error).strip()[:200])
            continue
        out = folder / "out"
        figures = list(out.glob("figures/*.svg"))
        row = {
            "terminal": passes(lambda: verify(not HIDDEN.search("".join(printed)), "control")),
            "html": passes(lambda: check_html(out / "report.html")),
            "svg": passes(lambda: (verify(figures, "no figure"), check_xml(figures))),
            "xml": passes(lambda: check_xml([out / "check.xml"])),
            "markdown": passes(lambda: check_markdown((out / "comparison.md").read_text())),
            "latex": passes(lambda: check_latex(out)),
            "csv": passes(lambda: check_csv(out)),
            "json": passes(lambda: check_json(out)),
        }
        for target, good in row.items():
            counts[target] += good
        cells = [("ok" if row[target] else "FAILS").ljust(len(target)) for target in targets]
        print(repr(text)[:32].ljust(34), *cells, flush=True)
    print("of", len(TEXTS), counts)
    sys.exit(any(count < len(TEXTS) for count in counts.values()))


main()
