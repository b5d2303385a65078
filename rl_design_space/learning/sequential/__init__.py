"""Learning one period after the other: learners, behaviours and step sizes beyond what `kernel` learns in lanes.

Learners differ in their targets and in what they remember, so their phases are not vectorised. `learn` comes here if it
gets a `Method`. One compiled function learns with all of them: compiling takes much longer than to ask, step by step,
which learner it is.
"""

__all__: list[str] = []
