# SPDX-License-Identifier: Apache-2.0
"""The site: docs/*.md, the C++ reference from doxygen's XML, the Python reference from the stub. scripts/docs runs it.

The source folder is a copy of what the pages link to; reference pages are written into it, one for each folder of headers.
"""

import os
import pathlib
import re
import sys

from sphinx.util import logging

SOURCE = pathlib.Path(os.environ["FRANSAC_DOCS_SOURCE"])
sys.path.insert(0, str(SOURCE / "python"))

project = "fransac"
version = release = os.environ["FRANSAC_VERSION"]
copyright = "the fransac authors; Apache-2.0"
extensions = ["breathe", "myst_parser", "sphinx.ext.autodoc"]
exclude_patterns = ["README.md", "docs/site", "python", "include"]
html_theme = "furo"
html_title = f"fransac {version}"
html_show_sphinx = False
html_copy_source = False
highlight_language = "none"
# Every header is in the namespaces of all others, and Breathe declares these anew for each. Nothing else is declared twice.
suppress_warnings = ["duplicate_declaration.cpp"]
myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath"]
breathe_projects = {"fransac": os.environ["FRANSAC_DOXYGEN_XML"], "pcl": os.environ["FRANSAC_DOXYGEN_PCL_XML"]}
breathe_default_project = "fransac"
breathe_show_include = False
cpp_maximum_signature_line_length = 100
python_maximum_signature_line_length = 100
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
python_use_unqualified_type_names = True

MODULES = {
    "planes": "Planes: `segment`, options, outlines",
    "core": "Core: cameras, depth, clouds, planes, errors",
    "obstacles": "Obstacles and maps of the ground",
    "track": "Tracking",
    "filter": "Filters: deprojection, pass-through, voxel grids, lenses",
    "calibrate": "Calibration of sensors",
    "sac": "RANSAC",
    "eval": "Metrics",
    "synth": "Rendered scenes",
    "io": "Files: `fransac::io`",
    "pcl": "In the place of PCL's classes: `fransac::pcl`",
}
# Not for use (Doxyfile).
HIDDEN = {"planes/tuning.hpp", "pcl/points.hpp", "pcl/field_means.hpp"}


def project_of(folder):
    """Headers of the adapter have a project of their own: one is called like a header of the library."""
    return "pcl" if folder == "pcl" else "fransac"


def write_reference():
    """A page for each folder of headers; one that MODULES does not name is an error."""
    folders = {header.parent.name for header in (SOURCE / "include/fransac").glob("*/*.hpp")}
    assert folders == set(MODULES), f"docs/site/conf.py: MODULES does not fit the folders of headers: {folders ^ set(MODULES)}"
    for folder, title in MODULES.items():
        text = f"# {title}\n"
        for header in sorted((SOURCE / "include/fransac" / folder).glob("*.hpp")):
            if f"{folder}/{header.name}" not in HIDDEN:
                text += f"\n## {header.name}\n\n`#include <fransac/{folder}/{header.name}>`\n"
                text += f"\n```{{eval-rst}}\n.. doxygenfile:: {header.name}\n   :project: {project_of(folder)}\n```\n"
        page = SOURCE / "cpp" / f"{folder}.md"
        page.parent.mkdir(exist_ok=True)
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


def sections_of_docstring(app, what, name, obj, options, lines):
    """Our docstrings' sections: an underlined title, then indented lines "name: text". Nothing public goes without."""
    if not any(lines):
        logging.getLogger(__name__).warning("%s has no docstring", name)
    text = "\n".join(lines)
    if what == "module":
        text = re.sub(r"\n\n(?= {4}\S)", "\n\n.. code-block:: python\n\n", text)
        lines[:] = text.split("\n")
    first = re.search(r"^\w.*\n-{3,}$", text, re.M)
    if not first:
        return
    before, sections = text[: first.start()], text[first.start() :]
    sections = re.sub(r"^(\w.*)\n-{3,}$", r".. rubric:: \1\n", sections, flags=re.M)
    sections = re.sub(r"^ {4}(\w+(?:, \w+)*): ", r"* **\1**: ", sections, flags=re.M)
    sections = re.sub(r"^ {4}(?=\S)", "", re.sub(r"^ {8}(?=\S)", "  ", sections, flags=re.M), flags=re.M)
    lines[:] = (before + sections).split("\n")


def link_home(app, docname, source):
    """README.md is the site's index; a folder has no page, and a link to it is its text."""
    text = source[0].replace("](../README.md", "](../index.md").replace("](README.md", "](index.md")
    source[0] = re.sub(r"\[([^]]+)\]\((?:\.\./)*[\w-]+/[\w/-]+\)", r"\1", text)


def setup(app):
    write_reference()
    app.connect("autodoc-process-docstring", sections_of_docstring)
    app.connect("source-read", link_home)
