"""The error tree: every message names the place, what is wrong there, and what to do."""


class DrillidError(Exception):
    """What went wrong, where, and the remedy, as one sentence each.

    Parameters
    ----------
    where : file, sheet row, column, well or interval of time the message is about
    what : what is wrong there
    remedy : what the user can do about it
    """

    def __init__(self, where: str, what: str, remedy: str) -> None:
        self.where, self.what, self.remedy = where, what, remedy
        super().__init__(where, what, remedy)

    def __str__(self) -> str:
        return f"{self.where}: {self.what}. {self.remedy}"


class SettingsError(DrillidError):
    """A setting, sheet or rig description that cannot be used."""


class LogError(DrillidError):
    """A raw log that cannot be read or lacks what it must hold."""


class DatasetError(DrillidError):
    """A dataset that does not match its declared schema."""


class EstimationError(DrillidError):
    """Data that carry too little to estimate what was asked for."""
