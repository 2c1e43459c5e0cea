"""Everything that measures: calls the services' cores in process (paper, Section V)."""
