"""Opens reports in headless Chromium, uses their players, and measures how long a frame takes.

    pip install -r tests/browser/requirements.txt
    python tests/browser/browser.py target/release/siloflow [DIRECTORY]

It needs the package `chromium` of Debian, or another Chromium named by CHROMIUM. Screenshots are kept in DIRECTORY. Everything is used as
a reader would: by clicks and keys, and what is on the screen is compared before and after.
"""

import base64
import io
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

from PIL import Image, ImageChops
from playwright.sync_api import sync_playwright
from window import ROOT, Window, check, executable

SIZES = {"wide": (1280, 900), "narrow": (400, 800)}
# WebGL without a graphics card.
SOFTWARE = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
# The wanted time from a new position of the slider to the new picture: 20 frames a second. It depends on the machine, so a longer time is
# reported and does not fail.
WANTED_MS = 50.0
INTERVAL = 0.1

GRAINS = 20_000
# A bed of GRAINS discs, and one of as many spheres, for a few steps.
LARGE = {
    "large2d": f"""(
        gravity: (0.0, -9.81), contact: Linear(k: 1.0e5, damping: Restitution(0.5)), mass: ArealSquare(100.0), step: Fixed(1.0e-4),
        walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))],
        fill: [(low: (0.0, 0.0), high: (2.0, 1.1), spacing: 0.0101, count: {GRAINS}, radius: Fixed(0.005))],
        until: 0.03, data_frames: (interval: 1.0e-3),
    )""",
    "large3d": f"""(
        space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.5)), mass: Sphere(2500.0),
        step: Fixed(1.0e-4), walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))],
        fill: [(low: (0.0, 0.0, 0.0), high: (0.28, 0.28, 0.3), spacing: 0.0101, count: {GRAINS}, radius: Fixed(0.005))],
        until: 0.03, data_frames: (interval: 1.0e-3),
    )""",
}

# Milliseconds from each new position of the slider until the graphics program has drawn the new picture.
MEASURE = """async () => {
  const slider = document.querySelector(".sfp-scrub");
  const gl = document.querySelector(".sfp canvas").getContext("webgl2");
  const pixel = new Uint8Array(4);
  const times = [];
  for (let i = 0; i < 60; i++) {
    const start = performance.now();
    slider.value = i % (Number(slider.max) + 1);
    slider.dispatchEvent(new Event("input"));
    await new Promise(requestAnimationFrame);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    times.push(performance.now() - start);
  }
  return times;
}"""

# Controls of players without a name for screen readers.
NAMELESS = """() => [...document.querySelectorAll(".sfp input, .sfp select, .sfp button, .sfp canvas")]
  .filter((control) => !(control.getAttribute("aria-label") || [...(control.labels ?? [])].map((label) => label.textContent.trim()).join("")))
  .map((control) => control.outerHTML)"""


def siloflow(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False, cwd=ROOT)
    check(done.returncode == 0, *arguments, done.stderr)


def reports(program, directory):
    """Makes runs and writes their reports; returns the files."""
    small = {
        "plane": ["scenes/silo1-mixture.ron", "--set", "spawner.count=150", "--until", "9", "--set", f"data_frames=(interval: {INTERVAL})"],
        "lattice": ["scenes/silo2d-lattice.ron", "--until", "1000"],
        "solid": ["scenes/silo3d.ron", "--until", "0.04", "--set", "data_frames=(interval: 0.004)", "--set", "pictures=None"],
    }
    files = {}
    for name, text in LARGE.items():
        (directory / f"{name}.ron").write_text(text)
    for name in (*small, *LARGE):
        arguments = small.get(name, [directory / f"{name}.ron"])
        siloflow(program, "run", *arguments, "--quiet", "--force", "--out", directory / name)
        files[name] = directory / f"{name}.html"
        siloflow(program, "report", directory / name, "--out", files[name], "--force")
    return files


