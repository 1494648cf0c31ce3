"""Where to put the foot: footholds chosen on a terrain as discrete variables, and the checked walk over them."""
