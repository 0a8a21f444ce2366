# amaranth: UnusedElaboratable=no
"""Wrong sizes for the parameters of components."""

import pytest


__all__ = ["check_sizes"]


def check_sizes(component, sizes, lowest):
    """Check that ``component`` keeps its sizes and refuses wrong ones.

    Parameters
    ----------
    component : type
    sizes : dict of str to object
        Allowed arguments.
    lowest : dict of str to (str, int)
        Of each argument that is checked: its name in messages, and its lowest value.
    """
    made = component(**sizes)
    assert {name: getattr(made, name) for name in sizes} == sizes
    for name, (thing, least) in lowest.items():
        component(**{**sizes, name: least})
        message = f"^{thing} must be {least} or more, not {least - 1}$"
        with pytest.raises(ValueError, match=message):
            component(**{**sizes, name: least - 1})
        with pytest.raises(TypeError, match=f"^{thing} must be an integer, not '3'$"):
            component(**{**sizes, name: "3"})
