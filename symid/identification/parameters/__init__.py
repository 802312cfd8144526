"""Physical from minimal parameters, with what is known of them beforehand."""
