"""Run docs/tutorial.py and write the page with its figures into a folder."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from drillid.literate import write_page  # noqa: E402

if __name__ == "__main__":
    write_page(ROOT / "docs" / "tutorial.py", Path(sys.argv[1]))
