"""More bugs chosen without the simulator, after it was extended for the first ones."""

from __future__ import annotations

from tools.faults.edits import Edit


#: Those of the twenty bugs that are not planted elsewhere, in an order drawn once.
LATER = {
    "chip: a repeated RUN runs again": Edit(
        "pathgene.sim.model.run_commands",
        ("        assert options is not None\n        if repeated:\n"),
        (
            "        assert options is not None\n"
            "        if repeated and self._run is not None:  # It continues.\n"
        ),
    ),
    "chip: every new session accepted": Edit(
        "pathgene.sim.model.chip",
        "        if session == (self._session + 1) % 256:\n",
        "        if session != self._session:\n",
    ),
    "task of a worker that died not done": Edit(
        "pathgene.host.workers.processes",
        (
            "                outcome = future.result()\n"
            "                del left[futures[future]]\n"
            "                yield outcome\n"
        ),
        ("                del left[futures[future]]\n                yield future.result()\n"),
    ),
    "session kept after an interrupt": Edit(
        "pathgene.host.device.link",
        (
            "        session, self.session = self.session, None\n"
            "        self.traffic.exchanges += 1\n"
            "        if self._is_refused and not requests[0].is_poll:\n"
            "            self._fill_number(session)\n"
            "        self._is_refused = False\n"
            "        try:\n"
            "            self._exchange(session, requests, meanwhile)\n"
        ),
        (
            "        session = self.session\n"
            "        self.traffic.exchanges += 1\n"
            "        if self._is_refused and not requests[0].is_poll:\n"
            "            self._fill_number(session)\n"
            "        self._is_refused = False\n"
            "        try:\n"
            "            self._exchange(session, requests, meanwhile)\n"
            "        except LinkTimeoutError:\n"
            "            self.session = None\n"
            "            raise\n"
        ),
    ),
    "every good frame counts as progress": Edit(
        "pathgene.host.device.link",
        (
            "            confirmed = window.confirmed\n"
            "            frames = self._receive(deadline)\n"
            "            for body, plain in frames:\n"
            "                if not plain and body[0] == session:\n"
            "                    take(requests, window, body)\n"
            "            if window.confirmed > confirmed:\n"
            "                silences = 0\n"
            "                deadline = self._deadline()\n"
            "            elif not frames:\n"
        ),
        (
            "            frames = self._receive(deadline)\n"
            "            for body, plain in frames:\n"
            "                if not plain and body[0] == session:\n"
            "                    take(requests, window, body)\n"
            "            if frames:\n"
            "                silences = 0\n"
            "                deadline = self._deadline()\n"
            "            else:\n"
        ),
    ),
    "answer before the window accepted": Edit(
        "pathgene.host.device.window",
        "    elif not 0 <= index < window.sent:\n",
        "    elif index >= window.sent:\n",
    ),
    "short form has the order of before": Edit(
        "pathgene.host.device.chip",
        (
            "            order = list(range(config.population))\n"
            "            request = generate_request(config, mode).pack(mode=mode)\n"
            "        else:\n"
            '            named = {f"slot_{rank}": slot for rank, slot in enumerate(order)}\n'
            "            request = generate_request(config, mode).pack(mode=mode, **named)\n"
            "\n"
            "        before, self._paths = self._known(), None\n"
            "        # A long reply may never get through a bad line. The short recipe does, and "
            "carries the same\n"
            "        # information.\n"
            "        recipe_only = bytes((LinkMode.RECIPE,)) + bytes(order)\n"
        ),
        (
            "            recipe_only = bytes((LinkMode.RECIPE,)) + bytes(order)\n"
            "            order = list(range(config.population))\n"
            "            request = generate_request(config, mode).pack(mode=mode)\n"
            "        else:\n"
            '            named = {f"slot_{rank}": slot for rank, slot in enumerate(order)}\n'
            "            request = generate_request(config, mode).pack(mode=mode, **named)\n"
            "            recipe_only = bytes((LinkMode.RECIPE,)) + bytes(order)\n"
            "\n"
            "        before, self._paths = self._known(), None\n"
        ),
    ),
    "line without its newline not ended": Edit(
        "pathgene.host.compare.store",
        '        if not line.endswith(b"\\n"):\n',
        '        if not line.endswith((b"\\n", b"}")):\n',
    ),
    "failed sync of a new file swallowed": Edit(
        "pathgene.host.files.replacement",
        "                current().sync(file)\n",
        (
            "                with contextlib.suppress(OSError):  # Not every file system can.\n"
            "                    current().sync(file)\n"
        ),
    ),
    "reset not noticed by reopen": Edit(
        "pathgene.host.device.chip",
        "        self.link.reopen()\n",
        (
            "        self.info = request_info(self.link)\n"
            '        self.link.open(self.info["session"], credit=self.config.receive_buffer)\n'
        ),
    ),
    "new files kept after a failure": Edit(
        "pathgene.host.files.replacement",
        ("                else:\n                    current().unlink(place)\n"),
        "",
    ),
    "repeated signals told apart by the time of day": Edit(
        "pathgene.host.interrupts",
        "    now_s = time.monotonic()\n    if now_s - _Received.last_s",
        "    now_s = time.time()\n    if now_s - _Received.last_s",
    ),
}
