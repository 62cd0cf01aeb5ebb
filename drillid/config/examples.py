"""Keys of rig descriptions for logs of many shapes, for their documentation; a test checks each against the models."""

FORMATS = (
    "Logs are read by their content: delimited text (CSV), LAS 1.2 to 3.0, WITSML 1.3.1.1 and 1.4.1.1, "
    "WITS streams of level 0, TDMS, LabVIEW Measurement, HDF5, "
    "MATLAB, netCDF, zarr, workbooks, Feather and Parquet, plain or packed by gzip, bzip2, xz, zstd or zip. Delimiter, "
    "encoding, header, units, decimals and the form of the times are taken from the file where they are "
    "unambiguous; what was decided is a row of problems.csv, and what is ambiguous is refused with the key that "
    "settles it. `drillid inspect FILE…` lists the contents of files and drafts their description, "
    "`drillid check` tries it."
)
"""What is read, and how."""

SHAPES = {
    "LAS or WITSML, which state units and times": "channels: {torque_sweep: {column: SWEEP}, speed: {column: RPMA}}",
    "Seconds from a start that the file does not state": "time: {column: ETIM, start: '2025-03-03T06:00:00'}",
    "Milliseconds since 1970": "time: {column: ts, unit: ms}",
    "Serial dates of a workbook, on the rig's clock": "time: {unit: excel, zone: Europe/Oslo}",
    "MATLAB's datenum": "time: {column: t, unit: matlab}",
    "03/04/2025 06:00:00 PM, with the month first": "time: {format: month first, zone: America/Chicago}",
    "Years of two digits": "time: {format: '%d.%m.%y %H:%M:%S.%f', zone: Europe/Berlin}",
    "Date and time of day in two columns": "time: {column: Time, date: Date, zone: Europe/Oslo}",
    "Text with semicolons, decimal commas and points between thousands": (
        "file: {delimiter: semicolon, decimal: ',', thousands: .}"
    ),
    "Names in the fifth line, units in the sixth": "file: {header_line: 5, units_line: 6}",
    "No header at all": "file: {columns: [Time, SWEEP, RPM, DMEA]}",
    "One sheet, group or log of several": "file: {table: Data}",
    "A WITS stream, whose items have mnemonics and codes and no units; 0150 is an item of the user's": (
        "channels:\n"
        "  torque_sweep: {column: '0150', unit: kN m}\n"
        "  speed: {column: RPMA, unit: rpm}\n"
        "  hole_depth: {column: DMEA, unit: m}\n"
        "time: {zone: Europe/Oslo}"
    ),
    "A recorder's own number for missing values": "file: {null_values: [-32768]}",
    "A file whose units are wrong": "file: {ignore_units: true}",
    "Depth at 1 Hz in a file of its own, with a clock of its own": (
        "other_logs:\n"
        "  - files: '*_depth.csv'\n"
        "    time: {zone: Europe/Oslo}\n"
        "    channels: {hole_depth: {column: Depth, unit: m}, speed: {column: RPM, unit: rpm}}"
    ),
    "A channel that a mnemonic of WITS stands for, and that is not logged": (
        "channels: {torque_sweep: {column: SWEEP}, flow: null}"
    ),
}
"""Keys by the shape of logs for which they are needed."""
