"""Ctrl-C, in a terminal, in a notebook and in threads; and Python processes that are killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from conftest import LONG, PATIENCE
from jupyter_client.manager import KernelManager

import stickslip

#: Runs the job, says how it was interrupted, and goes on.
SCRIPT = f"""
import stickslip
try:
    stickslip.run({LONG!r}, 'long', threads=1)
except stickslip.Interrupted as interrupted:
    print(f"{{interrupted.run.status()['share_done']:.9f}} {{interrupted}}", flush=True)
    print(interrupted.run.resume().status()['state'], flush=True)
"""


@pytest.fixture(scope="session")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The surface of a run that nobody interrupts."""
    run = stickslip.run(LONG, tmp_path_factory.mktemp("whole") / "long", progress=False)
    return (run.path / "surface.parquet").read_bytes()


def begun(directory: Path, is_alive: Any) -> None:
    """Waits until samples are saved in a run directory."""
    wait_until(lambda: pieces(directory) > 0, is_alive)


def pieces(directory: Path) -> int:
    """How many pieces of samples are saved in a run directory."""
    return len(list(directory.glob("shards/*.jsonl")))


def wait_until(is_there: Callable[[], bool], is_alive: Callable[[], bool] = lambda: True) -> None:
    """Waits until something is there that a program makes which goes on."""
    until = time.monotonic() + PATIENCE
    while not is_there():
        assert is_alive() and time.monotonic() < until
        time.sleep(0.02)


def processes_of(directory: Path) -> list[str]:
    """The command lines of programs that name a directory."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = entry.read_bytes().split(b"\0")
        except OSError:
            continue
        if words[0].endswith(b"stickslip") and any(os.fsencode(directory) in word for word in words):
            found.append(str(words))
    return found


@pytest.mark.parametrize("whom", ["python", "group"])
def test_an_interrupted_run_goes_on_to_the_same_bytes(whom: str, place: Path, whole: bytes) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT],
        cwd=place,
        start_new_session=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    begun(place / "long", lambda: process.poll() is None)
    if whom == "python":
        process.send_signal(signal.SIGINT)
    else:
        os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    first, second = out.splitlines()
    assert 0 < float(first.split()[0]) < 1, out
    assert "samples are kept; continue with `stickslip.Run(" in first and ".resume()`" in first
    assert second == "finished"
    assert err.count("interrupted: saving what is finished") == 1, err
    assert (place / "long" / "surface.parquet").read_bytes() == whole


def test_run_goes_on_with_an_interrupted_run(place: Path, whole: bytes) -> None:
    interrupted_run(place)
    with pytest.raises(stickslip.CannotCreateError) as caught:
        stickslip.run(LONG, "long", progress=False, resume=False)
    assert caught.value.code == "run-unfinished"
    assert caught.value.remedy is not None and caught.value.remedy.endswith("long').resume()")
    run = stickslip.run(LONG, "long", progress=False)
    assert (run.path / "surface.parquet").read_bytes() == whole
    assert "50,000 samples each" in run.output


def test_run_goes_on_with_a_run_of_fewer_samples(place: Path) -> None:
    interrupted_run(place)
    run = stickslip.run(LONG, "long", progress=False, samples=50_001)
    assert set(run.surface()["n_samples"]) == {50_001}


def interrupted_run(place: Path) -> None:
    """Leaves an interrupted run."""
    timer = threading.Thread(target=lambda: (begun(place / "long", lambda: True), os.kill(os.getpid(), signal.SIGINT)))
    timer.start()
    with pytest.raises(KeyboardInterrupt) as caught:
        stickslip.run(LONG, "long", progress=False, threads=1)
    timer.join()
    assert isinstance(caught.value, stickslip.Interrupted)
    assert caught.value.code == "interrupted" and (caught.value.remedy or "").endswith("long').resume()")
    assert caught.value.run == stickslip.Run("long")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_thread_is_interrupted_by_a_call(place: Path, whole: bytes) -> None:
    caught: list[BaseException] = []

    def work() -> None:
        try:
            stickslip.run(LONG, "long", progress=False, threads=1)
        except BaseException as error:
            caught.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    begun(place / "long", thread.is_alive)
    stickslip.interrupt()
    thread.join(timeout=PATIENCE)
    assert isinstance(caught[0], stickslip.Interrupted) and caught[0].run is not None
    assert (caught[0].run.resume(progress=False).path / "surface.parquet").read_bytes() == whole


def test_ctrl_c_at_a_terminal_reaches_the_runs_of_threads(place: Path) -> None:
    lines = "".join(f"    {line}\n" for line in SCRIPT.splitlines())
    script = (
        f"from concurrent.futures import ThreadPoolExecutor\ndef work():\n{lines}\n"
        "with ThreadPoolExecutor() as pool:\n"
        "    future = pool.submit(work)\n"
        "    try:\n        future.result()\n"
        "    except KeyboardInterrupt:\n        print('main', flush=True)\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script], cwd=place, start_new_session=True, stdout=subprocess.PIPE, text=True
    )
    begun(place / "long", lambda: process.poll() is None)
    os.killpg(process.pid, signal.SIGINT)
    out, _ = process.communicate(timeout=PATIENCE)
    assert "main" in out and "samples are kept" in out and out.rstrip().endswith("finished"), out


def test_a_second_ctrl_c_is_passed_on_and_a_third_kills(stub: Any, place: Path) -> None:
    stub(
        "import signal, time\n"
        "count = 0\n"
        "def more(*_):\n"
        "    global count\n"
        "    count += 1\n"
        "    open('count', 'w').write(str(count))\n"
        "signal.signal(signal.SIGINT, more)\n"
        "open('count', 'w').write('0')\n"
        "while True:\n    time.sleep(0.1)\n"
    )

    def impatient() -> None:
        for count in ("0", "1", "2"):
            while not (place / "count").exists() or (place / "count").read_text() != count:
                time.sleep(0.02)
            os.kill(os.getpid(), signal.SIGINT)

    user = threading.Thread(target=impatient)
    user.start()
    with pytest.raises(stickslip.Interrupted) as caught:
        stickslip.analyse()
    user.join()
    assert caught.value.run is None
    assert (place / "count").read_text() == "2"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere the program goes on")
def test_the_program_ends_with_python(place: Path, whole: bytes) -> None:
    process = subprocess.Popen([sys.executable, "-c", SCRIPT], cwd=place)
    begun(place / "long", lambda: process.poll() is None)
    assert len(processes_of(place / "long")) == 1
    process.kill()
    process.wait()
    wait_until(lambda: not processes_of(place / "long"))
    run = stickslip.Run("long")
    assert run.status()["state"] == "unfinished" and run.status()["samples_done"] > 0
    assert (run.resume(progress=False).path / "surface.parquet").read_bytes() == whole


#: Runs the job in a thread, and forks while it is at work. The fork outlives the Python process, and names itself.
FORKING = f"""
import multiprocessing, pathlib, threading, time
import stickslip

