"""Tests of hostile programs on every level that isolates: each is stopped, and the worker answers if it still can."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import grader
from grader.base.errors import NoAnswer
from grader.sandbox.plan import Contents
from grader.sandbox.sandbox import Sandbox, Worker

from .conftest import WORKER_CODE, run

REFUSED = {"PermissionError", "FileNotFoundError", "BlockingIOError"}
GRADER = Path(grader.__file__).parent


def refused(worker: Worker, source: str) -> bool:
    """Whether the source ends in an error of the kernel's, and the worker goes on."""
    found = run(worker, source)
    assert run(worker, "result = 'well'") == {"result": "well"}
    return found.get("error") in REFUSED or found.get("message", "").startswith(
        ("[Errno 1]", "[Errno 18]", "[Errno 30]")
    )


def opened(path: str) -> str:
    return f"import os; os.close(os.open({path!r}, os.O_RDONLY))"


SOCKETS = (
    ("INET", "STREAM"), ("INET", "DGRAM"), ("INET6", "STREAM"), ("UNIX", "STREAM"), ("NETLINK", "RAW"), ("VSOCK", "STREAM"),
    ("ALG", "SEQPACKET"),
)  # fmt: skip
OWN_FILES = [GRADER / name for name in ("base/errors.py", "engine/results.py", "sandbox/sandbox.py")]
OUTSIDE = (
    "np.__file__ + 'x'",
    "os.__file__",
    "'/tmp/leak'",
    "'../leak'",
    "'/dev/shm/leak'",
    "'/cache/leak'",
    "'/leak'",
)
NOT_ALLOWED = {
    "a process": (
        "import os; os.fork()",
        "import os; os.posix_spawn('/bin/sh', ['sh'], {})",
        "import os; os.execv('/bin/sh', ['sh'])",
        "import subprocess; subprocess.run(['true'])",
        "import multiprocessing as m; m.get_context('fork').Process(target=print).start()",
    ),
    "a socket": [f"import socket; socket.socket(socket.AF_{family}, socket.SOCK_{kind})" for family, kind in SOCKETS],
    "to read the grader": [f"open({str(path.resolve(strict=True))!r}).read()" for path in OWN_FILES],
    "to read files of the kernel and the system": map(
        opened, ("/proc/self/environ", "/proc/1/environ", "/proc/cpuinfo", "/sys/kernel", "/etc/shadow")
    ),
    "to write outside the scratch": [f"import os; open({place}, 'a').write('x')" for place in OUTSIDE],
    "to make a folder outside the scratch": [f"import os; os.makedirs({place} + '.d/e')" for place in OUTSIDE],
}


@pytest.mark.parametrize(
    "source",
    [pytest.param(source, id=f"{what}-{n}") for what, tried in NOT_ALLOWED.items() for n, source in enumerate(tried)],
)
def test_what_is_not_allowed_is_refused(isolated_worker: Worker, source: str) -> None:
    assert refused(isolated_worker, source)


# Files ----------------------------------------------------------------------------------------------------------------


def test_a_file_outside_cannot_be_read_or_changed_by_any_way(isolated_worker: Worker, tmp_path: Path) -> None:
    decoy = tmp_path / "trace.npz"
    decoy.write_text("secret")
    os.chmod(decoy, 0o644)
    assert refused(isolated_worker, f"open({str(decoy)!r}).read()")
    assert refused(isolated_worker, f"import os; os.listdir({str(tmp_path)!r})")
    assert refused(isolated_worker, f"import os; os.symlink({str(decoy)!r}, 'link'); open('link').read()")
    assert refused(isolated_worker, f"open('/box/../..' + {str(decoy)!r}).read()")
    assert refused(isolated_worker, f"import os; os.link({str(decoy)!r}, 'hard')")
    assert refused(isolated_worker, f"import os; os.chmod({str(decoy)!r}, 0o777)")
    assert refused(isolated_worker, f"import os; os.utime({str(decoy)!r}, (0, 0))")
    assert decoy.stat().st_mode & 0o777 == 0o644


