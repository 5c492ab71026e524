"""The server of the bench: its page, and the socket over which the page asks.

The loop of the server calls no engine. One thread does what is asked, in order; another makes bodies
and predictions beforehand, a third judges the state once it rests, a fourth makes motions, envelopes
and what else takes long to look at, a fifth waits for the process that makes films. Two more are for a population: it is followed while
something is dragged, and settled once that rests. One judges what is seen at each change. What fails in one of them is reported to the pages,
and it goes on.
"""

from __future__ import annotations

import asyncio
import os
import secrets
import socket
import sys
import traceback
from collections import deque
from collections.abc import AsyncIterator, Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from functools import partial
from importlib.resources import files
from itertools import product
from pathlib import Path
from typing import Any, Protocol, TypeVar

from workbench.draw.web.packing import Packing
from workbench.draw.web.snippet import MODULES
from workbench.draw.web.views import WebView
from workbench.errors import InputError, MissingPartError, WorkbenchError
from workbench.live.desk import (
    Desk,
    Judgement,
    Preparation,
    SupersededError,
    busy_frame,
    fault_frame,
    words_of,
    work_made,
)
from workbench.live.films import Films
from workbench.live.guard import Application, Guard
from workbench.live.pages import Page, PageClosedError, Waiting
from workbench.live.protocol import (
    LONGEST,
    SUBPROTOCOL,
    Job,
    Question,
    Replies,
    Verbs,
    packed,
    parsed,
)
from workbench.live.running import Runner, Runs
from workbench.threads import available_cores

try:
    import uvicorn
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import FileResponse, Response
    from starlette.routing import Route, WebSocketRoute
    from starlette.websockets import WebSocket, WebSocketDisconnect

    from workbench.live.guard import bounded_connections
except ImportError:
    raise MissingPartError(
        "the bench needs starlette, uvicorn and websockets: pip install 'bubbleman-workbench[live]'"
    ) from None

__all__ = ["live_application", "serve"]

IDLE = 0.12
"""Time [s] without a change after which a state is judged."""
OFTEN = 0.1
"""Time [s] between two frames about a population that is followed."""
SAVES_THEN = "it is saved once what is being computed is there"
WATCH = 1.0
"""Time [s] between looks at the study's file."""
CLOSING = 1.0
"""Time [s] in which a page is told why it is closed."""
MOST_KNOWN = 10_000
"""Questions that are known to have been asked, by their numbers."""
SWITCH = 5e-4
"""Time [s] after which a thread lets another one go on. Of the 5e-3 that are usual, an answer waits
for several where a state is judged meanwhile."""
LONGEST_HEADERS = 2**20
"""Bytes of the headers of a request: a browser keeps up to 180 cookies of 4 KB for a host."""
BACKLOG = 128
"""Connections that wait to be taken, and are taken before others are served: fewer than files that a
program may have open, 256 on some systems."""
PAGE = {
    "index.html": "text/html; charset=utf-8",
    "style.css": "text/css; charset=utf-8",
    "app.js": "text/javascript; charset=utf-8",
    "connection.js": "text/javascript; charset=utf-8",
    "copying.js": "text/javascript; charset=utf-8",
    "elements.js": "text/javascript; charset=utf-8",
    "envelope.js": "text/javascript; charset=utf-8",
    "eye.js": "text/javascript; charset=utf-8",
    "field.js": "text/javascript; charset=utf-8",
    "far_painting.js": "text/javascript; charset=utf-8",
    "ghost.js": "text/javascript; charset=utf-8",
    "filming.js": "text/javascript; charset=utf-8",
    "gizmo.js": "text/javascript; charset=utf-8",
    "grips.js": "text/javascript; charset=utf-8",
    "keys.js": "text/javascript; charset=utf-8",
    "looks.js": "text/javascript; charset=utf-8",
    "measure.js": "text/javascript; charset=utf-8",
    "motion.js": "text/javascript; charset=utf-8",
    "rows.js": "text/javascript; charset=utf-8",
    "ways.js": "text/javascript; charset=utf-8",
    "painter.js": "text/javascript; charset=utf-8",
    "people.js": "text/javascript; charset=utf-8",
    "reporting.js": "text/javascript; charset=utf-8",
    "reach_map.js": "text/javascript; charset=utf-8",
    "person.js": "text/javascript; charset=utf-8",
    "progress.js": "text/javascript; charset=utf-8",
    "size.js": "text/javascript; charset=utf-8",
    "sliders.js": "text/javascript; charset=utf-8",
    "things.js": "text/javascript; charset=utf-8",
    "verdicts.js": "text/javascript; charset=utf-8",
    "picture.js": "text/javascript; charset=utf-8",
    "describe.html": "text/html; charset=utf-8",
    "describe.css": "text/css; charset=utf-8",
    "describe.js": "text/javascript; charset=utf-8",
    "describe_frame.js": "text/javascript; charset=utf-8",
    "describe_marks.js": "text/javascript; charset=utf-8",
    "describe_next.js": "text/javascript; charset=utf-8",
    "describe_parts.js": "text/javascript; charset=utf-8",
    "describe_things.js": "text/javascript; charset=utf-8",
    "icon.svg": "image/svg+xml",
}
"""The files of the page and their types."""
VIEW = {f"{name}.js": "text/javascript; charset=utf-8" for name in MODULES}
VIEW["view.css"] = "text/css; charset=utf-8"
"""The files of the viewer that the reports have too, and their types."""
FILM = {".mp4": "video/mp4", ".webp": "image/webp"}
"""The types of films."""
REPORT = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self' data:; "
    "media-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
)
"""What a browser may do with a report: it holds its script, which it names by its hash itself, and may
ask for nothing but the pictures beside it."""
BUSY = "a report is being made already: end that, or wait for it"
Found = TypeVar("Found")


