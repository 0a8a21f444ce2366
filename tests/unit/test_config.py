"""The configuration: derived sizes, and the message of every rule."""

import dataclasses
import re

import pytest

from pathgene.hdl.config import CheckerBuild, Config, GeneticCore, MutationKind, SurvivorSelection


def test_default_has_the_papers_sizes():
    config = Config()
    assert (config.population, config.children, config.crossovers) == (32, 22, 11)
    assert (config.elites, config.survivors) == (2, 8)
    assert [kind.name for kind in config.mutations] == [
        "PERTURB",
        "INSERT",
        "INSERT",
        "DELETE",
        "DELETE",
    ]
    assert config.mutations[0] is MutationKind.PERTURB
    assert (config.coordinate_bits, config.waypoint_bits, config.waypoint_bytes) == (9, 30, 4)
    assert config.head_size == 8
    # 15 % of 512 cells is 76.8, and of 4096 steps 614.4; half of it to each side, rounded down.
    assert (config.box_cells, config.box_steps) == (38, 307)
    assert config.blocked_altitude == 4095
    assert (config.checker, config.lanes) == (CheckerBuild.PARALLEL, 8)
    assert (config.mutators, config.patches, config.draw_steps) == (5, 3, 14)


@pytest.mark.parametrize(
    ("max_waypoints", "head", "length_bits", "index_bits"),
    [(16, 8, 5, 4), (20, 10, 5, 5), (5, 2, 3, 3), (3, 1, 2, 2)],
)
def test_halves_of_a_path(max_waypoints, head, length_bits, index_bits):
    config = Config(max_waypoints=max_waypoints)
    assert config.head_size == head
    assert (config.length_bits, config.index_bits) == (length_bits, index_bits)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"population": 33}, "Config.population must be a power of two from 4 to 256, not 33"),
        (
            {"population": 64},
            "Config.population must be elites + survivors + children = 32, not 64",
        ),
        ({"children": 21}, "Config.children must be even and at least 4, not 21"),
        ({"elites": 0}, "Config.elites must be at least 1, not 0"),
        ({"survivors": 0}, "Config.survivors must be at least 1, not 0"),
        ({"perturbs": 0}, "Config.perturbs must be at least 1, not 0"),
        (
            {"deletes": 20},
            "Config.children must be at least perturbs + inserts + deletes = 23, not 22",
        ),
        ({"max_waypoints": 2}, "Config.max_waypoints must be from 3 to 64, not 2"),
        ({"max_waypoints": 65}, "Config.max_waypoints must be from 3 to 64, not 65"),
        ({"map_size": 500}, "Config.map_size must be a power of two from 8 to 4096, not 500"),
        (
            {"coarse_factor": 512},
            "Config.coarse_factor must be a power of two from 2 to map_size / 2, not 512",
        ),
        ({"altitude_bits": 17}, "Config.altitude_bits must be from 4 to 16, not 17"),
        ({"box_percent": 0}, "Config.box_percent must be from 1 to 100, not 0"),
        ({"clock_hz": 0}, "Config.clock_hz must be from 1 to 4294967295, not 0"),
        (
            {"clocks_per_bit": 3},
            "Config.clocks_per_bit must be from 4 to 65535, or 0 for a byte-wide port, not 3",
        ),
        (
            {"receive_buffer": 300},
            "Config.receive_buffer must be a power of two from 256 to 32768, not 300",
        ),
        ({"lanes": 3}, "Config.lanes must be 1, 2, 4, 8 or 16, not 3"),
        ({"checker": "two-tier"}, "Config.lanes must be 1 in the two-tier build, not 8"),
        (
            {"map_size": 8, "coarse_factor": 2, "lanes": 16},
            "Config.lanes must be at most map_size = 8, not 16",
        ),
        ({"memory_latency": 3}, "Config.memory_latency must be 1 or 2, not 3"),
        (
            {"core": "planner", "checker": "none"},
            "Config.checker must be parallel with the planner core, not none",
        ),
        (
            {"core": "planner", "population": 64, "survivors": 40},
            "Config.population must be at most 32 with the planner core, not 64",
        ),
        (
            {"core": "planner", "children": 14, "survivors": 16},
            "Config.survivors must be at most the children with the planner core, not 16",
        ),
        ({"redraws": 8}, "Config.redraws must be from 0 to 7, not 8"),
        ({"point_cycles": 3}, "Config.point_cycles must be 1 or 2, not 3"),
        (
            {"survivor_selection": "best"},
            "Config.survivor_selection must be uniform or rank, not 'best'",
        ),
        (
            {"checker": "hierarchical"},
            "Config.checker must be none, two-tier or parallel, not 'hierarchical'",
        ),
    ],
)
def test_names_the_broken_rule(changes, sentence):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        Config(**changes)


@pytest.mark.parametrize("value", ["32", 32.0, True, None])
def test_names_the_wrong_type(value):
    with pytest.raises(TypeError, match=rf"^Config\.population must be an integer, not {value!r}$"):
        Config(population=value)


def test_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        Config().population = 64


def test_build_id_depends_on_every_field():
    changed = [
        Config(survivor_selection=SurvivorSelection.RANK),
        Config(max_waypoints=20),
        Config(clocks_per_bit=4),
        Config(perturbs=2, inserts=1),
        Config(box_percent=20),
        Config(point_cycles=2),
    ]
    ids = {config.build_id for config in [Config(), *changed]}
    assert len(ids) == 7
    assert Config().build_id == Config().build_id
    assert all(0 <= build_id < 1 << 32 for build_id in ids)


def test_replace_checks_again():
    assert Config().replace(max_waypoints=20) == Config(max_waypoints=20)
    with pytest.raises(ValueError, match=r"^Config\.max_waypoints must be from 3 to 64, not 0$"):
        Config().replace(max_waypoints=0)


def test_the_longest_path_follows_the_core_unless_it_is_given():
    planner = Config(core=GeneticCore.PLANNER)
    assert (Config().max_waypoints, planner.max_waypoints) == (16, 24)
    assert Config().replace(core=GeneticCore.PLANNER) == planner
    assert planner.replace(core=GeneticCore.PAPER) == Config()
    given = Config(max_waypoints=20).replace(core=GeneticCore.PLANNER)
    assert given.max_waypoints == 20


@pytest.mark.parametrize(
    ("max_waypoints", "depth"), [(3, 16), (15, 16), (16, 32), (31, 32), (32, 64), (63, 64)]
)
def test_a_count_of_each_segment_waits(max_waypoints, depth):
    config = Config(max_waypoints=max_waypoints)
    assert config.max_segments == max_waypoints + 1
    assert config.count_places == depth
