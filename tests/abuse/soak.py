"""Looks for memory that grows while sheets come and go."""

import statistics
import threading
import time

from kinds import ATTACKS
from victims import Target

THREADS = 4
CHURN_S, REST_S = 7.0, 3.0
MOST_GROWTH = 1.05  # the last fifth over the second


def churn_for(target, seconds):
    """Makes and deletes sheets for some seconds; none is left at the end."""
    end = time.monotonic() + seconds

    def turns(number):
        while time.monotonic() < end:
            ATTACKS["churn"].run(target, number)

    threads = [threading.Thread(target=turns, args=(number,)) for number in range(THREADS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def soak(server, seconds):
    """Says whether memory stays as it is, and the server ends in order."""
    target = Target(server)
    sizes = []
    started = time.monotonic()
    while time.monotonic() < started + seconds:
        churn_for(target, CHURN_S)
        time.sleep(REST_S)
        sizes.append(server.memory_mb("VmRSS"))
        print(f"{time.monotonic() - started:6.0f} s  VmRSS {sizes[-1]:7.1f} MB  "
              f"{', '.join(f'{number} {what}' for what, number in target.counts.items())}", flush=True)
    fifth = max(1, len(sizes) // 5)
    before, after = statistics.mean(sizes[fifth:2 * fifth] or sizes), statistics.mean(sizes[-fifth:])
    status, stopped_s = server.stop()
    print(f"second fifth {before:.1f} MB, last fifth {after:.1f} MB ({100 * (after / before - 1):+.1f} %); "
          f"SIGTERM: status {status} after {stopped_s:.1f} s")
    return after <= before * MOST_GROWTH and status == 0
