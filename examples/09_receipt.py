"""A photograph on a simulated receipt printer: printed, and read back from the very bytes that a real
one would get. Writes examples/09_receipt.png."""

from pathlib import Path

from devices import decode, open_device
from halftone.cli.demo import PHOTOGRAPH

with open_device("mem:", "receipt-80mm") as printer:
    report = printer.print(PHOTOGRAPH, auto_levels=True)
    (paper,) = decode(printer.transport.data)

print(report)  # 1 page, 383 rows, 27,… bytes
paper.save(Path(__file__).with_suffix(".png"))
