"""Pictures of the inside of a period: what the agent knows, where it was, and which way it took."""
