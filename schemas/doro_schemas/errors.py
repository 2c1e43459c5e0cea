"""The one error type of the wire: a message, file or setting that is refused."""


class Refused(ValueError):  # noqa: N818 - named for what happened, as in Rejected
    """Something from outside does not fit and is refused; nothing else is affected.

    The text is one sentence that says what is wrong, where, and what to do. At a
    service's edge it is counted, published on ``doro/rejected`` and the service
    goes on (see :mod:`doro_schemas.bus`).
    """

    def __init__(self, reason: str, *, episode: str = "", frame: int = -1) -> None:
        super().__init__(reason)
        self.reason = reason
        self.episode = episode
        self.frame = frame
