# amaranth: UnusedElaboratable=no
"""Wrong sizes for the parameters of components."""

import pytest


__all__ = ["check_sizes"]


def check_sizes(component, sizes, limits):
    """Check that ``component`` keeps its sizes and refuses wrong ones.

    Parameters
    ----------
    component : type
    sizes : dict of str to object
        Allowed arguments.
    limits : dict of str to (str, int) or (str, int, int)
        Of each argument that is checked: its name in messages, its lowest value, and the highest if
        there is one.
    """
    made = component(**sizes)
    assert {name: getattr(made, name) for name in sizes} == sizes
    for name, (thing, least, *most) in limits.items():
        rule = f"from {least} to {most[0]}" if most else f"{least} or more"
        for value in (least, *most):
            component(**{**sizes, name: value})
        for value in (least - 1, *(highest + 1 for highest in most)):
            with pytest.raises(ValueError, match=f"^{thing} must be {rule}, not {value}$"):
                component(**{**sizes, name: value})
        with pytest.raises(TypeError, match=f"^{thing} must be an integer, not '3'$"):
            component(**{**sizes, name: "3"})
