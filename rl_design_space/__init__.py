"""Map the design space of a reinforcement-learning problem."""

__version__ = "0.1.0"
