"""JAX in lock-step: one step of all periods at a time, compiled once, float32.

Each period goes on with its next trial as soon as it has finished one. Who has finished all of them walks on
uncounted, because leaving would change the shapes. The random words are those of `jax_map`, so the same steps show
that both are the same learner.
"""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from numpy.typing import NDArray

from benchmarks.job import Job
from benchmarks.peers import Learn
from benchmarks.peers.jax_behaviour import choose, generators, next_word

TITLE = "JAX, lock-step"
PERIODS = 500


def version() -> str:
    """The tool that learns."""
    return f"JAX {jax.__version__}"


def prepare(job: Job) -> Learn:
    """Get ready for a job."""
    next_cell = jnp.asarray(job.next_cell())
    # One entry more, for those that have finished their last trial.
    epsilons = jnp.asarray(np.append(job.epsilon(), 0.0), jnp.float32)
    rewards = jnp.array([job.step_reward, job.sub_goal_reward, job.final_goal_reward], jnp.float32)
    alpha, gamma = jnp.float32(job.alpha), jnp.float32(job.gamma)

    @jax.jit
    def learn_all(layouts: jax.Array, generators: jax.Array) -> jax.Array:
        periods = len(layouts)
        lane = jnp.arange(periods)
        starts, goals = layouts[:, 0], layouts[:, 1:]

        def going_on(carry: Any) -> Any:
            *_, trial, _ = carry
            return (trial < job.trials).any()

        def step(carry: Any) -> Any:
            q, random, cell, reached, steps, trial, total = carry
            coin, random = next_word(random)
            pick, random = next_word(random)
            state = reached * job.cells + cell
            values = q[lane, state]
            action = jax.vmap(choose)(values, epsilons[trial], coin, pick)
            cell = next_cell[action, cell]
            met = cell == goals[lane, reached]
            reached = reached + met
            terminal = reached == job.goals
            reward = jnp.where(terminal, rewards[2], jnp.where(met, rewards[1], rewards[0]))
            next_state = jnp.minimum(reached, job.goals - 1) * job.cells + cell
            target = reward + jnp.where(terminal, 0.0, gamma * q[lane, next_state].max(axis=1))
            old = jnp.take_along_axis(values, action[:, jnp.newaxis], axis=1)[:, 0]
            new = old + alpha * (target - old)
            q = q.at[lane, state, action].set(
                new, unique_indices=True, indices_are_sorted=True, mode="promise_in_bounds"
            )
            steps = steps + 1
            ended = terminal | (steps == job.max_steps)
            total = total + jnp.where(ended & (trial < job.trials), steps, 0)
            trial = jnp.minimum(trial + ended, job.trials)
            return (
                q, random, jnp.where(ended, starts, cell), jnp.where(ended, 0, reached), jnp.where(ended, 0, steps),
                trial, total,
            )  # fmt: skip

        zero = jnp.zeros(periods, jnp.int32)
        q = jnp.zeros((periods, job.states, 4), jnp.float32)
        random = (generators[:, 0], generators[:, 1])
        *_, total = lax.while_loop(going_on, step, (q, random, starts, zero, zero, zero, zero))
        return total

    def learn(layouts: NDArray[np.int32], seed: int) -> NDArray[np.int64]:
        return np.asarray(learn_all(layouts, generators(seed, len(layouts))), dtype=np.int64)

    return learn
