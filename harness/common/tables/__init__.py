"""Tables as people and programs print them: text to names and cells; knows no mathematics."""

from esfem.common.tables.find_tables import table_in, tables_in
from esfem.common.tables.number_text import DecimalMark, decimal_mark, number, parsed
from esfem.common.tables.text_table import Row, TextTable

__all__ = [
    "DecimalMark",
    "Row",
    "TextTable",
    "decimal_mark",
    "number",
    "parsed",
    "table_in",
    "tables_in",
]
