"""Analysis: functions from recorded results to frames and estimates, without input, output or learning.

Internal but for `parts`, whose classes the claims of a study name.
"""

__all__: list[str] = []
