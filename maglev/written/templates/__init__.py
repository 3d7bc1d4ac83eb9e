"""Controllers to begin with: `maglev new` copies them."""
