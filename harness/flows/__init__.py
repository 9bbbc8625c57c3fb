"""One evolution of one surface: `esfem flow`, its files for ParaView, pictures and checks."""