threading.Thread(target=lambda: stickslip.run({LONG!r}, 'long', threads=1, progress=False), daemon=True).start()
while not list(pathlib.Path('long').glob('shards/*.jsonl')):
    time.sleep(0.02)
fork = multiprocessing.get_context('fork').Process(target=lambda: (stickslip.interrupt(), time.sleep({PATIENCE})))
fork.start()
print(fork.pid, flush=True)
time.sleep({PATIENCE})
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere the program goes on")
def test_a_fork_of_python_keeps_no_program_alive(place: Path, whole: bytes) -> None:
    process = subprocess.Popen([sys.executable, "-c", FORKING], cwd=place, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    fork = int(process.stdout.readline())
    try:
        # It saves more than a signal would have left time for.
        saved = pieces(place / "long")
        wait_until(lambda: pieces(place / "long") > saved + 2)
        assert len(processes_of(place / "long")) == 1, "the fork interrupted a run that is not its own"
        process.kill()
        process.wait()
        wait_until(lambda: not processes_of(place / "long"))
        os.kill(fork, 0)
    finally:
        os.kill(fork, signal.SIGKILL)
        process.stdout.close()
    assert stickslip.Run("long").status()["state"] == "unfinished"
    assert (stickslip.Run("long").resume(progress=False).path / "surface.parquet").read_bytes() == whole


def test_a_forked_process_has_runs_of_its_own(place: Path, small: dict[str, Any]) -> None:
    pid = os.fork()
    if pid == 0:
        try:
            stickslip.run(small, "forked", progress=False)
            os._exit(0)
        finally:
            os._exit(1)
    assert os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0
    assert stickslip.Run("forked").status()["state"] == "finished"


def test_a_notebook_is_interrupted_and_goes_on(place: Path, whole: bytes) -> None:
    manager = KernelManager(kernel_name="python3")
    manager.start_kernel(cwd=str(place))
    client = manager.client()
    client.start_channels()
    try:
        client.wait_for_ready(timeout=PATIENCE)
        client.execute(f"import stickslip, sys\nstickslip.run({LONG!r}, 'long', threads=1)")
        begun(place / "long", manager.is_alive)
        manager.interrupt_kernel()
        texts = sent_texts(client)
        assert texts["ename"] == "Interrupted", texts
        assert "interrupted: saving what is finished" in texts["stderr"]
        client.execute("run = sys.last_value.run.resume()\nrun")
        texts = sent_texts(client)
        assert "50,000 samples each" in texts["html"], texts
        assert " samples in " in texts["stderr"]
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)
    assert (place / "long" / "surface.parquet").read_bytes() == whole


def sent_texts(client: Any) -> dict[str, str]:
    """What a kernel sends about a cell, until it is idle."""
    texts = {"stderr": "", "html": "", "ename": ""}
    while True:
        message = client.get_iopub_msg(timeout=PATIENCE)
        content = message["content"]
        if message["msg_type"] == "stream":
            texts[content["name"]] = texts.get(content["name"], "") + content["text"]
        elif message["msg_type"] == "error":
            texts["ename"] = content["ename"]
        elif message["msg_type"] == "execute_result":
            texts["html"] = content["data"].get("text/html", "")
        elif message["msg_type"] == "status" and content["execution_state"] == "idle":
            if message["parent_header"].get("msg_type") == "execute_request":
                return texts
