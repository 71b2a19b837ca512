#!/usr/bin/python3
"""Builds the site of the documentation.

  deploy/site/build.py FOLDER      FOLDER/site; beside it what a later build of the same folder takes up
"""

import gzip
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import api_pages
import cpp_pages
import openapi
import pages
import python_pages

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
# The theme's only script within a page, which kerfd's Content-Security-Policy forbids: static/theme.js is in its place.
INLINE = re.compile(r"<script>\s*document\.body\.dataset\.theme = localStorage\.getItem\(\"theme\"\) \|\| \"auto\";\s*</script>")
SCRIPT = re.compile(r"<script(?![^>]* src=)[^>]*>")
# Debian's theme takes a style from a path of Debian's web servers; its script, which is loaded as a plain one, imports another; and its
# dark colours have lost the rule for who has chosen dark for all pages.
NORMALIZE = b"@import url(/javascript/normalize.css/normalize.css);"
NORMALIZE_FILE = pathlib.Path("/usr/share/javascript/normalize.css/normalize.css")
IMPORT = b'import Gumshoe from "./gumshoe-patched.js";'
DARK = re.compile(rb'@media not print \{\n(  body\[data-theme="dark"\] \{\n.*?\})', re.DOTALL)
COMPRESSED = {".html", ".js", ".css", ".svg", ".json"}


def finished_page(path, text):
    """Returns a page that works under kerfd's policy; SystemExit if it has a script that this does not know."""
    up = "../" * (len(path.parts) - 1)
    text = INLINE.sub(f'<script src="{up}_static/theme.js"></script>', text)
    if SCRIPT.search(text):
        raise SystemExit(f"{path} has a script within it, which kerfd's Content-Security-Policy forbids")
    return text


def finished_style(style):
    dark = DARK.search(style)
    if b"prefers-color-scheme" in style or not dark:
        return style
    return style + b"@media screen and (prefers-color-scheme: dark) {\n" + dark[1].replace(b'"dark"', b'"auto"') + b"\n}\n"


def finished(path, file):
    """Returns the bytes of a file of the site. `path`: within it; `file`: as Sphinx made it."""
    content = file.read_bytes()
    if path.suffix == ".html":
        return finished_page(path, content.decode()).encode()
    if path.name == "furo.css":
        return finished_style(content.replace(NORMALIZE, NORMALIZE_FILE.read_bytes()))
    if path.name == "furo.js":
        return content.replace(IMPORT, file.with_name("gumshoe-patched.js").read_bytes())
    return content


def publish(made, site):
    """Fills the folder `site` with what Sphinx made, and with compressed copies for kerfd to send."""
    files = {}
    for path in made.rglob("*"):
        name = path.relative_to(made)
        if path.is_file() and not name.name.startswith(".") and name.name != "objects.inv" and name.suffix not in (".map", ".txt"):
            files[name] = finished(name, path)
    files[pathlib.Path("openapi.json")] = (json.dumps(openapi.document(), indent=1) + "\n").encode()
    for name in [name for name in files if name.suffix in COMPRESSED]:
        files[name.with_name(name.name + ".gz")] = gzip.compress(files[name], mtime=0)
    pages.fill(site, files)


def main():
    folder = pathlib.Path(sys.argv[1]).resolve()
    package = folder / "python"
    with tempfile.TemporaryDirectory() as made:
        subprocess.run([ROOT / "client/python/generate", made], check=True)
        pages.fill(package, {path.relative_to(made): path.read_bytes() for path in pathlib.Path(made).rglob("*") if path.is_file()})
    sys.path.insert(0, str(package))
    pages.lay_out(folder / "source", {**api_pages.references(), **python_pages.references(), **cpp_pages.references()})
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", "-b", "html", "-q", "-W", "--keep-going", "-c", HERE, "-d", folder / "doctrees",
         folder / "source", folder / "html"], env={**os.environ, "PYTHONPATH": str(package)})
    if done.returncode:
        shutil.rmtree(folder / "doctrees")  # so that a page with a warning is read again
        raise SystemExit("deploy/docs: a warning above is an error; the site was not built")
    publish(folder / "html", folder / "site")


if __name__ == "__main__":
    main()
