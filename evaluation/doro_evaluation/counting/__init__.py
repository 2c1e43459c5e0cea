"""How many of each thing (paper, Table II), chairs, stacks, order, and other methods."""
