"""Text files of old controllers and programming devices, whose code page no file names."""

UMLAUTS = "äöüÄÖÜß"
DOS, WINDOWS = "cp850", "cp1252"
END_OF_FILE = b"\x1a"  # written by the editors of DOS; what follows it is not text


def decoded(data: bytes) -> str:
    """UTF-8 or UTF-16 where they are marked or fit; else the code page of DOS or of Windows, by whose umlauts are more."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace")
    data = data.partition(END_OF_FILE)[0]
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        dos, windows = (sum(data.count(octet) for octet in (letter.encode(page) for letter in UMLAUTS)) for page in (DOS, WINDOWS))
        return data.decode(DOS if dos > windows else WINDOWS, errors="replace")
