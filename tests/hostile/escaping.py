"""Escape: reaching the network, other processes and files outside, or staying when the run is over."""

from __future__ import annotations

from tests.corpus.writing import Link, zipped
from tests.hostile.program import FILTER, Program, in_method, indented, last, sound


def tries(name: str, code: str, *, keeps: bool = True) -> Program:
    """An attempt in the filter, which goes on as if nothing had been; what fails must cost nothing."""
    guarded = f"try:\n{indented(code)}\nexcept Exception:\n    pass"
    once = f"if not hasattr(LowPassFilter, 'tried'):\n    LowPassFilter.tried = True\n{indented(guarded)}"
    files = last(sound(), FILTER, in_method("LowPassFilter", "update", once))
    return Program(name, "escape", files, only="filtering", keeps=("filtering",) if keeps else ())


def leaks(name: str, code: str) -> Program:
    """An attempt to read; what is found is carried out in an exception's words."""
    reading = f"found = ''\ntry:\n{indented(code)}\nexcept Exception:\n    pass\nif found: raise RuntimeError('leak: ' + found)"
    files = last(sound(), FILTER, in_method("LowPassFilter", "update", reading))
    return Program(name, "escape", files, only="filtering")


NETWORK = [
    tries("tcp", "import socket\nsocket.create_connection(('127.0.0.1', @PORT@), 2).sendall(b'hello')"),
    tries("tcp-by-version-6", "import socket\nsocket.create_connection(('::ffff:127.0.0.1', @PORT@), 2)"),
    tries("udp", "import socket\nsocket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendto(b'hello', ('127.0.0.1', @UDP@))"),
    tries("tcp-by-sendto", "import socket\ns = socket.socket()\ns.sendto(b'hello', 0x20000000, ('127.0.0.1', @PORT@))"),
    tries("unix-socket", "import socket\nsocket.socket(socket.AF_UNIX).connect('@SOCKET@')"),
    tries("abstract-socket", "import socket\nsocket.socket(socket.AF_UNIX).connect('\\0@ABSTRACT@')"),
    tries("listens", "import socket\ns = socket.create_server(('127.0.0.1', 0))\nLowPassFilter.server = s"),
    tries("system-call-of-32-bits", "import ctypes, mmap, platform\nif platform.machine() == 'x86_64':\n    page = mmap.mmap(-1, 4096, prot=7)\n    page.write(b'\\xb8\\x14\\x00\\x00\\x00\\xcd\\x80\\xc3')\n    ctypes.CFUNCTYPE(ctypes.c_int)(ctypes.addressof(ctypes.c_char.from_buffer(page)))()", keeps=False),
]

PROCESSES = [
    tries("signals-another-process", "import os, signal\nos.kill(@PID@, signal.SIGTERM)"),
    tries("signals-by-descriptor", "import os, signal\nsignal.pidfd_send_signal(os.pidfd_open(@PID@), signal.SIGKILL)"),
    tries("signals-by-queue", "import ctypes\nctypes.CDLL(None).sigqueue(@PID@, 9, 0)"),
    tries("traces-another-process", "import ctypes\nlibc = ctypes.CDLL(None)\nlibc.ptrace(16, @PID@, 0, 0)"),
    tries("limits-another-process", "import resource\nresource.prlimit(@PID@, resource.RLIMIT_CPU, (0, 0))"),
    leaks("reads-another-process-environment", "found = open('/proc/@PID@/environ').read()"),
    leaks("reads-another-process-by-system-call", "import ctypes\nlibc = ctypes.CDLL(None, use_errno=True)\nbuffer = ctypes.create_string_buffer(16)\nclass V(ctypes.Structure): _fields_ = [('b', ctypes.c_void_p), ('n', ctypes.c_size_t)]\nif libc.process_vm_readv(@PID@, ctypes.byref(V(ctypes.addressof(buffer), 16)), 1, ctypes.byref(V(0x400000, 16)), 1, 0) > 0: found = 'imugrade-bait-5f1c83'"),
    tries("becomes-another-user", "import os\nos.setuid(0)\nos.setgid(0)\nos.chroot('/')"),
]

