#!/usr/bin/python3
"""Builds the site of the documentation and checks that it is whole: links and anchors lead somewhere, every call, message and public
name of Python is in it, and its pages need nothing that kerfd's Content-Security-Policy forbids."""

import argparse
import html.parser
import importlib
import pathlib
import re
import subprocess
import sys
import unittest
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
OPTIONS = None
# References of the elements that a browser loads or follows.
REFERENCES = {"a": "href", "link": "href", "img": "src", "script": "src", "form": "action", "source": "src", "iframe": "src"}


class Page(html.parser.HTMLParser):
    """Reads the anchors and the references of a page, and what its policy forbids."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.references, self.forbidden = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        there = dict(attributes)
        self.anchors.update(there[name] for name in ("id", "name") if there.get(name) and (name == "id" or tag == "a"))
        if REFERENCES.get(tag) in there:
            self.references.append((tag, there[REFERENCES[tag]]))
        if tag == "script" and "src" not in there:
            self.forbidden.append("a script within the page")
        self.forbidden += [name for name in there if name.startswith("on")]
        self.forbidden += [value for value in there.values() if (value or "").lower().startswith("javascript:")]


def read_site(site):
    return {path.relative_to(site).as_posix(): Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}


def dead_references(pages, files):
    """Returns the references of the pages that lead to no file of the site or to no anchor there, or that load from elsewhere."""
    dead = []
    for name, page in pages.items():
        for tag, reference in page.references:
            parts = urllib.parse.urlsplit(reference)
            if parts.scheme or parts.netloc:
                if tag != "a" and parts.scheme != "data":
                    dead.append(f"{name} loads {reference}")
                continue
            base = urllib.parse.urljoin(f"/{name}", urllib.parse.unquote(parts.path)).lstrip("/") if parts.path else name
            anchor = urllib.parse.unquote(parts.fragment)
            if parts.path.startswith("/") or base not in files or (anchor and base in pages and anchor not in pages[base].anchors):
                dead.append(f"{name}: {reference}")
    return dead


def messages_of(descriptor):
    yield descriptor
    for nested in descriptor.nested_types:
        if not nested.GetOptions().map_entry:
            yield from messages_of(nested)


class Docs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.built = subprocess.run([ROOT / "deploy/site/build.py", OPTIONS.work], capture_output=True, text=True)
        cls.site = pathlib.Path(OPTIONS.work, "site")
        if cls.built.returncode == 0:
            cls.files = {path.relative_to(cls.site).as_posix() for path in cls.site.rglob("*") if path.is_file()}
            cls.pages = read_site(cls.site)
            sys.path.insert(0, str(pathlib.Path(OPTIONS.work, "python")))

    def setUp(self):
        self.assertEqual(self.built.returncode, 0, self.built.stdout + self.built.stderr)

    def anchors(self, folder):
        return {anchor for name, page in self.pages.items() if name.startswith(folder) for anchor in page.anchors}

    def test_builds_without_a_warning(self):
        self.assertEqual(self.built.stdout + self.built.stderr, "")

    def test_has_every_page(self):
        for page in ROOT.rglob("*.md"):
            name = page.relative_to(ROOT)
            if not {"build", "node_modules", "dist", "data", ".git"} & set(name.parts):
                self.assertIn("index.html" if str(name) == "README.md" else name.with_suffix(".html").as_posix(), self.pages)

    def test_links_and_anchors_lead_somewhere(self):
        self.assertEqual(dead_references(self.pages, self.files), [])
        self.assertGreater(sum(len(page.references) for page in self.pages.values()), 5000)

    def test_dead_links_are_found(self):
        pages = {"a/b.html": Page('<a href="../c.html#there">'), "c.html": Page('<p id="there"><a href="a/b.html"><a href="#there">')}
        files = {"a/b.html", "c.html"}
        self.assertEqual(dead_references(pages, files), [])
        for bad in ("c.html", "../c.html#gone", "#gone", "/a/b.html", "../none.png"):
            pages["a/b.html"] = Page(f'<a href="{bad}">')
            self.assertEqual(dead_references(pages, files), [f"a/b.html: {bad}"])
        pages["a/b.html"] = Page('<a href="https://example.org"><img src="https://example.org/x.png"><script>1</script><p onclick="f()">')
        self.assertEqual(dead_references(pages, files), ["a/b.html loads https://example.org/x.png"])
        self.assertEqual(pages["a/b.html"].forbidden, ["a script within the page", "onclick"])

    def test_policy_of_kerfd_forbids_nothing(self):
        self.assertEqual({name: page.forbidden for name, page in self.pages.items() if page.forbidden}, {})
        for style in self.site.rglob("*.css"):
            for url in re.findall(r"(?:url\(|@import\s+)[\"']?([^\"')]+)", style.read_text(encoding="utf-8")):
                name = (style.parent / url).resolve()
                self.assertTrue(url.startswith("data:") or name.is_file(), f"{style}: {url}")
        for script in self.site.rglob("*.js"):
            self.assertNotRegex(script.read_text(encoding="utf-8"), r"(?m)^import ")

    def test_dark_colours_follow_the_browser(self):
        self.assertIn("prefers-color-scheme: dark", (self.site / "_static/styles/furo.css").read_text(encoding="utf-8"))

    def test_every_call_and_message_is_in_the_reference(self):
        anchors = self.anchors("reference/api/")
        modules = [importlib.import_module(f"kerf.v1.{path.stem}_pb2") for path in sorted((ROOT / "proto/kerf/v1").glob("*.proto"))]
        wanted, paths = set(), set()
        for file in (module.DESCRIPTOR for module in modules):
            enums = list(file.enum_types_by_name.values())
            for message in (found for top in file.message_types_by_name.values() for found in messages_of(top)):
                wanted |= {message.full_name, *(field.full_name for field in message.fields)}
                enums += message.enum_types
            for enum in enums:
                wanted |= {enum.full_name, *(f"{enum.full_name}.{value.name}" for value in enum.values)}
            for service in file.services_by_name.values():
                wanted |= {service.full_name, *(method.full_name for method in service.methods)}
                paths |= {f"/{service.full_name}/{method.name}" for method in service.methods}
        self.assertGreater(len(wanted), 800)
        self.assertEqual(sorted(name for name in wanted if f"kerf-{name}" not in anchors), [])
        index = re.sub(r"<[^>]*>", "", (self.site / "reference/api/index.html").read_text(encoding="utf-8"))
        streams = {path.rsplit("/", 1)[1] for path in paths if path not in index}
        self.assertEqual(streams, {"Watch", "Subscribe", "WatchImages", "UploadSheet", "ReplayRecording", "GetSheetRecording"})

    def test_every_public_name_of_python_is_in_the_reference(self):
        anchors = self.anchors("reference/python/")
        for package in (importlib.import_module("kerf"), importlib.import_module("kerf.aio")):
            for name in package.__all__:
                full = f"{package.__name__}.{name}"
                if name == "__version__":
                    continue
                self.assertIn(full, anchors)
                thing = getattr(package, name)
                if isinstance(thing, type) and thing.__module__.startswith(("kerf.blocking", "kerf.aio")):
                    methods = [method for method in dir(thing) if not method.startswith("_") and callable(getattr(thing, method))]
                    self.assertEqual([method for method in methods if f"{full}.{method}" not in anchors], [])

    def test_options_and_attributes_are_in_the_reference(self):
        anchors = self.anchors("reference/python/")
        kerf = importlib.import_module("kerf")
        for name in ("CutOptions", "SheetOptions", "Frame", "Image", "State", "Table", "Analysis"):
            attributes = getattr(kerf, name).__annotations__
            self.assertGreater(len(attributes), 2, name)
            self.assertEqual([each for each in attributes if f"kerf.{name}.{each}" not in anchors], [])
        text = re.sub(r"<[^>]*>", "", (self.site / "reference/python/cuts.html").read_text(encoding="utf-8"))
        self.assertIn("largest distance of the curve to the lips", text)
        self.assertNotIn("Convert a number or string to an integer", text)

    def test_every_installed_header_of_cpp_is_in_the_reference(self):
        """Compares with what the front doors include, which need all that is installed."""
        for part, door in (("core", "server/core/kerf/kerf.h"), ("client", "client/cpp/kerf/client.h")):
            text = re.sub(r"<[^>]*>", "", (self.site / f"reference/cpp/{part}.html").read_text(encoding="utf-8"))
            included = re.findall(r'#include "([^"]*)"', (ROOT / door).read_text(encoding="utf-8"))
            self.assertGreater(len(included), 4)
            for header in (f"kerf/{pathlib.Path(door).name}", *(path for path in included if not path.endswith(".pb.h"))):
                self.assertIn(f"{header}#", text)  # a heading, with its link

    def test_search_knows_pages_and_names(self):
        index = (self.site / "searchindex.js").read_text(encoding="utf-8")
        for name in ("client/tutorial", "reference/api/cuts", "CreateCutRequest", "temporary_sheet"):
            self.assertIn(name, index)

    def test_kerfd_takes_the_site(self):
        """kerfd reads at most 4096 files, and sends an encoding only if it is no older than its file."""
        self.assertLess(len(self.files), 1000)
        for name in self.files:
            if name.endswith(".gz"):
                encoded, original = (self.site / name).stat(), (self.site / name.removesuffix(".gz")).stat()
                self.assertGreaterEqual(encoded.st_mtime_ns, original.st_mtime_ns, name)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--work", required=True, help="folder for what is built; a later run takes it up")
    OPTIONS, rest = parser.parse_known_args()
    unittest.main(argv=[sys.argv[0]] + rest)
