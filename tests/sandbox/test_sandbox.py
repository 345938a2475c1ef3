"""What every isolation level must do: ask, answer, and outlive whatever the code in the sandbox does instead of answering."""

from __future__ import annotations

import itertools
import os
import signal
import sys
from pathlib import Path

import numpy as np
import pytest

from grader.base.errors import Crashed, GraderError, Malformed, TimedOut
from grader.sandbox import sandbox as sandbox_module
from grader.sandbox.plan import Contents
from grader.sandbox.sandbox import Sandbox, Worker

from .conftest import WORKER_CODE, run


def on_the_line(source: str) -> str:
    """Source that runs with `line`, the descriptor of the worker's socket, found as hostile code would find it."""
    return (
        "import os, stat, struct, threading\n"
        "def is_socket(fd):\n"
        "    try:\n"
        "        return stat.S_ISSOCK(os.fstat(fd).st_mode)\n"
        "    except OSError:\n"
        "        return False\n"
        "line = next(fd for fd in range(3, 100) if is_socket(fd))\n" + source
    )


@pytest.mark.plain
def test_a_question_is_answered_an_exception_told_and_nothing_read_from_standard_input(worker: Worker) -> None:
    frame = worker.ask("echo", {"a": [1, "é"]}, {"x": np.arange(6.0).reshape(2, 3)})
    assert frame.fields == {"a": [1, "é"]}
    np.testing.assert_array_equal(frame.arrays["x"], [[0, 1, 2], [3, 4, 5]])
    assert worker.alive
    assert run(worker, "x = 1\nraise KeyError('gone')") == {"error": "KeyError", "message": "'gone'", "line": 2}
    assert run(worker, "input()")["error"] == "EOFError"
    assert run(worker, "result = 7") == {"result": 7}


def test_large_arrays_pass_in_both_directions(anyone: Worker) -> None:
    array = np.arange(3_500_000.0)
    np.testing.assert_array_equal(anyone.ask("echo", arrays={"x": array}).arrays["x"], array)


def test_an_endless_loop_that_ignores_every_signal_ends_at_its_cpu_deadline(worker: Worker) -> None:
    ignore = (
        "import signal\nfor s in range(1, 65):\n    try: signal.signal(s, signal.SIG_IGN)\n    except Exception: pass\n"
    )
    with pytest.raises(TimedOut, match=r"no answer within 0\.2 s of CPU time") as caught:
        run(worker, ignore + "while True: pass", cpu_s=0.2)
    assert 0.2 <= caught.value.cpu_s < 1.0
    assert not worker.alive


def test_a_sleeper_ends_at_its_wall_deadline(worker: Worker) -> None:
    with pytest.raises(TimedOut, match=r"no answer within 0\.2 s$") as caught:
        run(worker, "import time; time.sleep(1000)", wall_s=0.2)
    assert caught.value.wall_s >= 0.2
    assert caught.value.cpu_s < 0.2


def test_a_worker_that_stops_reading_ends_at_its_deadline(anyone: Worker) -> None:
    stop = "import os, signal, time\ndef stop(*_):\n    os.write(1, b'stopped')\n    time.sleep(1000)\n"
    run(anyone, stop + "signal.signal(signal.SIGALRM, stop)\nsignal.setitimer(signal.ITIMER_REAL, 0.1)")
    while "stopped" not in anyone.printed():
        pass
    with pytest.raises(TimedOut):
        anyone.ask("echo", arrays={"x": np.zeros(3_500_000)}, wall_s=0.2)
    assert not anyone.alive


@pytest.mark.parametrize(
    ("source", "told"),
    [
        ("import os; os._exit(0)", "exit code 0 "),
        ("import os; os._exit(3)", "exit code 3 "),
        ("import ctypes; ctypes.string_at(0)", "SIGSEGV"),
        (on_the_line("os.close(line)"), "exit code 1 "),
    ],
)
def test_an_end_without_an_answer_is_a_crash_whatever_the_exit_code(worker: Worker, source: str, told: str) -> None:
    with pytest.raises(Crashed, match=told):
        run(worker, source)


@pytest.mark.parametrize("error", ["SystemExit(0)", "KeyboardInterrupt()"])
def test_what_slips_past_the_worker_code_is_no_answer(anyone: Worker, error: str) -> None:
    with pytest.raises(Malformed, match=error.split("(", maxsplit=1)[0]):
        run(anyone, f"raise {error}")
    assert not anyone.alive


def test_a_question_that_cannot_be_sent_is_our_fault_and_harms_nobody(anyone: Worker) -> None:
    with pytest.raises(GraderError, match="cannot be sent"):
        anyone.ask("echo", {"x": object()})
    assert run(anyone, "result = 1") == {"result": 1}


