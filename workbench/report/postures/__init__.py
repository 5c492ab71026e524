"""The part of the report about people in postures."""
