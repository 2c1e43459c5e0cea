"""Tables, plots and failures as one HTML page and as Markdown."""
