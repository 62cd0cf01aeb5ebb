"""Run docs/tutorial.py and write the page with its figures; tell where it differs from the page in docs."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from drillid.literate import differences, write_page  # noqa: E402  # once the path is told

if __name__ == "__main__":
    folder, kept = Path(sys.argv[1]), (ROOT / "docs" / "tutorial.md").read_text()
    write_page(ROOT / "docs" / "tutorial.py", folder)
    changed = differences(kept, (folder / "tutorial.md").read_text())
    for before, after in changed:
        print(f"< {before}\n> {after}")
    # what is written over may differ: that is what the page is written again for
    sys.exit(bool(changed) and folder.resolve() != ROOT / "docs")
