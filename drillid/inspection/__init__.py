"""What unknown log files hold, and a draft of the rig description that reads them."""
