#!/bin/sh
# `make setup` puts this into .venv/bin: the library of the checkout that the environment belongs to
root=$(cd "$(dirname "$0")/../.." && pwd) || exit 1
PYTHONPATH="$root${PYTHONPATH:+:$PYTHONPATH}"
NUMBA_CACHE_DIR="${NUMBA_CACHE_DIR:-$root/.venv/numba}"
export PYTHONPATH NUMBA_CACHE_DIR
exec "$root/.venv/bin/python" -m drillid "$@"
