"""Commands in processes of their own, forked from one that has imported what they import.

A test of a command line waits for Python's imports most of the time. Here they are done once a
worker; then each command is a process with its own folder, arguments, environment and streams, as if it
had been started by ``python -m``. Signals, the console script and imports themselves are tested
with commands that are really started (see `command.start`).
"""

from __future__ import annotations

import atexit
import gc
import io
import json
import os
import runpy
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import traceback
from contextlib import redirect_stdout
from functools import cache
from pathlib import Path
from typing import NoReturn
from unittest.mock import patch

_LARGEST = 2**20


_LOCK = threading.Lock()


@cache
def _started(parent: int) -> str:
    """Address of the process that commands of these tests are forked from."""
    address = os.path.join(tempfile.mkdtemp(prefix="acalx"), "commands")
    server = subprocess.Popen([sys.executable, __file__, address, str(parent)], stdin=subprocess.DEVNULL)
    atexit.register(lambda: (server.terminate(), server.wait()))
    while not os.path.exists(address):
        time.sleep(0.01)
    return address


def _server() -> str:
    with _LOCK:  # commands are run by several threads
        return _started(os.getpid())


def run_forked(module: str, arguments: list[str], folder: Path, environment: dict[str, str]) -> tuple[int, str, str]:
    """Exit status and what was printed of ``python -m MODULE ARGUMENTS`` in a folder."""
    request = {"module": module, "arguments": arguments, "folder": str(folder), "environment": environment}
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err, socket.socket(socket.AF_UNIX) as client:
        client.connect(_server())
        socket.send_fds(client, [json.dumps(request).encode()], [out.fileno(), err.fileno()])
        status = int(client.recv(64))
        for stream in (out, err):
            stream.seek(0)
        return status, out.read().decode("utf-8"), err.read().decode("utf-8")


def _serve(address: str, parent: int) -> None:
    import acalx.commands.calibrate  # for those who are forked, with the others
    import acalx.commands.evaluate
    import acalx.commands.run
    import acalx.commands.simulate
    import acalx.commands.validate
    from acalx.reporting.figures import new_figure, save

    figure, axes = new_figure(3.0, 3.0)  # what matplotlib reads for its first figure
    axes[0].semilogy([1.0, 10.0])
    save(figure, Path(tempfile.mkdtemp()), "first")

    line = ["acalx.run", "--cfg", "job", "hydra.run.dir=."]  # what Hydra's grammars learn as they read their first line
    with patch.object(sys, "argv", line), patch.object(sys, "path", sys.path[:]), redirect_stdout(io.StringIO()):
        acalx.commands.run.main()
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    gc.freeze()  # what is here stays, and no collection of those who are forked copies it

    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for those who answer
    listener = socket.socket(socket.AF_UNIX)
    listener.bind(address + ".new")
    listener.listen()
    os.rename(address + ".new", address)
    listener.settimeout(1.0)
    while os.getppid() == parent:
        try:
            connection, _ = listener.accept()
        except TimeoutError:
            continue
        if os.fork() == 0:
            _answer(connection)
        connection.close()


def _answer(connection: socket.socket) -> NoReturn:
    """Run a command in a process, wait for it and say its exit status."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    connection.setblocking(True)
    message, streams, _, _ = socket.recv_fds(connection, _LARGEST, 2)
    pid = os.fork()
    if pid == 0:
        _become(json.loads(message), streams)
    connection.send(str(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])).encode())
    os._exit(0)


def _become(request: dict, streams: list[int]) -> NoReturn:
    """Be ``python -m MODULE ARGUMENTS``."""
    for number, stream in enumerate(streams, 1):
        os.dup2(stream, number)
    sys.stdout, sys.stderr = (io.TextIOWrapper(os.fdopen(k, "wb"), "utf-8", write_through=True) for k in (1, 2))
    os.chdir(request["folder"])
    os.environ.clear()
    os.environ.update(request["environment"])
    sys.argv, sys.path[0] = [request["module"], *request["arguments"]], request["folder"]
    status: object = 0
    try:
        runpy.run_module(request["module"], run_name="__main__", alter_sys=True)
    except SystemExit as end:
        status = end.code
    except BaseException:
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status if isinstance(status, int) else int(status is not None))


if __name__ == "__main__":
    _serve(sys.argv[1], int(sys.argv[2]))
