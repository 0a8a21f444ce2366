"""The GPU engine without a GPU (see test_gpu), in numba's simulator and compiled to PTX."""

import importlib.util
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.planners import make
from pathgene.host.planners.airspace import Airspace
from pathgene.host.planners.base import Options
from pathgene.host.planners.fpa.engines import CpuEngine, Setup
from pathgene.host.planners.fpa.planner import first_population
from pathgene.host.planners.fpa.steps import Pollination
from pathgene.host.problem.rules import Rules


ROOT = Path(__file__).resolve().parents[4]
HERE = Path(__file__).resolve().parent
#: Relative difference of GPU and CPU after a few iterations; see pathgene.host.planners.fpa.cuda.
TOLERANCE = 1e-9


def run_script(name, *arguments, **environment):
    return subprocess.run(
        [sys.executable, HERE / name, *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])} | environment,
    )


def has_gpu():
    from numba import cuda

    return cuda.is_available()


@pytest.mark.ci  # Numba's simulator is slow.
# With these seeds 2-opt, a step, and 2-opt again improve a solution.
@pytest.mark.parametrize(
    ("waypoints", "threads", "width", "seed"),
    [
        pytest.param(4, 5, 2, 18, marks=pytest.mark.long),
        pytest.param(4, 32, 15, 18, marks=pytest.mark.long),
        (2, 7, 1, 59),
    ],
)
def test_simulated_gpu_equals_the_cpu(make_evaluator, tmp_path, waypoints, threads, width, seed):
    iterations, every, stride = 4, 1, 3
    evaluator = make_evaluator(ds_m=150.0)
    space = Airspace(evaluator.problem)
    # A feasible path, so that both kinds of fitness are compared, and a better one that is tangled,
    # so that g* changes.
    good = np.array([(3050, 3600, 520), (4800, 3300, 450), (5000, 2500, 380), (5300, 1500, 300)])
    setups = []
    # A second problem, with its own sampling step and map.
    other = make_evaluator(ds_m=200.0, zones=())
    for own, drawn in ((evaluator, 2), (other, 3)):
        paths = first_population(space, np.random.default_rng(drawn), 5, waypoints)
        paths[1, 1:-1] = good[:waypoints] + np.array([0, 0, 40])
        paths[3, 1:-1] = good[[1, 0, 2, 3][:waypoints]]
        setups.append(
            Setup(
                own,
                Pollination(np.uint64(seed), iterations, 0.5, 0.25, 0.02),
                np.stack((space.low, space.high)),
                paths,
                own.fitness(paths, np.full(len(paths), waypoints + 2)),
            )
        )
    file = tmp_path / "run.pickle"
    runs = [(setup.evaluator.problem, seed, setup.paths, setup.fitness) for setup in setups]
    options = {"threads": threads, "width": width, "blocks": 1}
    file.write_bytes(pickle.dumps((runs, iterations, every, stride, options)))
    # With the compiler off, the simulated threads run the same functions as plain Python.
    done = run_script("gpu_run.py", file, NUMBA_ENABLE_CUDASIM="1", NUMBA_DISABLE_JIT="1")
    assert done.returncode == 0, (done.returncode, done.stdout, done.stderr)
    found, (found_paths, found_fitness) = pickle.loads(file.with_suffix(".out").read_bytes())
    for at, setup in enumerate(setups):
        cpu = CpuEngine(setup, every, threads=1)
        (leaders,) = cpu.advance(1, iterations)
        (cpu_paths,), (cpu_fitness,) = cpu.populations()
        assert found_paths[at] == pytest.approx(cpu_paths, rel=TOLERANCE)
        assert found_fitness[at] == pytest.approx(cpu_fitness, rel=TOLERANCE)
        assert found_fitness[at].max() > 1 > found_fitness[at].min()
        assert (cpu_fitness > setup.fitness).sum() >= 3
        assert sum(found[at][-1][3:]) == leaders[-1].evaluated + leaders[-1].cut_short
        for (path, best, mean, *_), leader in zip(found[at], leaders, strict=True):
            assert path == pytest.approx(leader.path, rel=TOLERANCE)
            assert (best, mean) == pytest.approx((leader.fitness, leader.mean), rel=TOLERANCE)
    assert (np.argmax(setups[0].fitness), np.argmax(found_fitness[0])) == (1, 3)


@pytest.mark.ci  # Numba's simulator is slow.
def test_simulated_gpu_sees_the_edge_of_the_map(make_evaluator, tmp_path):
    """Paths along the edge, nearer than the corridor, have the penalty that the CPU gives them."""
    evaluator = make_evaluator(zones=(), ds_m=150.0, rules=Rules(corridor_m=60.0))
    space = Airspace(evaluator.problem)
    paths = first_population(space, np.random.default_rng(2), 3, 2)
    for path, away_m in zip(paths, (400.0, 120.0, 40.0), strict=True):
        path[1:-1] = (2000, away_m, 800), (4000, away_m, 800)
    fitness = evaluator.fitness(paths, np.full(3, 4))
    setup = Setup(
        evaluator,
        Pollination(np.uint64(1), 1, 0.5, 0.25, 0.02),
        np.stack((space.low, space.high)),
        paths,
        np.zeros(3),
    )
    file = tmp_path / "run.pickle"
    runs = [(evaluator.problem, 1, paths, np.zeros(3))]
    options = {"threads": 4, "width": 2, "blocks": 1}
    file.write_bytes(pickle.dumps((runs, 1, 1, 1, options)))
    done = run_script("gpu_run.py", file, NUMBA_ENABLE_CUDASIM="1", NUMBA_DISABLE_JIT="1")
    assert done.returncode == 0, (done.returncode, done.stdout, done.stderr)
    _, (found_paths, found_fitness) = pickle.loads(file.with_suffix(".out").read_bytes())
    cpu = CpuEngine(setup, 1, threads=1)
    cpu.advance(1, 1)
    (cpu_paths,), (cpu_fitness,) = cpu.populations()
    assert found_paths[0] == pytest.approx(cpu_paths, rel=TOLERANCE)
    assert found_fitness[0] == pytest.approx(cpu_fitness, rel=TOLERANCE)
    bare = make_evaluator(zones=(), ds_m=150.0, rules=Rules(corridor_m=0.0))
    assert fitness[2] < bare.fitness(paths, np.full(3, 4))[2]


def test_kernel_compiles_to_ptx():
    if importlib.util.find_spec("numba_cuda") is None:
        pytest.skip("numba-cuda is not there: it comes with the extra 'gpu'")
    done = run_script("gpu_compile.py")
    if done.returncode == 3:
        pytest.skip(f"CUDA's compiler is not there: {done.stdout.strip()}")
    assert done.returncode == 0, (done.returncode, done.stdout, done.stderr)
    assert ".target sm_90" in done.stdout


@pytest.mark.skipif(has_gpu(), reason="there is a GPU")
def test_reports_a_missing_gpu(evaluator):
    with pytest.raises(InputError) as caught:
        make("fpa", engine="gpu").plan(evaluator, Options())
    assert str(caught.value) == (
        "The engine gpu needs an NVIDIA GPU and CUDA for numba (the extra 'gpu'), which are not "
        "there; use another (--engine threads)."
    )
