"""Checks that every link, picture and script of the built site leads to a file of the site, and to an anchor that is there.

    python3 docs/site/check.py
"""

import html.parser
import pathlib
import sys
import urllib.parse

SITE = pathlib.Path(__file__).resolve().parents[2] / "target" / "site"


class Page(html.parser.HTMLParser):
    """The anchors of a page, its links, and what it loads."""

    def __init__(self, path):
        super().__init__()
        self.anchors, self.links, self.loaded = set(), [], []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.anchors.add(attributes.get("id"))
        if tag == "a" and "href" in attributes:
            self.links.append(attributes["href"])
        else:
            self.loaded += [attributes[name] for name in ("src", "href") if attributes.get(name)]


def main():
    pages = {path: Page(path) for path in sorted(SITE.rglob("*.html"))}
    wrong = [] if pages else ["there is no site: python3 docs/site/build.py"]
    count = 0
    for path, page in pages.items():
        for link in page.links + page.loaded:
            address = urllib.parse.urlsplit(link)
            if address.scheme or address.netloc:
                if link in page.loaded and address.scheme != "data":
                    wrong.append(f"{path}: loads {link}")
                continue
            count += 1
            target = (path.parent / urllib.parse.unquote(address.path)).resolve() if address.path else path
            if not target.is_file() or SITE not in target.parents:
                wrong.append(f"{path}: {link}")
            elif address.fragment and target in pages and urllib.parse.unquote(address.fragment) not in pages[target].anchors:
                wrong.append(f"{path}: {link} has no such anchor")
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"site: {count} links of {len(pages)} pages lead somewhere")


if __name__ == "__main__":
    main()
