"""Builds the site of the documentation from the pages of the repository, with mdBook.

    python3 docs/site/build.py          # target/site/index.html opens in a browser, without a server or a network

The pages are those that SUMMARY.md lists. A page keeps its place in the repository, so links between pages hold. A file to which a page links is copied;
a text file gets the ending .txt, which every browser shows. mdBook is taken from the path, or else installed into target/site-tools; --install does that alone.
"""

import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
TOOLS = ROOT / "target" / "site-tools"
PAGES = ROOT / "target" / "site-pages"
SITE = ROOT / "target" / "site"
MDBOOK = "0.5.4"

FENCE = re.compile(r"^ *```.*?^ *```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r'(\]\(|<img src=")(?!https?:|#)([^)\s"#]+)')
PICTURES = {".png", ".svg"}


def mdbook():
    """The program mdBook."""
    found = shutil.which("mdbook") or shutil.which("mdbook", path=str(TOOLS / "bin"))
    if found is None:
        install = ["cargo", "install", "--locked", "--quiet", f"mdbook@{MDBOOK}", "--no-default-features", "--features", "search"]
        subprocess.run([*install, "--root", TOOLS], check=True, cwd=ROOT)
        found = str(TOOLS / "bin" / "mdbook")
    return found


def anchor(heading):
    """The name of a heading in links."""
    return re.sub(r"[^\w-]", "", heading.strip().lower().replace(" ", "-"))


def thumbnails(text):
    """The first picture of each section of the gallery, as a link to the section."""
    sections = re.findall(r'^## (.+?)$(?:(?!^## ).)*?<img src="([^"]+)"', text, re.MULTILINE | re.DOTALL)
    links = [f'<a href="#{anchor(heading)}"><img src="{picture}" alt="">{heading}</a>' for heading, picture in sections]
    return '<div class="thumbnails">\n' + "\n".join(links) + "\n</div>\n"


def copied(page, pages):
    """The text of a page whose links lead to pages and copies of files."""

    def link(match):
        file = (page.parent / match[2]).resolve()
        name = file.relative_to(ROOT)
        if file in pages:
            return match[0]
        ending = "" if file.suffix in PICTURES else ".txt"
        copy = PAGES / f"{name}{ending}"
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, copy)
        return match[0] + ending

    # Code has brackets of its own.
    text = page.read_text(encoding="utf-8")
    prose, fences = FENCE.split(text), [*FENCE.findall(text), ""]
    text = "".join(LINK.sub(link, words) + fence for words, fence in zip(prose, fences, strict=True))
    if page.name == "gallery.md":
        first = text.index("\n## ")
        text = f"{text[:first]}\n{thumbnails(text)}{text[first:]}"
    return text


def main():
    if sys.argv[1:] == ["--install"]:
        mdbook()
        return
    shutil.rmtree(PAGES, ignore_errors=True)
    summary = (HERE / "SUMMARY.md").read_text(encoding="utf-8")
    pages = [(HERE / name).resolve() for name in re.findall(r"\]\((.+?)\)", summary)]
    missing = {page for page in (ROOT / "docs").rglob("*.md") if page.parent != HERE} - set(pages)
    if missing:
        sys.exit(f"docs/site/SUMMARY.md has no line for {', '.join(str(page.relative_to(ROOT)) for page in sorted(missing))}")
    for page in pages:
        target = PAGES / page.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(copied(page, set(pages)), encoding="utf-8")
    at_root = re.sub(r"\]\((.+?)\)", lambda link: f"]({(HERE / link[1]).resolve().relative_to(ROOT)})", summary)
    (PAGES / "SUMMARY.md").write_text(at_root, encoding="utf-8")
    for name in ("book.toml", "site.css"):
        shutil.copyfile(HERE / name, PAGES / name)
    shutil.rmtree(SITE, ignore_errors=True)
    subprocess.run([mdbook(), "build", "--dest-dir", SITE, PAGES], check=True)
    # Neither is a part of the site.
    for name in ("book.toml", "404.html"):
        (SITE / name).unlink(missing_ok=True)
    print(f"site: {SITE / 'index.html'}")


if __name__ == "__main__":
    sys.exit(main())
