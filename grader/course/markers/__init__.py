"""Markers, the objects that grade submissions, run in parallel: in a pool of processes on this machine, or on a Dask cluster."""
