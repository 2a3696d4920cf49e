"""Several searches that ask for members at once: what all of them wait for is computed together, in lanes.

Each search is a thread of plain code. When every one of them waits, what they asked for is computed by the thread that began them, which
hears signals; so what a search sees does not depend on how quick the others are.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeVar

Question = TypeVar("Question")
Answer = TypeVar("Answer")


class Abandoned(Exception):
    """Nobody answers any more."""


class Together(Generic[Question, Answer]):
    """Runs searches side by side; each gets a function that answers a list of questions. ``answer`` answers those of all of them at once."""

    def __init__(self, answer: Callable[[list[Question]], Sequence[Answer]]) -> None:
        self.answer = answer
        self.changed = threading.Condition()
        self.asked: dict[int, list[Question]] = {}
        self.answers: dict[int, list[Answer]] = {}
        self.running, self.over = 0, False
        self.trouble: BaseException | None = None

    def run(self, searches: Sequence[Callable[[Callable[[Sequence[Question]], list[Answer]]], None]]) -> None:
        """Returns when all have ended. Raises what a search or ``answer`` raised, KeyboardInterrupt among it, when all have left."""
        self.running = len(searches)
        threads = [threading.Thread(target=self._search, args=(k, one), daemon=True) for k, one in enumerate(searches)]
        for thread in threads:
            thread.start()
        try:
            self._serve()
        finally:
            with self.changed:
                self.over = True
                self.changed.notify_all()
            for thread in threads:
                thread.join()
        if self.trouble is not None:
            raise self.trouble

    def _serve(self) -> None:
        while True:
            with self.changed:
                while self.running and len(self.asked) < self.running and self.trouble is None:
                    self.changed.wait(0.2)
                if not self.running or self.trouble is not None:
                    return
                asked, self.asked = dict(sorted(self.asked.items())), {}
            every = iter(self.answer([one for questions in asked.values() for one in questions]))
            answers = {k: [next(every) for _ in questions] for k, questions in asked.items()}
            with self.changed:
                self.answers |= answers
                self.changed.notify_all()

    def _search(self, number: int, search: Callable[[Any], None]) -> None:
        def ask(questions: Sequence[Question]) -> list[Answer]:
            with self.changed:
                self.asked[number] = list(questions)
                self.changed.notify_all()
                while number not in self.answers and not self.over:
                    self.changed.wait()
                if number not in self.answers:
                    raise Abandoned
                return self.answers.pop(number)

        try:
            search(ask)
        except Abandoned:
            pass
        except BaseException as error:
            self.trouble = error
        finally:
            with self.changed:
                self.running -= 1
                self.changed.notify_all()
