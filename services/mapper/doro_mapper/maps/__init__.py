"""The paper's two hash maps: cells, blocks in view, coverage."""
