"""A problem file in; shapes at any time out, in the unit of lengths, without colours or a plotting library."""
