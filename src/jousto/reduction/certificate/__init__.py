"""The certificate of a reduction: what was checked, compared and found."""
