"""The drawer of shapes visits each corner of a box once, and ends."""

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover

from pathgene.hdl.planner.shape_drawer import ShapeDrawer
from pathgene.hdl.protocol.planner import EDGES
from tests.formal.parts import Opened, any_constant, free
from tools.formal import Proof


class Drawn(Elaboratable):
    """Proved for all time, by induction, for a map of 4 x 4 corners and arbitrary shapes.

    Assumed: a shape stays until it is taken, and its first corner is not after its last one.

    - A shape with a box of n corners is taken n + 1 cycles after it is offered, and at no other
      time.
    - An arbitrary watched corner is visited exactly in the cycle of its number if it is in the box,
      and never otherwise. Numbers go by rows, backwards in every second row.
    - A write has the corner of the previous cycle.
    """

    COORDINATE_BITS = 2

    def __init__(self, unit):
        self.dut = unit(ShapeDrawer)(self.COORDINATE_BITS, 1)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = Opened(self.dut)
        shapes, cells, shape = self.dut.shapes, self.dut.cells, self.dut.shapes.p
        free(m, shapes.valid, shapes.payload, cells.ready)

        # Cycles since the shape was offered.
        age = Signal(range((1 << 2 * self.COORDINATE_BITS) + 3))
        waits, before = Signal(), Signal(len(shape.as_value()))
        m.d.comb += waits.eq(shapes.valid & ~shapes.ready)
        m.d.sync += [age.eq(Mux(waits, age + 1, 0)), before.eq(shape)]
        m.d.comb += [
            Assume((age == 0) | (shapes.valid & (shape.as_value() == before))),
            Assume((shape.first_x <= shape.last_x) & (shape.first_y <= shape.last_y)),
        ]
        width, height = (
            Signal(self.COORDINATE_BITS + 1, name=name) for name in ("width", "height")
        )
        corners = Signal.like(age)
        m.d.comb += [
            width.eq(shape.last_x - shape.first_x + 1),
            height.eq(shape.last_y - shape.first_y + 1),
            corners.eq(width * height),
            Assert(shapes.ready == (age == corners + 1)),
        ]

        def number_of(x, y):
            """Return the number of a corner in the box, starting at 0."""
            row = y - shape.first_y
            return row * width + Mux(row[0], shape.last_x - x, x - shape.first_x)

        def is_inside(x, y):
            return (
                (shape.first_x <= x)
                & (x <= shape.last_x)
                & (shape.first_y <= y)
                & (y <= shape.last_y)
            )

        x, y, back = (dut.signal(name) for name in ("x", "y", "back"))
        drawing, turning = dut.signal(f"draws_{EDGES}"), dut.signal(f"turns_{EDGES}")
        watched_x, watched_y = (
            any_constant(m, self.COORDINATE_BITS, f"watched_{axis}") for axis in "xy"
        )
        now = age == number_of(watched_x, watched_y) + 1
        looked_x, looked_y, looked = Signal.like(x), Signal.like(y), Signal()
        m.d.sync += [looked_x.eq(x), looked_y.eq(y), looked.eq(drawing)]
        m.d.comb += Assert(
            (drawing & (x == watched_x) & (y == watched_y))
            == (is_inside(watched_x, watched_y) & now & (age != 0))
        )
        with m.If(cells.valid):
            m.d.comb += Assert(looked & (cells.p.x == looked_x) & (cells.p.y == looked_y))
        m.d.comb += Cover(shapes.ready & (width == 2) & (height == 3) & cells.valid)

        # Invariant that the induction needs: the place of the drawer.
        m.d.comb += Assert(drawing == ((age != 0) & (age <= corners)))
        with m.If(drawing):
            m.d.comb += [
                Assert(is_inside(x, y)),
                Assert(age == number_of(x, y) + 1),
                Assert(back == (y - shape.first_y)[0]),
                Assert(turning == Mux(back, x == shape.first_x, x == shape.last_x)),
                Assert(
                    dut.signal("ends")
                    == Mux(
                        back,
                        x == (shape.first_x + 1)[: len(x)],
                        x == (shape.last_x - 1)[: len(x)],
                    )
                ),
            ]
        for number in range(EDGES):
            m.d.comb += Assert(dut.signal(f"draws_{number}") == drawing)
            with m.If(drawing):
                m.d.comb += Assert(dut.signal(f"turns_{number}") == turning)
        for number in range(EDGES - 1):
            with m.If(drawing):
                m.d.comb += Assert(dut.signal(f"negates_{number}") == (back & ~turning))
        return m


PROOF = Proof(
    claim=Drawn,
    depth=8,
    induction=2,
    reached=10,
    faults={
        "it goes on": (ShapeDrawer, ("Mux(drawing, ~is_last, begins)", "drawing | begins")),
        "the first row is the last": (ShapeDrawer, ("y == shape.last_y", "y == shape.first_y")),
        "no row goes back": (ShapeDrawer, ("drawing & (back ^ turning)", "drawing & back")),
        "a shape is taken early": (
            ShapeDrawer,
            ("self.shapes.ready.eq(drawing & is_last)", "self.shapes.ready.eq(turning & drawing)"),
        ),
    },
)
