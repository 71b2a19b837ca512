"""Lays out the sources of the site: copies of the pages with links that hold there, and a table of contents."""

import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
LEFT_OUT = {"build", "node_modules", "dist", ".git", "data"}  # folders
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")
FENCE = re.compile(r"(^```.*?^```)", re.DOTALL | re.MULTILINE)
INDEX = pathlib.PurePosixPath("README.md")  # which is index.md of the site

# Pages by heading, in the order of reading; a page that is not listed stands under the last heading.
CONTENTS = {
    "Start": ["client/tutorial", "client/howto", "client/files", "deploy/troubleshooting", "server/limits", "client/compared", "server/glossary"],
    "Clients": ["client/cli/README", "client/python/README", "client/cpp/README", "web/README", "client/load/README", "client/load/thresholds"],
    "Operation": ["deploy/install", "server/configuration", "server/access", "deploy/proxy"],
    "Reference": ["reference/api/index", "reference/python/index", "reference/cpp/index", "proto/README"],
    "Quality": ["tests/evaluation/tradeoff", "tests/bench/performance", "tests/accuracy/README", "tests/accuracy/PLOTS", "tests/stability/README",
                "tests/evaluation/README", "tests/evaluation/quality", "tests/evaluation/speed", "tests/evaluation/solvers"],
    "Development": ["CONTRIBUTING", "server/architecture", "server/README", "tests/README", "tests/bench/README", "CHANGELOG"],
    "More": [],
}
# Names of pages in the table of contents, where they differ from the heading.
TITLES = {
    "proto/README": "The live stream", "reference/api/index": "Calls and messages", "reference/python/index": "Python package", "reference/cpp/index": "C++ headers",
    "server/README": "Architecture in detail", "client/cli/README": "Command line", "web/README": "Viewer",
    "client/load/README": "Load tester", "client/python/README": "Python", "client/cpp/README": "C++"}


def pages():
    """Returns the pages, relative to the root of the repository."""
    found = (path.relative_to(ROOT) for path in ROOT.rglob("*.md"))
    return sorted(pathlib.PurePosixPath(path) for path in found if not LEFT_OUT & set(path.parts))


def fill(folder, files):
    """Makes `folder` hold these files, bytes by path, and no others. A file with its bytes stays: Sphinx reads only what is newer."""
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_bytes() != content:
            path.write_bytes(content)
    wanted = {folder / name for name in files}
    for path in sorted(folder.rglob("*"), reverse=True):  # a folder after what it holds
        if path.is_file() and path not in wanted:
            path.unlink()
        elif path.is_dir() and not any(path.iterdir()):
            path.rmdir()


def linked(link, page):
    """Returns the path that a link of a page leads to, relative to the root, and its anchor; no path for one that leads elsewhere."""
    path, _, anchor = link.partition("#")
    if re.match(r"[a-z]+:", link) or not path:
        return None, anchor
    return (ROOT / page.parent / path).resolve().relative_to(ROOT), anchor


def with_links_of_the_site(text, page):
    """Links to the first page lead to the index; those to folders, which a site does not show, are plain text."""

    def replaced(match):
        path, anchor = linked(match[3], page)
        if path is not None and (ROOT / path).is_dir():
            return match[2]
        if path == pathlib.Path(INDEX):
            up = "../" * len(page.parent.parts)
            return f"{match[1]}[{match[2]}]({up}index.md{'#' + anchor if anchor else ''})"
        return match[0]

    parts = FENCE.split(text)
    return "".join(part if part.startswith("```") else LINK.sub(replaced, part) for part in parts)


def linked_files(text, page):
    """Returns the pictures and other files that a page links to."""
    found = (linked(match[3], page)[0] for match in LINK.finditer(FENCE.sub("", text)))
    return {path for path in found if path is not None and path.suffix != ".md" and (ROOT / path).is_file()}


def table_of_contents(names):
    """Returns the hidden table of contents that makes the menu. `names`: every page, without its ending."""
    listed = {name for group in CONTENTS.values() for name in group}
    text = ""
    for heading, group in CONTENTS.items():
        there = [name for name in group if name in names]
        if heading == "More":
            there += sorted(names - listed)
        entries = "".join(f"{TITLES[name]} <{name}>\n" if name in TITLES else f"{name}\n" for name in there)
        text += f"\n```{{toctree}}\n:hidden:\n:caption: {heading}\n\n{entries}```\n"
    return text


def lay_out(source, references):
    """Fills the folder `source`. `references`: text by path of the pages that are made, such as reference/api/index.rst."""
    files = {path: text.encode() for path, text in references.items()}
    names = {path.removesuffix(".rst") for path in references if path.endswith("/index.rst")}  # which list the others
    for page in pages():
        text = (ROOT / page).read_text(encoding="utf-8")
        files.update({str(path): (ROOT / path).read_bytes() for path in linked_files(text, page)})
        text = with_links_of_the_site(text, page)
        if page != INDEX:
            names.add(str(page.with_suffix("")))
            files[str(page)] = text.encode()
        else:
            index = text
    files["index.md"] = (index + table_of_contents(names)).encode()
    fill(source, files)
