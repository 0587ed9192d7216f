from __future__ import annotations

import numpy as np
import pytest

from mol_compactons import InputError
from mol_compactons.expressions import Node, Program, check_name, number, parse, pointwise

HOSTILE = [
    "__import__('os').system('ls')",
    "__import__(os)",
    "().__class__.__bases__",
    "u.__class__",
    "exec(u)",
    "eval(u)",
    "open(u)",
    "globals()",
    "lambda: u",
    "[u for u in x]",
    "{u: u}",
    "u if u else 0",
    "(u := 3)",
    "'a' * 10",
    "f'{u}'",
    "u[0]",
    "u @ u",
    "u; u",
    "not u",
    "yield",
    "await u",
    "10**10**10",
    "9**9**9**9",
    "(u**1000)**1000",
    "exp(exp(exp(100)))",
    "1e999",
    "9" * 400,
    "(" * 900 + "u" + ")" * 900,
    "-" * 1900 + "u",
    "u" + "+u" * 900,
    "u" * 5000,
    "u\x00",
    "ü",
    "u\\\nu",
    "# u",
    "1j",
    "0x10",
    "1_000",
    "*u",
    "sin(*u)",
    "sin(u=1)",
    "",
    "  \n ",
]


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_texts_get_a_sentence(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing of the text is ever run."""
    monkeypatch.setattr("builtins.eval", None)
    monkeypatch.setattr("builtins.exec", None)
    with pytest.raises(InputError) as caught:
        parse(text, "CustomEquation.flux", ("u", "x", "t"), {"nu": 0.1}, derivatives=True)
    sentence = str(caught.value)
    assert sentence.startswith("CustomEquation.flux")
    assert sentence.endswith((".", "?"))
    assert "\n" not in sentence
    assert len(sentence) < 400


@pytest.mark.parametrize(
    ("text", "place", "cure"),
    [
        ("u^2", "at character 2, '^'", "write ** for a powe"),
        ("u + 2u", "at character 6, 'u'", "write * between them"),
        ("u (u + 1) (u)", "at character 11, '('", "write * between them"),
        ("|u|", "at character 1, '|'", "write abs(...)"),
        ("F = u", "at character 3, '='", "one side of an equation"),
        ("heaviside(u > 0)", "at character 13, '>'", "heaviside"),
        ("u**2 + u_xx", "at character 8, 'u_xx'", "write d2(u)"),
        ("u + nv", "at character 5, 'nv'", "did you mean 'nu'"),
        ("3*W", "at character 3, 'W'", "u, x, t, nu, pi, e"),
        ("\n  u**2\n  + q", "at character 13, 'q'", "it may be"),
        ("sin + u", "at character 1, 'sin'", "write sin(...)"),
        ("u*tg(u)", "at character 3, 'tg'", "tan"),
        ("d4(u)", "at character 1, 'd4'", "did you mean 'd3'"),
        ("nu(u)", "at character 1, 'nu'", "write nu*(...)"),
        ("max(u)", "at character 1, 'max(u)'", "2 arguments"),
        ("sin(u, u)", "at character 1, 'sin(u, u)'", "1 argument"),
        ("1,5*u", "at character 1, '1,5", "decimal point"),
        ("u**u", "at character 4, 'u'", "numbers and parameters"),
        ("2**(u + 1)", "at character 5, 'u + 1'", "write exp((u + 1)*log(2))"),
        ("u**101", "at character 4, '101'", "between -100 and 100"),
        ("u +", "at character 3, '+'", "go on with a value"),
        ("(u", "at character 1", "1 bracket must be closed"),
        ("u))", "at character 2", "2 brackets too many close"),
        ("u // 2", "at character 1, 'u // 2'", "numbers, names and functions"),
        ("u + 1/(2 - 2)", "at character 5, '1/(2 - 2)'", "write one that does"),
        ("(-8)**(1/3)", "at character 1", "write one that does"),
        ("lambda*u", "at character 1, 'lambda'", "choose another name"),
        ("u" + "*u" * 40 + "*q" + "*u" * 40, "...': at character 83, 'q'", "it may be"),
    ],
)
def test_sentences_point_at_the_place_and_say_what_to_write(text: str, place: str, cure: str) -> None:
    with pytest.raises(InputError) as caught:
        parse(text, "CustomEquation.flux", ("u", "x", "t"), {"nu": 0.1}, derivatives=True)
    problem, _, advice = str(caught.value).partition("; ")
    assert place in problem
    assert cure in advice


@pytest.mark.parametrize(("before", "start"), [(0, 0), (40, 52), (70, 103), (80, 103)])
def test_of_a_long_formula_the_part_around_the_place_is_shown(before: int, start: int) -> None:
    """Sixty of 163 characters, and no fewer at the ends."""
    text = "u" + "*u" * before + "*q" + "*u" * (80 - before)
    shown = ("..." if start else "") + text[start : start + 60] + ("..." if start < 103 else "")
    with pytest.raises(InputError) as caught:
        parse(text, "CustomEquation.flux", ("u", "x", "t"), {}, derivatives=True)
    assert repr(shown) in str(caught.value)


def test_derivatives_only_where_they_are_allowed() -> None:
    with pytest.raises(InputError, match="a derivative in space stands where there is none"):
        pointwise("d2(x)")
    tree = parse("d2(x)", "f", ("x",), derivatives=True)
    with pytest.raises(InputError, match="d2 stands where there is no grid"):
        Program((tree,)).evaluate(3, {"x": np.zeros(3)})


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("a + b*c", "a + (b*c)"),
        ("a - b - c", "(a - b) - c"),
        ("a/b/c", "(a/b)/c"),
        ("-a**2", "-(a**2)"),
        ("a**2**3", "a**8"),
        ("+a", "a"),
        ("2*3 + 1", "7"),
        ("pi", "3.141592653589793"),
        ("nu*2 + b", "0.2 + b"),
        ("  a\n + b ", "a + b"),
        (".5e1", "5"),
    ],
)
def test_operations_bind_as_in_mathematics(text: str, same: str) -> None:
    """And what is constant is computed once, with parameters as numbers."""
    one, other = (parse(each, "f", ("a", "b", "c"), {"nu": 0.1}) for each in (text, same))
    assert one == other


def test_a_tree_remembers_what_was_written_where() -> None:
    tree = parse("a + sin(b)", "f", ("a", "b"))
    assert (tree.kind, tree.text) == ("add", "a + sin(b)")
    assert [(part.kind, part.text, part.place) for part in tree.parts] == [("name", "a", 1), ("sin", "sin(b)", 5)]
    assert parse("2", "f", ()) == number(2.0) == Node("number", number=2.0)


@pytest.mark.parametrize("name", ["sin", "pi", "e", "d2", "lambda", "2u", "u v", "", "ü"])
def test_a_name_that_means_something_or_is_none_is_refused(name: str) -> None:
    with pytest.raises(InputError):
        check_name(name, "CustomEquation.parameters")
    check_name("nu", "CustomEquation.parameters")