class AnyDesk(Protocol):
    """What the server asks of every desk.

    Parameters
    ----------
    page
        The file of its page.
    verbs
        What may be asked of it.
    judges
        Whether its states are judged once they rest, and its file is watched: it is a `Desk`.
    """

    page: str
    verbs: Verbs
    judges: bool

    def greeting(self) -> list[bytes]:
        """What a page needs that was just opened."""

    def state(self) -> list[bytes]:
        """The answer to the state as it is."""

    def scene(self) -> WebView:
        """The picture as it is now."""

    def preparation(self, question: Question) -> Preparation | None:
        """What another thread is to do before `do`; None where nothing is."""

    def do(self, question: Question) -> Replies:
        """Do what is asked."""

    def keep(self) -> str:
        """Keep what is not saved in a file of its own; where, in words, "" where nothing is."""


class Hub:
    """What is done for the pages that are open on one desk."""

    def __init__(self, desk: AnyDesk, runner: Runner) -> None:
        self.desk = desk
        self.pages: set[Page] = set()
        self.waiting: Waiting[Page] = Waiting()
        self.asked = asyncio.Event()
        self.changed = asyncio.Event()
        self.moved = asyncio.Event()
        self.looked = asyncio.Event()
        self.rested = asyncio.Event()
        self.begun = asyncio.Event()
        self.works: list[tuple[Page, Job]] = []
        self.ended = False
        self.known: deque[int] = deque(maxlen=MOST_KNOWN)
        self.tasks: dict[str, asyncio.Task[None]] = {}
        self.preparations: asyncio.Queue[tuple[Page, Preparation | Question]] = asyncio.Queue()
        self.prepared = 0
        self.work = ThreadPoolExecutor(1, "desk")
        self.preparing = ThreadPoolExecutor(1, "prepare")
        self.judging = ThreadPoolExecutor(1, "judge")
        self.jobs = ThreadPoolExecutor(1, "jobs")
        self.following = ThreadPoolExecutor(available_cores(), "follow")
        self.settling = ThreadPoolExecutor(1, "settle")
        self.seeing = ThreadPoolExecutor(1, "see")
        self.films = Films(lambda error: fault_frame(None, words_of(error)))
        self.runs = Runs(runner, self.tell)

    @property
    def steps(self) -> tuple[Callable[[], Coroutine[Any, Any, None]], ...]:
        """What is done again and again as long as the bench is served."""
        if not self.desk.judges:
            return (self.answer,)
        return (
            self.answer,
            self.prepare,
            self.judge,
            self.run_jobs,
            self.films.make,
            self.runs.run_next,
            self.follow,
            self.settle,
            self.see,
            self.watch,
        )

    @property
    def study(self) -> Desk:
        """The desk where it is that of a study, which alone judges."""
        assert isinstance(self.desk, Desk)
        return self.desk

    def start(self) -> None:
        """Start what is done again and again, but for what has been started already."""
        for step in self.steps:
            if step.__name__ not in self.tasks:
                self.tasks[step.__name__] = asyncio.create_task(self.repeat(step))

    async def stop(self) -> None:
        """Stop what is done again and again."""
        for task in self.tasks.values():
            task.cancel()
        await asyncio.gather(*self.tasks.values(), return_exceptions=True)
        self.end()

    def end(self) -> None:
        """Let the threads end with what they are at."""
        self.ended = True
        for pool in (
            self.work,
            self.preparing,
            self.judging,
            self.jobs,
            self.following,
            self.settling,
            self.seeing,
        ):
            pool.shutdown(wait=False, cancel_futures=True)
        self.films.end()
        self.runs.end()

    def tell(self, frame: bytes) -> None:
        """Send a frame to all pages."""
        for page in self.pages:
            page.put(frame)

    async def at_desk(self, function: Callable[..., Found], *arguments: Any) -> Found:
        """Call a function in the thread of the desk."""
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self.work, partial(function, *arguments))

    async def repeat(self, step: Callable[[], Coroutine[Any, Any, None]]) -> None:
        """Take a step again and again, also after one that failed."""
        while True:
            try:
                await step()
            except Exception as error:  # noqa: BLE001 (one step that fails must not end the bench)
                await self.failed(error)
                await asyncio.sleep(IDLE)

    async def failed(self, error: Exception, question: Question | None = None) -> None:
        """Report an error that nobody expects: to all pages in words, in full to who started the
        bench."""
        traceback.print_exception(error)
        await self.send(Replies(everybody=[fault_frame(question, words_of(error))]))

    async def answer(self) -> None:
        """Answer the question that has waited longest."""
        await self.asked.wait()
        if not len(self.waiting):
            self.asked.clear()
            return
        asker, question = self.waiting.take()
        try:
            await self.answer_one(asker, question)
        except Exception as error:  # noqa: BLE001 (a page waits for an answer to each question)
            await self.failed(error, question)

    async def answer_one(self, asker: Page, question: Question) -> None:
        """Do what is asked, or let it be prepared first. What is saved is what was asked before: it
        waits for what is being prepared."""
        if question.verb == "save" and self.prepared:
            self.prepare_next(asker, question)
            await self.send(Replies(everybody=[busy_frame(0, SAVES_THEN)]))
            return
        preparation = await self.at_desk(self.desk.preparation, question)
        if preparation is None:
            await self.replied(await self.at_desk(self.desk.do, question), asker)
            return
        self.prepare_next(asker, preparation)
        busy = busy_frame(question.number, preparation.words)
        await self.send(Replies(everybody=[busy]))

    def prepare_next(self, asker: Page, wanted: Preparation | Question) -> None:
        """Let something be prepared, or done, after what is being prepared already."""
        self.prepared += 1
        self.preparations.put_nowait((asker, wanted))

    async def prepare(self) -> None:
        """Prepare what takes time beside the desk, and let the desk do it then."""
        loop = asyncio.get_running_loop()
        asker, wanted = await self.preparations.get()
        try:
            if isinstance(wanted, Question):
                done = await self.at_desk(self.desk.do, wanted)
            else:
                found = await loop.run_in_executor(self.preparing, wanted.made)
                done = await self.at_desk(self.study.prepared, wanted, found)
            await self.replied(done, asker)
        finally:
            self.prepared -= 1

    async def replied(self, replies: Replies, asker: Page) -> None:
        """Send replies, and begin what is to be done for who asked."""
        await self.send(replies, asker)
        if replies.study is not None:
            await self.open_study(replies.study, asker)
        if replies.work is not None:
            self.begin(asker, replies.work)
        if replies.film_ends:
            self.films.end_for(asker)
        if replies.run_ends:
            self.runs.stop()
        if replies.run is not None and not self.runs.begin(replies.run):
            await self.send(Replies(asker=[fault_frame(None, BUSY)]), asker)
        if replies.film is not None and asker in self.pages:
            self.films.begin(asker, replies.film)

    async def open_study(self, path: Path, asker: Page) -> None:
        """Open a study in the place of what is open; the pages come to it by themselves."""
        try:
            self.desk = await self.at_desk(Desk, str(path))
        except WorkbenchError as error:
            await self.send(Replies(asker=[fault_frame(None, str(error))]), asker)
            return
        self.start()
        await self.send(Replies(everybody=[packed({"kind": "moved"})]))

    def begin(self, page: Page, work: Job) -> None:
        """Let another thread do something for a page, in the place of what is of the same
        kind."""
        self.works = [(one, w) for one, w in self.works if (one, w.kind) != (page, work.kind)]
        self.works.append((page, work))
        self.begun.set()

    async def run_jobs(self) -> None:
        """Do what pages have asked for that takes long, piece by piece and in turn."""
        loop = asyncio.get_running_loop()
        await self.begun.wait()
        if not self.works:
            self.begun.clear()
            return
        page, work = self.works.pop(0)
        if work.generation not in (None, self.study.generation) or page not in self.pages:
            return
        made = await loop.run_in_executor(self.jobs, work_made, work)
        for frame in made.frames:
            page.put(frame)
        newer = any((one, w.kind) == (page, work.kind) for one, w in self.works)
        if made.more is not None and not newer:
            self.works.append((page, made.more))

    async def judge(self) -> None:
        """Judge each state that rests."""
        await self.changed.wait()
        self.changed.clear()
        await asyncio.sleep(IDLE)
        if self.changed.is_set():
            return
        asked = await self.at_desk(self.study.judgement)
        loop = asyncio.get_running_loop()
        found = await loop.run_in_executor(self.judging, asked.made)
        await self.send(Replies(everybody=await self.at_desk(self.study.take, asked, found)))
        if asked.opened.moving is not None:
            await self.judge_motions(asked)
        if asked.following.there:
            self.rested.set()

    async def judge_motions(self, asked: Judgement) -> None:
        """Judge the motions of a state one after the other, until it is another one."""
        loop = asyncio.get_running_loop()

        def go_on() -> None:
            if self.changed.is_set() or self.ended:
                raise SupersededError

        motions = asked.motions(go_on)
        while not self.changed.is_set():
            found = await loop.run_in_executor(self.judging, next, motions, None)
            if found is None:
                return
            frames = await self.at_desk(self.study.take_motions, asked, found)
            await self.send(Replies(everybody=frames))

    async def settle(self) -> None:
        """Settle the people of a population in each state that rests, until it is another one."""
        loop = asyncio.get_running_loop()
        await self.rested.wait()
        self.rested.clear()
        asked = await self.at_desk(self.study.judgement)
        people = asked.following
        refused = await loop.run_in_executor(self.settling, people.begin)
        for number in range(len(people.pieces)):
            if self.superseded() or refused is not None:
                break
            state = asked.arrangement, asked.generation, self.superseded
            settle = partial(people.settle, number, *state)
            refused = await loop.run_in_executor(self.settling, settle)
            if refused is None and not self.superseded():
                repaint = partial(people.map, number, *state[:2], whole=True)
                await loop.run_in_executor(self.settling, repaint)
            await self.send(Replies(everybody=self.people_frames(asked)))
        for number in range(people.at_hand):
            if not self.superseded() and refused is None and asked.seat is not None:
                await loop.run_in_executor(self.settling, people.remember, number, asked.seat)
        if refused is not None:
            await self.send(Replies(everybody=[refused]))

    def superseded(self) -> bool:
        """Whether another state is to be judged, or has been since the last look."""
        return self.changed.is_set() or self.rested.is_set() or self.ended

    async def follow(self) -> None:
        """Follow each change with the people who are at hand: what is known of them at once, the
        maps of what they reach, and what must be searched for; of a drag the newest counts."""
        loop = asyncio.get_running_loop()
        await self.moved.wait()
        self.moved.clear()
        asked = await self.at_desk(self.study.judgement)
        people = asked.following
        sent = 0.0
        state = asked.arrangement, asked.generation
        steps: tuple[Callable[..., object], ...] = (
            partial(people.follow, search=False),
            partial(people.map, whole=False),
            partial(people.follow, search=True),
        )
        turns = people.turns
        for step, some in product(steps, turns):
            work = [partial(step, number, *state) for number in some]
            await asyncio.gather(*(loop.run_in_executor(self.following, one) for one in work))
            if self.moved.is_set():
                break
            if some is turns[-1] or loop.time() - sent > OFTEN:
                sent = loop.time()
                await self.send(Replies(everybody=self.people_frames(asked)))

    async def see(self) -> None:
        """Judge what is seen in each change, also while something is dragged; of a drag the newest
        counts, once all criteria have had their turn."""
        loop = asyncio.get_running_loop()
        await self.looked.wait()
        self.looked.clear()
        asked = await self.at_desk(self.study.judgement)
        sights = asked.sights()
        while frame := await loop.run_in_executor(self.seeing, next, sights, None):
            await self.send(Replies(everybody=[frame]))

    def people_frames(self, asked: Judgement) -> list[bytes]:
        """What is known of a population in a state; nothing where the state is another by now."""
        if asked.generation != self.study.generation:
            return []
        return asked.following.frames(asked.generation)

    async def watch(self) -> None:
        """Look at the study's file from time to time."""
        await asyncio.sleep(WATCH)
        await self.send(await self.at_desk(self.study.watched))

    async def send(self, replies: Replies, asker: Page | None = None) -> None:
        """Send frames to all pages, and to the one that asked."""
        for page in self.pages:
            own = replies.asker if page is asker else []
            for frame in (*replies.everybody, *own):
                page.put(frame)
        if replies.changed:
            for one in (self.changed, self.moved, self.looked):
                one.set()

    async def serve_socket(self, opened: WebSocket) -> None:
        """Serve one page as long as it is open."""
        if SUBPROTOCOL not in opened.scope.get("subprotocols", ()):
            await opened.close(4400, "reload the page: it is of another version")
            return
        await opened.accept(SUBPROTOCOL)
        page = Page(opened)
        delivering = asyncio.create_task(self.deliver(page, opened))
        try:
            await self.talk(page, opened)
        except (WebSocketDisconnect, RuntimeError):
            return
        except PageClosedError as error:
            await closed(opened, error)
        finally:
            self.pages.discard(page)
            self.waiting.forget(page)
            self.films.stop(page)
            delivering.cancel()

    async def deliver(self, page: Page, opened: WebSocket) -> None:
        """Send a page its frames, as long as it takes them."""
        try:
            await page.deliver()
        except (WebSocketDisconnect, RuntimeError):
            return
        except PageClosedError as error:
            self.pages.discard(page)
            await closed(opened, error)

    async def talk(self, page: Page, opened: WebSocket) -> None:
        """Greet a page, and take its questions. What all pages are told begins with its greeting,
        without which it could make nothing of an answer."""
        for made in (self.desk.greeting, self.desk.state):
            await self.show(page, made)
        if self.runs.frame is not None:
            page.put(self.runs.frame)
        self.changed.set()
        while True:
            await self.listen(page, opened)

    async def show(self, page: Page, made: Callable[[], list[bytes]]) -> None:
        """Send frames to a page that was just opened; a fault where they cannot be made."""
        try:
            frames = await self.at_desk(made)
        except Exception as error:  # noqa: BLE001 (the page is there, and may undo what failed)
            self.pages.add(page)
            await self.failed(error)
            return
        for frame in frames:
            page.put(frame)
        self.pages.add(page)

    async def listen(self, page: Page, opened: WebSocket) -> None:
        """Take one question of a page."""
        message = await opened.receive()
        if message["type"] == "websocket.disconnect" or page not in self.pages:
            raise WebSocketDisconnect(message.get("code", 1000))
        page.count(asyncio.get_running_loop().time())
        text = message.get("text")
        question = None
        try:
            question = parsed(
                text if text is not None else message.get("bytes") or b"", self.desk.verbs
            )
            if question.again and question.number in self.known:
                page.put(packed({"kind": "known", "answers": question.number}))
                return
            self.waiting.put(page, question)
        except InputError as error:
            page.put(fault_frame(question, str(error)))
            return
        self.known.append(question.number)
        self.asked.set()


