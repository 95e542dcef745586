"""The study of real sensors: its command gives the page that is kept here."""

from __future__ import annotations

from pathlib import Path

from command import Outcome, execute
from measured import MEASURED, needs_measured
from test_experiments import NUMBER, files, is_close

STUDY = Path(__file__).parents[1] / "experiments" / "measured"
SOURCES = {"drawings.py", "page.md", "run.py"}


@needs_measured
def test_the_command_writes_the_page_that_is_kept(tmp_path: Path) -> None:
    outcome = execute(tmp_path, "python", str(STUDY / "run.py"), "--data", str(MEASURED), "--to", "page")
    assert outcome.status == 0, outcome.err
    assert outcome.err == ""
    page = Outcome(0, "", "", tmp_path / "page")
    assert files(page.directory) == files(STUDY) - SOURCES
    kept, written = ((directory / "README.md").read_text(encoding="utf-8") for directory in (STUDY, page.directory))
    assert NUMBER.sub("#", kept) == NUMBER.sub("#", written)
    pairs = zip(NUMBER.findall(kept), NUMBER.findall(written), strict=True)
    assert [pair for pair in pairs if not is_close(*pair)] == []


def test_the_figures_of_the_page() -> None:
    page = (STUDY / "README.md").read_text(encoding="utf-8")
    assert "more for 72 of the 72" in page
    for name in ("efficiency", "sessions"):
        assert f"({name}.svg)" in page
        assert (STUDY / f"{name}.svg").is_file()


def test_without_data_the_command_says_what_to_give(tmp_path: Path) -> None:
    outcome = execute(tmp_path, "python", str(STUDY / "run.py"), "--data", "nowhere")
    assert outcome.status == 2
    assert "no measurements in nowhere: give --data DIRECTORY" in outcome.err
    assert "Traceback" not in outcome.err
