"""Run planned points: what is recorded is skipped, the rest is learned and recorded once."""
