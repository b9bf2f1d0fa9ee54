"""Opens HTML reports in headless Chromium and uses them as a person does.

    python3 -m venv venv && venv/bin/pip install websocket-client
    venv/bin/python tests/reference/report.py target/release/modalign OUT

Needs Debian's `chromium`. Runs the scenes `free-free-beam` and `cycloid-ball` with `-o`, their update and two short studies of each (folders that
hold a breakdown.json are kept), then checks of each page: no console error, no request beside the file, size and first paint, every tab draws, values under the
pointer, zoom, animation, charts and maps of the studies, poles clicked on and off and saved as a selection.json that `modalign identify` takes, keyboard, print, no letters over each other.
Screenshots of every tab at 1400 and 420 pixels, light and dark, are for looking at. Not part of `cargo test`.
"""

import base64
import json
import pathlib
import subprocess
import sys
import tempfile
import time
import urllib.request

import websocket

SCENES = ["free-free-beam", "cycloid-ball"]
MOST_BYTES = 3_000_000
MOST_PAINT_MS = 1000

# Few draws: the figures are looked at, not what they say.
STUDY = """schema = "modalign-study/1"
scene = "SCENE"
[speed_accuracy]
TESTS
estimators = ["h1", "h2"]
record_shares = [0.5]
orders = [32]
snr_db = [30.0, 50.0, 70.0]
draws = 1
repeats = 1
[breakdown]
draws = 20
refine = 1
stability = { highest_order = 30 }
[[breakdown.slice]]
x = { factor = "damping", lo = 0.001, hi = 0.1, count = 5, scale = "log" }
y = { factor = "noise", lo = 10.0, hi = 70.0, count = 4 }
[[breakdown.slice]]
x = { factor = "separation", lo = 0.1, hi = 20.0, count = 5, scale = "log" }
y = { factor = "references", lo = 1.0, hi = 3.0 }
"""


class Chromium:
    """One page under the DevTools protocol."""

    def __init__(self, downloads):
        self.folder = tempfile.TemporaryDirectory()
        self.process = subprocess.Popen(
            ["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--remote-debugging-port=0",
             "--remote-allow-origins=*", f"--user-data-dir={self.folder.name}", "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        port_file = pathlib.Path(self.folder.name) / "DevToolsActivePort"
        for _ in range(200):
            if port_file.exists() and port_file.read_text().strip():
                break
            time.sleep(0.1)
        port = port_file.read_text().split()[0]
        pages = json.load(urllib.request.urlopen(f"http://127.0.0.1:{port}/json"))
        target = next(page for page in pages if page["type"] == "page")
        self.socket = websocket.create_connection(target["webSocketDebuggerUrl"], timeout=60)
        self.number = 0
        self.events = []
        for domain in ["Page", "Runtime", "Log", "Network"]:
            self.call(f"{domain}.enable")
        self.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(downloads))

    def call(self, method, **parameters):
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": parameters}))
        while True:
            message = json.loads(self.socket.recv())
            if message.get("id") == self.number:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']}")
                return message["result"]
            self.events.append(message)

    def run(self, text):
        result = self.call("Runtime.evaluate", expression=text, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(f"{text}: {result['exceptionDetails']}")
        return result["result"].get("value")

    def open(self, path, width, dark):
        self.events.clear()
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width < 600)
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        self.call("Page.navigate", url=f"file://{path}")
        for _ in range(200):
            if self.run("document.readyState") == "complete":
                break
            time.sleep(0.05)
        time.sleep(0.3)

    def errors(self):
        """Errors of console and script, and what was loaded beside the page."""
        found = []
        for event in self.events:
            method, parameters = event.get("method"), event.get("params", {})
            if method == "Runtime.exceptionThrown":
                found.append(parameters["exceptionDetails"].get("exception", {}).get("description", "exception"))
            if method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning"):
                found.append(str(parameters["args"]))
            if method == "Log.entryAdded" and parameters["entry"]["level"] == "error":
                found.append(parameters["entry"]["text"])
            if method == "Network.requestWillBeSent" and not parameters["request"]["url"].startswith(("file:", "data:", "blob:")):
                found.append(f"request of {parameters['request']['url']}")
        return found

    def mouse(self, kind, x, y, button="none", clicks=0):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, clickCount=clicks)

    def click(self, x, y):
        self.mouse("mouseMoved", x, y)
        self.mouse("mousePressed", x, y, "left", 1)
        self.mouse("mouseReleased", x, y, "left", 1)

    def key(self, name):
        for kind in ["keyDown", "keyUp"]:
            self.call("Input.dispatchKeyEvent", type=kind, key=name, code=name)

    def shot(self, path, whole=True):
        image = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(image["data"]))

    def tab(self, name):
        self.run(f"document.getElementById('tab-{name}').click()")
        time.sleep(0.25)

    def close(self):
        self.socket.close()
        self.process.terminate()
        self.process.wait()


