"""Listens to everything that leaves the machine by the network interface of the first argument, for the seconds of the second. Status 1 if a UDP
datagram leaves, 0 if none does; with a third argument `expected`, the other way round."""

import socket
import sys
import time

interface, seconds, expected = sys.argv[1], float(sys.argv[2]), "expected" in sys.argv[3:]
# Of all protocols: a socket of one protocol is not shown what leaves.
listener = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0003))
listener.bind((interface, 0))
listener.settimeout(0.2)
end, left = time.monotonic() + seconds, 0
while time.monotonic() < end:
    try:
        packet, address = listener.recvfrom(65536)
    except TimeoutError:
        continue
    # Outgoing, IPv4, UDP.
    left += address[2] == socket.PACKET_OUTGOING and address[1] == 0x0800 and packet[9] == 17
print(f"{left} datagrams left by {interface}")
sys.exit((left > 0) != expected)
