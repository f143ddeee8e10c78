"""Opens the site of the documentation in headless Chromium from its files, searches it, and looks at it in several windows.

    python docs/site/build.py
    pip install -r tests/browser/requirements.txt
    python tests/browser/site.py [DIRECTORY]

Screenshots are kept in DIRECTORY. The site needs no network: every request is for a file.
"""

import pathlib
import sys
import tempfile

from playwright.sync_api import sync_playwright
from window import ROOT, Window, check, executable

SITE = ROOT / "target" / "site"
SIZES = {"wide": (1280, 900), "narrow": (390, 844)}
PAGES = {
    "start": "index.html",
    "gallery": "docs/gallery.html",
    "scene-file": "docs/reference/scene-file.html",
    "spawner": "docs/reference/scene-file.html#spawner",
    "janssen": "docs/validation/janssen.html",
    "tutorial": "docs/tutorial.html",
}
# A word, and a page that a search for it must find; the first is in the titles and in the texts of few pages, the second is a key of a scene.
SEARCHES = {"Janssen": "docs/validation/janssen.html", "release_timeout": "docs/reference/scene-file.html"}


def opened(browser, page, size, scheme="light"):
    """A page of the site in a window."""
    return Window(browser, page, f"{SITE.as_uri()}/{page}", size, color_scheme=scheme)


def search(browser, word, wanted, picture):
    """A search from the first page finds a page, and its link opens it."""
    window = opened(browser, "index.html", SIZES["wide"])
    page = window.page
    page.keyboard.press("s")
    page.locator("#mdbook-searchbar").press_sequentially(word)
    result = page.locator(f"#mdbook-searchresults a[href*='{wanted}']").first
    result.wait_for(timeout=30_000)
    page.screenshot(path=picture)
    result.click()
    page.wait_for_url(f"**/{wanted}*")
    check(word in page.locator("main").inner_text(), wanted, "does not have", word)
    window.close()


def main(directory):
    directory.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=executable(), args=["--no-sandbox"])
        for word, wanted in SEARCHES.items():
            search(browser, word, wanted, directory / f"search-{word}.png")
        for name, page in PAGES.items():
            for size_name, size in SIZES.items():
                for scheme in ("light", "dark"):
                    window = opened(browser, page, size, scheme)
                    width = window.page.evaluate("document.documentElement.scrollWidth")
                    check(width <= size[0], page, size_name, "is wider than the window:", width)
                    check(window.page.evaluate("[...document.images].every((image) => image.naturalWidth > 0)"), page, "misses a picture")
                    window.page.screenshot(path=directory / f"{name}-{size_name}-{scheme}.png")
                    window.close()
        browser.close()
    print("site: a search finds its pages, and nothing is asked of a network")


if __name__ == "__main__":
    if len(sys.argv) == 2:
        main(pathlib.Path(sys.argv[1]).resolve())
    else:
        with tempfile.TemporaryDirectory() as temporary:
            main(pathlib.Path(temporary))
