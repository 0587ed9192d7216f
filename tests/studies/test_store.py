from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from mol_compactons import InputError
from mol_compactons.studies.store import LOCK, MEMBERS, PLAN, ROWS, Store, forget_another, plan_of, result_path, rows_of

PLANNED = {"simulation": {"t_end": 1.0}, "axes": [1, 2]}


def row(name: str, status: str = "complete") -> dict[str, str]:
    return {"name": name, "status": status}


def test_what_is_added_is_there_for_the_next_and_the_last_word_counts(tmp_path: Path) -> None:
    folder = tmp_path / "study"
    store = Store(folder, PLANNED)
    for one in (row("a"), row("b", "failed"), row("b")):
        store.add(one)
    assert rows_of(folder) == store.rows() == {"a": row("a"), "b": row("b")}
    store.close()
    again = Store(folder, PLANNED)
    again.add(row("c"))
    assert set(again.rows()) == {"a", "b", "c"}
    again.close()
    assert plan_of(folder)["axes"] == [1, 2]
    assert result_path(folder, "a") == again.path_of("a") == folder / MEMBERS / "a.nc"


@pytest.mark.parametrize("cut", range(1, 30, 4))
def test_a_line_that_a_crash_cut_off_is_left_out_and_the_next_one_is_whole(cut: int, tmp_path: Path) -> None:
    store = Store(tmp_path / "study", PLANNED)
    store.add(row("a"))
    store.add(row("b"))
    store.close()
    path = tmp_path / "study" / ROWS
    path.write_bytes(path.read_bytes()[:-cut])
    assert set(rows_of(tmp_path / "study")) == {"a"}
    again = Store(tmp_path / "study", PLANNED)
    again.add(row("c"))
    assert set(again.rows()) == {"a", "c"}
    again.close()


def test_a_folder_holds_one_study(tmp_path: Path) -> None:
    Store(tmp_path / "study", PLANNED).close()
    with pytest.raises(InputError, match="holds another study"):
        Store(tmp_path / "study", {**PLANNED, "axes": [1, 3]})
    (tmp_path / "letters").mkdir()
    (tmp_path / "letters" / "love.txt").touch()
    with pytest.raises(InputError, match="holds other files"):
        Store(tmp_path / "letters", PLANNED)
    with pytest.raises(InputError, match="is a file"):
        Store(tmp_path / "letters" / "love.txt", PLANNED)
    with pytest.raises(InputError, match="does not exist"):
        Store(tmp_path / "no" / "where", PLANNED)
    assert [path.name for path in (tmp_path / "letters").iterdir()] == ["love.txt"]


def test_a_second_process_is_told_that_the_study_runs(tmp_path: Path) -> None:
    store = Store(tmp_path / "study", PLANNED)
    code = (
        "from pathlib import Path; from mol_compactons.studies.store import Store\n"
        f"Store(Path({str(tmp_path / 'study')!r}), {PLANNED!r})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "Another process runs the study" in done.stderr.splitlines()[-1]
    forget_another(tmp_path / "study", {"axes": []})
    assert plan_of(tmp_path / "study")
    store.close()
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, check=False).returncode == 0


def test_a_folder_that_a_program_made_for_itself_is_made_anew_for_another_study(tmp_path: Path) -> None:
    Store(tmp_path / "study", PLANNED).close()
    forget_another(tmp_path / "study", PLANNED)
    assert (tmp_path / "study" / PLAN).is_file()
    forget_another(tmp_path / "study", {"axes": []})
    assert not (tmp_path / "study").exists()
    forget_another(tmp_path / "study", {"axes": []})


@pytest.mark.parametrize(
    ("content", "words"), [("{", "is damaged"), ("[]", "does not know"), (json.dumps({"format": 99}), "does not know")]
)
def test_a_plan_that_cannot_be_read_is_one_sentence(content: str, words: str, tmp_path: Path) -> None:
    (tmp_path / PLAN).write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        plan_of(tmp_path)
    with pytest.raises(InputError, match="holds no study"):
        plan_of(tmp_path / "nowhere")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="permission denied"):
        Store(tmp_path / "study", PLANNED)


def test_the_lock_stays_and_holds_nothing(tmp_path: Path) -> None:
    Store(tmp_path / "study", PLANNED).close()
    assert (tmp_path / "study" / LOCK).read_bytes() == b""
