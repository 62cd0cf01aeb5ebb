"""Every dataset's declaration, and how it is read and written."""
