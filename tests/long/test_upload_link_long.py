"""An upload over UDP in real time: 2 s each way, and a fifth of the messages lost."""

import heapq
import select
import socket
import threading
import time

import numpy as np
import pytest

from pathgene.host.errors import JobError
from pathgene.host.mission.autopilot.mavlink_link import open_link
from pathgene.host.mission.autopilot.upload import upload
from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.pilot import Kind
from pathgene.sim.autopilot.served import Served
from tests.support.host.missions import SEEDS, flight


class Relay(threading.Thread):
    """A UDP link that delays every datagram and loses some."""

    def __init__(self, port, delay_s, loss, seed):
        super().__init__(daemon=True)
        self._inside = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._inside.connect(("127.0.0.1", port))
        self._outside = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._outside.bind(("127.0.0.1", 0))
        self.port = self._outside.getsockname()[1]
        self._delay_s, self._loss = delay_s, loss
        self._random = np.random.default_rng(seed)
        self._closed = threading.Event()

    def run(self):
        waiting, client, number = [], None, 0
        while not self._closed.is_set():
            ready, _, _ = select.select([self._inside, self._outside], [], [], 0.01)
            for side in ready:
                data, sender = side.recvfrom(65536)
                client = sender if side is self._outside else client
                number += 1
                if self._random.random() >= self._loss:
                    due_s = time.monotonic() + self._delay_s
                    heapq.heappush(waiting, (due_s, number, side is self._outside, data))
            while waiting and waiting[0][0] <= time.monotonic():
                _, _, is_up, data = heapq.heappop(waiting)
                if is_up:
                    self._inside.send(data)
                else:
                    self._outside.sendto(data, client)

    def close(self):
        self._closed.set()
        self.join()
        self._inside.close()
        self._outside.close()


@pytest.mark.long
@pytest.mark.parametrize("kind", list(Kind), ids=lambda kind: kind.name.lower())
def test_a_slow_link_that_loses_a_fifth_carries_an_upload(kind):
    plan = min((flight(seed) for seed in SEEDS[:30]), key=lambda plan: len(plan.items))
    autopilot = Autopilot(kind, Start(plan.home, armed=False))
    served = Served(autopilot)
    served.start()
    relay = Relay(served.port, 2.0, 0.2, seed=1)
    relay.start()
    link = open_link(f"udpout:127.0.0.1:{relay.port}")
    begun_s = time.monotonic()
    try:
        link.find(30.0, 1)
        for _ in range(3):  # As the sentence of a failure says: upload again.
            try:
                done = upload(plan, link)
            except JobError as error:
                print(error)
                continue
            break
        else:
            raise AssertionError("three uploads fail")
    finally:
        link.close()
        relay.close()
        served.close()
    print(f"{kind.name.lower()}: {done.mission_items} items in {time.monotonic() - begun_s:.0f} s")
    assert (
        len(autopilot.lists.items[0])
        == done.mission_items
        == len(plan.items) + (kind is Kind.ARDUPLANE)
    )
    assert len(autopilot.lists.items[2]) == len(plan.rally)