class Page(Window):
    """A report in a window."""

    def __init__(self, browser, file, size, **settings):
        super().__init__(browser, file.name, file.as_uri(), size, **settings)
        self.page.wait_for_selector(".sfp, .sfp-message", timeout=60_000)
        self.file = file

    def picture(self):
        """What the canvas shows, without its border."""
        self.page.wait_for_timeout(700)
        image = Image.open(io.BytesIO(self.page.locator(".sfp canvas, .sfp img").screenshot())).convert("RGB")
        return image.crop((2, 2, image.width - 2, image.height - 2))

    def seconds(self):
        return float(self.page.locator(".sfp-facts b").inner_text().split()[0])

    def changed(self, what, action):
        """The action changes the picture."""
        before = self.picture()
        action()
        after = self.picture()
        check(share_of_difference(before, after) > 0.002, self.file.name, what, "does not change the picture")
        return after


def control(page, name):
    """The control of the player with this label."""
    return page.locator(".sfp").get_by_label(name, exact=True)


def share_of_difference(a, b):
    """Share of the pixels that differ visibly."""
    check(a.size == b.size, "the picture has another size:", a.size, b.size)
    difference = ImageChops.difference(a, b).convert("L").point(lambda level: 255 if level > 12 else 0)
    return difference.histogram()[255] / (a.width * a.height)


def share_of_ink(image):
    """Share of the pixels that differ from the corner."""
    background = Image.new("RGB", image.size, image.getpixel((1, 1)))
    return share_of_difference(image, background)


def point_at_a_grain(page):
    """The numbers of a grain under the pointer, of one that is followed after a click, and else how to move the picture."""
    words = page.locator(".sfp-grain")
    check("Drag to" in words.inner_text(), "the player does not tell how to move the picture:", words.inner_text())
    canvas = page.locator(".sfp canvas")
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    places = [(0.1 * i, 0.05 * j) for j in range(19, 0, -1) for i in range(3, 8)]
    for x, y in places:
        page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"])
        # A browser may handle a move at its next picture.
        page.wait_for_timeout(100)
        if words.inner_text().startswith("grain "):
            break
    page.wait_for_timeout(300)
    seen = words.inner_text()
    check(seen.startswith("grain ") and " m, " in seen and "radius" in seen, "no grain is under the pointer:", seen)
    page.mouse.down()
    page.mouse.up()
    page.wait_for_timeout(200)
    check("followed" in words.inner_text(), "a click does not follow a grain:", words.inner_text())
    canvas.focus()
    page.keyboard.press("ArrowLeft")
    after = words.inner_text()
    check(after.split(":")[0] == seen.split(":")[0] and after != seen, "the grain is not followed:", seen, after)
    page.mouse.move(box["x"] + 0.02 * box["width"], box["y"] + 0.98 * box["height"])
    page.mouse.down()
    page.mouse.up()
    page.wait_for_timeout(200)
    check("Drag to" in words.inner_text(), "a click beside the grains does not let go:", words.inner_text())


