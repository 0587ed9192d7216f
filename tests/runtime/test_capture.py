"""What is printed inside is kept; what is printed around it is not touched."""

import os

import pytest

from mol_compactons.runtime.capture import captured_lines


def test_lines_of_c_and_of_python_are_kept(capfd: pytest.CaptureFixture[str]) -> None:
    with captured_lines() as lines:
        os.write(2, b"  from C \n\nagain\n")
        print("from Python")
        assert lines == []
    print("after")
    os.write(2, b"behind\n")
    assert lines == ["from C", "again", "from Python"]
    assert capfd.readouterr() == ("after\n", "behind\n")


def test_a_block_that_raises_gives_the_streams_back(capfd: pytest.CaptureFixture[str]) -> None:
    seen: list[list[str]] = []

    def fail() -> None:
        with captured_lines() as lines:
            seen.append(lines)
            os.write(2, b"before it\n")
            raise ValueError("within")

    with pytest.raises(ValueError, match="within"):
        fail()
    os.write(2, b"after\n")
    assert seen == [["before it"]]
    assert capfd.readouterr().err == "after\n"
