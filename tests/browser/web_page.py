"""Opens the web page of siloflow in headless Chromium and uses it as a student would.

    pip install -r tests/browser/requirements.txt
    python tests/browser/web_page.py target/release/siloflow crates/web/dist/siloflow.html [DIRECTORY]

The results of a run in the page are compared with those of the native program. Screenshots are kept in DIRECTORY.
"""

import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

from browser import SOFTWARE, share_of_ink, siloflow
from PIL import Image
from playwright.sync_api import sync_playwright
from window import Window, check, executable

SIZES = {"wide": (1280, 900), "narrow": (390, 844)}
GRAINS = 2000
# A bed of GRAINS discs.
BED = f"""(
    gravity: (0.0, -9.81), contact: Linear(k: 1.0e5, damping: Restitution(0.5)), mass: ArealSquare(100.0), step: Fixed(1.0e-4),
    walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))],
    fill: [(low: (0.0, 0.0), high: (1.0, 0.3), spacing: 0.0101, count: {GRAINS}, radius: Fixed(0.005))],
    until: 10.0,
)"""
# Wanted longest time from a click during a run to the response, ms. It depends on the machine, so a longer time is reported and does not fail.
WANTED_MS = 100.0
# Figures of a summary that belong to a machine. Lengths and hashes of files do, because frames are compressed by the word size of the machine.
OF_MACHINE = {"performance", "provenance", "files"}


class Page(Window):
    """The page in a window."""

    def __init__(self, browser, address, size=SIZES["wide"], **settings):
        super().__init__(browser, "the page", address, size, accept_downloads=True, **settings)

    def wait_until_right(self):
        self.page.wait_for_selector("#verdict .good", timeout=60_000)
        self.page.wait_for_function("() => document.querySelector('#facts b')", timeout=60_000)

    def verdict(self):
        self.page.wait_for_timeout(600)
        self.page.wait_for_selector("#verdict > :not(.plain)", timeout=60_000)
        return self.page.locator("#verdict").inner_text()

    def choose(self, name):
        self.page.locator("#shipped").select_option(name)
        self.page.wait_for_function("(name) => document.querySelector('#verdict .good') && document.querySelector('#facts b')", arg=name, timeout=60_000)

    def text(self):
        return self.page.locator("#text").input_value()

    def seconds(self):
        return float(self.page.locator("#facts b").inner_text().split()[0])

    def picture(self, path):
        self.page.wait_for_timeout(400)
        self.page.locator("#player canvas").screenshot(path=path)
        image = Image.open(path).convert("RGB")
        return image.crop((2, 2, image.width - 2, image.height - 2))

    def save(self, name, directory):
        with self.page.expect_download() as download:
            self.page.get_by_role("button", name=name, exact=True).click()
        path = directory / download.value.suggested_filename
        download.value.save_as(path)
        return path


def use_editor(view):
    """A mistake is marked at its place, with the program's words; the button leads there."""
    page = view.page
    right = view.text()
    lines = right.split("\n")
    number = next(number for number, line in enumerate(lines, 1) if "gravity:" in line)
    page.locator("#text").fill(right.replace("gravity:", "gravty:", 1))
    said = view.verdict()
    check(f"Line {number}, column" in said and "gravity" in said.split("gravty", 1)[1], "the mistake is not explained:", said)
    check(page.locator("#marks mark").inner_text().startswith("gravty"), "marked is", page.locator("#marks mark").inner_text())
    check(page.locator("#numbers b").inner_text() == str(number), "the number of the line is not marked")
    page.get_by_role("button", name="Go there").click()
    chosen = page.evaluate("() => { const t = document.getElementById('text'); return t.value.slice(t.selectionStart, t.selectionEnd); }")
    check(chosen.startswith("gravty"), "the cursor is at", chosen)
    check(page.locator("#run").is_disabled(), "a wrong scene can be run")
    page.reload()
    check("gravty" in view.text() or page.wait_for_timeout(1500) or "gravty" in view.text(), "the text is lost by a reload")
    page.locator("#text").fill(right)
    view.wait_until_right()


def numbers(summary):
    return {name: value for name, value in summary.items() if name not in OF_MACHINE}


