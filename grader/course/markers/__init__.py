"""Markers in parallel: a pool of processes on this machine, or a Dask cluster."""
