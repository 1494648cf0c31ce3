"""What a notebook shows: small pictures as SVG, cards as HTML, animations. Knows no gait, only lines and words."""