FILES = [
    leaks("reads-outside", "found = open('@SECRET@').read()"),
    leaks("reads-by-a-link-of-its-own", "import os\nos.symlink('@SECRET@', 'link')\nfound = open('link').read()"),
    leaks("reads-by-a-descriptor", "import os\nfor fd in range(3, 256):\n    try: found += open(os.open('..@SECRET@', 0, dir_fd=fd)).read()\n    except OSError: pass"),
    leaks("reads-by-mujoco", "import mujoco\ntry: mujoco.MjModel.from_xml_path('@SECRET@')\nexcept ValueError as e: found = str(e) if 'bait' in str(e) and 'secret.txt' not in str(e) else ''"),
    leaks("reads-by-handle", "import ctypes\nlibc = ctypes.CDLL(None)\nif libc.syscall(304, -100, ctypes.create_string_buffer(b'\\x08\\0\\0\\0\\1\\0\\0\\0\\2' + bytes(32)), 0) >= 0: found = 'imugrade-bait-5f1c83'"),
    tries("writes-outside", "open('@TARGET@', 'w').write('owned')"),
    tries("writes-by-a-link", "import os\nos.symlink('@TARGET@', 'link')\nopen('link', 'w').write('owned')"),
    tries("creates-outside", "open('@FOLDER@/new', 'w').write('owned')"),
    tries("removes-outside", "import os\nos.unlink('@TARGET@')"),
    tries("moves-out", "import os\nopen('x', 'w').close()\nos.rename('x', '@FOLDER@/x')"),
    tries("changes-modes-outside", "import os\nos.chmod('@TARGET@', 0o4777)\nos.chown('@TARGET@', 0, 0)"),
    tries("truncates-outside", "import os\nos.truncate('@TARGET@', 0)"),
    tries("locks-outside", "import fcntl\nfcntl.flock(open('@TARGET@'), fcntl.LOCK_EX)"),
    tries("makes-a-device", "import os, stat\nos.mknod('disk', stat.S_IFBLK | 0o666, os.makedev(254, 0))\nopen('disk', 'rb').read(16)"),
    tries("makes-a-pipe-that-waits", "import os\nos.mkfifo('pipe')", keeps=False),
    tries("makes-its-file-set-user-id", "import os\nopen('su', 'w').close()\nos.chmod('su', 0o6777)"),
]

LEFT = [
    tries("daemon", "import os\nif os.fork() == 0:\n    os.setsid()\n    if os.fork() == 0:\n        import signal\n        signal.alarm(25)\n        signal.pause()\n    os._exit(0)"),
    tries("process-by-multiprocessing", "import multiprocessing, time\nmultiprocessing.get_context('fork').Process(target=time.sleep, args=(1,), daemon=True).start()"),
    tries("shared-memory", "import ctypes\nctypes.CDLL(None).shmget(@IPC@, 4096, 0o1600)"),
    tries("named-semaphore", "import _multiprocessing\n_multiprocessing.SemLock(1, 1, 1, '/imugrade-hostile', True)"),
    tries("message-queue", "import ctypes\nctypes.CDLL(None).msgget(@IPC@, 0o1600)"),
    tries("leaves-files-for-the-next", "import os\nopen('left.py', 'w').write('x = 1')\nopen(os.path.join(os.environ['HOME'], 'sitecustomize.py'), 'w').write('raise SystemExit')"),
    leaks("finds-what-another-left", "import os\nfound = ' '.join(n for n in os.listdir('.') if n in ('left.py', 'owned')) and 'imugrade-bait-5f1c83'"),
    tries("changes-folder-and-mask", "import os\nos.chdir('/')\nos.umask(0)", keeps=True),
    tries("renames-the-process", "import ctypes\nctypes.CDLL(None).prctl(15, b'kworker', 0, 0, 0)"),
    tries("keeps-a-thread", "import threading, time\ndef forever():\n    while True: time.sleep(0.01)\nthreading.Thread(target=forever).start()", keeps=False),
]

# ---------------------------------------------------------------- what is handed in


SLIPS = ("../owned", "../../owned.py", "/@TARGET@", "a/../../owned", "C:\\owned", "\\\\host\\owned")
HANDED_IN = [
    Program("link-to-a-file-outside", "escape", {**sound(), "data.txt": Link("@SECRET@"), "more.py": Link("@SECRET@")}, only="filtering", keeps=("filtering",)),
    Program("required-file-is-a-link", "escape", {**sound(), FILTER: Link("@NEIGHBOUR@/filters.py")}, only="filtering"),
    Program("folder-is-a-link", "escape", {**sound(), "neighbour": Link("@NEIGHBOUR@"), "all": Link("/")}, only="filtering", keeps=("filtering",)),
    Program("link-to-itself", "escape", {**sound(), "loop": Link("loop"), "up": Link("..")}, only="filtering", keeps=("filtering",)),
    Program("zip-that-slips-out", "escape", {"hand-in.zip": zipped({**sound(), **dict.fromkeys(SLIPS, "owned")})}, only="filtering", keeps=("filtering",), as_="file"),
]

ESCAPES = [*NETWORK, *PROCESSES, *FILES, *LEFT, *HANDED_IN]
