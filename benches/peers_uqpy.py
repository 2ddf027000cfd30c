"""Subset simulation by UQpy, for peers_rare_events.py, in the environment that UQpy needs.

    python benches/peers_uqpy.py '{"direction": [0.8, 0.6], "beta": 3.1, "samples": 1000, "seeds": [1, 2]}'

The event is `direction . u > beta` for independent standard normal deviates u. `samples` are those of each level. Prints a
JSON list with an object for each seed: `probability`, `evaluations` and `seconds`, without those of loading the library.

The setting is that of Au and Beck (2001): modified Metropolis with a normal proposal of standard deviation 1 for each
deviate, a tenth of the samples kept in each level, and independent samples to begin with.
"""

import json
import sys
import time

import numpy as np
from UQpy.distributions import Normal
from UQpy.reliability import SubsetSimulation
from UQpy.run_model.RunModel import RunModel
from UQpy.sampling import ModifiedMetropolisHastings

# Enough for probabilities down to 1e-20.
MOST_LEVELS = 20


class LimitState(RunModel):
    """The limit state, negative where the event occurs, for all samples of a call at once.

    Replaces the model that UQpy would call sample by sample; it only needs `run` and the list of results.
    """

    def __init__(self, direction: np.ndarray, beta: float) -> None:
        self.direction = direction
        self.beta = beta
        self.qoi_list: list[float] = []

    def run(self, samples: np.ndarray) -> None:
        self.qoi_list.extend((self.beta - np.asarray(samples) @ self.direction).tolist())


def simulate(direction: np.ndarray, beta: float, samples: int, seed: int) -> dict[str, float]:
    started = time.perf_counter()
    dimension, kept = len(direction), samples // 10
    random = np.random.RandomState(seed)
    limit_state = LimitState(direction, beta)
    chains = ModifiedMetropolisHastings(
        log_pdf_target=[Normal().log_pdf] * dimension, dimension=dimension, n_chains=kept, random_state=random
    )
    found = SubsetSimulation(
        runmodel_object=limit_state,
        sampling=chains,
        samples_init=random.standard_normal((samples, dimension)),
        conditional_probability=0.1,
        nsamples_per_subset=samples,
        max_level=MOST_LEVELS,
    )
    return {
        "probability": float(found.failure_probability),
        "evaluations": len(limit_state.qoi_list),
        "seconds": time.perf_counter() - started,
    }


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: python benches/peers_uqpy.py JSON")
    task = json.loads(sys.argv[1])
    direction = np.array(task["direction"])
    print(json.dumps([simulate(direction, task["beta"], task["samples"], seed) for seed in task["seeds"]]))


if __name__ == "__main__":
    main()
