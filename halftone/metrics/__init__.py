"""Instruments: how far what a device shows is from the picture, and what patterns it has."""

from halftone.metrics.error import hpsnr, psnr
from halftone.metrics.spectra import periodogram, tonal_peak

__all__ = ["hpsnr", "periodogram", "psnr", "tonal_peak"]
