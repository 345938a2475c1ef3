"""A zygote (the parent process): isolates itself, imports everything once, then forks a worker whenever the grader asks for one.

The control socket keeps message boundaries. Its other end is the grader's; when that closes, the zygote and its workers end.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import select
import signal
import socket
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from . import confine, landlock, linux, namespaces, paths, rootfs
from .plan import Plan
from .syscalls import machine

_MAX_MESSAGE = 1 << 20
_FIRST_HIGH_FD = 100  # above what a worker's own descriptors are moved to
_LINE_FD = 3
_GC_THRESHOLDS = (20_000, 5, 10)
"""When a worker looks for cycles: it lives for seconds, and what it collects early is a tenth of a figure's time."""


class _GraderGoneError(Exception):
    """Exception: the other end of the control socket is closed, so everything that the grader started has to end."""


def main(control_fd: int) -> Callable[[], None] | None:
    """Run the zygote (parent process of workers) until the grader closes the socket `control_fd`, then end the process.

    In a worker that it forked, return the function that answers requests. If isolation or an import fails, tell the grader why
    and return None.
    """
    control = socket.socket(fileno=_move_up(control_fd))
    plan = Plan.unpacked(control.recv(_MAX_MESSAGE))
    try:
        return _isolate_and_serve(control, plan)
    except _GraderGoneError:
        if not plan.isolation_level.own_root:
            with contextlib.suppress(OSError):  # the grader may have been faster
                folder = os.path.dirname(plan.cache)
                paths.empty_folder(folder)
                os.rmdir(folder)
        os._exit(0)


def _isolate_and_serve(control: socket.socket, plan: Plan) -> Callable[[], None] | None:
    try:
        if plan.end_with_parent:
            namespaces.die_with_parent()
        confinement = _enter(plan, control)
        _check_confinement(confinement, plan)
    except (OSError, KeyError) as error:
        _tell(control, isolated=False, reason=_reason(error))
        return None
    _tell(control, isolated=True, without_landlock=not confinement.landlock_abi)
    try:
        answer = _warm_up(plan)
    except Exception:
        _tell(control, ready=False, reason=traceback.format_exc(limit=-4)[-4000:])
        return None
    _tell(control, ready=True)
    return _Zygote(control, confinement, plan, answer).serve()


def _move_up(fd: int) -> int:
    import fcntl  # noqa: PLC0415 - of POSIX only, as is everything that uses it

    high = fcntl.fcntl(fd, fcntl.F_DUPFD_CLOEXEC, _FIRST_HIGH_FD)
    os.close(fd)
    return high


def _tell(control: socket.socket, pidfd: int | None = None, **message: Any) -> None:
    try:
        socket.send_fds(control, [json.dumps(message).encode()], [] if pidfd is None else [pidfd])
    except OSError as error:
        raise _GraderGoneError from error


def _reason(error: BaseException) -> str:
    return str(error.args[-1]) if error.args else type(error).__name__


# Isolation ------------------------------------------------------------------------------------------------------------


def _enter(plan: Plan, control: socket.socket) -> confine.Confinement:
    """Isolate the zygote, and return what each worker needs for its own isolation; raise OSError if the kernel refuses.

    If workers get namespaces, the process forks and the child continues as pid 1.
    """
    if plan.isolation_level.own_namespaces:
        return _enter_full(plan, control)
    version = landlock.abi()
    if not version:
        raise OSError("the kernel has no Landlock")
    readable, listed = (["/"], []) if plan.isolation_level.own_root else _landlock_paths(plan)
    rules = ((scratch, _move_up(landlock.ruleset(version, readable, listed, [scratch]))) for scratch in plan.scratch)
    return confine.Confinement(plan.isolation_level, machine(), version, tuple(rules), _open_proc(), os.getpid())


def _landlock_paths(plan: Plan) -> tuple[list[str], list[str]]:
    """Return what Landlock lets workers read, and which folders it lets them list, where the host's root stays the root."""
    whole, split = paths.shown_and_listed(paths.mount_steps(plan.visible, plan.hidden))
    return [*whole, *plan.code, *rootfs.copies(plan).values()], split


def _open_proc() -> int:
    """Return a descriptor of /proc, by which workers use it after it is unmounted; -1 if there is no /proc."""
    try:
        return _move_up(os.open("/proc", os.O_PATH | os.O_DIRECTORY | os.O_CLOEXEC))
    except OSError:
        return -1


