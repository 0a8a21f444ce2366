"""Bugs chosen from the text of the product before the simulator and its judges were read."""

from __future__ import annotations

from tools.faults.edits import Edit


#: Bugs by name, in an order drawn once. The first twenty were the measure.
BLIND = {
    "signal handlers not restored after an error": Edit(
        "pathgene.host.interrupts",
        (
            "            signal.signal(number, handler)\n"
            "        yield\n"
            "    finally:\n"
            "        for number, previous in before.items():\n"
            "            signal.signal(number, previous)\n"
        ),
        (
            "            signal.signal(number, handler)\n"
            "        yield\n"
            "    except Exception:\n"
            "        raise\n"
            "    else:\n"
            "        for number, previous in before.items():\n"
            "            signal.signal(number, previous)\n"
        ),
    ),
    "copy of the population kept after a failed step": Edit(
        "pathgene.host.device.chip",
        "        before, self._paths = self._known(), None\n",
        "        before = self._known()\n",
    ),
    "batch stays open after an error": Edit(
        "pathgene.host.device.orders",
        (
            "        try:\n"
            "            if kind is None:\n"
            "                self.send(self._meanwhile)\n"
            "        finally:\n"
            "            self._orders.enter(None)\n"
            "            self.forget()\n"
        ),
        (
            "        if kind is None:\n"
            "            self.send(self._meanwhile)\n"
            "            self._orders.enter(None)\n"
            "        self.forget()\n"
        ),
    ),
    "answers of an earlier session accepted": Edit(
        "pathgene.host.device.link",
        "                if not plain and body[0] == session:\n",
        "                if not plain:\n",
    ),
    "chip: OUT_OF_ORDER has the number of the frame": Edit(
        "pathgene.sim.model.chip",
        "                return bytes((session, self._expected, Status.OUT_OF_ORDER))\n",
        "                return bytes((session, sequence, Status.OUT_OF_ORDER))\n",
    ),
    "session 0 not skipped": Edit(
        "pathgene.host.device.link",
        "        if session == _RESET_SESSION:\n",
        "        if session < _RESET_SESSION:\n",
    ),
    "chip: a late OPEN restarts the order": Edit(
        "pathgene.sim.model.chip",
        "        if session == (self._session + 1) % 256:\n",
        "        if session in (self._session, (self._session + 1) % 256):\n",
    ),
    "signal between the disk and the count of a run": Edit(
        "pathgene.host.compare.session",
        "                with interrupts.held():  # A stored run counts, too.\n",
        "                with contextlib.nullcontext(interrupts):\n",
    ),
    "late answers after a refusal not awaited": Edit(
        "pathgene.host.device.link",
        (
            '        self._exchange(session, [Request(Command.STATUS, (b"",), is_filler=True)])\n'
            "        self._next = (self._next + 1) % 256\n"
        ),
        "",
    ),
    "stored runs not locked": Edit(
        "pathgene.host.compare.store",
        "            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)\n",
        "            fcntl.flock(self._file, fcntl.LOCK_SH | fcntl.LOCK_NB)\n",
    ),
    "INFO and OPEN asked without limit": Edit(
        "pathgene.host.device.link",
        "        for attempt in range(self.attempts):\n",
        "        for attempt in iter(int, 1):\n",
    ),
    "all tasks repeated after the death of a process": Edit(
        "pathgene.host.workers.processes",
        (
            "                futures = {pool.submit(_work, task): number for "
            "number, task in left.items()}\n"
            "            for future in as_completed(futures):\n"
            "                outcome = future.result()\n"
            "                del left[futures[future]]\n"
        ),
        (
            "                futures = {pool.submit(_work, task): number for "
            "number, task in enumerate(tasks)}\n"
            "            for future in as_completed(futures):\n"
            "                outcome = future.result()\n"
            "                left.pop(futures[future], None)\n"
        ),
    ),
    "only copy of an older file removed": Edit(
        "pathgene.host.files.replacement",
        (
            "                is_whole = False\n"
            "                if older is not None:\n"
            "                    self._hidden.remove(older)  # The only copy stays.\n"
        ),
        "                is_whole = False\n",
    ),
    "copy of the population kept after a failed load": Edit(
        "pathgene.host.device.chip",
        ("        before, self._paths = self._paths, None\n        self.link.transfer(requests)"),
        ("        before = self._paths\n        self.link.transfer(requests)"),
    ),
    "chip: a refused command uses up its number": Edit(
        "pathgene.sim.model.chip",
        "            self._errors |= StickyError.REFUSED\n",
        (
            "            self._errors |= StickyError.REFUSED\n"
            "            self._expected = (self._expected + 1) % 256\n"
        ),
    ),
    "session kept after an error": Edit(
        "pathgene.host.device.link",
        "        session, self.session = self.session, None\n",
        "        session = self.session\n",
    ),
    "shorter form never used": Edit(
        "pathgene.host.device.link",
        (
            "            form = min(silences // _ATTEMPTS_BEFORE_SHORTER, "
            "len(request.payloads) - 1)\n"
        ),
        "            form = min(silences // _ATTEMPTS_BEFORE_SHORTER, 0)\n",
    ),
    "names not synced before obsolete files go": Edit(
        "pathgene.host.files.replacement",
        ("            sync_names(self._directory)\n        for place in obsolete:\n"),
        ("            pass\n        for place in obsolete:\n"),
    ),
    "silences not forgotten after progress": Edit(
        "pathgene.host.device.link",
        ("                silences = 0\n                deadline = self._deadline()\n"),
        "                deadline = self._deadline()\n",
    ),
    "sequence numbers wrap one early": Edit(
        "pathgene.host.device.link",
        "self._next = (self._next + len(requests)) % 256",
        "self._next = (self._next + len(requests)) % 255",
    ),
    "older file moved away instead of linked": Edit(
        "pathgene.host.files.replacement",
        (
            "            current().link(place, older)  # As well, so that the "
            "place is never empty.\n"
        ),
        "            self._move(place, older)\n",
    ),
    "OPEN has the number of the first command": Edit(
        "pathgene.host.device.link", "_OPENING = 255\n", "_OPENING = 0\n"
    ),
    "batch forgets its losses before it is sent": Edit(
        "pathgene.host.device.orders",
        (
            "        if self._commands:\n"
            "            self._link.order(self._commands, meanwhile)\n"
            "        self._commands.clear()\n"
            "        self._lost.clear()\n"
        ),
        (
            "        commands = list(self._commands)\n"
            "        self._commands.clear()\n"
            "        self._lost.clear()\n"
            "        if commands:\n"
            "            self._link.order(commands, meanwhile)\n"
        ),
    ),
    "last file renamed before obsolete files go": Edit(
        "pathgene.host.files.replacement",
        "        places = [self._directory / name for name in removed]\n",
        (
            "        for place, file in staged[-1:]:\n"
            "            current().rename(file, place)\n"
            "        staged = []\n"
            "        places = [self._directory / name for name in removed]\n"
        ),
    ),
    "torn line not ended": Edit(
        "pathgene.host.compare.store",
        '        if not line.endswith(b"\\n"):\n',
        "        if not line:\n",
    ),
    "refusal taken for an answer": Edit(
        "pathgene.host.device.window",
        "    elif status == Status.OK:\n",
        "    elif status != Status.DUPLICATE:\n",
    ),
    "failed sync of a run swallowed": Edit(
        "pathgene.host.compare.store",
        (
            '            self._file.write(f"{json.dumps(line, allow_nan=False)}\\n".encode())\n'
            "            current().sync(self._file)\n"
        ),
        (
            '            self._file.write(f"{json.dumps(line, allow_nan=False)}\\n".encode())\n'
            "            with contextlib.suppress(OSError):\n"
            "                current().sync(self._file)\n"
        ),
    ),
    "update_map opens no new session": Edit(
        "pathgene.host.device.chip",
        (
            "        if self.link.session is None:\n"
            "            self.reopen()\n"
            "        self._map.update"
        ),
        "        self._map.update",
    ),
    "box of a drawn zone noted as blocked": Edit(
        "pathgene.host.device.chip_map",
        (
            "        blocked = np.where(\n"
            "            drawn_corners(shape), self._config.blocked_altitude, "
            "self._heights[cells]\n"
            "        )\n"
        ),
        ("        blocked = np.full_like(self._heights[cells], self._config.blocked_altitude)\n"),
    ),
    "credit not returned after a silence": Edit(
        "pathgene.host.device.window",
        ("        self.in_flight.clear()\n        self._resend()\n"),
        "        self._resend()\n",
    ),
    "run counted only after its answer": Edit(
        "pathgene.host.device.runs",
        (
            "        self.started += 1\n"
            "        self.may_continue = True\n"
            "        self._orders.give([(Command.RUN, payload)])\n"
        ),
        (
            "        self.may_continue = True\n"
            "        self._orders.give([(Command.RUN, payload)])\n"
            "        self.started += 1\n"
        ),
    ),
    "earlier run not ended by reopen": Edit(
        "pathgene.host.device.chip",
        ("        self.link.reopen()\n        self._end_earlier_run()\n"),
        "        self.link.reopen()\n",
    ),
}
