"""Settings that gRPC takes from the environment. To be imported before grpc; variables that are set stay as they are."""

from __future__ import annotations

import os
import sys

_FORK_SUPPORT = "GRPC_ENABLE_FORK_SUPPORT"
# gRPC reads this one when it is imported. Later it would have no effect.
if "grpc" not in sys.modules:
    os.environ.setdefault(_FORK_SUPPORT, "1")
SURVIVES_FORKS = os.environ.get(_FORK_SUPPORT, "").lower() in ("1", "true", "yes", "t", "y")

# Milliseconds after which gRPC looks what became of a try to connect that no call waits for; its own value is 5000.
os.environ.setdefault("GRPC_CLIENT_CHANNEL_BACKUP_POLL_INTERVAL_MS", "250")