def use_player(view, is_solid):
    page = view.page
    check(0.03 < share_of_ink(view.picture()) < 0.97, view.file.name, "the picture is blank")
    check(view.seconds() == 0.0, "the player plays by itself")
    check(page.evaluate(NAMELESS) == [], "controls without a name:", page.evaluate(NAMELESS))

    frames = int(page.locator(".sfp-scrub").get_attribute("max"))
    interval = 0.004 if is_solid else INTERVAL
    page.locator(".sfp-scrub").fill(str(frames - 2))
    check(abs(view.seconds() - (frames - 2) * interval) < 1e-6, "scrubbing to frame", frames - 2, "shows", view.seconds(), "s")

    # Keys, on the picture.
    page.locator(".sfp canvas").focus()
    for key, expected in (("Home", 0), ("ArrowRight", 1), ("ArrowRight", 2), ("ArrowLeft", 1)):
        page.keyboard.press(key)
        check(abs(view.seconds() - expected * interval) < 1e-6, key, "shows", view.seconds(), "s")
    page.keyboard.press("Home")
    speed = control(page, "Speed").input_value()
    page.keyboard.press("-")
    check(control(page, "Speed").input_value() != speed, "the key - does not change the speed")
    page.keyboard.press("+")
    page.keyboard.press(" ")
    page.wait_for_function("() => document.querySelector('.sfp-scrub').value > 2", timeout=60_000)
    page.keyboard.press(" ")
    page.wait_for_timeout(300)
    stopped = view.seconds()
    page.wait_for_timeout(500)
    check(view.seconds() == stopped > 0, "the space key does not pause")

    # Clicks.
    page.keyboard.press("Home")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("() => document.querySelector('.sfp-scrub').value > 2", timeout=60_000)
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("button", name="One frame on").click()
    page.locator(".sfp canvas").focus()
    page.keyboard.press("End")
    page.wait_for_timeout(700)
    check("s" in page.locator(".sfp-live").inner_text(), "the state is not announced")

    point_at_a_grain(page)
    names = control(page, "Colour").locator("option").all_inner_texts()
    check({"species", "speed (m/s)", "age (s)", "coordination"} - set(names) <= ({"age (s)"} if is_solid else set()), names)
    current = control(page, "Colour").locator("option:checked").inner_text()
    other = next(name for name in ("coordination", "species") if name != current)
    view.changed("another colour", lambda: control(page, "Colour").select_option(label=other))
    check(other in page.locator(".sfp-legend").inner_text() or other == "species", "the legend does not name the colour")
    # The plane silo consists of wall grains, which are not hidden.
    check(control(page, "Walls").count() == int(is_solid), "a control for walls belongs to scenes with wall surfaces")
    if is_solid:
        view.changed("hiding the walls", lambda: control(page, "Walls").uncheck())
    view.changed("force chains", lambda: control(page, "Force chains").check())
    check("normal force" in page.locator(".sfp-legend").inner_text(), "the legend does not explain force chains")
    if is_solid:
        control(page, "Walls").check()
    view.changed("zoom", lambda: page.get_by_role("button", name="Zoom in").click())
    page.get_by_role("button", name="Show all").click()


def use_pictures(view):
    """The pictures of the lattice gas have the same controls for time."""
    page = view.page
    check(0.03 < share_of_ink(view.picture()), "the picture of the lattice gas is blank")
    image = page.locator(".sfp img")
    image.focus()
    view.changed("the key End", lambda: page.keyboard.press("End"))
    check(page.locator(".sfp-facts b").inner_text() == "step 1000", page.locator(".sfp-facts b").inner_text())
    page.keyboard.press("Home")
    page.get_by_role("button", name="Play").click()
    page.wait_for_function("() => document.querySelector('.sfp-scrub').value > 1", timeout=60_000)
    page.get_by_role("button", name="Pause").click()
    check(page.evaluate(NAMELESS) == [], "controls without a name:", page.evaluate(NAMELESS))


def turn_and_cut(view):
    page = view.page
    control(page, "Force chains").uncheck()
    canvas = page.locator(".sfp canvas")

    def drag():
        canvas.scroll_into_view_if_needed()
        box = canvas.bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 90, y - 30, steps=4)
        page.mouse.up()

    view.changed("a drag", drag)

    def key():
        canvas.focus()
        page.keyboard.press("Shift+ArrowLeft")

    view.changed("a key", key)
    view.changed("another view", lambda: control(page, "View").select_option("front"))
    control(page, "Walls").uncheck()
    whole = view.picture()
    control(page, "Cut").select_option("1")
    control(page, "Depth of the cut").fill("100")
    cut = view.picture()
    check(share_of_ink(cut) < 0.1 * share_of_ink(whole), "the whole scene is not cut away:", share_of_ink(cut), share_of_ink(whole))
    control(page, "Walls").check()
    control(page, "Depth of the cut").fill("50")
    control(page, "View").select_option("oblique")


