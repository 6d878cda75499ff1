"""Words of other robot languages, and what ARPS has in their place: a program of another make is told so.

V+ and VAL II: V+ language reference guide, Adept. AS: AS language reference manual, Kawasaki. RAPID: instructions,
functions and data types, ABB 3HAC050917. KRL: KUKA system software, operating and programming instructions.
"""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ["FOREIGN", "OTHERWISE", "foreign_hint"]

_NONE = ""
_NO_TYPES = "left out: a variable needs no declaration, LOCAL and AUTO make it a program's own"
_CONFIGURATION = "LEFTY, RIGHTY, ABOVE, BELOW, FLIP or NOFLIP"
_SHARED = "left out: variables are shared by all programs unless LOCAL or AUTO declares them"


def _each(words: str, ours: str) -> dict[str, str]:
    """Give several words the same answer."""
    return dict.fromkeys(words.split(), ours)


_V_PLUS: Mapping[str, str] = {
    **_each("MOVET MOVEST", "MOVE or MOVES, then OPEN or CLOSE"),
    **dict.fromkeys(
        ("REACT", "REACTI", "REACTE", "IGNORE", "LOCK", "UNLOCK", "INT.EVT", "WAIT.EVENT", "SET.EVENT"), _NONE
    ),
    **dict.fromkeys(
        ("PCEXECUTE", "PCABORT", "PCEND", "EXECUTE", "ABORT", "KILL", "RELEASE", "PRIME", "CYCLE.END"), _NONE
    ),
    **dict.fromkeys(
        ("PROMPT", "WRITE", "READ", "GETC", "ATTACH", "DETACH", "FOPEN", "FCLOSE", "FSEEK", "IOSTAT"), _NONE
    ),
    **_each("ENABLE DISABLE SWITCH PARAMETER DRY.RUN CALIBRATE RUNSIG POWER", _NONE),
    **dict.fromkeys(
        ("ALIGN", "NEST", "MOVEF", "MOVESF", "MOVEC", "DURATION", "PROFILE", "PAYLOAD", "MC", "INRANGE"), _NONE
    ),
    **_each("BITS DIN DOUT ADC DAC AIO.IN AIO.OUT LATCH LATCHED #LATCH", _NONE),
    **dict.fromkeys(
        ("BELT", "SETBELT", "DEFBELT", "WINDOW", "STATE", "TASK", "ID", "LAST", "$ERROR", "ERROR", "TIME"), _NONE
    ),
    **_each("INTON INTOFF SINGLE MULTIPLE WEAVE TEACH GAIN.SET SETDEVICE", _NONE),
    **dict.fromkeys(
        ("$DECODE", "$UNPACK", "PACK", "$PACK", "$TIME", "$INTB", "$FLTB", "INTB", "FLTB", "STRDIF"), _NONE
    ),
    **_each("VDISPLAY VWINDOW SELECT TRACE FLOAT PENDANT RETRY PROCEED", _NONE),
    "NONULL": "COARSE",
    "RELAXI": "OPENI",
    "GRASP": "CLOSEI",
    "EXIT": "GOTO, to a label behind the loop",
    "NEXT": "GOTO, to a label at the end of the loop",
    "GLOBAL": _SHARED,
    "#DEST": "HERE: SET #p = HERE",
    "#PDEST": "HERE: SET #p = HERE",
    "OUTSIDE": _NONE,
}
_FULL_ARPS: Mapping[str, str] = _each(
    "MOVET MOVEF ALIGN NEST REACT REACTI IGNORE PCEXECUTE PCABORT PROMPT WRITE ATTACH DETACH BITS DIN "
    "DOUT ADC DAC INTON INTOFF SINGLE MULTIPLE ENABLE DISABLE SWITCH FORCE.READ FORCE.BIAS WAIT.FORCE "
    "GUARD COMPLY HYBRID GOTO.POSE FOLLOW ROTATE STOP.BASE",
    _NONE,
)
_AS: Mapping[str, str] = {
    "JMOVE": "MOVE",
    "LMOVE": "MOVES",
    "JAPPRO": "APPRO",
    "LAPPRO": "APPROS",
    "JDEPART": "DEPART",
    "LDEPART": "DEPARTS",
    **_each("HOME HOME2", "READY"),
    **dict.fromkeys(
        ("C1MOVE", "C2MOVE", "HMOVE", "XMOVE", "FMOVE", "TDRAW", "ALIGN", "ONI", "ONE", "PULSE", "DLYSIG"), _NONE
    ),
    **dict.fromkeys(
        ("BRAKE", "WEIGHT", "MVWAIT", "PCEXECUTE", "SCALL", "HSIGNAL", "RUNMASK", "SLOW_REPEAT", "ENV_DATA"), _NONE
    ),
    **_each("HOLD CYCLE TRACE FLOAT SFLOW CONTINUE", _NONE),
    "SWAIT": "WAIT.SIGNAL",
    "TWAIT": "DELAY",
    "STABLE": "DELAY",
    "UTIMER": "TIMER",
    **_each("PRINT IFPWPRINT", "TYPE"),
    "ACCURACY": "COARSE or FINE",
    "DECEL": "ACCEL, which holds for braking too",
    "POINT": "SET",
    "UWRIST": "FLIP or NOFLIP",
    "DWRIST": "FLIP or NOFLIP",
    **_each("OPENS OPEND", "OPENI"),
    **_each("CLOSES CLOSED", "CLOSEI"),
    **_each("SCASE SVALUE", "CASE and VALUE, of numbers"),
}
_RAPID: Mapping[str, str] = {
    "MOVEJ": "MOVE",
    "MOVEL": "MOVES",
    "MOVEABSJ": "MOVE, to a precision point #p",
    **dict.fromkeys(
        ("MOVEC", "MOVELDO", "MOVEJDO", "TRIGGL", "TRIGGJ", "SEARCHL", "SINGAREA", "GRIPLOAD", "ACTUNIT"), _NONE
    ),
    **_each("PROC MODULE", ".PROGRAM name()"),
    **_each("ENDPROC ENDMODULE ENDFUNC", ".END"),
    "FUNC": ".PROGRAM name(), which gives its result in a parameter",
    **dict.fromkeys(
        ("VAR", "PERS", "CONST", "NUM", "ROBTARGET", "JOINTTARGET", "TOOLDATA", "WOBJDATA", "SPEEDDATA"), _NO_TYPES
    ),
    **_each("ENDIF ENDWHILE ENDFOR ENDTEST", "END"),
    "TEST": "CASE value OF",
    "DEFAULT": "ANY",
    "TPWRITE": "TYPE",
    **_each("PDISPON PDISPOFF PDISPSET EOFFSON EOFFSOFF EOFFSSET", _NONE),
    **_each("TPREADNUM TPREADFK TPERASE CONNECT TRAP ISIGNALDI IDELETE", _NONE),
    **_each("PULSEDO SETGO SETAO STOPMOVE STARTMOVE RAISE RETRY TRYNEXT", _NONE),
    "WAITTIME": "DELAY",
    "WAITUNTIL": "WAIT",
    **_each("WAITDI WAITDO", "WAIT.SIGNAL"),
    "SETDO": "SIGNAL",
    **_each("INVERTDO", "SIGNAL"),
    **_each(
        "PATHACCLIM SOFTACT SOFTDEACT PATHRESOL WORLDACCLIM MOTIONSUP PATHRECSTART",
        _NONE,
    ),
    "OFFS": "SHIFT(location BY dx, dy, dz)",
    "RELTOOL": "location:TRANS(dx, dy, dz)",
    "CROBT": "WHERE",
    "CJOINTT": "WHERE: SET #p = WHERE",
    "POSEMULT": "first:second",
    "POSEINV": "INVERSE",
    "ORIENTZYX": "TRANS",
    "EULERZYX": "DECOMPOSE",
    "ACCSET": "ACCEL",
    "VELSET": "SPEED",
    **_each("CONFL CONFJ", _CONFIGURATION),
    "EXIT": "STOP",
    "ASIN": "ATAN2(x, SQRT(1 - SQR(x)))",
    "ATAN": "ATAN2(x, 1)",
    "ROUND": "INT(x + 0.5)",
    "INCR": "x = x + 1",
    "DECR": "x = x - 1",
    **_each("CLKSTART CLKRESET CLKREAD CLKSTOP", "TIMER"),
}
_KRL: Mapping[str, str] = {
    **_each("PTP SPTP", "MOVE"),
    **_each("LIN SLIN", "MOVES"),
    "LIN_REL": "DRAW",
    "PTP_REL": "DRIVE, one joint at a time",
    **_each("CIRC CIRC_REL SCIRC SPLINE INTERRUPT TRIGGER BRAKE RESUME PULSE", _NONE),
    **_each("ONEXIT", _NONE),
    **_each("ADVANCE ANIN ANOUT DIGIN CONTINUE EXT EXTFCT", _NONE),
    "DEF": ".PROGRAM name()",
    "DEFFCT": ".PROGRAM name(), which gives its result in a parameter",
    **_each("DECL REAL BOOL CHAR E6POS AXIS E6AXIS STRUC ENUM", _NO_TYPES),
    **_each("ENDFOR ENDWHILE ENDIF ENDSWITCH", "END"),
    "ENDFCT": ".END",
    "SWITCH": "CASE value OF",
    "DEFAULT": "ANY",
    "LOOP": "WHILE TRUE DO",
    "ENDLOOP": "END",
    "REPEAT": "DO ... UNTIL",
    "SEC": "DELAY: WAIT takes a condition",
    "BAS": "SPEED, ACCEL, TOOL and BASE",
    "EXIT": "GOTO, to a label behind the loop",
    "$OUT": "SIGNAL",
    "$IN": "SIG(signal)",
    "$VEL": "SPEED",
    "$ACC": "ACCEL",
    "$POS_ACT": "WHERE",
    "$AXIS_ACT": "WHERE: SET #p = WHERE",
    "$TOOL": "TOOL",
    "$BASE": "BASE",
}
_TRIGONOMETRY = {
    "TAN": "SIN(x)/COS(x)",
    "ACOS": "ATAN2(SQRT(1 - SQR(x)), x)",
}
_LANGUAGES = {
    "the full ARPS": _FULL_ARPS,
    "V+": _V_PLUS,
    "AS": _AS,
    "RAPID": {**_RAPID, **_TRIGONOMETRY},
    "KRL": {**_KRL, **_TRIGONOMETRY},
}


