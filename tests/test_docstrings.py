"""The examples in the docstrings of what is public run, and give what they say."""

from __future__ import annotations

import doctest
import inspect

import pytest

import workbench as wb

FUNCTIONS = {
    name: inspect.unwrap(getattr(wb, name))
    for name in wb.__all__
    if inspect.isroutine(inspect.unwrap(getattr(wb, name)))
}
EXAMPLES = {
    name: found
    for name, function in FUNCTIONS.items()
    for found in doctest.DocTestFinder(recurse=False).find(function, name, globs={})
    if found.examples
}


def test_the_most_used_functions_have_an_example():
    assert len(EXAMPLES) >= 30


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_gives_what_it_says(name, capsys):
    doctest.DocTestRunner(verbose=False).run(EXAMPLES[name], clear_globs=False)
    assert capsys.readouterr().out == ""