def place(page, selector):
    """The middle of an element in the window, after scrolling to it."""
    text = f"""(() => {{ const node = document.querySelector({selector!r}); if (!node) return null;
        node.scrollIntoView({{ block: 'center' }}); const b = node.getBoundingClientRect();
        return [b.left + b.width / 2, b.top + b.height / 2, b.width, b.height]; }})()"""
    return page.run(text)


def tip(page):
    return page.run("(() => { const t = document.querySelector('.tip'); return t && !t.hidden ? t.innerText : ''; })()")


def check_hover_and_zoom(page, check):
    page.tab("frf")
    x, y, width, height = place(page, "#frf .plot svg")
    page.mouse("mouseMoved", x, y)
    check("hover tells values", "Hz" in tip(page), repr(tip(page)))
    ticks = "[...document.querySelectorAll('#frf .plot svg text')].map((t) => t.textContent).join()"
    before = page.run(ticks)
    page.mouse("mousePressed", x - 60, y, "left", 1)
    for k in range(6):
        page.mouse("mouseMoved", x - 60 + 20 * k, y, "left")
    page.mouse("mouseReleased", x + 60, y, "left", 1)
    check("dragging zooms", page.run(ticks) != before)
    page.run("document.querySelector('#frf .plot svg').focus()")
    page.key("0")
    check("key 0 resets the zoom", page.run(ticks) == before)
    page.run("document.querySelector('#frf .legend button').click()")
    check("a legend hides its curve", page.run("document.querySelector('#frf .legend button').getAttribute('aria-pressed')") == "false")
    page.tab("mac")
    place(page, "#mac svg")
    box = page.run("(() => { const b = document.querySelector('#mac svg rect:nth-of-type(2)').getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]; })()")
    page.mouse("mouseMoved", *box)
    check("MAC tells values", tip(page).startswith("MAC"), repr(tip(page)))


def check_animation(page, check):
    page.tab("shapes")
    snapshot = "document.querySelector('#shapes canvas').toDataURL().length + document.querySelector('#shapes canvas').toDataURL().slice(-4000)"
    first = page.run(snapshot)
    time.sleep(0.4)
    second = page.run(snapshot)
    check("shapes move", first != second)
    page.run("document.querySelector('#shapes button.main').click()")
    time.sleep(0.1)
    first = page.run(snapshot)
    time.sleep(0.3)
    check("pause stops them", first == page.run(snapshot))
    x, y, *_ = place(page, "#shapes canvas")
    page.mouse("mousePressed", x, y, "left", 1)
    page.mouse("mouseMoved", x + 80, y + 30, "left")
    page.mouse("mouseReleased", x + 80, y + 30, "left", 1)
    check("dragging turns them", first != page.run(snapshot))
    modes = page.run("document.querySelectorAll('#shapes select')[document.querySelectorAll('#shapes select').length - 1].options.length")
    check("modes can be chosen", modes > 1, str(modes))


