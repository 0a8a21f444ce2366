"""Progress on a terminal and in a log."""

import io
import re

import pytest

from pathgene.host.cli.output import print_line
from pathgene.host.progress import Bar, Counter, Progress
from pathgene.host.stages import part, stage, watched_by


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Clock:
    def __init__(self):
        self.now_s = 0.0

    def __call__(self):
        return self.now_s


def run(stream, times, generations=100):
    clock = Clock()
    progress = Progress(stream, generations, clock)
    for generation, now in enumerate(times):
        clock.now_s = now
        progress.update(generation, 1.5, 0.25)
    progress.close()
    return stream.getvalue()


def frames(text):
    """Return the lines that a terminal has shown, without spaces that erase them."""
    return [line for each in re.split(r"[\r\n]", text) if (line := each.rstrip())]


def test_log_has_the_first_the_last_and_every_five_seconds():
    text = run(io.StringIO(), [0, 1, 4.9, 5.0, 6, 9.9])
    assert text.splitlines() == [
        "generation 0/100  best 1.5000  mean 0.2500",
        "generation 3/100  best 1.5000  mean 0.2500",
        "generation 5/100  best 1.5000  mean 0.2500",
    ]


def test_log_does_not_repeat_the_last_line():
    assert run(io.StringIO(), [0, 6]).count("\n") == 2


def test_terminal_redraws_a_line_and_keeps_the_last_text():
    text = run(Terminal(), [0, 0.05, 0.11, 0.15], generations=4)
    *drawn, last = frames(text)
    assert [line[:5] for line in drawn] == ["  0 %", " 50 %"]
    assert all("generation" in line and " left" in line for line in drawn)
    assert last == "generation 3/4  best 1.5000  mean 0.2500"
    assert text.count("\n") == 1
    assert text.endswith("\n")


def test_terminal_bar_does_not_overflow():
    *_, full, last = frames(run(Terminal(), [0, 1, 2, 3], generations=2))
    assert full.startswith("100 %")
    assert "generation 3  best " in full
    assert last.startswith("generation 3  best ")


def test_shows_nothing_without_generations():
    stream = Terminal()
    Progress(stream, 5).close()
    assert stream.getvalue() == ""


def test_terminal_shows_stages_and_keeps_the_seconds_of_long_ones():
    stream, clock = Terminal(), Clock()
    bar = Bar(stream, 1, clock)
    with watched_by(bar.stage):
        stage("opening the board")
        clock.now_s = 0.2
        for share in (0.0, 0.43):
            stage("uploading the map", share)
            clock.now_s += 1
        stage("searching")
    bar.close()
    shown = frames(stream.getvalue())
    assert shown[0].startswith("opening the board")
    assert shown[1].startswith("  0 %")
    assert shown[2].startswith(" 43 %")
    assert "uploading the map" in shown[2]
    assert shown[3] == "uploading the map: 2.0 s"
    assert shown[4].startswith("searching")
    assert len(shown) == 5


def test_log_has_a_stage_only_after_five_silent_seconds():
    stream, clock = io.StringIO(), Clock()
    progress = Progress(stream, 9, clock)
    with watched_by(progress.stage):
        stage("opening the board")
        clock.now_s = 5
        stage("uploading the map", 0.1)
        clock.now_s = 6
        stage("uploading the map", 0.2)
        clock.now_s = 10
        stage("searching")
        clock.now_s = 15
        stage("searching")
    progress.close()
    assert stream.getvalue().splitlines() == ["uploading the map 10 %", "searching"]


@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()], ids=["log", "terminal"])
def test_a_part_is_named(stream):
    progress = Progress(stream, 1)
    with part("leg 2, from A to B"):
        progress.update(1, 1.5, 0.25)
    progress.close()
    named = "leg 2, from A to B: generation 1/1  best 1.5000  mean 0.2500"
    assert frames(stream.getvalue())[-1] == named


def test_nobody_watches_after_the_block():
    seen = []
    with watched_by(lambda *announced: seen.append(announced)):
        stage("inside", 0.5)
    stage("outside")
    assert seen == [("inside", 0.5)]


def test_a_counter_is_for_terminals():
    shown = []
    for stream in (Terminal(), io.StringIO()):
        counter = Counter(stream, "kernels compiled")
        counter.update(1)
        counter.update(2)
        counter.close()
        shown.append(stream.getvalue())
    assert shown == ["\r\x1b[K1 kernels compiled\r\x1b[K2 kernels compiled\n", ""]


def test_a_note_has_a_line_of_its_own(monkeypatch):
    stream = Terminal()
    monkeypatch.setattr("sys.stderr", stream)
    bar = Bar(stream, 1)
    bar.stage("opening the board")
    print_line("building the chip")
    bar.close()
    before, note, after = frames(stream.getvalue())
    assert note == "pathgene: building the chip"
    assert before == after == "opening the board, 00:00"


def test_a_stage_in_a_log_follows_the_text_before_it():
    stream, clock = io.StringIO(), Clock()
    progress = Progress(stream, 100, clock)
    for clock.now_s, generation in ((0, 1), (3, 100)):
        progress.update(generation, 1.5, 0.25)
    clock.now_s = 6
    progress.stage("refining the route")
    progress.close()
    assert [line.partition("  ")[0] for line in stream.getvalue().splitlines()] == [
        "generation 1/100",
        "generation 100/100",
        "refining the route",
    ]


def test_time_left_is_not_negative_if_a_count_begins_again():
    stream, clock = Terminal(), Clock()
    bar = Bar(stream, 100, clock)
    for clock.now_s, done in ((0, 80), (1, 5), (2, 6)):
        bar.show(done, "run")
    bar.close()
    assert len(frames(stream.getvalue())) == 4
    assert ", -" not in stream.getvalue()
