"""Base class of the gateware's components, which checks and documents declared parameters.

A unit declares its parameters as annotations, as Amaranth declares ports::

    class Sorter(Unit):
        \"\"\"Systolic sorter. ...\"\"\"

        capacity: Count(2)
        key_bits: Width(1)

        def interface(self):
            return {"members": In(stream.Signature(self.key_bits)), ...}

One declaration makes the argument of the constructor, its check with the error message, the
attribute that stores it, and its entry in the docstring's section "Parameters". A class attribute
with the same name is the default.
"""

import inspect
import re
from typing import Self

from amaranth.lib import wiring


__all__ = [
    "Choice",
    "Count",
    "Flag",
    "Given",
    "InstanceOf",
    "Parameter",
    "PowerOfTwo",
    "Unit",
    "Width",
]

# The sections that follow the docstring's "Parameters".
_NEXT_SECTION = re.compile(r"\n\n(?=(?:Attributes|Members)\n-)")
_ERRORS = """

Raises
------
TypeError, ValueError
    If a parameter has the wrong type, or is out of its range."""


class Parameter:
    """A value from which a unit is built.

    Parameters
    ----------
    text : str
        Sentences for the docstring of the unit.
    name : str or None
        Name in messages and in the docstring; None for the attribute's name in words.
    also : tuple of object
        Values that are accepted although the rule forbids them.
    """

    #: Type in the docstring.
    kind = "object"
    is_checked = True

    def __init__(self, text="", *, name=None, also=()):
        self.text = text
        self.name = name
        self.also = also

    def title(self, attribute):
        """Return the name of the parameter in messages."""
        return self.name or attribute.replace("_", " ").capitalize()

    @property
    def depends(self):
        """True if the rule names other parameters."""
        return False

    def rule(self, values=None):
        """Describe the rule in words, with bounds evaluated from ``values``."""
        return ""

    def check(self, title, value, values):
        """Return the ``value`` to store; raise an error if the rule forbids it.

        Parameters
        ----------
        title : str
            First words of the message.
        value : object
        values : dict of str to object
            All parameters of the unit.
        """
        return value

    def entry(self, attribute, default):
        """Return the lines of the docstring that describe the parameter."""
        kind = " or ".join([self.kind, *map(repr, self.also)])
        if default is not inspect.Parameter.empty:
            kind += f", default {default!r}"
        rule = f"{self.title(attribute)}, {self.rule()}." if self.rule() else ""
        text = " ".join(filter(None, (rule, self.text)))
        return f"{attribute} : {kind}" + (f"\n    {text}" if text else "")


class Given(Parameter):
    """Value without a check, such as a layout; ``kind`` is its type in words."""

    is_checked = False

    def __init__(self, kind, text="", **options):
        super().__init__(text, **options)
        self.kind = kind


class Flag(Parameter):
    """Option that is on or off; any value is converted to its truth."""

    kind = "bool"
    is_checked = False

    def check(self, title, value, values):
        """Return the truth of ``value``."""
        return bool(value)


class InstanceOf(Parameter):
    """Object of a class; ``phrase`` says so in messages, "a Config"."""

    def __init__(self, cls, text="", *, phrase=None, **options):
        super().__init__(text, **options)
        self.cls = cls
        self.kind = cls.__name__
        self.phrase = phrase or f"a {cls.__name__}"

    def check(self, title, value, values):
        """Return ``value``, an instance of the class."""
        if not isinstance(value, self.cls):
            raise TypeError(f"{title} must be {self.phrase}, not {value!r}")
        return value


class Choice(Parameter):
    """One of several values."""

    kind = "int"

    def __init__(self, *choices, text="", **options):
        super().__init__(text, **options)
        self.choices = choices

    def rule(self, values=None):
        """List the choices in words."""
        return " or ".join(map(repr, self.choices))

    def check(self, title, value, values):
        """Return ``value``, one of the choices."""
        if value not in self.choices:
            raise ValueError(f"{title} must be {self.rule()}, not {value!r}")
        return value