def _enter_full(plan: Plan, control: socket.socket) -> confine.Confinement:
    os.umask(0o022)
    proc = _open_proc()
    fonts = _contents(plan.fonts)
    if namespaces.may_drop_root():
        linux.unshare(linux.CLONE_NEWNS)
        _build_root(plan)
        namespaces.enter_as_root()
        namespaces.write_maps(proc, namespaces.DROPPED_ID, namespaces.DROPPED_ID)
    else:
        uid, gid = os.geteuid(), os.getegid()
        namespaces.enter_as_user()
        namespaces.write_maps(proc, uid, gid)
        _build_root(plan)
    sys.modules[__package__ or ""].__path__ = [rootfs.SANDBOX]
    for name, data in fonts:
        with open(f"{rootfs.CACHE}/{name}", "xb") as file:
            file.write(data)
    _become_first(control)
    return confine.Confinement(plan.isolation_level, machine(), landlock.abi(), (), proc, 0)


def _build_root(plan: Plan) -> None:
    rootfs.enter_new_root()
    rootfs.fill_root(plan.visible, plan.hidden, plan.code, rootfs.copies(plan))
    rootfs.close_root()


def _contents(files: tuple[str, ...]) -> list[tuple[str, bytes]]:
    found = []
    for path in files:
        with contextlib.suppress(OSError), open(path, "rb") as file:
            found.append((os.path.basename(path), file.read()))
    return found


def _become_first(control: socket.socket) -> None:
    """Fork, so that the child is pid 1 of the new pid namespace and goes on; this process waits for it and ends as it does."""
    pid = os.fork()
    if pid == 0:
        namespaces.die_with_parent()
        return
    control.close()
    _, status = os.waitpid(pid, 0)
    os._exit(min(abs(os.waitstatus_to_exitcode(status)), 255))


def _check_confinement(confinement: confine.Confinement, plan: Plan) -> None:
    """Confine a child process as a worker and check the isolation from inside; raise OSError with what did not hold."""
    reader, writer = os.pipe()
    own = _own_pid_namespace(confinement)
    pid = namespaces.fork_as_first(own) if own >= 0 else os.fork()
    if pid == 0:
        os.dup2(writer, _LINE_FD)
        os._exit(_run_check(confinement, plan))
    os.close(writer)
    with open(reader, "rb") as report:
        reason = report.read()
    _, status = os.waitpid(pid, 0)
    if own >= 0:
        os.close(own)
    if not reason and os.waitstatus_to_exitcode(status) == -signal.SIGKILL:
        os._exit(128 + signal.SIGKILL)  # the isolation kills nothing; the grader tries the same level again
    if reason != b"held":
        raise OSError(reason.decode(errors="replace") or "an isolated worker ended without a word")


def _run_check(confinement: confine.Confinement, plan: Plan) -> int:
    try:
        confine.confine(confinement, plan.scratch[0])
        confine.check_isolation(plan.decoy)
    except BaseException as error:
        os.write(_LINE_FD, _reason(error).encode(errors="replace"))
        return 1
    os.write(_LINE_FD, b"held")
    return 0


def _own_pid_namespace(confinement: confine.Confinement) -> int:
    return _move_up(os.pidfd_open(os.getpid())) if confinement.isolation_level.own_namespaces else -1


# Imports --------------------------------------------------------------------------------------------------------------


def _warm_up(plan: Plan) -> Any:
    """Import everything once, so that workers need not, and return the worker code's function that answers requests."""
    sys.path[:] = plan.search  # packages may lie where only the grader's own environment says
    copies = rootfs.copies(plan)
    folders = list(copies if plan.isolation_level.own_root else copies.values())
    with _imports_frozen():
        from .imports import import_where_they_are, load_worker_code  # noqa: PLC0415 - they pull numpy, which must come after the isolation

        worker_code = load_worker_code(folders, plan.search, thorough=plan.thorough)
        import_where_they_are(plan.warm)
    gc.set_threshold(*_GC_THRESHOLDS)
    if plan.isolation_level.own_namespaces:
        rootfs.freeze_cache()
    return worker_code


@contextlib.contextmanager
def _imports_frozen() -> Iterator[None]:
    """Disable garbage collection during imports and keep what they created out of later collections.

    Nearly all of it is permanent; searching it for garbage takes a tenth of the imports' time.
    """
    gc.disable()
    yield
    gc.freeze()  # so that a collection in a worker does not copy the zygote's pages
    gc.enable()
    tempfile.tempdir = None  # a worker finds its own


# Workers --------------------------------------------------------------------------------------------------------------


@dataclass
class _Child:
    """A worker that the zygote forked: its number in messages of the grader, its process, and its scratch folder."""

    number: int
    pid: int
    pidfd: int
    scratch: str


