# SPDX-License-Identifier: BSD-3-Clause
"""What magimu raises. Every message says what is wrong and what to do about it."""


class InputError(ValueError):
    """Input that cannot be read or used.

    Attributes:
        file: of the file or argument; empty where there is none.
        line, column: where in the file, from 1; 0: not known.
        problem: what is wrong.
        remedy: what to do.
    """

    def __init__(self, message: str, file: str = "", line: int = 0, column: int = 0,
                 problem: str = "", remedy: str = "") -> None:
        super().__init__(message)
        self.file = file
        self.line = line
        self.column = column
        self.problem = problem
        self.remedy = remedy


def refused(where: str, problem: str, remedy: str) -> InputError:
    """The exception for an argument: what is wrong with it, and what to give instead."""
    return InputError(f"{where}: {problem}; {remedy}", file=where, problem=problem, remedy=remedy)


class TooLittleError(InputError):
    """The recording can be read, but there is too little in it for what is asked."""


class NotTrustedError(InputError):
    """The calibration says of itself that it must not be used."""


class NumericalError(ArithmeticError):
    """Numbers that are not finite, or a matrix that is singular, where it must not be."""
