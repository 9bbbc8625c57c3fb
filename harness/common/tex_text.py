"""Texts as LaTeX shows them, with any compiler that knows UTF-8 and T1."""

import unicodedata

ESCAPES = {character: f"\\{character}" for character in "{}$&%#_"} | {
    "\\": r"\textbackslash{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": "$<$",
    ">": "$>$",
    "|": "$|$",
}
PHRASES = {
    "L-infinity(0,T; H^1(Gamma))": r"$L^\infty(0,T;\,H^1(\Gamma))$",
    "L-infinity(0,T; H^1)": r"$L^\infty(0,T;\,H^1)$",
    "H^1": "$H^1$",
    "O(h^2)": "$O(h^2)$",
    "<=": r"$\le$",
    ">=": r"$\ge$",
}
GREEK = (
    *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa"),
    *("lamda", "mu", "nu", "xi", "pi", "rho", "sigma", "tau", "phi", "chi", "psi", "omega"),
)
SYMBOLS = {
    **{unicodedata.lookup(f"GREEK SMALL LETTER {n}"): f"$\\{n}$" for n in GREEK},
    **{"λ": r"$\lambda$", "Γ": r"$\Gamma$", "Δ": r"$\Delta$", "Ω": r"$\Omega$"},
    **{"≤": r"$\le$", "≥": r"$\ge$", "≈": r"$\approx$", "→": r"$\to$", "∞": r"$\infty$"},
    **{"∇": r"$\nabla$", "∫": r"$\int$", "√": r"$\surd$", "·": r"$\cdot$", "×": r"$\times$"},  # noqa: RUF001
    **{"±": r"$\pm$", "°": r"$^\circ$", "²": "$^2$", "³": "$^3$", "½": r"$\frac12$", "₀": "$_0$"},
    **{"₁": "$_1$", "₂": "$_2$", "–": "--", "—": "---", "…": r"\dots{}", "§": r"\S{}"},  # noqa: RUF001
    **{"‘": "`", "’": "'", "“": "``", "”": "''"},  # noqa: RUF001
}
LATIN_ENDS = 0x180


def escaped(text: str) -> str:
    """The text in LaTeX's own words; a character that it does not know is shown as its number."""
    for phrase, tex in PHRASES.items():
        if phrase in text:
            return tex.join(escaped(part) for part in text.split(phrase))
    return "".join(map(_character, text))


def one_line(text: str) -> str:
    """The text with every run of blanks and line ends as one blank: no line escapes a comment."""
    return " ".join(text.split())


def _character(character: str) -> str:
    if character in ESCAPES:
        return ESCAPES[character]
    if character in SYMBOLS:
        return SYMBOLS[character]
    known = character.isascii() or (character.isalpha() and ord(character) < LATIN_ENDS)
    return character if known else f"[U+{ord(character):04X}]"