@pytest.mark.parametrize(
    ("rises", "source", "kind", "text"),
    [
        (False, "os.kill(os.getpid(), 9)", Crashed, "ended by SIGKILL"),
        (True, "os.kill(os.getpid(), 9)", GraderError, "out of memory"),
        (True, "os._exit(3)", Crashed, "exit code 3 "),
    ],
)
def test_only_a_kill_for_lack_of_memory_is_no_crash_of_the_code(
    rises: bool, source: str, kind: type[Exception], text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    counts = itertools.count() if rises else itertools.repeat(7)
    monkeypatch.setattr(sandbox_module, "_oom_kills", lambda: next(counts))
    plain = Sandbox(Contents(WORKER_CODE), isolation_level="none")
    with plain as sandbox, sandbox.worker() as worker, pytest.raises(kind, match=text):
        run(worker, f"import os\n{source}")


@pytest.mark.skipif(sys.platform != "linux", reason="the kernel of Linux keeps this counter")
def test_a_counter_that_linux_keeps_is_read() -> None:
    assert f"oom_kill {sandbox_module._oom_kills()}\n" in Path("/proc/vmstat").read_text()


# Printed text ---------------------------------------------------------------------------------------------------------


def test_printed_text_is_kept_in_order_even_after_a_crash(worker: Worker) -> None:
    source = "import os, sys\nprint('one')\nprint('two', file=sys.stderr)\nos.write(1, b'three\\n')\nos._exit(1)"
    with pytest.raises(Crashed):
        run(worker, source)
    assert worker.printed() == "one\ntwo\nthree\n"
    worker.close()
    assert worker.printed() == "one\ntwo\nthree\n"


# The protocol ---------------------------------------------------------------------------------------------------------


OTHER_NONCE = b'{"fields": {"fields": {"result": 1}}, "arrays": []}'


@pytest.mark.parametrize(
    ("junk", "told"),
    [
        ("b'garbage' * 20", "bytes of JSON"),
        ("struct.pack('<II16s', 2, 0, bytes(16)) + b'{}'", "a frame holds fields and arrays"),
        (f"struct.pack('<II16s', {len(OTHER_NONCE)}, 0, b'n' * 16) + {OTHER_NONCE!r}", "another question"),
    ],
)
def test_bytes_that_are_no_answer_to_the_question_end_the_worker(anyone: Worker, junk: str, told: str) -> None:
    with pytest.raises(Malformed, match=told):
        run(anyone, on_the_line(f"os.write(line, {junk})"))
    assert not anyone.alive


def test_an_answer_ahead_of_its_question_is_refused(anyone: Worker) -> None:
    late = "import time\ndef after():\n    time.sleep(0.1)\n    os.write(line, b'x' * 64)\n    os.write(1, b'sent')\n"
    run(anyone, on_the_line(late + "threading.Thread(target=after, daemon=True).start()"))
    while "sent" not in anyone.printed():
        pass
    with pytest.raises(Malformed, match="before its question"):
        run(anyone, "result = 1")


def test_half_an_answer_ends_at_the_deadline(anyone: Worker) -> None:
    source = "import time\nos.write(line, struct.pack('<II16s', 100, 0, bytes(16)) + b'{')\ntime.sleep(1000)"
    with pytest.raises(TimedOut):
        run(anyone, on_the_line(source), wall_s=0.2)


# From one worker to the next ------------------------------------------------------------------------------------------


def test_nothing_of_one_worker_is_left_for_the_next(sandbox: Sandbox) -> None:
    leave = "import os, sys, json\nopen('left', 'w').close()\nos.makedirs('a/b')\nos.environ['LEFT'] = '1'\n"
    with sandbox.worker() as first:
        run(first, leave + "sys.modules['left'] = json\njson.loads = None\nnp.zeros = None")
    look = "import os, sys, json\n"
    with sandbox.worker() as second:
        found = run(
            second,
            look + "result = [os.listdir('.'), 'LEFT' in os.environ, 'left' in sys.modules, json.loads is None,"
            " np.zeros is None]",
        )
    assert found == {"result": [[], False, False, False, False]}


def test_the_environment_holds_nothing_of_the_graders(sandbox: Sandbox, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("IMUGRADE_SEED", "hidden")
    with (
        Sandbox(Contents(WORKER_CODE), isolation_level=sandbox.isolation_level.name) as fresh,
        fresh.worker() as worker,
    ):
        found = run(worker, "import os; result = dict(os.environ)")["result"]
    assert "hidden" not in found.values()
    assert found["OPENBLAS_NUM_THREADS"] == "1"


# Beginning and end ----------------------------------------------------------------------------------------------------


def test_a_closed_worker_is_gone_at_once(sandbox: Sandbox) -> None:
    with sandbox.worker() as worker:
        pid = worker._process._pid if sandbox.isolation_level.isolates else worker._process._popen.pid  # type: ignore[attr-defined]
        os.kill(pid, 0)
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_worker_code_that_fails_to_start_is_our_fault_and_says_why(sandbox: Sandbox, tmp_path: Path) -> None:
    (tmp_path / "__init__.py").write_text("def warm_up(thorough):\n    raise LookupError('no such lab')\n")
    with (
        Sandbox(Contents(tmp_path), isolation_level=sandbox.isolation_level.name) as broken,
        pytest.raises(GraderError, match="no such lab"),
    ):
        broken.worker()


def test_a_killed_zygote_takes_its_workers_along_and_comes_back(isolating_sandbox: Sandbox) -> None:
    with Sandbox(Contents(WORKER_CODE), isolation_level=isolating_sandbox.isolation_level.name) as fragile:
        with fragile.worker() as worker:
            os.kill(fragile._zygote.pid, signal.SIGKILL)  # type: ignore[union-attr]
            with pytest.raises(GraderError, match="the sandbox is gone"):
                run(worker, "while True: pass")
        with fragile.worker() as again:
            assert run(again, "result = 1") == {"result": 1}