class _Zygote:
    """The zygote after its imports: forks workers on request and reports their ends, until the grader hangs up."""

    def __init__(self, control: socket.socket, confinement: confine.Confinement, plan: Plan, answer: Any) -> None:
        self._control = control
        self._confinement = confinement
        self._plan = plan
        self._answer = answer
        self._own = _own_pid_namespace(confinement)
        confine.seccomp_program(confinement, 1)  # most workers are pid 1: they find it ready
        self._warm = {*plan.warm}
        self._children: dict[int, _Child] = {}
        self._poll = select.poll()
        self._poll.register(control, select.POLLIN)

    def serve(self) -> Callable[[], None] | None:
        try:
            return self._serve()
        except _GraderGoneError:
            self._end_children()
            raise

    def _serve(self) -> Callable[[], None] | None:
        while True:
            for fd, _ in self._poll.poll():
                if fd in self._children:
                    self._reap(self._children.pop(fd))
                    continue
                message, fds = self._next()
                asked = json.loads(message)
                self._import(asked["warm"])
                work = self._spawn(asked["spawn"], fds)
                if work is not None:
                    return work

    def _next(self) -> tuple[bytes, list[int]]:
        try:
            message, fds, _, _ = socket.recv_fds(self._control, _MAX_MESSAGE, 2)
        except OSError as error:
            raise _GraderGoneError from error
        if not message:
            raise _GraderGoneError
        return message, list(fds)

    def _import(self, modules: list[str]) -> None:
        """Import those of `modules` that are new, before the first worker that needs them; all later workers have them, too."""
        from .imports import import_where_they_are  # noqa: PLC0415 - see _warm_up

        if new := [name for name in modules if name not in self._warm]:
            with _imports_frozen():
                import_where_they_are(new)
            self._warm.update(new)

    def _spawn(self, number: int, fds: list[int]) -> Callable[[], None] | None:
        """Fork worker `number`. Return its work in the child, None in the zygote; a failure is told to the grader."""
        scratch = self._free_scratch()
        try:
            if scratch is None:
                raise OSError(f"more than {len(self._plan.scratch)} workers at a time")
            pid = namespaces.fork_as_first(self._own) if self._own >= 0 else os.fork()
        except OSError as error:
            _tell(self._control, failed=number, reason=_reason(error))
            scratch, pid = None, -1
        if pid == 0 and scratch is not None:
            self._control.detach()  # close_from will close it; a second close would hit a stranger
            return partial(_work, fds[0], fds[1], self._confinement, scratch, self._answer)
        for fd in fds:
            os.close(fd)
        if scratch is not None:
            self._track(_Child(number, pid, os.pidfd_open(pid), scratch))
        return None

    def _free_scratch(self) -> str | None:
        if self._confinement.isolation_level.own_namespaces:
            return rootfs.SCRATCH  # every worker mounts its own there
        taken = {child.scratch for child in self._children.values()}
        return next((folder for folder in self._plan.scratch if folder not in taken), None)

    def _track(self, child: _Child) -> None:
        """Watch a worker's process for its end, and tell the grader that it has started."""
        self._children[child.pidfd] = child
        self._poll.register(child.pidfd, select.POLLIN)
        _tell(self._control, child.pidfd, spawned=child.number)

    def _reap(self, child: _Child) -> None:
        """Collect a worker that has ended, empty its folder, and tell the grader its exit code and CPU time."""
        self._poll.unregister(child.pidfd)
        os.close(child.pidfd)
        _, status, used = os.wait4(child.pid, 0)
        if not self._confinement.isolation_level.own_namespaces:
            paths.empty_folder(child.scratch)
        code = os.waitstatus_to_exitcode(status)
        _tell(self._control, ended=child.number, code=code, cpu_s=used.ru_utime + used.ru_stime)

    def _end_children(self) -> None:
        for child in self._children.values():
            with contextlib.suppress(ProcessLookupError):
                signal.pidfd_send_signal(child.pidfd, signal.SIGKILL)
            os.waitpid(child.pid, 0)


def _work(line_fd: int, printed_fd: int, confinement: confine.Confinement, scratch: str, answer: Any) -> None:
    """Run a worker in a forked child: attach its socket and output, confine it, answer requests, and exit. Never returns."""
    from . import worker  # noqa: PLC0415 - see _warm_up

    os.dup2(printed_fd, 1)
    os.dup2(printed_fd, 2)
    os.dup2(line_fd, _LINE_FD)
    line = socket.socket(fileno=_LINE_FD)
    try:
        confine.confine(confinement, scratch)
    except Exception as error:
        worker.refuse_questions(line, _reason(error))
        os._exit(1)
    os.environ.pop("PWD", None)  # bubblewrap sets it
    os.environ.update(HOME=scratch, TMPDIR=scratch)
    sys.argv[:] = [""]
    worker.take_streams()
    worker.run(line, answer)
    os._exit(0)
