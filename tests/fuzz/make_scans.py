#!/usr/bin/env python3
"""make_scans.py FOLDER: small NIfTI and NRRD files of each encoding, for corpus/scan and as seeds of
mutated_volumes.py. The same bytes on every run."""
import gzip
import os
import struct
import sys

SIZES = (5, 4, 3)
COUNT = 60


def nifti1(order, datatype, dim):
    """A header with an sform, before its values at byte 352."""
    head = bytearray(352)
    struct.pack_into(order + "i", head, 0, 348)
    struct.pack_into(order + "8h", head, 40, len(dim), *dim, *[1] * (7 - len(dim)))
    struct.pack_into(order + "h", head, 70, datatype)
    struct.pack_into(order + "3f", head, 108, 352, 0.5, 1)
    struct.pack_into(order + "h", head, 254, 1)
    struct.pack_into(order + "12f", head, 280, -2, 0, 0, 9, 0, 2, 0, 8, 0, 0, 3, 7)
    head[344:347] = b"n+1"
    return bytes(head)


def nifti2(datatype, dim):
    """A header with a qform, before its values at byte 544."""
    head = bytearray(544)
    struct.pack_into("<i8sh", head, 0, 540, b"n+2\0\r\n\x1a\n", datatype)
    struct.pack_into("<8q", head, 16, len(dim), *dim, *[1] * (7 - len(dim)))
    struct.pack_into("<8d", head, 104, -1, 1, 2, 3, 1, 1, 1, 1)
    struct.pack_into("<q", head, 168, 544)
    struct.pack_into("<i", head, 344, 1)
    struct.pack_into("<6d", head, 352, 0.1, 0.2, 0.3, 5, 6, 7)
    return bytes(head)


def nrrd(encoding, kind="short"):
    return (f"NRRD0004\ntype: {kind}\ndimension: 3\nspace: left-posterior-superior\nsizes: 5 4 3\n"
            "space directions: (1,0,0) (0,1,0) (0,0,2)\nkinds: domain domain domain\n"
            f"endian: little\nencoding: {encoding}\nspace origin: (-3,2,1)\n\n").encode()


def main():
    folder = sys.argv[1]
    numbers = [n * 37 % 251 for n in range(COUNT)]
    shorts = struct.pack(f"<{COUNT}h", *numbers)
    files = {
        "int16.nii": nifti1("<", 4, SIZES) + shorts,
        "big.nii": nifti1(">", 16, SIZES) + struct.pack(f">{COUNT}f", *numbers),
        "rgb.nii": nifti1("<", 128, SIZES) + bytes(numbers * 3),
        "frames.nii.gz": gzip.compress(nifti1("<", 4, SIZES + (2,)) + shorts * 2, mtime=0),
        "second.nii": nifti2(64, SIZES) + struct.pack(f"<{COUNT}d", *numbers),
        "vectors.nii": nifti2(4, SIZES + (1, 3)) + shorts * 3,
        "raw.nrrd": nrrd("raw") + shorts,
        "gzip.nrrd": nrrd("gzip") + gzip.compress(shorts, mtime=0),
        "text.nrrd": nrrd("text", "float") + " ".join(f"{n / 8}" for n in numbers).encode(),
        "hex.nrrd": nrrd("hex") + shorts.hex().encode(),
        "list.nrrd": (b"NRRD0005\ntype: uchar\ndimension: 4\nsizes: 5 4 3 2\n"
                      b"spacings: 1 2 3 nan\nencoding: raw\n\n") + bytes(numbers * 2),
    }
    os.makedirs(folder, exist_ok=True)
    for name, data in files.items():
        with open(os.path.join(folder, name), "wb") as file:
            file.write(data)


if __name__ == "__main__":
    main()
