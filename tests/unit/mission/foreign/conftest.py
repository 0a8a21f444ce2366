"""Missions of a few items over a plain."""

import pytest

from pathgene.host.errors import InputError
from tests.support.host.foreign import PLAIN, checked, land, plan_of


@pytest.fixture
def check(tmp_path):
    """Return the check of items, over a plain by default."""

    def run(items, heights=PLAIN, **options):
        places = {name: options.pop(name, None) for name in ("home", "rally", "firmware")}
        return checked(land(heights), tmp_path / "m.plan", plan_of(items, **places), **options)

    return run


@pytest.fixture
def refusal(check):
    """Return the sentence with which items are refused."""

    def run(*arguments, **options):
        with pytest.raises(InputError) as error:
            check(*arguments, **options)
        return str(error.value)

    return run
