"""UDP: commands and joint states in, setpoints out, a JSON message per datagram (docs/streaming.md)."""

from __future__ import annotations

import errno
import hmac
import os
import secrets
import socket
import time
from collections.abc import Callable, Collection, Iterator

from ...arm.arm import Arm, require_arm
from ...support.checks import require, require_clock, require_names
from ...support.errors import InputError, listed, quote
from ...support.files import as_path, read_bounded, why_no_file
from ...support.interrupts import Closeable
from ...support.strict_json import LARGEST_MESSAGE, encode
from .inbox import CommandInput, Inbox, StateInbox, StateInput
from .messages import motor_side, parse_state, setpoint_message
from .protocols import MESSAGE_TIMEOUT, Setpoint, UndeliveredError

LOOPBACK = "127.0.0.1"  # Default host. Only programs on this machine may then move the arm.
# Bytes of the system's buffer, which it doubles: one message of the largest size, or some 350 small ones. A larger
# buffer would only deliver older messages in a flood.
BUFFER = 128 * 1024
MOST_PER_CYCLE = 512  # Datagrams read in one cycle, about a millisecond's work: more than the buffer holds.
WINDOW = 2 * 10**9  # Nanoseconds for the difference of two computers' clocks plus the travel of a datagram.


class Socket(Closeable):
    """A nonblocking UDP socket, a context manager: it listens on host and port, or sends there.

    Raises InputError for an unusable host or port.
    """

    def __init__(self, host: str, port: int, *, listens: bool) -> None:
        family, address = _resolved(host, port, smallest=0 if listens else 1)
        self.socket = socket.socket(family, socket.SOCK_DGRAM)
        self.socket.setblocking(False)
        try:
            if listens:
                self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
                self.socket.bind(address)
            else:  # connected, so that the system says when no program listens there
                self.socket.connect(address)
        except OSError as error:
            self.close()
            way = "listen on" if listens else "send to"
            raise InputError(f"cannot {way} {host}:{port}: {error.strerror or error}") from error

    @property
    def address(self) -> tuple[str, int]:
        """The socket's host and port."""
        host, port = self.socket.getsockname()[:2]
        return str(host), int(port)

    def close(self) -> None:
        """Give the port back. Harmless when repeated."""
        self.socket.close()


class Receiver(Socket):
    """A socket that listens on host and port (0: a free one, see `address`).

    timeout [s]: how long a message counts. senders: allowed hosts, empty for all. key: the key that signs the datagrams
    (see `Signer`, `read_key`). units: "joint"; of joint states also "motor" or "counts" (see `MotorSide`). The inbox's
    note counts the dropped datagrams and gives the last reason. Raises InputError for an unusable host or port, and for
    an invalid key.
    """

    _inbox: Inbox | StateInbox
    _begin: Callable[..., None]

    def __init__(
        self,
        arm: Arm,
        host: str = LOOPBACK,
        port: int = 0,
        *,
        timeout: float = MESSAGE_TIMEOUT,
        senders: Collection[str] = (),
        key: bytes | None = None,
        units: str = "joint",
    ) -> None:
        self._begin(arm, timeout, units)
        self._allowed = _addresses(require_names(senders, "senders"))
        self._verifier = None if key is None else Verifier(key)
        self._left_out = 0
        super().__init__(host, port, listens=True)

    def arrivals(self) -> Iterator[tuple[str, bytes]]:
        """(sender's address, text) of the datagrams that count. Others move nothing and stop nothing."""
        for (host, port), datagram in self.waiting():
            text = self._checked(host, port, datagram)
            if text is not None:
                yield named(host, port), text

    def _checked(self, host: str, port: int, datagram: bytes) -> bytes | None:
        try:
            if self._allowed and host.partition("%")[0].removeprefix("::ffff:") not in self._allowed:
                raise InputError("it is not an allowed sender")
            return datagram if self._verifier is None else self._verifier.verified(datagram)
        except InputError as error:
            self._left_out += 1
            last = f"the last from {named(host, port)}: {error}"
            self._inbox.note = f"; {self._left_out} datagrams were left out, {last}"
            return None

    def waiting(self) -> Iterator[tuple[tuple[str, int], bytes]]:
        """What has arrived, as (sender's host and port, datagram), at most `MOST_PER_CYCLE` of them."""
        for _ in range(MOST_PER_CYCLE):
            try:
                # One byte more than a message may have, so that what is too long is seen to be.
                datagram, sender = self.socket.recvfrom(LARGEST_MESSAGE + 1)
            except BlockingIOError:
                return
            yield (str(sender[0]), int(sender[1])), datagram


class UdpSource(Receiver, CommandInput):
    """Commands from datagrams. A sender is an address with its port."""


class UdpFeedback(Receiver, StateInput):
    """Joint states from datagrams."""

    _state_of = staticmethod(parse_state)