def packed_text(view: WebView) -> str:
    """A picture, packed as on a page of a report."""
    packing = Packing()
    packing.add(view)
    return packing.text()


async def closed(opened: WebSocket, error: PageClosedError) -> None:
    """Close a page and say why, as far as it hears that."""
    try:
        await asyncio.wait_for(opened.close(error.code, str(error)), CLOSING)
    except (WebSocketDisconnect, RuntimeError, TimeoutError):
        return


def live_application(
    desk: AnyDesk,
    *,
    port: int,
    token: str,
    runner: Runner,
    ended: Callable[[str], None] | None = None,
) -> Application:
    """Build the application that serves a desk, with the guard around it.

    Parameters
    ----------
    port
        At which it is served.
    token
        The secret of its address.
    runner
        Runs a study and writes its report.
    ended
        Is told at the end, in words, where that was kept which was not saved; "" where all was. None
        to keep nothing.
    """
    hub = Hub(desk, runner)
    folder = files("workbench.live") / "page"
    pages = {name: (folder / name).read_bytes() for name in PAGE}
    viewer = {name: (files("workbench.draw.web") / name).read_bytes() for name in VIEW}

    async def page(request: Request) -> Response:
        name = request.path_params.get("name", hub.desk.page)
        if name not in pages:
            return Response("There is no such file.", 404, media_type="text/plain")
        return Response(pages[name], media_type=PAGE[name])

    async def view(request: Request) -> Response:
        name = request.path_params["name"]
        if name not in viewer:
            return Response("There is no such file.", 404, media_type="text/plain")
        return Response(viewer[name], media_type=VIEW[name])

    async def scene(request: Request) -> Response:
        try:
            view = await hub.at_desk(lambda: hub.desk.scene())
            # a million triangles take seconds, in which the desk must answer
            return Response(await asyncio.to_thread(packed_text, view), media_type="text/plain")
        except WorkbenchError as error:
            return Response(str(error), 409, media_type="text/plain")

    async def film(request: Request) -> Response:
        path = hub.films.path(request.path_params["name"])
        if path is None:
            return Response("There is no such film any more.", 404, media_type="text/plain")
        return FileResponse(path, media_type=FILM[path.suffix])

    async def report(request: Request) -> Response:
        path = hub.runs.path(request.path_params["name"])
        if path is None or not path.is_file():
            return Response("There is no such report any more.", 404, media_type="text/plain")
        return FileResponse(path, headers={"content-security-policy": REPORT})

    async def icon(request: Request) -> Response:
        return Response(pages["icon.svg"], media_type=PAGE["icon.svg"])

    async def ask(opened: WebSocket) -> None:
        await hub.serve_socket(opened)

    @asynccontextmanager
    async def running(app: Starlette) -> AsyncIterator[None]:
        hub.start()
        try:
            yield
        finally:
            await hub.stop()
            if ended is not None:
                ended(hub.desk.keep())

    routes = [
        Route("/", page),
        Route("/favicon.ico", icon),
        Route("/page/{name}", page),
        Route("/view/{name}", view),
        Route("/scene", scene),
        Route("/film/{name}", film),
        Route("/report/{name:path}", report),
        WebSocketRoute("/ws", ask),
    ]
    return Guard(Starlette(routes=routes, lifespan=running), port=port, token=token)


