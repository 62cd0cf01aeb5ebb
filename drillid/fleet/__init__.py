"""Wells in batches, what each stage depends on, and the only place that knows dask."""
