"""The film crew: all cameras of a rig, in this process or shared among several; the frames are the same."""

import multiprocessing
import os
import signal
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess

import cv2

from contracts import Camera, GantryError
from contracts.truth import Truth
from sim.film import CameraFilm
from sim.highlights import HighlightSpec
from sim.lens import Lens, pinhole_camera
from sim.rain import RainSpec
from sim.sensor import SensorSpec
from sim.shared_pictures import SharedPictures, Take
from sim.studio import Studio

_AHEAD = 3  # states under way to each worker: enough to keep it busy, few enough to keep memory small


@dataclass(frozen=True, eq=False)
class FilmSpec:
    """All that decides a film, given the states of the world."""

    studio: Studio
    cameras: tuple[Camera, ...]
    sensor: SensorSpec
    noise_seed: int
    keep_instances: bool
    highlights: tuple[HighlightSpec, ...] = ()
    rain: RainSpec | None = None


def film(spec: FilmSpec, states: Iterable[Truth], *, workers: int) -> Iterator[tuple[Take, ...]]:
    """Film every state with every camera, in the order of ``spec.cameras``.

    workers: 1 films here; more share the cameras among so many processes (never more than cameras), which set out at
        once, before the first picture is asked for, and end with the iteration.
    """
    workers = min(workers, len(spec.cameras))
    if workers <= 1:
        return _film_here(spec, states)
    filming = _film_by_team(spec, states, workers)
    next(filming)
    return filming


def _film_here(spec: FilmSpec, states: Iterable[Truth]) -> Iterator[tuple[Take, ...]]:
    lenses = [Lens.of(camera.intrinsics) for camera in spec.cameras]
    pinholes = [pinhole_camera(camera, lens) for camera, lens in zip(spec.cameras, lenses, strict=True)]
    renderer = spec.studio.renderer(pinholes)
    films = [
        CameraFilm(
            camera,
            lens,
            renderer,
            spec.sensor,
            noise_seed=spec.noise_seed,
            keep_instances=spec.keep_instances,
            highlights=spec.highlights,
            rain=spec.rain,
            view=spec.studio.view,
        )
        for camera, lens in zip(spec.cameras, lenses, strict=True)
    ]
    try:
        for state in states:
            yield tuple(camera.shoot(state) for camera in films)
    finally:
        renderer.close()


def _film_by_team(spec: FilmSpec, states: Iterable[Truth], workers: int) -> Iterator[tuple[Take, ...]]:
    """Yields nothing of use first, as soon as the processes are under way."""
    order = {camera.name: k for k, camera in enumerate(spec.cameras)}
    team = [_Worker(replace(spec, cameras=spec.cameras[k::workers])) for k in range(workers)]
    try:
        yield ()
        for takes in _through(team, states):
            yield tuple(sorted(takes, key=lambda take: order[take[0].camera]))
    finally:
        for worker in team:
            worker.dismiss()


def _through(team: Sequence["_Worker"], states: Iterable[Truth]) -> Iterator[list[Take]]:
    """Send states to all workers a little ahead of what has come back."""
    under_way: deque[None] = deque()
    for state in states:
        for worker in team:
            worker.inbox.send(state)
        under_way.append(None)
        if len(under_way) >= _AHEAD:
            under_way.popleft()
            yield [take for worker in team for take in worker.takes()]
    while under_way:
        under_way.popleft()
        yield [take for worker in team for take in worker.takes()]


class _Worker:
    """A process that films with its share of the cameras."""

    def __init__(self, share: FilmSpec) -> None:
        context = multiprocessing.get_context("spawn")  # a forked OpenGL context would be shared, and break
        self.inbox, theirs = context.Pipe()
        self._pictures = SharedPictures(context, share.cameras, _AHEAD, keep_instances=share.keep_instances)
        self._taken = 0
        self._process: BaseProcess = context.Process(target=_work, args=(share, theirs, self._pictures), daemon=True)
        with _deaf_to_the_keyboard():
            self._process.start()
        theirs.close()

    def takes(self) -> list[Take]:
        """What the worker's cameras made of the oldest state under way."""
        try:
            answer: list[Take] | GantryError = self.inbox.recv()
        except (EOFError, ConnectionResetError) as error:
            raise GantryError(f"a film process ended with exit status {self._process.exitcode}") from error
        if isinstance(answer, GantryError):
            raise answer
        self._taken += 1
        return self._pictures.get(self._taken - 1, answer)

    def dismiss(self) -> None:
        """End the process, busy or not."""
        self.inbox.close()
        self._process.terminate()
        self._process.join()


@contextmanager
def _deaf_to_the_keyboard() -> Iterator[None]:
    """Processes set out here do not hear Ctrl-C, which reaches a whole group: who began the film ends them."""
    resource_tracker.ensure_running()  # as it starts it would hear the keyboard again, for all
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _work(share: FilmSpec, outbox: Connection, pictures: SharedPictures) -> None:
    """Film states from ``outbox`` until it closes."""
    os.environ["LP_NUM_THREADS"] = "0"  # one thread for Mesa and one for OpenCV: the processes share the cores
    cv2.setNumThreads(1)

    def states() -> Iterator[Truth]:
        while True:
            try:
                yield outbox.recv()
            except (EOFError, ConnectionResetError):
                return

    try:
        for moment, takes in enumerate(_film_here(share, states())):
            outbox.send(pictures.put(moment, takes))
    except GantryError as error:
        outbox.send(error)
    except BrokenPipeError:  # nobody listens any more
        pass