def compare_archive(program, archive, native, directory):
    """The native program finds the files of the page whole, and the same frames and pictures in them."""
    shutil.rmtree(directory, ignore_errors=True)
    directory.mkdir()
    subprocess.run(["tar", "--extract", "--file", archive, "--directory", directory], check=True)
    run = directory / "silo1"
    siloflow(program, "verify", run)
    for number, source in enumerate((run, native)):
        siloflow(program, "export", source, "--to", "extxyz", "--out", directory / f"{number}.xyz")
    check((directory / "0.xyz").read_bytes() == (directory / "1.xyz").read_bytes(), "frames differ from those of the native program")
    pictures = sorted(path.name for path in (native / "frames").iterdir())
    check(pictures == sorted(path.name for path in (run / "frames").iterdir()), "there are other pictures")
    for name in pictures:
        check((run / "frames" / name).read_bytes() == (native / "frames" / name).read_bytes(), name, "differs")


def run_to_the_end(program, view, native, directory):
    """The whole silo: the same files as those of the native program, to the bit."""
    page = view.page
    check(0.01 < share_of_ink(view.picture(directory / "start.png")) < 0.97, "the silo is not drawn")
    page.locator("#run").click()
    page.wait_for_function("() => Number.parseFloat(document.querySelector('#facts b').textContent) > 5", timeout=60_000)
    page.screenshot(path=directory / "running.png")
    page.wait_for_selector("#summary:visible", timeout=300_000)
    check("empty" in page.locator("#summary").inner_text(), page.locator("#summary").inner_text())
    page.screenshot(path=directory / "end.png", full_page=True)
    summary = json.loads(view.save("summary.json", directory).read_text())
    expected = json.loads((native / "summary.json").read_text())
    check(summary["state_hash"] == expected["state_hash"], "state hashes", summary["state_hash"], expected["state_hash"])
    for name in sorted(set(numbers(summary)) | set(numbers(expected))):
        check(summary.get(name) == expected.get(name), "summary.json:", name, summary.get(name), expected.get(name))
    for name in ("series.csv", "state.csv"):
        check(view.save(name, directory).read_bytes() == (native / name).read_bytes(), name, "differs from that of the native program")
    archive = view.save("All files (tar)", directory)
    compare_archive(program, archive, native, directory / "of-page")
    check("<html" in view.save("Report (HTML)", directory).read_text()[:200], "the report is no page")
    return [expected["performance"]["wall_s"], summary["performance"]["wall_s"]]


def use_controls(view, rest):
    """Step, pause, speed, the next event."""
    page = view.page
    view.choose("free-fall")
    start = view.seconds()
    page.locator("#step").click()
    page.wait_for_function("(start) => Number.parseFloat(document.querySelector('#facts b').textContent) > start", arg=start)
    page.locator("#speed").select_option("0.1")
    page.locator("#run").click()
    page.wait_for_function("() => document.getElementById('run').textContent.includes('Pause')", timeout=20_000)
    start, before = time.monotonic(), view.seconds()
    page.wait_for_timeout(2000)
    share = (view.seconds() - before) / (time.monotonic() - start)
    check(0.05 < share < 0.15, "at a tenth of real time the run goes on at", share)
    page.locator("#run").click()
    page.wait_for_function("() => document.getElementById('run').textContent.includes('Run')", timeout=20_000)
    stopped = view.seconds()
    page.wait_for_timeout(400)
    check(view.seconds() == stopped, "a run that is paused goes on from", stopped, "to", view.seconds())
    page.locator("#speed").select_option("Infinity")
    view.choose("silo1")
    page.locator("#event").click()
    page.wait_for_function("() => /rest|door/.test(document.getElementById('told').textContent)", timeout=120_000)
    check(abs(view.seconds() - rest) < 0.002, "the grains come to rest at", view.seconds(), "natively at", rest)


def use_slider(view):
    page = view.page
    view.choose("fed-hopper")
    before = view.text()
    slider = page.locator("#parameters input").first
    name = slider.get_attribute("data-name")
    slider.focus()
    slider.press("ArrowRight")
    page.wait_for_function("(before) => document.getElementById('text').value !== before", arg=before, timeout=20_000)
    changed = [pair for pair in zip(before.split("\n"), view.text().split("\n")) if pair[0] != pair[1]]
    check(len(changed) == 1 and f'"{name}"' in changed[0][1], "the slider changes", changed)
    view.wait_until_right()


def use_link(view, browser, directory):
    page = view.page
    view.choose("silo1")
    text = view.text().replace("title", "// a student's silo\n    title", 1)
    page.locator("#text").fill(text)
    view.wait_until_right()
    page.get_by_role("button", name="Copy a link").click()
    page.wait_for_function("() => location.hash.startsWith('#s=')")
    other = Page(browser, page.url)
    other.wait_until_right()
    check(other.text() == text, "the link carries another text")
    other.page.screenshot(path=directory / "link.png")
    other.close()
    return len(page.url)


