"""Progress on a terminal and in a log."""

import io

from pathgene.host.progress import Counter, Progress


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


def test_log_has_the_first_the_last_and_every_five_seconds():
    text = run(io.StringIO(), [0, 1, 4.9, 5.0, 6, 9.9])
    assert text.splitlines() == [
        "generation 0/100  best 1.5000  mean 0.2500",
        "generation 3/100  best 1.5000  mean 0.2500",
        "generation 5/100  best 1.5000  mean 0.2500",
    ]


def test_log_does_not_repeat_the_last_line():
    assert run(io.StringIO(), [0, 6]).count("\n") == 2


def test_terminal_redraws_a_line():
    text = run(Terminal(), [0, 0.05, 0.1, 0.15], generations=3)
    frames = text.rstrip("\n").split("\r\x1b[K")
    assert frames[0] == ""
    assert [frame[:32] for frame in frames[1:]] == [
        f"[{'.' * 30}]",
        f"[{'#' * 20}{'.' * 10}]",
        f"[{'#' * 30}]",
    ]
    assert text.count("\n") == 1
    assert text.endswith("\n")


def test_terminal_bar_does_not_overflow():
    text = run(Terminal(), [0, 1, 2, 3], generations=2)
    assert f"[{'#' * 30}] generation 3  best " in text


def test_shows_nothing_without_generations():
    stream = Terminal()
    Progress(stream, 5).close()
    assert stream.getvalue() == ""


def test_a_counter_is_for_terminals():
    shown = []
    for stream in (Terminal(), io.StringIO()):
        counter = Counter(stream, "kernels compiled")
        counter.update(1)
        counter.update(2)
        counter.close()
        shown.append(stream.getvalue())
    assert shown == ["\r\x1b[K1 kernels compiled\r\x1b[K2 kernels compiled\n", ""]