def serve(
    desk: AnyDesk,
    *,
    port: int = 0,
    ready: Callable[[str], None],
    runner: Runner,
    ended: Callable[[str], None] | None = None,
) -> None:
    """Serve a desk at 127.0.0.1 until the program is stopped.

    Parameters
    ----------
    port
        At which it is served; one that is free if 0.
    ready
        Is given the address to open, with its token.
    runner, ended
        As of `live_application`.

    Raises
    ------
    InputError
        If the port is taken.
    """
    sys.setswitchinterval(SWITCH)
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as bound:
        if os.name == "posix":  # elsewhere it lets two programs have one port
            bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            bound.bind(("127.0.0.1", port))
        except (OSError, OverflowError) as error:
            raise InputError(f"port {port} cannot be had: {error}") from None
        bound.listen()  # who opens the address at once waits, and is not refused
        taken = int(bound.getsockname()[1])
        token = secrets.token_urlsafe(32)
        # one line holds all cookies of this machine; `websockets` takes 8 KB where it is not told so
        os.environ.setdefault("WEBSOCKETS_MAX_LINE_LENGTH", str(LONGEST_HEADERS))
        settings = uvicorn.Config(
            live_application(desk, port=taken, token=token, runner=runner, ended=ended),
            log_level="warning",
            access_log=False,
            lifespan="on",
            http=bounded_connections(),
            h11_max_incomplete_event_size=LONGEST_HEADERS,
            backlog=BACKLOG,
            ws="websockets-sansio",
            ws_max_size=2 * LONGEST,
            server_header=False,
            timeout_graceful_shutdown=2,
        )
        ready(f"http://127.0.0.1:{taken}/?token={token}")
        uvicorn.Server(settings).run(sockets=[bound])