def hostile_links(browser, address, directory):
    """Text of a link is shown as text; what is no scene, or too large, is refused."""
    evil = "<img src=x onerror=alert(1)></script><script>alert(2)</script>"
    pack = """async (scene) => {
      const stream = new Blob([JSON.stringify(scene)]).stream().pipeThrough(new CompressionStream("deflate-raw"));
      const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
      let letters = ""; for (const byte of bytes) letters += String.fromCharCode(byte);
      return "#s=" + btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
    }"""
    maker = Page(browser, address)
    maker.wait_until_right()
    link = lambda scene: address + maker.page.evaluate(pack, scene)
    huge = BED.replace(str(GRAINS), "1900000").replace("high: (1.0, 0.3)", "high: (100.0, 30.0)")
    endless = BED.replace("until: 10.0", "until: 1.0e6, data_frames: (interval: 2.0e-3)")
    cases = {
        link({"name": evil, "text": evil}): None,
        link({"name": "../../x", "text": f'(title: "{evil}", gravty: 1)'}): None,
        link({"name": "huge", "text": huge}): "page::|freeze|more than",
        link({"name": "endless", "text": endless}): "GB",
        link({"name": "long", "text": " " * 3_000_000}): "more than a scene",
        link({"name": "none"}): "no scene",
        address + "#s=" + "A" * 500: "cannot be opened",
        address + "#s=%3Cscript%3E": "damaged",
    }
    for number, (url, words) in enumerate(cases.items()):
        view = Page(browser, url)
        view.page.wait_for_selector("#verdict .bad, #crash:visible", timeout=120_000)
        said = view.page.locator("#verdict").inner_text() + view.page.locator("#crash").inner_text()
        check(words is None or any(word in said for word in words.split("|")), "case", number, "says", said)
        check(view.page.locator("img[src=x]").count() == 0, "text of the link has become an element")
        view.page.screenshot(path=directory / f"hostile{number}.png")
        view.close()
    maker.close()


def keyboard_alone(browser, address):
    """Tab reaches the buttons, a key runs and pauses, Escape leaves the text."""
    view = Page(browser, address)
    view.wait_until_right()
    page = view.page
    seen = []
    for _ in range(60):
        page.keyboard.press("Tab")
        focused = page.evaluate("() => document.activeElement.id")
        if focused == "text":
            page.keyboard.press("Escape")
        seen.append(focused)
        if focused == "run":
            break
    check({"shipped", "open", "link", "text", "run"} <= set(seen), "Tab reaches", seen)
    page.keyboard.press("Enter")
    page.wait_for_function("() => Number.parseFloat(document.querySelector('#facts b').textContent) > 0.5", timeout=60_000)
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.getElementById('run').textContent.includes('Run')", timeout=20_000)
    nameless = page.evaluate("""() => [...document.querySelectorAll("button, input, select, textarea, canvas")].filter((control) => control.offsetParent
      && !(control.getAttribute("aria-label") || control.textContent.trim() || [...(control.labels ?? [])].map((label) => label.textContent.trim()).join("")))
      .map((control) => control.outerHTML)""")
    check(not nameless, "controls without a name:", nameless)
    view.close()


# A program whose function `shipped` fails, as WebAssembly.
FAILING = """WebAssembly.compile = async () => new WebAssembly.Module(new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 127, 3, 2, 1, 0,
  5, 3, 1, 0, 1, 7, 20, 2, 6, 109, 101, 109, 111, 114, 121, 2, 0, 7, 115, 104, 105, 112, 112, 101, 100, 0, 0, 10, 5, 1, 3, 0, 0, 11]));"""


def failing_program(browser, address):
    """A program that fails ends in a message, and the text is there."""
    view = Page(browser, address)
    view.wait_until_right()
    view.page.locator("#text").fill("(my: scene)")
    view.verdict()
    view.context.add_init_script(FAILING)
    view.page.reload()
    view.page.wait_for_selector("#crash:visible", timeout=20_000)
    said = view.page.locator("#crash").inner_text()
    check("failed" in said and "unreachable" in said and view.text() == "(my: scene)", said, view.text())
    view.close()


# A browser that starts no worker.
WITHOUT_WORKERS = """window.Worker = class {
  constructor() { setTimeout(() => this.onerror({ message: "no worker here" })); }
  postMessage() {}
  terminate() {}
};"""


def no_worker(browser, address):
    """A browser that starts no worker ends in a message."""
    context = browser.new_context()
    context.add_init_script(WITHOUT_WORKERS)
    page = context.new_page()
    page.goto(address)
    page.wait_for_selector("#crash:visible", timeout=20_000)
    said = page.locator("#crash").inner_text()
    check("unpacked" in said and "no worker here" in said, said)
    context.close()


