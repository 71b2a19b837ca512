#!/usr/bin/env python3
"""Copies source files with the faults of faults.toml built in, each behind kerf::faults::active(number).

    faulty_copy.py ROOT FAULTS OUTPUT SOURCE...     SOURCE relative to ROOT; copies land in OUTPUT/SOURCE

A fault is one or more edits. Each names a file and a text that must occur in it exactly once: a `statement` (one or more
whole statements without declarations) or an `expression`, and what it `becomes`. Two faults may edit the same text.
"""
import pathlib
import sys
import tomllib


def fail(message):
    sys.exit(f"faulty_copy.py: {message}; bring tests/faults/faults.toml up to date with the source")


def span_of(edit, number, text):
    kind = "statement" if "statement" in edit else "expression"
    wanted = edit[kind]
    if text.count(wanted) != 1:
        fail(f"fault {number}: {edit['file']} holds {text.count(wanted)} times, not once: {wanted}")
    start = text.index(wanted)
    return (start, start + len(wanted), kind)


def replacement(kind, original, variants):
    """variants: [(number, becomes)], the first that is active wins."""
    if kind == "expression":
        result = f"({original})"
        for number, becomes in reversed(variants):
            result = f"(::kerf::faults::active({number}) ? ({becomes}) : {result})"
        return result
    result = "{ " + original + " }"
    for number, becomes in reversed(variants):
        result = f"if (::kerf::faults::active({number})) {{ {becomes} }} else {result}"
    return result


def main():
    root, faults_file, output, *sources = sys.argv[1:]
    faults = tomllib.loads(pathlib.Path(faults_file).read_text())["fault"]
    texts = {source: (pathlib.Path(root) / source).read_text() for source in sources}
    edits = {}  # file -> {span: [(number, becomes)]}
    for number, fault in enumerate(faults, start=1):
        for edit in fault["edit"]:
            if edit["file"] not in texts:
                fail(f"fault {number}: no such source {edit['file']}")
            span = span_of(edit, number, texts[edit["file"]])
            edits.setdefault(edit["file"], {}).setdefault(span, []).append((number, edit["becomes"]))
    for source, text in texts.items():
        last = len(text)
        for (start, end, kind), variants in sorted(edits.get(source, {}).items(), reverse=True):
            if end > last:
                fail(f"faults overlap in {source}: {variants}")
            text = text[:start] + replacement(kind, text[start:end], variants) + text[end:]
            last = start
        target = pathlib.Path(output) / source
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text('#include "tests/faults/fault_switch.h"\n' + text)
    names = ",\n".join("  " + '"' + fault["what"].replace('"', '\\"') + '"' for fault in faults)
    (pathlib.Path(output) / "fault_names.h").write_text(
        "#pragma once\n\n#include <array>\n\n// Of fault 1, 2, ...\n"
        f"inline constexpr std::array<const char*, {len(faults)}> kFaultNames{{\n{names}}};\n")


main()
