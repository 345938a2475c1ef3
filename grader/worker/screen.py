"""Headless matplotlib backend that mimics a GUI backend and draws no pixels, so that a live plot can be judged.

While `Screen.installed` is entered, each way of showing a figure (draw, draw_idle, flush_events, blit, pause, show, a saved frame,
an animation) calls a callback, and timers and animations run as in the event loop of a GUI.
"""

from __future__ import annotations

import contextlib
import io
import time
import weakref
from collections.abc import Callable, Iterator
from typing import Any

from . import drawing

_MAX_FIRINGS = 2000
_LAST_FRAMES = 3

Seen = Callable[[Any], None]
Done = Callable[[], bool]


class Screen:
    """Replacement of matplotlib's canvas, timers and animations that reports each figure shown by a student's program.

    Parameters
    ----------
    seen : called with the figure whenever something is shown
    done : returns whether enough was seen; the event loop then ends after a few more frames
    """

    def __init__(self, seen: Seen, done: Done) -> None:
        self._seen, self._done = seen, done
        self._timers: list[Any] = []
        self._animations: list[weakref.ref[Any]] = []
        self._depth = 0

    # --- showing -------------------------------------------------------------------------------------------------------

    def show_figure(self, canvas: Any) -> None:
        """Pass a canvas's figure to this screen's callback `seen`; send a draw event; draw no pixels. Ignore a 6th nested call."""
        from matplotlib.backend_bases import DrawEvent

        if self._depth > 4:
            return
        self._depth += 1
        try:
            canvas.renderer = canvas.get_renderer()
            canvas.figure.stale = False
            self._seen(canvas.figure)
            canvas.callbacks.process("draw_event", DrawEvent("draw_event", canvas, canvas.renderer))
        finally:
            self._depth -= 1

    def show_all(self, *, block: bool) -> None:
        """Do what `plt.show` does: show all open figures; if it blocks, run the event loop to its end and close them."""
        import matplotlib.pyplot as plt

        for figure in open_figures():
            figure.canvas.draw_idle()
        if block:
            self.run()
            plt.close("all")

    def show_animations_left(self) -> None:
        """Show the animations that the program created and did not show itself, as a notebook does, and run the event loop."""
        for reference in self._animations:
            animation = reference()
            if animation is not None and not getattr(animation, "_draw_was_started", True):
                self.show_figure(animation._fig.canvas)
        self.run()

    # --- the event loop ------------------------------------------------------------------------------------------------

    def start_timer(self, timer: Any) -> None:
        if timer not in self._timers:
            self._timers.append(timer)

    def stop_timer(self, timer: Any) -> None:
        if timer in self._timers:
            self._timers.remove(timer)

    def run(self, seconds: float | None = None) -> None:
        """Fire timers up to 2,000 times for `seconds` of virtual time (None: no limit), until none is left or `done()` is true."""
        due = {id(timer): timer.interval / 1000.0 for timer in self._timers}
        now, extra = 0.0, 0
        for _ in range(_MAX_FIRINGS):
            timers = [timer for timer in self._timers if timer.callbacks]
            if not timers or extra > _LAST_FRAMES:
                break
            timer = min(timers, key=lambda one: due.setdefault(id(one), now + one.interval / 1000.0))
            if seconds is not None and due[id(timer)] > seconds:
                break
            time.sleep(max(0.0, due[id(timer)] - now))
            now = due[id(timer)]
            due[id(timer)] = now + timer.interval / 1000.0
            timer._on_timer()
            extra += self._done()

    # --- animations ----------------------------------------------------------------------------------------------------

    def note_animation(self, animation: Any) -> None:
        self._animations.append(weakref.ref(animation))

    def play(self, animation: Any) -> None:
        """Pass the figure to this screen's callback `seen` at each frame of a saved animation, up to about 2,000; make no film."""
        animation._init_draw()
        for number, frame in enumerate(animation.new_saved_frame_seq()):
            animation._draw_next_frame(frame, blit=False)
            self._seen(animation._fig)
            if number >= _MAX_FIRINGS:
                break

    # --- standing ------------------------------------------------------------------------------------------------------

    @contextlib.contextmanager
    def installed(self) -> Iterator[None]:
        """While a block runs, let matplotlib pass figures to this screen's callback `seen` where it would show or save them."""
        import matplotlib.pyplot as plt
        from matplotlib import animation
        from matplotlib.backend_bases import FigureCanvasBase, TimerBase
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        with contextlib.ExitStack() as stack:
            for owner, members in (
                (FigureCanvasAgg, {"draw": _method(self.show_figure)}),
                (FigureCanvasBase, self._canvas()),
                (TimerBase, {"_timer_start": _method(self.start_timer), "_timer_stop": _method(self.stop_timer)}),
                (Figure, {"show": lambda figure, *_, **__: figure.canvas.draw_idle(), "tight_layout": _nothing}),
                (animation.Animation, self._animation(animation.Animation.__init__)),
                (animation.PillowWriter, {"grab_frame": lambda writer, **_: self._seen(writer.fig), "finish": _finish}),
            ):
                stack.enter_context(replaced(owner, members))
            stack.enter_context(replaced(plt, {"show": self._show(), "tight_layout": _nothing}))
            yield

    def _canvas(self) -> dict[str, Any]:
        def start_event_loop(canvas: Any, timeout: float = 0) -> None:
            self._seen(canvas.figure)
            self.run(timeout if timeout > 0 else None)
            time.sleep(max(0.0, timeout))

        def print_figure(canvas: Any, filename: Any, dpi: Any = None, *args: Any, **kwargs: Any) -> None:
            self._seen(canvas.figure)
            bare = kwargs.get("format") in ("raw", "rgba")
            _write(filename, drawing.blank(canvas.figure, dpi) if bare else _one_pixel())

        return {
            "flush_events": lambda canvas: self._seen(canvas.figure),
            "blit": lambda canvas, *_, **__: self._seen(canvas.figure),
            "start_event_loop": start_event_loop,
            "print_figure": print_figure,
        }

    def _animation(self, really_init: Callable[..., None]) -> dict[str, Any]:
        def init(animation: Any, *args: Any, **kwargs: Any) -> None:
            really_init(animation, *args, **kwargs)
            self.note_animation(animation)

        def save(animation: Any, filename: Any, *args: Any, **kwargs: Any) -> None:
            self.play(animation)
            _write(filename, b"GIF89a")

        def to_text(animation: Any, *args: Any, **kwargs: Any) -> str:
            self.play(animation)
            return ""

        return {"__init__": init, "save": save, "to_jshtml": to_text, "to_html5_video": to_text}

    def _show(self) -> Callable[..., None]:
        """Return the replacement of `plt.show`: a plain function, because `plt.switch_backend` sets an attribute of it."""
        import matplotlib.pyplot as plt

        def show(*args: Any, block: bool | None = None, **kwargs: Any) -> None:
            self.show_all(block=not plt.isinteractive() if block is None else bool(block))

        return show


