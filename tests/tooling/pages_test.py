#!/usr/bin/python3
"""Checks the pages: links and anchors lead somewhere, pages are short, their sentences too, named files exist, and the picture of the
rings is that of the includes."""

import pathlib
import re
import unittest

import rings

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Pages for readers, with the most bytes that each may have. The others are references and lab notes.
MOST_BYTES = {
    "README.md": 6000, "CONTRIBUTING.md": 9000, "CHANGELOG.md": 9000, "client/tutorial.md": 9000, "client/howto.md": 9000,
    "deploy/troubleshooting.md": 9000, "server/architecture.md": 9000, "server/glossary.md": 9000, "server/limits.md": 9000,
    "tests/bench/performance.md": 9000}
MOST_WORDS = 25  # of a sentence of these pages, tables left out
LEFT_OUT = {"build", "node_modules", "dist", ".git"}  # folders
FENCE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(([^()\s]+)\)")


def pages():
    return sorted(path for path in ROOT.rglob("*.md") if not LEFT_OUT & set(path.relative_to(ROOT).parts))


def prose(text):
    return FENCE.sub("", text)


def anchors(text):
    """Returns the anchors that GitHub gives to the headings of a page."""
    found = set()
    for heading in re.findall(r"^#+ +(.*?) *$", prose(text), re.MULTILINE):
        heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        number = 0
        while (slug if number == 0 else f"{slug}-{number}") in found:
            number += 1
        found.add(slug if number == 0 else f"{slug}-{number}")
    return found


def dead_links(page, text):
    """Returns the relative links of the page that lead to no file, or to no heading of one."""
    dead = []
    for link in LINK.findall(prose(text)):
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        if not target.exists() or (anchor and (target.suffix != ".md" or anchor not in anchors(target.read_text()))):
            dead.append(link)
    return dead


def sentences(text):
    """Returns the sentences of a page, without tables, headings and pictures."""
    found = []
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", prose(text))
    for paragraph in re.split(r"\n\s*\n|\n(?=\s*(?:- |\d+\. |\|))", text):
        if not paragraph.strip().startswith(("|", "#")):
            plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", " ".join(paragraph.split()))
            found += [sentence for sentence in re.split(r"(?<=[.:;?!])\**\s", plain) if sentence]
    return found


class Pages(unittest.TestCase):
    def test_links_lead_somewhere(self):
        self.assertEqual([f"{page.relative_to(ROOT)}: {link}" for page in pages() for link in dead_links(page, page.read_text())], [])

    def test_pages_are_short(self):
        for page, most in MOST_BYTES.items():
            with self.subTest(page):
                self.assertLessEqual((ROOT / page).stat().st_size, most)

    def test_sentences_are_short(self):
        found = [f"{page}: {len(sentence.split())} words: {sentence}" for page in MOST_BYTES
                 for sentence in sentences((ROOT / page).read_text()) if len(sentence.split()) > MOST_WORDS]
        self.assertEqual(found, [])

    def test_named_files_exist(self):
        """Of the server's pages paths may begin within server/."""
        found = []
        for page in MOST_BYTES:
            for path in re.findall(r"`((?:[\w.-]+/)+[\w.-]+\.(?:cc|h|md|py|ts|json|proto|svg|ply|obj))`", (ROOT / page).read_text()):
                if not path.startswith("build/") and not (ROOT / path).exists() and not (ROOT / "server" / path).exists():
                    found.append(f"{page}: {path}")
        self.assertEqual(found, [])

    def test_picture_of_the_rings_is_that_of_the_includes(self):
        self.assertEqual(rings.PICTURE.read_text(), rings.picture(), "run tests/tooling/rings.py")

    def test_dead_links_and_long_sentences_are_found(self):
        page = ROOT / "README.md"
        text = "# A `b` (c)\n\n# A `b` (c)\n\n[x](LICENSE) [y](gone.md) [z](#a-b-c) [w](#a-b-c-1) [v](#d) [u](https://example.org)\n"
        page_anchors = anchors(text)
        self.assertEqual(page_anchors, {"a-b-c", "a-b-c-1"})
        self.assertEqual(dead_links(page, text.replace("[z](#a-b-c) [w](#a-b-c-1)", "")), ["gone.md", "#d"])
        self.assertEqual(sentences("# Head\n\nOne two. Three:\nfour\n\n- five\n| six |\n\n```sh\nseven\n```\n"),
                         ["One two.", "Three:", "four", "- five"])


if __name__ == "__main__":
    unittest.main()
