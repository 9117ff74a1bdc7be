# SPDX-License-Identifier: Apache-2.0
"""The snippets of README.md and docs/python.md run as they stand."""

import pathlib
import re

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("page", ["README.md", "docs/python.md"])
def test_snippets(page, capsys):
    text = (REPOSITORY / page).read_text(encoding="utf-8")
    snippets = list(re.finditer(r"```python\n(.*?)```", text, re.S))
    assert snippets
    names = {}
    for snippet in snippets:
        line = text.count("\n", 0, snippet.start(1))
        exec(compile("\n" * line + snippet.group(1), page, "exec"), names)
    assert capsys.readouterr().out
