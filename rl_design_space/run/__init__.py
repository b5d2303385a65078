"""Run planned points: skip recorded points, learn the others, record each once."""