def _gathered() -> dict[str, dict[str, str]]:
    found: dict[str, dict[str, str]] = {}
    for language, words in _LANGUAGES.items():
        for word, ours in words.items():
            found.setdefault(word, {})[language] = ours
    return found


FOREIGN: Mapping[str, Mapping[str, str]] = _gathered()
"""By word in capitals: of each language that has it, what ARPS has in its place; "" where there is nothing yet."""


OTHERWISE: Mapping[str, str] = {
    "SET": "SET gives a location its value: SET name = location; an output is switched on by SIGNAL",
    "RESET": "RESET takes no value and switches every signal off; one output is switched off by SIGNAL -n",
}
"""Words of ours that mean something else in RAPID: what to write instead, where one does not fit."""


def foreign_hint(word: str) -> str:
    """Return what to write in place of a word of another robot language, or that there is nothing yet; else "".

    Parameters
    ----------
    word : in any letter case; what follows a point, as in `$VEL.CP`, may be left out of the table.
    """
    name = word.upper()
    of = FOREIGN.get(name) or FOREIGN.get(name.partition(".")[0] if name.startswith("$") else name)
    if of is None:
        return ""
    answers: dict[str, list[str]] = {}
    for language, ours in of.items():
        answers.setdefault(ours, []).append(language)
    return "; ".join(
        f"{word} is a word of {' and '.join(languages)}: " + (f"here it is {ours}" if ours else "not there yet")
        for ours, languages in answers.items()
    )
