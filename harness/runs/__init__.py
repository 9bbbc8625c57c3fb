"""Cases computed, one or many: stored, shared between processes, resumed where they stopped."""
