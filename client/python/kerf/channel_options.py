"""Options of channels to servers."""

# Never through a proxy of the environment: Kerf servers are near. The exact state of half a million vertices fits. A server
# that was started again is found soon.
CHANNEL_OPTIONS = [
    ("grpc.max_receive_message_length", 256 << 20),
    ("grpc.enable_http_proxy", 0),
    ("grpc.max_reconnect_backoff_ms", 2000),
]