def test_a_grader_among_the_packages_cannot_be_read(
    isolating_sandbox: Sandbox, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    packages = tmp_path / "site-packages"
    for name in ("grader", "neighbour"):
        (packages / name).mkdir(parents=True)
        (packages / name / "rubric.yaml").write_text("points")
    for folder in (tmp_path.parent, tmp_path, packages, packages / "grader", packages / "neighbour"):
        os.chmod(folder, 0o755)
    monkeypatch.setattr("grader.sandbox.surroundings.hidden", lambda: (str(packages / "grader"),))
    with (
        Sandbox(
            Contents(WORKER_CODE, readable=(packages,)), isolation_level=isolating_sandbox.isolation_level.name
        ) as shown,
        shown.worker() as worker,
    ):
        assert run(worker, f"result = open('{packages}/neighbour/rubric.yaml').read()") == {"result": "points"}
        assert refused(worker, f"open('{packages}/grader/rubric.yaml').read()")


def test_a_root_of_its_own_does_not_even_tell_what_the_hosts_holds(
    isolating_sandbox: Sandbox, isolated_worker: Worker, tmp_path: Path
) -> None:
    if not isolating_sandbox.isolation_level.own_root:
        pytest.skip("the root is the host's, and Landlock does not cover stat")
    paths = [str(tmp_path), "/proc", "/dev/shm", "/home"]
    assert run(isolated_worker, f"import os; result = [p for p in {paths} if os.path.exists(p)]") == {"result": []}


# Other processes ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["os.getppid()", "-1", "0", "GRADER"])
def test_no_other_process_can_be_signalled(isolating_sandbox: Sandbox, isolated_worker: Worker, target: str) -> None:
    source = f"import os, signal; GRADER = {os.getpid()}\nif {target} != os.getpid(): os.kill({target}, signal.SIGTERM)"
    found = run(isolated_worker, source)
    assert found.get("error") in {"PermissionError", "ProcessLookupError"}
    assert run(isolated_worker, "result = 1") == {"result": 1}


@pytest.mark.parametrize(
    "call",
    [
        "fork()",
        "vfork()",
        "ptrace(16, PID, 0, 0)",
        "unshare(0x10000000)",
        "mount(b'none', b'/box', b'tmpfs', 0, None)",
        "setns(0, 0)",
        "syscall(438, 0, 0, 0)",  # pidfd_getfd
        "syscall(310, PID, 0, 0, 0, 0, 0)",  # process_vm_readv
        "syscall(319, b'x', 0)",  # memfd_create
        "syscall(425, 1, 0)",  # io_uring_setup
        "syscall(29, 0, 1 << 30, 0o1600)",  # shmget
        "prctl(4, 1, 0, 0, 0)",  # PR_SET_DUMPABLE
    ],
)
def test_no_system_call_makes_or_reaches_another_process_or_namespace(isolated_worker: Worker, call: str) -> None:
    source = f"import ctypes\nPID = {os.getpid()}\nlibc = ctypes.CDLL(None, use_errno=True)\n"
    found = run(isolated_worker, source + f"result = [libc.{call}, ctypes.get_errno()]")
    assert found["result"] in ([-1, 1], [-1, 38])


def test_limits_of_another_process_cannot_be_changed_nor_its_own_raised(isolated_worker: Worker) -> None:
    before = os.sched_getaffinity(0)
    target = os.getpid()
    assert refused(isolated_worker, f"import os; os.sched_setaffinity({target}, [0])") or target == 1
    assert refused(isolated_worker, f"import resource; resource.prlimit({target}, resource.RLIMIT_NOFILE, (9, 9))")
    assert os.sched_getaffinity(0) == before
    source = "import resource; soft, hard = resource.getrlimit(resource.RLIMIT_AS)\n"
    found = run(isolated_worker, source + "resource.setrlimit(resource.RLIMIT_AS, (hard * 2, hard * 2))")
    assert found["error"] in {"ValueError", "PermissionError"}


# Floods ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("source", ["bytearray(6 << 30)", "[bytes(1 << 30) for _ in range(9)]"])
def test_memory_is_bounded(isolated_worker: Worker, source: str) -> None:
    assert "MemoryError" in run(isolated_worker, source)["error"]
    assert run(isolated_worker, "result = 1") == {"result": 1}


def test_when_memory_runs_out_the_kernel_takes_the_worker_first(
    isolating_sandbox: Sandbox, isolated_worker: Worker
) -> None:
    if isolating_sandbox.isolation_level.program:
        pytest.skip("there is no /proc from the start")
    pid = isolated_worker._process._pid  # type: ignore[attr-defined]
    assert Path(f"/proc/{pid}/oom_score_adj").read_text().strip() == "1000"


def test_threads_descriptors_and_a_file_are_bounded(isolated_worker: Worker) -> None:
    source = "import threading\nstop = threading.Event()\nresult = 0\ntry:\n"
    source += "    while result < 5000:\n        threading.Thread(target=stop.wait, daemon=True).start(); result += 1\n"
    assert run(isolated_worker, source + "except RuntimeError: pass\nstop.set()")["result"] < 5000
    source = "import os\nheld = []\ntry:\n    while True: held.append(os.open('/dev/null', 0))\n"
    source += "except OSError as e: result = [e.errno, len(held)]\nfor fd in held: os.close(fd)"
    errno, held = run(isolated_worker, source)["result"]
    assert errno == 24
    assert held < 128
    found = run(isolated_worker, "import os; fd = os.open('f', os.O_RDWR | os.O_CREAT); os.ftruncate(fd, 10 << 40)")
    assert found["error"] == "OSError"


def test_the_disk_is_bounded_where_the_box_has_its_own(isolating_sandbox: Sandbox, isolated_worker: Worker) -> None:
    if not isolating_sandbox.isolation_level.own_root:
        pytest.skip("Landlock has no quota")
    source = "result = 0\ntry:\n    for n in range(20):\n        with open(f'f{n}', 'wb', 0) as f:\n"
    source += "            result += f.write(bytes(8 << 20))\nexcept OSError: pass"
    assert run(isolated_worker, source)["result"] <= 64 << 20
    with isolating_sandbox.worker() as fresh:
        assert run(fresh, "result = open('f', 'wb').write(bytes(8 << 20))") == {"result": 8 << 20}


def test_calls_of_another_architecture_end_the_worker(isolated_worker: Worker) -> None:
    code = "b'\\xb8\\x14\\x00\\x00\\x00\\xcd\\x80\\xc3'"  # mov eax, 20 (getpid of i386); int 0x80; ret
    source = f"import ctypes, mmap\npage = mmap.mmap(-1, 4096, prot=7)\npage.write({code})\n"
    source += "ctypes.CFUNCTYPE(ctypes.c_int)(ctypes.addressof(ctypes.c_char.from_buffer(page)))()"
    if os.uname().machine != "x86_64":
        pytest.skip("int 0x80 is of x86")
    with pytest.raises(NoAnswer):
        run(isolated_worker, source)


# What sound work needs ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "source",
    [
        "import threading; t = threading.Thread(target=print); t.start(); t.join(); result = 1",
        "from concurrent.futures import ThreadPoolExecutor as P\nwith P(4) as p: result = sum(p.map(int, [0, 1]))",
        "import asyncio; result = asyncio.run(asyncio.sleep(0, 1))",
        "import tempfile\nwith tempfile.TemporaryDirectory() as d: open(d + '/x', 'w').write('x')\nresult = 1",
        "import sqlite3; result = sqlite3.connect('x.db').execute('select 1').fetchone()[0]",
        "np.savez('x.npz', a=np.ones(1)); result = int(np.load('x.npz')['a'][0])",
        "import getpass; result = len(getpass.getuser()) - 6",
        "import os, shutil; open('a', 'w').close(); os.rename('a', 'b'); shutil.copyfile('b', 'c'); result = 1",
        "import subprocess, ctypes, mmap, ssl, decimal, curses; result = 1",
        "import random, secrets, uuid, time; time.sleep(0.001); result = int(random.random() < 1)",
        "result = int(abs(np.linalg.svd(np.eye(50))[1][0]))",
    ],
)
def test_sound_work_is_not_hindered(isolated_worker: Worker, source: str) -> None:
    assert run(isolated_worker, source) == {"result": 1}
