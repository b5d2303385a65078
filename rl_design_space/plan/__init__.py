"""Plans: design points with their identity, grids, studies and constraints."""
