#!/usr/bin/python3
"""Checks all pages: links and anchors lead somewhere, and named files exist. Pages and their sentences are short, and their words
plain. The picture of the rings is that of the includes."""

import dataclasses
import pathlib
import re
import unittest

import comments_test
import rings

ROOT = pathlib.Path(__file__).resolve().parents[2]


@dataclasses.dataclass(frozen=True)
class Kind:
    """Pages of one purpose: the first that matches a path is the page's kind."""
    paths: tuple  # of pathlib.PurePath.match
    most_bytes: int
    most_words: int  # of a sentence, tables left out
    most_words_of_nine_in_ten: int


KINDS = (
    Kind(("/README.md",), 6000, 25, 25),  # the front page
    Kind(("/CONTRIBUTING.md", "/CHANGELOG.md", "client/tutorial.md", "client/howto.md", "deploy/*.md", "server/*.md",
          "tests/bench/performance.md"), 9500, 25, 25),  # pages for readers
    Kind(("tests/accuracy/PLOTS.md",), 36000, 45, 30),  # pictures and their tables, generated
    Kind(("tests/long/*.md",), 4000, 45, 30),  # the last results of the long proofs
    Kind(("tests/bench/notes/*.md",), 12288, 45, 30),  # what was tried
    Kind(("*.md",), 12288, 45, 30))  # beside the code: at most three screens
# A long page beside the code is split: the code of one room has one page, a second topic a second page.
LEFT_OUT = {"build", "node_modules", "dist", ".git"}  # folders
FENCE = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(([^()\s]+)\)")


def pages():
    return sorted(path for path in ROOT.rglob("*.md") if not LEFT_OUT & set(path.relative_to(ROOT).parts))


def kind_of(page):
    return next(kind for kind in KINDS if any(("/" / page.relative_to(ROOT)).match(path) for path in kind.paths))


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


def num_words(sentence):
    return len(sentence.split())


class Pages(unittest.TestCase):
    def test_links_lead_somewhere(self):
        self.assertEqual([f"{page.relative_to(ROOT)}: {link}" for page in pages() for link in dead_links(page, page.read_text())], [])

    def test_pages_are_short(self):
        for page in pages():
            with self.subTest(page.relative_to(ROOT)):
                self.assertLessEqual(page.stat().st_size, kind_of(page).most_bytes)

    def test_sentences_are_short(self):
        for page in pages():
            found = sorted(sentences(page.read_text()), key=num_words)
            with self.subTest(page.relative_to(ROOT)):
                if found:
                    self.assertLessEqual(num_words(found[-1]), kind_of(page).most_words, found[-1])
                    nearly_all = found[int(0.9 * (len(found) - 1))]
                    self.assertLessEqual(num_words(nearly_all), kind_of(page).most_words_of_nine_in_ten, nearly_all)

    def test_words_are_plain(self):
        found = [f"{page.relative_to(ROOT)}: {match}" for page in pages()
                 for match in comments_test.WORDS.findall(re.sub(r"`[^`]*`", "", prose(page.read_text())))]
        self.assertEqual(found, [])

    def test_named_files_exist(self):
        """Paths begin at the top, in server/, beside the page, or in src/ beside it."""
        found = []
        for page in pages():
            for path in re.findall(r"`((?:[\w.-]+/)+[\w.-]+\.(?:cc|h|md|py|ts|mjs|json|proto|svg|ply|obj))`", page.read_text()):
                bases = (ROOT, ROOT / "server", page.parent, page.parent / "src")
                if not path.startswith("build/") and not any((base / path).exists() for base in bases):
                    found.append(f"{page.relative_to(ROOT)}: {path}")
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