def every_shipped_scene(view):
    """Each shipped scene can be opened; a refused one says why."""
    names = [option for option in view.page.locator("#shipped option").evaluate_all("(all) => all.map((o) => o.value)") if option]
    check(len(names) >= 25, names)
    for name in names:
        view.page.locator("#shipped").select_option(name)
        view.page.wait_for_function("(name) => document.querySelector('#verdict .good, #verdict .bad')", arg=name, timeout=120_000)
        check(view.page.locator("#verdict .bad").count() == 0, name, view.page.locator("#verdict").inner_text())


def measure_response(browser, address, directory):
    """Time from a click on Pause until the button says Run, with GRAINS grains; and the longest wait of a timer of 10 ms during the run."""
    view = Page(browser, address)
    view.wait_until_right()
    page = view.page
    page.locator("#text").fill(BED)
    view.verdict()
    view.wait_until_right()
    times = page.evaluate("""async () => {
      const run = document.getElementById("run");
      const until = async (word) => { while (!run.textContent.includes(word)) await new Promise((done) => setTimeout(done, 1)); };
      const times = [];
      for (let i = 0; i < 10; i++) {
        run.click();
        await until("Pause");
        await new Promise((done) => setTimeout(done, 700));
        const start = performance.now();
        run.click();
        await until("Run");
        times.push(performance.now() - start);
      }
      return times;
    }""")
    page.screenshot(path=directory / "bed.png")
    view.close()
    return times


def main(program, file, directory):
    directory.mkdir(parents=True, exist_ok=True)
    address = file.as_uri()
    native = directory / "native"
    # The copy that the page has: its scene names the file beside it.
    (directory / "silo1.ron").unlink(missing_ok=True)
    (directory / "silo1.dat").unlink(missing_ok=True)
    siloflow(program, "new", directory / "silo1", "--from", "silo1")
    siloflow(program, "run", directory / "silo1.ron", "--quiet", "--force", "--out", native)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable(), args=SOFTWARE)
        start = time.monotonic()
        view = Page(browser, address)
        view.wait_until_right()
        first = time.monotonic() - start
        use_editor(view)
        [of_native, of_page] = run_to_the_end(program, view, native, directory)
        use_controls(view, json.loads((native / "summary.json").read_text())["rest_time_s"])
        use_slider(view)
        length = use_link(view, browser, directory)
        every_shipped_scene(view)
        view.close()
        hostile_links(browser, address, directory)
        failing_program(browser, address)
        no_worker(browser, address)
        keyboard_alone(browser, address)
        for name, size in SIZES.items():
            for scheme in ("light", "dark"):
                view = Page(browser, address, size, color_scheme=scheme)
                view.wait_until_right()
                view.page.locator("#run").click()
                view.page.wait_for_function("() => Number.parseFloat(document.querySelector('#facts b').textContent) > 12", timeout=120_000)
                view.page.locator("#run").click()
                width = view.page.evaluate("document.documentElement.scrollWidth")
                check(width <= size[0], name, "is wider than the window:", width)
                paper = view.page.evaluate("getComputedStyle(document.body).backgroundColor")
                check((paper == "rgb(255, 255, 255)") == (scheme == "light"), scheme, "has the paper", paper)
                ink = view.picture(directory / "canvas.png")
                check((max(ink.getpixel((1, 1))) < 80) == (scheme == "dark"), scheme, "has the wrong picture", ink.getpixel((1, 1)))
                view.page.screenshot(path=directory / f"page-{name}-{scheme}.png", full_page=name == "narrow")
                view.close()
        times = measure_response(browser, address, directory)
        browser.close()
    print(f"web page: ready {first:.1f} s after loading; silo1 takes {of_page:.2f} s, natively {of_native:.2f} s, speed ratio {of_native / of_page:.2f}")
    print(f"web page: pause after {statistics.median(times):.0f} ms with {GRAINS} grains (median of {len(times)}, slowest {max(times):.0f}); load {os.getloadavg()[0]:.1f}")
    print(f"web page: a link with silo1 has {length} characters")
    if max(times) > WANTED_MS:
        print(f"web page: pausing takes {max(times):.0f} ms on this machine, more than {WANTED_MS:.0f} ms")
    print("web page: it works")


if __name__ == "__main__":
    check(len(sys.argv) in (3, 4), "usage: web_page.py SILOFLOW PAGE [DIRECTORY]")
    paths = [pathlib.Path(argument).resolve() for argument in sys.argv[1:]]
    if len(paths) == 3:
        main(*paths)
    else:
        with tempfile.TemporaryDirectory() as temporary:
            main(*paths, pathlib.Path(temporary))
