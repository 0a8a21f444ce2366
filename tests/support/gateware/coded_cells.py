"""Coded cells by the text of the protocol page: bit by bit, for the tests alone."""


def numbers_of(altitudes, width, altitude_bits):
    """Return the coded error of the prediction of each cell."""
    coded = []
    for number, altitude in enumerate(altitudes):
        column, row = number % width, number // width

        def at(x, y):
            return altitudes[y * width + x]

        if column and row:
            rise = altitude - at(column - 1, row)
            rise -= at(column, row - 1) - at(column - 1, row - 1)
        elif column:
            rise = altitude - at(column - 1, 0)
        else:
            rise = altitude - (at(0, row - 1) if row else 0)
        rise %= 1 << altitude_bits
        if rise >= 1 << altitude_bits - 1:
            rise -= 1 << altitude_bits
        coded.append(2 * rise if rise >= 0 else -2 * rise - 1)
    return coded


def encode(altitudes, width, altitude_bits, remainder_bits):
    """Return the bytes of cells by rows, and the bits after each cell."""
    bits, ends = "", []
    numbers = numbers_of(altitudes, width, altitude_bits)
    for altitude, number in zip(altitudes, numbers, strict=True):
        quotient, remainder = divmod(number, 1 << remainder_bits)
        if quotient < 15:
            bits += "1" * quotient + "0" + lowest_first(remainder, remainder_bits)
        else:
            bits += "1" * 15 + lowest_first(altitude, altitude_bits)
        ends.append(len(bits))
    whole = bits + "0" * (-len(bits) % 8)
    data = bytes(int(whole[i : i + 8][::-1], 2) for i in range(0, len(whole), 8))
    return data, ends


def lowest_first(number, count):
    """Return ``count`` bits of a number as text, the lowest first."""
    return "".join(str(number >> i & 1) for i in range(count))
