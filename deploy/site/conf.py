"""Sphinx's configuration: Markdown and reStructuredText, the theme Furo, names of kerf.v1, and links from types in Python to them."""

import gc
import inspect
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import docutils.nodes as nodes
from sphinx import addnodes
from sphinx.util.docutils import SphinxDirective
from sphinx.util.nodes import make_id, make_refnode

import kerf
import kerf.aio

gc.disable()  # Sphinx keeps nearly all that it makes: looking for garbage takes two fifths of its time, and finds little

project = "Kerf"
author = "Kerf"
version = release = kerf.__version__
root_doc = "index"
extensions = ["myst_parser", "sphinx.ext.autodoc"]
nitpicky = True
smartquotes = False
default_role = "literal"
html_theme = "furo"
html_title = f"Kerf {version}"
html_static_path = [str(pathlib.Path(__file__).resolve().parent / "static")]
html_css_files = ["kerf.css"]
html_favicon = "static/kerf.svg"
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_permalinks_icon = "#"
html_domain_indices = False
html_use_index = False
pygments_style = "friendly"
pygments_dark_style = "monokai"
myst_heading_anchors = 4  # as GitHub makes them, so that links hold in both places
myst_enable_extensions = []
suppress_warnings = ["myst.header"]  # a page may begin its sections at a deeper heading
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
add_module_names = False
# Types of other packages, and names of the annotations for arrays: reference/python/index says what they are.
nitpick_ignore_regex = [("py:.*", r"(typing|collections|numpy|os|pathlib|grpc|abc)\..*"),
                        ("py:.*", r"(Any|Optional|None|Sequence|Mapping|Literal|PathLike|NDArray|AnyScene|AnyMaterial|Part|Fit|Floats|Float32s|Ints|Bytes)")]


def parse_member(env, signature, node):
    """Shows a field or a value of an enum. `signature`: name|before the type|type|after it|what the type is|number|oneof."""
    name, before, label, after, target, number, oneof = signature.split("|")
    node += addnodes.desc_name(name, name.rsplit(".", 1)[1])
    if label:
        text = nodes.inline("", label)
        reference = addnodes.pending_xref("", text, refdomain="std", reftype="kerf", reftarget=target, refexplicit=True, refwarn=True)
        node += [addnodes.desc_sig_space(), nodes.inline("", before), reference if target else text, nodes.inline("", after)]
    node += nodes.inline("", f" = {number}", classes=["kerf-number"])
    if oneof:
        node += nodes.inline("", f"one of {oneof}", classes=["kerf-oneof"])
    return name


class Target(SphinxDirective):
    """Makes the next heading the place of a service, method, message or enum."""
    required_arguments = 1

    def run(self):
        name = self.arguments[0]
        node = nodes.target("", "", ids=[make_id(self.env, self.state.document, "kerf", name)])
        self.state.document.note_explicit_target(node)
        self.env.get_domain("std").note_object("kerf", name, node["ids"][0], location=node)
        return [node]


def public_names():
    """Returns the name under which each class of Python is described, by that of its definition."""
    found = {}
    for package in (kerf.aio, kerf):
        for name in package.__all__:
            thing = getattr(package, name)
            if inspect.isclass(thing):
                found[f"{thing.__module__}.{thing.__qualname__}"] = f"{package.__name__}.{name}"
    return found


PUBLIC_NAMES = public_names()


def resolve(app, env, node, content):
    """Leads types in Python to where they are described: messages to the pages of kerf.v1, classes to their public names."""
    if node.get("refdomain") != "py":
        return None
    target = node["reftarget"]
    message = re.fullmatch(r"(?:kerf\.v1\.)?\w+_pb2\.([\w.]+)", target)
    if message:
        objects = env.get_domain("std").objects
        names = [name for kind, name in objects if kind == "kerf" and (name == f"kerf.v1.{message[1]}" or name.endswith(f".{message[1]}"))]
        name = min(names, key=len, default="")  # Python does not say which message a nested one is in
        return make_refnode(app.builder, node["refdoc"], *objects["kerf", name], content, name) if name else None
    objects = env.get_domain("py").objects
    found = objects.get(PUBLIC_NAMES.get(target, target)) or objects.get(f"kerf.{target}")
    return make_refnode(app.builder, node["refdoc"], found.docname, found.node_id, content, target) if found else None


def is_made_by_server(cls):
    return cls.__module__.startswith(("kerf.blocking", "kerf.aio"))


def attributes(cls):
    """Returns name, type and comment of each attribute that a class declares: those of options, frames and states."""
    found, comment = [], []
    for line in inspect.getsource(cls).split("\n")[1:]:
        alone = re.fullmatch(r"    # (.*)", line)
        declared = re.fullmatch(r"    ([a-z]\w*): (.*?)(?: = [^#]*?)?(?:  # (.*))?", line)
        if alone:
            comment.append(alone[1])
            continue
        if declared and declared[1] in vars(cls).get("__annotations__", {}) and not line.rstrip().endswith(("(", "[")):
            found.append((declared[1], declared[2].strip("\"'"), " ".join((*comment, declared[3] or "")).strip()))
        comment = []
        if line.startswith(("    def ", "    @")):
            break
    return found


def as_prose(line):
    """Takes no stars and bars outside of code for marks."""
    return "`".join(re.sub(r"([*|])", r"\\\1", part) if k % 2 == 0 else part for k, part in enumerate(line.split("`")))


def mark_examples(app, what, name, thing, options, lines):
    """Marks what is set in within a docstring as Python, and lists the attributes of a class below it."""
    marked, in_doctest = [], False
    for i, line in enumerate(lines):
        in_doctest = bool(line.strip()) and (in_doctest or line.lstrip().startswith(">>>"))
        is_set_in = line.startswith("    ")
        if is_set_in and (i == 0 or not lines[i - 1].strip()) and not any(before.startswith("    ") for before in lines[max(0, i - 2):i]):
            marked += [".. code-block:: python", ""]
        if not in_doctest and not is_set_in:
            line = as_prose(line)
        marked.append(line)
    if what == "class" and not is_made_by_server(thing):
        for attribute, kind, comment in attributes(thing):
            marked += ["", f".. attribute:: {attribute}", f"   :type: {kind}", "", f"   {as_prose(comment)}"]
        marked.append("")
    lines[:] = marked


def hide_constructors(app, what, name, thing, options, signature, returns):
    """Hides how Sheet and others are made, which only a server makes."""
    return ("", None) if what == "class" and is_made_by_server(thing) else None


def setup(app):
    app.add_object_type("kerf", "kerf", objname="kerf.v1", parse_node=parse_member)
    app.add_directive("kerf-target", Target)
    app.connect("missing-reference", resolve)
    app.connect("autodoc-process-docstring", mark_examples)
    app.connect("autodoc-process-signature", hide_constructors)