def with_damage(browser, files, directory):
    """A report with damaged frames says so, and shows everything else."""
    text = files["plane"].read_text()
    data = re.search(r'(<script type="application/octet-stream"[^>]*>)([^<]*)(</script>)', text)
    first, second = data[2].split(" ")
    wrong = bytearray(base64.b64decode(second))
    wrong[len(wrong) // 2] ^= 255
    for number, damaged in enumerate((f"{first} {base64.b64encode(wrong).decode()}", first, "?", f"{first} {second[:4000]}")):
        file = directory / f"damaged{number}.html"
        file.write_text(text[: data.start(2)] + damaged + text[data.end(2) :])
        view = Page(browser, file, SIZES["wide"])
        view.page.wait_for_selector(".sfp-message:visible")
        check("cannot be shown" in view.page.locator(".sfp-message").inner_text(), "no message about damaged data")
        view.close()


def without_webgl(chromium, files):
    """The plane is drawn without WebGL as well, and solid space has a message."""
    browser = chromium.launch(executable_path=executable(), args=["--no-sandbox", "--disable-3d-apis"])
    view = Page(browser, files["plane"], SIZES["wide"])
    view.page.locator(".sfp canvas").focus()
    view.page.keyboard.press("End")
    check(share_of_ink(view.picture()) > 0.03, "the plane is blank without WebGL")
    view.changed("a colour without WebGL", lambda: control(view.page, "Colour").select_option(label="coordination"))
    view.close()
    view = Page(browser, files["solid"], SIZES["wide"])
    check("WebGL" in view.page.locator(".sfp-message").inner_text(), "no message about WebGL")
    view.close()
    browser.close()


def measure(browser, file):
    view = Page(browser, file, SIZES["wide"])
    view.page.evaluate(MEASURE)
    times = view.page.evaluate(MEASURE)
    view.close()
    middle = statistics.median(times)
    load = os.getloadavg()[0]
    print(f"{file.stem}: {GRAINS} grains, {middle:.1f} ms per frame (median of {len(times)}; slowest {max(times):.1f} ms; load {load:.1f})")
    return middle


def main(program, directory):
    directory.mkdir(parents=True, exist_ok=True)
    files = reports(program, directory)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable(), args=SOFTWARE)
        middles = {name: measure(browser, files[name]) for name in LARGE}
        for name in ("plane", "solid"):
            for size_name, size in SIZES.items():
                view = Page(browser, files[name], size, reduced_motion="reduce")
                use_player(view, name == "solid")
                if name == "solid":
                    turn_and_cut(view)
                width = view.page.evaluate("document.documentElement.scrollWidth")
                check(width <= size[0], name, size_name, "is wider than the window:", width)
                view.page.wait_for_timeout(700)
                view.page.screenshot(path=directory / f"{name}-{size_name}.png")
                view.close()
            view = Page(browser, files[name], SIZES["wide"], color_scheme="dark")
            image = view.picture()
            check(max(image.getpixel((1, 1))) < 80 and share_of_ink(image) > 0.01, name, "has no dark picture")
            view.page.screenshot(path=directory / f"{name}-dark.png")
            view.close()
        view = Page(browser, files["lattice"], SIZES["wide"])
        use_pictures(view)
        view.page.screenshot(path=directory / "lattice.png")
        view.close()
        with_damage(browser, files, directory)
        browser.close()
        without_webgl(playwright.chromium, files)
    for name, middle in middles.items():
        if middle > WANTED_MS:
            print(f"browser: {name}: a frame takes {middle:.1f} ms on this machine, more than {WANTED_MS:.0f} ms")
    print("browser: the players work")


if __name__ == "__main__":
    check(len(sys.argv) in (2, 3), "usage: browser.py SILOFLOW [DIRECTORY]")
    program_path = pathlib.Path(sys.argv[1]).resolve()
    if len(sys.argv) == 3:
        main(program_path, pathlib.Path(sys.argv[2]).resolve())
    else:
        with tempfile.TemporaryDirectory() as temporary:
            main(program_path, pathlib.Path(temporary))
