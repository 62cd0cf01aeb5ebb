"""What users write: settings, sheets of wells and logs, rig descriptions; and the documents generated from them."""
