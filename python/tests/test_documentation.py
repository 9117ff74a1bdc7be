# SPDX-License-Identifier: Apache-2.0
"""The Python snippets of README.md and docs/*.md run as they stand, page by page."""

import pathlib
import re

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
SNIPPET = re.compile(r"```python\n(.*?)```", re.S)
PAGES = [page for page in (REPOSITORY / "README.md", *sorted(REPOSITORY.glob("docs/*.md"))) if SNIPPET.search(page.read_text("utf-8"))]


def test_guides_are_there():
    names = {page.stem for page in PAGES}
    assert names >= {"README", "python", "getting-started", "choosing", "results", "performance", "from-open3d"}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_snippets(page, capsys):
    text = page.read_text("utf-8")
    names = {}
    for snippet in SNIPPET.finditer(text):
        line = text.count("\n", 0, snippet.start(1))
        exec(compile("\n" * line + snippet.group(1), page.name, "exec"), names)
    assert capsys.readouterr().out
