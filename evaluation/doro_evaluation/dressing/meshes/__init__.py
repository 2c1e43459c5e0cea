"""More meshes for the training frames alone."""
