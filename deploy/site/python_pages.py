"""Writes the pages of the Python package for Sphinx's autodoc: every public name of kerf and kerf.aio, by the module that has it."""

import importlib
import inspect

# Modules whose public names share a page, by the page's file, and the page's title.
PAGES = {
    "server": ("Servers and sheets", ("kerf.blocking.client", "kerf.local_server", "kerf.blocking.sheet", "kerf.blocking.interaction", "kerf.scenes")),
    "cuts": ("Curves and cuts", ("kerf.curves", "kerf.cuts")),
    "regions": ("Regions of a sheet", ("kerf.regions",)),
    "frames": ("Frames and pictures", ("kerf.blocking.streams", "kerf.frames", "kerf.images")),
    "results": ("States, analyses and runs", ("kerf.arrays", "kerf.blocking.recorder", "kerf.runs")),
    "probes": ("Probes and steps", ("kerf.probes", "kerf.steps")),
    "errors": ("Errors", ("kerf.errors",)),
}
# Names the module of those names that do not say it themselves: types and numbers.
HOMES = {
    "APPLIED": "kerf.cuts", "NO_INTERSECTION": "kerf.cuts", "SCHEDULED": "kerf.cuts", "Point": "kerf.curves", "Edge": "kerf.regions",
    "Place": "kerf.regions", "Codec": "kerf.images", "ColorBy": "kerf.images",
    "AnyProbe": "kerf.probes", "Quantity": "kerf.probes"}
# Members of these are Python's, not Kerf's.
FOREIGN = "BaseException, Exception, dict, Sequence, Mapping, ABC, Generic, object"


def public_names(package):
    return [name for name in package.__all__ if name != "__version__"]


def home(package, name):
    return HOMES.get(name) or getattr(package, name).__module__


def directive(package, name):
    thing = getattr(package, name)
    full = f"{package.__name__}.{name}"
    if inspect.isclass(thing):
        return f".. autoclass:: {full}\n   :members:\n   :inherited-members: {FOREIGN}\n\n"
    if inspect.isroutine(thing):
        return f".. autofunction:: {full}\n\n"
    if isinstance(thing, int):  # has no docstring of its own
        return f".. py:data:: {full}\n   :value: {thing}\n\n   A status of :kerf:`CutResult <kerf.v1.CutResult.Status.{name}>`.\n\n"
    return f".. autodata:: {full}\n   :no-value:\n\n"


def title_and_line(title):
    return f"{title}\n{'=' * len(title)}\n\n"


def references():
    """Returns the text of each page by its path. The package that client/python/generate makes must be importable."""
    kerf = importlib.import_module("kerf")
    aio = importlib.import_module("kerf.aio")
    homes = {name: home(kerf, name) for name in public_names(kerf)}
    texts = {}
    for page, (title, modules) in PAGES.items():
        names = [name for module in modules for name in homes if homes[name] == module]
        texts[f"reference/python/{page}.rst"] = title_and_line(title) + "".join(directive(kerf, name) for name in names)
    homeless = sorted(name for name, module in homes.items() if not any(module in modules for _, modules in PAGES.values()))
    if homeless:
        raise SystemExit(f"deploy/site/python_pages.py names no page for {homeless}")
    asynchronous = "".join(directive(aio, name) for name in public_names(aio))
    texts["reference/python/aio.rst"] = f"{title_and_line('For asyncio')}.. automodule:: kerf.aio\n\n{asynchronous}"
    texts["reference/python/env.rst"] = (
        f"{title_and_line('Environments for learning')}.. automodule:: kerf.env\n\n"
        ".. autoclass:: kerf.env.SheetEnv\n   :members:\n\n.. autoclass:: kerf.env.SheetVectorEnv\n   :members:\n\n")
    pages = "".join(f"   {page}\n" for page in (*PAGES, "aio", "env"))
    texts["reference/python/index.rst"] = (
        f"{title_and_line('Python package')}.. automodule:: kerf\n\n"
        ":doc:`/client/python/README` introduces it. In annotations, ``Floats``, ``Float32s``, ``Ints`` and ``Bytes`` are NumPy arrays of "
        "such numbers. ``AnyScene`` is a scene file, or a ``Scene`` of kerf.v1 as a message or a mapping; ``AnyMaterial`` is a preset, or a "
        "``Material`` in the same way; ``Part`` is a box and its material; ``Fit`` is a box, or \"sheet\".\n\n"
        f".. toctree::\n   :maxdepth: 2\n\n{pages}")
    return texts
