"""From a log of joint values to strides and a mean step."""
