"""A page in headless Chromium without a network, whose errors, dialogs and requests are kept, for the tests of reports, of the web page and of the site."""

import os
import pathlib
import shutil

ROOT = pathlib.Path(__file__).resolve().parents[2]


def check(condition, *words):
    if not condition:
        raise SystemExit(" ".join(str(word) for word in ("browser:", *words)))


def executable():
    found = os.environ.get("CHROMIUM") or shutil.which("chromium")
    check(found, "there is no chromium")
    return found


class Window:
    """A page in a window. Errors name it by `name`."""

    def __init__(self, browser, name, address, size, **settings):
        self.context = browser.new_context(viewport={"width": size[0], "height": size[1]}, **settings)
        self.context.set_offline(True)
        self.page = self.context.new_page()
        self.name, self.problems, self.requests = name, [], []
        self.page.on("console", lambda message: message.type == "error" and self.problems.append(message.text))
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("dialog", lambda dialog: self.problems.append(f"dialog {dialog.message}"))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(address)

    def close(self):
        check(not self.problems, self.name, *self.problems)
        other = [url for url in self.requests if not url.startswith(("file:", "data:", "blob:"))]
        check(not other, self.name, "asks for", *other)
        self.context.close()