class Count(Parameter):
    """Integer from ``minimum`` to ``maximum``, without an upper bound if ``maximum`` is None.

    Parameters
    ----------
    minimum : int or str
    maximum : int or str or None
        A string is an expression of other parameters: ``"population - 1"``.
    """

    kind = "int"

    def __init__(self, minimum, maximum=None, text="", **options):
        super().__init__(text, **options)
        self.minimum = minimum
        self.maximum = maximum

    @property
    def depends(self):
        """True if a bound is an expression."""
        return isinstance(self.minimum, str) or isinstance(self.maximum, str)

    def bounds(self, values):
        """Return both bounds as numbers."""
        return tuple(
            eval(bound, {}, values) if isinstance(bound, str) else bound
            for bound in (self.minimum, self.maximum)
        )

    def rule(self, values=None):
        """Describe the bounds in words."""
        minimum, maximum = (self.minimum, self.maximum) if values is None else self.bounds(values)
        return f"{minimum} or more" if maximum is None else f"from {minimum} to {maximum}"

    def allows(self, value, values):
        """Return whether an integer is within the bounds."""
        minimum, maximum = self.bounds(values)
        return value >= minimum and (maximum is None or value <= maximum)

    def check(self, title, value, values):
        """Return ``value``, an integer within the bounds."""
        if value in self.also:
            return value
        if not isinstance(value, int) or isinstance(value, bool):
            raise TypeError(f"{title} must be an integer, not {value!r}")
        if not self.allows(value, values):
            raise ValueError(f"{title} must be {self.rule(values)}, not {value!r}")
        return value


class Width(Count):
    """Number of bits; an attribute ``key_bits`` is named "Key width"."""

    def title(self, attribute):
        """Return the name of the width in messages."""
        words = re.sub("_bits$", "_width", attribute)
        return super().title(words)


class PowerOfTwo(Count):
    """Power of two from ``minimum`` to ``maximum``, which are powers of two."""

    def rule(self, values=None):
        """Describe the bounds in words."""
        minimum, maximum = (self.minimum, self.maximum) if values is None else self.bounds(values)
        upper = "on" if maximum is None else f"to {maximum}"
        return f"a power of two from {minimum} {upper}"

    def allows(self, value, values):
        """Return whether an integer is an allowed power of two."""
        return value > 0 and value & (value - 1) == 0 and super().allows(value, values)


class Unit(wiring.Component):
    """Component whose constructor takes the parameters that its class declares.

    Arguments are given by position, in the order of the declarations, or by name. A subclass
    declares its ports as annotations, or makes them from its parameters in :meth:`interface`.
    """

    #: The declared parameters by name, inherited ones first.
    parameters = {}

    def __init_subclass__(cls, **options):
        super().__init_subclass__(**options)
        own = inspect.get_annotations(cls).items()
        cls.parameters = cls.parameters | {
            name: each for name, each in own if isinstance(each, Parameter)
        }
        cls.__signature__ = inspect.Signature(
            inspect.Parameter(
                name,
                inspect.Parameter.POSITIONAL_OR_KEYWORD,
                default=getattr(cls, name, inspect.Parameter.empty),
            )
            for name in cls.parameters
        )
        if cls.parameters and cls.__doc__:
            cls.__doc__ = _documented(cls)

    def __init__(self, *arguments, **named):
        bound = type(self).__signature__.bind(*arguments, **named)
        bound.apply_defaults()
        values = bound.arguments
        # Bounds that name other parameters come last, because they use checked values.
        for name in sorted(self.parameters, key=lambda name: self.parameters[name].depends):
            parameter = self.parameters[name]
            values[name] = parameter.check(parameter.title(name), values[name], values)
        self.__dict__.update(values)
        super().__init__(self.interface(), src_loc_at=1)

    def twin(self) -> Self:
        """Return another unit with the same parameters."""
        return type(self)(**{name: getattr(self, name) for name in self.parameters})

    def interface(self) -> dict | wiring.Signature | None:
        """Return the members of the signature; None if the class declares them as annotations.

        It is called once, after all parameters have become attributes. Layouts and inner units that
        the ports need, or that a user reads, become attributes here.
        """


def _documented(cls):
    """Return the docstring of a unit with its parameters, and the errors of their checks."""
    text = inspect.cleandoc(cls.__doc__)
    arguments = cls.__signature__.parameters
    entries = (each.entry(name, arguments[name].default) for name, each in cls.parameters.items())
    section = "\n\nParameters\n----------\n" + "\n".join(entries)
    head, *rest = _NEXT_SECTION.split(text, maxsplit=1)
    errors = _ERRORS if any(each.is_checked for each in cls.parameters.values()) else ""
    return head + section + "".join("\n\n" + each for each in rest) + errors
