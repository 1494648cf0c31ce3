"""From the bytes of a recording to a log of joint values."""
