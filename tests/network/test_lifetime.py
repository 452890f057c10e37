"""Laws of a process's end: whichever thread a signal reaches, and whenever, the loop of the process hears of it."""

import subprocess
import sys

WAITS = """
import os, queue, signal
from network.inbox import Inbox
from network.lifetime import Lifetime
wake = Inbox()
lifetime = Lifetime(lambda: wake.put(None))
signal.signal(signal.SIGUSR1, lambda *_: None)  # somebody else's
os.kill(os.getpid(), signal.SIGUSR1)
try:
    wake.get(0.2)
except queue.Empty:
    print("goes on")
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})  # the main thread alone: another one gets the signal
print(lifetime.over)
os.kill(os.getpid(), signal.SIGTERM)
wake.get()
print(lifetime.over)
"""


def test_a_signal_that_does_not_interrupt_the_wait_ends_it_and_another_one_does_not() -> None:
    done = subprocess.run([sys.executable, "-c", WAITS], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == ["goes", "on", "False", "True"]