def check_selection(page, check, binary, folder, downloads):
    page.tab("poles")
    picked = "parseInt(document.querySelector('#poles .count').textContent)"
    place(page, "#poles .plot svg")
    spots = page.run("""[...document.querySelectorAll('#poles .plot svg circle')].filter((c) => c.getAttribute('fill') === palette.series[2])
        .map((c) => { const b = c.getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]; })""")
    check("chosen poles are drawn", len(spots) > 2, str(len(spots)))
    wanted = [spots[0], spots[len(spots) // 2], spots[-1]]
    for spot in wanted:
        page.click(*spot)
    check("clicking picks poles", page.run(picked) == len({tuple(s) for s in wanted}), str(page.run(picked)))
    page.click(*wanted[1])
    check("clicking again drops one", page.run(picked) == 2, str(page.run(picked)))
    page.run("document.querySelector('#poles .plot svg').focus()")
    for name in ["ArrowRight", "ArrowRight", "Enter"]:
        page.key(name)
    check("arrows and Enter pick", page.run(picked) in (1, 3), str(page.run(picked)))
    page.run("[...document.querySelectorAll('#poles .bar button')][1].click()")
    check("all can be dropped", page.run(picked) == 0)
    page.run("[...document.querySelectorAll('#poles .bar button')][0].click()")
    count = page.run(picked)
    check("the chosen can be picked", count > 0, str(count))
    target = downloads / "selection.json"
    target.unlink(missing_ok=True)
    page.run("document.querySelector('#poles .bar button.main').click()")
    for _ in range(50):
        if target.exists() and target.stat().st_size:
            break
        time.sleep(0.1)
    saved = json.loads(target.read_text())
    check("selection.json is saved", saved["schema"] == "modalign-selection/1" and len(saved["poles"]) == count)
    command = page.run("document.querySelector('#poles code').textContent").split()
    # The command of the page, with its first test's file in the folder of the run.
    at = 2
    end = command.index("--method")
    path = folder / " ".join(command[at:end])
    rest = [str(target) if part == "selection.json" else part for part in command[end:]]
    rest[rest.index("-o") + 1] = str(downloads / "modes.json")
    result = subprocess.run([binary, "identify", str(path), *rest], capture_output=True, text=True)
    check("identify takes it", result.returncode == 0, result.stderr[-400:])
    if result.returncode != 0:
        return
    modes = json.loads((downloads / "modes.json").read_text())["modes"]
    near = all(any(abs(pole["frequency_hz"] - mode["frequency_hz"]) < 0.01 * pole["frequency_hz"] for mode in modes) for pole in saved["poles"])
    check("its modes are the picked poles", near and len(modes) >= 1, f"{len(modes)} modes")


def check_studies(page, check):
    page.tab("methods")
    check("the studies are drawn", page.run("document.querySelectorAll('#methods .plot svg').length") >= 5)
    pick = "(() => {{ const s = document.querySelectorAll('#methods select')[{}]; s.selectedIndex = {}; s.dispatchEvent(new Event('change')); }})()"
    labels = page.run("[...document.querySelectorAll('#methods .choice span')].map((s) => s.textContent)")
    middle = "(() => {{ const b = document.querySelectorAll('#methods .plot svg')[{}].querySelectorAll({!r})[{}].getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]; }})()"
    scroll = "document.querySelectorAll('#methods .plot')[{}].scrollIntoView({{ block: 'center' }})"
    page.run(scroll.format(0))
    page.mouse("mouseMoved", *page.run(middle.format(0, "path[transform]", 0)))
    check("a method tells time and error", " ms" in tip(page) and "%" in tip(page), repr(tip(page)))
    page.run(pick.format(labels.index("Cost"), 1))
    check("memory stands in place of time", "MiB" in page.run("document.querySelector('#methods .plot svg').textContent"))
    page.run(pick.format(labels.index("Data"), 1))
    check("the twin stands in place of the data", "dB" in page.run("[...document.querySelectorAll('#methods .note')].map((n) => n.textContent).join()"))
    plots = page.run("[...document.querySelectorAll('#methods .plot svg')].findIndex((s) => s.getAttribute('aria-label').startsWith('noise-damping'))")
    check("there is a map", plots >= 0)
    contours = f"document.querySelectorAll('#methods .plot svg')[{plots}].querySelectorAll('path[stroke-width=\"2\"]').length"
    before = page.run(contours)
    page.run(scroll.format(plots))
    page.mouse("mouseMoved", *page.run(middle.format(plots, "circle", 0)))
    check("a mode tells how far it is from failing", "mode " in tip(page) and "circle: " in tip(page), repr(tip(page)))
    x, y, width, height = page.run(f"(() => {{ const b = document.querySelectorAll('#methods .plot svg')[{plots}].getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; }})()")
    page.mouse("mouseMoved", x + width - 40, y + 30)
    check("a place tells the share of every method", tip(page).count("%") == 7, repr(tip(page)))
    page.run(pick.format(labels.index("Method"), 2))
    check("one method has one contour", before > 1 and page.run(contours) == 1, f"{before} {page.run(contours)}")
    distances = page.run("document.querySelector('#methods ul.sentences').innerText")
    check("the distances of the modes are shown", "circle" in distances, repr(distances))
    page.run(pick.format(labels.index("Map"), 1))
    check("the method stays when another map is taken", page.run("document.querySelectorAll('#methods select')[%d].selectedIndex" % labels.index("Method")) == 2)


def check_keyboard(page, check):
    page.run("document.querySelector('nav [aria-selected=true]').focus()")
    before = page.run("document.querySelector('nav [aria-selected=true]').id")
    page.key("ArrowRight")
    after = page.run("document.querySelector('nav [aria-selected=true]').id")
    check("arrows move between tabs", before != after, f"{before} {after}")
    focusable = page.run("document.querySelectorAll('a[href], button, select, input, [tabindex=\"0\"]').length")
    check("parts can be reached by keyboard", focusable > 20, str(focusable))


# Texts of one figure that cover each other by more than a pixel, as pairs.
OVERLAPS = """(() => { const found = [];
    for (const figure of document.querySelectorAll('main > section:not([hidden]) svg')) {
        const all = [...figure.querySelectorAll('text')].filter((t) => t.textContent && !t.getAttribute('transform')).map((t) => [t.textContent, t.getBoundingClientRect()]);
        all.forEach(([one, a], k) => all.slice(k + 1).forEach(([other, b]) => {
            const across = Math.min(a.right, b.right) - Math.max(a.left, b.left), down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
            if (across > 1 && down > 3) found.push(`${one} / ${other}`);
        }));
    }
    return found; })()"""


def check_page(binary, folder, shots, downloads):
    path = (folder / "report.html").resolve()
    size = path.stat().st_size
    failed = []

    def check(what, met, shown=""):
        print(f"  {'ok    ' if met else 'FAILED'} {what} {shown if not met else ''}")
        if not met:
            failed.append(what)

    print(f"{path}: {size} bytes")
    check("under 3 MB", size < MOST_BYTES, str(size))
    page = Chromium(downloads)
    try:
        page.open(path, 1400, False)
        paint = page.run("performance.getEntriesByName('first-contentful-paint')[0].startTime")
        ready = page.run("performance.getEntriesByType('navigation')[0].loadEventEnd")
        print(f"  first paint {paint:.0f} ms, loaded {ready:.0f} ms")
        check("first paint under 1 s", paint < MOST_PAINT_MS, f"{paint:.0f} ms")
        tabs = page.run("[...document.querySelectorAll('nav a')].map((a) => a.id.slice(4))")
        for name in tabs:
            page.tab(name)
            drawn = page.run(f"(() => {{ const s = document.getElementById('{name}'); return !s.hidden && s.innerText.trim().length > 20; }})()")
            check(f"tab {name} draws", drawn)
        check_hover_and_zoom(page, check)
        check_animation(page, check)
        check_studies(page, check)
        check_keyboard(page, check)
        check_selection(page, check, binary, folder, downloads)
        check("no error on the console, nothing loaded", not page.errors(), str(page.errors()))
        for width in [1400, 420]:
            for dark in [False, True]:
                page.open(path, width, dark)
                for name in tabs:
                    page.tab(name)
                    wide = page.run("document.documentElement.scrollWidth")
                    check(f"{name} fits {width}", wide <= width, str(wide))
                    covered = page.run(OVERLAPS)
                    check(f"letters of {name} can be read at {width}", not covered, str(covered[:5]))
                    page.shot(shots / f"{folder.name}-{width}-{'dark' if dark else 'light'}-{name}.png")
                check(f"no error at {width}", not page.errors(), str(page.errors()))
        page.open(path, 1400, True)
        pdf = base64.b64decode(page.call("Page.printToPDF", printBackground=True, preferCSSPageSize=True)["data"])
        (shots / f"{folder.name}.pdf").write_bytes(pdf)
        check("it prints", len(pdf) > 50_000 and not page.errors(), str(page.errors()))
    finally:
        page.close()
    return failed


def main():
    binary = str(pathlib.Path(sys.argv[1]).resolve())
    out = pathlib.Path(sys.argv[2])
    root = pathlib.Path(__file__).resolve().parents[2]
    shots, downloads = out / "shots", (out / "downloads").resolve()
    for folder in [shots, downloads]:
        folder.mkdir(parents=True, exist_ok=True)
    failed = []
    for scene in SCENES:
        folder = out / scene
        if not (folder / "breakdown.json").exists():
            folder.mkdir(parents=True, exist_ok=True)
            spec = (out / f"{scene}.study.toml").resolve()
            tests = 'tests = ["large cylinder"]' if scene == "cycloid-ball" else ""
            spec.write_text(STUDY.replace("SCENE", str(root / "measurements" / scene)).replace("TESTS", tests))
            for words in [["run", f"measurements/{scene}"], ["update", f"measurements/{scene}"], ["study", "speed-accuracy", str(spec)], ["study", "breakdown", str(spec)]]:
                subprocess.run([binary, *words, "-q", "-o", str(folder.resolve())], cwd=root, check=False, stdout=subprocess.DEVNULL)
            subprocess.run([binary, "report", str(folder.resolve())], check=True, stdout=subprocess.DEVNULL)
        failed += [f"{scene}: {what}" for what in check_page(binary, folder, shots, downloads)]
    print(f"{len(failed)} checks failed" if failed else "all checks passed", *failed, sep="\n")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
