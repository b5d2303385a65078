"""JAX, one period after the other: `lax.map` over a scalar `while_loop`, compiled once, float32."""

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

TITLE = "JAX, lax.map"
PERIODS = 500


def version() -> str:
    """The tool that learns."""
    return f"JAX {jax.__version__}"


def prepare(job: Job) -> Learn:
    """Get ready for a job."""
    next_cell = jnp.asarray(job.next_cell())
    epsilons = jnp.asarray(job.epsilon(), jnp.float32)
    rewards = jnp.array([job.step_reward, job.sub_goal_reward, job.final_goal_reward], jnp.float32)
    alpha, gamma = jnp.float32(job.alpha), jnp.float32(job.gamma)

    def learn_period(layout_and_generator: tuple[jax.Array, jax.Array]) -> jax.Array:
        layout, generator = layout_and_generator
        start, goals = layout[0], layout[1:]

        def trial(carry: Any, epsilon: jax.Array) -> Any:
            def going_on(carry: Any) -> Any:
                *_, reached, steps = carry
                return (reached < job.goals) & (steps < job.max_steps)

            def step(carry: Any) -> Any:
                q, random, cell, reached, steps = carry
                coin, random = next_word(random)
                pick, random = next_word(random)
                state = reached * job.cells + cell
                values = q[state]
                action = choose(values, epsilon, coin, pick)
                cell = next_cell[action, cell]
                met = cell == goals[reached]
                reached = reached + met
                terminal = reached == job.goals
                reward = jnp.where(terminal, rewards[2], jnp.where(met, rewards[1], rewards[0]))
                next_state = jnp.minimum(reached, job.goals - 1) * job.cells + cell
                target = reward + jnp.where(terminal, 0.0, gamma * q[next_state].max())
                old = values[action]
                q = q.at[state, action].set(old + alpha * (target - old))
                return q, random, cell, reached, steps + 1

            q, random = carry
            q, random, _, _, steps = lax.while_loop(going_on, step, (q, random, start, jnp.int32(0), jnp.int32(0)))
            return (q, random), steps

        q = jnp.zeros((job.states, 4), jnp.float32)
        _, steps = lax.scan(trial, (q, (generator[0], generator[1])), epsilons)
        total: jax.Array = steps.sum()
        return total

    compiled = jax.jit(lambda layouts, generators: lax.map(learn_period, (layouts, generators)))

    def learn(layouts: NDArray[np.int32], seed: int) -> NDArray[np.int64]:
        return np.asarray(compiled(layouts, generators(seed, len(layouts))), dtype=np.int64)

    return learn
