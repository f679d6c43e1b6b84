"""Words of three trades in one sentence each, with the other trades' word for the same thing (users.md 3.2)."""

from collections.abc import Mapping

WORDS: Mapping[str, tuple[str, str]] = {  # word -> (meaning, key of the cell that sets it)
    "QVZ": (
        "acknowledgement delay, Quittungsverzugszeit (Siemens: ADT): longest wait for DLE or NAK, after STX and after the block",
        "line.NAME.times.QVZ (or ADT), else by line.NAME.profile",
    ),
    "ZVZ": (
        "character delay, Zeichenverzugszeit (Siemens: CDT): longest gap between two characters of a block",
        "line.NAME.times.ZVZ (or CDT), else by line.NAME.profile",
    ),
    "BWZ": (
        "block wait time, Blockwartezeit: longest wait of a receiver for the repeat of a block it refused (Siemens, Bosch, rho 3)",
        "line.NAME.times.BWZ, else by line.NAME.profile",
    ),
    "KF": ("STEP 5 fixed point, 16 bits, -32768..32767", "db.NUMBER[AT].type"),
    "KH": ("STEP 5 hexadecimal word, 0..FFFF; at DL or DR one byte", "db.NUMBER[AT].type"),
    "KG": ("STEP 5 float, 32 bits, exponent first: not IEEE; only CPUs 135U and 155U have it", "db.NUMBER[AT].type"),
    "DH": ("STEP 5 double word, 32 bits fixed point", "db.NUMBER[AT].type"),
    "REAL": ("IEEE float, 32 bits, high word first", "db.NUMBER[AT].type"),
    "KV": ("gain of the position loop in 1/s: steady lag = speed / Kv", "plant.axis.NAME.kv_per_s"),
    "SYNC": ("CAN telegram (identifier 100) at which drives latch positions and take set values over", "bus.NAME.cycle_ms"),
}
ALIASES = {"ADT": "QVZ", "CDT": "ZVZ", "BLOCKWARTEZEIT": "BWZ", "QUITTUNGSVERZUGSZEIT": "QVZ", "ZEICHENVERZUGSZEIT": "ZVZ"}
ALSO_CALLED = {"QVZ": "ADT", "ZVZ": "CDT"}
MEANINGS: Mapping[str, tuple[tuple[str, str], ...]] = {  # word -> its other meanings, and their source
    "QVZ": (
        (
            "Quittungsverzug in an S5: a memory or an interface does not acknowledge an access; PAFE 4xh, ISTACK",
            "STEP 5; not a time of the line",
        ),
        ("under procedure 3964 (without R) a station has another, mostly shorter value, named below", "CP 341, CP 440"),
    ),
    "ZVZ": (
        ("it also runs from our DLE to the first character of the block, and from DLE ETX to the block check", "serial-protocols 1.4"),
        ("how long the line has to be quiet before a Siemens station answers stray characters with NAK", "CP 340"),
    ),
    "BWZ": (
        ("VIPA: longest wait from the acknowledged command to STX of the reaction telegram; line.NAME.times.reaction", "HB97E-CP, HB103E"),
        ("CP 341, event (10)05h: monitoring time of the reaction telegram, there by speed or 20 s", "SIMATIC CP 341"),
    ),
}
PARAMETERS: Mapping[str, tuple[str, str]] = {  # P number -> (meaning, unit); rho3 section 8
    "P2": ("machine configuration code, RC outputs 124..127", ""),
    "P3": ("number of timers and counters", ""),
    "P5": ("clock: interpolation, transformation and set-value cycle; 2..32 ms with CAN axes", "ms"),
    "P9": ("strobe time of coded outputs", "ms"),
    "P15": ("servo board types; 3 = CAN module", ""),
    "P20": ("I/O module configuration", ""),
    "P21": ("PLC bit-coupling ranges I.START, I.END, O.START, O.END", "byte"),
    "P24": ("user outputs cleared at control reset", ""),
    "P30": ("CAN buses: input blocks, output blocks, baud 0..3", ""),
    "P31": ("CAN input blocks: start byte, length, identifier 541..550", ""),
    "P32": ("CAN output blocks: start byte, length, identifier 471..480", ""),
    "P103": ("largest axis speed, automatic", "deg/s or mm/s"),
    "P104": ("PTP slope acceleration", "deg/s^2 or mm/s^2"),
    "P108": ("referencing speed", "deg/s or mm/s"),
    "P109": ("first reduced referencing speed", "deg/s or mm/s"),
    "P204": ("positive software limit", "deg or mm"),
    "P205": ("negative software limit, printed as a magnitude (AX-124)", "deg or mm"),
    "P207": ("actual value at the reference point", "deg or mm"),
    "P208": ("distance moved after the reference point", "deg or mm"),
    "P303": ("axis type: 3, 4 endless; 1, 4 manual axis", ""),
    "P306": ("of each kinematic; monitoring: sub-query 6, axis speeds on paths: 0 none, 1 abort, 2 manual, 3 limit with warning", ""),
    "P213": ("passing distances of R_PTP = 1 in joint coordinates", "deg or mm"),
    "P311": ("modulo value of endless axes", "deg"),
    "P313": ("of each kinematic: numbers of the components that hold x, y, z, a, b, c for a workpiece system, 0: not corrected", ""),
    "P401": ("measuring systems: module, referencing mode, gear factor, pulses, evaluation, output", ""),
    "P114": ("fast jog speed, and the drives' speed limit in manual mode", "deg/s or mm/s"),
    "P601": ("download of drive parameters at start", ""),
    "P602": ("booster type (number 2 of the download)", ""),
    "P603": ("motor type, SM (number 3)", ""),
    "P604": ("gain of the speed controller, SP (number 5)", "Nm s/rad (AX-267)"),
    "P605": ("integral time of the speed controller, SI (number 6)", "ms (AX-267)"),
    "P606": ("gain of the position controller, SG (number 7)", "1/s (AX-267)"),
    "P607": ("current limits automatic, manual, emergency stop, ST (numbers 10, 11, 14)", "% of rated (AX-267)"),
    "P608": ("slope of the emergency-stop ramp, SE (number 15)", "rpm/s (AX-267)"),
    "P609": ("speed at which the brake locks, SL (number 16)", "rpm (AX-267)"),
    "P610": ("largest static position error, SS (number 17)", "inc (AX-267)"),
    "P611": ("lag error relative to speed, SF (number 18)", "s (AX-267)"),
    "P612": ("bandwidth of the torque filter, SW (number 19)", "Hz (AX-267)"),
    "P613": ("damping of the second-order filter, SZ (number 20)", ""),
    "P614": ("zero shift of the position check-back, OO (number 22)", "inc (AX-267)"),
    "P615": ("over-temperature protection, OW (number 24)", ""),
}
