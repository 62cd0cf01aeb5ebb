"""A real well's start of rotation: its description, its log, fits and misfits."""
