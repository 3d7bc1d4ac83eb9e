"""Samples run: on one instance of each FMU, in batches, on a Dask cluster."""
