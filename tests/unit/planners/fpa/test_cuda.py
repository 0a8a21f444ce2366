"""The GPU engine without a GPU, in numba's simulator and compiled to PTX."""

import importlib.util
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from host.errors import InputError
from host.planners import make
from host.planners.airspace import Airspace
from host.planners.base import Options
from host.planners.fpa.engines import CpuEngine
from host.planners.fpa.first import first_population
from host.planners.fpa.steps import Pollination


ROOT = Path(__file__).resolve().parents[4]
HERE = Path(__file__).resolve().parent
#: Relative difference of GPU and CPU after a few iterations; see host.planners.fpa.cuda.
TOLERANCE = 1e-9


def run_script(name, *arguments, **environment):
    return subprocess.run(
        [sys.executable, HERE / name, *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
        env=os.environ | {"PYTHONPATH": str(ROOT)} | environment,
    )


def has_gpu():
    from numba import cuda

    return cuda.is_available()


@pytest.mark.ci  # Numba's simulator is slow.
# With these seeds 2-opt, a step, and 2-opt again improve a solution.
@pytest.mark.parametrize(("waypoints", "threads", "seed"), [(4, 5, 18), (2, 32, 59)])
def test_simulated_gpu_equals_the_cpu(make_evaluator, tmp_path, waypoints, threads, seed):
    iterations, every, stride = 4, 1, 3
    evaluator = make_evaluator(ds_m=150.0)
    problem = evaluator.problem
    space = Airspace(problem)
    paths = first_population(space, np.random.default_rng(2), 5, waypoints)
    # A feasible path, so that both kinds of fitness are compared, and a better one that is tangled,
    # so that g* changes.
    good = np.array([(3050, 3600, 520), (4800, 3300, 450), (5000, 2500, 380), (5300, 1500, 300)])
    paths[1, 1:-1] = good[:waypoints] + np.array([0, 0, 40])
    paths[3, 1:-1] = good[[1, 0, 2, 3][:waypoints]]
    fitness = evaluator.fitness(paths, np.full(len(paths), waypoints + 2))
    cpu = CpuEngine(
        evaluator,
        Pollination(np.uint64(seed), iterations, 0.5, 0.25, 0.02),
        every,
        np.stack((space.low, space.high)),
        paths,
        fitness,
        threads=1,
    )
    leaders = cpu.advance(1, iterations)
    file = tmp_path / "run.pickle"
    file.write_bytes(
        pickle.dumps((problem, seed, iterations, every, stride, threads, paths, fitness))
    )
    # With the compiler off, the simulated threads run the same functions as plain Python.
    done = run_script("gpu_run.py", file, NUMBA_ENABLE_CUDASIM="1", NUMBA_DISABLE_JIT="1")
    assert done.returncode == 0, (done.returncode, done.stdout, done.stderr)
    found, (found_paths, found_fitness) = pickle.loads(file.with_suffix(".out").read_bytes())
    cpu_paths, cpu_fitness = cpu.population()
    assert found_paths == pytest.approx(cpu_paths, rel=TOLERANCE)
    assert found_fitness == pytest.approx(cpu_fitness, rel=TOLERANCE)
    assert found_fitness.max() > 1 > found_fitness.min()
    assert (cpu_fitness > fitness).sum() >= 3
    assert (np.argmax(fitness), np.argmax(cpu_fitness)) == (1, 3)
    assert sum(found[-1][3:]) == leaders[-1].evaluated + leaders[-1].cut_short
    for (path, best, mean, *_), leader in zip(found, leaders, strict=True):
        assert path == pytest.approx(leader.path, rel=TOLERANCE)
        assert (best, mean) == pytest.approx((leader.fitness, leader.mean), rel=TOLERANCE)


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
        "there; use another (--engine cores)."
    )


@pytest.mark.skipif(not has_gpu(), reason="there is no GPU")
def test_gpu_starts_as_the_cpu(evaluator):
    options = Options(generations=3, population=64)
    gpu, cpu = (
        make("fpa-2opt", engine=engine, two_opt_every=2).plan(evaluator, options)
        for engine in ("gpu", "cores")
    )
    assert [line[1:] for line in gpu.history] == pytest.approx(
        [line[1:] for line in cpu.history], rel=TOLERANCE
    )
