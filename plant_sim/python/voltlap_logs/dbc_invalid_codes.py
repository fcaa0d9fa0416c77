# SPDX-License-Identifier: Apache-2.0
"""Raw values of a signal by which the sender says that there is no measurement, where the file says so: its value
table, its comment, an attribute, or that it keeps to SAE J1939."""
from __future__ import annotations

import re

NO_VALUE = (r"(?:(?:sig(?:nal)?|value|data|sensor|measurement)?\s*(?:is\s+)?not\s+(?:avail\w*|valid|present|connected|"
            r"defined|known|init\w*|measured)|unavail\w*|invalid\w*|error|err|fault\w*|fail(?:ed|ure)|sna|n\s*/\s*a|na|"
            r"nan|unknown|undefined|undef|reserved|init(?:iali[sz]\w*)?|missing|disconnected|"
            r"no\s+(?:value|data|signal|measurement|sensor))")
IN_A_NAME = re.compile(rf"\b{NO_VALUE}\b", re.IGNORECASE)
DENIED = re.compile(r"\b(?:no|not|without|non)\s+(?:\w+\s+)?(?:error|err|fault\w*|fail\w*|invalid\w*|unknown)\b|"
                    r"\berror\s+free\b", re.IGNORECASE)
CODE = r"(?:0x[0-9a-f]+|\b[0-9a-f]*[0-9][0-9a-f]*h\b|\bff+\b|-?\b\d+(?:\.\d+)?\b)"
LINK = r"\s*['\"]?\s*(?:=+>?|:|->|means?|is|are|indicates?|denotes?|stands\s+for|signals|\(|if|when|,)\s*['\"]?\s*"
OF_WHAT = r"(?:(?:sensor|signal|value|data|measurement|reading|communication)\s+)?"
# "0xFFFF = invalid", "65535: not available", "FF means error"
CODE_FIRST = re.compile(rf"(?P<code>{CODE}){LINK}(?:the\s+|an?\s+)?{OF_WHAT}{NO_VALUE}\b", re.IGNORECASE)
# "invalid = 0xFFFF", "not available: 255", "SNA (0xFF)", "invalid value 0x8000"
WORD_FIRST = re.compile(rf"\b{NO_VALUE}(?:\s+(?:value|code))?(?:{LINK}|\s+(?=0x))(?P<code>{CODE})", re.IGNORECASE)
ATTRIBUTE = re.compile(r"invalid|sna$|notavail", re.IGNORECASE)
J1939 = re.compile(r"\bj1939\b", re.IGNORECASE)


def says_no_value(text: str) -> bool:
    """Whether the name of a value is one of "no value": SNA, NotAvailable, Signal_invalid, but not NoError."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text).replace("_", " ").replace("-", " ")
    return bool(IN_A_NAME.search(words)) and not DENIED.search(words)


def raw_of(code: str, signal) -> int | None:
    """The raw value, without sign, for a code in words: raw as a rule, else a value that the signal can have."""
    top = 1 << signal.length
    text = code.lower()
    if text.startswith("0x"):
        number = int(text, 16)
    elif text.endswith("h"):
        number = int(text[:-1], 16)
    elif re.fullmatch("ff+", text):
        number = int(text, 16)
    else:
        number = float(text)
        if number.is_integer():
            number = int(number)
    lowest = -(top >> 1) if signal.is_signed else 0
    if isinstance(number, int) and lowest <= number < top:
        return number % top
    if not signal.scale:
        return None
    raw = (number - signal.offset) / signal.scale
    if abs(raw - round(raw)) > 1e-6 or not lowest <= round(raw) < top:
        return None
    return round(raw) % top


def from_comment(signal) -> list[int]:
    text = signal.comment or ""
    codes = [match.group("code") for rule in (CODE_FIRST, WORD_FIRST) for match in rule.finditer(text)
             if not DENIED.search(match.group())]
    return [raw for raw in (raw_of(code, signal) for code in codes) if raw is not None]


def from_attributes(signal) -> list[int]:
    attributes = getattr(signal.dbc, "attributes", None) or {}
    out = []
    for name, attribute in attributes.items():
        if ATTRIBUTE.search(name) and re.fullmatch(CODE, str(attribute.value).strip(), re.IGNORECASE):
            out.append(raw_of(str(attribute.value).strip(), signal))
    return [raw for raw in out if raw is not None]


def j1939_ranges(length: int) -> list[list[int]]:
    """SAE J1939-71, 5.1.4: of a byte 0xFE is error and 0xFF not available, of a longer signal all values whose most
    significant byte is one of these."""
    if length < 8:
        return []
    return [[0xFE << (length - 8), (1 << length) - 1]]


def protocol_is_j1939(message, database) -> bool:
    protocol = getattr(getattr(database, "dbc", None), "attributes", None) or {}
    named = protocol.get("ProtocolType")
    text = str(named.value) if named is not None else ""
    return getattr(message, "protocol", None) == "j1939" or bool(J1939.search(text))


def keeps_to_j1939(signal, message, database) -> bool:
    texts = [signal.comment, message.comment]
    # A file may name the protocol and hold plain frames of 11 bits beside it, which have nothing of it.
    protocol = message.is_extended_frame and protocol_is_j1939(message, database)
    return protocol or any(J1939.search(text or "") for text in texts)


def is_state(signal) -> bool:
    """Whether the values are states with names, such as off, on, fault: then each of them is one, the fault as well."""
    ordinary = [name for name in (signal.choices or {}).values() if not says_no_value(str(name))]
    return len(ordinary) >= 2 and signal.scale == 1 and signal.offset == 0 and not signal.unit


def invalid_codes(signal, message, database) -> list[list[int]]:
    """[[first, last], ...] of raw values taken as bits, without sign."""
    if signal.is_float:
        return []
    top = 1 << signal.length
    named = {} if is_state(signal) else signal.choices or {}
    singles = {int(raw) % top for raw, name in named.items() if says_no_value(str(name))}
    if getattr(signal, "raw_invalid", None) is not None:
        singles.add(int(signal.raw_invalid) % top)
    singles.update(from_comment(signal))
    singles.update(from_attributes(signal))
    ranges = [[raw, raw] for raw in sorted(singles)]
    if not signal.is_signed and keeps_to_j1939(signal, message, database):
        ranges += j1939_ranges(signal.length)
    return ranges
