"""Pages of results and sweeps: what stands in them, and what a browser makes of them."""