def _method(call: Callable[[Any], None]) -> Callable[..., None]:
    """Return a method that passes its instance alone to `call` and ignores other arguments, to replace one of matplotlib's."""

    def method(instance: Any, *args: Any, **kwargs: Any) -> None:
        call(instance)

    return method


def _nothing(*args: Any, **kwargs: Any) -> None:
    """Stand in for `tight_layout`, which is slow and changes nothing that is reported, and do nothing."""


def open_figures() -> list[Any]:
    """Return all open pyplot figures; unlike `plt.figure(number)`, this leaves the current figure as it is."""
    from matplotlib import _pylab_helpers

    return [manager.canvas.figure for manager in _pylab_helpers.Gcf.get_all_fig_managers()]


def _one_pixel() -> bytes:
    """Return a PNG of one pixel, saved in place of a figure: a readable file for programs that read their picture back."""
    from PIL import Image

    stream = io.BytesIO()
    Image.new("RGB", (1, 1)).save(stream, "png")
    return stream.getvalue()


def _finish(writer: Any) -> None:
    _write(writer.outfile, b"GIF89a")


def _write(target: Any, content: bytes) -> None:
    if hasattr(target, "write"):
        target.write(content)
        return
    with open(target, "wb") as stream:
        stream.write(content)


@contextlib.contextmanager
def replaced(owner: Any, members: dict[str, Any]) -> Iterator[None]:
    """Replace members of a class or module while a block runs; on exit restore them, or remove those that the owner lacked."""
    own = {name: vars(owner)[name] for name in members if name in vars(owner)}
    for name, member in members.items():
        setattr(owner, name, member)
    try:
        yield
    finally:
        for name in members:
            if name in own:
                setattr(owner, name, own[name])
            else:
                delattr(owner, name)
