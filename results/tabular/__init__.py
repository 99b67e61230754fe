"""Results in; tables that spreadsheets, pandas and MATLAB read, one row a time, out."""