class UdpSink(Socket):
    """Setpoints as datagrams to host and port, signed if there is a key (see `Signer`).

    units: "joint", or "motor" or "counts" to include the motors (see `MotorSide`).

    Raises InputError for an unusable host or port, and for an invalid key.
    """

    def __init__(
        self, arm: Arm, host: str = LOOPBACK, port: int = 0, *, key: bytes | None = None, units: str = "joint"
    ) -> None:
        self._arm = require_arm(arm)
        self._motors = motor_side(arm, units)
        self._signer = None if key is None else Signer(key)
        super().__init__(host, port, listens=False)
        self.receiver = named(host, port)

    def write(self, setpoint: Setpoint) -> None:
        """Send the setpoint. Raises `UndeliveredError` without a listener, OSError if it cannot send.

        The system reports a refusal at the next call, in place of its result. So it is read before sending (a new
        listener) and after (an immediate answer).
        """
        text = encode(setpoint_message(self._arm, setpoint, self._motors)).encode()
        refused = self._refused()
        try:
            self.socket.send(text if self._signer is None else self._signer.sign(text))
            refused = self._refused() or refused
        except ConnectionRefusedError:  # an answer that came just now
            refused = True
        if refused:
            raise UndeliveredError(f"nobody listens at {self.receiver}")

    def _refused(self) -> bool:
        error = self.socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if error not in (0, errno.ECONNREFUSED):
            raise OSError(error, os.strerror(error))
        return error != 0


def named(host: str, port: int) -> str:
    """`127.0.0.1:5005`, `[::1]:5005`."""
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"


def _resolved(host: str, port: int, smallest: int) -> tuple[socket.AddressFamily, tuple[str, int]]:
    require(host, str, "host", "such as '127.0.0.1', with the port beside it")
    if not isinstance(port, int) or isinstance(port, bool) or not smallest <= port <= 65535:
        raise InputError(f"a port is a whole number from {smallest} to 65535; got {quote(port)}")
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
    except (OSError, UnicodeError, ValueError) as error:
        raise InputError(f"no host {host!r}: {error}") from error
    return family, (str(address[0]), int(address[1]))


def _addresses(hosts: Collection[str]) -> set[str]:
    """Every address of these hosts, the zone left out."""
    try:
        found = [address for host in hosts for address in socket.getaddrinfo(host, None)]
    except (OSError, UnicodeError) as error:
        raise InputError(f"no such host among those that may send, {listed(hosts)}: {error}") from error
    return {str(address[0]).partition("%")[0] for *_, address in found}


def read_key(path: str | os.PathLike[str]) -> bytes:
    """The key in a file without surrounding white space. Raises InputError for an unreadable file or an invalid key."""
    file = as_path(path)
    try:
        key = read_bounded(file, 2048).strip()
    except (OSError, ValueError) as error:
        raise InputError(f"the key {quote(str(path))}: {why_no_file(file, error)}") from error
    return checked_key(key)


def checked_key(key: bytes) -> bytes:
    """A checked key. Raises InputError without its bytes."""
    if not isinstance(key, bytes) or not 16 <= len(key) <= 1024:
        raise InputError("a key is 16 to 1024 bytes: `openssl rand -hex 32 > key` makes one")
    return key


def _mac(key: bytes, *parts: bytes) -> bytes:
    return hmac.digest(key, b" ".join(parts), "sha256").hex().encode()


class Signer:
    """Signs datagrams: `session counter mac text`, mac = HMAC-SHA256(key, "session counter text") (RFC 2104) in hex.

    session: 16 hexadecimal digits, drawn at the start. counter: nanoseconds since 1970, above the last one's.
    """

    def __init__(self, key: bytes, now: Callable[[], int] = time.time_ns) -> None:
        self._key, self._now, self._counter = checked_key(key), require_clock(now, "now"), 0
        self._session = secrets.token_hex(8).encode()

    def sign(self, text: bytes) -> bytes:
        """The text as a signed datagram."""
        self._counter = max(self._counter + 1, self._now())
        counted = self._session, b"%d" % self._counter
        return b" ".join((*counted, _mac(self._key, *counted, require(text, bytes, "text", "a message encoded")), text))


class Verifier:
    """Accepts signed datagrams once each, in order, within 2 s of this computer's clock, none from before its start."""

    def __init__(self, key: bytes, now: Callable[[], int] = time.time_ns) -> None:
        self._key, self._now = checked_key(key), require_clock(now, "now")
        self._floor = self._now()
        self._counters: dict[bytes, int] = {}

    def verified(self, datagram: bytes) -> bytes:
        """The text in a datagram. InputError where it is unsigned, forged, old, or was here before."""
        session, *parts = require(datagram, bytes, "datagram", "as it arrived").split(b" ", 3)
        if len(parts) != 3 or len(session) != 16 or not parts[0].isdigit() or len(parts[0]) > 20:
            raise InputError("it is not signed")
        digits, mac, text = parts
        # In constant time: how long a comparison takes would tell a forger how much of a signature is right.
        if not hmac.compare_digest(mac, _mac(self._key, session, digits, text)):
            raise InputError("its signature is wrong: the keys differ, or it was forged")
        counter, now = int(digits), self._now()
        if abs(counter - now) > WINDOW:
            raise InputError(f"its time is {(counter - now) / 1e9:+.3g} s from ours (at most 2 s): set both clocks")
        if counter <= max(self._floor, self._counters.get(session, 0)):
            raise InputError("it was here before, came after a later one, or is older than this program")
        self._counters[session] = counter
        for silent in [session for session, last in self._counters.items() if now - last > WINDOW]:
            self._floor = max(self._floor, self._counters.pop(silent))  # still too old if this clock goes back
        return text
