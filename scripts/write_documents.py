"""Write every file that is generated from the models and schemas."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from drillid.config.documents import write_documents  # noqa: E402  # once the path is told

if __name__ == "__main__":
    write_documents(ROOT)
